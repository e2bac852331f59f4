//! Tests of the likelihood of the pixels: against planted answers, differences, and a plain loop
//! over all pixels.

use crate::planted::{SHARED, camera, params, scene, table, truth};
use crate::simulate::Params;
use crate::simulate::photograph as simulate;
use edges::names::Kernel;
use edges::names::LobeShape;
use edges::numerics::clip::Cut;
use edges::photographs::PixelNoise;
use edges::photographs::edge::line::{Bend, ORDERS};
use estimator::compare::{Nuisances, Photograph, Terms};
use estimator::estimate::Choice;
use estimator::estimate::Layout;
use estimator::estimate::Loss;
use estimator::estimate::estimate;
use estimator::estimate::refined;
use estimator::estimate::search::optimum::optimum;
use estimator::estimate::{Joint, Used};
use estimator::model::Blur;
use estimator::model::Further;
use nalgebra::{DMatrix, DVector};

/// Residuals and nuisance derivatives of a photograph's rows, stacked.
fn rows(
    photograph: &Photograph,
    curves: &estimator::compare::Curves,
    at: &Nuisances,
) -> DMatrix<f64> {
    let mut all: Vec<Vec<f64>> = Vec::new();
    photograph.rows(curves, at, |row| all.push(row.to_vec()));
    DMatrix::from_fn(all.len(), all[0].len(), |i, j| all[i][j])
}

/// Nuisance derivatives match differences. Central differences over +-h have an error of h^2/6
/// third derivatives: 1e-6 of the column for steps of a thousandth of the scale of a column. The
/// derivatives leave out how a bin's third moments turn. This is of the order of (bin / blur)^2
/// times the turn: below 1e-3.
#[test]
fn nuisance_derivatives_match_differences() {
    let planted = truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.31, 0.6);
    let table = table(&planted, &[20.0], 20.0);
    let scene = scene(
        &params(6, planted, &[20.0], &[150.0], camera(40_000.0)),
        &table,
    );
    let shot = &scene.shots[0];
    let mut pixels = (*shot.pixels).clone();
    pixels.line.bend = Some(Bend {
        middle_px: 5.0,
        half_px: 70.0,
        terms_px: [0.0; ORDERS - 1],
        order: 4,
    });
    let mut photograph = Photograph::new(&pixels, scene.optics.camera.pitch_mm);
    let model = estimator::estimate::model(shot, SHARED);
    let blur = Blur::new(3.4, 0.31);
    let curves = photograph.curves(Some((&model, blur)), &scene.optics.camera, &[0]);
    photograph.settle(&curves);
    let at = Nuisances {
        place_px: 0.3,
        turn_rad: 3e-4,
        bend_px: [0.01, -0.005, 0.002, 0.0, 0.0, 0.0, 0.0, 0.0],
        dark: 0.01,
        light: [
            0.02, -0.01, 0.01, -0.02, 0.015, 0.01, -0.01, 0.02, 0.01, -0.01,
        ],
        lit: 0.004,
        lamp: 0.3,
        step: 0.4,
    };
    photograph.estimate_light(Terms::All);
    photograph.with_noise(&curves, photograph.noise);
    let here = rows(&photograph, &curves, &at);
    let steps = [1e-3, 1e-5, 1e-4]
        .into_iter()
        .chain([1e-4; 10])
        .chain([1e-3; 3])
        .chain([1e-4, 1e-3, 1e-4]);
    for (column, h) in steps.enumerate() {
        let moved = |h: f64| {
            let mut at = at;
            match column {
                0 => at.place_px += h,
                1 => at.turn_rad += h,
                2 => at.dark += h,
                3..13 => at.light[column - 3] += h,
                13..16 => at.bend_px[column - 13] += h,
                16 => at.lit += h,
                17 => at.lamp += h,
                _ => at.step *= h.exp(),
            }
            rows(&photograph, &curves, &at)
        };
        let last = here.ncols() - 1;
        let difference = (moved(h).column(last) - moved(-h).column(last)) / (2.0 * h);
        let error = (here.column(column) - &difference).norm() / difference.norm();
        println!("nuisance {column}: {error:.1e}");
        assert!(error < 1e-3, "nuisance {column}: {error:.1e}");
    }
}

