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
//! it off at 0 or at full scale, the mean and the variance after the cut are used.
//!
//! Position and angle of the edge, both plateaus and the light are nuisances of each photograph.
//! For each trial blur they are set to their optimum and projected out (variable projection). What
//! remains is a function of blur and lens alone.

mod noise;
mod nuisances;
mod rows;

pub use nuisances::Nuisances;

use nalgebra::DMatrix;
use num_complex::Complex64;

use crate::compare::light;
use crate::compare::light::{LIGHT, Lights, Terms, Uneven};
use crate::compare::likelihood::noise::Weight;
use crate::compare::likelihood::nuisances::{FIRST_LIGHT, anywhere};
use crate::compare::pixels::{Bin, Pixels};
use crate::model::Blur;
use crate::model::Camera;
use crate::model::Model;
use crate::model::{Even, Grid};
use edges::numerics::factor;
use edges::numerics::factor::Products;
use edges::photographs::PixelNoise;
use edges::photographs::edge::line::{Bend, ORDERS};

/// Edge profile of a trial model, with its derivatives by the fitted parameters: ln spread, ln c,
/// the variances of further blurs, then those of the lens.
#[derive(Clone)]
pub struct Curves {
    value: Even,
    by: Vec<Even>,
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

/// Pixels of a photograph with their noise and their weights.
#[derive(Clone)]
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
        let wanted = model.map_or_else(Vec::new, |(model, blur)| model.wanted(blur).collect());
        let n = self.grid.frequencies_per_mm().len();
        // OTF and its derivatives by the blur, and by the numbers of the lens.
        let mut otf = Vec::with_capacity(n);
        let mut by_blur = vec![Vec::with_capacity(n); wanted.len()];
        let mut by_lens = vec![Vec::with_capacity(n); lens.len()];
        let mut slopes = vec![0.0; camera.numbers()];
        let camera = camera.along(normal_rad);
        for f in self.grid.frequencies_per_mm() {
            let seen = if lens.is_empty() {
                camera.otf(f)
            } else {
                camera.otf_and_slopes(f, &mut slopes)
            };
            let parts = match model {
                Some((model, blur)) if seen.abs() >= 1e-8 => model.parts(blur, f),
                Some(_) => [Complex64::ZERO; 8],
                None => [Complex64::ONE; 8],
            };
            otf.push(parts[0] * seen);
            for (otf, &(part, _)) in by_blur.iter_mut().zip(&wanted) {
                otf.push(parts[part] * seen);
            }
            for (otf, &number) in by_lens.iter_mut().zip(lens) {
                otf.push(parts[0] * slopes[number]);
            }
        }
        let kink = model.map_or(0.0, |(model, blur)| model.kink(blur)[0]);
        let by_blur = by_blur.iter().zip(&wanted);
        let by_blur = by_blur.map(|(otf, &(_, kink))| self.grid.even(otf, kink));
        let by_lens = by_lens.iter().map(|otf| self.grid.even(otf, 0.0));
        Curves {
            value: self.grid.even(&otf, kink),
            by: by_blur.chain(by_lens).collect(),
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
        // Fall, in units of the misfit, below which a step is left out: nuisances are then within a
        // hundredth of their standard errors. The curves' parameters move by far less, because the
        // linear part of the nuisances is projected out.
        const LEAST: f64 = 1e-4;
        let least = LEAST / self.observations().max(1) as f64;
        let own = self.step_column() + 1;
        let columns = own + curves.by.len();
        let chi2 = |fitted: &FittedPhotograph| fitted.factor.column(columns).norm_squared();
        let mut fitted = self.normal(curves, start);
        let mut damping = 0.0;
        for _ in 0..MOST {
            let squares = chi2(&fitted);
            // Decrease of chi-square that a step without damping promises.
            let fall = fitted.factor.view((0, columns), (own, 1)).norm_squared();
            if fall < 1e-8 + least * squares || !fall.is_finite() {
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
}

impl FittedPhotograph {
    /// Returns the sum of squares that neither the nuisances nor the curves' parameters explain.
    fn unexplained(&self) -> f64 {
        let last = self.factor.ncols() - 1;
        self.factor[(last, last)].powi(2)
    }
}

impl Curves {
    /// Returns these curves with those of a rival model behind them: its derivatives, and as the last
    /// one the difference between the two (rival less this).
    pub fn beside(&self, rival: Curves) -> Curves {
        let difference = rival.value.less(&self.value);
        let mut both = self.clone();
        both.by.extend(rival.by);
        both.by.push(difference);
        both
    }

    /// Returns the moments of the value and of its derivatives, see [`Even::moment`].
    fn moments(&self, reach: usize) -> Vec<Even> {
        let all = std::iter::once(&self.value).chain(&self.by);
        all.map(|curve| curve.moment(reach)).collect()
    }
}
