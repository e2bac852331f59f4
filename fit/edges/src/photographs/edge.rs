//! Search for the slanted edge of a window: its direction, its place, the curve that it follows,
//! and whether there is only one.

pub(crate) mod curve;
pub mod fault;
pub(crate) mod lattice;
pub mod line;
pub(crate) mod shape;
pub mod slant;

use crate::numerics::factor;
use crate::numerics::factor::Products;
use crate::photographs::edge::curve::Steepness;
use crate::photographs::edge::fault::Fault;
use crate::photographs::edge::line::EdgeLine;
use crate::photographs::profile::{BIN_PX, Profile, smoothed};
use crate::photographs::window::Window;

/// Number of pixels above which a window is first searched in a copy of lower resolution, which has
/// at most a quarter of this number.
const LARGE: usize = 40_000;

/// Distance of the half level from the central bin below which a profile is centred, pixels. The
/// place is free in all later steps, and only the bins depend on it.
const CENTRED_PX: f64 = 1e-3;

/// The same while direction and curve still move.
const ROUGHLY_PX: f64 = 0.02;

/// Finds the edge of a window that holds one edge, as a straight line, and its profile.
///
/// The first direction is that of the first moment under a rotationally symmetric weight, which is
/// exact for any straight edge. Direction and place are then refined. For the first direction,
/// large windows are averaged down.
pub(crate) fn straight(window: &Window) -> Result<(EdgeLine, Profile), Fault> {
    let pixels = window.width() * window.height();
    let mut start = None;
    if pixels > LARGE {
        let side = (4.0 * pixels as f64 / LARGE as f64).sqrt().ceil() as usize;
        if side > window.width().min(window.height()) {
            return Err(Fault::TooSmall);
        }
        match straight(&window.reduced(side)) {
            Ok((small, _)) => {
                start = Some(EdgeLine {
                    offset_px: small.offset_px * side as f64,
                    ..small
                });
            }
            Err(Fault::TooSmall) => {}
            Err(fault) => return Err(fault),
        }
    }
    let mut line = match start {
        Some(line) => line,
        None => EdgeLine {
            normal_rad: first_direction(window)?,
            offset_px: 0.0,
            normal_standard_error_rad: 0.0,
            bend: None,
        },
    };
    let profile = straighten(window, &mut line)?;
    Ok((line, profile))
}

/// Refines the direction, the place and the curve of an edge until the pixels scatter least about
/// their common profile, and returns both. The light should be even, because a fall of light along
/// the edge looks like a bend.
///
/// The angle and the curve are refined by Gauss-Newton steps; the place is the half level of the
/// profile. The accuracy is limited by noise, see `normal_standard_error_rad`; without noise the
/// error is below 2e-5 rad.
pub(crate) fn refine(window: &Window, mut line: EdgeLine) -> Result<(EdgeLine, Profile), Fault> {
    // A step of the curve turns the line too.
    let profile = match line.bend {
        None => straighten(window, &mut line)?,
        Some(_) => {
            let profile = profile_of(window, &line)?;
            centre(window, &mut line, profile, ROUGHLY_PX)?
        }
    };
    bend(window, line, profile)
}

/// Refines the curve of an edge, whose direction and place are refined already.
pub(crate) fn bend(
    window: &Window,
    mut line: EdgeLine,
    mut profile: Profile,
) -> Result<(EdgeLine, Profile), Fault> {
    for _ in 0..12 {
        let Some(farthest) = curve::step(window, &mut line, &profile) else {
            break;
        };
        profile = profile_of(window, &line)?;
        profile = centre(window, &mut line, profile, ROUGHLY_PX)?;
        if farthest < 1e-3 {
            break;
        }
    }
    profile = centre(window, &mut line, profile, CENTRED_PX)?;
    if line.bend.is_some()
        && let Some([_, error]) = direction(window, &line, &profile)
    {
        line.normal_standard_error_rad = error;
    }
    Ok((line, profile))
}

/// Finds the edge of a window in even light, with its curve.
pub fn locate(window: &Window) -> Result<EdgeLine, Fault> {
    let (line, profile) = straight(window)?;
    Ok(bend(window, line, profile)?.0)
}

/// Refines direction and place of an edge, and keeps its curve. Returns its profile.
fn straighten(window: &Window, line: &mut EdgeLine) -> Result<Profile, Fault> {
    let mut profile = profile_of(window, line)?;
    profile = centre(window, line, profile, ROUGHLY_PX)?;
    // A shift of 1e-4 px at the end of the edge does not change the MTF.
    let least = 2e-4 / (window.width() as f64).hypot(window.height() as f64);
    for _ in 0..12 {
        let step = turn(window, line, &profile);
        profile = profile_of(window, line)?;
        profile = centre(window, line, profile, ROUGHLY_PX)?;
        if step.abs() < least.max(0.01 * line.normal_standard_error_rad) {
            break;
        }
    }
    centre(window, line, profile, CENTRED_PX)
}

