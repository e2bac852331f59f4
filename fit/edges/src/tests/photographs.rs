//! Tests of photographs with faults: charts, defects, uneven light, clipping. Each edge has a known
//! MTF, exp(-2 (pi sigma f)^2): a Gaussian, sampled at points. A repaired photograph must give that
//! MTF and a warning; a refused one must give its remedy.

use std::f64::consts::PI;

use rayon::prelude::*;

use crate::photographs::Measurement;
use crate::photographs::Roi;
use crate::photographs::edge::fault::Accepted;
use crate::photographs::edge::fault::Fault;
use crate::photographs::edge::line::{Bend, EdgeLine};
use crate::photographs::edge::shape;
use crate::photographs::measure::edge;
use crate::photographs::photo;
use crate::photographs::photo::channel::Decode;
use crate::photographs::photo::plane::Photo;
use crate::photographs::photo::taken::Taken;
use crate::photographs::photo::transfer::Transfer;
use crate::photographs::{Estimator, Profile, Window, standard_error};

const SIGMA_PX: f64 = 0.8;
pub(crate) const DARK: f64 = 0.1;
pub(crate) const BRIGHT: f64 = 0.7;
/// Standard deviation of a pixel's noise.
pub(crate) const NOISE: f64 = 0.001;

/// Uniform numbers in [0, 1) and normal numbers, by splitmix64 of a seed.
struct Stream(u64);

impl Stream {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (2.0 * PI * self.uniform()).cos()
    }
}

/// Share of a Gaussian below s.
pub(crate) fn rise(s: f64, sigma: f64) -> f64 {
    0.5 * libm::erfc(-s / sigma / std::f64::consts::SQRT_2)
}

pub(crate) fn photo(width: usize, height: usize, light: impl Fn(f64, f64) -> f64) -> Photo {
    let at = |i: usize| light((i % width) as f64, (i / width) as f64) as f32;
    Photo {
        width,
        height,
        luminance: (0..width * height).map(at).collect(),
        clip_level: Some(1.0),
        clips_alone: true,
        transfer: Taken::default(),
        warnings: Vec::new(),
    }
}

/// Distance from the line through (x0, y0) whose normal has the direction `deg`, degrees.
fn distance(x: f64, y: f64, x0: f64, y0: f64, deg: f64) -> f64 {
    let (sin, cos) = deg.to_radians().sin_cos();
    (x - x0) * cos + (y - y0) * sin
}

/// A photograph of an edge through the middle of 240 x 200 pixels. `change` changes the light at
/// (x, y); noise is added afterwards.
fn degraded(deg: f64, sigma: f64, seed: u64, change: impl Fn(f64, f64, f64) -> f64) -> Photo {
    let photo = photo(240, 200, |x, y| {
        let s = distance(x, y, 120.3, 99.1, deg);
        change(x, y, DARK + (BRIGHT - DARK) * rise(s, sigma))
    });
    noisy(photo, seed)
}

pub(crate) fn noisy(photo: Photo, seed: u64) -> Photo {
    with_noise(photo, seed, NOISE)
}

/// Adds normal noise of a standard deviation.
pub(crate) fn with_noise(mut photo: Photo, seed: u64, deviation: f64) -> Photo {
    let mut stream = Stream(seed);
    for value in &mut photo.luminance {
        *value += (deviation * stream.normal()) as f32;
    }
    photo
}

/// The largest difference of the measured MTF from the known one, up to half the sampling
/// frequency, and the largest standard error there.
fn error(measured: &Measurement, sigma: f64) -> (f64, f64) {
    error_from(measured, |f| gaussian(sigma, f))
}

/// The MTF of a Gaussian.
fn gaussian(sigma: f64, f: f64) -> f64 {
    (-2.0 * (PI * sigma * f).powi(2)).exp()
}

/// As [`error`], for any known MTF.
fn error_from(measured: &Measurement, known: impl Fn(f64) -> f64) -> (f64, f64) {
    let frequencies: Vec<f64> = (1..=50).map(|k| 0.01 * f64::from(k)).collect();
    let estimator = Estimator::new(&measured.profile, 1.0, 400, 50);
    let mtf = estimator.measure(&measured.profile);
    let noise = standard_error(&estimator.response(&measured.profile), &measured.profile);
    let worst = frequencies
        .iter()
        .zip(&mtf.modulus[1..])
        .map(|(&f, m)| (m - known(f)).abs());
    (
        worst.fold(0.0, f64::max),
        noise.iter().copied().fold(0.0, f64::max),
    )
}

fn warned(measured: &Measurement, word: &str) -> bool {
    measured.warnings.iter().any(|text| text.contains(word))
}

/// A photograph of an edge with sinusoidal waves of an amplitude and a period, pixels. They are too
/// short for the curve of the estimator.
fn wave(amplitude: f64, period: f64) -> Photo {
    let clean = photo(240, 200, |x, y| {
        let off = amplitude * (2.0 * PI * y / period).sin();
        DARK + 0.6 * rise(distance(x, y, 120.3, 99.1, 5.0) + off, SIGMA_PX)
    });
    noisy(clean, 9)
}

