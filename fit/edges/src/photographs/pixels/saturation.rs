//! Detection of clipped highlights, cut-off darks and black regions: many pixels at exactly the
//! same extreme value.
//!
//! A clipped pixel gives less information than it seems to. If it were left out, only the dark half
//! of the noise would remain. So clipping causes a warning where it is harmless and a refusal where
//! it is not. The likelihood of the pixels knows of both limits, as long as a pixel's light is one
//! value of the file.
//!
//! If a share p of a plateau's pixels is clipped, the mean falls by (density - p z) standard
//! deviations of a pixel, where z is the normal quantile of p and density is the normal density
//! there. For p = 0.05 this is 0.02, which is 0.02 % of the step at 1 % noise. For p = 0.5 it is
//! 0.4.

use crate::photographs::edge::fault::Fault;
use crate::photographs::photo::plane::Photo;
use crate::photographs::window::Window;

/// Share of clipped pixels among the bright ones above which the photograph is refused, if its
/// light is that of several channels or if the ceiling is not that of the format.
const MOST_CLIPPED: f64 = 0.05;

/// Share of bright pixels at full scale above which a photograph of one channel is refused. Noise
/// about full scale is cut off in half of the pixels, which the loss `edge` takes into account.
const MOST_FULL: f64 = 2.0 / 3.0;

/// Share of pixels that are exactly 0 among the dark ones above which the photograph is refused.
/// Noise about a dark of 0 is cut off in half of the pixels.
const MOST_ZERO: f64 = 2.0 / 3.0;

/// Light below which the brightest pixels of a black region lie, in units of full scale. It is the
/// sixth step of 8 bits in sRGB.
const DARKEST: f64 = 0.002;

/// Approximate number of pixels that are looked at, evenly spaced.
const SAMPLE: usize = 65_536;

/// Refuses a window that is black or all alike, or whose plateaus are clipped, and returns warnings
/// about lesser clipping.
pub(crate) fn check(photo: &Photo, window: &Window) -> Result<Vec<String>, Fault> {
    let (low, high) = window.bulk();
    let middle = (0.5 * (low + high)) as f32;
    let values = window.sample(SAMPLE);
    let integers = photo.clip_level == Some(1.0);
    let zeros = values.iter().filter(|&&v| v == 0.0).count() as f64 / values.len().max(1) as f64;
    let dark_codes = integers && low >= 0.0 && high < DARKEST && zeros > MOST_ZERO;
    if !values.is_empty() && (low == 0.0 && high == 0.0 || dark_codes) {
        return Err(Fault::Black(zeros));
    }
    let (mut dark, mut bright): (Vec<f32>, Vec<f32>) =
        values.into_iter().partition(|&v| v < middle);
    dark.sort_unstable_by(f32::total_cmp);
    bright.sort_unstable_by(f32::total_cmp);
    let share = |side: &[f32], holds: &dyn Fn(f32) -> bool| {
        side.iter().filter(|&&v| holds(v)).count() as f64 / side.len().max(1) as f64
    };
    if let Some(level) = photo.clip_level {
        let clipped = share(&bright, &|v| v >= level);
        let most = if photo.clips_alone {
            MOST_FULL
        } else {
            MOST_CLIPPED
        };
        if clipped > most {
            return Err(Fault::Clipped {
                share: clipped,
                level: f64::from(level),
            });
        }
    }
    if low == high {
        return Err(Fault::NoContrast {
            contrast: 0.0,
            noise: 0.0,
        });
    }
    let (darks, brights) = (common(&dark), common(&bright));
    // The camera's own ceiling, below that of the format. It shows as many pixels of one value with
    // nothing above it and no neighbouring value of similar size, if the dark side shows noise.
    let ceiling = brights[0].value;
    let above = share(&bright, &|v| v > ceiling);
    let of_the_format = photo.clips_alone && photo.clip_level == Some(ceiling);
    if !of_the_format
        && brights[0].share > MOST_CLIPPED
        && above < 0.1 * brights[0].share
        && brights[1].share < 0.125 * brights[0].share
        && darks[0].share < 0.1
    {
        return Err(Fault::Clipped {
            share: brights[0].share,
            level: f64::from(ceiling),
        });
    }
    let zero = share(&dark, &|v| v == 0.0);
    if zero > MOST_ZERO && low >= 0.0 && high > 0.0 && (integers || brights[0].share < 0.5) {
        return Err(Fault::CutOff(zero));
    }
    let clipping = photo
        .clip_level
        .and_then(|level| window.clipping_warning(level));
    Ok(clipping.into_iter().chain(window.floor_warning()).collect())
}

/// A value and the share of the pixels that have it.
#[derive(Clone, Copy, Default)]
struct Pile {
    value: f32,
    share: f64,
}

/// Returns the two most common values of a sorted list.
fn common(sorted: &[f32]) -> [Pile; 2] {
    let mut most = [Pile::default(); 2];
    for run in sorted.chunk_by(|a, b| a == b) {
        let pile = Pile {
            value: run[0],
            share: run.len() as f64 / sorted.len() as f64,
        };
        if pile.share > most[0].share {
            most = [pile, most[0]];
        } else if pile.share > most[1].share {
            most[1] = pile;
        }
    }
    most
}