fn first_direction(window: &Window) -> Result<f64, Fault> {
    let radius2 = 0.25 * (window.width().min(window.height()) as f64).powi(2);
    let (mut mean, mut weights) = (0.0, 0.0);
    let weight = |x: f64, y: f64| (1.0 - (x * x + y * y) / radius2).max(0.0).powi(2);
    for p in window.pixels() {
        let w = weight(p.x, p.y);
        mean += w * p.value;
        weights += w;
    }
    mean /= weights;
    let (mut gx, mut gy) = (0.0, 0.0);
    for p in window.pixels() {
        let w = weight(p.x, p.y) * (p.value - mean);
        gx += w * p.x;
        gy += w * p.y;
    }
    if gx == 0.0 && gy == 0.0 {
        return Err(Fault::NoContrast {
            contrast: 0.0,
            noise: 0.0,
        });
    }
    Ok(gy.atan2(gx))
}

/// Moves the line to the half level of its profile, unless it lies within `limit_px` of it, and
/// returns the profile about the new place.
fn centre(
    window: &Window,
    line: &mut EdgeLine,
    mut profile: Profile,
    limit_px: f64,
) -> Result<Profile, Fault> {
    // If the line is far off the edge, the profile about it is short. Each round centres it again,
    // and the second round is nearly exact.
    for _ in 0..4 {
        let shift = half_level(&profile)?;
        if shift.abs() < limit_px {
            break;
        }
        line.offset_px += shift;
        profile = profile_of(window, line)?;
        if shift.abs() < ROUGHLY_PX {
            break;
        }
    }
    Ok(profile)
}

fn profile_of(window: &Window, line: &EdgeLine) -> Result<Profile, Fault> {
    Profile::new(window, line).ok_or(Fault::TooSmall)
}

/// Returns the distance (pixels) from the central bin to the half level. Where the profile crosses
/// the half level several times, the steepest crossing counts.
fn half_level(profile: &Profile) -> Result<f64, Fault> {
    let smooth = smoothed(&profile.mean, 6);
    let n = smooth.len();
    let ends = (n / 12).max(4);
    let level = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    let (dark, bright) = (level(&smooth[..ends]), level(&smooth[n - ends..]));
    let step = bright - dark;
    let noise = profile.noise[1];
    let (low, high) = smooth
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| {
            (l.min(v), h.max(v))
        });
    // A plateau is the mean of many pixels. A step of more than 5 of its standard errors is a step;
    // a smaller one is noise.
    let plateau: f64 = profile.variance[..ends]
        .iter()
        .chain(&profile.variance[n - ends..])
        .sum::<f64>()
        / (ends * ends) as f64;
    if step <= 5.0 * plateau.sqrt() || step <= 1e-6 * high.abs() {
        return Err(Fault::NoContrast {
            contrast: step,
            noise,
        });
    }
    let ripple = 8.0 * profile.variance.iter().copied().fold(0.0, f64::max).sqrt();
    if high - low > 1.35 * step + ripple {
        return Err(Fault::SeveralEdges((high - low) / step));
    }
    let half = 0.5 * (dark + bright);
    let crossing = (0..n - 1)
        .filter(|&j| smooth[j] <= half && smooth[j + 1] > half)
        .max_by(|&a, &b| profile.slope(a, 4).total_cmp(&profile.slope(b, 4)))
        .ok_or(Fault::NoContrast {
            contrast: step,
            noise,
        })?;
    let part = (half - smooth[crossing]) / (smooth[crossing + 1] - smooth[crossing]);
    Ok((crossing as f64 + part - profile.reach as f64) * BIN_PX)
}

/// Makes one Gauss-Newton step of the angle and returns it, radians.
fn turn(window: &Window, line: &mut EdgeLine, profile: &Profile) -> f64 {
    let Some([step, error]) = direction(window, line, profile) else {
        return 0.0;
    };
    let step = step.clamp(-0.1, 0.1);
    line.turn(step);
    line.normal_standard_error_rad = error;
    step
}

/// Returns the Gauss-Newton step of the angle and its standard error, radians. The distances of the
/// pixels from the common profile are regressed on its slope times the position along the edge. A
/// fall of light along the edge, which looks like a turn on the steep part, is known from the
/// plateaus.
fn direction(window: &Window, line: &EdgeLine, profile: &Profile) -> Option<[f64; 2]> {
    let (mut products, mut n) = (Products::new(4), 0.0_f64);
    Steepness::new(profile).all(window, line).for_each(|told| {
        let (t, slope) = (told.along_px, told.slope);
        products.add(&[slope, told.level * t, slope * t, told.off]);
        n += 1.0;
    });
    let factor = factor::of(products.sum());
    let spread = factor[(2, 2)];
    let error = factor[(3, 3)] * (window.excess() / n).sqrt() / spread;
    (spread > 0.0).then(|| [factor[(2, 3)] / spread, error])
}
