//! Edges whose MTF is known, drawn by code that shares nothing with the estimator.
//!
//! A pixel holds the integral of the blurred edge over its square. The blur is a normal
//! distribution, and the edge follows an arc of a circle.

use std::f64::consts::PI;

use rayon::prelude::*;

use crate::planted::Stream;
use crate::tests::studies::statistics::check;
use edges::photographs::crossing::{Curve, Measured};
use edges::photographs::edge::fault::Fault;
use edges::photographs::edge::slant;
use edges::photographs::edge::slant::Slant;
use edges::photographs::measure;
use edges::photographs::photo::plane::Photo;
use edges::photographs::photo::taken::Taken;

/// Places and weights of the Gauss-Legendre rule of 8 points on -1 to 1; each stands for both
/// signs.
///
/// Over one pixel it integrates an edge of a standard deviation of 0.4 px to 1e-9 of its step.
const RULE: [[f64; 2]; 4] = [
    [0.183_434_642_495_649_8, 0.362_683_783_378_362],
    [0.525_532_409_916_329, 0.313_706_645_877_887_3],
    [0.796_666_477_413_626_7, 0.222_381_034_453_374_48],
    [0.960_289_856_497_536_3, 0.101_228_536_290_376_26],
];

/// An edge whose MTF is known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Known {
    /// Width and height of the picture, pixels.
    pub size_px: [usize; 2],
    /// Direction of the normal in the middle of the edge, from +x towards +y.
    pub normal_deg: f64,
    /// Place of the middle of the edge along the normal, from the middle of the picture.
    pub offset_px: f64,
    /// Standard deviation of the blur.
    pub blur_px: f64,
    /// Height of the arc over its chord; positive if the bright side is the inner one.
    pub bow_px: f64,
    /// Light on the dark and on the bright side.
    pub levels: [f64; 2],
}

impl Known {
    /// Returns the length of the edge in the picture, pixels: from top to bottom if it is steep,
    /// else from left to right.
    fn chord_px(&self) -> f64 {
        let (sin, cos) = self.normal_deg.to_radians().sin_cos();
        let [width, height] = self.size_px.map(|size| size as f64);
        if cos.abs() > sin.abs() {
            height / cos.abs()
        } else {
            width / sin.abs()
        }
    }

    /// Returns the radius of the arc, pixels; infinite for a straight edge.
    fn radius_px(&self) -> f64 {
        let bow = self.bow_px.abs();
        self.chord_px().powi(2) / (8.0 * bow) + 0.5 * bow
    }

    /// Returns the light of the pixels, row by row from the top left.
    pub(crate) fn light(&self) -> Vec<f64> {
        let [width, height] = self.size_px;
        let middle = |size: usize| 0.5 * (size as f64 - 1.0);
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        places
            .map(|(x, y)| {
                let [dark, bright] = self.levels;
                let share = self.share(x as f64 - middle(width), y as f64 - middle(height));
                dark + (bright - dark) * share
            })
            .collect()
    }

    /// Returns the part of a pixel's light that is bright. The pixel's place counts from the middle
    /// of the picture.
    fn share(&self, x: f64, y: f64) -> f64 {
        let far = 8.0 * self.blur_px + 1.0;
        let distance = self.distance_px(x, y);
        if distance.abs() > far {
            return f64::from(u8::from(distance > 0.0));
        }
        let points = || {
            let both = |[place, weight]: [f64; 2]| [[-0.5 * place, weight], [0.5 * place, weight]];
            RULE.into_iter().flat_map(both)
        };
        let mut sum = 0.0;
        for [u, weight_u] in points() {
            for [v, weight_v] in points() {
                let at = self.distance_px(x + u, y + v) / (self.blur_px * 2.0_f64.sqrt());
                sum += 0.25 * weight_u * weight_v * (0.5 + 0.5 * libm::erf(at));
            }
        }
        sum
    }

    /// Returns the distance of a point from the edge, pixels; positive on the bright side.
    fn distance_px(&self, x: f64, y: f64) -> f64 {
        let (sin, cos) = self.normal_deg.to_radians().sin_cos();
        let across = x * cos + y * sin - self.offset_px;
        let along = y * cos - x * sin;
        let radius = self.radius_px();
        if radius.is_infinite() {
            across
        } else if self.bow_px > 0.0 {
            radius - (across - radius).hypot(along)
        } else {
            (across + radius).hypot(along) - radius
        }
    }