/// A repaired photograph has a warning with `word`, and an MTF error of at most 4 standard errors
/// by noise plus `bias`.
fn repaired(name: &str, photo: &Photo, word: &str, bias: f64) {
    let measured = edge(photo, None, &[]).unwrap_or_else(|fault| panic!("{name}: {fault}"));
    let (error, noise) = error(&measured, SIGMA_PX);
    println!(
        "{name}: MTF error {error:.5}, noise {noise:.5}, {:?}",
        measured.warnings
    );
    assert!(warned(&measured, word), "{name}: {:?}", measured.warnings);
    assert_eq!(
        measured.warnings.len(),
        1,
        "{name}: {:?}",
        measured.warnings
    );
    assert!(
        error < 4.0 * noise + bias,
        "{name}: {error} at a noise of {noise}"
    );
}

#[test]
fn a_clean_edge_of_any_direction_and_polarity_has_no_warning() {
    let mut cases = 0;
    for quarter in [0.0, 90.0, 180.0, -90.0] {
        for tilt in [1.0, 5.0, 12.0, 31.0, 44.0, -1.5, -20.0] {
            let photo = degraded(quarter + tilt, SIGMA_PX, 7 + cases, |_, _, v| v);
            let measured = edge(&photo, None, &[]).unwrap();
            assert_eq!(
                measured.warnings,
                Vec::<String>::new(),
                "{} deg",
                quarter + tilt
            );
            let (error, noise) = error(&measured, SIGMA_PX);
            // 28 pictures of 50 frequencies: 5 standard errors are exceeded once in 1000 runs of
            // all.
            assert!(
                error < 5.0 * noise,
                "{} deg: {error} {noise}",
                quarter + tilt
            );
            cases += 1;
        }
    }
    assert_eq!(cases, 28);
}

/// Corners of the window that lie beyond the profile take part in the likelihood, so their wild
/// pixels are left out too. They are known exactly: each lies off by 0.2 of full scale, which is
/// more than 8 standard deviations and a third of the step.
#[test]
fn wild_pixels_beyond_the_profile_are_left_out() {
    for tilt in [5.0, 31.0] {
        let clean = degraded(tilt, SIGMA_PX, 3, |_, _, v| v);
        let mut photo = clean.clone();
        let (width, height) = (photo.width, photo.height);
        let corners = [0, width - 1].map(|x| [0, height - 1].map(|y| y * width + x));
        for &at in corners.as_flattened() {
            photo.luminance[at] += 0.2;
        }
        let [before, after] = [&clean, &photo].map(|photo| {
            let measured = edge(photo, None, &[]).unwrap();
            let end = measured.profile.reach as f64 * crate::photographs::BIN_PX;
            let pixels = || measured.window.pixels();
            let ruler = measured.line.ruler();
            let beyond = pixels().filter(|p| ruler.place(p.x, p.y).0.abs() > end);
            [pixels().count(), beyond.count()]
        });
        // The corners of this tilt lie beyond the profile, at least two of them.
        assert!(before[1] >= 2, "{tilt} deg: {before:?}");
        assert_eq!(before[0] - after[0], 4, "{tilt} deg");
    }
}

/// A value that many bright pixels share is a ceiling only if none lies above it. With the noise
/// cut off at the plateau, half of the plateau is at the ceiling; the share is that of all pixels
/// above the middle, of which the edge of 0.8 pixels takes less than 2 %. Where a tenth of the
/// bright pixels have the value of the plateau, with as many above it as below, nothing is clipped.
#[test]
fn a_value_is_a_ceiling_if_nothing_lies_above_it() {
    let clean = degraded(5.0, SIGMA_PX, 1, |_, _, v| v);
    let level = BRIGHT as f32;
    let mut cut = clean.clone();
    cut.luminance.iter_mut().for_each(|v| *v = v.min(level));
    let Err(Fault::Clipped { share, level: at }) = edge(&cut, None, &[]) else {
        panic!("it is clipped");
    };
    assert!(
        (share - 0.5).abs() < 0.02 && at == f64::from(level),
        "{share} {at}"
    );
    let mut common = clean;
    let plateau = common.luminance.iter_mut().filter(|v| **v > 0.65);
    plateau.step_by(10).for_each(|v| *v = level);
    let measured = edge(&common, None, &[]).expect("nothing is clipped");
    assert_eq!(measured.warnings, Vec::<String>::new());
}

