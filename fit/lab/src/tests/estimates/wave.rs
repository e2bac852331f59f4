//! Tests of the wave kernel against the pupil on a raster, its limits, and planted answers.

use std::f64::consts::TAU;

use crate::planted::{camera, params, scene, table, truth};
use crate::simulate::PlantedSheet;
use edges::names::Kernel;
use edges::names::LobeShape;
use edges::names::Spectrum;
use estimator::estimate::Candidates;
use estimator::estimate::Kind;
use estimator::estimate::Progress;
use estimator::estimate::search::select::select;
use estimator::model::Fault;
use estimator::model::wave;
use num_complex::Complex64;
use tables::{Direction, NoWaves, Path, ShiftLine, Table, WaveLine};

const AZIMUTH_DEG: f64 = 20.0;

fn spectrum(text: &str) -> Spectrum {
    Spectrum::parse(text).expect("a good spectrum")
}

fn ideal(incidence_deg: &[f64]) -> Table {
    table(
        &truth(Kernel::Shift, LobeShape::Radial, 1.0, 0.2, 0.6),
        incidence_deg,
        AZIMUTH_DEG,
    )
}

fn direction(table: &Table, incidence_deg: f64) -> Direction {
    table
        .direction(incidence_deg, Some(AZIMUTH_DEG))
        .expect("the table holds it")
}

fn line(direction: &Direction, normal: [f64; 2], spectrum: &Spectrum) -> WaveLine {
    let incidence_rad = direction.incidence_deg.to_radians();
    wave::line(direction, incidence_rad, normal, Some(spectrum)).expect("exact corner cubes")
}

/// Autocorrelation of the pupil on a raster along the normal. Cells are weighted by their share in
/// the aperture; each has the phase 2 pi |y|^2/(lambda R) of its middle. Returns the frequency that
/// the lag stands for, and the OTF.
fn raster(
    direction: &Direction,
    normal: [f64; 2],
    c_mm: f64,
    wavelength_mm_r: f64,
    lag_share: f64,
) -> (f64, f64) {
    const ROWS: usize = 600;
    const CELLS: usize = 6000;
    let cosine = direction.incidence_deg.to_radians().cos();
    let cell = 1.8 * c_mm / CELLS as f64;
    let lag = (lag_share * CELLS as f64) as usize;
    let (mut sum, mut power) = (Complex64::ZERO, 0.0);
    for path in direction.paths.iter().flatten() {
        let corners: Vec<[f64; 2]> = path
            .polygon
            .iter()
            .map(|p| {
                let x = c_mm * cosine * (p[0] - 0.5 * path.offset[0]);
                let y = c_mm * (p[1] - 0.5 * path.offset[1]);
                [normal[0] * x + normal[1] * y, normal[0] * y - normal[1] * x]
            })
            .collect();
        let across = |pick: fn(f64, f64) -> f64| corners.iter().map(|p| p[1]).reduce(pick);
        let (low, high) = (across(f64::min).unwrap(), across(f64::max).unwrap());
        let width = (high - low) / ROWS as f64;
        for row in 0..ROWS {
            let t = low + (row as f64 + 0.5) * width;
            let ends: Vec<f64> = (0..corners.len())
                .filter_map(|k| {
                    let (p, q) = (corners[k], corners[(k + 1) % corners.len()]);
                    ((p[1] < t) != (q[1] < t))
                        .then(|| p[0] + (t - p[1]) / (q[1] - p[1]) * (q[0] - p[0]))
                })
                .collect();
            let (from, to) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            let pupil: Vec<Complex64> = (0..CELLS)
                .map(|i| {
                    let middle = (i as f64 + 0.5) * cell - 0.9 * c_mm;
                    let inside =
                        (to.min(middle + 0.5 * cell) - from.max(middle - 0.5 * cell)).max(0.0);
                    Complex64::cis(TAU * middle * middle / wavelength_mm_r) * (inside / cell)
                })
                .collect();
            let pairs = pupil[lag..].iter().zip(&pupil);
            sum += pairs.map(|(a, b)| a * b.conj()).sum::<Complex64>() * (width * cell);
            power += (to - from) * width;
        }
    }
    assert!(
        sum.im.abs() < 1e-9 * power,
        "the aperture is its own reflection"
    );
    (lag as f64 * cell / wavelength_mm_r, sum.re / power)
}

