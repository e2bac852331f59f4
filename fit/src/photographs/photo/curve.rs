//! Tone curves: the light of a stored value, both in units of full scale.

use crate::photographs::photo::transfer::Transfer;

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