    /// Returns the MTF along the normal at a frequency in cycles per pixel: that of the blur, and
    /// that of the square pixel, on average over the directions of the arc.
    pub(crate) fn mtf(&self, frequency: f64) -> f64 {
        const PARTS: i32 = 20;
        let half_rad = (0.5 * self.chord_px() / self.radius_px()).asin();
        let pixel = |turn: f64| {
            let (sin, cos) = (self.normal_deg.to_radians() + turn).sin_cos();
            [cos, sin].map(|part| {
                let x = PI * frequency * part;
                if x.abs() < 1e-9 { 1.0 } else { x.sin() / x }
            })
        };
        let directions = (0..PARTS).map(|k| half_rad * ((2 * k + 1) as f64 / PARTS as f64 - 1.0));
        let pixels: f64 = directions
            .map(|turn| pixel(turn).iter().product::<f64>())
            .sum();
        let blur = (-2.0 * (PI * self.blur_px * frequency).powi(2)).exp();
        blur * pixels / f64::from(PARTS)
    }

    /// Returns the frequency at which the MTF falls to a level, cycles per pixel.
    pub(crate) fn crossing(&self, level: f64) -> f64 {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.mtf(middle) > level {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }
}

/// Number of frequencies, as in the program.
const COUNT: usize = 512;

impl Known {
    /// Draws an edge: 2 to 43 degrees off an axis, in all four directions of either polarity, a
    /// blur of 0.4 to 6 pixels and a bow of 0 to 3.
    ///
    /// The edge is 75 pixels long, as in the figures of MTF Mapper. The window is as wide as the
    /// blur asks for.
    fn drawn(stream: &mut Stream) -> Known {
        let quarter = stream.between(0.0, 4.0).floor();
        let sign = stream.between(-1.0, 1.0).signum();
        let blur_px = (stream.between(0.4_f64.ln(), 6.0_f64.ln())).exp();
        let across = (40.0 + 14.0 * blur_px) as usize;
        let bow = stream.between(0.0, 3.0) * stream.between(-1.0, 1.0).signum();
        Known {
            size_px: if (quarter as usize).is_multiple_of(2) {
                [across, 75]
            } else {
                [75, across]
            },
            normal_deg: 90.0 * quarter + sign * stream.between(2.0, 43.0),
            offset_px: stream.between(-0.5, 0.5),
            blur_px,
            bow_px: bow,
            levels: [0.1, 0.77],
        }
    }

    /// Returns a photograph with normal noise of a standard deviation.
    fn photo(&self, noise: f64, stream: &mut Stream) -> Photo {
        let light = self.light();
        let noisy = |light: &f64| (light + noise * stream.normal()) as f32;
        let light = light.iter().map(noisy);
        Photo {
            width: self.size_px[0],
            height: self.size_px[1],
            luminance: light.collect(),
            clip_level: None,
            clips_alone: true,
            transfer: Taken::default(),
            warnings: Vec::new(),
        }
    }
}

/// Errors of one edge.
struct Drawn {
    known: Known,
    /// Warnings, and the bow that was found, pixels.
    said: (Vec<String>, f64),
    /// MTF50, MTF10, and the MTF at the true MTF50: truth and measurement, if there is one.
    found: [(f64, Option<Measured>); 3],
}

impl Drawn {
    /// Returns the error of a figure over its truth, and over its standard error.
    fn error(&self, i: usize) -> Option<[f64; 2]> {
        let (truth, found) = self.found[i];
        let found = found?;
        let error = found.value - truth;
        Some([error / truth, error / found.standard_error])
    }
}

/// Draws edges with a signal-to-noise ratio and measures them.
fn measured(count: u64, ratio: f64) -> Vec<Drawn> {
    let draw = |seed: u64| {
        let mut stream = Stream(0xed9e << 20 | seed);
        let known = Known::drawn(&mut stream);
        let photo = known.photo((known.levels[1] - known.levels[0]) / ratio, &mut stream);
        let edge = measure::edge(&photo, None, &[]);
        let edge = edge.unwrap_or_else(|fault| panic!("{known:?}: {fault}"));
        let curve = Curve::new(&edge.profile, 1.0, COUNT);
        let half = known.crossing(0.5);
        Drawn {
            known,
            said: (edge.warnings, edge.line.bow_px()),
            found: [
                (half, curve.falls_to(0.5)),
                (known.crossing(0.1), curve.falls_to(0.1)),
                (0.5, curve.at(half)),
            ],
        }
    };
    (0..count).into_par_iter().map(draw).collect()
}

/// Returns mean, standard deviation and largest absolute value.
fn spread(values: &[f64]) -> [f64; 3] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let square = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
    let largest = values.iter().map(|v| v.abs()).fold(0.0, f64::max);
    [mean, (square / (n - 1.0)).sqrt(), largest]
}

