//! Places of a bin's pixels in an edge profile, and the value and slopes of a profile there.

use crate::compare::pixels::Bin;
use crate::model::Even;
use crate::photographs::BIN_PX;

/// Place of a bin's pixels in a profile that was moved and turned.
pub(crate) struct Place {
    /// Index of the bin of the profile whose centre is nearest to the pixels.
    offset: i64,
    /// Means of u, of u^2 (less that of an evenly filled bin) and of u^3, in bins.
    moments: [f64; 3],
    /// Slopes of u and u^2 along the edge, bins per pixel.
    along: [f64; 2],
    /// Mean of t, pixels, and mean of t u, pixels times bins.
    turned: [f64; 2],
}

impl Place {
    /// Locates the pixels of `bin` for an edge that lies at `place` (pixels off the line) and is
    /// turned by `turn` (rad).
    pub(crate) fn new(bin: &Bin, [place, turn]: [f64; 2]) -> Place {
        let whole = (place / BIN_PX).round();
        // u - place + turn t. The spread that the turn itself makes is kept to second order.
        let by = turn * bin.along - (place - whole * BIN_PX);
        let [u, uu, uuu] = bin.across;
        let n = bin.count.max(1.0);
        let tu = bin.cross[0] / n;
        let second = uu + 2.0 * by * u + by * by + turn * (2.0 * tu + turn * bin.spread / n);
        let third = uuu + 3.0 * by * uu + 3.0 * by * by * u + by.powi(3);
        let slopes = if bin.spread > 0.0 {
            [bin.cross[0] / bin.spread, bin.cross[1] / bin.spread]
        } else {
            [0.0; 2]
        };
        let first_along = slopes[0] + turn;
        let second_along = slopes[1] + 2.0 * by * slopes[0] + 2.0 * turn * (u + by);
        Place {
            offset: bin.number - whole as i64,
            moments: [
                (u + by) / BIN_PX,
                second / (BIN_PX * BIN_PX) - 1.0 / 12.0,
                third / BIN_PX.powi(3),
            ],
            along: [first_along / BIN_PX, second_along / (BIN_PX * BIN_PX)],
            turned: [
                bin.along,
                ((u + by) * bin.along + tu + turn * bin.spread / n) / BIN_PX,
            ],
        }
    }

    /// Evaluates a curve for the pixels: its mean, its slope along the edge (per pixel), and its
    /// first two derivatives across the edge (per pixel, and per pixel and bin).
    pub(crate) fn of(&self, curve: &Even) -> [f64; 4] {
        let [here, first, second, third] = curve.around(self.offset);
        let [m1, m2, m3] = self.moments;
        [
            here + first * m1 + 0.5 * second * m2 + third * m3 / 6.0,
            first * self.along[0] + 0.5 * second * self.along[1],
            (first + second * m1) / BIN_PX,
            second / BIN_PX,
        ]
    }

    /// Returns the derivatives by the place (pixels) of a curve's mean and of its slope along the
    /// edge, for the result of [`Place::of`].
    pub(crate) fn by_place(&self, [_, _, across, bend]: [f64; 4]) -> [f64; 4] {
        [-across, -bend * self.along[0], 0.0, 0.0]
    }

    /// Returns the derivatives by the turn of a curve's mean and of its slope along the edge, for
    /// the result of [`Place::of`].
    pub(crate) fn by_turn(&self, [_, _, across, bend]: [f64; 4]) -> [f64; 4] {
        let centre = across - bend * self.moments[0];
        [
            centre * self.turned[0] + bend * self.turned[1],
            across + bend * self.turned[0] * self.along[0],
            0.0,
            0.0,
        ]
    }
}