/// The closed form agrees with the pupil on a raster. A cell is 3e-4 edge lengths and the wave 4 pi
/// c f is at most 70 per edge length. So the middle of a cell gives its phase to (0.021)^2/24 =
/// 2e-5 of values that are below 0.1 there. 600 rows leave 1/(24 x 600^2) of the curvature of a
/// chord's integral, (70/2)^2, of such values: 1.4e-5.
#[test]
#[ignore = "seconds: `make test-full` runs it"]
fn closed_form_meets_the_pupil_on_a_raster() {
    let incidence = [0.0, 20.0, 40.0];
    let table = ideal(&incidence);
    let (mut cases, mut worst) = (0, 0.0_f64);
    for incidence_deg in incidence {
        let direction = direction(&table, incidence_deg);
        for normal_deg in [5.0_f64, 97.0] {
            let normal = [normal_deg.to_radians().cos(), normal_deg.to_radians().sin()];
            for (c, nm, r) in [
                (0.2, 550.0, 150.0),
                (0.08, 450.0, 300.0),
                (0.35, 620.0, 60.0),
            ] {
                let line = line(&direction, normal, &spectrum(&format!("{nm}")));
                for share in [0.03, 0.1, 0.55] {
                    let (f, expected) = raster(&direction, normal, c, nm * 1e-6 * r, share);
                    let found = line.otf(c, r, f).0.re;
                    worst = worst.max((found - expected).abs());
                    cases += 1;
                }
            }
        }
    }
    println!("{cases} cases, largest difference {worst:.2e}");
    assert_eq!(cases, 3 * 2 * 3 * 3);
    assert!(worst < 2e-5, "{worst:e}");
}

/// Radix-2 transform in place, along `values` (a power of 2 of them).
fn fft(values: &mut [Complex64], sign: f64) {
    let n = values.len();
    if n < 2 {
        return;
    }
    let (mut even, mut odd): (Vec<_>, Vec<_>) = values
        .chunks_exact(2)
        .map(|pair| (pair[0], pair[1]))
        .unzip();
    fft(&mut even, sign);
    fft(&mut odd, sign);
    for (k, (e, o)) in even.into_iter().zip(odd).enumerate() {
        let o = o * Complex64::cis(sign * TAU * k as f64 / n as f64);
        (values[k], values[k + n / 2]) = (e + o, e - o);
    }
}

