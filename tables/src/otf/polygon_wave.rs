//! Fourier transform of a polygon of the entrance plane along a line.
//!
//! A uniform polygon of area A, edges e_j and their midpoints m_j, counter-clockwise, has the
//! transform `Phi(k) = i/(A |k|^2) sum_j (k_x e_jy - k_y e_jx) sinc(k.e_j/2) exp(-i k.m_j)`. Its
//! terms cancel near k = 0. There a series in the moments of the polygon along the line replaces
//! it. Both are taken about the centroid, so that a polygon far from the origin keeps its digits.

use num_complex::Complex64;

use crate::table::polygon::{area, centroid};

/// Greatest `extent * kappa` at which the moments are used.
///
/// At 1.5 the closed form has lost less than one digit. The term that the series leaves out,
/// 1.5^24/24!, is 3e-20.
const SERIES: f64 = 1.5;

/// Number of terms of the series.
const TERMS: usize = 24;

/// Fourier transform of a uniform polygon at the wave vectors `kappa * g` of one line.
///
/// `g` may be 0 or nearly 0: the polygon then looks like a point.
#[derive(Debug, Clone)]
pub(crate) struct PolygonWave {
    /// Centroid along the line, g . centroid.
    centre: f64,
    /// Largest |g . (corner - centroid)|.
    extent: f64,
    /// Moments along the line: means of (g . (p - centroid) / extent)^n over the polygon.
    moments: [f64; TERMS],
    /// For each edge: (g x e)/(A |g|^2), g.e/2, g.(midpoint - centroid).
    edges: Vec<[f64; 3]>,
}

impl PolygonWave {
    /// Prepares a counter-clockwise polygon, or returns `None` if its area is not positive.
    pub(crate) fn new(corners: &[[f64; 2]], g: [f64; 2]) -> Option<PolygonWave> {
        let area = area(corners);
        if area.is_nan() || area <= 0.0 {
            return None;
        }
        let [x, y] = centroid(corners);
        let from_centre: Vec<[f64; 2]> = corners
            .iter()
            .map(|corner| [corner[0] - x, corner[1] - y])
            .collect();
        let along: Vec<f64> = from_centre
            .iter()
            .map(|p| g[0] * p[0] + g[1] * p[1])
            .collect();
        let extent = along.iter().fold(0.0_f64, |extent, s| extent.max(s.abs()));
        let square = g[0] * g[0] + g[1] * g[1];
        let count = corners.len();
        let mut moments = [0.0; TERMS];
        moments[0] = 1.0;
        let mut edges = Vec::with_capacity(count);
        for (j, (p, s)) in from_centre.iter().zip(&along).enumerate() {
            let (q, t) = (from_centre[(j + 1) % count], along[(j + 1) % count]);
            if extent == 0.0 {
                continue;
            }
            let edge = [q[0] - p[0], q[1] - p[1]];
            edges.push([
                (g[0] * edge[1] - g[1] * edge[0]) / (area * square),
                0.5 * (t - s),
                0.5 * (t + s),
            ]);
            // In the triangle (centroid, p, q) the mean of s^n is 2 n!/(n+2)! times the sum over a
            // + b = n of s^a t^b.
            let share = 0.5 * (p[0] * q[1] - p[1] * q[0]) / area;
            let (s, t) = (s / extent, t / extent);
            let (mut power, mut complete) = (1.0, 1.0);
            for (n, moment) in moments.iter_mut().enumerate().skip(1) {
                power *= t;
                complete = s * complete + power;
                *moment += share * 2.0 * complete / ((n + 1) as f64 * (n + 2) as f64);
            }
        }
        Some(PolygonWave {
            centre: g[0] * x + g[1] * y,
            extent,
            moments,
            edges,
        })
    }

