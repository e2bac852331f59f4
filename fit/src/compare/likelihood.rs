//! The likelihood of one photograph's pixels under an edge profile.
//!
//! A pixel at distance d from the edge, and t along it, has the expected light
//!
//! ```text
//! dark + lit (L - 1) + step L E(d),
//! L = 1 + g_d d + g_t t + g_dd d^2 + g_dt d t + g_tt (t^2 - m)
//! ```
//!
//! E is the unit edge through blur and camera. The polynomial L is the unevenness of the light. It
//! multiplies the light of the edge, and the part of the dark plateau that is light of the same
//! lamp. The rest is a veil or the camera's offset. The lit part may be anything between nothing
//! and all of the dark plateau. Its prior has the mean and the deviation of that range. m is the
//! mean of t^2 over the window, so that the step is a mean along the edge: bins of equal range
//! along the edge cannot tell g_tt from the step.
//!
//! The noise is normal with the variance read + gain x light ([`PixelNoise`]). If the camera cuts
//! it off at 0 or at full scale, the mean and the variance after the cut are used. Both noise
//! numbers are the most likely ones for the scatter of the pixels about a smooth model. The weights
//! follow from that model and stay fixed while the likelihood is maximised, because weights that
//! follow the data or the parameters bias the estimate.
//!
//! Position and angle of the edge, both plateaus and the light are nuisances of each photograph.
//! For each trial blur they are set to their optimum and projected out (variable projection). What
//! remains is a function of blur and lens alone.

use nalgebra::{DMatrix, DVector};

use crate::compare::pixels::{Bin, Pixels};
use crate::compare::place::Place;
use crate::compare::view::MODEL_ERROR;
use crate::model::Blur;
use crate::model::Camera;
use crate::model::Model;
use crate::model::{Even, Grid};
use crate::numerics::factor;
use crate::numerics::factor::Products;
use crate::photographs::BIN_PX;
use crate::photographs::PixelNoise;

/// Nuisances of a photograph, in the order of their columns: the numbers that each photograph has
/// for itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Nuisances {
    /// Distance of the edge from the photograph's line, pixels.
    pub place_px: f64,
    /// Turn of the edge against the line, rad.
    pub turn_rad: f64,
    /// Dark plateau.
    pub dark: f64,
    /// Unevenness of the light: coefficients of d and t (per pixel), and of d^2, d t and t^2.
    pub light: [f64; LIGHT],
    /// Part of the dark plateau that the uneven light multiplies.
    pub lit: f64,
    /// Bright minus dark plateau, > 0. Its column is the derivative by ln(step).
    pub step: f64,
}

/// Number of terms of uneven light.
pub(crate) const LIGHT: usize = 5;

/// Number of terms of first order, which are always estimated.
const FIRST_ORDER: usize = 2;

/// Fall of chi-square from which the terms of second order are estimated too. Noise reaches it in
/// one photograph of 1,000 (three terms). They would raise the errors of c and a by 6 % and those
/// of mu by 80 % where the light is even.
const UNEVEN: f64 = 16.27;

/// First column of the light.
const FIRST_LIGHT: usize = 3;

/// Column of the lit part of the dark plateau.
const LIT: usize = FIRST_LIGHT + LIGHT;

/// Number of columns of the nuisances. The last is that of ln(step).
pub(crate) const NUISANCES: usize = LIT + 2;

/// Column of ln(step).
pub(crate) const STEP: usize = NUISANCES - 1;

/// Edge profile of a trial model, with its derivatives by the fitted parameters: ln spread, ln c,
/// then those of the lens.
pub(crate) struct Curves {
    value: Even,
    by: Vec<Even>,
}

/// Photograph with its nuisances at their optimum.
pub(crate) struct Fitted {
    /// Upper triangular R, where R^T R is the weighted normal matrix of (nuisances, derivatives,
    /// residual).
    pub factor: DMatrix<f64>,
    /// Nuisances at the optimum.
    pub nuisances: Nuisances,
}

/// Light in one bin, or one term of it.
#[derive(Debug, Clone, Copy)]
struct Lit {
    /// Mean over the bin's pixels.
    value: f64,
    /// Slope along the edge, per pixel.
    by_t: f64,
    /// Variance of the pixels' places along the edge.
    share: f64,
}

