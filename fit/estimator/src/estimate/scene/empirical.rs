//! The lens as it is: how it departs from the OTF exp(-(f blur)^p), where pixels of the source edge
//! ask for it.
//!
//! Bayes' criterion chooses the number of terms, on the pixels of the references alone, and the next
//! larger number is taken. A lens that exp(-(f blur)^p) describes gets none.

use nalgebra::{DMatrix, DVector};

use crate::compare::{Photograph, Pixels, are_uneven};
use crate::estimate::scene::optics::{DEPARTURE, at};
use crate::estimate::search::joint::without;
use crate::estimate::search::select::CLEAR;
use crate::model::{Camera, Departure, Lens};
use edges::numerics::{Evaluation, Solution, least_squares};

/// Numbers of terms that are tried: splines of 5, 7, 9, 13, 17 and 25 steps. With the box of the
/// pixel the last one leaves less than 0.0023 of the OTF of a round pupil that ends between 0.6 and
/// 1.5 cycles per pixel, most beside that end, and 0.0001 of that of a halo of 5 % and 20 pixels.
/// More terms changed no interval of 100 campaigns.
const COUNTS: [usize; 6] = [2, 4, 6, 10, 14, 22];

/// Number of terms of a first trial. A lens that these cannot improve enough has no departure.
const TRIAL: usize = 10;

/// OTF of the parametric lens that tells where the spline ends: at [`BEYOND`] times the frequency of
/// this OTF. A disc of defocus has lobes of its OTF there.
const FAINT: f64 = 0.01;

/// See [`FAINT`].
const BEYOND: f64 = 2.5;

/// Frequency at which it ends at the latest, cycles per pixel: beyond it nothing is computed.
const LAST: f64 = 2.0;

/// Returns the camera whose lens departs as these photographs of one direction show, and the
/// covariance of the terms; `None` if the parametric lens of `camera` describes them. `free` are
/// the numbers of that lens which are estimated.
pub(crate) fn departing(
    pixels: &[&Pixels],
    camera: &Camera,
    free: &[usize],
) -> Option<(Camera, DMatrix<f64>)> {
    let source = Source::new(pixels, camera);
    let each = (source.observations() as f64).ln();
    let trial = with_terms(camera, TRIAL);
    if source.fall(&trial) <= COUNTS[0] as f64 * each + CLEAR {
        return None;
    }
    let start = numbers(camera, free);
    let parametric = source.fit(camera, free, start);
    let carrier = at(camera, free, &parametric.parameters);
    let fits: Vec<(Camera, Solution)> = COUNTS
        .iter()
        .map(|&count| {
            let camera = with_terms(&carrier, count);
            let all: Vec<usize> = (0..count).collect();
            let solution = source.fit(&camera, &all, DVector::zeros(count));
            (at(&camera, &all, &solution.parameters), solution)
        })
        .collect();
    // What no candidate describes must not add terms.
    let reduced = |fit: &Solution| {
        let freedom = source.observations().saturating_sub(fit.parameters.len());
        fit.sum_of_squares() / freedom.max(1) as f64
    };
    let all = fits.iter().map(|(_, fit)| reduced(fit));
    let misfit = all.fold(reduced(&parametric), f64::min).max(1.0);
    let criterion =
        |fit: &Solution, terms: usize| fit.sum_of_squares() / misfit + terms as f64 * each;
    let of = |fit: &Solution| criterion(fit, fit.parameters.len());
    let least = (0..fits.len()).min_by(|&a, &b| of(&fits[a].1).total_cmp(&of(&fits[b].1)))?;
    // Blur and exponent of the parametric lens stay as they are under the departure.
    if of(&fits[least].1) + CLEAR > criterion(&parametric, 0) {
        return None;
    }
    // The criterion leaves out what moves the lens by less than a few of its errors, which may move
    // a by as many. With terms beyond those, the stated errors contain it.
    let (camera, solution) = &fits[(least + 1).min(fits.len() - 1)];
    let inverse = solution.jacobian.tr_mul(&solution.jacobian).try_inverse()?;
    Some((camera.clone(), inverse * reduced(solution).max(1.0)))
}

