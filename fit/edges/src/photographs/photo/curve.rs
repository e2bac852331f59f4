//! Tone curves: the light of a stored value, both in units of full scale; and those of ICC profiles
//! (ICC.1:2010): grey profiles, and RGB profiles of matrix and curves.
//!
//! Only the tone curves of a profile are used. The matrix defines the primaries, but luminance has
//! the weights of Rec. 709 whatever they are. A profile of look-up tables alone has no curves and is
//! refused.

use moxcms::{ColorProfile, DataColorSpace, LocalizableString, ProfileText, ToneReprCurve};

use crate::photographs::photo::{Curves, Transfer};

/// A tone curve.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Curve {
    /// A curve that a manifest can name.
    Named(Transfer),
    /// The inverse of the camera's curve of ITU-R BT.709-6, item 1.2.
    Bt709,
    /// A power of the stored value, with this exponent, > 0.
    Power(f64),
    /// `(a x + b)^g + e` from x = `d` on, `c x + f` below, in the order g, a, b, c, d, e, f
    /// (ICC.1:2010, 10.16, type 4; the other types are special cases).
    Parametric([f64; 7]),
    /// Light at evenly spaced stored values from 0 to 1, at least two. Between them the curve is
    /// straight.
    Sampled(Vec<f64>),
}

/// Largest difference in light at which a profile's curve has the name of a known curve. Samples of
/// the sRGB curve in a table of 1,024 places differ by 8e-6 from it.
const ALIKE: f64 = 1e-4;

/// Number of places at which curves are compared and checked.
const PLACES: u16 = 4096;

impl Curve {
    /// Returns the light of a stored value. Below 0 the curve is continued oddly about its value at
    /// 0, so noise around it stays centred.
    pub(crate) fn light(&self, stored: f32) -> f32 {
        if let Curve::Named(transfer) = self {
            return transfer.to_linear(stored);
        }
        let magnitude = self.rising(f64::from(stored.abs()));
        if stored < 0.0 {
            (2.0 * self.rising(0.0) - magnitude) as f32
        } else {
            magnitude as f32
        }
    }

    /// Returns the light of a stored value that is not negative.
    fn rising(&self, x: f64) -> f64 {
        match self {
            Curve::Named(transfer) => f64::from(transfer.to_linear(x as f32)),
            Curve::Bt709 if x < 0.081 => x / 4.5,
            Curve::Bt709 => ((x + 0.099) / 1.099).powf(1.0 / 0.45),
            Curve::Power(exponent) => x.powf(*exponent),
            Curve::Parametric([g, a, b, c, d, e, f]) => {
                if x < *d {
                    c * x + f
                } else {
                    (a * x + b).max(0.0).powf(*g) + e
                }
            }
            Curve::Sampled(light) => {
                let last = light.len() - 1;
                let place = x * last as f64;
                // Above full scale the last piece goes on.
                let piece = (place as usize).min(last - 1);
                let part = place - piece as f64;
                light[piece] + part * (light[piece + 1] - light[piece])
            }
        }
    }

    /// Returns whether the curve never falls between 0 and 1, and reaches 1 to 1 % at 1.
    pub(crate) fn rises(&self) -> bool {
        let light: Vec<f64> = places().map(|x| self.rising(x)).collect();
        let last = light[light.len() - 1];
        // A comparison with NaN is false.
        light.windows(2).all(|pair| pair[1] >= pair[0] - 1e-6)
            && light[0] < 0.5
            && (last - 1.0).abs() < 0.01
    }

    /// Returns the name of the curve for messages and results.
    pub(crate) fn name(&self) -> String {
        let alike =
            |other: &Curve| places().all(|x| (self.rising(x) - other.rising(x)).abs() <= ALIKE);
        match self {
            Curve::Bt709 => "BT.709".into(),
            _ if alike(&Curve::Named(Transfer::Linear)) => "linear".into(),
            _ if alike(&Curve::Named(Transfer::Srgb)) => "sRGB".into(),
            _ if alike(&Curve::Bt709) => "BT.709".into(),
            Curve::Power(exponent) => power(*exponent),
            Curve::Parametric([g, a, b, _, d, e, _])
                if *a == 1.0 && *b == 0.0 && *d <= 0.0 && *e == 0.0 =>
            {
                power(*g)
            }
            Curve::Named(_) | Curve::Parametric(_) | Curve::Sampled(_) => "tone curve".into(),
        }
    }

    /// Returns whether the curve has the name "linear".
    pub(crate) fn is_linear(&self) -> bool {
        self.name() == "linear"
    }
}

fn places() -> impl Iterator<Item = f64> {
    (0..=PLACES).map(|i| f64::from(i) / f64::from(PLACES))
}

/// Returns the name of a power, such as "gamma 2.2".
fn power(exponent: f64) -> String {
    format!("gamma {}", (1000.0 * exponent).round() / 1000.0)
}

/// Reason why a damaged profile cannot be followed.
pub(crate) const DAMAGED: &str = "it is damaged";

/// Name of the profile of a JPEG or TIFF.
pub(crate) const PROFILE: &str = "ICC profile";

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
        .map(of_profile)
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
fn of_profile(stored: &ToneReprCurve) -> Result<Curve, String> {
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
