//! Which table a result is of.

use serde::{Deserialize, Serialize};

/// The table that was used.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TableResult {
    /// Its content hash.
    pub content_hash: String,
    /// Its design.
    pub design: String,
    /// What tables of the same cell share, whatever directions they hold; absent from older results.
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
                back: from.back.clone(),
                losses: from.losses_text(),
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
    /// Whether the other says the same; numbers that went through JSON may have lost their last digit.
    fn same(&self, other: &CellResult) -> bool {
        let numbers = |cell: &CellResult| {
            let [x, y, z] = cell.azimuth_zero;
            [cell.edge_length, cell.refractive_index, x, y, z]
        };
        let texts =
            |cell: &CellResult| [&cell.mesh_hash, &cell.back, &cell.losses].map(String::clone);
        let mut pairs = numbers(self).into_iter().zip(numbers(other));
        let near = |(a, b): (f64, f64)| (a - b).abs() <= 4.0 * f64::EPSILON * a.abs().max(1.0);
        texts(self) == texts(other) && pairs.all(near)
    }
}