/// Checks the noise of pixels whose scatter is made: in a bin of n pixels, n - 2 times the same
/// variance v, for a mean and a slope. The noise is then v at every light, whatever the weights. 25
/// rounds of sums over a few hundred bins round by less than 1e-9, even if the line of the gain is
/// known to 1e-3 only.
#[test]
fn noise_is_the_scatter_over_the_degrees_of_freedom() {
    let planted = truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.31, 0.6);
    let table = table(&planted, &[20.0], 20.0);
    let scene = scene(
        &params(6, planted, &[20.0], &[150.0], camera(40_000.0)),
        &table,
    );
    for v in [1e-6, 4e-4] {
        let mut pixels = (*scene.shots[0].pixels).clone();
        pixels.cut = Cut::default();
        for bin in pixels.bins.iter_mut().chain(&mut pixels.strips) {
            let free = if bin.spread > 0.0 { 2.0 } else { 1.0 };
            (bin.slope, bin.tilt, bin.variance[1]) = (0.0, [0.0; 2], 0.0);
            bin.scatter = [(bin.count - free) * v, 0.0, 0.0];
        }
        let mut photograph = Photograph::new(&pixels, scene.optics.camera.pitch_mm);
        photograph.settle(&photograph.curves(None, &scene.optics.camera, &[]));
        for light in [0.0, 0.1, 0.5] {
            let found = photograph.noise.variance(light);
            assert!((found / v - 1.0).abs() < 1e-9, "{light}: {found} {v}");
        }
    }
}

/// The gradient of the sum of squares, with the nuisances at their optimum, is 2 J^T r. Central
/// differences with h = 1e-3 have an error of h^2/6 third derivatives, 1e-6 of the change of the
/// derivative over a unit of ln. The gradient is large 5 % off the optimum, and 1e-3 of it is
/// enough to find any wrong column.
#[test]
fn derivatives_of_the_likelihood_match_differences() {
    let mut cases = 0;
    for (kernel, a) in [
        (Kernel::Eq1, 3.4),
        (Kernel::Angular, 600.0),
        (Kernel::Shift, 1.0),
        (Kernel::Lobe, 2.5),
        (Kernel::Wave, 1.0),
    ] {
        for shape in LobeShape::ALL {
            let planted = truth(kernel, shape, a, 0.31, 0.6);
            let incidence = [0.0, 30.0];
            let table = table(&planted, &incidence, 20.0);
            let scene = scene(
                &params(7, planted, &incidence, &[150.0], camera(40_000.0)),
                &table,
            );
            let choice = Choice {
                kernel,
                shape,
                per_angle_a: kernel.has_lobe(),
                per_angle_mu: false,
                further: Further::NONE,
            };
            let mut at: Vec<f64> = Vec::new();
            if kernel.has_c() {
                at.push(0.31_f64.ln());
            }
            if kernel.has_lobe() {
                at.extend([a.ln(), a.ln()]);
            }
            let at = DVector::from_vec(at);
            let joint = Joint::new(&scene, choice, &at);
            let layout = Layout::of(choice, &scene);
            let off = joint.start(&at.map(|v| v + 0.05));
            let (residuals, jacobian) = joint.evaluate(&layout, &off, &mut Vec::new());
            let gradient = 2.0 * jacobian.tr_mul(&residuals);
            for i in 0..off.len() {
                let squares = |h: f64| {
                    let mut moved = off.clone();
                    moved[i] += h;
                    joint
                        .evaluate(&layout, &moved, &mut Vec::new())
                        .0
                        .norm_squared()
                };
                let h = 1e-3;
                let difference = (squares(h) - squares(-h)) / (2.0 * h);
                let error = (gradient[i] - difference).abs();
                assert!(
                    error < 1e-3 * gradient.amax(),
                    "{kernel:?} {shape:?} {i}: {} {difference}",
                    gradient[i]
                );
                cases += 1;
            }
        }
    }
    // Parameters of the blur, and one of the lens.
    assert_eq!(
        cases,
        LobeShape::ALL.len() * ((3 + 1) + (3 + 1) + (1 + 1) + (2 + 1) + (1 + 1))
    );
}

