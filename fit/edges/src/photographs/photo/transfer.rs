//! Relation between stored values and light.

/// Relation between stored values and light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Transfer {
    /// Stored values are proportional to light.
    Linear,
    /// Stored values are sRGB-encoded (IEC 61966-2-1).
    Srgb,
}

impl Transfer {
    /// The names that a manifest may use, in the order of the variants.
    pub const NAMES: [&'static str; 2] = ["linear", "srgb"];

    /// Returns the transfer that has this name in a manifest, or `None`.
    pub fn from_name(name: &str) -> Option<Transfer> {
        match name {
            "linear" => Some(Transfer::Linear),
            "srgb" => Some(Transfer::Srgb),
            _ => None,
        }
    }

    /// Returns the light of a stored value, both in units of full scale. The sRGB curve is odd in
    /// the value, so noise around 0 stays centred.
    pub fn to_linear(self, stored: f32) -> f32 {
        match self {
            Transfer::Linear => stored,
            Transfer::Srgb => {
                let magnitude = stored.abs();
                let light = if magnitude <= 0.04045 {
                    magnitude / 12.92
                } else {
                    ((magnitude + 0.055) / 1.055).powf(2.4)
                };
                light.copysign(stored)
            }
        }
    }

    /// Returns the stored value of a light, the inverse of [`Transfer::to_linear`].
    pub fn to_stored(self, light: f32) -> f32 {
        match self {
            Transfer::Linear => light,
            Transfer::Srgb => {
                let magnitude = light.abs();
                let stored = if magnitude <= 0.003_130_8 {
                    magnitude * 12.92
                } else {
                    1.055 * magnitude.powf(1.0 / 2.4) - 0.055
                };
                stored.copysign(light)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_meets_the_standard_at_known_codes() {
        // IEC 61966-2-1: 8-bit code and the linear light it stands for, to 6 digits.
        let known = [
            (0, 0.0),
            (10, 0.003_035_3),
            (11, 0.003_346_5),
            (128, 0.215_861),
            (188, 0.502_886),
            (255, 1.0),
        ];
        let mut cases = 0;
        for (code, light) in known {
            let found = Transfer::Srgb.to_linear(code as f32 / 255.0);
            assert!(
                (found - light).abs() <= 1e-6,
                "code {code}: {found} instead of {light}"
            );
            assert_eq!(Transfer::Srgb.to_linear(-(code as f32) / 255.0), -found);
            let code = code as f32 / 255.0;
            assert!((Transfer::Srgb.to_stored(found) - code).abs() < 1e-6);
            cases += 1;
        }
        assert_eq!(cases, 6);
    }

    #[test]
    fn names_round_trip() {
        for name in Transfer::NAMES {
            assert!(Transfer::from_name(name).is_some(), "{name}");
        }
    }
}
