//! One photograph made ready for comparison with models: its profile, its estimator, and everything of the model that
//! the parameters do not change.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use num_complex::Complex64;

use crate::model::baseline::Baseline;
use crate::model::camera::Camera;
use crate::model::kernel::{Blur, Kernel};
use crate::model::lobe::Shape;
use crate::model::spread::Grid;
use crate::numerics::fourier::fast_length;
use crate::photographs::edge::Line;
use crate::photographs::profile::Profile;
use crate::photographs::sfr;
use crate::photographs::sfr::{Estimator, Mtf};
use crate::samples::sampled::Sampled;
use tables::ShiftLine;
use tables::WaveLine;

/// Residual below which two MTFs are taken for equal whatever the noise: the model's own rounding and interpolation.
pub const MODEL_ERROR: f64 = 2e-5;

/// Most frequencies that one photograph is compared at.
const MOST_FREQUENCIES: usize = 96;

/// How the differences of two MTFs at several frequencies are weighed against each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weights {
    /// In units of their noise, correlations between frequencies taken out.
    Noise,
    /// All alike, so that the sum of their squares is the mean squared difference, as published.
    Even,
}

/// A photograph of an edge, measured.
#[derive(Clone)]
pub struct View {
    /// Where the edge lies.
    pub line: Line,
    /// Pixels sorted by distance from the edge.
    pub profile: Profile,
    /// The estimator at the frequencies of comparison.
    pub estimator: Estimator,
    /// What it measures.
    pub mtf: Mtf,
    /// Standard error of its modulus.
    pub mtf_standard_error: Vec<f64>,
    grid: Grid,
    pitch_mm: f64,
    /// Edge normal in the aerial image, (tangential, sagittal).
    normal: [f64; 2],
    camera: Vec<f64>,
    whitener: Cholesky<f64, Dyn>,
    /// The photograph's samples, where its model is evaluated by them.
    sampled: Option<Sampled>,
}

/// A model's profile over the bins, with its derivatives by the natural logarithms of spread and c.
pub struct Curve {
    /// Mean of the unit edge over every bin.
    pub bins: Vec<f64>,
    /// Derivative by ln(spread), where the kernel has a lobe.
    pub by_ln_spread: Option<Vec<f64>>,
    /// Derivative by ln(c), where the kernel has c.
    pub by_ln_c: Option<Vec<f64>>,
}

/// The blur's variable part: kernel, lobe shape, and this direction's shift or waves.
#[derive(Clone, Copy)]
pub struct Model<'a> {
    /// Terms of the model.
    pub kernel: Kernel,
    /// Shape of its lobe.
    pub shape: Shape,
    /// The direction's shift along the edge normal; `None` only for models without it.
    pub shift: Option<&'a ShiftLine>,
    /// The direction's waves along the edge normal; `None` only for models without them (a `wave` model is NaN then).
    pub wave: Option<&'a WaveLine>,
    /// The facets along the edge normal; `None` but for baselines (which are NaN without).
    pub baseline: Option<Baseline>,
    /// Floating distance (optical path), mm.
    pub r_mm: f64,
    /// Edge normal in the aerial image, (tangential, sagittal).
    pub normal: [f64; 2],
}

