//! The likelihood of one photograph's pixels under an edge profile.
//!
//! A pixel at distance d from the edge, and t along it, has the expected light
//!
//! ```text
//! dark + lit (L - 1) + step (L E(d) + lamp g M(d))
//! ```
//!
//! E is the unit edge through blur and camera. L is the unevenness of the light, see
//! [`light`](crate::compare::light). It multiplies the light of the edge, and the part of the dark
//! plateau that is light of the same lamp. The rest is a veil or the camera's offset. The lit part
//! may be anything between nothing and all of the dark plateau.
//!
//! Unevenness of the camera multiplies the blurred edge. Unevenness of the lamp is blurred with the
//! edge, which adds g M(d). g is the slope of L across the edge, and M is the first moment of the
//! line spread up to d, with its sign changed. `lamp` is the share of the lamp: anything between 0
//! and 1. Where the shape of the edge does not tell, its prior keeps the difference in the errors.
//! The priors have the mean and the deviation of their ranges.
//!
//! Where the light is even, L has its terms of first order alone, and neither `lit` nor `lamp` is
//! estimated.
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
use num_complex::Complex64;
use std::f64::consts::FRAC_1_SQRT_2;

use crate::compare::light;
use crate::compare::light::{LIGHT, Lights, Terms, UNIT_PX, Uneven};
use crate::compare::pixels::{Bin, Pixels};
use crate::compare::place::Place;
use crate::compare::remainder::{Remainder, Sums};
use crate::compare::view::{MODEL_ERROR, by_variance};
use crate::model::Blur;
use crate::model::Camera;
use crate::model::Model;
use crate::model::{Even, Grid};
use edges::numerics::factor;
use edges::numerics::factor::Products;
use edges::photographs::BIN_PX;
use edges::photographs::PixelNoise;
use edges::photographs::edge::line::{Bend, ORDERS};

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
const FIRST_LIGHT: usize = 3;

/// Standard deviation of each order of the curve before the pixels are seen, pixels. The search of
/// the edge leaves 0.1 to 0.4 px in uneven light. High orders look alike in the four strips, so
/// without a limit their steps run away where the noise is strong.
const BEND_PX: f64 = 0.5;

/// Edge profile of a trial model, with its derivatives by the fitted parameters: ln spread, ln c,
/// the variances of further blurs, then those of the lens.
pub struct Curves {
    value: Even,
    by: Vec<Even>,
}

/// Returns mean and standard deviation of a number that may lie anywhere between 0 and `most`.
fn anywhere(most: f64) -> [f64; 2] {
    [0.5 * most, most / 12.0_f64.sqrt()]
}

/// Photograph with its nuisances at their optimum.
pub struct FittedPhotograph {
    /// Upper triangular R, where R^T R is the weighted normal matrix of (nuisances, derivatives,
    /// residual).
    pub factor: DMatrix<f64>,
    /// Nuisances at the optimum.
    pub nuisances: Nuisances,
    /// Number of columns of the nuisances. The last is that of ln(step).
    pub columns: usize,
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
pub struct Photograph<'a> {
    /// Pixels of the photograph, by bins.
    pub pixels: &'a Pixels,
    /// Noise of the pixels.
    pub noise: PixelNoise,
    terms: Terms,
    /// Bins that are compared: those of the pixels, or their strips where the light is uneven.
    bins: &'a [Bin],
    /// Dark plateau of the last round, which sets the prior of its lit part.
    dark: f64,
    grid: Grid,
    weights: Vec<Weight>,
    start: Nuisances,
}