/// Returns the values of numbers of a lens without departure.
fn numbers(camera: &Camera, numbers: &[usize]) -> DVector<f64> {
    let lens = &camera.lenses[0];
    let all = [lens.blur_mm.ln(), lens.exponent];
    DVector::from_iterator(numbers.len(), numbers.iter().map(|&number| all[number]))
}

/// Returns the camera with a departure of `count` terms, all 0.
fn with_terms(camera: &Camera, count: usize) -> Camera {
    let lens = &camera.lenses[0];
    let faint = (-FAINT.ln()).powf(lens.exponent.recip()) / lens.blur_mm;
    let departure = Departure {
        end_per_mm: (BEYOND * faint).min(LAST / camera.pitch_mm),
        terms: vec![0.0; count],
    };
    Camera {
        lenses: vec![Lens {
            departure: Some(departure),
            ..lens.clone()
        }],
        ..*camera
    }
}

/// Photographs of the source edge along one direction, with their noise.
struct Source<'a> {
    photographs: Vec<Photograph<'a>>,
}

impl<'a> Source<'a> {
    /// Finds noise and light of the photographs under a camera that is near the truth.
    fn new(pixels: &[&'a Pixels], camera: &Camera) -> Source<'a> {
        let all = pixels.iter().map(|pixels| {
            let mut photograph = Photograph::new(pixels, camera.pitch_mm);
            let curves = photograph.curves(None, camera, &[]);
            let fall = photograph.settle(&curves);
            (photograph, curves, fall)
        });
        let mut all: Vec<_> = all.collect();
        let falls: Vec<f64> = all.iter().map(|(.., fall)| *fall).collect();
        if are_uneven(&falls) {
            for (photograph, curves, _) in &mut all {
                photograph.settle_unevenly(curves);
            }
        }
        Source {
            photographs: all.into_iter().map(|(own, ..)| own).collect(),
        }
    }

    /// Returns the number of independent numbers, less those of the nuisances.
    fn observations(&self) -> usize {
        let of = |own: &Photograph| own.observations().saturating_sub(own.nuisances());
        self.photographs.iter().map(of).sum()
    }

    /// Evaluates residuals and derivatives by numbers of the lens, with the nuisances at their
    /// optimum. Terms of a departure have their prior.
    fn evaluate(&self, camera: &Camera, numbers: &[usize]) -> Evaluation {
        let departure = camera.lenses[0].departure.as_ref();
        let terms = departure.map_or(&[][..], |own| &own.terms);
        let factors: Vec<DMatrix<f64>> = self
            .photographs
            .iter()
            .map(|photograph| {
                let fitted = photograph.fit(&photograph.curves(None, camera, numbers));
                without(&fitted.factor, fitted.columns)
            })
            .collect();
        let rows: usize = factors.iter().map(DMatrix::nrows).sum();
        let width = numbers.len();
        let mut residuals = DVector::zeros(rows + terms.len());
        let mut jacobian = DMatrix::zeros(rows + terms.len(), width);
        let mut row = 0;
        for factor in &factors {
            let n = factor.nrows();
            residuals.rows_mut(row, n).copy_from(&factor.column(width));
            let own = factor.columns(0, width);
            jacobian.view_mut((row, 0), (n, width)).copy_from(&own);
            row += n;
        }
        for (term, value) in terms.iter().enumerate() {
            residuals[row + term] = value / DEPARTURE;
            jacobian[(row + term, term)] = DEPARTURE.recip();
        }
        (residuals, jacobian)
    }

    /// Returns the fall of the sum of squares that the numbers of a camera's departure promise, to
    /// first order.
    fn fall(&self, camera: &Camera) -> f64 {
        let all: Vec<usize> = (0..camera.numbers()).collect();
        let (residuals, jacobian) = self.evaluate(camera, &all);
        let pull = jacobian.tr_mul(&residuals);
        let normal = jacobian.tr_mul(&jacobian).cholesky();
        normal.map_or(0.0, |normal| pull.dot(&normal.solve(&pull)))
    }

    /// Fits numbers of the lens.
    fn fit(&self, camera: &Camera, numbers: &[usize], start: DVector<f64>) -> Solution {
        // A share of chi-square that lies far below one of its numbers.
        const TOLERANCE: f64 = 1e-6;
        least_squares(start, TOLERANCE, |values| {
            self.evaluate(&at(camera, numbers, values), numbers)
        })
    }
}