/// The waves of an edge are those that were planted, and lower the MTF where it is one half as a
/// displaced edge does: a sine of amplitude A by the Bessel function J0(2 pi f A), here of f =
/// sqrt(ln 2 / 2) / (pi sigma). Pieces of 8 pixels see sinc(8 / 40) = 0.935 of a sine of 40 pixels,
/// and the curve of the edge takes at most (10 / 5 pi)^2 = 40 % of the variance of five periods. So
/// 0.72 to 1 of the amplitude is found. The rise is read off to half a bin at each end, which is
/// 2.5 % of the blur and 5 % of the loss.
#[test]
fn waves_lower_the_mtf_by_what_is_stated() {
    const BLUR_PX: f64 = 4.0;
    for amplitude in [0.4, 0.8] {
        let clean = photo(240, 200, |x, y| {
            let off = amplitude * (2.0 * PI * y / 40.0).sin();
            DARK + 0.6 * rise(distance(x, y, 120.3, 99.1, 5.0) + off, BLUR_PX)
        });
        let measured = edge(&noisy(clean, 9), None, &[]).expect("small waves are measured");
        let waves = shape::waves(&measured.window, &measured.line, &measured.profile);
        let half = (0.5 * 2.0_f64.ln()).sqrt() / (PI * BLUR_PX);
        let of = |amplitude: f64| 1.0 - libm::j0(2.0 * PI * half * amplitude);
        let found = waves.rms_px * 2.0_f64.sqrt();
        println!(
            "{amplitude}: {found:.3} px, loss {:.5} of {:.5}",
            waves.loss,
            of(found)
        );
        assert!((0.7..1.02).contains(&(found / amplitude)), "{found}");
        assert!((waves.loss / of(found) - 1.0).abs() < 0.06, "{waves:?}");
    }
}

/// The standard error of the angle is the scatter of the angle: of edges in white noise, in noise
/// that grows with the light, and in noise that neighbours share (a filter, with the same pixels
/// otherwise). The mean square pull of n draws scatters by sqrt(2 / n); the limit is 4 of these.
/// The factor of shared noise is some 4 % too low besides (see `correlation`).
#[test]
#[ignore = "seconds: `make test-full` runs it"]
fn the_error_of_the_angle_is_its_scatter() {
    for (name, draws, height, filter, [read, gain]) in [
        ("white", 300, 64, [0.0, 1.0, 0.0], [1e-4, 0.0]),
        ("shot", 150, 64, [0.0, 1.0, 0.0], [0.0, 2e-4]),
        ("shared", 60, 200, [0.25, 0.5, 0.25], [4e-4, 0.0]),
    ] {
        let (size, middle) = ([64, height], 0.5 * height as f64 - 1.0);
        let pull = |seed: u64| {
            let mut stream = Stream(0xa9e1 << 20 | seed);
            let deg = 3.0 + 12.0 * stream.uniform();
            let place = [stream.uniform(), stream.uniform()];
            let clean = photo(size[0], size[1], |x, y| {
                let s = distance(x, y, 31.0 + place[0], middle + place[1], deg);
                DARK + (BRIGHT - DARK) * rise(s, 1.5)
            });
            let noise: Vec<f64> = clean
                .luminance
                .iter()
                .map(|&light| (read + gain * f64::from(light)).sqrt() * stream.normal())
                .collect();
            let mut noisy = clean;
            for (i, value) in noisy.luminance.iter_mut().enumerate() {
                let (x, y) = (i % size[0] + size[0], i / size[0] + size[1]);
                let at = |j: usize, k: usize| {
                    noise[(y + j - 1) % size[1] * size[0] + (x + k - 1) % size[0]]
                };
                let rows = |j: usize| (0..3).map(move |k| (j, k));
                let all = (0..3).flat_map(rows);
                *value += all
                    .map(|(j, k)| filter[j] * filter[k] * at(j, k))
                    .sum::<f64>() as f32;
            }
            let line = edge(&noisy, None, &[]).expect("there is an edge").line;
            (line.normal_rad - deg.to_radians()) / line.normal_standard_error_rad
        };
        let pulls: Vec<f64> = (0..draws).into_par_iter().map(pull).collect();
        let square = pulls.iter().map(|pull| pull * pull).sum::<f64>() / draws as f64;
        println!("{name}: mean square pull of {draws} angles {square:.3}");
        let scatter = 4.0 * (2.0 / draws as f64).sqrt();
        assert!((square - 1.0).abs() < scatter + 0.04, "{name}: {square}");
    }
}

#[test]
fn hot_and_dead_pixels_are_left_out() {
    let mut stream = Stream(11);
    for (name, value) in [("hot", 1.0_f32), ("dead", 0.0), ("wild", 5e4)] {
        let mut photo = degraded(5.0, SIGMA_PX, 3, |_, _, v| v);
        let pixels = photo.luminance.len();
        for _ in 0..pixels / 2_000 {
            let at = (stream.uniform() * pixels as f64) as usize;
            photo.luminance[at] = value;
        }
        if name == "wild" {
            photo.clip_level = None;
        }
        let measured = edge(&photo, None, &[]).unwrap();
        assert!(
            warned(&measured, "left out"),
            "{name}: {:?}",
            measured.warnings
        );
        let (error, noise) = error(&measured, SIGMA_PX);
        println!("{name}: MTF error {error:.5}, noise {noise:.5}");
        assert!(error < 4.0 * noise, "{name}: {error} at a noise of {noise}");
    }
}