/// The closed form agrees with the way of textbooks: pupil, its two-dimensional transform, the
/// power of that (the image of a point), and the transform back, which is the OTF at all lags at
/// once.
///
/// A cell on the border is in or out. No side runs along the raster. So 1,500 of 75,000 cells at 20
/// degrees are wrong by 0.29 of themselves at random: 1.5e-4, of which 4 are allowed. From cell to
/// cell the phase turns by 4 pi 0.16 mm / (lambda R) = 0.01 at most, which is negligible.
#[test]
fn closed_form_meets_the_transform_of_the_pupil() {
    const N: usize = 1024;
    let (c, r, nm) = (0.2, 150.0, 550.0);
    let lambda_r = nm * 1e-6 * r;
    // 512 cells per edge length, so that the aperture and its lags fit into the raster.
    let cell = c / 512.0;
    let table = ideal(&[0.0, 20.0]);
    let (mut cases, mut worst) = (0, 0.0_f64);
    for incidence_deg in [0.0_f64, 20.0] {
        let direction = direction(&table, incidence_deg);
        let cosine = incidence_deg.to_radians().cos();
        let (mut otf, mut power) = (vec![Complex64::ZERO; N * N], 0.0);
        for path in direction.paths.iter().flatten() {
            let corners: Vec<[f64; 2]> = path
                .polygon
                .iter()
                .map(|p| {
                    [
                        cosine * (p[0] - 0.5 * path.offset[0]),
                        p[1] - 0.5 * path.offset[1],
                    ]
                })
                .map(|p| p.map(|x| c * x))
                .collect();
            // The polygon is convex, so an inner point is on one side of all of its edges.
            let inside = |at: [f64; 2]| {
                let side = |k: usize| {
                    let (p, q) = (corners[k], corners[(k + 1) % corners.len()]);
                    (q[0] - p[0]) * (at[1] - p[1]) - (q[1] - p[1]) * (at[0] - p[0]) > 0.0
                };
                (1..corners.len()).all(|k| side(k) == side(0))
            };
            let place = |i: usize| (i as f64 + 0.5 - 0.5 * N as f64) * cell;
            let mut field: Vec<Complex64> = (0..N * N)
                .map(|i| {
                    let at = [place(i % N), place(i / N)];
                    let turn = TAU * (at[0] * at[0] + at[1] * at[1]) / lambda_r;
                    if inside(at) {
                        Complex64::cis(turn)
                    } else {
                        Complex64::ZERO
                    }
                })
                .collect();
            both_ways(&mut field, -1.0);
            for value in &mut field {
                *value = value.norm_sqr().into();
            }
            both_ways(&mut field, 1.0);
            // Cubes add incoherently.
            otf.iter_mut()
                .zip(&field)
                .for_each(|(sum, value)| *sum += value);
            power += field[0].re;
        }
        for (normal, step) in [([1.0, 0.0], 1), ([0.0, 1.0], N)] {
            let line = line(&direction, normal, &spectrum("550"));
            for lag in [3, 10, 31, 77, 150, 260] {
                let found = line.otf(c, r, lag as f64 * cell / lambda_r).0.re;
                let expected = otf[lag * step] / power;
                worst = worst.max((found - expected.re).abs());
                cases += 1;
            }
        }
    }
    println!("{cases} cases, largest difference {worst:.2e}");
    assert_eq!(cases, 2 * 2 * 6);
    assert!(worst < 6e-4, "{worst:e}");
}

/// Transforms the rows, then the columns, of a square.
fn both_ways(field: &mut [Complex64], sign: f64) {
    let n = field.len().isqrt();
    for _ in 0..2 {
        field.chunks_exact_mut(n).for_each(|row| fft(row, sign));
        for i in 0..n {
            for k in 0..i {
                field.swap(i * n + k, k * n + i);
            }
        }
    }
}

/// The derivative matches fourth-order differences over h = 1e-4 of ln c. The wave k = 4 pi c f
/// reaches 17 per edge length, so k^5 h^4/30 is 5e-12, and rounding 1e-14/h is 1e-10. (No case lies
/// within h of a lag that passes a corner, where the slope has a kink.)
#[test]
fn derivative_by_ln_c_matches_differences() {
    let incidence = [0.0, 20.0, 40.0];
    let table = ideal(&incidence);
    let (mut cases, mut worst) = (0, 0.0_f64);
    for incidence_deg in incidence {
        let direction = direction(&table, incidence_deg);
        for normal_deg in [0.0_f64, 5.0, 31.0, 90.0] {
            let normal = [normal_deg.to_radians().cos(), normal_deg.to_radians().sin()];
            let line = line(&direction, normal, &spectrum("450:0.2,550:0.5,620:0.3"));
            for (c, r) in [(0.2_f64, 150.0), (0.08, 300.0), (0.35, 60.0)] {
                for i in 1..30 {
                    let f = 0.13 * f64::from(i);
                    let h = 1e-4;
                    let at = |steps: f64| line.otf((c.ln() + steps * h).exp(), r, f).0.re;
                    let expected = (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * h);
                    worst = worst.max((line.otf(c, r, f).1.re - expected).abs());
                    cases += 1;
                }
            }
        }
    }
    println!("{cases} cases, largest difference {worst:.2e}");
    assert_eq!(cases, 3 * 4 * 3 * 29);
    assert!(worst < 2e-10, "{worst:e}");
}

