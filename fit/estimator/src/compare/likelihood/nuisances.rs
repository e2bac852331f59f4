//! What each photograph has for itself: the place of its edge, its plateaus and its light.

use nalgebra::DVector;

use crate::compare::light::{Terms, Uneven};
use crate::compare::pixels::Bin;
use crate::compare::place::Place;
use edges::photographs::edge::line::ORDERS;

/// Nuisances of a photograph, in the order of their columns: the numbers that each photograph has
/// for itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nuisances {
    /// Distance of the edge from the photograph's line, pixels.
    pub place_px: f64,
    /// Turn of the edge against the line, rad.
    pub turn_rad: f64,
    /// Distance of the edge from the curve of its line, pixels: coefficients of the curve's orders
    /// 2, 3, ....
    pub bend_px: [f64; ORDERS - 1],
    /// Dark plateau.
    pub dark: f64,
    /// Unevenness of the light.
    pub light: Uneven,
    /// Part of the dark plateau that the uneven light multiplies.
    pub lit: f64,
    /// Share of the unevenness that is the lamp's, not the camera's.
    pub lamp: f64,
    /// Bright minus dark plateau where the light is 1, > 0. Its column is the derivative by
    /// ln(step).
    pub step: f64,
}

/// First column of the light.
pub(super) const FIRST_LIGHT: usize = 3;

/// Standard deviation of each order of the curve before the pixels are seen, pixels. The search of
/// the edge leaves 0.1 to 0.4 px in uneven light. High orders look alike in the four strips, so
/// without a limit their steps run away where the noise is strong.
pub(super) const BEND_PX: f64 = 0.5;

/// Returns mean and standard deviation of a number that may lie anywhere between 0 and `most`.
pub(super) fn anywhere(most: f64) -> [f64; 2] {
    [0.5 * most, most / 12.0_f64.sqrt()]
}

impl Nuisances {
    /// Locates the pixels of a bin in the edge profile. `tangents` are those of the curve's orders
    /// that are estimated.
    pub(super) fn place(&self, bin: &Bin, tangents: &[[f64; 2]]) -> Place {
        let mut line = [self.place_px, self.turn_rad];
        for (term, [height, slope]) in self.bend_px.iter().zip(tangents) {
            line[0] += term * height;
            line[1] -= term * slope;
        }
        Place::new(bin, line)
    }

    /// Returns the nuisances after a step, whose last entry is that of ln(step).
    pub(super) fn moved(self, step: &DVector<f64>, terms: Terms, bends: usize) -> Nuisances {
        let own = step.len() - 1;
        let light = step.rows(FIRST_LIGHT, terms.light());
        let bend = step.rows(FIRST_LIGHT + terms.light(), bends);
        let [lit, lamp] = if terms.are_many() {
            [step[own - 2], step[own - 1]]
        } else {
            [0.0; 2]
        };
        Nuisances {
            // A step from a poor start may be far too long: no edge lies more than a few pixels
            // from its half level.
            place_px: self.place_px - step[0].clamp(-4.0, 4.0),
            turn_rad: self.turn_rad - step[1].clamp(-0.02, 0.02),
            bend_px: std::array::from_fn(|i| {
                self.bend_px[i] - bend.get(i).map_or(0.0, |by| by.clamp(-1.0, 1.0))
            }),
            dark: self.dark - step[2],
            light: std::array::from_fn(|i| self.light[i] - light.get(i).unwrap_or(&0.0)),
            lit: self.lit - lit,
            lamp: self.lamp - lamp,
            step: self.step * (-step[own].clamp(-1.0, 1.0)).exp(),
        }
    }
}