impl<'a> Photograph<'a> {
    /// Prepares a photograph of which only the pixels are known. [`Photograph::settle`] finds the
    /// rest.
    pub fn new(pixels: &'a Pixels, pitch_mm: f64) -> Photograph<'a> {
        Photograph {
            pixels,
            noise: PixelNoise {
                read: 1.0,
                gain: 0.0,
            },
            terms: Terms::First,
            bins: &pixels.bins,
            dark: 0.0,
            grid: Grid::new(2 * pixels.reach() + 1, pitch_mm),
            weights: Vec::new(),
            start: Nuisances {
                place_px: 0.0,
                turn_rad: 0.0,
                bend_px: [0.0; ORDERS - 1],
                dark: 0.0,
                light: [0.0; LIGHT],
                lit: 0.0,
                lamp: anywhere(1.0)[0],
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
    /// profile is that of the source edge itself. Derivatives by the lens are those by these numbers
    /// of the camera's lenses, see [`Camera::numbers`].
    pub fn curves(&self, model: Option<(&Model, Blur)>, camera: &Camera, lens: &[usize]) -> Curves {
        let normal_rad = self.pixels.line.normal_rad;
        let blurs = model.map_or((false, false), |(model, _)| {
            (model.kernel.has_lobe(), model.kernel.has_c())
        });
        let n = self.grid.frequencies_per_mm().len();
        // OTF and its derivatives by ln spread, ln c, and the numbers of the lens.
        let mut otf = [const { Vec::new() }; 3];
        let mut by_lens: Vec<Vec<Complex64>> = vec![Vec::new(); lens.len()];
        for part in otf.iter_mut().chain(&mut by_lens) {
            part.reserve(n);
        }
        let mut slopes = vec![0.0; camera.numbers()];
        let camera = camera.along(normal_rad);
        for f in self.grid.frequencies_per_mm() {
            let seen = if lens.is_empty() {
                camera.otf(f)
            } else {
                camera.otf_and_slopes(f, &mut slopes)
            };
            let [value, by_spread, by_c] = match model {
                Some((model, blur)) if seen.abs() >= 1e-8 => model.otf(blur, f),
                Some(_) => [0.0.into(); 3],
                None => [1.0.into(), 0.0.into(), 0.0.into()],
            };
            for (otf, part) in otf.iter_mut().zip([value, by_spread, by_c]) {
                otf.push(part * seen);
            }
            for (otf, &number) in by_lens.iter_mut().zip(lens) {
                otf.push(value * slopes[number]);
            }
        }
        let [kink, kink_by_spread, kink_by_c] =
            model.map_or([0.0; 3], |(model, blur)| model.kink(blur));
        let wanted = [(blurs.0, 1, kink_by_spread), (blurs.1, 2, kink_by_c)];
        let wanted = wanted.into_iter().filter(|&(is, ..)| is);
        let by_blur = wanted.map(|(_, part, kink)| self.grid.even(&otf[part], kink));
        // A Gaussian factor does not change the kink at frequency 0.
        let slopes = model
            .into_iter()
            .flat_map(|(model, _)| model.variance_slopes());
        let further = slopes.map(|by| self.grid.even(&by_variance(&self.grid, &otf[0], by), 0.0));
        let by_lens = by_lens.iter().map(|otf| self.grid.even(otf, 0.0));
        Curves {
            value: self.grid.even(&otf[0], kink),
            by: by_blur.chain(further).chain(by_lens).collect(),
        }
    }

    /// Finds noise, weights and nuisances under a model that is near the truth, in even light.
    /// Returns the fall of chi-square by uneven light, see [`light::are_uneven`].
    pub fn settle(&mut self, curves: &Curves) -> f64 {
        self.settle_evenly(curves);
        let fall = self.unevenness(curves);
        self.weigh(curves);
        fall
    }

    /// Does the same where the light is known to be even.
    pub fn settle_evenly(&mut self, curves: &Curves) {
        self.start = self.first_guess(curves);
        self.make_rounds(curves);
        self.weigh(curves);
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

    /// Estimates these terms of the light from now on.
    fn take(&mut self, terms: Terms) {
        self.terms = terms;
        self.bins = match terms {
            Terms::First => &self.pixels.bins,
            Terms::None | Terms::Second | Terms::All => &self.pixels.strips,
        };
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
            unexplained(&self.normal(curves, self.start))
        });
        let freedom = self.observations().saturating_sub(self.nuisances());
        self.take(before);
        self.start = settled;
        (few - all) / (all / freedom.max(1) as f64).max(1.0)
    }

    /// Estimates these terms of the light, whether the pixels ask for them or not. The noise has to
    /// be given anew.
    pub fn estimate_light(&mut self, terms: Terms) {
        self.take(terms);
    }

    /// Returns the number of nuisances that the pixels alone determine. The orders of the curve,
    /// the lit part of the dark plateau and the share of the lamp have priors.
    pub(crate) fn nuisances(&self) -> usize {
        FIRST_LIGHT + self.terms.light() + 1
    }

    /// Returns the number of the curve's orders that are estimated.
    ///
    /// In even light a wrong curve does not touch the blur to first order. In uneven light a bow
    /// and the light look alike, and so each takes a part of the other.
    fn bends(&self) -> usize {
        self.curve().map_or(0, |bend| bend.order.saturating_sub(1))
    }

    /// Returns the curve whose orders are estimated.
    fn curve(&self) -> Option<Bend> {
        let bend = self.pixels.line.bend;
        bend.filter(|_| self.terms.free_the_curve())
    }

    /// Returns the column of ln(step), which is the last one of the nuisances. Those of the curve,
    /// of the lit part and of the lamp stand before it, if they are estimated.
    fn step_column(&self) -> usize {
        let priors = if self.terms.are_many() { 2 } else { 0 };
        self.bend_column() + self.bends() + priors
    }

    /// Returns the tangents of the curve's orders at the middle of a bin, see [`Bend::tangents`];
    /// 0 where they are not estimated.
    ///
    /// Within a bin the curve leaves its tangent by a little. Place, turn and the lower orders take
    /// this.
    fn tangents(&self, bin: &Bin) -> [[f64; 2]; ORDERS - 1] {
        let curve = self.curve();
        curve.map_or_else(Default::default, |bend| bend.tangents(bin.along))
    }

    /// Returns mean and standard deviation of the lit part of the dark plateau, of which nothing is
    /// known but that it lies between 0 and the plateau.
    fn lit_prior(&self) -> [f64; 2] {
        let least = 1e-6 * self.start.step.abs() + f64::MIN_POSITIVE;
        let [mean, deviation] = anywhere(self.dark.max(0.0));
        [mean, deviation.max(least)]
    }

    /// Replaces the noise by a known one, as bounds at a planted truth need it.
    pub fn with_noise(&mut self, curves: &Curves, noise: PixelNoise) {
        self.noise = noise;
        let light = self.light(curves);
        self.set_weights(&light);
    }

    /// Returns what a photograph with these places of its pixels would tell: the rows (ln step,
    /// parameters of the curves) of R, where R^T R is the information with the other nuisances
    /// projected out. The values of the pixels have no part in it: the edge lies on the line, and
    /// its dark plateau, its step and the noise are as given, in even light.
    pub fn foreseen(
        mut self,
        curves: &Curves,
        [dark, step]: [f64; 2],
        noise: PixelNoise,
    ) -> DMatrix<f64> {
        (self.start.dark, self.start.step) = (dark, step);
        self.with_noise(curves, noise);
        let own = self.step_column();
        let factor = self.information(curves, &self.start);
        let left = factor.ncols() - 1 - own;
        factor.view((own, own), (left, left)).into_owned()
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
    fn light(&self, curves: &Curves) -> Vec<[f64; 2]> {
        let start = &self.start;
        let bins = self.bins.iter();
        bins.map(|bin| {
            let place = start.place(bin, self.tangents(bin));
            let Lights { all, .. } = self.lights(bin, &start.light);
            let unit @ [_, _, across, _] = place.of(&curves.value);
            [
                start.dark + start.lit * (all.value - 1.0) + start.step * all.mean(unit),
                start.step * all.value * across,
            ]
        })
        .collect()
    }

    /// Returns the light of a bin.
    ///
    /// Uneven light is 1 at the middle of the window, a place that photographs of one camera have
    /// in common. Even light is 1 on the edge, where its terms of first order do not move the step.
    fn lights(&self, bin: &Bin, light: &Uneven) -> Lights {
        let from = if self.terms.are_many() {
            0.0
        } else {
            self.pixels.line.offset_px
        };
        light::of(bin, from, light, self.terms.light())
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
                    let slope = bin.slope - across * bin.cross[0] / bin.spread;
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

    fn set_weights(&mut self, light: &[[f64; 2]]) {
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

    /// Moves the nuisances to their optimum under a model, from the start.
    pub fn fit(&self, curves: &Curves) -> FittedPhotograph {
        self.fit_from(curves, self.start)
    }

    /// Moves the nuisances to their optimum under a model, from those of a model near it.
    ///
    /// Under a model that describes the pixels the problem is almost linear, and steps of
    /// Gauss-Newton lead to the optimum. Under a poor model they may overshoot. Then they are
    /// damped as those of Levenberg and Marquardt.
    pub(crate) fn fit_from(&self, curves: &Curves, start: Nuisances) -> FittedPhotograph {
        const MOST: usize = 12;
        // Damping after the first step that overshoots, and its factor from step to step.
        const FIRST: f64 = 1e-3;
        const FACTOR: f64 = 10.0;
        // Share of the promised fall from which on a step asks for less damping. A step that is
        // damped right reaches about a half, and with less the next one would overshoot again.
        const KEPT: f64 = 0.75;
        // Share by which chi-square may rise: more than rounding, far less than by any overshoot.
        const RISE: f64 = 1e-9;
        let own = self.step_column() + 1;
        let columns = own + curves.by.len();
        let chi2 = |fitted: &FittedPhotograph| fitted.factor.column(columns).norm_squared();
        let mut fitted = self.normal(curves, start);
        let mut damping = 0.0;
        for _ in 0..MOST {
            let squares = chi2(&fitted);
            // Decrease of chi-square that a step without damping promises.
            let fall = fitted.factor.view((0, columns), (own, 1)).norm_squared();
            if fall < 1e-8 + 1e-13 * squares || !fall.is_finite() {
                break;
            }
            let step = factor::damped_step(&fitted.factor, own, columns, damping);
            let next = fitted.nuisances.moved(&step, self.terms, self.bends());
            let tried = self.normal(curves, next);
            let left = chi2(&tried);
            if left <= squares * (1.0 + RISE) {
                fitted = tried;
                if squares - left > KEPT * fall {
                    damping = if damping > FIRST {
                        damping / FACTOR
                    } else {
                        0.0
                    };
                }
            } else {
                damping = (FACTOR * damping).max(FIRST);
            }
        }
        fitted
    }

    fn normal(&self, curves: &Curves, nuisances: Nuisances) -> FittedPhotograph {
        let columns = self.step_column() + 1;
        let mut normal = Products::new(columns + curves.by.len() + 1);
        self.rows(curves, &nuisances, |row| normal.add(row));
        FittedPhotograph {
            factor: factor::of(normal.sum()),
            nuisances,
            columns,
        }
    }

    /// Passes the weighted rows of all bins to `take`: first the row of a bin's mean, then that of
    /// its slope along the edge.
    ///
    /// The columns of a row are the derivatives by the nuisances, those by the curves' parameters,
    /// and the residual (model - data).
    pub fn rows(&self, curves: &Curves, at: &Nuisances, mut take: impl FnMut(&[f64])) {
        let step = self.step_column();
        let size = step + 1 + curves.by.len() + 1;
        let [mut mean, mut slope] = [(); 2].map(|()| vec![0.0; size]);
        let many = self.terms.are_many();
        let moments = many.then(|| curves.moments(self.pixels.reach()));
        let moment = |i: usize, place: &Place| {
            let curves = moments.as_ref();
            curves.map_or([0.0; 4], |moments| place.of(&moments[i]))
        };
        let bends = self.bends();
        let slope_across = at.light[0] / UNIT_PX;
        let of_lamp = at.lamp * slope_across;
        for (bin, weight) in self.bins.iter().zip(&self.weights) {
            let tangents = self.tangents(bin);
            let place = at.place(bin, tangents);
            let lights = self.lights(bin, &at.light);
            // A curve in this light: its mean, and its slope along the edge.
            let lit = |curve: [f64; 4], moment: [f64; 4]| {
                let light = lights.all;
                [
                    light.mean(curve) + of_lamp * moment[0],
                    light.slope(curve) + of_lamp * moment[1],
                ]
            };
            let (unit, bump) = (place.of(&curves.value), moment(0, &place));
            let unlit = [lights.all.value - 1.0, lights.all.by_t];
            let edge = lit(unit, bump);
            let expected = at.dark + at.lit * unlit[0] + at.step * edge[0];
            let (expected, passed, _) = self.pixels.cut.clipped(expected, weight.sigma);
            let weights = weight.root.map(|root| root * passed);
            let mut columns = mean.iter_mut().zip(&mut slope);
            let mut push = |by: [f64; 2], factor: f64| {
                if let Some((mean, slope)) = columns.next() {
                    *mean = by[0] * factor * weights[0];
                    *slope = by[1] * factor * weights[1];
                }
            };
            let by_place = lit(place.by_place(unit), place.by_place(bump));
            let by_turn = lit(place.by_turn(unit), place.by_turn(bump));
            push(by_place, at.step);
            push(by_turn, at.step);
            push([1.0, 0.0], 1.0);
            for (i, by) in lights.by.iter().enumerate().take(self.terms.light()) {
                let lamp = if i == 0 { at.lamp / UNIT_PX } else { 0.0 };
                let of_edge = [
                    by.mean(unit) + lamp * bump[0],
                    by.slope(unit) + lamp * bump[1],
                ];
                let of_dark = [by.value, by.by_t];
                let both = |k: usize| at.step * of_edge[k] + at.lit * of_dark[k];
                push([0, 1].map(both), 1.0);
            }
            for [height, slope] in tangents.into_iter().take(bends) {
                let both = |k: usize| height * by_place[k] - slope * by_turn[k];
                push([0, 1].map(both), at.step);
            }
            if many {
                push(unlit, 1.0);
                push([bump[0], bump[1]], at.step * slope_across);
            }
            push(edge, at.step);
            for (i, curve) in (1..).zip(&curves.by) {
                push(lit(place.of(curve), moment(i, &place)), at.step);
            }
            let along = passed * (at.step * edge[1] + at.lit * unlit[1]);
            mean[size - 1] = weight.root[0] * (expected - bin.mean);
            slope[size - 1] = weight.root[1] * (along - bin.slope);
            take(&mean);
            if weight.root[1] > 0.0 {
                take(&slope);
            }
        }
        let mut row = vec![0.0; size];
        for (column, value, [middle, deviation]) in self.priors(at) {
            row[column] = 1.0 / deviation;
            row[size - 1] = (value - middle) / deviation;
            take(&row);
            row[column] = 0.0;
        }
    }

    /// Returns what is known of the orders of the curve, of the lit part of the dark plateau and of
    /// the share of the lamp, if they are estimated: their column, their value, and the mean and
    /// the standard deviation that they have before the pixels are seen.
    fn priors(&self, at: &Nuisances) -> impl Iterator<Item = (usize, f64, [f64; 2])> {
        let bends = (self.bend_column()..).zip(at.bend_px).take(self.bends());
        let bends = bends.map(|(column, value)| (column, value, [0.0, BEND_PX]));
        let step = self.step_column();
        let shares = self.terms.are_many().then(|| {
            [
                (step - 2, at.lit, self.lit_prior()),
                (step - 1, at.lamp, anywhere(1.0)),
            ]
        });
        bends.chain(shares.into_iter().flatten())
    }

    /// Returns the column of the first order of the curve.
    fn bend_column(&self) -> usize {
        FIRST_LIGHT + self.terms.light()
    }

    /// Returns what a fitted model leaves of the photograph, in units of the noise.
    pub(crate) fn remainder(&self, curves: &Curves, fitted: &FittedPhotograph) -> Remainder {
        let mut rows = Vec::new();
        self.rows(curves, &fitted.nuisances, |row| {
            rows.push(row[row.len() - 1]);
        });
        let (mut rows, mut sums) = (rows.into_iter(), Sums::default());
        for (bin, weight) in self.bins.iter().zip(&self.weights) {
            let mean = rows.next().unwrap_or(0.0);
            let slope = (weight.root[1] > 0.0).then(|| rows.next().unwrap_or(0.0));
            // A strip tells by its mean how the light changes along the edge.
            let along = if self.terms.are_many() {
                Some(mean * bin.along.signum())
            } else {
                slope
            };
            sums.add(bin.number, mean, along);
        }
        let [across, along] = sums.finished();
        let left = fitted.factor.nrows() - fitted.columns;
        let last = fitted.factor.column(fitted.factor.ncols() - 1);
        Remainder {
            squares: last.rows(fitted.columns, left).norm_squared(),
            freedom: self.observations().saturating_sub(self.nuisances()),
            across,
            along,
        }
    }

    /// Returns the two halves of a fitted photograph, along the edge: what each would give alone,
    /// to first order. Priors count half in each.
    pub(crate) fn halves(
        &self,
        curves: &Curves,
        fitted: &FittedPhotograph,
    ) -> [FittedPhotograph; 2] {
        let mut fine = Photograph {
            bins: &self.pixels.strips,
            weights: Vec::new(),
            grid: self.grid.clone(),
            ..*self
        };
        let light = fine.light(curves);
        fine.set_weights(&light);
        let size = fine.step_column() + 1 + curves.by.len() + 1;
        let mut halves = [(); 2].map(|()| Products::new(size));
        let of_bins = fine
            .bins
            .iter()
            .zip(&fine.weights)
            .flat_map(|(bin, weight)| {
                let rows = if weight.root[1] > 0.0 { 2 } else { 1 };
                std::iter::repeat_n(usize::from(bin.along > 0.0), rows)
            });
        let mut half = of_bins.collect::<Vec<usize>>().into_iter();
        fine.rows(curves, &fitted.nuisances, |row| match half.next() {
            Some(half) => halves[half].add(row),
            None => {
                let row: Vec<f64> = row.iter().map(|v| v * FRAC_1_SQRT_2).collect();
                halves.iter_mut().for_each(|half| half.add(&row));
            }
        });
        halves.map(|half| FittedPhotograph {
            factor: factor::of(half.sum()),
            ..*fitted
        })
    }

    /// Returns the factor of a fitted photograph with the full information of pixels that were cut
    /// off. The estimate uses the mean of such pixels alone, which has a little less
    /// information.
    pub(crate) fn information(&self, curves: &Curves, at: &Nuisances) -> DMatrix<f64> {
        let size = self.step_column() + 1 + curves.by.len() + 1;
        let mut normal = Products::new(size);
        let gains: Vec<f64> = self
            .light(curves)
            .iter()
            .zip(self.bins)
            .zip(&self.weights)
            .flat_map(|((&[light, _], bin), weight)| {
                let (_, passed, left) = self.pixels.cut.clipped(light, weight.sigma);
                let used = passed * passed / left;
                let all = self.pixels.cut.information(light, weight.sigma) / weight.sigma.powi(2);
                let gain = (all / used.max(f64::MIN_POSITIVE)).sqrt();
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
fn unexplained(fitted: &FittedPhotograph) -> f64 {
    let last = fitted.factor.ncols() - 1;
    fitted.factor[(last, last)].powi(2)
}

impl Nuisances {
    /// Locates the pixels of a bin in the edge profile. `tangents` are those of the curve's orders.
    fn place(&self, bin: &Bin, tangents: [[f64; 2]; ORDERS - 1]) -> Place {
        let mut line = [self.place_px, self.turn_rad];
        for (term, [height, slope]) in self.bend_px.iter().zip(tangents) {
            line[0] += term * height;
            line[1] -= term * slope;
        }
        Place::new(bin, line)
    }

    /// Returns the nuisances after a step, whose last entry is that of ln(step).
    fn moved(self, step: &DVector<f64>, terms: Terms, bends: usize) -> Nuisances {
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

impl Curves {
    /// Returns the moments of the value and of its derivatives, see [`Even::moment`].
    fn moments(&self, reach: usize) -> Vec<Even> {
        let all = std::iter::once(&self.value).chain(&self.by);
        all.map(|curve| curve.moment(reach)).collect()
    }
}