impl Model<'_> {
    /// OTF of the aerial image at `frequency` (1/mm) along the normal, and its derivatives by ln(spread) and ln(c).
    pub fn otf(&self, blur: Blur, frequency: f64) -> [Complex64; 3] {
        let [sheet, by_ln_c] = self.sheet_otf(blur.c_mm, frequency);
        let [lobe, by_ln_spread] = self.lobe_otf(blur.spread, frequency);
        [sheet * lobe, sheet * by_ln_spread, by_ln_c * lobe]
    }

    /// The factor that depends on c, of shift, waves or a rough front, and its derivative by ln(c); 1 and 0 where the kernel
    /// has none.
    pub fn sheet_otf(&self, c_mm: f64, frequency: f64) -> [Complex64; 2] {
        if let Some(facets) = self.baseline {
            return facets
                .front_otf(self.shape, c_mm * self.r_mm, frequency)
                .map(Complex64::from);
        }
        match (self.kernel, self.wave, self.shift) {
            (Kernel::Wave, Some(line), _) => {
                let (value, by_ln_c) = line.otf(c_mm, self.r_mm, frequency);
                [value.into(), by_ln_c.into()]
            }
            (kernel, ..) if kernel == Kernel::Wave || kernel.is_baseline() => {
                [Complex64::from(f64::NAN); 2]
            }
            (Kernel::Eq1 | Kernel::Angular | Kernel::Shift, _, Some(line)) => {
                let (value, by_c) = line.otf(c_mm, self.r_mm, frequency);
                [value, by_c * c_mm]
            }
            _ => [Complex64::ONE, Complex64::ZERO],
        }
    }

    /// The lobe's factor, and its derivative by ln(spread); 1 and 0 where the kernel has none.
    pub fn lobe_otf(&self, spread: f64, frequency: f64) -> [f64; 2] {
        if let Some(facets) = self.baseline {
            return facets.own_otf(self.shape, spread * self.r_mm, frequency);
        }
        if !self.kernel.has_lobe() {
            return [1.0, 0.0];
        }
        let a = spread / self.kernel.distance_scale(self.r_mm);
        let (value, slope) = self.shape.otf(a, frequency, self.normal);
        [value, slope * a]
    }

    /// Kink of the OTF at zero frequency (mm), and its derivatives by ln(spread) and ln(c).
    pub fn kink(&self, blur: Blur) -> [f64; 3] {
        if let (Kernel::Wave, Some(line)) = (self.kernel, self.wave) {
            let kink = line.kink(blur.c_mm, self.r_mm);
            return [kink, 0.0, -kink];
        }
        if !self.kernel.has_lobe() || self.kernel.is_baseline() {
            return [0.0; 3];
        }
        let a = blur.spread / self.kernel.distance_scale(self.r_mm);
        let (kink, slope) = self.shape.kink(a, self.normal);
        [kink, slope * a, 0.0]
    }
}

impl View {
    /// Measures the edge at `line`. `tangential_rad` is the direction of the tangential axis in the photograph.
    ///
    /// Frequencies: the spacing is about the reciprocal of the profile's length (closer ones tell nothing new); the last is
    /// where the measured modulus sinks into three times its noise, at most half the sampling frequency.
    pub fn new(
        line: Line,
        profile: Profile,
        pitch_mm: f64,
        tangential_rad: f64,
        camera: &Camera,
    ) -> View {
        // Half the sampling frequency is the eighth part of a period.
        let period = fast_length(profile.len()).min(8 * 4 * MOST_FREQUENCIES);
        let most = period / 8;
        let wide = Estimator::new(&profile, pitch_mm, period, most);
        let mtf = wide.measure(&profile);
        let dark = |k: usize| mtf.modulus[k] < 3.0 * mtf.power_noise[k].sqrt();
        let count = (1..most)
            .find(|&k| dark(k) && dark(k + 1))
            .unwrap_or(most)
            .clamp(4.min(most), MOST_FREQUENCIES);
        let estimator = wide.truncated(count);
        let mtf = estimator.measure(&profile);
        let response = estimator.response(&profile);
        let mtf_standard_error = sfr::standard_error(&response, &profile);
        let whitener = whitener(response, &profile);
        let grid = Grid::new(profile.len(), pitch_mm);
        let angle = line.normal_rad - tangential_rad;
        let mut view = View {
            line,
            profile,
            estimator,
            mtf,
            mtf_standard_error,
            grid,
            pitch_mm,
            normal: [angle.cos(), angle.sin()],
            camera: Vec::new(),
            whitener,
            sampled: None,
        };
        view.set_camera(camera);
        view
    }

    /// Changes the camera.
    pub fn set_camera(&mut self, camera: &Camera) {
        self.camera = self
            .grid
            .frequencies_per_mm()
            .map(|f| camera.otf(f, self.line.normal_rad))
            .collect();
        self.sampled = self.sampled.as_ref().map(|s| s.through(camera));
    }

    /// Evaluates the model by samples from now on, or in closed form.
    pub fn set_sampled(&mut self, sampled: Option<Sampled>) {
        self.sampled = sampled;
    }

    /// The samples by which the model is evaluated, if it is.
    pub fn sampled(&self) -> Option<&Sampled> {
        self.sampled.as_ref()
    }

    /// The same photograph seen through another camera.
    pub fn through(&self, camera: &Camera) -> View {
        let mut view = self.clone();
        view.set_camera(camera);
        view
    }

    /// Edge normal in the aerial image, (tangential, sagittal).
    pub fn normal(&self) -> [f64; 2] {
        self.normal
    }

