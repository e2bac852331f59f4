//! Section of the page on the origin of the numbers: all that is needed to compute them again.

use crate::report::page::markup::{escape, significant};
use crate::report::page::shown::Page;

/// Entry of the list: its name, and its value as markup.
type Entry = (&'static str, String);

/// Writes names and values of the inputs.
pub(crate) fn section(page: &Page) -> String {
    let list: String = inputs(page)
        .into_iter()
        .chain(settings(page))
        .map(|(name, value)| format!("<div><dt>{name}</dt><dd>{value}</dd></div>\n"))
        .collect();
    format!(
        "<p>With these entries, the estimate can be repeated.</p>\n\
         <dl class=\"list\">\n{list}</dl>\n\
         <p>The method is that of Sugawara and Koizumi (SIGGRAPH Asia 2025 Posters, doi \
         10.1145/3757374.3771778). The file of the option <code>-o</code> holds all numbers, \
         their errors and their correlations.</p>\n"
    )
}

/// Returns the entries on command, program and files.
fn inputs(page: &Page) -> Vec<Entry> {
    let result = page.result;
    let code = |text: &str| format!("<code>{}</code>", escape(text));
    let manifest = code(&page.campaign.file.display().to_string());
    let mut rows = vec![
        ("command", code(page.command)),
        ("program", format!("fit {}", env!("CARGO_PKG_VERSION"))),
        (
            "manifest",
            format!("{manifest}, the file that describes the photographs"),
        ),
        (
            "table",
            format!(
                "{}; the table says where the cell, the part of the sheet that repeats, sends the \
                 light",
                escape(&result.table.design)
            ),
        ),
        (
            "content hash",
            format!(
                "{}, a checksum of the table",
                code(&result.table.content_hash)
            ),
        ),
    ];
    if let Some(cell) = &result.table.cell {
        rows.push((
            "mesh hash",
            format!(
                "{}, a checksum of the shape of the cell",
                code(&cell.mesh_hash)
            ),
        ));
        rows.push((
            "cell",
            format!(
                "edge length of a cube {} (units of the mesh), refractive index {}, back of the \
                 cubes: {}, losses of light in the table: {}",
                significant(cell.edge_length, 6),
                cell.refractive_index,
                escape(&cell.back),
                escape(&cell.losses)
            ),
        ));
    }
    rows
}

/// Returns the entries on camera, light and solver.
fn settings(page: &Page) -> Vec<Entry> {
    let result = page.result;
    let camera = &result.camera;
    let lens = match (camera.lens_blur_mm, camera.lens_exponent) {
        (Some(blur), Some(exponent)) => format!(
            "At the frequency f, the lens keeps the share \
             exp(\u{2212}(f \u{b7} {} mm)<sup>{}</sup>) of the contrast. {}",
            significant(blur, 3),
            significant(exponent, 3),
            if camera.lens_assumed {
                "There is no reference photograph, so this was assumed. Its uncertainty, a factor \
                 of 2, is in the errors below."
            } else {
                "This was measured in the reference photograph, which shows the source itself."
            }
        ),
        _ => "The blur of the lens is left out, because there is no reference photograph.".into(),
    };
    let mut rows = vec![(
        "camera",
        format!(
            "One pixel is {} mm wide in the plane of the mid-air image. {lens}",
            camera.pixel_pitch_mm
        ),
    )];
    if let Some(spectrum) = &result.wavelength_nm {
        rows.push(("wavelengths (nm)", escape(&spectrum.to_string())));
    }
    rows.push((
        "half mirror",
        format!(
            "It reflects the light once and lets it pass once. This leaves the share {} of the \
             light (transmittance times reflectance).",
            significant(result.half_mirror, 4)
        ),
    ));
    rows.push((
        "view",
        if result.seen_in_mirror == Some(false) {
            "The camera looked at the sheet straight."
        } else {
            "The camera saw the sheet in the half mirror."
        }
        .into(),
    ));
    if let Some(own) = &result.sampling {
        let sampling = own.sampling;
        rows.push((
            "render",
            format!(
                "The model was computed with {} samples per pixel (sequence {}, seed {}).",
                sampling.samples,
                sampling.sequence.name(),
                sampling.seed
            ),
        ));
    }
    rows.push((
        "solver",
        format!(
            "It minimised the loss {}, a measure of the difference between photographs and \
             model. It stopped after {} evaluations: {}.",
            result.loss.name(),
            result.iterations,
            escape(&result.stop)
        ),
    ));
    rows
}