/// All pixels of all photographs, one by one, with the light of the simulator in place of the
/// model. It has no bins, moments, transforms or projections. The parameters are ln c, ln a, ln
/// sigma of the lens; then place, angle, ln step, dark and gradient of every photograph, the
/// reference first.
struct Plain {
    /// Number of parameters of each photograph: place, turn, step, dark, light, and the lit part of
    /// the dark plateau.
    own: usize,
    params: Params,
    photographs: Vec<Vec<f32>>,
}

const SHARED_PLAIN: usize = 3;

impl Plain {
    fn new(params: &Params, own: usize) -> Plain {
        let indices = std::iter::once(None).chain((0..params.captures.len()).map(Some));
        let photographs = indices
            .map(|index| simulate::photograph(params, index).expect("the truth is complete"))
            .collect();
        Plain {
            own,
            params: params.clone(),
            photographs,
        }
    }

    /// Returns the noise-free light of a photograph.
    fn light(&self, at: &DVector<f64>, photograph: usize) -> Vec<f64> {
        let mut params = self.params.clone();
        params.truth.c_mm = at[0].exp();
        params.truth.a = crate::simulate::ByIncidence::Shared(at[1].exp());
        params.camera.sigma_px = at[2].exp();
        params.camera.veil = 0.0;
        params.camera.dark_ratio = 0.0;
        let own = at.rows(SHARED_PLAIN + self.own * photograph, self.own);
        let edge = match photograph {
            0 => params.reference.as_mut().expect("there is a reference"),
            k => &mut params.captures[k - 1].edge,
        };
        // The step is that at the edge, where the gradient starts; in uneven light it is that at
        // the middle of the window.
        let from_edge = edge.offset_px;
        let planted_normal = edge.normal_deg;
        edge.offset_px += own[0];
        edge.normal_deg += own[1].to_degrees();
        let unit = simulate::light(&params, photograph.checked_sub(1)).expect("complete");
        let camera = &params.camera;
        let (cx, cy) = (
            0.5 * (camera.width as f64 - 1.0),
            0.5 * (camera.height as f64 - 1.0),
        );
        let (sin, cos) = planted_normal.to_radians().sin_cos();
        let place = |pixel: usize| {
            let (x, y) = (pixel % camera.width, pixel / camera.width);
            let (x, y) = (x as f64 - cx, y as f64 - cy);
            (x * cos + y * sin + from_edge, y * cos - x * sin)
        };
        let distance = |pixel: usize| place(pixel).0;
        let gradient = |pixel: usize| {
            let (mut d, t) = place(pixel);
            if own.len() > 6 {
                d -= from_edge;
            }
            let second = match own.as_slice() {
                &[.., by_dd, by_dt, by_tt, _] if own.len() > 6 => {
                    by_dd * d * d + by_dt * d * t + by_tt * t * t
                }
                _ => 0.0,
            };
            (own[4] * d + own[5] * t + second).exp()
        };
        let lamp = if own.len() > 6 { 0.5 * own[4] } else { 0.0 };
        let moments = moments(&unit, distance);
        unit.iter()
            .enumerate()
            .map(|(pixel, unit)| {
                let lit = if own.len() > 6 {
                    own[own.len() - 1]
                } else {
                    0.5 * own[3]
                };
                let light = gradient(pixel);
                let edge = light * unit + lamp * moments[pixel];
                own[3] + lit * (light - 1.0) + own[2].exp() * edge
            })
            .collect()
    }

