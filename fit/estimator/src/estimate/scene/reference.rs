//! The reference photographs: the blur of the camera alone, and the brightness of the source.

use nalgebra::{DMatrix, DVector};

use crate::compare::Contrast;
use crate::compare::Pixels;
use crate::compare::View;
use crate::estimate::scene::empirical;
use crate::estimate::scene::optics::{Optics, STEP, at, gaussian, ln_blur};
use crate::model::{Camera, Lens};
use edges::numerics::{CONVERGED, Solution, least_squares};
use edges::photographs::photo::taken::Taken;

/// Measured reference photographs.
#[derive(Debug, Clone)]
pub struct Reference {
    /// The photographs, in the order of the manifest; never empty.
    pub photographs: Vec<SourceEdge>,
    /// Exposure of the first.
    pub exposure: f64,
    /// Bright minus dark plateau of the source edge, per unit of exposure: the mean over the
    /// photographs, weighted by their errors.
    pub step: f64,
    /// Relative standard error of `step`.
    pub step_relative_error: f64,
    /// Derivatives of ln(step) by the numbers of the lenses, see [`Camera::numbers`].
    pub step_by_lens: Vec<f64>,
    /// Whitened sum of squares of the lens' fit to the MTFs per degree of freedom, the largest over
    /// the directions. It is about 1 if the model of the lens describes the camera.
    pub reduced_chi2: f64,
    /// Relation between stored values and light that was taken for the first photograph.
    pub transfer: Taken,
}

/// Measured photograph of the source edge.
#[derive(Debug, Clone)]
pub struct SourceEdge {
    /// Pixels of the photograph.
    pub pixels: Pixels,
    /// Exposure of the photograph.
    pub exposure: f64,
    /// Bright minus dark plateau per unit of exposure.
    pub step: f64,
    /// Relative standard error of `step`.
    pub step_relative_error: f64,
    /// Frequency at which the measured MTF falls to one half, 1/mm.
    pub mtf50_per_mm: Option<f64>,
}

impl Reference {
    /// Returns whether a photograph of the mid-air edge is sharper than the reference, along the
    /// nearest direction.
    ///
    /// The blur of the sheet only adds to that of the lens. So where the MTF of the reference is
    /// one half, that of a mid-air image is at most one half. The margin allows for the square
    /// pixel, whose MTF depends on the direction of the edge.
    pub fn is_blunter_than(&self, view: &View) -> bool {
        const MARGIN: f64 = 0.1;
        const SURE: f64 = 5.0;
        let nearest = self.nearest(view.line.normal_rad).0;
        let at = nearest.mtf50_per_mm.and_then(|f| view.mtf_at(f));
        at.is_some_and(|[mtf, error]| mtf - 0.5 > MARGIN.max(SURE * error))
    }

    /// Returns the photograph whose edge is nearest to a direction, and the angle between the two,
    /// radians.
    pub(crate) fn nearest(&self, normal_rad: f64) -> (&SourceEdge, f64) {
        let angle = |own: &SourceEdge| between(own.pixels.line.normal_rad, normal_rad);
        let mut nearest = (&self.photographs[0], angle(&self.photographs[0]));
        for own in &self.photographs[1..] {
            if angle(own) < nearest.1 {
                nearest = (own, angle(own));
            }
        }
        nearest
    }
}

/// Angle between two directions up to which they count as one, radians.
///
/// An edge that was turned by less tells less of another direction than of the lens as it is. This
/// limit is a convention.
const ONE_DIRECTION: f64 = std::f64::consts::PI / 12.0;

/// Fall of the sum of squares for which a free exponent is kept. A superfluous exponent reaches it
/// in 1 of 1000 cases.
const KEEP_EXPONENT: f64 = 10.8;

/// Measures the camera by photographs of the source edge, each with its exposure. There must be
/// one. Photographs of edges that lie apart by more than 15 degrees show lenses of their own.
pub fn measure(sources: Vec<(View, Pixels, f64)>) -> (Reference, Optics) {
    combined(sources, true)
}

/// Measures it with a lens of the OTF exp(-(f blur)^p), whether this describes the photographs or
/// not.
pub fn measure_parametric(sources: Vec<(View, Pixels, f64)>) -> (Reference, Optics) {
    combined(sources, false)
}

