//! Which terms the model has, and why.

use crate::estimate::CLEAR;
use crate::estimate::Kind;
use crate::names::Kernel;
use crate::names::LobeShape;
use crate::result::{Candidate, Parameter, ResultFile, sharing};

use crate::report::page::markup::{Row, grouped, table};
use crate::report::page::shown::Page;

/// The model in words.
pub(crate) fn in_words(kernel: Kernel, lobe: Option<LobeShape>) -> String {
    let lobe = match lobe {
        Some(shape) => format!("a {} lobe", shape.name()),
        None => "a lobe".into(),
    };
    match kernel {
        Kernel::Eq1 => {
            format!("the ray shift and {lobe} whose width does not depend on the distance")
        }
        Kernel::Angular => format!("the ray shift and {lobe} whose width grows with the distance"),
        Kernel::Shift => "the ray shift alone".into(),
        Kernel::Lobe => format!("{lobe} alone"),
        Kernel::Wave => "wave optics of the corner cubes at the wavelength of the source".into(),
        Kernel::Saito => {
            format!("the baseline of Saito et al. (2024): {lobe} of three rough facets")
        }
        Kernel::SaitoSurface => {
            format!(
                "the baseline of Saito et al. (2024): {lobe} of a rough front and three rough \
                facets"
            )
        }
        Kernel::Guo => format!("the baseline of Guo et al. (2018): {lobe} of a rough front"),
        Kernel::Mrm => {
            format!(
                "the baseline of Portsmouth et al. (2026): {lobe} of rough facets that reflect \
                backwards"
            )
        }
    }
}

/// The comparison of all candidates.
pub(crate) fn section(page: &Page) -> String {
    let result = page.result;
    let least = result
        .candidates
        .iter()
        .map(|c| c.criterion)
        .fold(f64::INFINITY, f64::min);
    let chosen = result.candidates.iter().position(|c| is_chosen(c, result));
    let mut out = why(result, chosen, least);
    let rows: Vec<Row> = result
        .candidates
        .iter()
        .enumerate()
        .map(|(i, candidate)| Row {
            cells: vec![
                candidate.kernel.name().into(),
                candidate.lobe.map_or("\u{2013}", LobeShape::name).into(),
                candidate.sharing.clone(),
                candidate.parameters.to_string(),
                grouped(candidate.loss),
                grouped(candidate.criterion),
                grouped(candidate.criterion - least),
                if Some(i) == chosen { "chosen" } else { "" }.into(),
            ],
            chosen: Some(i) == chosen,
        })
        .collect();
    let head = [
        "kernel",
        "lobe",
        "spread",
        "parameters",
        "\u{3c7}\u{b2}",
        "criterion",
        "above the least",
        "",
    ];
    out.push_str(&table("Candidate models", &head, &rows));
    let compared = match result.loss {
        // The criterion of `mse` is that of `mtf`.
        Kind::Mtf | Kind::Mse => "the MTFs",
        Kind::Edge => "the pixels around the edges",
    };
    let mu = match &result.mu {
        Some(Parameter::PerAngle { .. }) => "\u{b5} has one value per incidence angle.",
        Some(Parameter::Shared(_)) => "All incidence angles share one \u{b5}.",
        None => "",
    };
    out.push_str(&format!(
        "<p>The criterion is Bayes\u{2019}: \u{3c7}\u{b2}, the squared differences of {compared} \
        in units of their noise, plus \
         ln n for every parameter. {mu}</p>\n"
    ));
    out
}

/// The candidate that the estimate is of.
fn is_chosen(candidate: &Candidate, result: &ResultFile) -> bool {
    let per_angle = matches!(result.spread(), Some(Parameter::PerAngle { .. }));
    candidate.kernel == result.kernel
        && candidate.lobe == result.lobe
        && candidate.sharing == sharing(result.kernel, per_angle)
}

fn why(result: &ResultFile, chosen: Option<usize>, least: f64) -> String {
    let model = in_words(result.kernel, result.lobe);
    let candidates = &result.candidates;
    let Some(chosen) = chosen.map(|i| &candidates[i]) else {
        return format!("<p>The model is {model}.</p>\n");
    };
    let above = chosen.criterion - least;
    let reason = if candidates.len() == 1 {
        "It was named on the command line; nothing else was tried.".to_owned()
    } else if above > 0.0 {
        format!(
            "Of {} candidates it has the fewest parameters among those within {CLEAR} of the \
            least criterion: a further term \
             must lower the criterion by more than {CLEAR}, and none does.",
            candidates.len()
        )
    } else {
        let next = candidates
            .iter()
            .filter(|c| !std::ptr::eq(*c, chosen))
            .map(|c| c.criterion - least)
            .fold(f64::INFINITY, f64::min);
        format!(
            "Of {} candidates it has the least criterion; the next is {} above. A further term \
            must lower the criterion by \
             more than {CLEAR}.",
            candidates.len(),
            grouped(next)
        )
    };
    format!("<p>The model is {model}. {reason}</p>\n")
}
