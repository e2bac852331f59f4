//! Fourier transform of a ray-shift distribution along a line: the optical transfer function of the
//! ray shift.
//!
//! `w` is the vector that turns a shift r = (u, v) in edge lengths into a position x = w.r on the
//! line. `S(kappa) = E[exp(-2 pi i kappa w.r)]` over the retroreflected rays, with kappa in cycles
//! per unit of x. For the image plane of the model, w = c (cos(theta) cos(alpha), sin(alpha)) with
//! c in mm makes x mm and kappa cycles per mm. Then dS/dc = (kappa / c) dS/dkappa.
//!
//! There are two ways. From the bins, each is a uniform box: this is exact for the histogram, which
//! itself blurs by one bin. If the direction has polygons, their closed form needs no bins. A path
//! maps its polygon p by `M p + o`, so its transform is `exp(-i k.o) Phi(transpose(M) k)`. A map
//! that collapses the polygon to a segment or a point is no special case.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::lookup::direction::Direction;
use crate::otf::polygon_wave::{PolygonWave, sinc};
use crate::otf::waves::{LANES, Rows, STEP, Waves};
use crate::table::exact::Path;
use crate::table::polygon::area;

impl Direction {
    /// Returns S at each frequency, from the polygons if there are any, otherwise from the bins;
    /// S(0) = 1.
    ///
    /// If nothing returns (eta 0), all values are 0. Polygons include the shifts outside of the
    /// histogram's range; bins do not. Values are accurate to 1e-13. For 16384 bins a frequency
    /// takes about 10 us.
    ///
    /// ```
    /// # use ndarray::Array2;
    /// # use tables::Direction;
    /// # let mut probability = Array2::zeros((4, 4));
    /// # probability[[1, 3]] = 0.5;
    /// # let direction = Direction {
    /// #     incidence_deg: 0.0, azimuth_deg: 0.0, retroreflected: 0.5, probability, range: 2.0,
    /// #     standard_error: 0.0, interpolated: false, paths: None, exits: None,
    /// # };
    /// // One bin of width 1 about u = 1.5: a box, shifted.
    /// let otf = direction.otf_along([1.0, 0.0], &[0.0, 0.25]);
    /// assert!((otf[0].re - 1.0).abs() < 1e-15);
    /// assert!((otf[1].norm() - 0.9003163161571061).abs() < 1e-15); // sin(pi/4) / (pi/4)
    /// ```
    pub fn otf_along(&self, w: [f64; 2], kappa: &[f64]) -> Vec<Complex64> {
        match &self.paths {
            Some(paths) => of_paths(paths, w, kappa).0,
            None => self.of_bins::<false>(w, kappa).0,
        }
    }

    /// Returns S and dS/dkappa at each frequency.
    ///
    /// S is that of [`Direction::otf_along`]; from bins it takes twice the time.
    pub fn otf_and_slope_along(
        &self,
        w: [f64; 2],
        kappa: &[f64],
    ) -> (Vec<Complex64>, Vec<Complex64>) {
        match &self.paths {
            Some(paths) => of_paths(paths, w, kappa),
            None => self.of_bins::<true>(w, kappa),
        }
    }

    /// Returns S and dS/dkappa from the bins, even if the direction has polygons.
    pub fn otf_of_bins_along(
        &self,
        w: [f64; 2],
        kappa: &[f64],
    ) -> (Vec<Complex64>, Vec<Complex64>) {
        self.of_bins::<true>(w, kappa)
    }

    /// Returns S, and dS/dkappa if `SLOPE` is set, from the bins.
    fn of_bins<const SLOPE: bool>(
        &self,
        w: [f64; 2],
        kappa: &[f64],
    ) -> (Vec<Complex64>, Vec<Complex64>) {
        let total = self.probability.sum();
        if total <= 0.0 {
            return (
                vec![Complex64::ZERO; kappa.len()],
                vec![Complex64::ZERO; kappa.len()],
            );
        }
        let (bins, width) = (
            self.probability.ncols(),
            2.0 * self.range / self.probability.ncols() as f64,
        );
        let centres: Vec<f64> = (0..bins)
            .map(|i| (i as f64 + 0.5) * width - self.range)
            .collect();
        let rows = Rows::new(&self.probability, &centres);
        let (mut values, mut slopes) = (
            Vec::with_capacity(kappa.len()),
            Vec::with_capacity(kappa.len()),
        );
        let mut along_u = Waves::new(bins.next_multiple_of(STEP));
        let mut along_v = Waves::new(bins.next_multiple_of(STEP));
        for block in kappa.chunks(LANES) {
            along_u.fill(block, w[0], &centres, width);
            along_v.fill(block, w[1], &centres, width);
            let sums = rows.sums::<SLOPE>(&along_u, &along_v, &centres);
            for (lane, &kappa) in block.iter().enumerate() {
                let [plain, by_u, by_v] =
                    sums.map(|(re, im)| Complex64::new(re[lane], im[lane]) / total);
                let (box_u, box_u_slope) = sinc(0.5 * TAU * kappa * w[0] * width);
                let (box_v, box_v_slope) = sinc(0.5 * TAU * kappa * w[1] * width);
                values.push(plain * box_u * box_v);
                if SLOPE {
                    let centre = Complex64::new(0.0, -TAU) * (by_u * w[0] + by_v * w[1]);
                    let boxes = 0.5
                        * TAU
                        * width
                        * (w[0] * box_u_slope * box_v + w[1] * box_u * box_v_slope);
                    slopes.push(centre * (box_u * box_v) + plain * boxes);
                }
            }
        }
        (values, slopes)
    }
}

