//! The way from a sample to the point of the entrance where its ray starts, uniform over the
//! entrance.

use crate::geometry::sequence::{Stream, centred};
use glam::DVec2;
use meshes::Entrance;

/// The entrance, cut so that a point of the unit square maps onto it uniformly.
///
/// Coordinates of the square are centred: (c0, c1) in (-1/2, 1/2)^2. A triangle is half of a
/// parallelogram, and the other half is folded onto it along the diagonal. This map is affine piece
/// by piece, which the fast kernel needs and the usual square-root map is not. It is also
/// continuous, which keeps the gain of a low-discrepancy sequence: turning the other half about the
/// centre instead gives 15 times the error of a mean at 65,536 points.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Launch {
    /// Pieces of the entrance.
    pieces: Vec<Piece>,
    /// Lower and upper corner of the box of all pieces, cell frame, edge lengths.
    bounds: [DVec2; 2],
}

/// A parallelogram, or the half of it with c0 + c1 <= 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Piece {
    /// Centre of the parallelogram, cell frame, edge lengths.
    pub centre: DVec2,
    /// Sides of the parallelogram, edge lengths.
    pub sides: [DVec2; 2],
    /// True if only one half belongs to the entrance.
    pub folded: bool,
    /// Number of the scene that the piece leads into.
    pub scene: usize,
    /// Start of the range in [0, 1) of the first coordinates that choose the piece.
    pub from: f64,
    /// End of that range.
    pub to: f64,
    /// Reciprocal of the length of that range.
    stretch: f64,
}

impl Piece {
    fn area(&self) -> f64 {
        let whole = self.sides[0].perp_dot(self.sides[1]).abs();
        if self.folded { whole / 2.0 } else { whole }
    }

    /// Returns the corners of the piece, counter-clockwise if its sides are, cell frame.
    pub(crate) fn polygon(&self) -> Vec<DVec2> {
        let [a, b] = self.sides.map(|side| side / 2.0);
        let corners = [
            self.centre - a - b,
            self.centre + a - b,
            self.centre - a + b,
            self.centre + a + b,
        ];
        // The half with c0 + c1 <= 0 ends at the diagonal between the second and the third corner.
        if self.folded {
            corners[..3].to_vec()
        } else {
            [0, 1, 3, 2].map(|i| corners[i]).to_vec()
        }
    }

    /// Returns whether every sample chooses this piece.
    #[inline(always)]
    pub(crate) fn takes_all(&self) -> bool {
        self.from == 0.0 && self.to == 1.0
    }

    /// Stretches the first centred coordinate, which has chosen the piece, over the whole piece.
    #[inline(always)]
    pub(crate) fn stretched(&self, c0: f64) -> f64 {
        (c0 + 0.5 - self.from) * self.stretch - 0.5
    }

    /// Returns the point of the piece for centred coordinates of the square.
    #[inline(always)]
    pub(crate) fn point(&self, c0: f64, c1: f64) -> DVec2 {
        let flip = self.folded && c0 + c1 > 0.0;
        let (c0, c1) = if flip { (-c1, -c0) } else { (c0, c1) };
        self.centre + (self.sides[0] * c0 + self.sides[1] * c1)
    }
}

impl Launch {
    /// Creates the launch over `entrance`: a simple polygon, or the parallelogram of a periodic
    /// cell.
    pub(crate) fn new(entrance: &Entrance) -> Self {
        Launch::among(&[(entrance, 1)])
    }

    /// Creates the launch over several entrances, one for each scene. Each is given with the number
    /// of equal entrances that it stands for.
    pub(crate) fn among(entrances: &[(&Entrance, usize)]) -> Self {
        let mut pieces = Vec::new();
        let mut areas = Vec::new();
        for (scene, &(entrance, count)) in entrances.iter().enumerate() {
            for piece in cut(entrance) {
                areas.push(piece.area() * count as f64);
                pieces.push(Piece { scene, ..piece });
            }
        }
        let whole: f64 = areas.iter().sum();
        let mut sum = 0.0;
        let last = pieces.len().saturating_sub(1);
        for (i, piece) in pieces.iter_mut().enumerate() {
            piece.from = sum / whole;
            sum += areas[i];
            piece.to = if i == last { 1.0 } else { sum / whole };
            piece.stretch = 1.0 / (piece.to - piece.from);
        }
        let corners = || pieces.iter().flat_map(Piece::polygon);
        let bounds = [
            corners().fold(DVec2::INFINITY, DVec2::min),
            corners().fold(DVec2::NEG_INFINITY, DVec2::max),
        ];
        Launch { pieces, bounds }
    }

