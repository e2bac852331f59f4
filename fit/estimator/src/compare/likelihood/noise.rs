//! The noise of a photograph and the weights of its bins, found in rounds with the nuisances.
//!
//! Both noise numbers are the most likely ones for the scatter of the pixels about a smooth model.
//! The weights follow from that model and stay fixed while the likelihood is maximised, because
//! weights that follow the data or the parameters bias the estimate.

use crate::compare::light::{LIGHT, Lights, Terms};
use crate::compare::likelihood::nuisances::Nuisances;
use crate::compare::likelihood::{Curves, Photograph};
use crate::compare::place::Place;
use crate::compare::view::MODEL_ERROR;
use edges::photographs::BIN_PX;
use edges::photographs::PixelNoise;

/// Weights and noise of one bin.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Weight {
    /// Square roots of the weights of the mean and of the slope; 0 for a number that the bin does
    /// not have.
    pub root: [f64; 2],
    /// Standard deviation of a pixel before the cut at 0, linear light.
    pub sigma: f64,
}

impl Photograph<'_> {
    /// Finds noise, weights and nuisances under a model that is near the truth, in even light.
    /// Returns the fall of chi-square by uneven light, see
    /// [`are_uneven`](crate::compare::are_uneven).
    pub fn settle(&mut self, curves: &Curves) -> f64 {
        self.start = self.first_guess(curves);
        self.make_rounds(curves);
        self.weigh(curves);
        let fall = self.unevenness(curves);
        self.weigh(curves);
        fall
    }

    /// Finds them in uneven light, after [`Photograph::settle`].
    pub fn settle_unevenly(&mut self, curves: &Curves) {
        self.take(Terms::All);
        self.make_rounds(curves);
        self.weigh(curves);
    }

    /// Makes rounds of noise and nuisances.
    ///
    /// Noise and light depend on each other only a little, so two rounds are enough. If noise is
    /// cut off, the plateau moves with the noise, and each round leaves about a tenth of the
    /// remaining error. Then five rounds are made.
    fn make_rounds(&mut self, curves: &Curves) {
        let rounds = if self.pixels.cut.is_any() { 5 } else { 2 };
        for _ in 0..rounds {
            self.weigh(curves);
            self.start = self.fit(curves).nuisances;
            self.dark = self.start.dark;
            if !self.terms.are_many() {
                self.start.lit = self.lit_prior()[0];
            }
        }
    }

    /// Returns the fall of chi-square by the terms of the light up to second order, with the blur
    /// free. The weights have to be found anew.
    fn unevenness(&mut self, curves: &Curves) -> f64 {
        let (settled, before) = (self.start, self.terms);
        self.start.light = [0.0; LIGHT];
        let [few, all] = [Terms::None, Terms::Second].map(|terms| {
            self.take(terms);
            let light = self.light(curves);
            self.set_weights(&light);
            // The problem is almost linear, so one step tells what the optimum would.
            self.normal(curves, self.start).unexplained()
        });
        let freedom = self.observations().saturating_sub(self.nuisances());
        self.take(before);
        self.start = settled;
        (few - all) / (all / freedom.max(1) as f64).max(1.0)
    }

    /// Replaces the noise by a known one, as bounds at a planted truth need it.
    pub fn with_noise(&mut self, curves: &Curves, noise: PixelNoise) {
        self.noise = noise;
        let light = self.light(curves);
        self.set_weights(&light);
    }

    fn first_guess(&self, curves: &Curves) -> Nuisances {
        // The line lies at the half level of the photograph. The half level of the model may lie
        // beside the model's own zero.
        let reach = self.pixels.reach() as i64;
        let half = (-reach..reach)
            .find(|&j| curves.value.around(j)[0] <= 0.5 && curves.value.around(j + 1)[0] > 0.5)
            .map_or(0.0, |j| {
                let (low, high) = (curves.value.around(j)[0], curves.value.around(j + 1)[0]);
                j as f64 + (0.5 - low) / (high - low)
            });
        let mut guess = Nuisances {
            place_px: -half * BIN_PX,
            dark: 0.0,
            step: 1.0,
            ..self.start
        };
        let (mut n, mut e, mut y, mut ee, mut ey) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for bin in &self.pixels.bins {
            let unit = Place::new(bin, [guess.place_px, 0.0]).of(&curves.value)[0];
            n += bin.count;
            e += bin.count * unit;
            y += bin.count * bin.mean;
            ee += bin.count * unit * unit;
            ey += bin.count * unit * bin.mean;
        }
        guess.step = ((n * ey - e * y) / (n * ee - e * e)).abs();
        guess.dark = (y - guess.step * e) / n;
        guess
    }

    /// Returns the expected light of each bin and its slope per pixel across the edge, for the
    /// nuisances of the start.
    pub(super) fn light(&self, curves: &Curves) -> Vec<[f64; 2]> {
        let (start, bends) = (&self.start, self.bends());
        let bins = self.bins.iter();
        bins.map(|bin| {
            let place = start.place(bin, &self.tangents(bin)[..bends]);
            let Lights { all, .. } = self.lights(bin, &start.light);
            let unit @ [_, _, across, _] = place.of(&curves.value);
            [
                start.dark + start.lit * (all.value - 1.0) + start.step * all.mean(unit),
                start.step * all.value * across,
            ]
        })
        .collect()
    }

    fn weigh(&mut self, curves: &Curves) {
        let light = self.light(curves);
        // Degrees of freedom, light, and variance of the pixels about the model's slope across the
        // edge and their own slope along it, for each bin.
        let bins = self.bins.iter().zip(&light);
        let scatter: Vec<[f64; 3]> = bins
            .filter_map(|(bin, &[light, across])| {
                let [yy, yu, uu] = bin.scatter;
                let squares = yy - 2.0 * across * yu + across * across * uu;
                let (along, slopes) = if bin.spread > 0.0 {
                    let slope = bin.slope - across * bin.tilt[0];
                    (slope * slope * bin.spread, 1.0)
                } else {
                    (0.0, 0.0)
                };
                let freedom = bin.count - 1.0 - slopes;
                (freedom > 0.0).then(|| [freedom, light, (squares - along).max(0.0) / freedom])
            })
            .collect();
        // The floor lies far below the noise of any sensor. It avoids a division by zero for
        // noise-free pictures.
        let floor = 1e-12 * self.start.step.powi(2) + f64::MIN_POSITIVE;
        self.noise = PixelNoise::most_likely(&scatter, self.pixels.cut, floor);
        self.set_weights(&light);
    }

    pub(super) fn set_weights(&mut self, light: &[[f64; 2]]) {
        let model_error = (MODEL_ERROR * self.start.step).powi(2);
        let bins = self.bins.iter().zip(light);
        self.weights = bins
            .map(|(bin, &[light, _])| {
                let variance = self.noise.variance(light);
                let sigma = variance.sqrt();
                let left = self.pixels.cut.clipped(light, sigma).2 * self.pixels.excess;
                // The model's own error is one number for a bin, however many pixels the bin has.
                let root = |amount: f64| {
                    if amount > 0.0 {
                        (left / amount + model_error * bin.count / amount)
                            .sqrt()
                            .recip()
                    } else {
                        0.0
                    }
                };
                Weight {
                    root: [root(bin.count), root(bin.spread)],
                    sigma,
                }
            })
            .collect();
    }
}