#[test]
fn uneven_light_is_evened_out() {
    // The light falls by 20 % from the middle to the corners, as cos^4 of the field angle.
    let vignette = |x: f64, y: f64| {
        let r2 =
            ((x - 120.0).powi(2) + (y - 100.0).powi(2)) / (120.0_f64.powi(2) + 100.0_f64.powi(2));
        (1.0 + r2 * (0.8_f64.powf(-0.5) - 1.0)).powi(-2)
    };
    let mut cases = 0;
    for deg in [5.0, 98.0, -160.0] {
        // The polynomial leaves 3 x^4, x^2 = 0.056, less its part of lower order: 0.2 % of the
        // light.
        repaired(
            "vignetting",
            &degraded(deg, SIGMA_PX, 5, |x, y, v| v * vignette(x, y)),
            "light varies",
            0.002,
        );
        // A linear gradient is part of the model.
        repaired(
            "gradient across",
            &degraded(deg, SIGMA_PX, 6, |x, _, v| {
                v * (1.0 + 0.15 * (x / 120.0 - 1.0))
            }),
            "light varies",
            0.001,
        );
        repaired(
            "gradient along",
            &degraded(deg, SIGMA_PX, 8, |_, y, v| {
                v * (1.0 + 0.15 * (y / 100.0 - 1.0))
            }),
            "light varies",
            0.001,
        );
        cases += 3;
    }
    assert_eq!(cases, 9);
}

/// A veil changes both plateaus alike. The MTF stays right without a repair.
#[test]
fn a_veil_needs_no_repair() {
    let measured = edge(
        &degraded(8.0, SIGMA_PX, 2, |_, _, v| 0.3 + 0.5 * v),
        None,
        &[],
    )
    .unwrap();
    assert_eq!(measured.warnings, Vec::<String>::new());
    let (error, noise) = error(&measured, SIGMA_PX);
    assert!(error < 4.0 * noise, "{error} at a noise of {noise}");
}

/// Faults that would make the answer wrong are refused, each by its own variant and with a remedy.
#[test]
fn what_cannot_be_repaired_is_refused() {
    let refused = |photo: &Photo| {
        edge(photo, None, &[])
            .map(|m| m.warnings)
            .expect_err("a fault")
    };
    let clip = |mut photo: Photo, low: f32, high: f32| {
        photo
            .luminance
            .iter_mut()
            .for_each(|v| *v = v.clamp(low, high));
        photo
    };
    let shifted = |distance_px: f64, share: f64| {
        photo(240, 200, |x, y| {
            let s = distance(x, y, 120.3, 99.1, 6.0);
            DARK + 0.5 * (rise(s, SIGMA_PX) + share * rise(s - distance_px, SIGMA_PX))
        })
    };
    type Is = fn(&Fault) -> bool;
    let cases: [(&str, Photo, Is, &str); 11] = [
        (
            "highlights at full scale",
            clip(degraded(5.0, SIGMA_PX, 1, |_, _, v| 1.5 * v), 0.0, 1.0),
            |f| matches!(f, Fault::Clipped { .. }),
            "expose less",
        ),
        (
            "highlights at the camera's ceiling",
            clip(degraded(5.0, SIGMA_PX, 1, |_, _, v| v), 0.0, 0.7),
            |f| matches!(f, Fault::Clipped { .. }),
            "expose less",
        ),
        (
            "highlights without noise",
            clip(
                photo(240, 200, |x, y| {
                    1.2 * rise(distance(x, y, 120.0, 99.0, 5.0), 0.8)
                }),
                0.1,
                1.0,
            ),
            |f| matches!(f, Fault::Clipped { .. }),
            "expose less",
        ),
        (
            "darks",
            clip(degraded(5.0, SIGMA_PX, 1, |_, _, v| v - 0.11), 0.0, 1.0),
            |f| matches!(f, Fault::CutOff { .. }),
            "black offset",
        ),
        (
            "doubled",
            shifted(6.0, 0.5),
            |f| {
                matches!(f, Fault::Doubled { share, distance_px }
                if (share - 0.5).abs() < 0.05 && (distance_px - 6.0).abs() < 0.5)
            },
            "second reflection",
        ),
        (
            "defocused",
            degraded(5.0, 60.0, 1, |_, _, v| v),
            |f| matches!(f, Fault::Blurred { .. }),
            "focus",
        ),
        (
            "wavy",
            wave(0.9, 40.0),
            |f| {
                matches!(f, Fault::Wavy { rms_px, .. }
                if (rms_px - 0.9 / f64::sqrt(2.0)).abs() < 0.15)
            },
            "smoother part",
        ),
        (
            "no edge",
            degraded(5.0, SIGMA_PX, 1, |_, _, _| 0.5),
            |f| matches!(f, Fault::NoContrast { .. }),
            "exposure",
        ),
        (
            "tiny",
            photo(12, 12, |x, y| {
                0.1 + 0.8 * rise(distance(x, y, 6.0, 6.0, 5.0), 0.8)
            }),
            |f| matches!(f, Fault::TooSmall),
            "larger roi",
        ),
        (
            "narrow",
            photo(2, 20_001, |_, y| 0.1 + 0.8 * rise(y - 10_000.0, 0.8)),
            |f| matches!(f, Fault::TooSmall),
            "larger roi",
        ),
        (
            "a bar",
            degraded(5.0, SIGMA_PX, 1, |x, _, _| {
                if (100.0..130.0).contains(&x) {
                    0.9
                } else {
                    0.1
                }
            }),
            |f| {
                matches!(
                    f,
                    Fault::NoSlantedEdge { .. }
                        | Fault::SeveralEdges { .. }
                        | Fault::NoContrast { .. }
                )
            },
            "roi",
        ),
    ];
    let count = cases.len();
    for (name, photo, is, remedy) in cases {
        let fault = refused(&photo);
        println!("{name}: {fault}");
        assert!(is(&fault), "{name}: {fault:?}");
        assert!(fault.to_string().contains(remedy), "{name}: {fault}");
    }
    assert_eq!(count, 11);
}

