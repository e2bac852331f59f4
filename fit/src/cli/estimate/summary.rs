//! The printed summary of an estimate: a table for a reader.

use std::fmt::Write;

use tables::cli as terminal;

use edges::names::{ParameterId, ParameterKind};
use estimator::estimate::Bound;
use estimator::estimate::unverified_in_words;
use estimator::result::Truth;
use estimator::result::{FitResult, Number, OwnBlur, Parameter, ResultFile};

/// Returns the result as a table for a reader.
pub(super) fn summary(result: &ResultFile, truth: Option<&Truth>) -> String {
    let mut text = head(result);
    let beside = if truth.is_some() {
        "truth     difference"
    } else {
        ""
    };
    let _ = writeln!(
        text,
        "{:<12}{:>10}{:>12}{:>14}   {beside}",
        "", "incidence", "estimate", "std. error"
    );
    let mut rows = Rows { text, truth };
    let sizes = [result.c_mm, result.surface_roughness].map(|size| size.map(Parameter::Shared));
    let azimuth = result.azimuth_deg.map(Parameter::Shared);
    let spread = result.angular_spread_mrad.map(Parameter::Shared);
    let blurs = result.own_blur_px.as_ref();
    let blurs = blurs.map_or(Vec::new(), OwnBlur::numbers);
    let (errors, [e1, e2, e3]) = (result.dihedral_errors(), ParameterKind::DIHEDRAL_ERRORS);
    // Roughnesses are shown in thousandths.
    let parameters = [
        ("c (mm)", ParameterKind::CornerSize, 1.0, &sizes[0]),
        (
            "1000 x front",
            ParameterKind::SurfaceRoughness,
            1e3,
            &sizes[1],
        ),
        (
            "1000 x rough",
            ParameterKind::Roughness,
            1e3,
            &result.roughness,
        ),
        ("a (1/mm)", ParameterKind::APerMm, 1.0, &result.a_per_mm),
        ("a R", ParameterKind::ATimesR, 1.0, &result.a_times_r),
        ("spread(mrad)", ParameterKind::AngularSpread, 1.0, &spread),
        ("error 1 mrad", e1, 1.0, &errors[0]),
        ("error 2 mrad", e2, 1.0, &errors[1]),
        ("error 3 mrad", e3, 1.0, &errors[2]),
        ("mu", ParameterKind::Mu, 1.0, &result.mu),
        ("azimuth (°)", ParameterKind::Azimuth, 1.0, &azimuth),
    ];
    for (label, kind, scale, parameter) in parameters {
        if kind == ParameterKind::AngularSpread {
            for &(id, number) in &blurs {
                rows.row("blur (px)", id, number);
            }
        }
        let numbers = parameter.as_ref().map(|own| own.numbers(kind));
        for (id, number) in numbers.into_iter().flatten() {
            let scaled = Number {
                value: number.value.map(|v| v * scale),
                standard_error: number.standard_error.map(|v| v * scale),
            };
            rows.row(label, id, scaled);
        }
    }
    let mut text = rows.text;
    for (id, bound) in &result.bounds {
        let _ = writeln!(text, "{}", bounded(*id, *bound));
    }
    let nominal = result.exposures_from_exif();
    if nominal > 0 && result.mu.is_some() {
        let _ = writeln!(
            text,
            "mu rests on exposures of Exif data ({nominal} of {} photographs): cameras round shutter \
             times (1/60 s stands for 1/64 s), so that mu may be off by several percent beyond its \
             error; give `exposure` as measured",
            result.captures.len()
        );
    }
    if let Some(said) = result.diffraction_in_words() {
        let _ = writeln!(text, "{said}");
    }
    if let Some(said) = unverified_in_words(&result.trusted) {
        let _ = writeln!(text, "{said}");
    }
    text
}