/// For lambda R -> 0 the wave kernel is the ray shift, up to the kink times the lag. For a small
/// aperture it is the autocorrelation of the aperture.
#[test]
fn limits_are_ray_shift_and_diffraction() {
    let table = ideal(&[0.0, 20.0]);
    for incidence_deg in [0.0, 20.0] {
        let direction = direction(&table, incidence_deg);
        for normal_deg in [0.0_f64, 33.0, 90.0] {
            let normal = [normal_deg.to_radians().cos(), normal_deg.to_radians().sin()];
            let line = line(&direction, normal, &spectrum("550"));
            let rays = ShiftLine::new(&direction, incidence_deg.to_radians(), normal)
                .expect("light returns");
            for f in [0.1, 0.7, 1.9, 3.3] {
                let (c, r) = (0.25, 1e-4);
                let geometric = rays.otf(c, r, f).0;
                // The lag is 550e-6 x 1e-4 x 3.3 / 0.25 = 7e-7 edge lengths, and the kink is 2.
                // ShiftLine interpolates to 1e-6.
                let found = line.otf(c, r, f).0.re;
                assert!(
                    (geometric - found).norm() < 4e-6,
                    "{incidence_deg} {f}: {found} {geometric}"
                );
                // The lag is 0.3 edge lengths, the wave nearly 0.
                let (c, r) = (1e-3, 1e4);
                let (f, apertures) = raster(&direction, normal, c, 550e-6 * r, 0.1 * f);
                let found = line.otf(c, r, f).0.re;
                assert!((found - apertures).abs() < 2e-5, "{f}: {found} {apertures}");
            }
        }
    }
}

/// Pieces of one cube are one aperture; the same pieces as separate cubes are not. A spectrum is a
/// weighted sum of its lines.
#[test]
fn pieces_add_coherently_and_lines_add_up() {
    let table = ideal(&[20.0]);
    let whole = direction(&table, 20.0);
    let normal = [0.8, 0.6];
    // Every polygon is cut into a fan of triangles.
    let fan = |path: &Path, apart: f64| -> Vec<Path> {
        (1..path.polygon.len() - 1)
            .map(|k| {
                let by = [apart * k as f64, 0.0];
                let moved = |p: [f64; 2]| [p[0] + by[0], p[1]];
                Path {
                    polygon: [0, k, k + 1].map(|i| moved(path.polygon[i])).to_vec(),
                    offset: [path.offset[0] + 2.0 * by[0], path.offset[1]],
                    ..path.clone()
                }
            })
            .collect()
    };
    let with = |apart: f64| Direction {
        paths: whole
            .paths
            .as_ref()
            .map(|paths| paths.iter().flat_map(|path| fan(path, apart)).collect()),
        ..whole.clone()
    };
    let green = spectrum("550");
    let (one, pieces, strangers) = (
        line(&whole, normal, &green),
        line(&with(0.0), normal, &green),
        line(&with(100.0), normal, &green),
    );
    let lines = line(&whole, normal, &spectrum("450:1,550:3"));
    let blue = line(&whole, normal, &spectrum("450"));
    for i in 1..40 {
        let f = 0.1 * f64::from(i);
        let at = |line: &WaveLine| {
            let (value, slope) = line.otf(0.2, 150.0, f);
            (value.re, slope.re)
        };
        let (a, b) = (at(&one), at(&pieces));
        // Rounding of a few hundred terms.
        assert!(
            (a.0 - b.0).abs() < 1e-13 && (a.1 - b.1).abs() < 1e-11,
            "{f}: {a:?} {b:?}"
        );
        assert!((at(&lines).0 - 0.25 * at(&blue).0 - 0.75 * a.0).abs() < 1e-14);
    }
    // Separate triangles spread light further, so their OTF falls faster.
    assert!(strangers.otf(0.2, 150.0, 0.5).0.re < one.otf(0.2, 150.0, 0.5).0.re - 0.1);
    let kink = one.kink(0.2, 150.0);
    let small = 1e-6;
    let slope = (1.0 - one.otf(0.2, 150.0, small).0.re) / small;
    // The curvature adds an error of the order of 10 x 1e-6.
    assert!((kink - slope).abs() < 1e-4 && (pieces.kink(0.2, 150.0) - kink).abs() < 1e-9);
}

