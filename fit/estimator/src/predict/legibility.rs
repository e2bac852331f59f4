//! What can be read of a mid-air image: luminance, contrast in ambient light, and the smallest
//! letter.
//!
//! **Letter.** The strokes of a capital letter and the gaps between them are a fifth of its height
//! h, so that its pattern has f = 2.5 / h. It is readable if this pattern keeps a contrast
//! C MTF(f) of 0.1 along and across the plane of incidence: at a tenth of the full contrast people
//! read letters of 0.25 to 2 degrees with at least half of their speed (G. E. Legge, G. S. Rubin
//! and A. Luebker, Vision Research 27, 1165, 1987). And a letter is at least 5 minutes of arc high
//! for the viewer, the smallest one for a visual acuity of 1 (ISO 8596).
//!
//! **Contrast.** C is that of a wide pattern, (Lmax - Lmin) / (Lmax + Lmin). The dark of the image
//! has the luminance A of the ambient light behind it, and its white L + A: C = L / (L + 2 A).
//!
//! The criterion knows no crowding, no colours and no training. Letters three times as high are
//! read with ease.

use serde::Serialize;

use crate::error::Error;
use crate::predict::curve::{Curve, Derived};
use crate::predict::domain::Viewpoint;
use crate::predict::prediction::{AxisCurve, Incidence, half_difference};
use crate::predict::sheet::Fitted;
use crate::result::Number;

/// When a letter is readable.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Criterion {
    /// Periods of the pattern of strokes within the height of a capital letter.
    pub periods: f64,
    /// Least contrast of this pattern.
    pub contrast: f64,
    /// Least height for the eye, minutes of arc.
    pub arcminutes: f64,
}

impl Criterion {
    /// Criterion of this module, which the page of `fit explore` has too.
    pub const USUAL: Criterion = Criterion {
        periods: 2.5,
        contrast: 0.1,
        arcminutes: 5.0,
    };
}

/// Light and place in which a mid-air image is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Viewing {
    /// Luminance behind the image; source white is 1.
    pub ambient: f64,
    /// Distance from the viewer to the image, mm.
    pub viewer_mm: f64,
}

impl Viewing {
    /// Returns the height of the smallest letter for the eye, mm.
    pub fn eye_mm(&self) -> f64 {
        let angle_rad = (Criterion::USUAL.arcminutes / 60.0).to_radians();
        self.viewer_mm * angle_rad.tan()
    }
}

/// What limits the smallest readable letter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Limit {
    /// Blur of the image.
    Blur,
    /// Acuity of the eye.
    Eye,
    /// Contrast of the image, which is too low for letters of any size.
    Contrast,
}

/// Smallest readable capital letter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Letter {
    /// Height, mm; its value is `None` if no letter is readable.
    pub height_mm: Number,
    /// What limits it.
    pub limit: Limit,
}

/// What a viewer can read of a mid-air image at one place.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Legibility {
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Azimuth, degrees; null for a mean table.
    pub azimuth_deg: Option<f64>,
    /// Distance R: optical path from the sheet to the image, mm.
    pub floating_distance_mm: f64,
    /// Share eta of the arriving rays that the cell sends straight back, from the table.
    pub retroreflected: f64,
    /// True if the direction lies between the directions of the table.
    pub interpolated: bool,
    /// Luminance of white without ambient light, divided by that of the source; unknown without mu.
    pub luminance: Number,
    /// Contrast of a wide pattern in the ambient light; unknown without mu.
    pub contrast: Number,
    /// Frequency at which the lesser MTF of both axes falls to one half, 1/mm; unknown if it stays
    /// above, or if nothing returns.
    pub mtf50_per_mm: Number,
    /// Smallest letter without ambient light.
    pub letter_in_the_dark: Letter,
    /// Smallest letter in the ambient light; null without mu.
    pub letter: Option<Letter>,
}

