//! The likelihood of all photographs together. They share blur and lens, and the pixels of the
//! reference count beside those of the photographs of the mid-air edge.

use nalgebra::{DMatrix, DVector, RowDVector};
use rayon::prelude::*;

use crate::compare::{
    Curves, FittedPhotograph, Nuisances, Photograph, Pixels, Remainder, are_uneven,
};
use crate::estimate::scene::Scene;
use crate::estimate::search::compared::model;
use crate::estimate::search::covariance::{Covariances, Mu, Scatter};
use crate::estimate::search::layout::Choice;
use crate::estimate::search::layout::Layout;
use crate::model::{Blur, Camera, Model};
use edges::numerics::Evaluation;
use edges::photographs::PixelNoise;

/// Photographs of a scene with their noise, which is fixed while candidates are compared.
pub struct Joint<'a> {
    scene: &'a Scene,
    shots: Vec<Photograph<'a>>,
    references: Vec<Photograph<'a>>,
    /// Numbers of the lenses that are estimated, such as ln(blur / mm). What is known of them
    /// beforehand counts as numbers beside the pixels.
    lens: DVector<f64>,
}

/// Information whose inverse is the covariance. The variants differ only if pixels were cut off at
/// 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Used {
    /// Information that the estimate uses: of pixels that may be cut off, the mean.
    ByTheEstimate,
    /// All information: the covariance is the Cramer-Rao bound.
    ByAnyEstimate,
}

impl<'a> Joint<'a> {
    /// Finds noise and nuisances of each photograph under the model of `choice` at `parameters`
    /// (logarithms of c and of the spreads), which should be near the truth.
    pub fn new(scene: &'a Scene, choice: Choice, parameters: &DVector<f64>) -> Joint<'a> {
        let camera = &scene.optics.camera;
        let layout = Layout::of(choice, scene);
        let settled = |pixels: &'a Pixels, model: Option<(&Model, Blur)>| {
            let mut photograph = Photograph::new(pixels, camera.pitch_mm);
            let curves = photograph.curves(model, camera, &[]);
            let fall = photograph.settle(&curves);
            (photograph, curves, fall)
        };
        let shots = scene.shots.par_iter().map(|shot| {
            let blur = layout.blur(parameters, shot.place);
            settled(&shot.pixels, Some((&model(shot, choice), blur)))
        });
        let mut all: Vec<(Photograph, Curves, f64)> = shots.collect();
        let references = scene.reference.iter().flat_map(|own| &own.photographs);
        all.extend(references.map(|reference| settled(&reference.pixels, None)));
        let falls: Vec<f64> = all.iter().map(|(_, _, fall)| *fall).collect();
        if are_uneven(&falls) {
            all.par_iter_mut()
                .for_each(|(photograph, curves, _)| photograph.settle_unevenly(curves));
        }
        let mut photographs = all.into_iter().map(|(photograph, ..)| photograph);
        let shots = photographs.by_ref().take(scene.shots.len()).collect();
        let references = photographs.collect();
        Joint {
            scene,
            shots,
            references,
            lens: scene.optics.lens.clone(),
        }
    }

