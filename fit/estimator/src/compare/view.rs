//! One photograph made ready for comparison with models: its profile, its estimator, and the parts
//! of the model that the parameters do not change.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use num_complex::Complex64;

use crate::model::Blur;
use crate::model::Camera;
use crate::model::Grid;
use crate::model::{Curve, Model};
use edges::numerics::fast_length;
use edges::photographs::Profile;
use edges::photographs::edge::line::EdgeLine;
use edges::photographs::sfr;
use edges::photographs::{Estimator, Mtf};

/// Difference below which two MTFs count as equal whatever the noise: the model's own rounding and
/// interpolation.
pub(crate) const MODEL_ERROR: f64 = 2e-5;

/// Largest number of frequencies at which one photograph is compared.
const MOST_FREQUENCIES: usize = 96;

/// Weights of the differences of two MTFs at several frequencies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weights {
    /// Units of the noise, with the correlations between frequencies removed.
    Noise,
    /// Equal weights: the sum of the squares is the mean squared difference, as published.
    Even,
}

/// A photograph of an edge, measured.
#[derive(Clone)]
pub struct View {
    /// Line of the edge.
    pub line: EdgeLine,
    /// Pixels sorted by distance from the edge.
    pub profile: Profile,
    /// Estimator at the frequencies of comparison.
    pub estimator: Estimator,
    /// MTF of the photograph as measured by `estimator`.
    pub mtf: Mtf,
    /// Standard errors of the measured modulus.
    pub mtf_standard_error: Vec<f64>,
    grid: Grid,
    pitch_mm: f64,
    /// Edge normal in the photograph: along the tangential axis, and 90 degrees clockwise from it.
    normal: [f64; 2],
    camera: Vec<f64>,
    whitener: Cholesky<f64, Dyn>,
}

impl View {
    /// Measures the edge at `line`. `tangential_rad` is the direction of the tangential axis in the
    /// photograph.
    ///
    /// The spacing of the frequencies is about the reciprocal of the profile's length, because
    /// closer ones add nothing new. The last frequency is where the measured modulus sinks below
    /// three times its noise, and at most half the sampling frequency.
    pub fn new(
        line: EdgeLine,
        profile: Profile,
        pitch_mm: f64,
        tangential_rad: f64,
        camera: &Camera,
    ) -> View {
        // One eighth of a period is half the sampling frequency.
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
        View {
            camera: seen_by(camera, &grid, line.normal_rad),
            line,
            profile,
            estimator,
            mtf,
            mtf_standard_error,
            grid,
            pitch_mm,
            normal: [angle.cos(), angle.sin()],
            whitener,
        }
    }

    /// Returns the edge normal in the photograph: along the tangential axis, and 90 degrees
    /// clockwise from it.
    pub fn normal(&self) -> [f64; 2] {
        self.normal
    }

    /// Evaluates the model's edge profile on this photograph's bins.
    pub fn curve(&self, model: &Model, blur: Blur) -> Curve {
        self.behind(&self.camera, model, blur)
    }

    /// Evaluates the model's edge profile on this photograph's bins as `camera` would see it.
    pub fn curve_by(&self, camera: &Camera, model: &Model, blur: Blur) -> Curve {
        let camera = seen_by(camera, &self.grid, self.line.normal_rad);
        self.behind(&camera, model, blur)
    }

    /// Evaluates the model's edge profile behind a camera whose OTF at the grid's frequencies is
    /// given.
    fn behind(&self, camera: &[f64], model: &Model, blur: Blur) -> Curve {
        let wanted: Vec<(usize, f64)> = model.wanted(blur).collect();
        let mut value = Vec::with_capacity(camera.len());
        let mut slopes = vec![Vec::with_capacity(camera.len()); wanted.len()];
        for (f, &camera) in self.grid.frequencies_per_mm().zip(camera) {
            // Beyond the reach of the camera the model's OTF is not needed.
            let parts = if camera.abs() < 1e-8 {
                [Complex64::ZERO; 8]
            } else {
                model.parts(blur, f)
            };
            value.push(parts[0] * camera);
            for (slope, &(part, _)) in slopes.iter_mut().zip(&wanted) {
                slope.push(parts[part] * camera);
            }
        }
        let bins = |otf: &[Complex64], kink: f64| self.grid.profile(otf, kink, &self.profile);
        let slopes = slopes.iter().zip(&wanted);
        Curve {
            bins: bins(&value, model.kink(blur)[0]),
            derivatives: slopes.map(|(otf, &(_, kink))| bins(otf, kink)).collect(),
        }
    }

