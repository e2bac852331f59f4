//! Samples of a lobe for a = 1: offsets in the image plane times a.
//!
//! Samples of microfacets invert the distribution functions 1 - exp(-r^2) and 1 - 1 / (1 + r^2).
//! Samples of the two shapes of Eq. (1) invert a tabulated distribution function. Its cells are so
//! fine that the OTF of the samples agrees with that of the lobe to 2e-5 (a density that is even
//! over cells of width h adds h^2 / 12 to the variance of the lobe):
//!
//! - radial: sinc^2(t) t on [0, 2.4 pi], and an even angle.
//! - separable: sinc^2(t) on each axis. Its 1/t^2 tails never end. Beyond 64 pi the period that
//!   begins at n pi holds 64/n - 64/(n + 1) of what is left (to 1.2e-5 of that 1.6e-3). Within a
//!   period the light is distributed as in the last period of the table.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::LazyLock;

use crate::model::CUT;
use crate::samples::quantile::Quantile;
use edges::names::LobeShape;

/// Number of cells of the radial table.
const CELLS: usize = 4096;

/// Size of the separable table: periods of sin^2, and cells in each period.
const PERIODS: usize = 64;
const PER_PERIOD: usize = 256;

/// Maps points of the unit square to offsets of a lobe with a = 1.
#[derive(Debug, Clone, Copy)]
pub struct LobeSampler {
    shape: LobeShape,
}

impl LobeSampler {
    /// Makes the sampler of a shape.
    pub fn new(shape: LobeShape) -> LobeSampler {
        LobeSampler { shape }
    }

    /// Returns the offset times a, (tangential, sagittal), for a point of the unit square.
    pub fn at(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let about = |r: f64| {
            let (sin, cos) = (TAU * v).sin_cos();
            [r * cos, r * sin]
        };
        match self.shape {
            LobeShape::Radial => about(radius(u)),
            LobeShape::Beckmann => about((-(-u).ln_1p()).sqrt()),
            LobeShape::Ggx => about((u / (1.0 - u)).sqrt()),
            LobeShape::Separable => [axis(u), axis(v)],
        }
    }
}

/// Returns the quantile of sinc^2(t) t dt on [0, 2.4 pi].
fn radius(share: f64) -> f64 {
    static TABLE: LazyLock<Quantile> = LazyLock::new(|| {
        let step = CUT / CELLS as f64;
        let masses = cells(CELLS, step, |t| t.sin().powi(2) / t);
        Quantile::new(0.0, step, &masses).expect("the lobe has mass")
    });
    TABLE.at(share).0
}

/// Returns the quantile of sinc^2(t) dt on the whole axis.
fn axis(share: f64) -> f64 {
    static TABLE: LazyLock<(Quantile, f64)> = LazyLock::new(|| {
        let step = PI / PER_PERIOD as f64;
        let masses = cells(PERIODS * PER_PERIOD, step, |t| (t.sin() / t).powi(2));
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

/// Integrates a density over cells of width `step` from 0 on, by the two-point Gauss rule, which is
/// exact to step^4.
fn cells(count: usize, step: f64, density: impl Fn(f64) -> f64) -> Vec<f64> {
    let node = 0.5 / 3.0_f64.sqrt();
    (0..count)
        .map(|i| {
            let at = |x: f64| density((i as f64 + x) * step);
            0.5 * step * (at(0.5 - node) + at(0.5 + node))
        })
        .collect()
}
