//! Section of the page on the chosen terms of the model.

use edges::names::Kernel;
use edges::names::LobeShape;
use estimator::estimate::CLEAR;
use estimator::estimate::Kind;
use estimator::result::{Candidate, OwnBlur, Parameter, ResultFile, sharing};

use crate::report::page::markup::{Row, grouped, table};
use crate::report::page::shown::Page;

/// Explains the model in sentences, with the words that they need.
pub(crate) fn explained(kernel: Kernel, lobe: Option<LobeShape>) -> String {
    let effects = if kernel.is_baseline() {
        "The model is a baseline: a published model that is fitted for comparison. Facets are the \
         small faces of the sheet. Rough facets spread each ray into a spot of light, the \
         lobe."
    } else {
        "Two effects blur the mid-air image. First, a corner cube sends each ray back parallel to \
         itself, but a little to the side: this is the ray shift. Second, light spreads behind a \
         small opening, such as that of a cube (diffraction): one ray becomes a spot of light, the \
         lobe."
    };
    let model = kernel.causes(lobe);
    let shape = lobe.map_or(String::new(), |shape| format!(" {}", shape.description()));
    format!("{effects} The model explains the blur by {model}.{shape}")
}

/// Writes the choice of the model and the comparison of all candidates.
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
                shared(candidate),
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
        "above the lowest",
        "",
    ];
    out.push_str(&table("Candidate models", &head, &rows));
    let compared = match result.loss {
        // The criterion of `mse` is that of `mtf`.
        Kind::Mtf | Kind::Mse => "the MTF curves",
        Kind::Edge => "the pixels around the edges",
    };
    let mu = match &result.mu {
        Some(Parameter::PerAngle { .. }) => {
            " The reflectance \u{b5} has one value per incidence angle."
        }
        Some(Parameter::Shared(_)) => " All incidence angles share one reflectance \u{b5}.",
        None => "",
    };
    if let Some(said) = result.diffraction_in_words() {
        let mut letters = said.chars();
        let first = letters
            .next()
            .map_or(String::new(), |own| own.to_uppercase().to_string());
        out.push_str(&format!("<p>{first}{}.</p>\n", letters.as_str()));
    }
    out.push_str(&format!(
        "<p>In this table, \u{3c7}\u{b2} compares {compared}. The criterion is \u{3c7}\u{b2} \
         plus a price for every parameter: the natural logarithm of the number of independent \
         data. This is Bayes\u{2019} information criterion (BIC). If \u{3c7}\u{b2} per degree of \
         freedom is above 1 for every candidate, \u{3c7}\u{b2} is first divided by the lowest of \
         these values. \u{201c}Spread\u{201d} says whether the spread of the lobe is shared by all \
         incidence angles or has one value per angle. \u{201c}Parameters\u{201d} is the number of \
         fitted parameters of the blur.{mu}</p>\n<p>The kernels explain the blur by these \
         causes:</p>\n<dl class=\"list\">\n"
    ));
    let mut named: Vec<Kernel> = Vec::new();
    for kernel in result.candidates.iter().map(|candidate| candidate.kernel) {
        if !named.contains(&kernel) {
            named.push(kernel);
            out.push_str(&format!(
                "<div><dt>{}</dt><dd>{}</dd></div>\n",
                kernel.name(),
                kernel.causes(None)
            ));
        }
    }
    out.push_str("</dl>\n");
    out
}

/// Returns true for the candidate of the estimate.
fn is_chosen(candidate: &Candidate, result: &ResultFile) -> bool {
    let per_angle = matches!(result.spread(), Some(Parameter::PerAngle { .. }));
    candidate.kernel == result.kernel
        && candidate.lobe == result.lobe
        && candidate.sharing == sharing(result.kernel, per_angle)
        && candidate.own_blur == result.own_blur_px.is_some()
        && candidate.own_blur_per_distance
            == matches!(result.own_blur_px, Some(OwnBlur::PerDistance { .. }))
        && candidate.angular_spread == result.angular_spread_mrad.is_some()
        && candidate.dihedral_errors == result.dihedral_errors_mrad.is_some()
}

/// Describes how the spread of a candidate is shared, and its further blurs.
fn shared(candidate: &Candidate) -> String {
    let own = match (candidate.own_blur, candidate.own_blur_per_distance) {
        (_, true) => Some(", own blur per distance"),
        (true, false) => Some(", own blur"),
        (false, false) => None,
    };
    let angular = candidate.angular_spread.then_some(", angular spread");
    let errors = candidate.dihedral_errors.then_some(", dihedral errors");
    let further: String = own.into_iter().chain(angular).chain(errors).collect();
    format!("{}{further}", candidate.sharing)
}

/// Explains why this candidate was chosen; `least` is the lowest criterion of all.
fn why(result: &ResultFile, chosen: Option<usize>, least: f64) -> String {
    let model = format!(
        "A kernel is the set of causes of blur in a model. The kernel of this estimate is {}: {}.",
        result.kernel.name(),
        result.kernel.causes(result.lobe)
    );
    let candidates = &result.candidates;
    let Some(chosen) = chosen.map(|i| &candidates[i]) else {
        return format!("<p>{model}</p>\n");
    };
    let above = chosen.criterion - least;
    let reason = if candidates.len() == 1 {
        "The command line allowed no other candidate, so none was tried.".to_owned()
    } else if above > 0.0 {
        format!(
            "<code>fit</code> compared {} candidate models by a criterion: the lower, the better. \
             Criteria that differ by at most {CLEAR} count as equal. Of the candidates within \
             {CLEAR} of the lowest criterion, this one has the fewest parameters.",
            candidates.len()
        )
    } else {
        let next = candidates
            .iter()
            .filter(|c| !std::ptr::eq(*c, chosen))
            .map(|c| c.criterion - least)
            .fold(f64::INFINITY, f64::min);
        format!(
            "<code>fit</code> compared {} candidate models by a criterion: the lower, the better. \
             This one has the lowest criterion, and the next is {} above it. A candidate with \
             more parameters is chosen only if it lowers the criterion by more than {CLEAR}.",
            candidates.len(),
            grouped(next)
        )
    };
    format!("<p>{model} {reason}</p>\n")
}
