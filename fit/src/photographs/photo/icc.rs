//! Tone curves of ICC profiles (ICC.1:2010): grey profiles, and RGB profiles of matrix and curves.
//!
//! Only the curves are used. The matrix says which red, green and blue are meant; luminance has the
//! weights of Rec. 709 whatever they are. A profile of look-up tables alone has no curves and is
//! refused.

use moxcms::{ColorProfile, DataColorSpace, LocalizableString, ProfileText, ToneReprCurve};

use crate::photographs::photo::curve::Curve;
use crate::photographs::photo::taken::Curves;
use crate::photographs::photo::transfer::Transfer;

/// Reason why a damaged profile cannot be followed.
pub(crate) const DAMAGED: &str = "it is damaged";

/// Returns the curves of a profile. `part` is the name of the profile's place in the file, and
/// `colour` says whether the picture has colours.
///
/// # Errors
/// Returns the reason, in words, if the profile is damaged, has no curves, is not for such a
/// picture, or has a curve that falls.
pub(crate) fn curves(bytes: &[u8], part: &str, colour: bool) -> Result<Curves, String> {
    let profile = ColorProfile::new_from_slice(bytes).map_err(|_| DAMAGED.to_owned())?;
    let tables = profile.lut_a_to_b_perceptual.is_some()
        || profile.lut_a_to_b_colorimetric.is_some()
        || profile.lut_a_to_b_saturation.is_some();
    let stored: Vec<&ToneReprCurve> = match profile.color_space {
        DataColorSpace::Rgb => [&profile.red_trc, &profile.green_trc, &profile.blue_trc]
            .into_iter()
            .flatten()
            .collect(),
        DataColorSpace::Gray if !colour => profile.gray_trc.iter().collect(),
        DataColorSpace::Gray => return Err("it is for grey, the picture has colours".into()),
        _ => return Err("it is neither for RGB nor for grey".into()),
    };
    let wanted = match profile.color_space {
        DataColorSpace::Rgb => 3,
        _ => 1,
    };
    if stored.len() != wanted {
        return Err(if tables {
            "it holds look-up tables in place of tone curves".into()
        } else {
            "it holds no tone curves".into()
        });
    }
    let mut each = stored
        .into_iter()
        .map(curve)
        .collect::<Result<Vec<_>, _>>()?;
    if each.iter().all(|curve| *curve == each[0]) {
        each.truncate(1);
    } else if !colour {
        return Err("its three tone curves differ, but the picture is grey".into());
    }
    let from = match description(&profile) {
        Some(name) => format!("{part} \"{name}\""),
        None => part.to_owned(),
    };
    Ok(Curves {
        each,
        from,
        doubt: None,
    })
}

/// Converts a curve of the profile. Samples are scaled to 1 at full scale.
fn curve(stored: &ToneReprCurve) -> Result<Curve, String> {
    let curve = match stored {
        ToneReprCurve::Lut(codes) => match codes[..] {
            [] => Curve::Named(Transfer::Linear),
            // A fixed-point number of 8 whole and 8 fractional bits.
            [gamma] => Curve::Power(f64::from(gamma) / 256.0),
            _ => {
                let full = f64::from(codes[codes.len() - 1]);
                Curve::Sampled(codes.iter().map(|&code| f64::from(code) / full).collect())
            }
        },
        ToneReprCurve::Parametric(numbers) => {
            let numbers: Vec<f64> = numbers.iter().map(|&number| f64::from(number)).collect();
            Curve::Parametric(match numbers[..] {
                [g] => [g, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                [g, a, b] => [g, a, b, 0.0, -b / a, 0.0, 0.0],
                [g, a, b, c] => [g, a, b, 0.0, -b / a, c, c],
                [g, a, b, c, d] => [g, a, b, c, d, 0.0, 0.0],
                [g, a, b, c, d, e, f] => [g, a, b, c, d, e, f],
                _ => return Err(DAMAGED.into()),
            })
        }
    };
    if !curve.rises() {
        return Err("its tone curve does not rise from dark to 1".into());
    }
    Ok(curve)
}

/// Returns the description of the profile in one line, without quotation marks.
fn description(profile: &ColorProfile) -> Option<String> {
    let text = match profile.description.as_ref()? {
        ProfileText::PlainString(text) => text.clone(),
        ProfileText::Localizable(texts) => {
            let english = |text: &&LocalizableString| text.language == "en";
            let chosen = texts.iter().find(english).or(texts.first())?;
            chosen.value.clone()
        }
        ProfileText::Description(text) => text.ascii_string.clone(),
    };
    let kept = |c: char| !c.is_control() && c != '"';
    let text: String = text.chars().filter(|&c| kept(c)).take(60).collect();
    let text = text.trim().to_owned();
    (!text.is_empty()).then_some(text)
}
