//! Pixels that do not follow the edge: hot and dead ones, dust, other marks.

use crate::photographs::edge::line::EdgeLine;
use crate::photographs::profile::{BIN_PX, Profile};
use crate::photographs::window::Window;

/// Distance from the edge's own profile, in standard deviations of a pixel, from which a pixel is
/// off: noise reaches it once in 10^15 pixels, shot noise of few electrons once in 10^6.
const DEVIATIONS: f64 = 8.0;

/// What the straight lines between bins may miss of the sharpest profile, and what is too little to
/// matter, in steps: pixels nearer than that, 1 in 10^4, move the profile by 5e-6.
const LEAST_STEPS: f64 = 0.05;

/// Takes out pixels farther from all others than these are from each other (an EXR's hot pixels can
/// be thousands of times the picture); they would spoil the search for the edge. Returns their
/// number.
pub(crate) fn exclude_gross(window: &mut Window) -> usize {
    let (low, high) = window.bulk();
    let span = high - low;
    if span <= 0.0 {
        return 0;
    }
    window.keep(|pixel| (low - 2.0 * span..=high + 2.0 * span).contains(&pixel.value))
}

/// Takes out pixels that are off the profile by more than an edge with an arc of `arc_px`, or their
/// place in a bin, explains. Returns their number.
///
/// The profile is that of the medians, which a few wild pixels do not move; it is only formed where
/// the means raise a doubt.
pub(crate) fn exclude(
    window: &mut Window,
    line: &EdgeLine,
    profile: &Profile,
    arc_px: f64,
) -> usize {
    let (dark, bright) = profile.plateaus();
    let least = LEAST_STEPS * (bright - dark);
    let limits: Vec<f64> = (0..profile.len())
        .map(|j| {
            let noise = (profile.variance[j] * profile.count[j].max(1.0)).sqrt();
            // At an angle of a simple fraction the pixels of a bin may all lie at one end of it.
            let astray_px = 1.5 * arc_px + 0.5 * BIN_PX;
            least + DEVIATIONS * noise + astray_px * profile.slope(j, 2).abs()
        })
        .collect();
    let bin = |s: f64| ((s / BIN_PX).round() + profile.reach as f64) as usize;
    let off = |curve: &Profile, s: f64, value: f64, share: f64| {
        curve
            .at(s)
            .is_some_and(|expected| (value - expected).abs() > share * limits[bin(s)])
    };
    // Wild pixels draw the mean of their bin towards them, up to three of them by this share.
    let share = |s: f64| (1.0 - 4.0 / profile.count[bin(s)]).max(0.5);
    let doubtful = window.pixels().any(|p| {
        let (s, _) = line.place(&p);
        profile.at(s).is_some() && off(profile, s, p.value, share(s))
    });
    if !doubtful {
        return 0;
    }
    let mut values = vec![Vec::new(); profile.len()];
    for p in window.pixels() {
        let (s, _) = line.place(&p);
        if profile.at(s).is_some() {
            values[bin(s)].push(p.value);
        }
    }
    let mut medians = profile.clone();
    for (median, values) in medians.mean.iter_mut().zip(&mut values) {
        if !values.is_empty() {
            let middle = values.len() / 2;
            *median = *values.select_nth_unstable_by(middle, f64::total_cmp).1;
        }
    }
    medians.bridge_means();
    window.keep(|p| !off(&medians, line.place(p).0, p.value, 1.0))
}