impl Lit {
    /// Returns the mean of a curve in this light, from the curve's mean and its slope along the
    /// edge.
    fn mean(self, [unit, along, ..]: [f64; 4]) -> f64 {
        self.value * unit + self.by_t * along * self.share
    }

    /// Returns the slope of a curve in this light along the edge.
    fn slope(self, [unit, along, ..]: [f64; 4]) -> f64 {
        self.value * along + self.by_t * unit
    }
}

/// Weights and noise of one bin.
#[derive(Debug, Clone, Copy, Default)]
struct Weight {
    /// Square roots of the weights of the mean and of the slope; 0 for a number that the bin does
    /// not have.
    root: [f64; 2],
    /// Standard deviation of a pixel before the cut at 0, linear light.
    sigma: f64,
}

/// Pixels of a photograph with their noise and their weights.
pub(crate) struct Photograph<'a> {
    /// Pixels of the photograph, by bins.
    pub pixels: &'a Pixels,
    /// Noise of the pixels.
    pub noise: PixelNoise,
    /// Number of terms of the light that are estimated: those of first order, or all.
    light_terms: usize,
    /// Dark plateau of the last round, which sets the prior of its lit part.
    dark: f64,
    grid: Grid,
    weights: Vec<Weight>,
    start: Nuisances,
}