/// An accepted doubled edge is measured as it is, with a warning. Its MTF is that of the lens times
/// that of the two edges, |1 + share exp(-2 pi i f distance)| / (1 + share). Its other faults are
/// still refused.
#[test]
fn an_accepted_doubled_edge_is_measured() {
    for (share, apart) in [(0.2, 6.0), (0.5, 6.0), (0.3, 11.0)] {
        let doubled = photo(240, 200, |x, y| {
            let s = distance(x, y, 120.3, 99.1, 6.0);
            DARK + 0.4 * (rise(s, SIGMA_PX) + share * rise(s - apart, SIGMA_PX))
        });
        let doubled = noisy(doubled, 3);
        assert!(matches!(
            edge(&doubled, None, &[]),
            Err(Fault::Doubled { .. })
        ));
        let measured = edge(&doubled, None, &[Accepted::Doubled]).expect("it is accepted");
        assert!(warned(&measured, "doubled"), "{:?}", measured.warnings);
        assert_eq!(measured.warnings.len(), 1, "{:?}", measured.warnings);
        let estimator = Estimator::new(&measured.profile, 1.0, 400, 50);
        let mtf = estimator.measure(&measured.profile);
        let noise = standard_error(&estimator.response(&measured.profile), &measured.profile);
        let noise = noise.iter().copied().fold(0.0, f64::max);
        let worst = (1..=50)
            .map(|k| {
                let f = 0.01 * f64::from(k);
                let phase = 2.0 * PI * f * apart;
                let two = (1.0 + share * phase.cos()).hypot(share * phase.sin()) / (1.0 + share);
                let known = two * (-2.0 * (PI * SIGMA_PX * f).powi(2)).exp();
                (mtf.modulus[k as usize] - known).abs()
            })
            .fold(0.0, f64::max);
        println!("share {share}, {apart} px apart: MTF error {worst:.5}, noise {noise:.5}");
        // Beside noise, the taper costs a curve that turns within 1/apart: the second derivative of
        // the MTF by f, share (2 pi apart)^2, times half the variance of the taper's transform,
        // about (0.5 / 200 px)^2.
        let taper = 0.5 * share * (2.0 * PI * apart * 0.5 / 200.0).powi(2);
        assert!(worst < 4.0 * noise + taper, "{worst} at a noise of {noise}");
    }
    let wide = degraded(5.0, 60.0, 1, |_, _, v| v);
    let fault = edge(&wide, None, &[Accepted::Doubled]).map(|m| m.warnings);
    assert!(matches!(fault, Err(Fault::Blurred { .. })), "{fault:?}");
}

/// A region is called by its fault: black, clipped or without contrast. The file is 8-bit, linear.
#[test]
fn regions_of_one_value_are_called_by_it() {
    let mut cases = 0;
    let mut check = |what: &str, light: &dyn Fn(f64, f64) -> f64, kind: &str, words: &str| {
        let fault = edge(&photo(240, 200, light), None, &[]).expect_err(what);
        assert_eq!(fault.kind(), kind, "{what}: {fault}");
        assert!(fault.to_string().contains(words), "{what}: {fault}");
        cases += 1;
    };
    let hot = |x: f64, y: f64, light: f64| if x == 7.0 && y == 9.0 { light } else { 0.0 };
    check(
        "black",
        &|_, _| 0.0,
        "black",
        "the region is black: 100.0 % of its pixels",
    );
    check(
        "black but one",
        &|x, y| hot(x, y, 0.9),
        "black",
        "check the roi",
    );
    let few = |x: f64, _: f64| {
        if x % 5.0 == 0.0 {
            1.0 / 255.0 / 12.92
        } else {
            0.0
        }
    };
    check(
        "black with a step of noise",
        &few,
        "black",
        "80.0 % of its pixels are exactly 0",
    );
    check("white", &|_, _| 1.0, "clipped", "expose less");
    check(
        "grey",
        &|_, _| 0.3,
        "no contrast",
        "give the roi of the edge",
    );
    check(
        "dark grey",
        &|_, _| 0.001,
        "no contrast",
        "give the roi of the edge",
    );
    // An edge between black and little light is an edge whose darks are cut off.
    let edge = |x: f64, y: f64| 0.01 * f64::from(u8::from(x > 140.0 + 0.1 * y));
    check("dim", &edge, "cut off at 0", "black offset");
    assert_eq!(cases, 7);
}

