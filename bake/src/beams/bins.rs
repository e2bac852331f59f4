//! Exact probability of each bin of the histogram of ray shifts.
//!
//! A piece spreads its light evenly over the image of its polygon under the map of the ray shift.
//! The image's area in each bin follows from Green's theorem, edge by edge. In each bin that an
//! edge crosses, it adds the area between itself and the right side of the bin. To every bin
//! further right it adds its height; a running sum along the row carries the height there. The cost
//! is edges x bins crossed, plus one pass over the rows that the image touches.
//!
//! If the map nearly loses a dimension, the image is a point or a segment and has no area to speak
//! of. Then the lines of the bins are carried back to the entrance plane and cut the polygon
//! itself.

use glam::{DMat2, DVec2};

use crate::geometry::{HalfPlane, Polygon, polygon};

/// Largest thinness, as the ratio of the map's singular values, of an image that is binned on the
/// entrance plane.
const THIN: f64 = 1e-3;

/// A histogram of ray shifts that is being filled: `[v][u]`, row-major.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Histogram {
    bins: usize,
    range: f64,
    /// Mass of each bin, `[v][u]`, row-major.
    pub mass: Vec<f64>,
    /// Mass outside the histogram.
    pub out_of_range: f64,
    row_sums: Vec<f64>,
}

impl Histogram {
    /// Creates an empty histogram of `bins` x `bins` over [-range, range], edge lengths.
    pub(crate) fn new(bins: usize, range: f64) -> Self {
        Histogram {
            bins,
            range,
            mass: vec![0.0; bins * bins],
            out_of_range: 0.0,
            row_sums: vec![0.0; bins + 2],
        }
    }

    /// Adds the shifts `matrix` p + `offset` of all entry points p of a polygon. Each square edge
    /// length of the polygon weighs `density`.
    pub(crate) fn add(&mut self, polygon: &[DVec2], matrix: DMat2, offset: DVec2, density: f64) {
        let mass = density * polygon::area(polygon);
        if mass <= 0.0 {
            return;
        }
        // Bin units: bin (i, j) is [i, i + 1] x [j, j + 1].
        let scale = self.bins as f64 / (2.0 * self.range);
        let matrix = matrix * scale;
        let offset = (offset + self.range) * scale;
        let squares = matrix.x_axis.length_squared() + matrix.y_axis.length_squared();
        // With the singular values s1 and s2, |det| = s1 s2 and squares = s1^2 + s2^2. Their ratio
        // is about s2 / s1 if it is small.
        if matrix.determinant().abs() <= THIN * squares {
            return self.add_strips(polygon, matrix, offset, density);
        }
        let mut image: Polygon = polygon.iter().map(|&p| matrix * p + offset).collect();
        if matrix.determinant() < 0.0 {
            image.reverse();
        }
        let whole = polygon::area(&image);
        let (low, high) = polygon::bounds(&image);
        let end = self.bins as f64;
        if low.min_element() < 0.0 || high.max_element() > end {
            let frame = [
                DVec2::ZERO,
                DVec2::new(end, 0.0),
                DVec2::splat(end),
                DVec2::new(0.0, end),
            ];
            image = polygon::clip(&image, polygon::edges(&frame));
            self.out_of_range += mass * (1.0 - polygon::area(&image) / whole).max(0.0);
        }
        if !image.is_empty() {
            self.add_image(&image, mass / whole);
        }
    }

    /// Adds the area that a polygon has in each bin, times `density`. The polygon is in bin units
    /// and lies inside the histogram.
    fn add_image(&mut self, image: &[DVec2], density: f64) {
        let (low, high) = polygon::bounds(image);
        let last = self.bins - 1;
        let rows = low.y as usize..=(high.y as usize).min(last);
        let columns = low.x as usize..=(high.x as usize).min(last);
        for row in rows {
            let (bottom, top) = (row as f64, row as f64 + 1.0);
            for (i, &a) in image.iter().enumerate() {
                let b = image[(i + 1) % image.len()];
                let (start, end) = (a.y.clamp(bottom, top), b.y.clamp(bottom, top));
                if start != end {
                    self.add_edge(x_at(a, b, start), start, x_at(a, b, end), end);
                }
            }
            let mut running = 0.0;
            let bins = &mut self.mass[row * self.bins..][..self.bins];
            for column in columns.clone() {
                running += self.row_sums[column];
                // Rounding may leave -1e-17 behind the end of the image.
                bins[column] += density * f64::max(running, 0.0);
            }
            self.row_sums[*columns.start()..columns.end() + 3].fill(0.0);
        }
    }

