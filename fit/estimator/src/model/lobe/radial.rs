//! The radial lobe: sinc^2(a r), cut at a r = 2.4 pi, with total light 1.
//!
//! The paper's Eq. (1), turned about the principal ray. Without a cut its energy diverges
//! logarithmically. The authors' public code cuts there too.

use std::f64::consts::PI;
use std::sync::LazyLock;

use super::cell_masses;
use edges::numerics::{GAUSS_16, Quantile};
use tables::Samples;

/// Radius at which the lobe is cut, as a r.
pub const CUT: f64 = 2.4 * PI;

/// Number of cells of the table of radii.
const CELLS: usize = 4096;

/// Returns the quantile of sinc^2(t) t dt on [0, 2.4 pi].
pub(super) fn radius(share: f64) -> f64 {
    static TABLE: LazyLock<Quantile> = LazyLock::new(|| {
        let step = CUT / CELLS as f64;
        let masses = cell_masses(CELLS, step, |t| t.sin().powi(2) / t);
        Quantile::new(0.0, step, &masses).expect("the lobe has mass")
    });
    TABLE.at(share).0
}

/// Value of k from which the asymptotic series is exact to 1e-9.
const ASYMPTOTIC: f64 = 20.0;

/// End of the table in k, which few cameras reach. Beyond it the series is evaluated for each
/// value.
const TABLE_END: f64 = 120.0;
const TABLE_STEP: f64 = 0.02;

/// Evaluates g(k) = int_0^{2.4 pi} (sin^2 t / t) J0(k t) dt, normalised to g(0) = 1, and dg/dk, for
/// k = 2 pi f / a >= 0.
///
/// Both come from cubic Hermite interpolation of quadrature values. The fourth derivative of g is
/// at most int (sin^2 t) t^3 dt / g(0) = 260, so the error is below 260 x 0.02^4 / 384 = 1.1e-7.
pub(super) fn otf(k: f64) -> (f64, f64) {
    static TABLE: LazyLock<(Samples, f64)> = LazyLock::new(|| {
        let nodes = nodes();
        let norm = quadrature(&nodes, 0.0).0;
        let count = (TABLE_END / TABLE_STEP) as usize + 2;
        let values = (0..count).map(|i| i as f64 * TABLE_STEP).map(|k| {
            if k <= ASYMPTOTIC {
                quadrature(&nodes, k)
            } else {
                asymptotic(k)
            }
        });
        let (g, slope) = values.map(|(g, s)| (g / norm, s / norm)).unzip();
        (Samples::new(TABLE_STEP, g, slope), norm)
    });
    let (table, norm) = &*TABLE;
    if k <= TABLE_END {
        table.at(k)
    } else {
        let (g, slope) = asymptotic(k);
        (g / norm, slope / norm)
    }
}

/// Returns the nodes t of the 16-point Gauss-Legendre rule on 8 panels, each with its weight times
/// sin^2 t.
fn nodes() -> Vec<[f64; 2]> {
    const PANELS: usize = 8;
    let half = CUT / PANELS as f64 / 2.0;
    let panel = |panel: usize| {
        let middle = (2 * panel + 1) as f64 * half;
        GAUSS_16.into_iter().flat_map(move |(node, weight)| {
            [middle - node * half, middle + node * half]
                .map(|t| [t, t.sin() * t.sin() * weight * half])
        })
    };
    (0..PANELS).flat_map(panel).collect()
}

/// Integrates g and its derivative by k, not normalised, over [`nodes`]. At k = 20 each panel spans
/// 3 oscillations of the integrand, which the rule integrates to rounding.
fn quadrature(nodes: &[[f64; 2]], k: f64) -> (f64, f64) {
    let mut sum = (0.0, 0.0);
    for &[t, s] in nodes {
        sum.0 += s / t * libm::j0(k * t);
        sum.1 -= s * libm::j1(k * t);
    }
    sum
}

