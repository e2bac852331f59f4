//! The separable lobe: sinc^2(a x) sinc^2(a y), the paper's Eq. (1) along each axis. It is not cut.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::LazyLock;

use super::cell_masses;
use edges::numerics::Quantile;

/// Size of the table of places: periods of sin^2, and cells in each period.
const PERIODS: usize = 64;
const PER_PERIOD: usize = 256;

/// Evaluates the OTF and its derivative by a: a triangle along each axis.
pub(super) fn otf(a: f64, frequency: f64, normal: [f64; 2]) -> (f64, f64) {
    let [x, y] = normal.map(|n| PI * (frequency * n).abs() / a);
    if x >= 1.0 || y >= 1.0 {
        return (0.0, 0.0);
    }
    ((1.0 - x) * (1.0 - y), (x * (1.0 - y) + y * (1.0 - x)) / a)
}

/// Returns the slope of the OTF at frequency 0, -d OTF/d|f| (mm), and its derivative by a.
pub(super) fn kink(a: f64, normal: [f64; 2]) -> (f64, f64) {
    let kink = PI * (normal[0].abs() + normal[1].abs()) / a;
    (kink, -kink / a)
}

/// Returns the distance beyond which the share `tail` of the light lies along an axis, mm.
///
/// The mean of sin^2 is 1/2, and the integral of sinc^2(a x) is pi/a. So the share 1/(pi a x) of the
/// light lies beyond x.
pub(super) fn reach_mm(a: f64, tail: f64) -> f64 {
    1.0 / (PI * a * tail)
}

/// Returns the quantile of sinc^2(t) dt on the whole axis.
///
/// The 1/t^2 tails never end. Beyond 64 pi the period that begins at n pi holds 64/n - 64/(n + 1) of
/// what is left (to 1.2e-5 of that 1.6e-3). Within a period the light is distributed as in the last
/// period of the table.
pub(super) fn axis(share: f64) -> f64 {
    static TABLE: LazyLock<(Quantile, f64)> = LazyLock::new(|| {
        let step = PI / PER_PERIOD as f64;
        let masses = cell_masses(PERIODS * PER_PERIOD, step, |t| (t.sin() / t).powi(2));
        // The integral of sinc^2 from 0 on is pi/2.
        let tail = 1.0 - masses.iter().sum::<f64>() / FRAC_PI_2;
        let table = Quantile::new(0.0, step, &masses).expect("the lobe has mass");
        (table, tail)
    });
    let (table, tail) = &*TABLE;
    let side = 2.0 * share - 1.0;
    let beyond = 1.0 - side.abs();
    let t = if beyond > *tail {
        table.at(side.abs() / (1.0 - tail)).0
    } else {
        let periods = PERIODS as f64;
        let place = (periods * tail / beyond).max(periods);
        let n = place.floor();
        // The share of period n that lies before the place is n (n + 1) (1/n - 1/place).
        let part = (n + 1.0) * (1.0 - n / place);
        let last = table.below((PERIODS - 1) * PER_PERIOD);
        (n - periods + 1.0) * PI + table.at(last + part * (1.0 - last)).0
    };
    t.copysign(side)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_otf_is_the_product_of_triangles() {
        let (value, _) = otf(4.2, 0.5, [0.6, 0.8]);
        assert!((value - (1.0 - PI * 0.3 / 4.2) * (1.0 - PI * 0.4 / 4.2)).abs() < 1e-15);
    }
}