/// MTF50 and MTF10 are right for 200 random edges at each of three noises, and so are their
/// standard errors. fit/doc/mtf.md has the figures that this test prints.
///
/// Without noise the limits are those of the method: bins, window and search for the edge. With
/// noise the mean error of n draws may be 4 of its standard errors, besides that.
#[test]
#[ignore = "10 processor-seconds: `make test-full` runs it"]
fn statistics_of_known_edges() {
    const DRAWS: u64 = 200;
    for ratio in [f64::INFINITY, 57.0, 20.0] {
        let draws = measured(DRAWS, ratio);
        for (i, what) in ["MTF50", "MTF10", "MTF at MTF50"].into_iter().enumerate() {
            let found: Vec<[f64; 2]> = draws.iter().filter_map(|draw| draw.error(i)).collect();
            let n = found.len() as f64;
            let errors: Vec<f64> = found.iter().map(|error| error[0]).collect();
            let [mean, deviation, largest] = spread(&errors);
            println!(
                "{what} at {ratio}: {n} found, bias {:+.3} %, spread {:.3} %, largest {:.2} %",
                100.0 * mean,
                100.0 * deviation,
                100.0 * largest
            );
            for draw in &draws {
                if draw.error(i).is_some_and(|[_, pull]| pull.abs() > 3.3) && ratio < 1e9 {
                    println!("{:?} {:?} {:?}", draw.known, draw.said, draw.found[i]);
                }
            }
            if ratio.is_infinite() {
                assert!(
                    mean.abs() < 1e-3 && largest < 0.01,
                    "{what}: {mean} {largest}"
                );
            } else {
                let pulls: Vec<f64> = found.iter().map(|error| error[1]).collect();
                check(&format!("{what} at {ratio}"), &pulls, 0.1);
                let limit = 1e-3 + 4.0 * deviation / n.sqrt();
                assert!(mean.abs() < limit, "{what} at {ratio}: {mean}");
            }
            assert!(
                what == "MTF10" || found.len() as u64 == DRAWS,
                "{what}: {n}"
            );
            if (ratio, what) == (57.0, "MTF50") {
                let ends = [0.0, 0.05, 0.1, 0.2, 0.4];
                for range in ends.windows(2) {
                    let within = draws
                        .iter()
                        .filter(|draw| (range[0]..range[1]).contains(&draw.found[i].0));
                    let errors: Vec<f64> =
                        within.filter_map(|draw| Some(draw.error(i)?[0])).collect();
                    let [mean, deviation, largest] = spread(&errors);
                    println!(
                        "  {range:?} cycles/pixel, {}: bias {:+.3} %, spread {:.3} %, \
                        largest {:.2} %",
                        errors.len(),
                        100.0 * mean,
                        100.0 * deviation,
                        100.0 * largest
                    );
                }
                assert!(deviation < 0.01, "{deviation}");
            }
        }
    }
}

/// The standard errors of MTF10 hold where noise reaches it: in 1,500 random edges at a
/// signal-to-noise ratio of 20, of which half have an MTF10 above the noise.
///
/// The mean square pull of n = 800 scatters by sqrt(2 / n) = 0.05. 0.1 more is left for the edges
/// whose MTF10 is hardly above the noise and was chosen by it. With the slope of the cubic itself
/// the mean square was 1.27. The coverage scatters by 0.008.
#[test]
#[ignore = "30 processor-seconds: `make test-full` runs it"]
fn statistics_of_mtf10_in_noise() {
    let draws = measured(1500, 20.0);
    let pulls: Vec<f64> = draws
        .iter()
        .filter_map(|draw| Some(draw.error(1)?[1]))
        .collect();
    let n = pulls.len() as f64;
    let square = pulls.iter().map(|pull| pull * pull).sum::<f64>() / n;
    let within = pulls.iter().filter(|pull| pull.abs() < 1.96).count() as f64 / n;
    println!("MTF10 at 20: {n} found, mean square pull {square:.3}, coverage {within:.3}");
    assert!(n > 750.0, "{n}");
    assert!((square - 1.0).abs() < 0.2, "{square}");
    assert!((within - 0.95).abs() < 0.025, "{within}");
}

