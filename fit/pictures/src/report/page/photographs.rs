//! Section of the page with the warnings, each beside its photograph.

use rayon::prelude::*;

use edges::photographs::Shot;
use estimator::result::ResultFile;

use crate::report::page::crop::crop;
use crate::report::page::markup::count;
use crate::report::page::shown::{Page, name};
use charts::escape;

/// Greatest number of photographs that are shown.
///
/// A page with hundreds of them would be slow on a phone, and they would repeat one another.
const MOST_CROPS: usize = 24;

/// Warnings about one photograph, or about the campaign.
struct Warned<'a> {
    title: String,
    shot: Option<&'a Shot>,
    warnings: Vec<&'a str>,
}

/// Returns the number of warnings of a result.
pub(crate) fn number(result: &ResultFile) -> usize {
    let of_captures: usize = result.captures.iter().map(|c| c.warnings.len()).sum();
    result.warnings.len() + of_captures
}

/// Writes all warnings with the photographs that they are about.
pub(crate) fn section(page: &Page) -> String {
    let warned = gather(page);
    if warned.is_empty() {
        return "<p>There are no warnings: <code>fit</code> repaired nothing, assumed nothing and \
                found nothing doubtful.</p>\n"
            .into();
    }
    let crops: Vec<Option<String>> = warned
        .par_iter()
        .enumerate()
        .map(|(i, item)| {
            let label = format!("{}: the part that was measured, with its edge", item.title);
            crop(item.shot.filter(|_| i < MOST_CROPS)?, &label)
        })
        .collect();
    let mut out = String::new();
    if crops.iter().any(Option::is_some) {
        out.push_str(
            "<p>The brightness of these pictures is stretched from their darkest to their \
             brightest pixels. The dashed line is the edge that <code>fit</code> found. The frame \
             is the region that it measured. Red pixels are saturated: they were too bright for \
             the camera.</p>\n",
        );
    }
    for (item, crop) in warned.iter().zip(&crops) {
        let lines: String = item
            .warnings
            .iter()
            .map(|warning| format!("<li>{}</li>", escape(warning)))
            .collect();
        out.push_str(&format!(
            "<article class=\"warned\"><div><h3>{}</h3>\n<ul>{lines}</ul></div>\n{}</article>\n",
            escape(&item.title),
            crop.as_deref().unwrap_or_default()
        ));
    }
    let pictures = warned.iter().filter(|item| item.shot.is_some()).count();
    if pictures > MOST_CROPS {
        out.push_str(&format!(
            "<p>{} listed without a picture: the page shows {MOST_CROPS} at most.</p>\n",
            count(pictures - MOST_CROPS, "photograph is", "photographs are")
        ));
    }
    out
}

/// Collects the warnings: those of the campaign first, then those of each photograph.
fn gather<'a>(page: &'a Page) -> Vec<Warned<'a>> {
    let (campaign, result) = (page.campaign, page.result);
    let shots: Vec<&Shot> = campaign
        .references
        .iter()
        .chain(campaign.captures.iter().map(|c| &c.shot))
        .collect();
    // If a warning of the campaign is about one photograph, it begins with the photograph's name.
    let about = |warning: &'a str| {
        shots.iter().find_map(|&shot| {
            let rest = warning.strip_prefix(&name(&shot.image))?;
            Some((shot, rest.strip_prefix(": ")?))
        })
    };
    let mut whole = Vec::new();
    let mut found: Vec<Warned> = Vec::new();
    for warning in &result.warnings {
        let Some((shot, warning)) = about(warning) else {
            whole.push(warning.as_str());
            continue;
        };
        match found
            .iter_mut()
            .find(|w| w.shot.is_some_and(|s| std::ptr::eq(s, shot)))
        {
            Some(item) => item.warnings.push(warning),
            None => found.push(Warned {
                title: name(&shot.image),
                shot: Some(shot),
                warnings: vec![warning],
            }),
        }
    }
    // Results are in the order of the manifest. Captures that were left out are missing.
    let mut results = result.captures.iter().peekable();
    for capture in &campaign.captures {
        let image = name(&capture.shot.image);
        let same =
            results.next_if(|r| r.image == image && r.incidence_deg == capture.incidence_deg);
        let Some(r) = same.filter(|r| !r.warnings.is_empty()) else {
            continue;
        };
        found.push(Warned {
            title: image,
            shot: Some(&capture.shot),
            warnings: r.warnings.iter().map(String::as_str).collect(),
        });
    }
    if !whole.is_empty() {
        let campaign = Warned {
            title: "The campaign: all photographs together".into(),
            shot: None,
            warnings: whole,
        };
        found.insert(0, campaign);
    }
    found
}