/// Lesser faults cause warnings: 2 % of the bright pixels clipped at the tail of their noise,
/// slight waves, wide tails.
#[test]
fn lesser_faults_are_warnings() {
    let mut clipped = degraded(5.0, SIGMA_PX, 4, |_, _, v| v + 1.0 - BRIGHT - 2.05 * NOISE);
    clipped.luminance.iter_mut().for_each(|v| *v = v.min(1.0));
    repaired("clipped noise", &clipped, "clipped", 0.001);
    let straight = degraded(5.0, SIGMA_PX, 4, |_, _, v| v);
    assert!(edge(&straight, None, &[]).is_ok_and(|m| !warned(&m, "wavy")));
    assert!(edge(&wave(0.15, 40.0), None, &[]).is_ok_and(|m| warned(&m, "wavy")));
    assert!(
        edge(&degraded(5.0, 50.0, 4, |_, _, v| v), None, &[])
            .is_ok_and(|m| warned(&m, "does not fade out"))
    );
}

/// A chart on white: a dark quadrangle with sides 90 pixels from its middle, the normals of the
/// sides in degrees; bars, dots and a frame.
fn chart(width: usize, height: usize, sides_deg: [f64; 4]) -> Photo {
    let (cx, cy) = (0.55 * width as f64, 0.5 * height as f64);
    let unit = width as f64 / 600.0;
    let clean = photo(width, height, |x, y| {
        let side = |deg: &f64| rise(90.0 * unit - distance(x, y, cx, cy, *deg), SIGMA_PX);
        let inside: f64 = sides_deg.iter().map(side).product();
        let (u, v) = (x / unit, y / unit);
        let bars = (20.0..90.0).contains(&u)
            && (40.0..360.0).contains(&v)
            && (v as usize / 6).is_multiple_of(2);
        let dots = v > 370.0 && ((u - 300.0).abs() % 20.0 - 10.0).hypot(v - 385.0) < 4.0;
        let frame = !(5.0..595.0).contains(&u) || !(5.0..395.0).contains(&v);
        let paper = if bars || dots || frame { DARK } else { BRIGHT };
        paper + (DARK - paper) * inside
    });
    noisy(clean, 17)
}

fn square(tilt: f64) -> [f64; 4] {
    [0.0, 90.0, 180.0, 270.0].map(|quarter| quarter + tilt)
}

/// The four edges of a square among other marks are offered as regions. Each region gives the right
/// measurement.
#[test]
fn a_chart_offers_its_edges() {
    let mut cases = 0;
    for tilt in [4.0, 10.0, -15.0, 30.0] {
        let photo = chart(600, 400, square(tilt));
        let Err(Fault::Choice(rois)) = edge(&photo, None, &[]) else {
            panic!(
                "{tilt} deg: {:?}",
                edge(&photo, None, &[]).map(|m| m.warnings)
            );
        };
        assert_eq!(rois.len(), 4, "{tilt} deg: {rois:?}");
        for roi in rois {
            let measured = edge(&photo, Some(roi), &[]).unwrap();
            let (error, noise) = error(&measured, SIGMA_PX);
            // The estimator's own error is below 0.002 (see edge.rs).
            assert!(
                error < 0.002 + 4.0 * noise,
                "{tilt} deg, {roi}: {error}, noise {noise}"
            );
            cases += 1;
        }
        let text = edge(&photo, None, &[]).map(|_| ()).unwrap_err().to_string();
        assert!(
            text.contains("roi = [") && text.contains("4 edges"),
            "{text}"
        );
    }
    assert_eq!(cases, 16);
}

/// If only one edge of a chart is slanted, it is used, with a warning that names its region. Its
/// normal, from dark to bright, points out of the quadrangle.
#[test]
fn the_only_edge_of_a_chart_is_found() {
    let photo = chart(600, 400, [8.0, 90.0, 180.0, 270.0]);
    let measured = edge(&photo, None, &[]).unwrap();
    let found = format!("give {}", measured.region);
    assert!(warned(&measured, &found), "{:?}", measured.warnings);
    assert!((measured.line.normal_rad.to_degrees() - 8.0).abs() < 0.01);
    let (error, noise) = error(&measured, SIGMA_PX);
    assert!(error < 0.002 + 4.0 * noise, "{error}, noise {noise}");
}

