//! Checks that the edge of a window is one straight edge, and sharp enough for the window.

use crate::photographs::edge::accepted::Accepted;
use crate::photographs::edge::fault::Fault;
use crate::photographs::edge::line::EdgeLine;
use crate::photographs::profile::{BIN_PX, Profile, smoothed};
use crate::photographs::window::Window;

/// Steepness of a second edge, relative to the first, from which the edge counts as doubled. The
/// line spread function of an ideal lens has side lobes below 0.05; that of a box and that of a
/// sinc^2 have none.
const DOUBLED: f64 = 0.1;

/// Slope in the valley between two edges, relative to the second edge, below which there are two
/// edges.
const VALLEY: f64 = 0.7;

/// Largest share of the profile's length that the rise from 10 to 90 % may take. A ramp across the
/// whole window takes 0.8.
const LONGEST_RISE: f64 = 0.55;

/// Height of an arc (pixels) that causes a warning, and height that causes a refusal. An arc of 0.1
/// px, spread over the pixels, lowers the MTF at half the sampling frequency by 0.4 %; one of 1 px
/// lowers it by a third.
const BOW: [f64; 2] = [0.1, 1.0];

/// Refuses doubled, bowed and wide edges, and returns warnings about accepted faults and small
/// arcs.
pub(crate) fn check(
    window: &Window,
    line: &EdgeLine,
    profile: &Profile,
    accepted: &[Accepted],
) -> Result<Vec<String>, Fault> {
    let mut warnings = Vec::new();
    let smooth = smoothed(&profile.mean, 2);
    let (dark, bright) = profile.plateaus();
    let step = bright - dark;
    let last_below = |level: f64| smooth.iter().rposition(|&v| v <= dark + level * step);
    let first_above = |level: f64| smooth.iter().position(|&v| v >= dark + level * step);
    // The inner of the two crossings counts, so that noise on a plateau does not lengthen the rise.
    if let (Some(start), Some(end)) = (last_below(0.1), first_above(0.9)) {
        let rise_px = end.saturating_sub(start) as f64 * BIN_PX;
        let length_px = profile.len() as f64 * BIN_PX;
        if rise_px > LONGEST_RISE * length_px {
            return Err(Fault::Blurred { rise_px, length_px });
        }
    }
    if let Some((share, distance_px)) = double(profile) {
        if !accepted.contains(&Accepted::Doubled) {
            return Err(Fault::Doubled { share, distance_px });
        }
        warnings.push(format!(
            "the edge is doubled (a second edge, {:.0} % as steep, lies {distance_px:.1} pixels \
            away) and was accepted: the second edge counts as blur of the sheet",
            100.0 * share
        ));
    }
    let arc_px = arc(window, line, profile)?;
    if arc_px > BOW[0] {
        warnings.push(format!(
            "the edge is bowed by {arc_px:.2} pixels, which lowers the MTF; give a shorter roi, \
            or correct the lens distortion"
        ));
    }
    Ok(warnings)
}

/// Returns the height of the edge's arc (pixels), or 0 if noise explains it.
///
/// # Errors
/// Returns [`Fault::Bowed`] if the arc is higher than 1 pixel and noise does not explain it.
pub(crate) fn arc(window: &Window, line: &EdgeLine, profile: &Profile) -> Result<f64, Fault> {
    let (sagitta_px, error) = bow(window, line, profile);
    let sagitta_px = sagitta_px.abs();
    if sagitta_px <= 5.0 * error {
        return Ok(0.0);
    }
    if sagitta_px > BOW[1] {
        return Err(Fault::Bowed { sagitta_px });
    }
    Ok(sagitta_px)
}

/// Returns the steepness of a second edge, relative to the first, and its distance from the first
/// (pixels). A ripple of the blur itself, as waves make it, is alike on both sides of the edge and
/// does not count.
fn double(profile: &Profile) -> Option<(f64, f64)> {
    const HALF: usize = 4;
    let slopes: Vec<f64> = (0..profile.len()).map(|j| profile.slope(j, HALF)).collect();
    let first = (0..slopes.len()).max_by(|&a, &b| slopes[a].total_cmp(&slopes[b]))?;
    let most = profile.variance.iter().copied().fold(0.0, f64::max);
    let noise = (2.0 * most).sqrt() / (2.0 * HALF as f64 * BIN_PX);
    let sides = [-1_isize, 1].map(|outward| {
        let mut found: Option<(f64, f64)> = None;
        // The search goes outward from the first edge. It keeps the lowest slope so far and looks
        // for a slope that rises from it.
        let mut valley = slopes[first];
        let mut at = first as isize + outward;
        while let Some(&slope) = usize::try_from(at).ok().and_then(|j| slopes.get(j)) {
            valley = valley.min(slope);
            // Half the steepness of a second edge is enough here, for the comparison of the two
            // sides.
            let enough = slope > 0.5 * DOUBLED * slopes[first]
                && slope > 8.0 * noise + valley.max(0.0)
                && valley < VALLEY * slope;
            if enough && found.is_none_or(|(share, _)| slope > share * slopes[first]) {
                let distance_px = (at - first as isize).unsigned_abs() as f64 * BIN_PX;
                found = Some((slope / slopes[first], distance_px));
            }
            at += outward;
        }
        found
    });
    let alike = |a: f64, b: f64| a.min(b) > 0.5 * a.max(b);
    if let [Some(left), Some(right)] = sides
        && alike(left.0, right.0)
        && alike(left.1, right.1)
    {
        return None;
    }
    let steepest = sides
        .into_iter()
        .flatten()
        .max_by(|a, b| a.0.total_cmp(&b.0));
    steepest.filter(|&(share, _)| share > DOUBLED)
}

/// Returns the height of the edge's arc over the chord of the window and its standard error,
/// pixels. The distances of the pixels from the profile are regressed on its slope times the square
/// of the place along the edge.
fn bow(window: &Window, line: &EdgeLine, profile: &Profile) -> (f64, f64) {
    let slopes: Vec<f64> = (0..profile.len()).map(|j| profile.slope(j, 4)).collect();
    let mut sums = [0.0; 6];
    let mut farthest = 0.0_f64;
    for pixel in window.pixels() {
        let (s, t) = line.place(&pixel);
        let Some(expected) = profile.at(s) else {
            continue;
        };
        let j = (s / BIN_PX).round() + profile.reach as f64;
        let slope = slopes[j as usize];
        let (w, r, tt) = (slope * slope, pixel.value - expected, t * t);
        let terms = [w, w * tt, w * tt * tt, slope * r, slope * r * tt, r * r * w];
        sums.iter_mut().zip(terms).for_each(|(sum, x)| *sum += x);
        farthest = farthest.max(tt);
    }
    let [w, wt, wtt, r, rt, scatter] = sums;
    let spread = wtt - wt * wt / w;
    if spread.is_nan() || spread <= 0.0 {
        return (0.0, f64::INFINITY);
    }
    let curvature = (rt - r * wt / w) / spread;
    // The scatter is weighted with the slope, so it is that of the pixels on the edge.
    let error = (scatter / w / spread).sqrt();
    let height = wt / w * 3.0;
    let height = height.min(farthest);
    (curvature * height, error * height)
}