    /// Returns the mean of `exp(-i kappa g.p)` over the polygon, and its derivative by kappa.
    ///
    /// The value is accurate to 1e-14, the derivative to 1e-14 of the extent.
    pub(crate) fn at(&self, kappa: f64) -> (Complex64, Complex64) {
        let (value, slope) = if self.extent * kappa.abs() <= SERIES {
            self.series(kappa)
        } else {
            self.closed(kappa)
        };
        let turn = Complex64::cis(-kappa * self.centre);
        (
            turn * value,
            turn * (slope - Complex64::new(0.0, self.centre) * value),
        )
    }

    /// Returns value and derivative about the centroid by the series of moments.
    fn series(&self, kappa: f64) -> (Complex64, Complex64) {
        let step = Complex64::new(0.0, -self.extent * kappa);
        let (mut value, mut slope) = (Complex64::ONE, Complex64::ZERO);
        // `before` is step^(n-1)/(n-1)!, whose derivative by kappa belongs to the next term.
        let mut before = Complex64::ONE;
        for (n, &moment) in self.moments.iter().enumerate().skip(1) {
            slope += before * moment;
            before *= step / n as f64;
            value += before * moment;
        }
        (value, slope * Complex64::new(0.0, -self.extent))
    }

    /// Returns value and derivative about the centroid by the closed form.
    fn closed(&self, kappa: f64) -> (Complex64, Complex64) {
        let (mut value, mut slope) = (Complex64::ZERO, Complex64::ZERO);
        for &[across, half, middle] in &self.edges {
            let wave = Complex64::cis(-kappa * middle) * across;
            let (sinc, sinc_slope) = sinc(kappa * half);
            value += wave * sinc;
            slope += wave * Complex64::new(half * sinc_slope, -middle * sinc);
        }
        let factor = Complex64::new(0.0, 1.0 / kappa);
        let value = factor * value;
        (value, factor * slope - value / kappa)
    }
}

/// Series of sin x / x in x^2.
const SINC: [f64; 8] = [
    1.0,
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
];