    /// The model's edge profile on this photograph's bins.
    pub fn curve(&self, model: &Model, blur: Blur) -> Curve {
        if let Some(sampled) = &self.sampled {
            return sampled.curve(model, blur, self.pitch_mm, &self.profile);
        }
        let n = self.camera.len();
        let mut otf = [const { Vec::new() }; 3];
        for part in &mut otf {
            part.reserve(n);
        }
        for (f, &camera) in self.grid.frequencies_per_mm().zip(&self.camera) {
            // Beyond the camera's reach the rest need not be worked out.
            let values = if camera.abs() < 1e-8 {
                [Complex64::ZERO; 3]
            } else {
                model.otf(blur, f)
            };
            for (part, value) in otf.iter_mut().zip(values) {
                part.push(value * camera);
            }
        }
        let [value, by_spread, by_c] = &otf;
        let [kink, kink_by_spread, kink_by_c] = model.kink(blur);
        let bins = |otf: &[Complex64], kink: f64| self.grid.profile(otf, kink, &self.profile);
        Curve {
            bins: bins(value, kink),
            by_ln_spread: model
                .kernel
                .has_lobe()
                .then(|| bins(by_spread, kink_by_spread)),
            by_ln_c: model.kernel.has_c().then(|| bins(by_c, kink_by_c)),
        }
    }

    /// The camera's edge alone: the model of a reference photograph.
    pub fn reference_curve(&self) -> Vec<f64> {
        let otf: Vec<Complex64> = self.camera.iter().map(|&c| Complex64::from(c)).collect();
        self.grid.profile(&otf, 0.0, &self.profile)
    }

    /// MTF of a modelled profile and its derivatives, through the estimator of the photograph.
    pub fn predict(&self, bins: &[f64], derivatives: &[Vec<f64>]) -> (Vec<f64>, Vec<Vec<f64>>) {
        self.estimator
            .predict(bins, derivatives, &self.mtf.power_noise)
    }

    /// Differences of two MTFs in units of their noise, correlations between frequencies taken out (zero frequency left
    /// out). Linear.
    pub fn whiten(&self, difference: &[f64]) -> DVector<f64> {
        let mut v = DVector::from_column_slice(&difference[1..]);
        self.whitener.l_dirty().solve_lower_triangular_mut(&mut v);
        v
    }

    /// Differences of two MTFs, weighed (zero frequency left out). Linear.
    pub fn weigh(&self, weights: Weights, difference: &[f64]) -> DVector<f64> {
        match weights {
            Weights::Noise => self.whiten(difference),
            Weights::Even => {
                let v = DVector::from_column_slice(&difference[1..]);
                &v / (v.len() as f64).sqrt()
            }
        }
    }

    /// The noise response of the weighed MTF: rows are weighed frequencies, columns are bins.
    pub fn response(&self, weights: Weights) -> DMatrix<f64> {
        let mut m = self.estimator.response(&self.profile).remove_row(0);
        match weights {
            Weights::Noise => {
                self.whitener.l_dirty().solve_lower_triangular_mut(&mut m);
            }
            Weights::Even => m /= (m.nrows() as f64).sqrt(),
        }
        m
    }

    /// Frequency (1/mm) at which the measured MTF first falls to one half, from the frequencies of comparison.
    pub fn mtf50_per_mm(&self) -> Option<f64> {
        crate::photographs::sfr::crossing(
            &self.estimator.frequencies_per_mm,
            &self.mtf.modulus,
            0.5,
        )
    }

    /// One pixel, mm.
    pub fn pitch_mm(&self) -> f64 {
        self.pitch_mm
    }
}

/// Covariance of the measured modulus by bin noise, factored; zero frequency left out.
fn whitener(response: DMatrix<f64>, profile: &Profile) -> Cholesky<f64, Dyn> {
    let mut response = response.remove_row(0);
    for (mut bin, variance) in response.column_iter_mut().zip(&profile.variance) {
        bin *= variance.sqrt();
    }
    let mut covariance = &response * response.transpose();
    for k in 0..covariance.nrows() {
        covariance[(k, k)] *= 1.0 + 1e-9;
        covariance[(k, k)] += MODEL_ERROR * MODEL_ERROR;
    }
    Cholesky::new(covariance).expect("a Gram matrix plus a positive diagonal is positive definite")
}
