//! Part of the page on the inputs that no photograph can check.

use crate::report::page::markup::{Row, significant, table};
use charts::{escape, minus};
use estimator::estimate::{Effect, Unverified, UnverifiedInput};
use estimator::result::ResultFile;

/// Columns of the table: the heading, and the effect that it shows.
type Column = (&'static str, fn(&Effect) -> Option<f64>);

/// Writes the table of what is taken on trust; nothing for a result without it.
pub(crate) fn part(result: &ResultFile) -> String {
    if result.trusted.is_empty() {
        return String::new();
    }
    let columns: [Column; 3] = [
        ("c", |effect| effect.c_mm),
        (
            if result.a_times_r.is_some() { "A" } else { "a" },
            |effect| effect.a_per_mm,
        ),
        ("\u{b5}", |effect| effect.mu),
    ];
    let mut head = vec!["taken on trust", "value", "if larger by"];
    head.extend(columns.iter().map(|(title, _)| *title));
    let row = |entry: &Unverified| -> Row {
        let value = |value| escape(&minus(significant(value, 4)));
        let mut cells = vec![
            named(entry.what).to_owned(),
            entry.value.map_or("\u{2013}".into(), value),
            escape(&minus(entry.step.replace(" deg", "\u{b0}"))),
        ];
        cells.extend(columns.iter().map(|(_, of)| {
            of(&entry.effect).map_or("\u{2013}".into(), |share| {
                minus(format!("{:+.2} %", 100.0 * share))
            })
        }));
        cells.into()
    };
    let rows: Vec<Row> = result.trusted.iter().map(row).collect();
    format!(
        "<h3>Taken on trust</h3>\n<p>No photograph can check these numbers of the manifest and of \
         the table. The columns on the right say how much each result would change if the number \
         were larger by the step (of several values by angle, the largest change). A dash stands \
         for a result that there is not, and for an effect that is not known: the table holds no \
         direction one degree further, or its light depends on the index in other ways too. The \
         value has a dash where the photographs differ.</p>\n{}",
        table("Taken on trust", &head, &rows)
    )
}

/// Returns the name of an input for a reader.
fn named(given: UnverifiedInput) -> &'static str {
    match given {
        UnverifiedInput::PixelPitchMm => "pixel pitch (mm)",
        UnverifiedInput::FloatingDistanceMm => "floating distances (mm)",
        UnverifiedInput::HalfMirror => "half mirror (transmittance times reflectance)",
        UnverifiedInput::ReferenceExposure => "exposure of the reference",
        UnverifiedInput::Exposure => "exposures over that of the reference",
        UnverifiedInput::WavelengthNm => "wavelengths (nm)",
        UnverifiedInput::RefractiveIndex => "refractive index",
        UnverifiedInput::IncidenceDeg => "incidence angles (\u{b0})",
        UnverifiedInput::AzimuthDeg => "azimuths (\u{b0})",
        UnverifiedInput::TangentialAxisDeg => "tangential axes (\u{b0})",
        UnverifiedInput::Lens => "lens: as sharp as in the reference",
        UnverifiedInput::DihedralAngles => "dihedral angles: as in the table",
        UnverifiedInput::Linearity => "light over the camera's values, at the brightest plateau",
        UnverifiedInput::Cell => "cell of the table",
    }
}