/// Returns the first lines of the summary: the model in words, the data, and how well they agree.
fn head(result: &ResultFile) -> String {
    let lobe = result
        .lobe
        .map_or(String::new(), |l| format!(", lobe {}", l.name()));
    let samples = result.sampling.as_ref().map_or(String::new(), |own| {
        format!(", {} samples a pixel", own.sampling.samples)
    });
    format!(
        "model: {} (kernel {}{lobe})\n\
         fitted: {} photographs, table {}, loss {}{samples}; {} after {} evaluations, {:.2} s\n",
        result.kernel.description(),
        result.kernel.name(),
        result.captures.len(),
        terminal::in_a_line(&result.table.design),
        result.loss.name(),
        result.stop,
        result.iterations,
        result.seconds
    ) + &result.fit.as_ref().map_or(String::new(), quality)
}

/// Returns the line of the summary that says how well the model describes the photographs.
fn quality(fit: &FitResult) -> String {
    let raised = if fit.scale > 1.0 {
        format!("; standard errors x {:.2}", fit.scale)
    } else {
        String::new()
    };
    format!(
        "fit: {}, chi-square {:.4} per degree of freedom ({}), p = {}{raised}\n",
        fit.verdict.name(),
        fit.reduced_chi2,
        fit.degrees_of_freedom,
        significant(fit.p_value)
    )
}

/// Writes a probability with two digits.
fn significant(p: f64) -> String {
    if p >= 0.001 {
        format!("{p:.2}")
    } else {
        format!("{p:.0e}")
    }
}

/// Table of estimates, row by row.
struct Rows<'a> {
    text: String,
    truth: Option<&'a Truth>,
}

impl Rows<'_> {
    fn row(&mut self, label: &str, id: ParameterId, number: Number) {
        let place = id.place().unwrap_or_default();
        // Five decimals of a number that no photograph tells would fill the line, or be zeros.
        let shown = |v: Option<f64>| match v {
            None => "-".to_owned(),
            Some(v) if v != 0.0 && !(1e-5..1e4).contains(&v.abs()) => format!("{v:.3e}"),
            Some(v) => format!("{v:.5}"),
        };
        let _ = write!(
            self.text,
            "{label:<12}{place:>10}{:>12}{:>14}",
            shown(number.value),
            shown(number.standard_error)
        );
        let planted = |truth: &Truth| truth.of(id);
        if let (Some(truth), Some(value)) = (self.truth.and_then(planted), number.value) {
            let _ = write!(
                self.text,
                "   {truth:<8} {:>+9.3} %",
                100.0 * (value / truth - 1.0)
            );
        }
        self.text.push('\n');
    }
}

/// Returns the line that states a bound.
fn bounded(id: ParameterId, bound: Bound) -> String {
    let shown = |v: f64| {
        if v < 1e-3 {
            format!("{v:.2e}")
        } else {
            format!("{v:.4}")
        }
    };
    let side = match (bound.at_least, bound.at_most) {
        (Some(v), _) => format!("> {}", shown(v)),
        (_, Some(v)) => format!("< {}", shown(v)),
        _ => "not bounded by these photographs".into(),
    };
    format!("{id} {side} ({:.0} % confidence)", 100.0 * bound.confidence)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A value of 0.36 for a planted 0.3 is a fifth of the truth too large.
    #[test]
    fn differences_are_shares_of_the_truth() {
        let truth = "{\"truth\": {\"kernel\": \"eq1\", \"c\": 0.3}}";
        let truth: Truth = serde_json::from_str(truth).expect("it is JSON");
        let mut rows = Rows {
            text: String::new(),
            truth: Some(&truth),
        };
        let number = Number {
            value: Some(0.36),
            standard_error: Some(0.01),
        };
        rows.row("c (mm)", ParameterKind::CornerSize.shared(), number);
        let text = rows.text;
        assert!(
            text.contains("0.36000") && text.contains("0.01000"),
            "{text}"
        );
        assert!(text.trim_end().ends_with("+20.000 %"), "{text}");
    }
}
