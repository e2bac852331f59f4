//! Polygons that overlap, cut into pieces that do not: the densities add where they overlap.

use crate::geometry::Polygon;
use crate::geometry::polygon::{area, clip, edges, split, subtract};

/// Convex polygon with the same density everywhere.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Piece {
    /// Corners, counter-clockwise.
    pub(crate) polygon: Polygon,
    /// Density, per unit of area of the polygon.
    pub(crate) density: f64,
}

/// Returns pieces that do not overlap and have the summed density of `sheets`; `None` if there are
/// more than `most`.
///
/// Pieces of no more than the area `least` are left out.
pub(crate) fn arrangement(sheets: &[Piece], least: f64, most: usize) -> Option<Vec<Piece>> {
    let mut pieces: Vec<Piece> = Vec::new();
    for sheet in sheets {
        pieces = laid(pieces, sheet, least);
        if pieces.len() > most {
            return None;
        }
    }
    Some(pieces)
}

/// Lays one more sheet on pieces that do not overlap.
fn laid(pieces: Vec<Piece>, sheet: &Piece, least: f64) -> Vec<Piece> {
    let planes: Vec<_> = edges(&sheet.polygon).collect();
    let mut laid = Vec::with_capacity(pieces.len() + 4);
    // What no piece has covered yet.
    let mut rest = vec![sheet.polygon.clone()];
    for piece in pieces {
        if area(&clip(&piece.polygon, planes.iter().copied())) <= least {
            laid.push(piece);
            continue;
        }
        let mut common = piece.polygon;
        for plane in &planes {
            let (inside, outside) = split(&common, plane);
            keep(&mut laid, outside, piece.density, least);
            common = inside;
        }
        let cut: Vec<_> = edges(&common).collect();
        let less = |part: Polygon| subtract(&part, &cut, least).unwrap_or_else(|| vec![part]);
        rest = rest.into_iter().flat_map(less).collect();
        keep(&mut laid, common, piece.density + sheet.density, least);
    }
    for part in rest {
        keep(&mut laid, part, sheet.density, least);
    }
    laid
}

/// Appends a polygon that is large enough to be seen.
fn keep(pieces: &mut Vec<Piece>, polygon: Polygon, density: f64, least: f64) {
    if area(&polygon) > least {
        pieces.push(Piece { polygon, density });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::polygon::hull;
    use glam::DVec2;
    use proptest::prelude::*;

    fn square(low: f64, high: f64, density: f64) -> Piece {
        let corners = [(low, low), (high, low), (high, high), (low, high)];
        Piece {
            polygon: corners.map(|(x, y)| DVec2::new(x, y)).to_vec(),
            density,
        }
    }

    #[test]
    fn densities_add_where_two_squares_overlap() {
        let both = [square(0.0, 2.0, 1.0), square(1.0, 3.0, 4.0)];
        let pieces = arrangement(&both, 0.0, 100).expect("they are few");
        let area_of = |density: f64| -> f64 {
            let chosen = pieces.iter().filter(|p| p.density == density);
            chosen.map(|p| area(&p.polygon)).sum()
        };
        assert_eq!([1.0, 4.0, 5.0].map(area_of), [3.0, 3.0, 1.0]);
        // Two equal polygons are one piece.
        let twice = [square(0.0, 2.0, 1.0), square(0.0, 2.0, 0.5)];
        assert_eq!(
            arrangement(&twice, 0.0, 1),
            Some(vec![square(0.0, 2.0, 1.5)])
        );
        assert_eq!(arrangement(&both, 0.0, 4), None, "a limit of pieces");
    }

    proptest! {
        // Every point lies in one piece, of the density of all sheets that hold it. The corners of
        // pieces are good to 1e-15, so points that close to an edge are left out; there are none
        // among random ones. The light is kept but for pieces of less than `least`: 20 sheets of 8
        // corners in at most 3,000 pieces leave out less than 3,000 times 1e-13.
        #[test]
        fn pieces_hold_the_summed_density_of_all_sheets(
            shapes in proptest::collection::vec(
                (proptest::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64), 3..8), 0.1..2.0_f64),
                1..20,
            ),
            points in proptest::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64), 50),
        ) {
            let sheets: Vec<Piece> = shapes
                .iter()
                .map(|(corners, density)| {
                    let corners: Vec<DVec2> =
                        corners.iter().map(|&(x, y)| DVec2::new(x, y)).collect();
                    Piece { polygon: hull(&corners, 0.0), density: *density }
                })
                .collect();
            let pieces = arrangement(&sheets, 1e-13, 3_000).expect("they are few");
            let light = |all: &[Piece]| -> f64 {
                all.iter().map(|p| p.density * area(&p.polygon)).sum()
            };
            let lost = light(&sheets) - light(&pieces);
            prop_assert!(lost.abs() < 40.0 * 3_000.0 * 1e-13, "{lost}");
            for (x, y) in points {
                let point = DVec2::new(x, y);
                let holds = |p: &&Piece| edges(&p.polygon).all(|edge| edge.value(point) <= 0.0);
                let expected: f64 = sheets.iter().filter(holds).map(|p| p.density).sum();
                let found: Vec<&Piece> = pieces.iter().filter(holds).collect();
                prop_assert!(found.len() <= 1, "{point} lies in {} pieces", found.len());
                let density = found.first().map_or(0.0, |p| p.density);
                prop_assert!((density - expected).abs() < 1e-13, "{density} {expected}");
            }
        }
    }
}