    /// Returns the normal matrix and the gradient at a point.
    fn normal(&self, at: &DVector<f64>, noise: PixelNoise) -> (DMatrix<f64>, DVector<f64>) {
        let n = at.len();
        let (mut normal, mut gradient) = (DMatrix::zeros(n, n), DVector::zeros(n));
        for (k, pixels) in self.photographs.iter().enumerate() {
            let light = self.light(at, k);
            let columns: Vec<usize> = (0..SHARED_PLAIN)
                .filter(|&i| k > 0 || i == 2)
                .chain((0..self.own).map(|i| SHARED_PLAIN + self.own * k + i))
                .collect();
            // Steps of a thousandth of a pixel or of a parameter: the error is h^2/6 = 1e-7 of
            // third derivatives.
            let derivatives: Vec<Vec<f64>> = columns
                .iter()
                .map(|&column| {
                    let own = column.wrapping_sub(SHARED_PLAIN) % self.own;
                    let h = match (column < SHARED_PLAIN, own) {
                        (false, 1 | 4 | 5) => 1e-5,
                        (false, 6..) if own + 1 < self.own => 1e-7,
                        _ => 1e-3,
                    };
                    let (mut low, mut high) = (at.clone(), at.clone());
                    low[column] -= h;
                    high[column] += h;
                    let (low, high) = (self.light(&low, k), self.light(&high, k));
                    high.iter()
                        .zip(&low)
                        .map(|(a, b)| (a - b) / (2.0 * h))
                        .collect()
                })
                .collect();
            // The lit part of the dark plateau is known to lie between 0 and the plateau.
            let (lit, dark) = (
                SHARED_PLAIN + self.own * (k + 1) - 1,
                at[SHARED_PLAIN + self.own * k + 3],
            );
            if self.own > 6 {
                normal[(lit, lit)] += 12.0 / (dark * dark);
                gradient[lit] += (at[lit] - 0.5 * dark) * 12.0 / (dark * dark);
            }
            for (pixel, (&value, light)) in pixels.iter().zip(&light).enumerate() {
                let weight = 1.0 / noise.variance(*light);
                for (i, &a) in columns.iter().enumerate() {
                    let by_a = derivatives[i][pixel] * weight;
                    gradient[a] += by_a * (light - f64::from(value));
                    for (j, &b) in columns.iter().enumerate() {
                        normal[(a, b)] += by_a * derivatives[j][pixel];
                    }
                }
            }
        }
        (normal, gradient)
    }
}

/// Returns the integral of -s dE up to each pixel, where E is the unit edge and s the distance. The
/// pixels are summed in the order of their distances.
fn moments(unit: &[f64], distance: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut order: Vec<usize> = (0..unit.len()).collect();
    order.sort_by(|&a, &b| distance(a).total_cmp(&distance(b)));
    let mut moments = vec![0.0; unit.len()];
    for pair in order.windows(2) {
        let [low, high] = [pair[0], pair[1]];
        let middle = 0.5 * (distance(low) + distance(high));
        moments[high] = moments[low] - middle * (unit[high] - unit[low]);
    }
    moments
}

/// The binned likelihood has the optimum and the errors of the likelihood of every single pixel.
///
/// Bins leave out 0.7 % of the information on a blur as narrow as that of the lens, and less on
/// wider ones. In the worst case, if everything depended on the lens, errors would be 0.35 % larger
/// and estimates would differ by sqrt(0.007) = 0.08 standard errors; but the lens has a small
/// share. The limits are 0.35 % and 0.05.
#[test]
fn bins_tell_what_all_pixels_tell() {
    bins_tell_all(6);
}

/// Bins tell all of uneven light too: its terms of second order are estimated.
#[test]
fn bins_tell_all_of_uneven_light() {
    bins_tell_all(10);
}