    /// Returns the lower and the upper corner of the least box that holds the entrance.
    pub(crate) fn box_of_entrance(&self) -> [DVec2; 2] {
        self.bounds
    }

    /// Returns the pieces of the entrance.
    pub(crate) fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Returns the point where the ray of sample `index` of `stream` starts, cell frame, edge
    /// lengths.
    #[inline]
    #[cfg(test)]
    pub(crate) fn point(&self, stream: &Stream, index: u64) -> DVec2 {
        self.entry(stream, index).1
    }

    /// Returns the scene that the ray of sample `index` of `stream` enters, and the point where it
    /// starts, cell frame, edge lengths.
    ///
    /// The first coordinate chooses the piece by area. The rest of this coordinate is stretched
    /// over the piece.
    #[inline]
    pub(crate) fn entry(&self, stream: &Stream, index: u64) -> (usize, DVec2) {
        self.entry_of(stream.pair(index))
    }

    /// Returns what [`Launch::entry`] does for the sample with the first two coordinates `digits`.
    #[inline(always)]
    pub(crate) fn entry_of(&self, digits: [u32; 2]) -> (usize, DVec2) {
        let [c0, c1] = digits.map(centred);
        if let [piece] = &self.pieces[..] {
            return (piece.scene, piece.point(c0, c1));
        }
        // The last piece ends at 1, above every sample.
        let chosen = self.pieces.partition_point(|piece| piece.to <= c0 + 0.5);
        let piece = &self.pieces[chosen];
        (piece.scene, piece.point(piece.stretched(c0), c1))
    }

    /// Returns the azimuth of sample `index`, rad, between 0 and 2 pi. It is the third coordinate.
    #[inline]
    pub(crate) fn azimuth_rad(&self, stream: &Stream, index: u64) -> f64 {
        (centred(stream.third(index)) + 0.5) * std::f64::consts::TAU
    }

    /// Returns the chance, in (0, 1), that decides whether the photon `index` is kept at losses.
    pub(crate) fn chance(&self, stream: &Stream, index: u64) -> f64 {
        centred(stream.fourth(index)) + 0.5
    }
}

/// Cuts an entrance into pieces.
fn cut(entrance: &Entrance) -> Vec<Piece> {
    match entrance.polygon[..] {
        [a, b, c, d] if (a + c - b - d).length() <= 1e-12 * (c - a).length() => {
            vec![Piece {
                centre: (a + b + c + d) / 4.0,
                sides: [b - a, d - a],
                folded: false,
                ..WHOLE
            }]
        }
        _ => ears(&entrance.polygon).into_iter().map(folded).collect(),
    }
}

/// A piece that every sample chooses.
const WHOLE: Piece = Piece {
    centre: DVec2::ZERO,
    sides: [DVec2::X, DVec2::Y],
    folded: false,
    scene: 0,
    from: 0.0,
    to: 1.0,
    stretch: 1.0,
};

fn folded([a, b, c]: [DVec2; 3]) -> Piece {
    // The triangle is the half with c0 + c1 <= 0 of the parallelogram about the middle of b and c.
    Piece {
        centre: (b + c) / 2.0,
        sides: [b - a, c - a],
        folded: true,
        ..WHOLE
    }
}