/// MTF50 of edges near the pixel grid: what the limits of [`Slant`] are made from. From 1 pixel
/// crossed on, the error without noise is below 3e-4; with 0.65 pixels it is up to 3 %, and an
/// aligned edge loses a sixth.
#[test]
fn an_edge_must_cross_a_pixel() {
    for (tilt_deg, refused, warned) in [
        (0.0, true, false),
        (0.2, true, false),
        (0.5, true, false),
        (0.8, false, true),
        (1.0, false, true),
        (1.9, false, true),
        (2.0, false, false),
        (5.0, false, false),
    ] {
        for normal_deg in [tilt_deg, 90.0 - tilt_deg, 180.0 + tilt_deg, tilt_deg - 90.0] {
            let known = Known {
                size_px: [75, 75],
                normal_deg,
                offset_px: 0.2,
                blur_px: 0.5,
                bow_px: 0.0,
                levels: [0.1, 0.77],
            };
            let photo = known.photo(0.0, &mut Stream(1));
            let edge = measure::edge(&photo, None, &[]).expect("there is an edge");
            let slant = Slant::of(&edge.line, &edge.window);
            // 74 pixels lie between the centres of the first and the last row.
            let crossed = 74.0 * tilt_deg.to_radians().tan();
            assert!(
                (slant.crossed_px - crossed).abs() < 0.02,
                "{normal_deg}: {slant:?}"
            );
            match slant.check() {
                Err(Fault::Aligned { .. }) => assert!(refused, "{normal_deg}"),
                Err(fault) => panic!("{fault}"),
                Ok(warning) => assert!(!refused && warning.is_some() == warned, "{normal_deg}"),
            }
            let found = Curve::new(&edge.profile, 1.0, COUNT).falls_to(0.5);
            let error = found.expect("it falls").value / known.crossing(0.5) - 1.0;
            assert!(refused || error.abs() < 4e-4, "{normal_deg}: {error}");
            assert!(tilt_deg > 0.0 || error < -0.1, "{normal_deg}: {error}");
        }
    }
}

/// MTF50 where the tangent of the tilt is 1/4: the errors without noise stay below the limit that
/// the warning names, and one of each blur reaches a half of it. The warning comes if the limit is
/// above the standard error, which it is not for wide blurs in noise. It comes at no other angle.
#[test]
fn pixels_in_lines_are_warned_of() {
    const PLACES: u32 = 20;
    let quarter = 0.25_f64.atan().to_degrees();
    let measured = |normal_deg: f64, blur_px: f64, place: u32, noise: f64| {
        let known = Known {
            size_px: [(40.0 + 14.0 * blur_px) as usize, 75],
            normal_deg,
            offset_px: f64::from(place) / f64::from(PLACES) - 0.5,
            blur_px,
            bow_px: 0.0,
            levels: [0.1, 0.77],
        };
        let photo = known.photo(0.67 * noise, &mut Stream(u64::from(place)));
        let edge = measure::edge(&photo, None, &[]).expect("there is an edge");
        let half = Curve::new(&edge.profile, 1.0, COUNT).falls_to(0.5);
        let half = half.expect("it falls");
        let warning = slant::lined_up(&edge.profile, half.value, half.standard_error);
        (half.value / known.crossing(0.5) - 1.0, half.value, warning)
    };
    let mut cases = 0;
    for blur_px in [0.4, 0.5, 0.8, 1.5] {
        let mut largest = 0.0_f64;
        let mut limit = 0.0;
        for place in 0..PLACES {
            let (error, half, warning) = measured(quarter, blur_px, place, 0.0);
            largest = largest.max(error.abs());
            limit = 0.25 * half * half;
            let warning = warning.expect("the standard error is that of rounding");
            let named = format!("{:.1} %", 100.0 * limit);
            assert!(warning.contains(&named), "{named}: {warning}");
            cases += 1;
        }
        assert!(
            (0.5..1.0).contains(&(largest / limit)),
            "{blur_px}: {largest} of {limit}"
        );
    }
    // 1/57 is the noise of a pixel over the step. The standard errors are 1.0 % and 0.6 %, the
    // limits 2.6 % and 0.4 %.
    for (blur_px, warned) in [(0.5, true), (1.5, false)] {
        for place in 0..PLACES {
            let (_, _, warning) = measured(quarter, blur_px, place, 1.0 / 57.0);
            assert_eq!(warning.is_some(), warned, "{blur_px} {place}: {warning:?}");
            cases += 1;
        }
    }
    let others = [
        1.0 / 8.0,
        1.0 / 5.0,
        1.0 / 3.0,
        2.0 / 5.0,
        0.5,
        0.75,
        1.0,
        0.2126,
        0.3,
    ];
    for tangent in others {
        let (_, _, warning) = measured(f64::atan(tangent).to_degrees(), 0.5, 7, 0.0);
        assert!(warning.is_none(), "{tangent}: {warning:?}");
        cases += 1;
    }
    assert_eq!(cases, 129);
}

/// A curve crosses pixels too: an edge along the rows with a bow of 2 pixels is not aligned.
#[test]
fn a_bow_crosses_pixels() {
    let known = Known {
        size_px: [90, 120],
        normal_deg: 0.0,
        offset_px: 0.0,
        blur_px: 0.8,
        bow_px: 2.0,
        levels: [0.1, 0.77],
    };
    let photo = known.photo(0.0, &mut Stream(1));
    let edge = measure::edge(&photo, None, &[]).expect("there is an edge");
    let slant = Slant::of(&edge.line, &edge.window);
    assert!((slant.crossed_px - 2.0).abs() < 0.1, "{slant:?}");
    assert!(matches!(slant.check(), Ok(Some(_))));
}