impl<'a> Photograph<'a> {
    /// Prepares a photograph of which only the pixels are known. [`Photograph::settle`] finds the
    /// rest.
    pub(crate) fn new(pixels: &'a Pixels, pitch_mm: f64) -> Photograph<'a> {
        Photograph {
            pixels,
            noise: PixelNoise {
                read: 1.0,
                gain: 0.0,
            },
            light_terms: FIRST_ORDER,
            dark: 0.0,
            grid: Grid::new(2 * pixels.reach() + 1, pitch_mm),
            weights: Vec::new(),
            start: Nuisances {
                place_px: 0.0,
                turn_rad: 0.0,
                dark: 0.0,
                light: [0.0; LIGHT],
                lit: 0.0,
                step: 1.0,
            },
        }
    }

    /// Returns the number of independent numbers in the photograph: for each bin a mean, and a
    /// slope if its pixels are spread along the edge.
    pub(crate) fn observations(&self) -> usize {
        let known = |w: &Weight| w.root.iter().filter(|&&root| root > 0.0).count();
        self.weights.iter().map(known).sum()
    }

    /// Evaluates the edge profile through `camera`, with its derivatives. Without a `model` the
    /// profile is that of the source edge itself. Derivatives by the lens are those by the first
    /// `lens` of its parameters (ln blur, exponent).
    pub(crate) fn curves(
        &self,
        model: Option<(&Model, Blur)>,
        camera: &Camera,
        lens: usize,
    ) -> Curves {
        let normal_rad = self.pixels.line.normal_rad;
        let blurs = model.map_or((false, false), |(model, _)| {
            (model.kernel.has_lobe(), model.kernel.has_c())
        });
        let n = self.grid.frequencies_per_mm().len();
        // OTF and its derivatives by ln spread, ln c, ln(lens blur) and the exponent.
        let mut otf = [const { Vec::new() }; 5];
        for part in &mut otf {
            part.reserve(n);
        }
        for f in self.grid.frequencies_per_mm() {
            let camera = camera.otf_and_slopes(f, normal_rad);
            let [value, by_spread, by_c] = match model {
                Some((model, blur)) if camera[0].abs() >= 1e-8 => model.otf(blur, f),
                Some(_) => [0.0.into(); 3],
                None => [1.0.into(), 0.0.into(), 0.0.into()],
            };
            let parts = [
                value * camera[0],
                by_spread * camera[0],
                by_c * camera[0],
                value * camera[1],
                value * camera[2],
            ];
            for (otf, part) in otf.iter_mut().zip(parts) {
                otf.push(part);
            }
        }
        let [kink, kink_by_spread, kink_by_c] =
            model.map_or([0.0; 3], |(model, blur)| model.kink(blur));
        let wanted = [
            (blurs.0, 1, kink_by_spread),
            (blurs.1, 2, kink_by_c),
            (lens > 0, 3, 0.0),
            (lens > 1, 4, 0.0),
        ];
        Curves {
            value: self.grid.even(&otf[0], kink),
            by: wanted
                .into_iter()
                .filter(|&(is, ..)| is)
                .map(|(_, part, kink)| self.grid.even(&otf[part], kink))
                .collect(),
        }
    }

    /// Returns the terms of uneven light in a bin whose pixels lie at the mean distance `d`.
    fn terms(&self, bin: &Bin, d: f64) -> [Lit; LIGHT] {
        let t = bin.along;
        // Share for the covariance of t with a curve, which follows from the curve's slope along
        // the edge.
        let share = bin.spread / bin.count.max(1.0);
        let term = |value: f64, by_t: f64| Lit { value, by_t, share };
        [
            term(d, 0.0),
            term(t, 1.0),
            term(d * d, 0.0),
            term(d * t, d),
            term(t * t + share - self.pixels.square_along, 2.0 * t),
        ]
    }

    /// Returns the light of a bin, 1 where it is even.
    fn lit(&self, bin: &Bin, d: f64, light: &[f64; LIGHT]) -> Lit {
        let even = Lit {
            value: 1.0,
            by_t: 0.0,
            share: bin.spread / bin.count.max(1.0),
        };
        let terms = self.terms(bin, d);
        terms.iter().zip(light).fold(even, |sum, (term, c)| Lit {
            value: sum.value + c * term.value,
            by_t: sum.by_t + c * term.by_t,
            ..sum
        })
    }

    /// Finds noise, weights and nuisances under a model that is near the truth.
    ///
    /// Noise and light depend on each other only a little, so two rounds are enough. If noise is
    /// cut off, the plateau moves with the noise, and each round leaves about a tenth of
    /// the remaining error. Then five rounds are made.
    pub(crate) fn settle(&mut self, curves: &Curves) {
        let rounds = if self.pixels.cut.is_any() { 5 } else { 2 };
        self.start = self.first_guess(curves);
        self.start.lit = self.lit_prior()[0];
        let squares = self.settled(curves, rounds);
        if self.is_uneven(curves, squares) {
            self.settled(curves, rounds);
        }
        self.weigh(curves);
    }

    /// Makes rounds of noise and nuisances. Returns the sum of squares that no parameter explains.
    fn settled(&mut self, curves: &Curves, rounds: usize) -> f64 {
        let mut squares = 0.0;
        for _ in 0..rounds {
            self.weigh(curves);
            let fitted = self.fit(curves);
            self.start = fitted.nuisances;
            self.dark = self.start.dark;
            squares = unexplained(&fitted);
        }
        squares
    }

    /// Adds the light's terms of second order if the pixels ask for them, with the blur free.
    fn is_uneven(&mut self, curves: &Curves, squares: f64) -> bool {
        self.light_terms = LIGHT;
        let all = unexplained(&self.fit(curves));
        let freedom = self.observations().saturating_sub(NUISANCES).max(1) as f64;
        let is = squares - all > UNEVEN * (all / freedom).max(1.0);
        if !is {
            self.light_terms = FIRST_ORDER;
        }
        is
    }

    /// Estimates all terms of the light, whether the pixels ask for them or not.
    #[cfg(test)]
    pub(crate) fn estimate_all_light(&mut self) {
        self.light_terms = LIGHT;
    }

    /// Returns the number of nuisances that the pixels alone determine. The lit part of the dark
    /// plateau has its prior.
    pub(crate) fn nuisances(&self) -> usize {
        NUISANCES - 1 - LIGHT + self.light_terms
    }

    /// Returns mean and standard deviation of the lit part of the dark plateau, of which nothing is
    /// known but that it lies between 0 and the plateau.
    fn lit_prior(&self) -> [f64; 2] {
        let dark = self.dark.max(0.0);
        let least = 1e-6 * self.start.step.abs() + f64::MIN_POSITIVE;
        [0.5 * dark, (dark / 12.0_f64.sqrt()).max(least)]
    }

    /// Replaces the noise by a known one, as bounds at a planted truth need it.
    pub(crate) fn with_noise(&mut self, curves: &Curves, noise: PixelNoise) {
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
        for (j, bin) in self.pixels.bins.iter().enumerate() {
            let unit = Place::new(bin, self.pixels.first + j as i64, [guess.place_px, 0.0])
                .of(&curves.value)[0];
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
    fn light(&self, curves: &Curves) -> Vec<[f64; 2]> {
        let start = &self.start;
        let bins = self.pixels.bins.iter().enumerate();
        bins.map(|(j, bin)| {
            let place = Place::new(bin, self.pixels.first + j as i64, start.line());
            let lit = self.lit(bin, self.pixels.centre_px(j), &start.light);
            let [unit, _, across, _] = place.of(&curves.value);
            [
                start.dark + start.lit * (lit.value - 1.0) + start.step * lit.value * unit,
                start.step * lit.value * across,
            ]
        })
        .collect()
    }

    fn weigh(&mut self, curves: &Curves) {
        let light = self.light(curves);
        // Degrees of freedom, light, and variance of the pixels about the model's slope, for each
        // bin.
        let bins = self.pixels.bins.iter().zip(&light);
        let scatter: Vec<[f64; 3]> = bins
            .filter(|(bin, _)| bin.count >= 2.0)
            .map(|(bin, &[light, across])| {
                let [yy, yu, uu] = bin.scatter;
                let squares = (yy - 2.0 * across * yu + across * across * uu).max(0.0);
                [bin.count - 1.0, light, squares / (bin.count - 1.0)]
            })
            .collect();
        // The floor lies far below the noise of any sensor. It avoids a division by zero for
        // noise-free pictures.
        let floor = 1e-12 * self.start.step.powi(2) + f64::MIN_POSITIVE;
        self.noise = PixelNoise::most_likely(&scatter, self.pixels.cut, floor);
        self.set_weights(&light);
    }

    fn set_weights(&mut self, light: &[[f64; 2]]) {
        let model_error = (MODEL_ERROR * self.start.step).powi(2);
        let bins = self.pixels.bins.iter().zip(light);
        self.weights = bins
            .map(|(bin, &[light, _])| {
                if bin.count == 0.0 {
                    return Weight::default();
                }
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

    /// Moves the nuisances to their optimum under a model, by Gauss-Newton steps from the start.
    /// The start is so near that the problem is almost linear.
    pub(crate) fn fit(&self, curves: &Curves) -> Fitted {
        const MOST: usize = 12;
        let mut nuisances = self.start;
        let columns = NUISANCES + curves.by.len();
        let mut fitted = self.normal(curves, nuisances);
        for _ in 0..MOST {
            let rest = fitted.factor.column(columns);
            let squares = rest.norm_squared();
            let fall = rest.rows(0, NUISANCES).norm_squared();
            // Decrease of chi-square that this step promises.
            if fall < 1e-8 + 1e-13 * squares || !fall.is_finite() {
                break;
            }
            let step = factor::back_substituted(&fitted.factor, NUISANCES, columns);
            nuisances = nuisances.moved(&step);
            fitted = self.normal(curves, nuisances);
        }
        fitted
    }

    fn normal(&self, curves: &Curves, nuisances: Nuisances) -> Fitted {
        let size = NUISANCES + curves.by.len() + 1;
        let mut normal = Products::new(size);
        self.rows(curves, &nuisances, |row| normal.add(row));
        Fitted {
            factor: factor::of(normal.sum()),
            nuisances,
        }
    }

    /// Passes the weighted rows of all bins to `take`: first the row of a bin's mean, then that of
    /// its slope along the edge.
    ///
    /// The columns of a row are the derivatives by the nuisances, those by the curves' parameters,
    /// and the residual (model - data).
    pub(crate) fn rows(&self, curves: &Curves, at: &Nuisances, mut take: impl FnMut(&[f64])) {
        let size = NUISANCES + curves.by.len() + 1;
        let (mut mean, mut slope) = (vec![0.0; size], vec![0.0; size]);
        for (j, (bin, weight)) in self.pixels.bins.iter().zip(&self.weights).enumerate() {
            if weight.root[0] == 0.0 {
                continue;
            }
            let place = Place::new(bin, self.pixels.first + j as i64, at.line());
            let d = self.pixels.centre_px(j) + bin.across[0];
            let lit = self.lit(bin, d, &at.light);
            let of_mean = |curve: [f64; 4]| lit.mean(curve);
            let of_slope = |curve: [f64; 4]| lit.slope(curve);
            let unit = place.of(&curves.value);
            let [_, _, across, bend] = unit;
            let unlit = lit.value - 1.0;
            let expected = at.dark + at.lit * unlit + at.step * of_mean(unit);
            let (expected, passed, _) = self.pixels.cut.clipped(expected, weight.sigma);
            let [m, s] = weight.root.map(|root| root * passed);
            let (step_m, step_s) = (at.step * m, at.step * s);
            let by_place = [-across, -bend * place.along[0], 0.0, 0.0];
            let by_turn = place.by_turn(across, bend);
            (mean[0], slope[0]) = (step_m * of_mean(by_place), step_s * of_slope(by_place));
            (mean[1], slope[1]) = (step_m * of_mean(by_turn), step_s * of_slope(by_turn));
            mean[2] = m;
            slope[2] = 0.0;
            let terms = self.terms(bin, d).into_iter();
            for (i, term) in (FIRST_LIGHT..STEP).zip(terms.take(self.light_terms)) {
                mean[i] = step_m * term.mean(unit) + at.lit * m * term.value;
                slope[i] = step_s * term.slope(unit) + at.lit * s * term.by_t;
            }
            (mean[LIT], slope[LIT]) = (m * unlit, s * lit.by_t);
            (mean[STEP], slope[STEP]) = (step_m * of_mean(unit), step_s * of_slope(unit));
            for (i, curve) in (NUISANCES..).zip(&curves.by) {
                let change = place.of(curve);
                (mean[i], slope[i]) = (step_m * of_mean(change), step_s * of_slope(change));
            }
            mean[size - 1] = weight.root[0] * (expected - bin.mean);
            let along = step_s * of_slope(unit) + at.lit * s * lit.by_t;
            slope[size - 1] = along - weight.root[1] * bin.slope;
            take(&mean);
            if weight.root[1] > 0.0 {
                take(&slope);
            }
        }
        let [lit, deviation] = self.lit_prior();
        let mut prior = vec![0.0; size];
        prior[LIT] = 1.0 / deviation;
        prior[size - 1] = (at.lit - lit) / deviation;
        take(&prior);
    }

    /// Returns the factor of a fitted photograph with the full information of pixels that were cut
    /// off. The estimate uses the mean of such pixels alone, which has a little less
    /// information.
    pub(crate) fn information(&self, curves: &Curves, at: &Nuisances) -> DMatrix<f64> {
        let size = NUISANCES + curves.by.len() + 1;
        let mut normal = Products::new(size);
        let gains: Vec<f64> = self
            .light(curves)
            .iter()
            .zip(&self.pixels.bins)
            .zip(&self.weights)
            .filter(|((_, bin), _)| bin.count > 0.0)
            .flat_map(|((&[light, _], bin), weight)| {
                let (_, passed, left) = self.pixels.cut.clipped(light, weight.sigma);
                let used = passed * passed / left;
                let all = self.pixels.cut.information(light, weight.sigma) / weight.sigma.powi(2);
                let gain = if self.pixels.cut.is_any() {
                    (all / used.max(f64::MIN_POSITIVE)).sqrt()
                } else {
                    1.0
                };
                let rows = if bin.spread > 0.0 { 2 } else { 1 };
                std::iter::repeat_n(gain, rows)
            })
            .collect();
        let mut gain = gains.into_iter();
        self.rows(curves, at, |row| {
            let gain = gain.next().unwrap_or(1.0);
            let row: Vec<f64> = row.iter().map(|v| v * gain).collect();
            normal.add(&row);
        });
        factor::of(normal.sum())
    }
}

/// Returns the sum of squares that neither the nuisances nor the curves' parameters explain.
fn unexplained(fitted: &Fitted) -> f64 {
    let last = fitted.factor.ncols() - 1;
    fitted.factor[(last, last)].powi(2)
}

impl Nuisances {
    /// Returns place (pixels) and turn (rad) of the edge.
    fn line(&self) -> [f64; 2] {
        [self.place_px, self.turn_rad]
    }

    fn moved(self, step: &DVector<f64>) -> Nuisances {
        Nuisances {
            // A step from a poor start may be far too long: no edge lies more than a few pixels
            // from its half level.
            place_px: self.place_px - step[0].clamp(-4.0, 4.0),
            turn_rad: self.turn_rad - step[1].clamp(-0.02, 0.02),
            dark: self.dark - step[2],
            light: std::array::from_fn(|i| self.light[i] - step[FIRST_LIGHT + i]),
            lit: self.lit - step[LIT],
            step: self.step * (-step[STEP].clamp(-1.0, 1.0)).exp(),
        }
    }
}