/// Predicts what a viewer can read of a mid-air image at a place.
///
/// Standard errors follow from the covariance of the result, as for [`predict`](super::predict).
///
/// # Errors
/// Returns an error if the table lacks the direction, or if the result lacks a parameter of the
/// blur.
pub fn legibility(
    sheet: &Fitted<'_>,
    place: &Viewpoint,
    viewing: &Viewing,
) -> Result<Legibility, Error> {
    let at = Incidence::new(*sheet, place.incidence_deg, place.azimuth_deg)?;
    let lines = at.lines()?;
    let curves = lines.each_ref().map(|line| line.at(place.r_mm));
    let luminance = at.luminance();
    let twice = 2.0 * viewing.ambient;
    let contrast = match (luminance.value, luminance.standard_error) {
        (Some(light), error) if light > 0.0 => Number {
            value: Some(light / (light + twice)),
            standard_error: error.map(|error| error * twice / (light + twice).powi(2)),
        },
        (Some(_), _) => Number {
            value: Some(0.0),
            standard_error: None,
        },
        (None, _) => Number::UNKNOWN,
    };
    let letter = |ambient: f64| {
        letter(
            &at,
            &curves,
            Viewing {
                ambient,
                ..*viewing
            },
        )
    };
    let known = luminance.value.is_some() || viewing.ambient == 0.0;
    Ok(Legibility {
        incidence_deg: place.incidence_deg,
        azimuth_deg: place.azimuth_deg,
        floating_distance_mm: place.r_mm,
        retroreflected: at.direction.retroreflected,
        interpolated: at.direction.interpolated,
        luminance,
        contrast,
        mtf50_per_mm: half(&at, &curves),
        letter_in_the_dark: letter(0.0),
        letter: known.then(|| letter(viewing.ambient)),
    })
}

/// Returns the number of the axis whose MTF falls to `level` first, with the frequency; `None` if
/// none of them falls so far.
fn first_to_fall<'a>(
    curves: impl IntoIterator<Item = &'a Curve<'a>>,
    level: f64,
) -> Option<(usize, Derived)> {
    let all = curves.into_iter().enumerate();
    let found = all.filter_map(|(axis, curve)| Some((axis, curve.falls_to(level)?)));
    found.min_by(|a, b| a.1.value.total_cmp(&b.1.value))
}

/// Returns the frequency at which the lesser MTF falls to one half.
fn half(at: &Incidence<'_>, curves: &[AxisCurve<'_>; 2]) -> Number {
    let own = curves.iter().filter_map(|axis| axis.curve.as_ref());
    let Some((axis, found)) = first_to_fall(own, 0.5) else {
        return Number::UNKNOWN;
    };
    let beside = curves[axis].by_azimuth(|side| Some(side.falls_to(0.5)?.value));
    Number {
        value: Some(found.value),
        standard_error: at.uncertainty.of_blur(&found, beside),
    }
}

/// Returns the smallest letter in some ambient light, where the luminance is known or the light is
/// none.
fn letter(at: &Incidence<'_>, curves: &[AxisCurve<'_>; 2], viewing: Viewing) -> Letter {
    let Criterion {
        periods, contrast, ..
    } = Criterion::USUAL;
    // MTF at which the contrast of strokes is the least that can be read.
    let level = |luminance: Option<f64>| match luminance {
        Some(light) if viewing.ambient > 0.0 => contrast * (1.0 + 2.0 * viewing.ambient / light),
        _ => contrast,
    };
    let light = at.luminance().value;
    let level_here = level(light);
    let own = || curves.iter().filter_map(|axis| axis.curve.as_ref());
    if own().next().is_none() || level_here.is_nan() || level_here >= 1.0 {
        return Letter {
            height_mm: Number::UNKNOWN,
            limit: Limit::Contrast,
        };
    }
    let eye_mm = viewing.eye_mm();
    let found = first_to_fall(own(), level_here);
    let Some((axis, found)) = found.filter(|(_, found)| periods / found.value > eye_mm) else {
        return Letter {
            height_mm: Number {
                value: Some(eye_mm),
                standard_error: None,
            },
            limit: Limit::Eye,
        };
    };
    let height_mm = periods / found.value;
    // By mu the level changes, and with it the frequency.
    let by_mu = match light {
        Some(light) if viewing.ambient > 0.0 => {
            let by_light = -contrast * 2.0 * viewing.ambient / light.powi(2);
            let slope = own()
                .nth(axis)
                .map_or(f64::NAN, |own| own.slope(found.value));
            by_light * at.light_by_mu() / slope
        }
        _ => 0.0,
    };
    let sides: Option<Vec<f64>> = (curves[axis].sides.iter().zip(&at.sides))
        .map(|(curve, side)| {
            let light = (at.sheet).luminance(at.incidence_deg, side.retroreflected);
            Some(curve.falls_to(level(light))?.value)
        })
        .collect();
    let by_azimuth = half_difference(sides.as_deref().unwrap_or_default());
    let error = (at.uncertainty).standard_error(found.by_blur, by_mu);
    Letter {
        height_mm: Number {
            value: Some(height_mm),
            standard_error: error.map(|error| error.hypot(by_azimuth) * height_mm / found.value),
        },
        limit: Limit::Blur,
    }
}
