//! Digits of coordinates: how far a file may have rounded a position.

use glam::DVec3;

/// Significant digits from which a number in a text is taken for a whole f64.
const WHOLE: i32 = 15;

/// Digits of the coordinates of a text.
///
/// Programs write a fixed number of decimals or a fixed number of significant digits. Trailing
/// zeros may be missing, so both numbers are the largest of the file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Digits {
    decimals: i32,
    significant: i32,
}

impl Digits {
    /// Adds a number of the text, such as `-0.0123` or `1.5e-3`.
    pub(crate) fn read(&mut self, word: &str) {
        let (mantissa, exponent) = word.split_once(['e', 'E']).unwrap_or((word, "0"));
        let decimals = mantissa.split_once('.').map_or(0, |(_, after)| after.len());
        let decimals = (decimals as i32).saturating_sub(exponent.parse().unwrap_or(0));
        let digits = mantissa.bytes().filter(u8::is_ascii_digit);
        let significant = digits.skip_while(|&digit| digit == b'0').count();
        self.decimals = self.decimals.max(decimals);
        self.significant = self.significant.max(significant as i32);
    }

    /// Returns the step in which the text gives `x`: the unit of its last digit.
    fn step(self, x: f64) -> f64 {
        let unit = |power: i32| 10_f64.powi(power);
        let first = x.abs().log10().floor();
        // The logarithm of 0 is not finite: a zero has its decimals alone.
        let relative = if first.is_finite() {
            unit(first as i32 + 1 - self.significant)
        } else {
            0.0
        };
        unit(-self.decimals).max(relative)
    }

    /// Returns the steps of `positions`; empty if the text has all digits of f64.
    pub(crate) fn steps(self, positions: &[DVec3]) -> Vec<DVec3> {
        if self.significant >= WHOLE {
            return Vec::new();
        }
        let all = positions.iter();
        all.map(|p| DVec3::from_array(p.to_array().map(|x| self.step(x))))
            .collect()
    }
}

/// Returns the steps of a position that went through f32.
pub(crate) fn single(position: DVec3) -> DVec3 {
    let step = |x: f64| {
        let x = (x as f32).abs();
        f64::from(x.next_up()) - f64::from(x)
    };
    DVec3::from_array(position.to_array().map(step))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps by the definition of three formats: `%.6f`, `%g` with six digits, and the shortest
    /// text; and of f32, where 1 is followed by 1 + 2^-23.
    #[test]
    fn steps_of_texts_and_of_singles() {
        let cases: [(&[&str], f64, f64); 6] = [
            (&["0.000074", "12.345678", "0.000000"], 12.3, 1e-6),
            (&["0.000074", "12.345678", "0.000000"], 0.0, 1e-6),
            (&["2.20746", "0.00033116", "-7.35751e-05"], 2.2, 1e-5),
            (&["2.20746", "0.00033116", "-7.35751e-05"], 7.4e-5, 1e-10),
            (&["3", "-0", "1E2"], 3.0, 1.0),
            (&["2.2", "2.20"], 2.2, 1e-2),
        ];
        for (words, x, expected) in cases {
            let mut digits = Digits::default();
            words.iter().for_each(|word| digits.read(word));
            let step = digits.steps(&[DVec3::splat(x)])[0].x;
            assert!((step / expected - 1.0).abs() < 1e-12, "{words:?}: {step}");
        }
        let mut whole = Digits::default();
        whole.read("2.2074581729392224");
        assert_eq!(whole.steps(&[DVec3::ONE]), []);
        let steps = single(DVec3::new(-1.0, 100.0, 0.0));
        assert_eq!(
            steps.truncate().to_array(),
            [2_f64.powi(-23), 2_f64.powi(-17)]
        );
        assert!(steps.z < 1e-40);
    }
}