fn combined(sources: Vec<(View, Pixels, f64)>, as_it_is: bool) -> (Reference, Optics) {
    let directions = directions(&sources);
    let mut optics = Optics {
        camera: Camera {
            pitch_mm: sources[0].0.pitch_mm(),
            lenses: Vec::new(),
        },
        free: Vec::new(),
        lens: DVector::zeros(0),
        covariance: DMatrix::zeros(0, 0),
        assumed: false,
    };
    let mut reduced_chi2 = 0.0_f64;
    for members in directions {
        let own: Vec<&(View, Pixels, f64)> = members.iter().map(|&i| &sources[i]).collect();
        let mut lens = parametric(&own);
        if as_it_is {
            let pixels: Vec<&Pixels> = own.iter().map(|own| &own.1).collect();
            let departing = empirical::departing(&pixels, &lens.camera, &lens.free);
            if let Some((camera, covariance)) = departing {
                lens = Measured::departing(&own, camera, covariance);
            }
        }
        reduced_chi2 = reduced_chi2.max(lens.reduced_chi2);
        lens.append_to(&mut optics, mean_direction(&own));
    }
    let neighbours = optics.neighbours();
    let mut slopes = Vec::new();
    let photographs = sources.into_iter().map(|(view, pixels, exposure)| {
        let edge = view.edge_of(&optics.camera);
        let contrast = Contrast::fit(&view.profile, &edge);
        let by_lens = neighbours.iter().map(|(camera, step)| {
            let pairs = view.edge_of(camera).into_iter().zip(edge.iter());
            let change: Vec<f64> = pairs.map(|(a, b)| (a - b) / step).collect();
            contrast.relative_change(&change)
        });
        slopes.push(DVector::from_iterator(neighbours.len(), by_lens));
        SourceEdge {
            pixels,
            exposure,
            step: contrast.step / exposure,
            step_relative_error: contrast.variance(&view.profile).sqrt() / contrast.step.abs(),
            mtf50_per_mm: view.mtf50_per_mm(),
        }
    });
    let photographs: Vec<SourceEdge> = photographs.collect();
    let [mut step, mut step_relative_error] =
        [photographs[0].step, photographs[0].step_relative_error];
    if photographs.len() > 1 {
        let weights = photographs.iter().map(|own| {
            let least = 1e-8;
            own.step_relative_error.max(least).powi(-2)
        });
        let weights: Vec<f64> = weights.collect();
        let sum: f64 = weights.iter().sum();
        let all = photographs.iter().zip(&weights);
        step = all
            .map(|(own, w)| w / sum * own.step.ln())
            .sum::<f64>()
            .exp();
        step_relative_error = sum.sqrt().recip();
        let mean = slopes.iter().zip(&weights).map(|(own, w)| own * (w / sum));
        slopes = vec![mean.sum()];
    }
    let reference = Reference {
        exposure: photographs[0].exposure,
        photographs,
        step,
        step_relative_error,
        step_by_lens: slopes[0].as_slice().to_vec(),
        reduced_chi2,
        transfer: Taken::default(),
    };
    (reference, optics)
}

/// Returns the angle between two lines with these normals, radians: at most a right angle.
pub(crate) fn between(a: f64, b: f64) -> f64 {
    (a - b).sin().abs().asin()
}

/// Returns the photographs of each direction, by their numbers.
fn directions(sources: &[(View, Pixels, f64)]) -> Vec<Vec<usize>> {
    let mut all: Vec<Vec<usize>> = Vec::new();
    for (i, (view, ..)) in sources.iter().enumerate() {
        let normal_rad = |i: usize| sources[i].0.line.normal_rad;
        let near = |members: &&mut Vec<usize>| {
            between(normal_rad(members[0]), view.line.normal_rad) <= ONE_DIRECTION
        };
        match all.iter_mut().find(near) {
            Some(members) => members.push(i),
            None => all.push(vec![i]),
        }
    }
    all
}

/// Returns the mean of the normals, each as the angle or its opposite that lies near the first.
fn mean_direction(sources: &[&(View, Pixels, f64)]) -> f64 {
    let first = sources[0].0.line.normal_rad;
    let off = sources.iter().map(|(view, ..)| {
        let by = view.line.normal_rad - first;
        (by.sin() * by.cos().signum()).asin()
    });
    first + off.sum::<f64>() / sources.len() as f64
}

/// Lens that was measured along one direction.
struct Measured {
    /// Camera with this lens alone.
    camera: Camera,
    free: Vec<usize>,
    values: DVector<f64>,
    covariance: DMatrix<f64>,
    reduced_chi2: f64,
}