/// Evaluates g and its derivative by k, not normalised, for large k by a series that starts from
/// the cut.
///
/// The series is I[F] = T F J1(kT)/k + T F' J0(kT)/k^2 - I[lap F]/k^2, with F = sinc^2 and its
/// Laplacian in two dimensions (two integrations by parts). F is band-limited to k <= 2, so beyond
/// k = 2 only the cut contributes.
fn asymptotic(k: f64) -> (f64, f64) {
    let t = CUT;
    let (j0, j1) = (libm::j0(k * t), libm::j1(k * t));
    let [f, df, lap, dlap] = sinc_squared(t);
    let value =
        t * (f * j1 / k + df * j0 / k.powi(2) - lap * j1 / k.powi(3) - dlap * j0 / k.powi(4));
    // d/dk of J1(kt)/k is t J0/k - 2 J1/k^2, and that of J0/k^2 is -t J1/k^2 - 2 J0/k^3. The higher
    // powers follow in the same way.
    let slope = t
        * (f * (t * j0 / k - 2.0 * j1 / k.powi(2))
            - df * (t * j1 / k.powi(2) + 2.0 * j0 / k.powi(3))
            - lap * (t * j0 / k.powi(3) - 4.0 * j1 / k.powi(4))
            + dlap * (t * j1 / k.powi(4) + 4.0 * j0 / k.powi(5)));
    (value, slope)
}

/// Evaluates F = sin^2 t / t^2, F', its radial Laplacian F'' + F'/t, and the derivative of the
/// Laplacian.
fn sinc_squared(t: f64) -> [f64; 4] {
    // Leibniz's rule on s(t) t^-2, with s = sin^2 t, s' = sin 2t, s'' = 2 cos 2t, s''' = -4 sin 2t.
    let s = [
        t.sin().powi(2),
        (2.0 * t).sin(),
        2.0 * (2.0 * t).cos(),
        -4.0 * (2.0 * t).sin(),
    ];
    let p = [
        t.powi(-2),
        -2.0 * t.powi(-3),
        6.0 * t.powi(-4),
        -24.0 * t.powi(-5),
    ];
    let d0 = s[0] * p[0];
    let d1 = s[1] * p[0] + s[0] * p[1];
    let d2 = s[2] * p[0] + 2.0 * s[1] * p[1] + s[0] * p[2];
    let d3 = s[3] * p[0] + 3.0 * s[2] * p[1] + 3.0 * s[1] * p[2] + s[0] * p[3];
    [d0, d1, d2 + d1 / t, d3 + d2 / t - d1 / (t * t)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radial_matches_brute_force_and_its_slope_matches_differences() {
        let brute = |k: f64| {
            let n = 200_000;
            let h = CUT / n as f64;
            (0..n)
                .map(|i| (i as f64 + 0.5) * h)
                .map(|t| t.sin().powi(2) / t * libm::j0(k * t) * h)
                .sum::<f64>()
        };
        let norm = brute(0.0);
        for k in [
            0.0, 0.013, 0.5, 1.0, 1.99, 2.0, 3.7, 9.99, 19.995, 20.01, 25.0, 60.0, 125.0,
        ] {
            let (g, slope) = otf(k);
            // The midpoint rule has h = 3.8e-5 and the error h^2/24 x |integrand''| x T < 1e-7 for
            // k <= 125.
            assert!(
                (g - brute(k) / norm).abs() < 3e-7,
                "k {k}: {g} against {}",
                brute(k) / norm
            );
            let d = 1e-4;
            let difference = (otf(k + d).0 - otf((k - d).abs()).0) / (k + d - (k - d).abs()).max(d);
            if k > 0.0 {
                // The error of the interpolated values, 1.1e-7, over 2d bounds that of the
                // difference quotient.
                assert!(
                    (slope - difference).abs() < 2e-3_f64.min(1.1e-7 / d + 1e-5),
                    "k {k}: {slope} {difference}"
                );
            }
        }
    }

    /// Checks the derivative beyond the table, where value and derivative come from the series.
    /// With T = 2.4 pi, its first term is the wave T F(T) J1(k T) / (k g(0)). From k = 120 on it is
    /// below 0.12 x 0.027 / (120 x 1.65) = 1.7e-5; the other terms are a hundredth of it. Each
    /// derivative is T times as large, so the third is below 7.5e-3. The difference over 2 d errs
    /// by d^2 / 6 of that, 1.3e-9 at d = 1e-3. The rounding of k T, 3e-13 of the values, adds
    /// 1e-14.
    #[test]
    fn the_slope_beyond_the_table_matches_differences() {
        let (d, mut cases) = (1e-3, 0);
        for k in [120.5, 125.0, 160.0, 400.0] {
            let difference = (otf(k + d).0 - otf(k - d).0) / (2.0 * d);
            let slope = otf(k).1;
            assert!(
                (slope - difference).abs() < 1.5e-9,
                "{k}: {slope} {difference}"
            );
            cases += 1;
        }
        assert_eq!(cases, 4);
    }
}