    /// Returns the same photographs, with their noise and their light as they are here, in another
    /// scene.
    pub(crate) fn in_scene<'b>(&self, scene: &'b Scene) -> Joint<'b>
    where
        'a: 'b,
    {
        Joint {
            scene,
            shots: self.shots.clone(),
            references: self.references.clone(),
            lens: scene.optics.lens.clone(),
        }
    }

    /// Replaces the noise of all photographs by a known one.
    pub fn with_noise(&mut self, choice: Choice, at: &DVector<f64>, noise: PixelNoise) {
        let layout = Layout::of(choice, self.scene);
        let camera = self.camera(&layout, at);
        for (shot, photograph) in self.scene.shots.iter().zip(&mut self.shots) {
            let (model, blur) = (model(shot, choice), layout.blur(at, shot.place));
            let curves = photograph.curves(Some((&model, blur)), &camera, &[]);
            photograph.with_noise(&curves, noise);
        }
        for photograph in &mut self.references {
            let curves = photograph.curves(None, &camera, &[]);
            photograph.with_noise(&curves, noise);
        }
    }

    /// Estimates these terms of the light of each photograph. The noise has to be given anew.
    pub fn estimate_light(&mut self, terms: crate::compare::Terms) {
        let all = self.shots.iter_mut().chain(&mut self.references);
        all.for_each(|photograph| photograph.estimate_light(terms));
    }

    /// Appends the parameters of the lens to those of the blur.
    pub fn start(&self, blur: &DVector<f64>) -> DVector<f64> {
        let all = blur.iter().chain(&self.lens).copied();
        DVector::from_iterator(blur.len() + self.lens.len(), all)
    }

    /// Returns the camera at these parameters.
    pub fn camera(&self, layout: &Layout, at: &DVector<f64>) -> Camera {
        let lens = at.rows(layout.parameters(), self.lens.len()).into_owned();
        self.scene.optics.at(&lens)
    }

    /// Returns the number of independent numbers in the photographs, less those of the nuisances
    /// and of the lens.
    pub fn observations(&self) -> usize {
        let of = |p: &Photograph| p.observations().saturating_sub(p.nuisances());
        let all: usize = self.shots.iter().chain(&self.references).map(of).sum();
        let known = self.scene.optics.priors().len();
        (all + known).saturating_sub(self.lens.len())
    }

    /// Evaluates residuals and derivatives at a point, with the nuisances at their optimum. Each
    /// photograph has only a few rows, whose products equal those of all its pixels.
    ///
    /// The search for the nuisances begins with those in `near`, of an evaluation at a point near
    /// this one, and leaves the new ones there. If there are none, it begins with the photographs'
    /// own.
    pub fn evaluate(
        &self,
        layout: &Layout,
        at: &DVector<f64>,
        near: &mut Vec<Nuisances>,
    ) -> Evaluation {
        let fitted = self.fitted_from(layout, at, near);
        *near = fitted.iter().map(|(fitted, _)| fitted.nuisances).collect();
        // The rows of a factor below those of the nuisances, and its columns behind theirs.
        let factors: Vec<DMatrix<f64>> = fitted
            .into_iter()
            .map(|(fitted, _)| without(&fitted.factor, fitted.columns))
            .collect();
        let width = layout.parameters() + self.lens.len();
        let priors = self.scene.optics.priors();
        let rows: usize = factors.iter().map(|f| f.nrows()).sum();
        let rows = rows + priors.len();
        let (mut residuals, mut jacobian) = (DVector::zeros(rows), DMatrix::zeros(rows, width));
        let mut row = 0;
        for (i, factor) in factors.iter().enumerate() {
            let (n, last) = (factor.nrows(), factor.ncols() - 1);
            residuals.rows_mut(row, n).copy_from(&factor.column(last));
            for (k, column) in self.columns(layout, i).into_iter().enumerate() {
                jacobian
                    .view_mut((row, column), (n, 1))
                    .copy_from(&factor.column(k));
            }
            row += n;
        }
        for (row, (index, [mean, deviation])) in (row..).zip(priors) {
            let column = layout.parameters() + index;
            residuals[row] = (at[column] - mean) / deviation;
            jacobian[(row, column)] = 1.0 / deviation;
        }
        (residuals, jacobian)
    }

    /// Moves the nuisances of each photograph to their optimum. Returns the photographs, the
    /// reference last, with the curves to which they were fitted.
    fn fitted(&self, layout: &Layout, at: &DVector<f64>) -> Vec<(FittedPhotograph, Curves)> {
        self.fitted_from(layout, at, &[])
    }

    /// Does what [`Joint::fitted`] does from the nuisances `near` of another point, if there are
    /// any.
    fn fitted_from(
        &self,
        layout: &Layout,
        at: &DVector<f64>,
        near: &[Nuisances],
    ) -> Vec<(FittedPhotograph, Curves)> {
        let camera = self.camera(layout, at);
        let lens = &self.scene.optics.free;
        let shots = self.scene.shots.iter().map(Some);
        let models = shots.chain(std::iter::repeat(None));
        let photographs = self.shots.iter().chain(&self.references);
        let all: Vec<_> = photographs.zip(models).enumerate().collect();
        all.into_par_iter()
            .map(|(i, (photograph, shot))| {
                let model = shot.map(|shot| model(shot, layout.choice));
                let blur = shot.map(|shot| layout.blur(at, shot.place));
                let curves = photograph.curves(model.as_ref().zip(blur), &camera, lens);
                let fitted = match near.get(i) {
                    Some(&near) => photograph.fit_from(&curves, near),
                    None => photograph.fit(&curves),
                };
                (fitted, curves)
            })
            .collect()
    }

    /// Returns what the model leaves of each photograph, the reference last.
    pub(crate) fn remainders(&self, layout: &Layout, at: &DVector<f64>) -> Vec<Remainder> {
        let photographs = self.shots.iter().chain(&self.references);
        let fitted = self.fitted(layout, at);
        let all = photographs.zip(&fitted);
        all.map(|(photograph, (fitted, curves))| photograph.remainder(curves, fitted))
            .collect()
    }

    /// Evaluates the residuals of each photograph and their derivatives by all parameters, the
    /// reference last.
    pub(crate) fn parts(&self, layout: &Layout, at: &DVector<f64>) -> Vec<Evaluation> {
        let fitted = self.fitted(layout, at).into_iter().enumerate();
        let parts = fitted.map(|(i, (fitted, _))| self.part(layout, i, &fitted));
        parts.collect()
    }

    /// Evaluates the residuals of both halves of photograph `i` and their derivatives by all
    /// parameters. Each half has place, angle, plateaus and light of its own.
    pub(crate) fn halves(&self, layout: &Layout, at: &DVector<f64>, i: usize) -> [Evaluation; 2] {
        let (fitted, curves) = &self.fitted(layout, at)[i];
        let halves = self.shots[i].halves(curves, fitted);
        halves.map(|half| self.part(layout, i, &half))
    }

    fn part(&self, layout: &Layout, i: usize, fitted: &FittedPhotograph) -> Evaluation {
        let width = layout.parameters() + self.lens.len();
        let factor = without(&fitted.factor, fitted.columns);
        let mut jacobian = DMatrix::zeros(factor.nrows(), width);
        for (k, column) in self.columns(layout, i).into_iter().enumerate() {
            jacobian.set_column(column, &factor.column(k));
        }
        (factor.column(factor.ncols() - 1).into_owned(), jacobian)
    }

    /// Returns the columns of the derivatives of photograph `i`. The reference is the last
    /// photograph.
    fn columns(&self, layout: &Layout, i: usize) -> Vec<usize> {
        let lens = layout.parameters()..layout.parameters() + self.lens.len();
        let blur = self
            .scene
            .shots
            .get(i)
            .map(|shot| layout.columns(shot.place));
        blur.into_iter().flatten().chain(lens).collect()
    }

    /// Computes the covariance of the estimates, and mu, at an optimum. The covariance is the
    /// inverse Fisher information of the pixels.
    ///
    /// For c and the spreads each photograph has its own plateaus, so a wrong exposure cannot bias
    /// them. For mu the steps of all photographs are tied to that of the reference by exposure and
    /// retroreflected share. mu is where these steps are most likely: generalised least squares on
    /// the same pixels. Its covariance includes the error by the table's rays, as one error for
    /// each incidence.
    pub fn information(&self, layout: &Layout, at: &DVector<f64>, used: Used) -> Covariances {
        let fitted = self.fitted(layout, at);
        let photographs: Vec<&Photograph> = self.shots.iter().chain(&self.references).collect();
        let steps: Vec<f64> = fitted.iter().map(|(f, _)| f.nuisances.step).collect();
        // The rows are (ln step, derivatives, residual). The other nuisances are taken out.
        let factors: Vec<DMatrix<f64>> = fitted
            .into_iter()
            .zip(photographs)
            .map(|((fitted, curves), photograph)| {
                let factor = if used == Used::ByAnyEstimate {
                    &photograph.information(&curves, &fitted.nuisances)
                } else {
                    &fitted.factor
                };
                without(factor, fitted.columns - 1)
            })
            .collect();
        let p = layout.parameters();
        let width = p + self.lens.len();
        let mut normal = DMatrix::zeros(width, width);
        for (i, factor) in factors.iter().enumerate() {
            let columns = self.columns(layout, i);
            let free = factor.view((1, 1), (factor.nrows() - 1, columns.len()));
            scatter(&mut normal, &columns, &(free.transpose() * free));
        }
        self.add_priors(&mut normal, p);
        layout.expect(&mut normal);
        let blur = inverse(&normal).view((0, 0), (p, p)).into_owned();
        let mu = (!self.references.is_empty()).then(|| self.mu(layout, &factors, &steps, &blur));
        Covariances { blur, mu }
    }

    /// Adds what is known of the lens beforehand to a normal matrix, whose columns of the lens
    /// begin at `first`.
    fn add_priors(&self, normal: &mut DMatrix<f64>, first: usize) {
        for (index, [_, deviation]) in self.scene.optics.priors() {
            normal[(first + index, first + index)] += deviation.powi(-2);
        }
    }

    /// Returns the exposures of all photographs, the references last.
    fn exposures(&self) -> Vec<f64> {
        let references = self.scene.reference.iter().flat_map(|own| &own.photographs);
        let shots = self.scene.shots.iter().map(|shot| shot.exposure);
        shots.chain(references.map(|own| own.exposure)).collect()
    }

    fn mu(
        &self,
        layout: &Layout,
        factors: &[DMatrix<f64>],
        steps: &[f64],
        blur: &DMatrix<f64>,
    ) -> Mu {
        let scene = self.scene;
        let (p, own) = (layout.parameters(), layout.choice.per_angle_mu);
        let groups = if own { scene.groups.len() } else { 1 };
        // The columns are blur, lens, ln mu, and ln step of the reference.
        let first = p + self.lens.len();
        let width = first + groups + 1;
        let reference_step = steps[scene.shots.len()].ln();
        let exposures = self.exposures();
        let mut normal = DMatrix::zeros(width, width);
        let mut gradient = DVector::zeros(width);
        let mut by_eta = DMatrix::<f64>::zeros(width, scene.groups.len());
        let mut tells = Vec::new();
        for (i, factor) in factors.iter().enumerate() {
            let step = factor.column(0);
            let mut columns = self.columns(layout, i);
            columns.push(width - 1);
            let shot = scene.shots.get(i);
            columns.extend(shot.map(|shot| first + if own { shot.place.group } else { 0 }));
            // Blur and lens enter directly. mu and the reference's step enter through the step of
            // this photograph.
            let blurs = self.columns(layout, i).len();
            let rows = DMatrix::from_fn(factor.nrows(), columns.len(), |r, k| {
                factor[(r, if k < blurs { k + 1 } else { 0 })]
            });
            // For mu = 1, `off` is the difference between the step that follows from the first
            // reference and the photograph's own. Further references have exposures of their own.
            let returned = shot.map(|shot| shot.returned(layout.choice.kernel));
            let light = returned.as_ref().map_or(1.0, |own| own.retroreflected);
            let light = light * shot.map_or(1.0, |_| scene.half_mirror);
            let known = (light * exposures[i] / exposures[scene.shots.len()]).ln();
            let off = known + reference_step - steps[i].ln();
            let pull = rows.tr_mul(&(step * off));
            for (k, &column) in columns.iter().enumerate() {
                gradient[column] += pull[k];
            }
            if let (Some(shot), Some(returned)) = (shot, returned) {
                let of_eta = rows.tr_mul(&step) * returned.relative_error();
                for (k, &column) in columns.iter().enumerate() {
                    by_eta[(column, shot.place.group)] += of_eta[k];
                }
                tells.push(LightInformation {
                    step: factor[(0, 0)],
                    of_eta: returned.relative_error(),
                    off,
                    rows: rows.row(0).into_owned(),
                    columns: columns.clone(),
                });
            }
            scatter(&mut normal, &columns, &rows.tr_mul(&rows));
        }
        self.add_priors(&mut normal, p);
        layout.expect(&mut normal);
        let tied = inverse(&normal);
        let solution = -(&tied * gradient);
        let ln_mu = solution.rows(first, groups).into_owned();
        let scatter = Scatter {
            each: tells.iter().map(|own| own.left(&solution)).collect(),
            freedom: tells.len().saturating_sub(groups),
        };
        let values = ln_mu.iter().map(|v| v.exp()).collect();
        let rays = &tied * by_eta;
        let mut covariance = DMatrix::zeros(p + groups, p + groups);
        covariance.view_mut((0, 0), (p, p)).copy_from(blur);
        let place = |k: usize| if k < p { k } else { first + k - p };
        for i in 0..p + groups {
            for j in p.max(i)..p + groups {
                let (a, b) = (place(i), place(j));
                let mut value = tied[(a, b)];
                if i >= p {
                    value += rays.row(a).dot(&rays.row(b));
                }
                covariance[(i, j)] = value;
                covariance[(j, i)] = value;
            }
        }
        Mu {
            values,
            covariance,
            scatter,
        }
    }
}

