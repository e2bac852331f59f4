//! What a panel shows: polygons or bins, each with a density.

use crate::geometry::polygon::area;
use crate::plots::arrangement::Piece;
use glam::DVec2;

/// Densities of square bins.
#[derive(Debug)]
pub(crate) struct Bins {
    /// Densities `[row upward][column to the right]`.
    pub(crate) density: Vec<Vec<f64>>,
    /// Lower left corner.
    pub(crate) corner: DVec2,
    /// Side of a bin.
    pub(crate) width: f64,
}

/// Distribution that a panel shows.
#[derive(Debug)]
pub(crate) enum Content {
    /// Polygons that do not overlap, and the outlines of those that they were cut from.
    Polygons(Vec<Piece>, Vec<Vec<DVec2>>),
    /// Bins of one width.
    Bins(Bins),
}

/// Rectangle: its lowest and its highest corner.
pub(crate) type Extent = (DVec2, DVec2);

impl Content {
    /// Returns the densities above 0, each with the share of light that has it.
    pub(crate) fn light(&self) -> Vec<[f64; 2]> {
        let mut light: Vec<[f64; 2]> = match self {
            Content::Polygons(pieces, _) => {
                let share = |p: &Piece| [p.density, p.density * area(&p.polygon)];
                pieces.iter().map(share).collect()
            }
            Content::Bins(bins) => {
                let share = |density: &f64| [*density, density * bins.width * bins.width];
                bins.density.iter().flatten().map(share).collect()
            }
        };
        light.retain(|[density, _]| *density > 0.0);
        light
    }

    /// Returns the smallest rectangle that holds all that is not 0.
    pub(crate) fn extent(&self) -> Extent {
        let nothing = (DVec2::splat(f64::INFINITY), DVec2::splat(f64::NEG_INFINITY));
        let grown = |(low, high): Extent, point: DVec2| (low.min(point), high.max(point));
        match self {
            Content::Polygons(pieces, _) => {
                let corners = pieces.iter().flat_map(|piece| &piece.polygon);
                corners.copied().fold(nothing, grown)
            }
            Content::Bins(bins) => {
                let rows = bins.density.iter().enumerate();
                let filled = rows.flat_map(|(y, row)| {
                    let cells = row.iter().enumerate().filter(|(_, d)| **d > 0.0);
                    cells.map(move |(x, _)| DVec2::new(x as f64, y as f64))
                });
                let place = |at: DVec2| bins.corner + bins.width * at;
                let corners = filled.flat_map(|at| [place(at), place(at + 1.0)]);
                corners.fold(nothing, grown)
            }
        }
    }
}