/// Returns S and dS/dkappa from polygons.
fn of_paths(paths: &[Path], w: [f64; 2], kappa: &[f64]) -> (Vec<Complex64>, Vec<Complex64>) {
    let mut total = 0.0;
    let mut lines = Vec::with_capacity(paths.len());
    for path in paths {
        let [[uu, uv], [vu, vv]] = path.matrix;
        let g = [TAU * (uu * w[0] + vu * w[1]), TAU * (uv * w[0] + vv * w[1])];
        if let Some(line) = PolygonWave::new(&path.polygon, g) {
            let power = path.weight * area(&path.polygon);
            total += power;
            lines.push((
                power,
                TAU * (w[0] * path.offset[0] + w[1] * path.offset[1]),
                line,
            ));
        }
    }
    let sum = |&kappa: &f64| {
        let (mut value, mut slope) = (Complex64::ZERO, Complex64::ZERO);
        for (power, offset, line) in &lines {
            let turn = Complex64::cis(-kappa * offset) * (power / total);
            let (here, here_slope) = line.at(kappa);
            value += turn * here;
            slope += turn * (here_slope - Complex64::new(0.0, *offset) * here);
        }
        (value, slope)
    };
    if total <= 0.0 {
        return (
            vec![Complex64::ZERO; kappa.len()],
            vec![Complex64::ZERO; kappa.len()],
        );
    }
    kappa.iter().map(sum).unzip()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::otf::polygon_wave::{tests::gauss, tests::quadrature};
    use ndarray::Array2;

    fn direction(probability: Array2<f64>, paths: Option<Vec<Path>>) -> Direction {
        Direction {
            incidence_deg: 10.0,
            azimuth_deg: 0.0,
            retroreflected: probability.sum(),
            probability,
            range: 2.0,
            standard_error: 0.0,
            interpolated: false,
            paths,
            exits: None,
        }
    }

    fn lumpy(bins: usize) -> Array2<f64> {
        Array2::from_shape_fn((bins, bins), |(v, u)| {
            ((v * 7 + u * 13) % 11) as f64 * ((u + v) % 5) as f64
        })
        .mapv(|p| p * 1e-3)
    }

    const LINES: [[f64; 2]; 5] = [
        [1.0, 0.0],
        [0.0, 1.0],
        [0.6, -0.8],
        [0.08, 0.02],
        [0.0, 0.0],
    ];
    const KAPPA: [f64; 11] = [0.0, 1e-9, 0.1, 0.25, 0.5, 0.9, 1.3, -0.4, 2.0, 2.5, 3.0];

    #[test]
    fn bins_agree_with_quadrature() {
        let direction = direction(lumpy(12), None);
        let nodes = gauss(16);
        let (width, total) = (4.0 / 12.0, direction.probability.sum());
        let mut cases = 0;
        for w in LINES {
            let otf = direction.otf_along(w, &KAPPA);
            for (value, kappa) in otf.iter().zip(KAPPA) {
                let mut expected = Complex64::ZERO;
                for ((v, u), p) in direction.probability.indexed_iter() {
                    for (s, ws) in &nodes {
                        for (t, wt) in &nodes {
                            let r = [(u as f64 + s) * width - 2.0, (v as f64 + t) * width - 2.0];
                            let phase = TAU * kappa * (w[0] * r[0] + w[1] * r[1]);
                            expected += Complex64::cis(-phase) * (p * ws * wt / total);
                        }
                    }
                }
                // Phases reach 2 pi 3 x 2.8 = 53, each rounded to 53 x 1e-16. 16 nodes are exact
                // over one bin.
                assert!(
                    (value - expected).norm() < 5e-14,
                    "{w:?} {kappa}: {value} {expected}"
                );
                cases += 1;
            }
        }
        assert_eq!(cases, 5 * 11);
    }

    fn paths() -> Vec<Path> {
        let triangle = vec![[0.0, 0.0], [1.0, 0.0], [0.3, 0.8]];
        let square = vec![[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
        let path = |polygon: &[[f64; 2]], matrix, offset, weight| Path {
            polygon: polygon.to_vec(),
            matrix,
            offset,
            weight,
            deviation: [0.0; 2],
            passes: 0,
            jones: None,
            cube: None,
        };
        vec![
            path(&triangle, [[-2.0, 0.0], [0.0, -2.0]], [0.4, -0.3], 1.0),
            path(&square, [[0.5, 0.2], [-0.1, 1.5]], [0.0, 0.6], 0.7),
            path(&square, [[0.0, 1.0], [1.0, 0.0]], [0.1, 0.0], 0.5), // turns it over
            path(&triangle, [[1.0, 2.0], [0.5, 1.0]], [-0.2, 0.1], 0.9), // to a segment
            path(&square, [[0.0, 0.0], [0.0, 0.0]], [0.3, 0.2], 0.4), // to a point
        ]
    }

    #[test]
    fn polygons_agree_with_quadrature() {
        let mut cases = 0;
        let single = paths().into_iter().map(|path| vec![path]);
        for paths in single.chain([paths()]) {
            let total: f64 = paths
                .iter()
                .map(|path| path.weight * area(&path.polygon))
                .sum();
            let direction = direction(lumpy(4), Some(paths.clone()));
            for w in LINES {
                for (value, kappa) in direction.otf_along(w, &KAPPA).iter().zip(KAPPA) {
                    let k = w.map(|w| TAU * kappa * w);
                    let mut expected = Complex64::ZERO;
                    for path in &paths {
                        let m = path.matrix;
                        let inside = [
                            m[0][0] * k[0] + m[1][0] * k[1],
                            m[0][1] * k[0] + m[1][1] * k[1],
                        ];
                        let offset = k[0] * path.offset[0] + k[1] * path.offset[1];
                        let share = path.weight * area(&path.polygon) / total;
                        expected +=
                            quadrature(&path.polygon, inside) * Complex64::cis(-offset) * share;
                    }
                    // Phases reach 2 pi 3 x 3 and are rounded, as for bins.
                    assert!(
                        (value - expected).norm() < 1e-13,
                        "{w:?} {kappa}: {value} {expected}"
                    );
                    cases += 1;
                }
            }
        }
        assert_eq!(cases, 6 * 5 * 11);
    }

    #[test]
    fn slopes_agree_with_differences() {
        let mut cases = 0;
        for direction in [
            direction(lumpy(12), None),
            direction(lumpy(4), Some(paths())),
        ] {
            for w in LINES {
                let (values, slopes) = direction.otf_and_slope_along(w, &KAPPA);
                for (same, other) in values.iter().zip(direction.otf_along(w, &KAPPA)) {
                    assert!((same - other).norm() < 1e-15);
                }
                let h = 1e-4;
                let f = |steps: f64| direction.otf_along(w, &KAPPA.map(|kappa| kappa + steps * h));
                let [a, b, c, d] = [f(1.0), f(-1.0), f(2.0), f(-2.0)];
                for i in 0..KAPPA.len() {
                    let expected = ((a[i] - b[i]) * 8.0 - (c[i] - d[i])) / (12.0 * h);
                    // Fourth-order differences err by (2 pi 3)^5 h^4 / 30 = 8e-12, rounding of
                    // values by 5e-14 / h = 5e-10.
                    assert!(
                        (slopes[i] - expected).norm() < 1e-9,
                        "{w:?} {}: {} {expected}",
                        KAPPA[i],
                        slopes[i]
                    );
                    cases += 1;
                }
            }
        }
        assert_eq!(cases, 2 * 5 * 11);
    }

    #[test]
    fn where_nothing_returns_all_is_zero() {
        for direction in [
            direction(Array2::zeros((8, 8)), None),
            direction(Array2::zeros((8, 8)), Some(Vec::new())),
        ] {
            let (values, slopes) = direction.otf_and_slope_along([1.0, 0.0], &[0.0, 1.0]);
            assert_eq!(
                (values, slopes),
                (vec![Complex64::ZERO; 2], vec![Complex64::ZERO; 2])
            );
        }
    }
}