/// A region that the user chose is used as it is.
#[test]
fn a_given_region_is_measured() {
    let photo = chart(600, 400, square(8.0));
    let roi = Roi {
        x: 380,
        y: 160,
        width: 80,
        height: 80,
    };
    let measured = edge(&photo, Some(roi), &[]).unwrap();
    assert_eq!(measured.region, roi);
    assert_eq!(measured.warnings, Vec::<String>::new());
    let (error, noise) = error(&measured, SIGMA_PX);
    assert!(error < 0.002 + 4.0 * noise, "{error}, noise {noise}");
}

/// A region of a camera's JPEG of 24 megapixels, 8 bits per colour, is measured from its file. The
/// noise of the 8 bits and of the JPEG's whole coefficients is part of the pixels' scatter. Beside
/// noise 0.001 is allowed: the bins cost 0.0007 on known edges.
#[test]
#[ignore = "seconds: `make test-full` runs it"]
fn a_jpeg_of_24_megapixels_is_measured() {
    const WIDTH: usize = 6000;
    const HEIGHT: usize = 4000;
    let mut stream = Stream(24);
    let mut bytes = Vec::with_capacity(3 * WIDTH * HEIGHT);
    for i in 0..WIDTH * HEIGHT {
        let s = distance((i % WIDTH) as f64, (i / WIDTH) as f64, 3000.3, 1999.1, 5.0);
        let light = DARK + (BRIGHT - DARK) * rise(s, SIGMA_PX) + 0.004 * stream.normal();
        let code = (255.0 * Transfer::Srgb.to_stored(light as f32)).round() as u8;
        bytes.extend([code; 3]);
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("edge.jpg");
    let written = std::fs::File::create(&file).expect("the folder takes files");
    image::codecs::jpeg::JpegEncoder::new_with_quality(std::io::BufWriter::new(written), 100)
        .encode(
            &bytes,
            WIDTH as u32,
            HEIGHT as u32,
            image::ExtendedColorType::Rgb8,
        )
        .expect("it can be encoded");
    drop(bytes);
    let start = std::time::Instant::now();
    let photo = photo::load(&file, &Decode::default()).expect("it is a JPEG");
    println!("read in {:.2} s", start.elapsed().as_secs_f64());
    let part = Roi {
        x: 2920,
        y: 1800,
        width: 160,
        height: 400,
    };
    let measured = edge(&photo, Some(part), &[]).unwrap_or_else(|fault| panic!("{fault}"));
    let (error, noise) = error(&measured, SIGMA_PX);
    println!("MTF error {error:.5}, noise {noise:.5}");
    assert!(warned(&measured, "8-bit"), "{:?}", measured.warnings);
    // The colours of a JPEG are stored at half the resolution.
    assert!(warned(&measured, "correlated"), "{:?}", measured.warnings);
    assert_eq!(measured.warnings.len(), 2, "{:?}", measured.warnings);
    assert!(error < 4.0 * noise + 0.001, "{error} at a noise of {noise}");
}

/// At an angle of a simple fraction the pixels of a bin lie at one end of it. They are no defects,
/// even if there is no noise to hide the difference.
#[test]
fn simple_fractions_without_noise_have_no_defects() {
    for fraction in [
        1.0 / 3.0,
        1.0 / 2.0,
        2.0 / 3.0,
        3.0 / 4.0,
        4.0 / 3.0,
        3.0 / 2.0_f64,
    ] {
        let deg = fraction.atan().to_degrees();
        for offset in [-0.44, 0.02, 0.3] {
            let sharp = photo(192, 128, |x, y| {
                DARK + (BRIGHT - DARK) * rise(distance(x, y, 95.5, 63.5, deg) - offset, 0.62)
            });
            let measured = edge(&sharp, None, &[])
                .unwrap_or_else(|fault| panic!("{deg:.2} deg, {offset} px: {fault}"));
            assert!(
                !warned(&measured, "left out"),
                "{deg:.2} deg: {:?}",
                measured.warnings
            );
        }
    }
}

/// An edge whose odd rows, or columns, are shifted is refused as such, and is not repaired as one
/// with hot pixels. An edge whose shift is small is measured with it: rows that are shifted by d
/// across the edge have cos(pi d f) of its MTF. The estimator is right to
/// 0.002; 100 frequencies exceed 4.5 standard errors once in 1,500 tests.
#[test]
fn shifted_rows_are_a_fault_of_their_own() {
    let mut cases = [0, 0, 0];
    for (deg, columns) in [(5.0, false), (12.0, false), (95.0, true)] {
        for shift in [0.0, 0.15, 0.5, 1.0, 1.5, 3.0] {
            let clean = photo(240, 200, |x, y| {
                let [along, other] = if columns { [y, x] } else { [x, y] };
                let along = along - if other % 2.0 == 1.0 { shift } else { 0.0 };
                let [x, y] = if columns {
                    [other, along]
                } else {
                    [along, other]
                };
                DARK + 0.6 * rise(distance(x, y, 120.3, 99.1, deg), SIGMA_PX)
            });
            let found = edge(&noisy(clean, 3), None, &[]);
            let case = format!("{deg} {shift}: {found:?}");
            // Beside the variance of the blur, 0.64, that of the shift, d^2/4, lowers the MTF by 3 %
            // and by 10 % where it is one half at shifts of 0.33 and 0.62 pixels.
            let across = shift * deg.to_radians().cos().abs().max(deg.to_radians().sin());
            if shift < 0.6 {
                let measured = found.expect(&case);
                assert_eq!(warned(&measured, "is shifted"), shift > 0.4, "{case}");
                assert!(!warned(&measured, "hot"), "{case}");
                let known = |f: f64| gaussian(SIGMA_PX, f) * (PI * across * f).cos();
                let (worst, noise) = error_from(&measured, known);
                assert!(worst < 0.002 + 4.5 * noise, "{case}: {worst} {noise}");
                cases[usize::from(shift > 0.0)] += 1;
            } else {
                let what = if columns { "columns" } else { "rows" };
                let fault = found.expect_err(&case);
                let Fault::Shifted {
                    what: found,
                    shift_px,
                    ..
                } = fault
                else {
                    panic!("{case}")
                };
                assert_eq!(found, what, "{case}");
                // The regression is exact to first order only, and ends at 3.5 SIGMA_PX.
                assert!((0.7..1.25).contains(&(shift_px / across)), "{case}");
                cases[2] += 1;
            }
        }
    }
    assert_eq!(cases, [3, 6, 9]);
}

/// A mosaic of colours that is stored as grey is told, with the light of its four places. Its gains
/// are known to 1 %: 12,000 pixels of each place have noise of 0.001. Gains of 2 % are a sensor's.
#[test]
fn a_mosaic_stored_as_grey_is_told() {
    for (gains, is_told) in [
        ([0.5, 1.0, 1.0, 0.7], true),
        ([1.0, 0.9, 0.95, 1.0], true),
        ([1.0, 0.99, 0.98, 1.0], false),
        ([1.0; 4], false),
    ] {
        let clean = photo(240, 200, |x, y| {
            let gain = gains[2 * (y as usize % 2) + x as usize % 2];
            gain * (DARK + 0.6 * rise(distance(x, y, 120.3, 99.1, 5.0), SIGMA_PX))
        });
        let measured = edge(&noisy(clean, 3), None, &[]).expect("it is measured");
        assert_eq!(
            warned(&measured, "mosaic"),
            is_told,
            "{gains:?} {:?}",
            measured.warnings
        );
        if is_told {
            let mean = gains.iter().sum::<f64>() / 4.0;
            let [a, b, c, d] = gains.map(|gain| gain / mean);
            let told = format!("({a:.2}, {b:.2}; {c:.2}, {d:.2})");
            assert!(warned(&measured, &told), "{told} {:?}", measured.warnings);
        }
    }
}

/// Pictures in which the search for an edge leads far out of the window end in a reason. A line
/// outside of it made the profile panic.
#[test]
fn an_edge_sought_in_vain_is_a_fault() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/odd");
    for name in ["two_marks.png", "blobs.png"] {
        let photo = photo::load(&folder.join(name), &Decode::default()).expect("it is a PNG");
        let fault = edge(&photo, None, &[]).expect_err(name);
        let told = matches!(fault, Fault::Choice { .. } | Fault::NotAlone { .. });
        assert!(told, "{name}: {fault}");
    }
    let bend = |term: f64| Bend {
        middle_px: 0.0,
        half_px: 30.0,
        terms_px: [term; 8],
        order: 9,
    };
    let window = Window::of(&photo(60, 50, |x, _| x), None).expect("it fits");
    for offset_px in [0.0, 29.0, -110.0, 1e9, f64::INFINITY, f64::NAN] {
        for bend in [
            None,
            Some(bend(3.0)),
            Some(bend(-1e4)),
            Some(bend(f64::NAN)),
        ] {
            let line = EdgeLine {
                normal_rad: 0.1,
                offset_px,
                normal_standard_error_rad: 0.0,
                bend,
            };
            // A straight line has 8 pixels on either side only near the middle.
            let found = Profile::new(&window, &line).is_some();
            let fits = offset_px == 0.0;
            assert!(found == fits || bend.is_some(), "{line:?}");
        }
    }
}

/// Rows of sharp edges at tilts whose tangents are simple fractions lie at few distances from the
/// edge. They are no shifted rows, and no mosaic.
#[test]
fn no_tilt_looks_like_shifted_rows() {
    for fraction in [
        0.02,
        0.05,
        0.125,
        0.2,
        0.25,
        1.0 / 3.0,
        0.5,
        2.0 / 3.0,
        0.75,
        0.96,
    ] {
        for (turn, sigma) in [(0.0, 0.4), (90.0, 0.4), (180.0, 1.0)] {
            let deg = f64::atan(fraction).to_degrees() + turn;
            let measured = edge(&degraded(deg, sigma, 5, |_, _, v| v), None, &[]);
            let measured = measured.expect("it is an edge");
            let told = warned(&measured, "is shifted") || warned(&measured, "mosaic");
            assert!(!told, "{deg} {sigma}: {:?}", measured.warnings);
        }
    }
}