    /// Adds an edge that lies within one row.
    ///
    /// A height upward counts as negative. The left side of a counter-clockwise polygon runs down,
    /// so its area comes out positive.
    fn add_edge(&mut self, x0: f64, y0: f64, x1: f64, y1: f64) {
        // The ends are sorted from left to right. The sign of the height keeps the sense of the
        // edge.
        let (left, right, height) = if x0 <= x1 {
            (x0, x1, y0 - y1)
        } else {
            (x1, x0, y0 - y1)
        };
        let (first, last) = (left as usize, (right as usize).min(self.bins));
        if first >= last {
            return self.add_part(first, 0.5 * (left + right), height);
        }
        let slope = height / (right - left);
        let mut from = left;
        for column in first..=last {
            let to = right.min(column as f64 + 1.0);
            self.add_part(column, 0.5 * (from + to), slope * (to - from));
            from = to;
        }
    }

    /// Adds a piece of an edge with the given `height` and mean abscissa `x` in `column`: its area
    /// to this column, and the rest of its height to the columns on the right.
    fn add_part(&mut self, column: usize, x: f64, height: f64) {
        let inside = height * (column as f64 + 1.0 - x);
        self.row_sums[column] += inside;
        self.row_sums[column + 1] += height - inside;
    }

    /// Adds the shifts by cutting the polygon of entry points along the lines of the bins. This is
    /// slower than [`Histogram::add_image`] and right for any map.
    fn add_strips(&mut self, polygon: &[DVec2], matrix: DMat2, offset: DVec2, density: f64) {
        let rows = strips(polygon.to_vec(), matrix.row(1), offset.y, self.bins);
        for (row, part) in rows {
            let Some(row) = row else {
                self.out_of_range += density * polygon::area(&part);
                continue;
            };
            for (column, part) in strips(part, matrix.row(0), offset.x, self.bins) {
                let mass = density * polygon::area(&part);
                match column {
                    Some(column) => self.mass[row * self.bins + column] += mass,
                    None => self.out_of_range += mass,
                }
            }
        }
    }
}

/// Returns the abscissa of the line through `a` and `b` at the height `y`, between the two points.
fn x_at(a: DVec2, b: DVec2, y: f64) -> f64 {
    if y == a.y {
        a.x
    } else if y == b.y {
        b.x
    } else {
        (a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x)).clamp(a.x.min(b.x), a.x.max(b.x))
    }
}

