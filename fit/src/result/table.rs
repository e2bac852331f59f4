//! Which table a result is of.

use serde::{Deserialize, Serialize};

/// The table that was used.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TableResult {
    /// Its content hash.
    pub content_hash: String,
    /// Its design.
    pub design: String,
    /// What tables of the same cell share, whatever directions they hold; absent from older
    /// results.
    #[serde(default)]
    pub cell: Option<CellResult>,
}

/// What makes two tables those of one cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CellResult {
    /// SHA-256 of the mesh.
    pub mesh_hash: String,
    /// Corner sizes are in units of it.
    pub edge_length: f64,
    /// Direction of azimuth 0 in the mesh's frame.
    pub azimuth_zero: [f64; 3],
    /// Of the front face.
    pub refractive_index: f64,
    /// What the facets are backed with.
    pub back: String,
    /// What of the surfaces' losses is in the table, and so not in mu.
    #[serde(default = "none")]
    pub losses: String,
    /// What else its light obeyed, as options of `bake trace`; not how finely deviations were
    /// recorded.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub options: String,
}

/// The losses of tables that had none.
fn none() -> String {
    "none".into()
}

impl TableResult {
    /// What a result keeps of the table that it was fitted with.
    pub fn of(table: &tables::Table) -> TableResult {
        let from = &table.provenance;
        TableResult {
            content_hash: table.content_hash(),
            design: from.design.clone(),
            cell: Some(CellResult {
                mesh_hash: from.mesh_hash.clone(),
                edge_length: from.edge_length,
                azimuth_zero: from.azimuth_zero,
                refractive_index: from.refractive_index,
                back: from.back.to_string(),
                losses: from.losses_text(),
                options: from.options.of_the_cell(),
            }),
        }
    }

    /// Whether the other is a table of the same cell.
    pub fn same_cell(&self, other: &TableResult) -> bool {
        let cells = self.cell.as_ref().zip(other.cell.as_ref());
        self.content_hash == other.content_hash || cells.is_some_and(|(own, other)| own.same(other))
    }
}

impl CellResult {
    /// Whether the other says the same; numbers that went through JSON may have lost their last
    /// digit.
    fn same(&self, other: &CellResult) -> bool {
        let numbers = |cell: &CellResult| {
            let [x, y, z] = cell.azimuth_zero;
            [cell.edge_length, cell.refractive_index, x, y, z]
        };
        let texts = |cell: &CellResult| {
            [&cell.mesh_hash, &cell.back, &cell.losses, &cell.options].map(String::clone)
        };
        let mut pairs = numbers(self).into_iter().zip(numbers(other));
        let near = |(a, b): (f64, f64)| (a - b).abs() <= 4.0 * f64::EPSILON * a.abs().max(1.0);
        texts(self) == texts(other) && pairs.all(near)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tables::options::StatedOptions;

    fn of(content_hash: &str, options: &str) -> TableResult {
        TableResult {
            content_hash: content_hash.into(),
            design: "triangular".into(),
            cell: Some(CellResult {
                mesh_hash: "0".repeat(64),
                edge_length: 1.0,
                azimuth_zero: [1.0, 0.0, 0.0],
                refractive_index: 1.5,
                back: "mirror".into(),
                losses: "none".into(),
                options: StatedOptions::from(options).of_the_cell(),
            }),
        }
    }

    #[test]
    fn a_cell_is_its_mesh_and_what_its_light_obeys() {
        let all = [
            ("", "--deviations off", true),
            (
                "--roughness 0.001",
                "--roughness 0.001 --deviations 2.5",
                true,
            ),
            ("--deviations off --element plate", "--element plate", true),
            ("", "--roughness 0.001", false),
            ("--roughness 0.001", "--roughness 0.002", false),
            ("--element plate", "", false),
            ("", "--normals file --deviations off", false),
            ("", "--glass-index 1.9", false),
        ];
        for (fitted, given, same) in all {
            let (fitted, other) = (of("a", fitted), of("b", given));
            assert_eq!(fitted.same_cell(&other), same, "{fitted:?} {given}");
            assert_eq!(other.same_cell(&fitted), same, "{given} {fitted:?}");
            // As a file holds it, and the same table whatever an older result says of it.
            let text = serde_json::to_string(&fitted).unwrap();
            let read: TableResult = serde_json::from_str(&text).unwrap();
            assert_eq!(read.same_cell(&other), same, "{text}");
            assert!(fitted.same_cell(&of("a", given)));
        }
        let smooth = serde_json::to_string(&of("a", "")).unwrap();
        assert!(!smooth.contains("options"), "older programs read it");
    }
}
