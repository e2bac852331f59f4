//! A planted answer, truth.json of `fit simulate`: what an estimate is compared with.

use serde::Deserialize;

use crate::names::kernel::Kernel;

/// The numbers that a campaign was made with.
#[derive(Debug, Clone, Deserialize)]
pub struct Truth {
    truth: serde_json::Value,
}

impl Truth {
    /// The planted value of `c_mm`, `a_per_mm`, `a_times_r` or `mu`, at an incidence (degrees) where it differs by angle.
    /// `None` where the planted kernel has no such parameter: `a` is a R under `angular`, else in 1/mm.
    pub fn of(&self, parameter: &str, incidence_deg: Option<f64>) -> Option<f64> {
        let kernel = Kernel::from_name(self.truth.get("kernel")?.as_str()?)?;
        let key = match parameter {
            "c_mm" if kernel.has_c() => "c",
            "a_per_mm" if kernel.has_lobe() && kernel != Kernel::Angular => "a",
            "a_times_r" if kernel == Kernel::Angular => "a",
            "mu" => "mu",
            _ => return None,
        };
        let value = self.truth.get(key)?;
        value
            .as_f64()
            .or_else(|| value.get(incidence_deg?.to_string())?.as_f64())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_is_what_the_planted_kernel_makes_of_it() {
        let planted = |kernel: &str| -> Truth {
            let text = format!(
                r#"{{"seed": 1, "truth": {{"kernel": "{kernel}", "a": {{"0": 4.5, "12.5": 4}}, "c": 0.2}}}}"#
            );
            serde_json::from_str(&text).expect("it is JSON")
        };
        let (eq1, angular) = (planted("eq1"), planted("angular"));
        assert_eq!(eq1.of("a_per_mm", Some(12.5)), Some(4.0));
        assert_eq!(eq1.of("a_times_r", Some(12.5)), None);
        assert_eq!(angular.of("a_times_r", Some(0.0)), Some(4.5));
        assert_eq!(angular.of("a_per_mm", Some(0.0)), None);
        assert_eq!(eq1.of("a_per_mm", None), None);
        assert_eq!(eq1.of("c_mm", Some(12.5)), Some(0.2));
        assert_eq!(eq1.of("mu", None), None);
        assert_eq!(planted("shift").of("a_per_mm", Some(0.0)), None);
        assert_eq!(planted("lobe").of("c_mm", None), None);
    }
}