    /// Evaluates the edge profile of a camera alone, which is the model of a reference photograph.
    pub fn edge_of(&self, camera: &Camera) -> Vec<f64> {
        let otf = seen_by(camera, &self.grid, self.line.normal_rad);
        let otf: Vec<Complex64> = otf.into_iter().map(Complex64::from).collect();
        self.grid.profile(&otf, 0.0, &self.profile)
    }

    /// Returns the MTF of a modelled profile, and its derivatives, through the photograph's
    /// estimator.
    pub fn predict(&self, bins: &[f64], derivatives: &[Vec<f64>]) -> (Vec<f64>, Vec<Vec<f64>>) {
        self.estimator
            .predict(bins, derivatives, &self.mtf.power_noise)
    }

    /// Converts differences of two MTFs to units of their noise and removes the correlations
    /// between frequencies. The zero frequency is left out. The map is linear.
    pub fn whiten(&self, difference: &[f64]) -> DVector<f64> {
        let mut v = DVector::from_column_slice(&difference[1..]);
        self.whitener.l_dirty().solve_lower_triangular_mut(&mut v);
        v
    }

    /// Multiplies the differences of two MTFs by their weights. The zero frequency is left out. The
    /// map is linear.
    pub fn weigh(&self, weights: Weights, difference: &[f64]) -> DVector<f64> {
        match weights {
            Weights::Noise => self.whiten(difference),
            Weights::Even => {
                let v = DVector::from_column_slice(&difference[1..]);
                &v / (v.len() as f64).sqrt()
            }
        }
    }

    /// Returns the noise response of the weighted MTF: a row for each weighted frequency, a column
    /// for each bin.
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

    /// Returns the frequency (1/mm) at which the measured MTF first falls to one half, interpolated
    /// between the frequencies of comparison.
    pub fn mtf50_per_mm(&self) -> Option<f64> {
        edges::photographs::crossing(&self.estimator.frequencies_per_mm, &self.mtf.modulus, 0.5)
    }

    /// Returns the measured MTF at a frequency (1/mm) and its standard error, both interpolated
    /// between the frequencies of comparison. Returns `None` beyond the last of them.
    pub fn mtf_at(&self, frequency_per_mm: f64) -> Option<[f64; 2]> {
        let all = &self.estimator.frequencies_per_mm;
        let next = all.iter().position(|&f| f >= frequency_per_mm)?;
        let last = next.saturating_sub(1);
        let width = all[next] - all[last];
        let part = if width > 0.0 {
            (frequency_per_mm - all[last]) / width
        } else {
            0.0
        };
        let at = |values: &[f64]| values[last] + part * (values[next] - values[last]);
        Some([at(&self.mtf.modulus), at(&self.mtf_standard_error)])
    }

    /// Returns the pixel pitch, mm.
    pub fn pitch_mm(&self) -> f64 {
        self.pitch_mm
    }
}

/// Evaluates the OTF of a camera along a normal at the frequencies of a grid.
fn seen_by(camera: &Camera, grid: &Grid, normal_rad: f64) -> Vec<f64> {
    let camera = camera.along(normal_rad);
    grid.frequencies_per_mm().map(|f| camera.otf(f)).collect()
}

/// Factors the covariance that bin noise gives the measured modulus. The zero frequency is left
/// out.
///
/// The error of the light is left out too: it is common to all frequencies, and weights that know
/// such an error would bias a fit (Peelle's puzzle). It is in the standard errors.
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
