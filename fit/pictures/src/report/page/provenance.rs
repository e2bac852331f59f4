//! Section of the page on the origin of the numbers: all that is needed to compute them again.

use crate::report::page::markup::{count, significant};
use crate::report::page::shown::Page;
use crate::report::page::trust;
use charts::escape;
use estimator::result::ResultFile;

/// Entry of the list: its name, and its value as markup.
type Entry = (&'static str, String);

/// Writes names and values of the inputs.
pub(crate) fn section(page: &Page) -> String {
    let list: String = inputs(page)
        .into_iter()
        .chain(std::iter::once(("light", light(page.result))))
        .chain(settings(page))
        .map(|(name, value)| format!("<div><dt>{name}</dt><dd>{value}</dd></div>\n"))
        .collect();
    format!(
        "<p>With these entries, the estimate can be repeated.</p>\n\
         <dl class=\"list\">\n{list}</dl>\n\
         <p>The method is that of Sugawara and Koizumi (SIGGRAPH Asia 2025 Posters, doi \
         10.1145/3757374.3771778). The file of the option <code>-o</code> holds all numbers, \
         their errors and their correlations.</p>\n{}",
        trust::part(page.result)
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

/// Returns how the values of each file became light, and what decided it.
fn light(result: &ResultFile) -> String {
    let read = |name: &str, from: &str| format!("{name} ({from})");
    let reference = result.reference_transfer.as_deref();
    let reference = reference.zip(result.reference_transfer_from.as_deref());
    let photographs: Vec<(String, &str)> = result
        .captures
        .iter()
        .map(|c| (read(&c.transfer, &c.transfer_from), c.image.as_str()))
        .collect();
    format!(
        "The values in the files became light by these curves. What decided stands in brackets. {}",
        curves(reference.map(|(name, from)| read(name, from)), &photographs)
    )
}

/// Lists the curves of the reference and of the photographs; each has the name of its file.
///
/// Photographs with one curve share an item. Files are named if not all have the same curve.
fn curves(reference: Option<String>, photographs: &[(String, &str)]) -> String {
    let mut groups: Vec<(&str, Vec<String>)> = Vec::new();
    for (read, image) in photographs {
        let image = format!("<code>{}</code>", escape(image));
        match groups.iter_mut().find(|(known, _)| known == read) {
            Some((_, images)) => images.push(image),
            None => groups.push((read, vec![image])),
        }
    }
    let alike = groups.len() < 2;
    let reference = reference.map(|read| format!("Reference: {}.", escape(&read)));
    let others = groups.iter().map(|(read, images)| {
        let named = if alike {
            String::new()
        } else {
            format!(" {}:", images.join(", "))
        };
        let number = count(images.len(), "photograph", "photographs");
        format!("{number}:{named} {}.", escape(read))
    });
    reference
        .into_iter()
        .chain(others)
        .collect::<Vec<_>>()
        .join(" ")
}

/// Returns the entries on camera, half mirror and solver.
fn settings(page: &Page) -> Vec<Entry> {
    let result = page.result;
    let camera = &result.camera;
    let terms: usize = camera.lens.iter().map(|own| own.terms).sum();
    let lens = match (camera.lens_blur_mm, camera.lens_exponent) {
        (Some(blur), Some(exponent)) => format!(
            "At the frequency f, the lens keeps the share \
             exp(\u{2212}(f \u{b7} {} mm)<sup>{}</sup>) of the contrast. {}{}",
            significant(blur, 3),
            significant(exponent, 3),
            if camera.lens_assumed {
                "There is no reference photograph, so this was assumed. Its uncertainty, a factor \
                 of 2, is in the errors below."
            } else {
                "This was measured in the reference photograph, which shows the source itself."
            },
            match terms {
                0 => String::new(),
                count => format!(" {count} further terms describe what this form leaves out."),
            },
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn photographs_with_one_curve_share_an_item() {
        let srgb = || "sRGB (default of 8 bits)".to_owned();
        let gamma = || "gamma 2.2 (ICC profile \"A&B\")".to_owned();
        let cases = [
            (
                None,
                vec![(srgb(), "a.png")],
                "1 photograph: sRGB (default of 8 bits).",
            ),
            (
                Some("linear (EXR)".to_owned()),
                vec![(srgb(), "a.png"), (srgb(), "b.png")],
                "Reference: linear (EXR). 2 photographs: sRGB (default of 8 bits).",
            ),
            (
                None,
                vec![(srgb(), "a.png"), (gamma(), "<b>.jpg"), (srgb(), "c.png")],
                "2 photographs: <code>a.png</code>, <code>c.png</code>: sRGB (default of 8 bits). \
                 1 photograph: <code>&lt;b&gt;.jpg</code>: \
                 gamma 2.2 (ICC profile &quot;A&amp;B&quot;).",
            ),
        ];
        for (reference, photographs, wanted) in &cases {
            assert_eq!(curves(reference.clone(), photographs), *wanted);
        }
        assert_eq!(cases.len(), 3);
    }
}
