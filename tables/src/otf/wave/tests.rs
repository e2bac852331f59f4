//! Waves of a cube of two halves against their closed form, and limits of an aperture.

use super::*;

/// Half width of the aperture along the normal, edge lengths.
const HALF: f64 = 0.5;

/// Weights of its two halves.
const WEIGHTS: [f64; 2] = [0.9, 0.4];

const INCIDENCE_DEG: f64 = 30.0;

/// Source lines, (nm, weight).
const LINES: [(f64, f64); 2] = [(450.0, 1.0), (650.0, 3.0)];

/// Makes one cube whose aperture is a rectangle of two halves with different losses.
fn cube() -> Direction {
    let (middle, low, high) = ([0.2, -0.1], -0.4, 0.3);
    let half = |from: f64, to: f64, weight: f64| {
        let at = |x: f64, y: f64| [middle[0] + x, middle[1] + y];
        Path {
            polygon: vec![at(from, low), at(to, low), at(to, high), at(from, high)],
            matrix: [[-2.0, 0.0], [0.0, -2.0]],
            offset: [2.0 * middle[0], 2.0 * middle[1]],
            weight,
            deviation: [0.0; 2],
            passes: 0,
            jones: None,
            cube: None,
        }
    };
    Direction {
        incidence_deg: INCIDENCE_DEG,
        azimuth_deg: 0.0,
        retroreflected: 0.4,
        probability: ndarray::Array2::zeros((4, 4)),
        range: 2.0,
        standard_error: 0.0,
        interpolated: false,
        exits: None,
        paths: Some(vec![
            half(-HALF, 0.0, WEIGHTS[0]),
            half(0.0, HALF, WEIGHTS[1]),
        ]),
    }
}

/// Returns the waves of the cube along a normal.
fn along(normal: [f64; 2]) -> WaveLine {
    let incidence_rad = INCIDENCE_DEG.to_radians();
    WaveLine::new(&cube(), incidence_rad, normal, &LINES).expect("an ideal cube")
}

/// Returns the waves of the cube along the tangential axis.
fn two_halves() -> WaveLine {
    along([1.0, 0.0])
}

/// The rectangle, foreshortened, overlaps itself up to its diagonal, along the diagonal only.
/// Directions of 0.1 degrees miss the diagonal by 1 - cos(0.05 deg) = 4e-7 of the lag.
#[test]
fn no_line_passes_a_frequency_beyond_the_highest() {
    let (c_mm, r_mm, shortest_mm) = (0.2, 150.0, 450e-6);
    let incidence_rad = INCIDENCE_DEG.to_radians();
    let end = WaveLine::highest_frequency(&cube(), incidence_rad, [c_mm, r_mm, shortest_mm]);
    let diagonal = (2.0 * HALF * incidence_rad.cos()).hypot(0.7);
    let expected = diagonal * c_mm / (shortest_mm * r_mm);
    assert!((end / expected - 1.0).abs() < 1e-14, "{end} {expected}");
    let mut longest = 0.0_f64;
    for k in 0..1800 {
        let (sin, cos) = (0.1 * f64::from(k)).to_radians().sin_cos();
        let line = along([cos, sin]);
        assert_eq!(
            line.otf(c_mm, r_mm, end * (1.0 + 1e-12)).0,
            Complex64::ZERO,
            "{k}"
        );
        longest = longest.max(line.reach);
    }
    let short = 1.0 - longest / diagonal;
    assert!((0.0..1e-6).contains(&(short + 1e-14)), "{short}");
    println!("1800 lines");
}

