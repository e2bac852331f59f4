//! Detection of pixels that do not follow the edge: hot and dead pixels, dust, other marks.

use crate::photographs::edge::line::EdgeLine;
use crate::photographs::profile::{BIN_PX, Profile, bin_at};
use crate::photographs::window::Window;

/// Distance from the profile of the edge from which a pixel is off, in standard deviations of a
/// pixel. Gaussian noise reaches it once in 10^15 pixels, shot noise of few electrons once in 10^6.
const DEVIATIONS: f64 = 8.0;

/// Least distance from the profile at which a pixel can be off, in steps of the edge. The straight
/// lines between the bins may miss the sharpest profile by as much. Pixels nearer than this do not
/// matter: 1 of them in 10^4 moves the profile by 5e-6.
const LEAST_STEPS: f64 = 0.05;

/// Excludes pixels far outside the range of the others from the window, and returns their number.
/// An EXR's hot pixels can be thousands of times as bright as the picture, which would spoil the
/// search for the edge.
pub(crate) fn exclude_gross(window: &mut Window) -> usize {
    let (low, high) = window.bulk();
    let span = high - low;
    if span <= 0.0 {
        return 0;
    }
    window.keep(|pixel| (low - 2.0 * span..=high + 2.0 * span).contains(&pixel.value))
}

/// Excludes pixels that are off the profile from the window, and returns their number. A pixel is
/// off if neither noise, nor its place in a bin, nor an edge that is astray by `astray_px` pixels
/// (waves, shifted rows) explains its distance. Corners of the window that lie beyond the profile are compared with its ends.
///
/// The distance is that from the medians of the bins, which a few wild pixels do not move. The
/// medians are only computed if the means of the bins raise a doubt.
pub(crate) fn exclude(
    window: &mut Window,
    line: &EdgeLine,
    profile: &Profile,
    astray_px: f64,
) -> usize {
    let (dark, bright) = profile.plateaus();
    let least = LEAST_STEPS * (bright - dark);
    let limits: Vec<f64> = (0..profile.len())
        .map(|j| {
            let noise = profile.deviation(j, window.excess());
            // At an angle of a simple fraction the pixels of a bin may all lie at one of its ends.
            let most_px = 1.5 * astray_px + 0.5 * BIN_PX;
            least + DEVIATIONS * noise + most_px * profile.slope(j, 2).abs()
        })
        .collect();
    let end = profile.reach as f64 * BIN_PX;
    // Just within the last bin, where the profile has a value.
    let held = |s: f64| s.clamp(-end, end - 1e-6);
    let bin = |s: f64| (bin_at(held(s)) + profile.reach as f64) as usize;
    let off = |curve: &Profile, s: f64, value: f64, share: f64| {
        curve
            .at(held(s))
            .is_some_and(|expected| (value - expected).abs() > share * limits[bin(s)])
    };
    // Wild pixels draw the mean of their bin towards them: up to three of them by this share.
    let share = |s: f64| (1.0 - 4.0 / profile.count[bin(s)]).max(0.5);
    let ruler = line.ruler();
    let doubtful = window.pixels().any(|p| {
        let (s, _) = ruler.place(p.x, p.y);
        off(profile, s, p.value, share(s))
    });
    if !doubtful {
        return 0;
    }
    let mut values = vec![Vec::new(); profile.len()];
    for p in window.pixels() {
        let (s, _) = ruler.place(p.x, p.y);
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
    window.keep(|p| !off(&medians, ruler.place(p.x, p.y).0, p.value, 1.0))
}