#[test]
fn what_the_waves_need_is_named() {
    let table = ideal(&[0.0, 20.0]);
    let held = direction(&table, 20.0);
    let bins = Direction {
        paths: None,
        exits: None,
        ..held.clone()
    };
    let tilted = Direction {
        paths: held.paths.clone().map(|mut paths| {
            paths[0].matrix[0][1] = 0.03;
            paths
        }),
        ..held.clone()
    };
    let green = spectrum("550");
    // Between its directions a table of polygons has waves too; they equal those of the direction
    // itself.
    let (between, own) = (direction(&table, 10.0), direction(&ideal(&[10.0]), 10.0));
    for normal in [[1.0, 0.0], [0.6, 0.8]] {
        let [a, b] = [&between, &own]
            .map(|direction| wave::line(direction, 0.1, normal, Some(&green)).unwrap());
        for frequency in [0.5, 2.0, 6.0] {
            let [a, b] = [&a, &b].map(|line| line.otf(0.2, 150.0, frequency).0.re);
            assert!((a - b).abs() < 1e-7, "{frequency}: {a} {b}");
        }
    }
    let fault = |direction: &Direction, spectrum: Option<&Spectrum>| {
        wave::line(direction, 0.1, [1.0, 0.0], spectrum).expect_err("it is refused")
    };
    assert_eq!(fault(&held, None), Fault::NoWavelength);
    let no_polygons = fault(&bins, Some(&green));
    assert!(
        no_polygons
            .to_string()
            .contains("bake trace --method exact")
    );
    assert_eq!(
        no_polygons,
        Fault::Table(NoWaves::NoPolygons {
            incidence_deg: 20.0
        })
    );
    assert_eq!(
        fault(&tilted, Some(&green)),
        Fault::Table(NoWaves::NoPointReflection {
            incidence_deg: 20.0
        })
    );
}

fn waves(c_mm: f64, lines: &str) -> PlantedSheet {
    PlantedSheet {
        spectrum: Some(spectrum(lines)),
        ..truth(Kernel::Wave, LobeShape::Radial, 1.0, c_mm, 0.6)
    }
}

/// Photographs by Fresnel integrals give c and mu within 4.5 of their errors, and the wave kernel
/// is chosen among all kernels. Without a wavelength it is no candidate.
#[test]
fn planted_campaigns_are_recovered() {
    let auto = Candidates {
        kernels: Kernel::ALL.to_vec(),
        shapes: vec![LobeShape::Radial],
        spare_shapes: Vec::new(),
        per_angle_a: None,
        per_angle_mu: None,
    };
    for (seed, (c, lines)) in [
        (0.08, "550"),
        (0.15, "450:0.2,550:0.5,620:0.3"),
        (0.24, "532"),
        (0.4, "620"),
    ]
    .into_iter()
    .enumerate()
    {
        let truth = waves(c, lines);
        let incidence = [0.0, 25.0];
        let table = table(&truth, &incidence, AZIMUTH_DEG);
        let campaign = params(
            50 + seed as u64,
            truth,
            &incidence,
            &[150.0, 300.0],
            camera(4e4),
        );
        let scene = scene(&campaign, &table);
        for kind in [Kind::Mtf, Kind::Edge] {
            let found = select(&scene, kind, &auto, &Progress::SILENT).unwrap().best;
            println!(
                "{c} {lines}: {:?} {:?} chi2 {:.1} of {}",
                found.choice.kernel, found.c_mm, found.chi2, found.residuals
            );
            assert_eq!(found.choice.kernel, Kernel::Wave, "{c} {lines}");
            let c_mm = found.c_mm.expect("wave has c");
            let mu = found.mu.as_ref().expect("there is a reference")[0];
            for (value, truth) in [(c_mm, c), (mu, 0.6)] {
                let pull = (value.value - truth) / value.standard_error;
                assert!(
                    pull.abs() < 4.5,
                    "{c} {lines}: {value:?}, {pull:.1} errors off"
                );
            }
            assert!(found.spread.is_empty());
        }
    }
}
