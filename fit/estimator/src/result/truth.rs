//! The planted answer (truth.json of `fit simulate`), with which an estimate is compared.

use serde::Deserialize;

use edges::names::Kernel;
use edges::names::{ParameterId, ParameterKind};

/// The numbers with which a campaign was simulated.
#[derive(Debug, Clone, Deserialize)]
pub struct Truth {
    truth: serde_json::Value,
}

impl Truth {
    /// Returns the planted value of a parameter; at its incidence if the value differs by angle.
    /// Returns `None` if the planted kernel has no such parameter: `a` of the file is a R under
    /// `angular`, else a in 1/mm.
    pub fn of(&self, id: ParameterId) -> Option<f64> {
        let kernel = Kernel::from_name(self.truth.get("kernel")?.as_str()?)?;
        let key = match id.kind {
            ParameterKind::CornerSize if kernel.has_c() => "c",
            ParameterKind::APerMm if kernel.has_lobe() && kernel != Kernel::Angular => "a",
            ParameterKind::ATimesR if kernel == Kernel::Angular => "a",
            ParameterKind::AngularSpread => "angular_spread_mrad",
            ParameterKind::Mu => "mu",
            _ => return None,
        };
        let value = self.truth.get(key)?;
        value
            .as_f64()
            .or_else(|| value.get(id.at?.to_string())?.as_f64())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_is_what_the_planted_kernel_makes_of_it() {
        let planted = |kernel: &str| -> Truth {
            let text = format!(
                "{{\"seed\": 1, \"truth\": {{\"kernel\": \"{kernel}\", \
                \"a\": {{\"0\": 4.5, \"12.5\": 4}}, \"c\": 0.2}}}}"
            );
            serde_json::from_str(&text).expect("it is JSON")
        };
        let (eq1, angular) = (planted("eq1"), planted("angular"));
        assert_eq!(eq1.of(ParameterKind::APerMm.at(12.5)), Some(4.0));
        assert_eq!(eq1.of(ParameterKind::ATimesR.at(12.5)), None);
        assert_eq!(angular.of(ParameterKind::ATimesR.at(0.0)), Some(4.5));
        assert_eq!(angular.of(ParameterKind::APerMm.at(0.0)), None);
        assert_eq!(eq1.of(ParameterKind::APerMm.shared()), None);
        assert_eq!(eq1.of(ParameterKind::CornerSize.at(12.5)), Some(0.2));
        assert_eq!(eq1.of(ParameterKind::Mu.shared()), None);
        assert_eq!(planted("shift").of(ParameterKind::APerMm.at(0.0)), None);
        assert_eq!(planted("lobe").of(ParameterKind::CornerSize.shared()), None);
    }
}
