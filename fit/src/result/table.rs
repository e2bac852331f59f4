//! Identity of the table that a result was fitted with.

use serde::{Deserialize, Serialize};

/// Table that was used.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TableResult {
    /// Content hash of the table.
    pub content_hash: String,
    /// Design of the cell.
    pub design: String,
    /// Properties of the cell, equal in all tables of the same cell whatever their directions.
    ///
    /// They are absent from older results.
    #[serde(default)]
    pub cell: Option<CellResult>,
}

/// Properties by which two tables are known to be of the same cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CellResult {
    /// SHA-256 of the mesh.
    pub mesh_hash: String,
    /// Edge length of a cube in units of the mesh; c is the size of this edge in mm.
    pub edge_length: f64,
    /// Direction of azimuth 0 in the mesh's frame.
    pub azimuth_zero: [f64; 3],
    /// Refractive index behind the flat front face; 1 for hollow cubes.
    pub refractive_index: f64,
    /// Material on the back of the facets.
    pub back: String,
    /// Losses of the surfaces that the table contains, and that mu therefore does not contain.
    #[serde(default = "none")]
    pub losses: String,
    /// Other options of `bake trace` that change the light of the cell.
    ///
    /// The resolution of recorded deviations is not one of them.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub options: String,
}

/// Returns the losses of tables that had none.
fn none() -> String {
    "none".into()
}

impl TableResult {
    /// Returns the part of a table that a result keeps.
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

    /// Returns true if the other table is one of the same cell.
    pub fn same_cell(&self, other: &TableResult) -> bool {
        let cells = self.cell.as_ref().zip(other.cell.as_ref());
        self.content_hash == other.content_hash || cells.is_some_and(|(own, other)| own.same(other))
    }
}

impl CellResult {
    /// Returns true if the other properties are equal.
    ///
    /// Numbers may differ in their last digit, because they went through JSON.
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
            // The text form means the same. An equal content hash is the same table, whatever the
            // properties say.
            let text = serde_json::to_string(&fitted).unwrap();
            let read: TableResult = serde_json::from_str(&text).unwrap();
            assert_eq!(read.same_cell(&other), same, "{text}");
            assert!(fitted.same_cell(&of("a", given)));
        }
        let smooth = serde_json::to_string(&of("a", "")).unwrap();
        assert!(!smooth.contains("options"), "older programs read it");
    }
}