/// Paths of a cube whose coordinates are rounded are one aperture, also where the apex lies far
/// from the origin. Cubes of two kinds with one foot are two.
///
/// The maps of the halves are off by 1e-4, and the feet by half of that. So the aperture moves
/// against the foot by 5e-5, which turns each phase by at most that times the wave.
#[test]
fn nearly_equal_paths_are_one_aperture_and_kinds_are_not() {
    let (exact, away) = (cube(), [30.0, -20.0]);
    let mut rounded = cube();
    for (k, path) in rounded.paths.iter_mut().flatten().enumerate() {
        let off = 1e-4 * (1.0 - 2.0 * k as f64);
        path.matrix = [[-2.0 + off, 0.5 * off], [-off, -2.0 - 0.3 * off]];
        path.polygon
            .iter_mut()
            .flatten()
            .enumerate()
            .for_each(|(i, x)| *x += away[i % 2]);
        let foot = [
            0.5 * path.offset[0] + away[0] + 0.5 * off,
            0.5 * path.offset[1] + away[1],
        ];
        path.offset = path.matrix.map(|row| -row[0] * foot[0] - row[1] * foot[1]);
    }
    // A second kind: a quarter of the size, of the same foot.
    let kinds = |both: [bool; 2]| {
        let mut kinds = cube();
        let own = kinds.paths.take().unwrap_or_default();
        let other = own.iter().map(|path| {
            let about = [0, 1].map(|i| 0.5 * path.offset[i]);
            let mut path = path.clone();
            for corner in &mut path.polygon {
                *corner = [0, 1].map(|i| about[i] + 0.5 * (corner[i] - about[i]));
            }
            path
        });
        let all = [own.clone(), other.collect()];
        let kept = all.into_iter().zip(both).filter(|(_, kept)| *kept);
        kinds.paths = Some(kept.flat_map(|(paths, _)| paths).collect());
        kinds
    };
    let mut cases = 0;
    for normal in [[1.0, 0.0], [0.0, 1.0], [0.6, -0.8]] {
        let of = |direction: &Direction| {
            let incidence_rad = INCIDENCE_DEG.to_radians();
            WaveLine::new(direction, incidence_rad, normal, &LINES).expect("nearly exact")
        };
        let [exact, rounded] = [&exact, &rounded].map(of);
        let [large, small, both] =
            [[true, false], [false, true], [true, true]].map(|which| of(&kinds(which)));
        for frequency in [0.1, 0.4, 0.83, 1.4, 2.0] {
            let at = |line: &WaveLine| line.otf(0.2, 150.0, frequency).0.re;
            let off = at(&rounded) - at(&exact);
            let turned = 5e-5 * 4.0 * PI * 0.2 * frequency;
            assert!(off.abs() < turned, "{normal:?} {frequency}: {off:e}");
            // Four fifths of the light are of the large kind.
            let off = at(&both) - 0.8 * at(&large) - 0.2 * at(&small);
            assert!(off.abs() < 1e-13, "{normal:?} {frequency}: {off:e}");
            cases += 1;
        }
    }
    assert_eq!(cases, 15);
}

/// Returns the integral of cos(wave a) times the amplitudes at a - lag/2 and a + lag/2, over
/// the power.
///
/// Both ends of the pair lie in one half, or one end in each. The amplitude is the root of the
/// weight.
fn overlap(half: f64, lag: f64, wave: f64) -> f64 {
    let end = half - 0.5 * lag;
    let inner = (0.5 * lag).min(end);
    let part = |from: f64, to: f64| ((wave * to).sin() - (wave * from).sin()) / wave;
    let [left, right] = WEIGHTS;
    let both = left * part(-end, -inner) + right * part(inner, end);
    (both + (left * right).sqrt() * part(-inner, inner)) / ((left + right) * half)
}

/// Compares the OTF of two halves and two lines with its closed form. Both are sums of a few
/// terms of order 1 / wave, and wave is above 0.2, so they round by less than 1e-14.
///
/// The derivative by ln c is compared with differences. With wave up to 5.1 and a half aperture
/// of 0.44, the third derivative by ln c is below 125, of which h^2/6 are 2.1e-9.
#[test]
fn two_halves_in_two_colours_meet_their_closed_form() {
    let line = two_halves();
    let half = HALF * INCIDENCE_DEG.to_radians().cos();
    let (c_mm, r_mm, h) = (0.2, 150.0, 1e-5_f64);
    let mut cases = 0;
    for frequency in [0.1, 0.4, 0.83, 1.4, 2.0] {
        let total: f64 = LINES.iter().map(|(_, weight)| weight).sum();
        let of = |&(nm, weight): &(f64, f64)| {
            let lag = nm * 1e-6 * r_mm * frequency / c_mm;
            let wave = 4.0 * PI * c_mm * frequency;
            if lag >= 2.0 * half {
                0.0
            } else {
                weight / total * overlap(half, lag, wave)
            }
        };
        let expected: f64 = LINES.iter().map(of).sum();
        let (value, by_ln_c) = line.otf(c_mm, r_mm, frequency);
        let (value, by_ln_c) = (value.re, by_ln_c.re);
        assert!(
            (value - expected).abs() < 1e-13,
            "{frequency}: {value} {expected}"
        );
        let at = |by: f64| line.otf(c_mm * by.exp(), r_mm, frequency).0.re;
        let difference = (at(h) - at(-h)) / (2.0 * h);
        assert!(
            (by_ln_c - difference).abs() < 3e-9,
            "{frequency}: {by_ln_c} {difference}"
        );
        cases += 1;
    }
    assert_eq!(cases, 5);
}

/// Compares the kink with that of the closed form: the lag shortens each half by itself and
/// adds itself where its ends lie in different halves. The code takes the slope at a lag of
/// 1e-9 of the aperture, where it is the same.
#[test]
fn the_kink_of_two_halves_is_that_of_the_mean_wavelength() {
    let [left, right] = WEIGHTS;
    let half = HALF * INCIDENCE_DEG.to_radians().cos();
    let mean_mm = (450.0 + 3.0 * 650.0) / 4.0 * 1e-6;
    let fall = (left + right - (left * right).sqrt()) / ((left + right) * half);
    let expected = fall * mean_mm * 150.0 / 0.2;
    let kink = two_halves().kink(0.2, 150.0);
    assert!((kink / expected - 1.0).abs() < 1e-13, "{kink} {expected}");
}