fn bins_tell_all(own: usize) {
    let (a, c, mu) = (3.1_f64, 0.36_f64, 0.55);
    let incidence = [5.0, 30.0];
    let planted = truth(Kernel::Eq1, LobeShape::Radial, a, c, mu);
    let table = table(&planted, &incidence, 20.0);
    let params = params(91, planted, &incidence, &[200.0], camera(2e4));
    let camera = &params.camera;
    let electrons = camera.full_well_e;
    let step = 1.0 / ((1_u64 << camera.bits) - 1) as f64;
    let noise = PixelNoise {
        read: (camera.read_noise_e / electrons).powi(2) + step * step / 12.0,
        gain: 1.0 / electrons,
    };
    let scene = scene(&params, &table);
    let start = optimum(&scene, SHARED);
    let mut joint = Joint::new(&scene, SHARED, &start.solution.parameters);
    let near = joint.start(&start.solution.parameters);
    if own > 6 {
        joint.estimate_light(Terms::Second);
    }
    joint.with_noise(SHARED, &near, noise);
    let loss = Loss::Edge(Box::new(joint));
    let fit = estimate(&scene, &loss, refined(&scene, &loss, start));
    let Loss::Edge(joint) = loss else {
        unreachable!()
    };
    let layout = Layout::of(SHARED, &scene);
    let bound = joint.information(&layout, &fit.solution.parameters, Used::ByAnyEstimate);

    let plain = Plain::new(&params, own);
    let photographs = params.captures.len() + 1;
    let mut at = DVector::zeros(SHARED_PLAIN + own * photographs);
    (at[0], at[1], at[2]) = (c.ln(), a.ln(), camera.sigma_px.ln());
    let mut covariance = DMatrix::zeros(0, 0);
    for k in 0..photographs {
        // Near the truth, so that the prior has a width.
        at[SHARED_PLAIN + own * k + 3] = 0.01;
    }
    for _ in 0..4 {
        let (normal, gradient) = plain.normal(&at, noise);
        covariance = normal.try_inverse().expect("all is identified");
        at -= &covariance * gradient;
    }
    let mut cases = 0;
    let mut compare = |name: &str, value: f64, of_bins: f64, of_pixels: f64, variance: f64| {
        let error = variance.sqrt();
        let (off, ratio) = (
            (value - at_of(name, &at)) / error,
            (of_bins / of_pixels).sqrt(),
        );
        println!("{name}: {off:+.3} standard errors, errors {ratio:.4}");
        assert!(off.abs() < 0.05, "{name}: {off}");
        assert!((ratio - 1.0).abs() < 0.0035, "{name}: {ratio}");
        cases += 1;
    };
    let blur = &bound.blur;
    compare(
        "c",
        fit.c_mm.expect("c").value.ln(),
        blur[(0, 0)],
        covariance[(0, 0)],
        covariance[(0, 0)],
    );
    compare(
        "a",
        fit.spread[0].value.ln(),
        blur[(1, 1)],
        covariance[(1, 1)],
        covariance[(1, 1)],
    );

    // mu is the generalised least-squares mean of the steps, which `light` gives relative to the
    // planted mu.
    let steps: Vec<usize> = (0..photographs)
        .map(|k| SHARED_PLAIN + own * k + 2)
        .collect();
    let shots = photographs - 1;
    let ratio = DVector::from_fn(shots, |k, _| at[steps[k + 1]] - at[steps[0]]);
    let of = DMatrix::from_fn(shots, shots, |i, j| {
        let at = |i: usize, j: usize| covariance[(steps[i], steps[j])];
        at(i + 1, j + 1) - at(i + 1, 0) - at(0, j + 1) + at(0, 0)
    });
    let weights = of.try_inverse().expect("definite");
    let sum = weights.sum();
    let ln_mu = (&weights * ratio).sum() / sum + mu.ln();
    let bound_mu = bound.mu.expect("there is a reference");
    let off = (fit.mu.as_ref().expect("mu")[0].value.ln() - ln_mu) * sum.sqrt();
    let errors = (bound_mu.covariance[(2, 2)] * sum).sqrt();
    println!("mu: {off:+.3} standard errors, errors {errors:.4}");
    assert!(off.abs() < 0.05, "mu: {off}");
    assert!((errors - 1.0).abs() < 0.0035, "mu: {errors}");
    assert_eq!(cases, 2);
}

fn at_of(name: &str, at: &DVector<f64>) -> f64 {
    match name {
        "c" => at[0],
        _ => at[1],
    }
}