/// Information of one photograph on its light.
struct LightInformation {
    /// Square root of the information on ln step.
    step: f64,
    /// Relative error of the table's retroreflected share.
    of_eta: f64,
    /// Difference of ln step for mu = 1.
    off: f64,
    /// Derivatives of the difference, in units of the noise.
    rows: RowDVector<f64>,
    /// Columns of these derivatives.
    columns: Vec<usize>,
}

impl LightInformation {
    /// Returns the difference between the light of the photograph and that of a solution, in units
    /// of its noise; positive if the photograph has more.
    fn left(&self, solution: &DVector<f64>) -> f64 {
        let pairs = self.columns.iter().zip(self.rows.iter());
        let moved: f64 = pairs.map(|(&column, v)| v * solution[column]).sum();
        let noise = 1.0_f64.hypot(self.step * self.of_eta);
        -(moved + self.step * self.off) / noise
    }
}

/// Returns a triangular factor without its first `count` unknowns, which are projected out.
pub(crate) fn without(factor: &DMatrix<f64>, count: usize) -> DMatrix<f64> {
    let left = factor.nrows() - count;
    factor.view((count, count), (left, left)).into_owned()
}

/// Adds a small matrix to the rows and columns of `normal` that `columns` names.
fn scatter(normal: &mut DMatrix<f64>, columns: &[usize], part: &DMatrix<f64>) {
    for (i, &a) in columns.iter().enumerate() {
        for (j, &b) in columns.iter().enumerate() {
            normal[(a, b)] += part[(i, j)];
        }
    }
}

/// Inverts a normal matrix. The variances are infinite if the photographs do not determine all
/// parameters.
fn inverse(normal: &DMatrix<f64>) -> DMatrix<f64> {
    let n = normal.nrows();
    normal
        .clone()
        .try_inverse()
        .filter(|i| i.iter().all(|v| v.is_finite()))
        .unwrap_or_else(|| DMatrix::from_diagonal_element(n, n, f64::INFINITY))
}