impl Measured {
    /// Makes the lens of a camera with a departure, whose numbers are all estimated.
    fn departing(
        sources: &[&(View, Pixels, f64)],
        camera: Camera,
        covariance: DMatrix<f64>,
    ) -> Measured {
        let departure = camera.lenses[0].departure.as_ref();
        let terms = departure.map_or(Vec::new(), |own| own.terms.clone());
        let residuals = residuals(sources, &camera);
        let freedom = residuals.len().saturating_sub(terms.len()).max(1) as f64;
        Measured {
            free: (0..terms.len()).collect(),
            values: DVector::from_vec(terms),
            covariance,
            reduced_chi2: residuals.norm_squared() / freedom,
            camera,
        }
    }

    /// Appends the lens to those of other directions.
    fn append_to(self, optics: &mut Optics, normal_rad: f64) {
        let first = optics.camera.numbers();
        let lenses = self.camera.lenses.into_iter();
        optics
            .camera
            .lenses
            .extend(lenses.map(|lens| Lens { normal_rad, ..lens }));
        optics
            .free
            .extend(self.free.iter().map(|number| first + number));
        let values = optics.lens.iter().chain(&self.values).copied();
        optics.lens = DVector::from_vec(values.collect());
        let own = self.covariance.nrows();
        let mut covariance = DMatrix::zeros(first + own, first + own);
        covariance
            .view_mut((0, 0), (first, first))
            .copy_from(&optics.covariance);
        covariance
            .view_mut((first, first), (own, own))
            .copy_from(&self.covariance);
        optics.covariance = covariance;
    }
}

/// Fits the lens with the OTF exp(-(f blur)^p) to the MTFs.
fn parametric(sources: &[&(View, Pixels, f64)]) -> Measured {
    let pitch_mm = sources[0].0.pitch_mm();
    let start = ln_blur(0.5, pitch_mm);
    let gaussian_lens = fit(sources, pitch_mm, DVector::from_vec(vec![start]));
    let free = fit(
        sources,
        pitch_mm,
        DVector::from_vec(vec![gaussian_lens.parameters[0], 2.0]),
    );
    let keep = gaussian_lens.sum_of_squares() - free.sum_of_squares() > KEEP_EXPONENT;
    let solution = if keep { free } else { gaussian_lens };
    let parameters = solution.parameters.len();
    let freedom = solution.residuals.len().saturating_sub(parameters).max(1) as f64;
    let reduced_chi2 = solution.sum_of_squares() / freedom;
    let normal = solution.jacobian.transpose() * &solution.jacobian;
    let mut covariance = DMatrix::zeros(2, 2);
    if let Some(inverse) = normal.try_inverse() {
        covariance
            .view_mut((0, 0), (parameters, parameters))
            .copy_from(&(inverse * reduced_chi2.max(1.0)));
    }
    let free: Vec<usize> = (0..parameters).collect();
    Measured {
        camera: at(&gaussian(pitch_mm), &free, &solution.parameters),
        free,
        values: solution.parameters,
        covariance,
        reduced_chi2,
    }
}

/// Returns the whitened differences of the MTFs from those of a camera.
fn residuals(sources: &[&(View, Pixels, f64)], camera: &Camera) -> DVector<f64> {
    let all = sources.iter().flat_map(|(view, ..)| {
        let edge = view.edge_of(camera);
        let (modelled, _) = view.predict(&edge, &[]);
        let difference: Vec<f64> = modelled
            .iter()
            .zip(&view.mtf.modulus)
            .map(|(m, d)| m - d)
            .collect();
        view.whiten(&difference).as_slice().to_vec()
    });
    DVector::from_vec(all.collect())
}

fn fit(sources: &[&(View, Pixels, f64)], pitch_mm: f64, start: DVector<f64>) -> Solution {
    let template = gaussian(pitch_mm);
    let free: Vec<usize> = (0..start.len()).collect();
    let residuals =
        |parameters: &DVector<f64>| residuals(sources, &at(&template, &free, parameters));
    least_squares(start, CONVERGED, |parameters| {
        let here = residuals(parameters);
        // These are central differences. The model is smooth and its rounding 1e-13, so a step of
        // 1e-4 is accurate to 1e-8.
        let columns: Vec<DVector<f64>> = (0..parameters.len())
            .map(|i| {
                let (mut low, mut high) = (parameters.clone(), parameters.clone());
                low[i] -= STEP;
                high[i] += STEP;
                (residuals(&high) - residuals(&low)) / (2.0 * STEP)
            })
            .collect();
        (here, DMatrix::from_columns(&columns))
    })
}
