//! Where the numbers come from: enough to get them again.

use crate::report::page::markup::{escape, significant};
use crate::report::page::shown::Page;

/// Names and values.
pub(crate) fn section(page: &Page) -> String {
    let result = page.result;
    let code = |text: &str| format!("<code>{}</code>", escape(text));
    let mut rows = vec![
        ("command", code(page.command)),
        ("program", format!("fit {}", env!("CARGO_PKG_VERSION"))),
        ("manifest", code(&page.campaign.file.display().to_string())),
        ("table", escape(&result.table.design)),
        ("table content", code(&result.table.content_hash)),
    ];
    if let Some(cell) = &result.table.cell {
        rows.push(("mesh of the cell", code(&cell.mesh_hash)));
        rows.push((
            "cell",
            format!(
                "edge length {} (units of the mesh), refractive index {}, back {}, losses {}",
                significant(cell.edge_length, 6),
                cell.refractive_index,
                escape(&cell.back),
                escape(&cell.losses)
            ),
        ));
    }
    let camera = &result.camera;
    let lens = match (camera.lens_blur_mm, camera.lens_exponent) {
        (Some(blur), Some(exponent)) => format!(
            "lens exp(\u{2212}(f \u{b7} {} mm)<sup>{}</sup>) from the reference photograph",
            significant(blur, 3),
            significant(exponent, 3)
        ),
        _ => "no lens: there is no reference photograph".into(),
    };
    rows.push((
        "camera",
        format!("pixel {} mm; {lens}", camera.pixel_pitch_mm),
    ));
    if let Some(spectrum) = &result.wavelength_nm {
        rows.push(("wavelengths (nm)", escape(&spectrum.to_string())));
    }
    rows.push((
        "half mirror",
        format!(
            "transmittance times reflectance {}",
            significant(result.half_mirror, 4)
        ),
    ));
    if let Some(own) = &result.sampling {
        let sampling = own.sampling;
        rows.push((
            "render",
            format!(
                "{} samples a pixel ({}, seed {})",
                sampling.samples,
                sampling.sequence.name(),
                sampling.seed
            ),
        ));
    }
    rows.push((
        "solver",
        format!(
            "loss {}, {} after {} evaluations",
            result.loss.name(),
            escape(&result.stop),
            result.iterations
        ),
    ));
    let list: String = rows
        .iter()
        .map(|(name, value)| format!("<div><dt>{name}</dt><dd>{value}</dd></div>\n"))
        .collect();
    format!(
        "<dl class=\"list\">\n{list}</dl>\n<p>The method is that of Sugawara and Koizumi \
        (SIGGRAPH Asia 2025 Posters, doi \
         10.1145/3757374.3771778). All numbers, and the covariance, are in the file that \
         <code>-o</code> writes.</p>\n"
    )
}
