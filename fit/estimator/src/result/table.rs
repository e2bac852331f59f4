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
        let same = |(own, other): (&CellResult, _)| own.differences(other).next().is_none();
        self.content_hash == other.content_hash || cells.is_some_and(same)
    }

    /// Returns the names of the properties in which the cell of another table differs, as a list
    /// in words.
    pub fn difference(&self, other: &TableResult) -> String {
        let cells = self.cell.as_ref().zip(other.cell.as_ref());
        let names: Vec<&str> =
            cells.map_or(Vec::new(), |(own, other)| own.differences(other).collect());
        if names.is_empty() {
            return "content hash (the result does not say which cell it has)".into();
        }
        names.join(", ")
    }
}

impl CellResult {
    /// Returns the names of the properties that differ.
    ///
    /// Numbers may differ in their last digit, because they went through JSON.
    fn differences<'a>(&'a self, other: &'a CellResult) -> impl Iterator<Item = &'static str> + 'a {
        let near = |a: f64, b: f64| (a - b).abs() <= 4.0 * f64::EPSILON * a.abs().max(1.0);
        let mut zeros = self.azimuth_zero.iter().zip(other.azimuth_zero);
        let same = [
            ("mesh", self.mesh_hash == other.mesh_hash),
            ("edge length", near(self.edge_length, other.edge_length)),
            ("azimuth zero", zeros.all(|(&a, b)| near(a, b))),
            (
                "refractive index",
                near(self.refractive_index, other.refractive_index),
            ),
            ("back", self.back == other.back),
            ("losses", self.losses == other.losses),
            ("options", self.options == other.options),
        ];
        same.into_iter()
            .filter(|(_, same)| !same)
            .map(|(name, _)| name)
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
    fn what_differs_is_named() {
        let (fitted, mut other) = (of("a", ""), of("b", "--roughness 0.001"));
        assert_eq!(fitted.difference(&other), "options");
        let cell = other.cell.as_mut().unwrap();
        cell.mesh_hash = "1".repeat(64);
        cell.refractive_index = 1.49;
        cell.azimuth_zero = [0.0, 1.0, 0.0];
        let said = fitted.difference(&other);
        assert_eq!(said, "mesh, azimuth zero, refractive index, options");
        other.cell = None;
        assert!(fitted.difference(&other).starts_with("content hash"));
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
