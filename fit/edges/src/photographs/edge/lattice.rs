//! Patterns of the pixel grid that repeat every two pixels: rows or columns that are shifted
//! against their neighbours, as the two fields of interlaced video are, and a mosaic of colours
//! that is stored as grey.
//!
//! The distances of the pixels from the common profile are regressed on the slope of the profile (a
//! shift), its level (a colour) and a constant (a black level), each with the sign of the pixel's
//! row, column or both.

use crate::numerics::factor;
use crate::numerics::factor::Products;
use crate::photographs::edge::curve::{Steepness, loss};
use crate::photographs::edge::fault::Fault;
use crate::photographs::edge::line::EdgeLine;
use crate::photographs::edge::slant::Slant;
use crate::photographs::profile::Profile;
use crate::photographs::window::Window;

/// Share by which shifted rows lower the MTF where it is one half: the one that causes a warning,
/// and the one that causes a refusal. At tilts whose tangent is a simple fraction each bin holds
/// rows of one kind, which looks like a loss of up to 0.02.
const SHIFTED: [f64; 2] = [0.03, 0.1];

/// Least difference in light between the four places of a square of 2 x 2 pixels that is a mosaic.
/// The gains of a sensor differ by less.
const MOSAIC: f64 = 0.05;

/// Least fall of chi-square for which a pattern is believed. Noise reaches it once in 10^10
/// photographs.
const BELIEVED: f64 = 50.0;

/// Number of pixels that the edge has to cross for all patterns to be seen. With fewer, columns (of
/// a steep edge) are distances from the edge.
const LEAST_CROSSED_PX: f64 = 4.0;

/// Columns of the regression: constants and levels with the signs of row, column and both, slopes
/// with those of row and column, and the distances from the profile.
const LEVEL: usize = 3;
const SLOPE: usize = 6;
const OFF: usize = 8;

/// Patterns of the pixel grid in a window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lattice {
    /// Shift of every second row, and of every second column, across the edge, pixels.
    pub shifts_px: [f64; 2],
    /// Share by which the shifts lower the MTF where it is one half.
    pub loss: f64,
    /// Light of the places of a square of 2 x 2 pixels, row by row, with a mean of 1. The square
    /// begins at the window's corner.
    pub light: [f64; 4],
}

/// Measures the patterns of the pixel grid. Those that noise explains are left out. `rise_px` is
/// the distance from 10 to 90 % of the step.
pub(crate) fn find(window: &Window, line: &EdgeLine, profile: &Profile, rise_px: f64) -> Lattice {
    let (sin, cos) = line.normal_rad.sin_cos();
    let crosses = Slant::of(line, window).crossed_px >= LEAST_CROSSED_PX;
    let seen = |is_seen: bool| if is_seen { 1.0 } else { 0.0 };
    // Rows cut a steep edge across, columns a flat one.
    let (by_row, by_column) = (
        seen(crosses || cos.abs() >= sin.abs()),
        seen(crosses || cos.abs() < sin.abs()),
    );
    let both = seen(crosses);
    let (mut products, mut pixels) = (Products::new(OFF + 1), 0.0);
    Steepness::new(profile).all(window, line).for_each(|told| {
        let [column, row] = told.is_odd.map(|odd| if odd { -1.0 } else { 1.0 });
        let (level, slope) = (told.level, told.slope);
        products.add(&[
            both * row,
            both * column,
            both * row * column,
            both * row * level,
            both * column * level,
            both * row * column * level,
            by_row * row * slope,
            by_column * column * slope,
            told.off,
        ]);
        pixels += 1.0;
    });
    let factor = factor::of(products.sum());
    let falls = factor.column(OFF);
    let variance = window.excess() * falls[OFF].powi(2) / f64::max(pixels, 1.0);
    let believed = |from: usize, to: usize| {
        let fall: f64 = (from..to).map(|k| falls[k] * falls[k]).sum();
        fall > BELIEVED * variance
    };
    let found = factor::back_substituted(&factor, OFF, OFF);
    // Where every second row is too bright, it lies off by half of the shift, and the others by the
    // other half.
    let shift = |k: usize| {
        if believed(k, k + 1) {
            2.0 * found[k].abs()
        } else {
            0.0
        }
    };
    let shifts_px = [shift(SLOPE), shift(SLOPE + 1)];
    let signs = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let light = signs.map(|[row, column]| {
        let terms = [row, column, row * column];
        let change: f64 = (0..3).map(|k| terms[k] * found[LEVEL + k]).sum();
        if believed(0, SLOPE) {
            1.0 + change
        } else {
            1.0
        }
    });
    let variance_px2: f64 = shifts_px.iter().map(|shift| 0.25 * shift * shift).sum();
    Lattice {
        shifts_px,
        loss: loss(variance_px2, rise_px),
        light,
    }
}

impl Lattice {
    /// Refuses rows or columns that are shifted too far.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        if self.loss > SHIFTED[1] {
            let (what, shift_px) = self.shifted();
            return Err(Fault::Shifted {
                what,
                shift_px,
                loss: self.loss,
            });
        }
        Ok(())
    }

    /// Returns the farthest that a pixel lies off by the shifts, pixels.
    pub(crate) fn most_px(&self) -> f64 {
        0.5 * self.shifts_px.iter().sum::<f64>()
    }

    /// Returns what is shifted, and by how many pixels.
    fn shifted(&self) -> (&'static str, f64) {
        let [rows, columns] = self.shifts_px;
        if rows >= columns {
            ("rows", rows)
        } else {
            ("columns", columns)
        }
    }

    /// Returns warnings about small shifts and about a mosaic.
    pub(crate) fn warnings(&self) -> impl Iterator<Item = String> {
        let (what, shift_px) = self.shifted();
        let shifted = (self.loss > SHIFTED[0]).then(|| {
            format!(
                "every second of its {what} is shifted by about {shift_px:.1} pixels across the \
                edge, which lowers the MTF by {:.1} % where it is one half",
                100.0 * self.loss
            )
        });
        let [a, b, c, d] = self.light;
        let ends = [a, b, c, d]
            .iter()
            .fold((f64::INFINITY, 0.0_f64), |(low, high), &v| {
                (low.min(v), high.max(v))
            });
        let mosaic = (ends.1 - ends.0 > MOSAIC).then(|| {
            format!(
                "the four places of each square of 2 x 2 pixels see unlike light ({a:.2}, {b:.2}; \
                {c:.2}, {d:.2}): this looks like a mosaic of colours (Bayer) that was stored as \
                grey; the edge was measured as if it were grey; develop it, or save the pixels of \
                one colour"
            )
        });
        shifted.into_iter().chain(mosaic)
    }
}
