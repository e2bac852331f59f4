//! Places of a bin's pixels in an edge profile, and the value and slopes of a profile there.

use crate::compare::pixels::Bin;
use crate::model::Even;
use edges::photographs::{BIN_PX, bin_at};

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
        let whole = bin_at(place);
        // u - place + turn t. The spread that the turn itself makes is kept to second order.
        let by = turn * bin.along - (place - whole * BIN_PX);
        let [u, uu, uuu] = bin.across;
        let [tt, tu] = bin.variance;
        let second = uu + 2.0 * by * u + by * by + turn * (2.0 * tu + turn * tt);
        let third = uuu + 3.0 * by * uu + 3.0 * by * by * u + by.powi(3);
        let first_along = bin.tilt[0] + turn;
        let second_along = bin.tilt[1] + 2.0 * by * bin.tilt[0] + 2.0 * turn * (u + by);
        Place {
            offset: bin.number - whole as i64,
            moments: [
                (u + by) / BIN_PX,
                second / (BIN_PX * BIN_PX) - 1.0 / 12.0,
                third / BIN_PX.powi(3),
            ],
            along: [first_along / BIN_PX, second_along / (BIN_PX * BIN_PX)],
            turned: [bin.along, ((u + by) * bin.along + tu + turn * tt) / BIN_PX],
        }
    }

    /// Evaluates a curve for the pixels: its mean, its slope along the edge (per pixel), and its
    /// first two derivatives across the edge (per pixel, and per pixel and bin).
    pub(super) fn of(&self, curve: &Even) -> [f64; 4] {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Moments of the pixels of a bin that is moved and turned, against means over the pixels
    /// themselves, in double precision of numbers up to 10. The third moment is that of an edge
    /// that is not turned: its part by the turn is left out.
    #[test]
    fn moments_are_those_of_the_moved_pixels() {
        // Distance from the bin's centre, and position along the edge, pixels.
        let pixels = [
            (-0.11, -3.0),
            (0.02, -1.5),
            (0.09, 0.5),
            (0.12, 2.0),
            (-0.05, 3.0),
        ];
        let n = pixels.len() as f64;
        let mean =
            |of: &dyn Fn(f64, f64) -> f64| pixels.iter().map(|&(u, t)| of(u, t)).sum::<f64>() / n;
        let along = mean(&|_, t| t);
        let variance = mean(&|_, t| (t - along).powi(2));
        let bin = Bin {
            number: 7,
            count: n,
            across: [1, 2, 3].map(|power| mean(&|u, _| u.powi(power))),
            along,
            spread: n * variance,
            variance: [variance, mean(&|u, t| (t - along) * u)],
            tilt: [1, 2].map(|power| mean(&|u, t| (t - along) * u.powi(power)) / variance),
            ..Bin::default()
        };
        for place in [0.0, 0.1, -0.07, 0.81] {
            for turn in [0.0, 0.02, -0.03] {
                let found = Place::new(&bin, [place, turn]);
                let whole = (place / BIN_PX).round();
                assert_eq!(found.offset, 7 - whole as i64);
                let moved = |u: f64, t: f64| (u - place + turn * t) / BIN_PX + whole;
                let expected = [
                    mean(&|u, t| moved(u, t)),
                    mean(&|u, t| moved(u, t).powi(2)) - 1.0 / 12.0,
                ];
                for (found, expected) in found.moments.into_iter().zip(expected) {
                    assert!((found - expected).abs() < 1e-14, "{place} {turn}: {found}");
                }
                if turn == 0.0 {
                    let expected = mean(&|u, t| moved(u, t).powi(3));
                    assert!((found.moments[2] - expected).abs() < 1e-14, "{place}");
                }
                let expected = [along, mean(&|u, t| t * moved(u, t))];
                for (found, expected) in found.turned.into_iter().zip(expected) {
                    assert!((found - expected).abs() < 1e-14, "{place} {turn}: {found}");
                }
            }
        }
    }
}