/// Returns sin x / x and its derivative; the series below 0.5 leaves out x^16/17! < 1e-19.
pub(crate) fn sinc(x: f64) -> (f64, f64) {
    let square = x * x;
    if square < 0.25 {
        let (mut value, mut slope) = (0.0, 0.0);
        for term in SINC.into_iter().rev() {
            slope = slope * square + value;
            value = value * square + term;
        }
        (value, 2.0 * x * slope)
    } else {
        let (sin, cos) = x.sin_cos();
        (sin / x, (cos - sin / x) / x)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::table::polygon::fan;

    /// Nodes and weights of Gauss-Legendre quadrature on [0, 1].
    pub(crate) fn gauss(n: usize) -> Vec<(f64, f64)> {
        (0..n)
            .map(|i| {
                let mut x = ((i as f64 + 0.75) / (n as f64 + 0.5) * std::f64::consts::PI).cos();
                let mut derivative = 0.0;
                for _ in 0..100 {
                    let (mut p, mut before) = (1.0, 0.0);
                    for k in 0..n {
                        let k = k as f64;
                        (p, before) = (((2.0 * k + 1.0) * x * p - k * before) / (k + 1.0), p);
                    }
                    derivative = n as f64 * (x * p - before) / (x * x - 1.0);
                    x -= p / derivative;
                }
                (
                    0.5 + 0.5 * x,
                    1.0 / ((1.0 - x * x) * derivative * derivative),
                )
            })
            .collect()
    }

    /// Returns the mean of exp(-i k.p) by quadrature over the fan of triangles.
    ///
    /// 40 x 40 nodes are exact to rounding for |k| x size < 30: the error of n nodes falls like
    /// (phase/4n)^2n.
    pub(crate) fn quadrature(corners: &[[f64; 2]], k: [f64; 2]) -> Complex64 {
        let nodes = gauss(40);
        let origin = corners[0];
        let mut sum = Complex64::ZERO;
        for (a, b, twice) in fan(corners) {
            for &(s, ws) in &nodes {
                for &(t, wt) in &nodes {
                    let p = [0, 1].map(|i| origin[i] + s * ((1.0 - t) * a[i] + t * b[i]));
                    sum += Complex64::cis(-(k[0] * p[0] + k[1] * p[1])) * (twice * s * ws * wt);
                }
            }
        }
        sum / area(corners)
    }

    fn shapes() -> Vec<Vec<[f64; 2]>> {
        vec![
            vec![[0.0, 0.0], [1.0, 0.0], [0.3, 0.8]],
            vec![[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]],
            (0..6)
                .map(|i| f64::from(i).to_radians() * 60.0)
                .map(|a| [a.cos() + 0.2, a.sin() - 0.4])
                .collect(),
            vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1e-5], [0.0, 1e-5]],
            vec![[2.0, 1.0], [2.0, 1.0], [2.5, 1.0], [2.0, 1.5]],
        ]
    }

    #[test]
    fn transform_agrees_with_quadrature() {
        let mut cases = 0;
        for corners in shapes() {
            for g in [[1.0, 0.0], [0.0, 1.0], [0.6, -0.8], [-2.0, 1.5]] {
                let line = PolygonWave::new(&corners, g).unwrap();
                for kappa in [0.0, 1e-9, 1e-3, 0.5, 1.0, 1.49, 1.51, 3.0, 10.0, -2.0] {
                    let expected = quadrature(&corners, [kappa * g[0], kappa * g[1]]);
                    // For a sliver of width w the closed form loses digits: its error is eps / w,
                    // here 1e-16 / 1e-5.
                    let sliver = area(&corners) < 1e-3;
                    let tolerance = if sliver { 1e-10 } else { 3e-14 };
                    let (value, _) = line.at(kappa);
                    assert!(
                        (value - expected).norm() < tolerance,
                        "{corners:?} {g:?} {kappa}: {value} {expected}"
                    );
                    cases += 1;
                }
            }
        }
        assert_eq!(cases, 5 * 4 * 10);
    }

    #[test]
    fn slope_agrees_with_differences() {
        let mut cases = 0;
        for corners in shapes().into_iter().filter(|corners| area(corners) > 1e-3) {
            let line = PolygonWave::new(&corners, [1.2, -0.7]).unwrap();
            for kappa in [0.0, 0.3, 1.2, 1.6, 5.0, 12.0] {
                let h = 1e-3;
                // Fourth-order differences: error extent^5 h^4 / 30 < 3e-12 with an extent below 3,
                // rounding 1e-16/h.
                let f = |steps: f64| line.at(kappa + steps * h).0;
                let expected = ((f(1.0) - f(-1.0)) * 8.0 - (f(2.0) - f(-2.0))) / (12.0 * h);
                let (_, slope) = line.at(kappa);
                assert!(
                    (slope - expected).norm() < 2e-11,
                    "{corners:?} {kappa}: {slope} {expected}"
                );
                cases += 1;
            }
        }
        assert_eq!(cases, 4 * 6);
    }

    #[test]
    fn a_point_has_a_flat_transform() {
        let line = PolygonWave::new(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], [0.0, 0.0]).unwrap();
        assert_eq!(line.at(7.0), (Complex64::ONE, Complex64::ZERO));
        assert!(
            PolygonWave::new(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], [1.0, 0.0]).is_none(),
            "no area"
        );
        assert!(
            PolygonWave::new(&[[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]], [1.0, 0.0]).is_none(),
            "clockwise"
        );
    }

    #[test]
    fn sinc_joins_its_series() {
        for x in [0.499_999_f64, 0.5, 0.500_001, -0.499_999] {
            let (value, slope) = sinc(x);
            assert!((value - x.sin() / x).abs() < 3e-16);
            // (cos x - sinc x)/x cancels to 0.16 at 0.5: a few units of 1e-16 / 0.5.
            assert!((slope - (x.cos() - x.sin() / x) / x).abs() < 1e-15, "{x}");
        }
        assert_eq!(sinc(0.0), (1.0, 0.0));
    }
}
