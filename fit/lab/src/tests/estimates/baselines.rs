//! Tests of the baselines: against light traced through their rough facets, and fitted to
//! photographs that they describe.

use crate::planted;
use std::f64::consts::{PI, TAU};
use std::path::PathBuf;

use edges::document::FileLine;
use edges::names::LobeShape;
use edges::names::{Family, Kernel};
use edges::photographs::photo::channel::Decode;
use edges::photographs::photo::plane::Photo;
use edges::photographs::photo::taken::Taken;
use edges::photographs::{Campaign, Capture, Setup, Shot};
use estimator::estimate::Kind;
use estimator::estimate::Progress;
use estimator::estimate::Scene;
use estimator::estimate::search::select::select;
use estimator::estimate::{Candidates, Selection};
use estimator::model::Blur;
use estimator::model::microfacet;
use estimator::model::{Baseline, fresnel, returned};

use crate::planted::Stream;

const INDEX: f64 = 1.5;

type V = [f64; 3];

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn plus(a: V, s: f64, b: V) -> V {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

fn unit(a: V) -> V {
    a.map(|x| x / dot(a, a).sqrt())
}

fn cross(a: V, b: V) -> V {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn mirrored(d: V, n: V) -> V {
    plus(d, -2.0 * dot(d, n), n)
}

/// Snell's law for a unit direction. `n` points against `d`; `ratio` is the index before the
/// surface over the index behind it.
fn refracted(d: V, n: V, ratio: f64) -> V {
    let cos = -dot(d, n);
    let behind = (1.0 - ratio * ratio * (1.0 - cos * cos)).sqrt();
    plus(d.map(|x| ratio * x), ratio * cos - behind, n)
}

/// A facet about the normal `n`. Its slope is drawn from a distribution of roughness `alpha`.
fn facet(n: V, shape: LobeShape, alpha: f64, stream: &mut Stream) -> V {
    let u = stream.between(0.0, 1.0);
    let z = match shape {
        LobeShape::Beckmann => (-(1.0 - u).ln()).sqrt(),
        _ => (u / (1.0 - u)).sqrt(),
    };
    let turn = stream.between(0.0, TAU);
    let across = unit(cross(
        n,
        if n[0].abs() < 0.6 {
            [1.0, 0.0, 0.0]
        } else {
            [0.0, 1.0, 0.0]
        },
    ));
    let slope = plus(across.map(|x| x * turn.cos()), turn.sin(), cross(n, across));
    unit(plus(n, alpha * z, slope))
}

/// Place where a ray ends in the mid-air image at unit distance, (tangential, sagittal). The ray
/// passes five interfaces, or leaves from the one interface of the minimal model.
fn traced(
    kernel: Kernel,
    shape: LobeShape,
    theta: f64,
    azimuth: f64,
    alpha: [f64; 2],
    stream: &mut Stream,
) -> [f64; 2] {
    let up = [0.0, 0.0, 1.0];
    let d = [theta.sin(), 0.0, -theta.cos()];
    let out = if kernel == Kernel::Mrm {
        // The minimal model is f(reflect(v, n), l): light that a mirror would send on leaves from
        // the mirrored direction.
        mirrored(
            mirrored(d, up).map(|x| -x),
            facet(up, shape, alpha[0], stream),
        )
        .map(|x| -x)
    } else {
        let mut inside = refracted(d, facet(up, shape, alpha[1], stream), 1.0 / INDEX);
        for i in 0..3 {
            let psi = azimuth + TAU * f64::from(i) / 3.0;
            let flat = (2.0_f64 / 3.0).sqrt();
            let axis = [flat * psi.cos(), flat * psi.sin(), 1.0 / 3.0_f64.sqrt()];
            inside = mirrored(inside, facet(axis, shape, alpha[0], stream));
        }
        let front = facet(up, shape, alpha[1], stream).map(|x| -x);
        refracted(inside, front, INDEX)
    };
    let back = if kernel == Kernel::Mrm && dot(out, d) > 0.0 {
        out.map(|x| -x)
    } else {
        out
    };
    let along = -dot(back, d);
    [
        (back[0] * theta.cos() + back[2] * theta.sin()) / along,
        back[1] / along,
    ]
}

/// The OTFs of the baselines agree with those of traced rays. With 200,000 rays per case, the
/// standard error of the mean of a cosine is 1 / sqrt(2 x 200,000) = 0.0016; 4.5 of these are
/// allowed for 200 comparisons. At roughness 1e-4 the second order is 1e-4 of the first, and slopes
/// beyond 1e-2 hold 1e-4 of GGX's light.
#[test]
fn otfs_are_those_of_traced_facets() {
    const RAYS: usize = 200_000;
    let sampling = 4.5 / (2.0 * RAYS as f64).sqrt();
    let mut stream = Stream(11);
    let mut cases = 0;
    let alpha = 1e-4;
    for (kernel, rough) in [
        (Kernel::Saito, [alpha, 0.0]),
        (Kernel::SaitoSurface, [0.5 * alpha, 3.0 * alpha]),
        (Kernel::Mrm, [alpha, 0.0]),
    ] {
        for shape in LobeShape::MICROFACETS {
            for (theta, azimuth) in [
                (0.0, 0.3),
                (25.0_f64.to_radians(), 0.0),
                (50.0_f64.to_radians(), 0.9),
            ] {
                let ends: Vec<[f64; 2]> = (0..RAYS)
                    .map(|_| traced(kernel, shape, theta, azimuth, rough, &mut stream))
                    .collect();
                for turn in [0.0_f64, 0.5 * PI, 0.7] {
                    let normal = [turn.cos(), turn.sin()];
                    let model =
                        Baseline::new(kernel, theta, INDEX, normal).expect("it is a baseline");
                    let blur = Blur::new(rough[0], rough[1]);
                    for frequency in [150.0, 600.0, 1500.0] {
                        let mean = ends
                            .iter()
                            .map(|p| {
                                (TAU * frequency * (p[0] * normal[0] + p[1] * normal[1])).cos()
                            })
                            .sum::<f64>()
                            / RAYS as f64;
                        let value = model.otf(shape, blur, 1.0, frequency)[0].re;
                        // GGX on three facets: the model has equal shares in place of unequal ones.
                        // The worst shares are (0, 2, 2).
                        let shares = if shape == LobeShape::Ggx && kernel != Kernel::Mrm {
                            0.046
                        } else {
                            2e-4
                        };
                        assert!(
                            (mean - value).abs() < sampling + shares,
                            "{kernel:?} {shape:?} {theta} {turn} {frequency}: {mean} {value}"
                        );
                        cases += 1;
                    }
                }
            }
        }
    }
    assert_eq!(cases, 162);
}

/// Saito's three facets with a third of the spread each, compared with the shares that they really
/// have. Let w be the unit vector across both the ray and the line, on the cube's axes. Facet i
/// turns the light along the line by 2 sqrt(1 - w_i^2) of its slope.
///
/// Over all rays and lines the OTF of GGX differs by at most 0.045, where w lies on an axis. At
/// normal incidence, with w across (1, 1, 1), it differs by 0.0066. The OTF of Beckmann never
/// differs. Steps of 1/40 in w and 1/20 in the frequency miss less than 1 % of the greatest
/// difference.
#[test]
fn equal_shares_of_three_facets_are_as_good_as_stated() {
    let otf = |shape: LobeShape, k: f64| match shape {
        LobeShape::Beckmann => microfacet::beckmann(k).0,
        _ => microfacet::ggx(k).0,
    };
    let worst = |shape: LobeShape, squares: [f64; 3]| {
        (1..=100)
            .map(|i| {
                let k = 0.05 * f64::from(i);
                let own = squares.map(|w| otf(shape, 2.0 * k * (1.0 - w).max(0.0).sqrt()));
                let equal = otf(shape, k * (8.0_f64 / 3.0).sqrt()).powi(3);
                (own.iter().product::<f64>() - equal).abs()
            })
            .fold(0.0, f64::max)
    };
    let (mut all, mut cases) = (0.0_f64, 0);
    for i in 0..=40 {
        for j in 0..=40 - i {
            let squares = [i, j, 40 - i - j].map(|n| f64::from(n) / 40.0);
            all = all.max(worst(LobeShape::Ggx, squares));
            assert!(worst(LobeShape::Beckmann, squares) < 1e-14, "{squares:?}");
            cases += 1;
        }
    }
    let upright = (0..=60).map(|i| {
        let turn = f64::from(i).to_radians();
        let [x, y] = [turn.cos() / 2.0_f64.sqrt(), turn.sin() / 6.0_f64.sqrt()];
        worst(LobeShape::Ggx, [x + y, y - x, -2.0 * y].map(|w| w * w))
    });
    let upright = upright.fold(0.0, f64::max);
    println!("{all:.4} over all, {upright:.4} at normal incidence");
    assert!((all - 0.0453).abs() < 0.0005, "{all}");
    assert!((upright - 0.0066).abs() < 0.0001, "{upright}");
    assert_eq!(cases, 861);
}

/// The model of Guo et al. agrees with their eqs. 2 and 3 as printed: Jacobians of the two
/// refractions. At normal incidence it is the lobe of two rough refractions of Saito's front.
#[test]
fn guo_is_its_jacobians_and_at_normal_incidence_two_refractions() {
    for theta in [0.0_f64, 20.0, 45.0, 60.0] {
        let i = theta.to_radians().cos();
        let t = (1.0 - (theta.to_radians().sin() / INDEX).powi(2)).sqrt();
        let jacobian = |cos: f64| cos / (INDEX * t - i).powi(2);
        let alpha_o = 2e-3 * (1.0 / jacobian(t) + 1.0 / jacobian(i)).sqrt();
        let model =
            Baseline::new(Kernel::Guo, theta.to_radians(), INDEX, [0.6, 0.8]).expect("it is");
        let blur = Blur::new(2e-3, 1.0);
        for (r_mm, f) in [(150.0, 0.7), (400.0, 1.1)] {
            let k = TAU * f * alpha_o * r_mm;
            let value = model.otf(LobeShape::Beckmann, blur, r_mm, f)[0].re;
            assert!((value - (-0.25 * k * k).exp()).abs() < 1e-14);
        }
    }
    let guo = Baseline::new(Kernel::Guo, 0.0, INDEX, [1.0, 0.0]).expect("it is");
    let saito = Baseline::new(Kernel::SaitoSurface, 0.0, INDEX, [1.0, 0.0]).expect("it is");
    let front = saito.otf(LobeShape::Beckmann, Blur::new(0.0, 2e-3), 300.0, 0.9)[0];
    let own = guo.otf(LobeShape::Beckmann, Blur::new(2e-3, 0.0), 300.0, 0.9)[0];
    assert!((front - own).norm() < 1e-14 && own.re < 0.9);
}

#[test]
fn derivatives_are_differences_and_no_roughness_is_no_blur() {
    let mut cases = 0;
    for kernel in [
        Kernel::Saito,
        Kernel::SaitoSurface,
        Kernel::Guo,
        Kernel::Mrm,
    ] {
        for shape in LobeShape::MICROFACETS {
            let model = Baseline::new(kernel, 0.5, INDEX, [0.8, 0.6]).expect("it is");
            let at =
                |own: f64, front: f64, f: f64| model.otf(shape, Blur::new(own, front), 200.0, f);
            for f in [0.3, 0.9, 2.0] {
                let d = 1e-4_f64;
                let [_, own, front] = at(8e-4, 1.5e-3, f);
                let by_own = at(8e-4 * d.exp(), 1.5e-3, f)[0] - at(8e-4 * (-d).exp(), 1.5e-3, f)[0];
                let by_front =
                    at(8e-4, 1.5e-3 * d.exp(), f)[0] - at(8e-4, 1.5e-3 * (-d).exp(), f)[0];
                // The truncation error is d^2 times a third derivative of order 10. The Bessel
                // functions add errors of 2e-8 over 2 d.
                let tolerance = 10.0 * d * d + 2e-4;
                assert!(
                    (own - by_own / (2.0 * d)).norm() < tolerance,
                    "{kernel:?} {shape:?} {f}"
                );
                assert!(
                    (front - by_front / (2.0 * d)).norm() < tolerance,
                    "{kernel:?} {shape:?} {f}"
                );
                assert!((at(1e-12, 1e-12, f)[0].re - 1.0).abs() < 1e-12);
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 24);
}

#[test]
fn light_is_the_effective_area_and_fresnel() {
    let normal = ((INDEX - 1.0) / (INDEX + 1.0)).powi(2);
    assert!((fresnel(0.0, INDEX) - normal).abs() < 1e-15);
    // At Brewster's angle one polarisation is not reflected at all.
    let across = (INDEX * INDEX - 1.0) / (INDEX * INDEX + 1.0);
    assert!((fresnel(INDEX.atan(), INDEX) - 0.5 * across * across).abs() < 1e-15);
    assert!((fresnel(0.5 * PI, INDEX) - 1.0).abs() < 1e-12);
    let truth = planted::truth(Kernel::Eq1, LobeShape::Radial, 4.0, 0.2, 0.5);
    for theta in [0.0, 15.0, 30.0, 45.0] {
        let table = planted::table(&truth, &[theta], 20.0);
        let eta = table
            .direction(theta, Some(20.0))
            .expect("it is there")
            .retroreflected;
        // Effective area of an ideal triangular cell, from the direction cosines on the cube's
        // axes. The pair is the mean of a cube and its copy turned by 180 degrees.
        let inside = (theta.to_radians().sin() / truth.refractive_index).asin();
        let area = |azimuth: f64| {
            let mut cosines = [0.0, 1.0, 2.0].map(|i| {
                let psi = (azimuth - 120.0 * i).to_radians().cos();
                inside.cos() / 3.0_f64.sqrt() - (2.0_f64 / 3.0).sqrt() * inside.sin() * psi
            });
            cosines.sort_by(f64::total_cmp);
            let [p, q, r] = cosines;
            let sum = p + q + r;
            match () {
                () if p <= 0.0 => 0.0,
                () if p + q <= r => 4.0 * p * q / sum,
                () => sum - 2.0 / sum,
            }
        };
        let effective = 0.5 * (area(20.0) + area(200.0)) / (0.75_f64.sqrt() * inside.cos());
        assert!(
            (eta - effective).abs() < 1e-12,
            "{theta}: {eta} {effective}"
        );
        let passed = (1.0 - fresnel(theta.to_radians(), truth.refractive_index)).powi(2);
        for kernel in [Kernel::Saito, Kernel::Guo] {
            let light = returned(kernel, eta, theta.to_radians(), truth.refractive_index);
            assert!((light - effective * passed).abs() < 1e-12);
        }
    }
}

/// A photographed sheet that one baseline describes. Edges are in closed form (a Gaussian, or
/// Student's t for one GGX lobe). Quadrature turns them into pixels, and normal noise is added.
struct Sheet {
    kernel: Kernel,
    shape: LobeShape,
    roughness: f64,
    front: f64,
    mu: f64,
}

const PITCH_MM: f64 = 0.08;
const LENS_PX: f64 = 0.55;
const AZIMUTH: f64 = 20.0;

impl Sheet {
    /// Scale of the sheet's blur along the normal, mm: roughness times the gain of all facets
    /// together, times distance.
    fn width_mm(&self, theta: f64, normal: [f64; 2], r_mm: f64) -> f64 {
        let i = theta.cos();
        let t = (1.0 - (theta.sin() / 1.49).powi(2)).sqrt();
        let step = 1.49 * t - i;
        let length = |x: f64, y: f64| (normal[0] * x).hypot(normal[1] * y);
        let facets = 8.0_f64.sqrt() * 1.49 * self.roughness * length(t / i, 1.0);
        let gained = match self.kernel {
            Kernel::Saito => facets,
            Kernel::SaitoSurface => {
                facets.hypot(2.0_f64.sqrt() * step * self.front * length(1.0 / i, 1.0))
            }
            Kernel::Guo => self.roughness * step * (1.0 / t + 1.0 / i).sqrt(),
            _ => 2.0 * self.roughness * length(1.0, i),
        };
        gained * r_mm
    }

    /// The edge as a function of distance, in pixels: the sheet's blur of this width, seen through
    /// the lens.
    fn edge(&self, width_px: f64, d: f64) -> f64 {
        let normal = |x: f64| 0.5 * libm::erfc(-x / 2.0_f64.sqrt());
        if self.shape == LobeShape::Beckmann {
            return normal(d / (0.5 * width_px * width_px + LENS_PX * LENS_PX).sqrt());
        }
        // Midpoint rule over 7 standard deviations of the lens. Its error falls faster than any
        // power of the step.
        let h = LENS_PX / 8.0;
        (-56..56)
            .map(|i| {
                let u = (f64::from(i) + 0.5) * h;
                let weight = (-0.5 * (u / LENS_PX).powi(2)).exp() * h / (LENS_PX * TAU.sqrt());
                let x = d - u;
                weight * 0.5 * (1.0 + x / x.hypot(width_px))
            })
            .sum()
    }

    fn photograph(&self, width_px: f64, normal_deg: f64, step: f64, seed: u64) -> Photo {
        const ELECTRONS: f64 = 40_000.0;
        const SPACING: f64 = 1.0 / 128.0;
        let (width, height) = (192_usize, 128_usize);
        let reach = 130.0;
        let table: Vec<f64> = (0..(2.0 * reach / SPACING) as usize)
            .map(|i| self.edge(width_px, i as f64 * SPACING - reach))
            .collect();
        let at = |d: f64| {
            let x = (d + reach) / SPACING;
            let i = x as usize;
            table[i] + (x - i as f64) * (table[i + 1] - table[i])
        };
        let (sin, cos) = normal_deg.to_radians().sin_cos();
        let mut stream = Stream(seed);
        let mut luminance = Vec::with_capacity(width * height);
        for row in 0..height {
            for column in 0..width {
                let (x, y) = (column as f64 - 95.3, row as f64 - 63.4);
                // The pixel's area: 4 x 4 midpoints, accurate to 1e-4 of the change of the edge's
                // slope across a quarter pixel.
                let mut sum = 0.0;
                for v in 0..4 {
                    for u in 0..4 {
                        let offset = |n: i32| (f64::from(n) - 1.5) / 4.0;
                        sum += at((x + offset(u)) * cos + (y + offset(v)) * sin);
                    }
                }
                let light = 0.02 + step * sum / 16.0;
                let deviation = (light / ELECTRONS + 1e-8).sqrt();
                let radius = (-2.0 * stream.between(1e-300, 1.0).ln()).sqrt();
                let noise = radius * stream.between(0.0, TAU).cos();
                luminance.push((light + deviation * noise) as f32);
            }
        }
        Photo {
            width,
            height,
            luminance,
            clip_level: None,
            clips_alone: true,
            transfer: Taken::default(),
            warnings: Vec::new(),
        }
    }

    fn scene(&self, seed: u64) -> Scene {
        let shot = |name: String, exposure: f64| Shot {
            image: PathBuf::from(name),
            exposure,
            rounding: None,
            roi: None,
            accepted: Vec::new(),
            decode: Decode::default(),
            place: FileLine {
                file: "simulated".into(),
                line: 0,
            },
        };
        let angles = [0.0, 20.0, 40.0];
        let captures: Vec<Capture> = angles
            .into_iter()
            .flat_map(|angle| [(angle, 150.0, 6.0), (angle, 300.0, 97.0)])
            .map(
                |(incidence_deg, floating_distance_mm, normal_deg)| Capture {
                    shot: shot(
                        format!("{incidence_deg} {floating_distance_mm} {normal_deg}"),
                        4.0,
                    ),
                    floating_distance_mm,
                    path_mm: None,
                    incidence_deg,
                    azimuth_deg: Some(AZIMUTH),
                    tangential_axis_deg: 0.0,
                },
            )
            .collect();
        let campaign = Campaign {
            file: "simulated".into(),
            setup: Setup {
                pixel_pitch_mm: PITCH_MM,
                seen_in_mirror: Some(false),
                half_mirror_transmittance: 0.5,
                half_mirror_reflectance: 0.5,
                spectrum: None,
                lamp: None,
                stray: Default::default(),
                polarisation: None,
            },
            references: vec![shot("source".into(), 1.0)],
            captures,
            warnings: Vec::new(),
        };
        let truth = planted::truth(Kernel::Eq1, LobeShape::Radial, 4.0, 0.2, 0.5);
        let table = planted::table(&truth, &angles, AZIMUTH);
        Scene::of(&campaign, &table, &|shot| {
            let name = shot.image.to_string_lossy();
            let numbers: Vec<f64> = name.split(' ').filter_map(|n| n.parse().ok()).collect();
            Ok(match numbers[..] {
                [angle, r_mm, normal_deg] => {
                    let theta = f64::to_radians(angle);
                    let (sin, cos) = f64::to_radians(normal_deg).sin_cos();
                    let eta = table
                        .direction(angle, Some(AZIMUTH))
                        .expect("it is there")
                        .retroreflected;
                    let light = returned(self.kernel, eta, theta, 1.49);
                    let width_px = self.width_mm(theta, [cos, sin], r_mm) / PITCH_MM;
                    let step = 0.8 * self.mu * light * 0.25 * shot.exposure;
                    self.photograph(width_px, normal_deg, step, seed + (angle + r_mm) as u64)
                }
                _ => {
                    let sharp = Sheet {
                        shape: LobeShape::Beckmann,
                        ..*self
                    };
                    sharp.photograph(0.0, 5.0, 0.8, seed)
                }
            })
        })
        .expect("the photographs hold edges")
    }
}

fn fitted<'a>(scene: &'a Scene, family: Family) -> Selection<'a> {
    let open = Candidates {
        kernels: family.kernels().to_vec(),
        shapes: family.shapes().to_vec(),
        spare_shapes: Vec::new(),
        per_angle_a: Some(false),
        per_angle_mu: None,
    };
    select(scene, Kind::Edge, &open, &Progress::SILENT).expect("candidates are open")
}

/// Photographs that a baseline describes return its roughness and mu within 4 standard errors (14
/// numbers), its lobe, and a chi-square of 1 within the error that the quadrature of the pixels
/// adds.
#[test]
fn planted_baselines_come_back() {
    let sheet = |kernel, shape, roughness, front| Sheet {
        kernel,
        shape,
        roughness,
        front,
        mu: 0.6,
    };
    let sheets = [
        sheet(Kernel::Saito, LobeShape::Beckmann, 5e-4, 0.0),
        sheet(Kernel::SaitoSurface, LobeShape::Beckmann, 3e-4, 3e-3),
        sheet(Kernel::Guo, LobeShape::Beckmann, 3e-3, 0.0),
        sheet(Kernel::Guo, LobeShape::Ggx, 2e-3, 0.0),
        sheet(Kernel::Mrm, LobeShape::Beckmann, 9e-4, 0.0),
        sheet(Kernel::Mrm, LobeShape::Ggx, 7e-4, 0.0),
    ];
    let mut numbers = 0;
    for (i, sheet) in sheets.iter().enumerate() {
        let scene = sheet.scene(1000 * i as u64 + 7);
        let selection = fitted(&scene, sheet.kernel.family());
        let best = &selection.best;
        let name = format!("{:?} {:?}", sheet.kernel, sheet.shape);
        assert_eq!(
            (best.choice.kernel, best.choice.shape),
            (sheet.kernel, sheet.shape),
            "{name}"
        );
        assert!(
            best.reduced_chi2() < 1.15,
            "{name}: {}",
            best.reduced_chi2()
        );
        let mu = best.mu.as_ref().expect("there is a reference");
        assert_eq!(mu.len(), 1, "{name}: one mu describes it");
        let mut found = vec![(best.spread[0], sheet.roughness), (mu[0], sheet.mu)];
        found.extend(best.c_mm.map(|front| (front, sheet.front)));
        for (value, truth) in found {
            let off = (value.value - truth) / value.standard_error;
            println!(
                "{name}: {} +- {} ({off:+.2})",
                value.value, value.standard_error
            );
            assert!(off.abs() < 4.0, "{name}: {value:?}, truth {truth}");
            assert!(value.standard_error < 0.02 * truth, "{name}: {value:?}");
            numbers += 1;
        }
    }
    assert_eq!(numbers, 13);
}