/// Cuts a polygon where gradient.p + constant is an integer in [0, bins].
///
/// Returns the parts with the numbers of their strips, `None` for parts outside [0, bins].
fn strips(
    polygon: Polygon,
    gradient: DVec2,
    constant: f64,
    bins: usize,
) -> Vec<(Option<usize>, Polygon)> {
    let values = || polygon.iter().map(|p| gradient.dot(*p) + constant);
    let (low, high) = (
        values().fold(f64::INFINITY, f64::min),
        values().fold(f64::NEG_INFINITY, f64::max),
    );
    let index = |x: f64| (x >= 0.0 && x < bins as f64).then_some(x as usize);
    let middle = 0.5 * (low + high);
    // A polygon narrower than rounding lies in one bin, which is found as for a ray.
    if high - low <= 1e-12 * (1.0 + middle.abs()) {
        return vec![(index(middle), polygon)];
    }
    let first = low.floor().clamp(-1.0, bins as f64) + 1.0;
    let last = high.floor().clamp(-1.0, bins as f64);
    let mut parts = Vec::new();
    let mut rest = polygon;
    let mut line = first;
    while line <= last && !rest.is_empty() {
        let below = HalfPlane {
            gradient,
            anchor: DVec2::ZERO,
            constant: constant - line,
        };
        let (part, above) = polygon::split(&rest, &below);
        if !part.is_empty() {
            parts.push((index(line - 0.5), part));
        }
        rest = above;
        line += 1.0;
    }
    if !rest.is_empty() {
        parts.push((index(line - 0.5), rest));
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Computes every bin by clipping its square, slowly and plainly.
    fn by_boxes(
        polygon: &[DVec2],
        matrix: DMat2,
        offset: DVec2,
        bins: usize,
        range: f64,
    ) -> Vec<f64> {
        let width = 2.0 * range / bins as f64;
        let mut image: Polygon = polygon.iter().map(|&p| matrix * p + offset).collect();
        if polygon::area(&image) < 0.0 {
            image.reverse();
        }
        let density = 1.0 / matrix.determinant().abs();
        let mut mass = Vec::new();
        for (row, column) in (0..bins).flat_map(|row| (0..bins).map(move |column| (row, column))) {
            let low = DVec2::new(column as f64, row as f64) * width - range;
            let square = [
                low,
                low + DVec2::X * width,
                low + width,
                low + DVec2::Y * width,
            ];
            mass.push(density * polygon::area(&polygon::clip(&image, polygon::edges(&square))));
        }
        mass
    }

    fn hexagon(radius: f64) -> Polygon {
        (0..6)
            .map(|i| radius * DVec2::from_angle(0.3 + i as f64 * std::f64::consts::FRAC_PI_3))
            .collect()
    }

    #[test]
    fn scanline_strips_and_boxes_agree() {
        // Areas of bins are below 1 and come from sums of at most 40 terms. So 1e-14 bounds the
        // error of each area and of the running sum of a row.
        let cases = [
            (
                DMat2::from_diagonal(DVec2::splat(-2.0)),
                DVec2::new(0.1, -0.2),
            ),
            (
                DMat2::from_cols(DVec2::new(-2.0, 0.3), DVec2::new(0.1, -1.7)),
                DVec2::ZERO,
            ),
            (
                DMat2::from_cols(DVec2::new(0.4, 0.3), DVec2::new(0.3, -0.4)),
                DVec2::new(0.5, 0.25),
            ),
            (
                DMat2::from_diagonal(DVec2::splat(-4.0)),
                DVec2::new(1.9, -1.9),
            ),
        ];
        for (matrix, offset) in cases {
            let polygon = hexagon(0.45);
            let mut bins = Histogram::new(40, 2.0);
            bins.add(&polygon, matrix, offset, 1.0);
            let mut cut = Histogram::new(40, 2.0);
            cut.add_strips(&polygon, matrix * 10.0, (offset + 2.0) * 10.0, 1.0);
            let oracle = by_boxes(&polygon, matrix, offset, 40, 2.0);
            let worst = |mass: &[f64]| {
                mass.iter()
                    .zip(&oracle)
                    .map(|(a, b)| (a - b).abs())
                    .fold(0.0, f64::max)
            };
            assert!(worst(&bins.mass) < 1e-14, "{matrix}: {}", worst(&bins.mass));
            assert!(worst(&cut.mass) < 1e-14, "{matrix}: {}", worst(&cut.mass));
            let total = bins.mass.iter().sum::<f64>() + bins.out_of_range;
            assert!((total - polygon::area(&polygon)).abs() < 1e-14);
            assert!((bins.out_of_range - cut.out_of_range).abs() < 1e-14);
        }
    }

    #[test]
    fn edges_on_the_bins_lines_fill_whole_bins() {
        let square = [
            DVec2::splat(-1.0),
            DVec2::new(1.0, -1.0),
            DVec2::splat(1.0),
            DVec2::new(-1.0, 1.0),
        ];
        let mut bins = Histogram::new(8, 2.0);
        bins.add(&square, DMat2::IDENTITY, DVec2::ZERO, 1.0);
        for (i, &mass) in bins.mass.iter().enumerate() {
            let inside = (2..6).contains(&(i % 8)) && (2..6).contains(&(i / 8));
            assert_eq!(mass, if inside { 0.25 } else { 0.0 });
        }
        let mut full = Histogram::new(8, 2.0);
        full.add(&square, 2.0 * DMat2::IDENTITY, DVec2::ZERO, 1.0);
        assert!(
            full.mass.iter().all(|&mass| mass == 4.0 / 64.0),
            "the whole histogram, to its last bin"
        );
        assert_eq!(full.out_of_range, 0.0);
    }

    #[test]
    fn a_shared_shift_falls_into_one_bin_and_a_segment_into_a_row() {
        let polygon = hexagon(0.5);
        let whole = polygon::area(&polygon);
        let mut point = Histogram::new(8, 2.0);
        point.add(&polygon, DMat2::ZERO, DVec2::new(0.6, -0.1), 1.0);
        assert!((point.mass[3 * 8 + 5] - whole).abs() < 1e-15);
        assert_eq!(point.mass.iter().filter(|&&mass| mass > 0.0).count(), 1);
        let mut far = Histogram::new(8, 2.0);
        far.add(&polygon, DMat2::ZERO, DVec2::new(2.0, 0.0), 1.0);
        assert_eq!(far.mass.iter().sum::<f64>(), 0.0);
        assert!((far.out_of_range - whole).abs() < 1e-15);
        let mut segment = Histogram::new(8, 2.0);
        segment.add(
            &polygon,
            DMat2::from_cols(DVec2::new(-2.0, 0.0), DVec2::ZERO),
            DVec2::new(0.0, 0.2),
            1.0,
        );
        let row: f64 = segment.mass[4 * 8..5 * 8].iter().sum();
        assert!((row - whole).abs() < 1e-15, "{row} {whole}");
        assert!(
            (segment.mass[4 * 8 + 3] - segment.mass[4 * 8 + 4]).abs() < 1e-15,
            "symmetric"
        );
    }
}