/// Cuts a simple polygon, counter-clockwise, into triangles by clipping ears.
fn ears(polygon: &[DVec2]) -> Vec<[DVec2; 3]> {
    let mut left = polygon.to_vec();
    let mut triangles = Vec::with_capacity(left.len().saturating_sub(2));
    while left.len() > 3 {
        let n = left.len();
        let corner = |i: usize| [left[(i + n - 1) % n], left[i], left[(i + 1) % n]];
        let is_ear = |i: usize| {
            let [a, b, c] = corner(i);
            let others = (0..n - 3).map(|k| left[(i + 2 + k) % n]);
            (b - a).perp_dot(c - b) > 0.0 && others.into_iter().all(|p| !inside([a, b, c], p))
        };
        // A polygon that touches itself may have no proper ear left. Then any corner is cut off.
        let ear = (0..n).find(|&i| is_ear(i)).unwrap_or(0);
        triangles.push(corner(ear));
        left.remove(ear);
    }
    if let [a, b, c] = left[..] {
        triangles.push([a, b, c]);
    }
    triangles
}

fn inside([a, b, c]: [DVec2; 3], p: DVec2) -> bool {
    [(a, b), (b, c), (c, a)]
        .iter()
        .all(|(from, to)| (*to - *from).perp_dot(p - *from) >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tables::options::Sampler;

    /// Checks the mean and the second moment of 2^16 points against those of the polygon.
    ///
    /// The points are scrambled Sobol points. The error of a mean falls as N^-1 or faster for the
    /// continuous map of one piece (2^-16 = 1.5e-5), and as N^-3/4 (2.4e-4) if the map jumps
    /// between pieces.
    fn moments(polygon: Vec<DVec2>, mean: DVec2, xx: f64, tolerance: f64) {
        let launch = Launch::new(&Entrance {
            height: 0.5,
            polygon,
            lattice: None,
        });
        let stream = Stream::new(Sampler::Sobol, 1, 0.0, 0.0, 0);
        let n = 1 << 16;
        let points: Vec<DVec2> = (0..n).map(|i| launch.point(&stream, i)).collect();
        let sum: DVec2 = points.iter().sum();
        assert!(
            (sum / n as f64 - mean).length() < tolerance,
            "mean {:?}",
            sum / n as f64
        );
        let second: f64 = points.iter().map(|p| p.x * p.x).sum::<f64>() / n as f64;
        assert!((second - xx).abs() < tolerance, "second moment {second}");
    }

    #[test]
    fn uniform_over_triangle_square_and_an_l() {
        let p = DVec2::new;
        // Triangle (0,0) (1,0) (0,1): mean 1/3, E[x^2] = 1/6.
        moments(
            vec![p(0., 0.), p(1., 0.), p(0., 1.)],
            p(1. / 3., 1. / 3.),
            1. / 6.,
            1.5e-5,
        );
        // Parallelogram (0,0) (1,0) (1.5,1) (0.5,1): mean (0.75, 0.5), E[x^2] = 1/3 + 1/4 + 1/12.
        moments(
            vec![p(0., 0.), p(1., 0.), p(1.5, 1.), p(0.5, 1.)],
            p(0.75, 0.5),
            1. / 3. + 0.25 + 1. / 12.,
            1.5e-5,
        );
        // L of [0,2]x[0,1] and [0,1]x[1,2]: area 3, mean 5/6, E[x^2] = (2 x 4/3 + 1/3) / 3 = 1.
        let l = vec![
            p(0., 0.),
            p(2., 0.),
            p(2., 1.),
            p(1., 1.),
            p(1., 2.),
            p(0., 2.),
        ];
        moments(l, p(5. / 6., 5. / 6.), 1.0, 2.4e-4);
    }

    /// Checks that an entrance that stands for three gets three quarters of the samples. The first
    /// coordinates of 2^12 Sobol points are one in each of 2^12 equal cells, so the numbers are
    /// exact.
    #[test]
    fn an_entrance_that_stands_for_more_gets_more_samples() {
        let square = Entrance {
            height: 0.5,
            polygon: vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y],
            lattice: None,
        };
        let stream = Stream::new(Sampler::Sobol, 1, 0.0, 0.0, 0);
        let mut cases = 0;
        for (counts, expected) in [([1, 3], 1024), ([3, 1], 3072), ([7, 7], 2048)] {
            let launch = Launch::among(&counts.map(|count| (&square, count)));
            let first = (0..1 << 12).filter(|&i| launch.entry(&stream, i).0 == 0);
            assert_eq!(first.count(), expected, "{counts:?}");
            cases += 1;
        }
        assert_eq!(cases, 3);
    }
}
