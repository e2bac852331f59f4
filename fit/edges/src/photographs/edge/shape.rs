//! Checks that the edge of a window is one smooth edge, and sharp enough for the window.

use crate::photographs::edge::curve;
use crate::photographs::edge::curve::Waves;
use crate::photographs::edge::fault::Accepted;
use crate::photographs::edge::fault::Fault;
use crate::photographs::edge::lattice;
use crate::photographs::edge::lattice::Lattice;
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

/// Share by which waves of the edge lower the MTF where it is one half: the one that causes a
/// warning, and the one that causes a refusal.
const WAVY: [f64; 2] = [0.005, 0.1];

/// Refuses doubled, wavy and wide edges, and returns warnings about accepted faults and small
/// waves. `waves` are those of the profile's edge.
pub(crate) fn check(
    profile: &Profile,
    waves: Waves,
    accepted: &[Accepted],
) -> Result<Vec<String>, Fault> {
    let mut warnings = Vec::new();
    if let Some(rise_px) = rise_px(profile) {
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
    if waves.loss > WAVY[1] {
        return Err(Fault::Wavy {
            rms_px: waves.rms_px,
            loss: waves.loss,
        });
    }
    if waves.loss > WAVY[0] {
        warnings.push(format!(
            "the edge is wavy: {:.2} pixels (root mean square) are left about a smooth curve, \
            which lowers the MTF by {:.1} % where it is one half",
            waves.rms_px,
            100.0 * waves.loss
        ));
    }
    Ok(warnings)
}

/// Measures the waves of an edge about its curve.
pub(crate) fn waves(window: &Window, line: &EdgeLine, profile: &Profile) -> Waves {
    curve::waves(window, line, profile, rise_px(profile).unwrap_or(0.0))
}

/// Measures the patterns of the pixel grid.
pub(crate) fn lattice(window: &Window, line: &EdgeLine, profile: &Profile) -> Lattice {
    lattice::find(window, line, profile, rise_px(profile).unwrap_or(0.0))
}

/// Returns the distance over which the profile rises from 10 to 90 % of its step, pixels. The inner
/// of several crossings count, so that noise on a plateau does not lengthen the rise.
pub(crate) fn rise_px(profile: &Profile) -> Option<f64> {
    let smooth = smoothed(&profile.mean, 2);
    let (dark, bright) = profile.plateaus();
    let step = bright - dark;
    let start = smooth.iter().rposition(|&v| v <= dark + 0.1 * step)?;
    let end = smooth.iter().position(|&v| v >= dark + 0.9 * step)?;
    Some(end.saturating_sub(start) as f64 * BIN_PX)
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
