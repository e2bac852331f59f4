//! MTF50 of edges of known MTF in the light of bars, hot spots and lenses.
//!
//! The renderer shares nothing with the program: a pixel is the mean of 5 x 5 points of Gauss and
//! Legendre on its square, the blur is a normal distribution, and the light is that of its physical
//! form. A bar lights along one axis only, and falls with the square of the distance from it. A hot
//! spot is a normal distribution. A lens falls as cos^4 about its axis.

use std::f64::consts::PI;

use crate::numerics::{Stream, sinc};
use crate::photographs::crossing::{Curve, Measured};
use crate::photographs::edge::slant::Slant;
use crate::photographs::measure;
use crate::photographs::photo::plane::Photo;
use crate::photographs::photo::taken::Taken;

/// Places and weights of the rule of 5 points on a pixel, from -1/2 to 1/2.
const RULE: [[f64; 2]; 5] = [
    [-0.453_089_922_969_332, 0.118_463_442_528_094_54],
    [-0.269_234_655_052_841_55, 0.239_314_335_249_683_23],
    [0.0, 0.284_444_444_444_444_44],
    [0.269_234_655_052_841_55, 0.239_314_335_249_683_23],
    [0.453_089_922_969_332, 0.118_463_442_528_094_54],
];

/// Shape of the light.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    Even,
    Along,
    Across,
    Round,
    Cos4,
}

const UNEVEN: [Shape; 4] = [Shape::Along, Shape::Across, Shape::Round, Shape::Cos4];

/// An edge in uneven light.
#[derive(Debug, Clone, Copy)]
struct Lit {
    size_px: [usize; 2],
    normal_deg: f64,
    offset_px: f64,
    blur_px: f64,
    /// Height of the arc that the edge follows.
    bow_px: f64,
    shape: Shape,
    /// Place of the brightest light from the middle of the picture, in half diagonals.
    brightest: [f64; 2],
    /// Share by which the light falls over the picture.
    fall: f64,
    /// Noise of a pixel over the step.
    noise: f64,
}

const DARK: f64 = 0.1;
const BRIGHT: f64 = 0.77;

impl Lit {
    /// Draws an edge in a region of 14 to 400 pixels along it and 20 to 400 across. It crosses a
    /// pixel, and the blur fades out in the region.
    fn drawn(stream: &mut Stream) -> Lit {
        loop {
            let mut size = |low: f64| stream.between(low.ln(), 400.0_f64.ln()).exp();
            let (along, across) = (size(14.0), size(20.0));
            let lit = Lit {
                size_px: [across as usize, along as usize],
                normal_deg: stream.between(2.0, 43.0),
                offset_px: stream.between(-0.5, 0.5),
                blur_px: stream.between(0.4_f64.ln(), 6.0_f64.ln()).exp(),
                bow_px: stream.between(-1.0, 1.0) * (along / 75.0).powi(2).min(1.0),
                shape: UNEVEN[stream.between(0.0, 4.0) as usize],
                brightest: [(); 2].map(|()| stream.between(-1.5, 1.5)),
                fall: stream.between(0.0, 0.3),
                noise: stream
                    .between(300.0_f64.recip().ln(), 30.0_f64.recip().ln())
                    .exp(),
            };
            let quarter = stream.between(0.0, 4.0).floor();
            let sign = stream.between(-1.0, 1.0).signum();
            let crossed = along.floor() * lit.normal_deg.to_radians().tan();
            if crossed < 1.3 || across - crossed < 20.0_f64.max(14.0 * lit.blur_px) {
                continue;
            }
            let [width, height] = lit.size_px;
            let is_steep = (quarter as usize).is_multiple_of(2);
            return Lit {
                size_px: if is_steep {
                    [width, height]
                } else {
                    [height, width]
                },
                normal_deg: 90.0 * quarter + sign * lit.normal_deg,
                ..lit
            };
        }
    }

    /// Returns the place of each pixel from the middle of the picture.
    fn places(&self) -> impl Iterator<Item = [f64; 2]> + Clone + use<> {
        let [width, height] = self.size_px;
        let middle = |size: usize| 0.5 * (size as f64 - 1.0);
        let all = (0..height).flat_map(move |y| (0..width).map(move |x| [x, y]));
        all.map(move |[x, y]| [x as f64 - middle(width), y as f64 - middle(height)])
    }

    /// Returns the share of a pixel that is bright.
    fn share(&self, [x, y]: [f64; 2]) -> f64 {
        let (sin, cos) = self.normal_deg.to_radians().sin_cos();
        let length = if cos.abs() > sin.abs() {
            self.size_px[1] as f64 / cos.abs()
        } else {
            self.size_px[0] as f64 / sin.abs()
        };
        let mut sum = 0.0;
        for [u, weight_u] in RULE {
            for [v, weight_v] in RULE {
                let (x, y) = (x + u, y + v);
                let along = (y * cos - x * sin) / length;
                // Within a pixel of the bow the arc is a parabola.
                let across = x * cos + y * sin - self.offset_px - 4.0 * self.bow_px * along * along;
                let at = across / self.blur_px / 2.0_f64.sqrt();
                sum += weight_u * weight_v * 0.5 * libm::erfc(-at);
            }
        }
        sum
    }

    /// Returns the light at each pixel, for a width of the lamp in half diagonals.
    fn light(&self, width: f64) -> Vec<f64> {
        let (sin, cos) = self.normal_deg.to_radians().sin_cos();
        let half = 0.5 * (self.size_px[0] as f64).hypot(self.size_px[1] as f64);
        let at = |[x, y]: [f64; 2]| {
            let (x, y) = (x / half - self.brightest[0], y / half - self.brightest[1]);
            let square = |r: f64| (r / width).powi(2);
            match self.shape {
                Shape::Even => 1.0,
                Shape::Along => 1.0 / (1.0 + square(y * cos - x * sin)),
                Shape::Across => 1.0 / (1.0 + square(x * cos + y * sin)),
                Shape::Round => (-0.5 * square(x.hypot(y))).exp(),
                Shape::Cos4 => (1.0 + square(x.hypot(y))).powi(-2),
            }
        };
        self.places().map(at).collect()
    }

    /// Returns the light of all pixels, 1 where it is largest. It falls by `fall`.
    fn lights(&self) -> Vec<f64> {
        let ends = |light: &[f64]| {
            let ends = |(low, high): (f64, f64), &v: &f64| (low.min(v), high.max(v));
            light.iter().fold((f64::INFINITY, 0.0), ends)
        };
        let (mut narrow, mut wide) = (0.01_f64, 1000.0_f64);
        for _ in 0..40 {
            let width = (narrow * wide).sqrt();
            let (low, high) = ends(&self.light(width));
            if 1.0 - low / high > self.fall {
                narrow = width;
            } else {
                wide = width;
            }
        }
        let light = self.light(wide);
        let (_, high) = ends(&light);
        light.iter().map(|v| v / high).collect()
    }

    fn photo(&self, stream: &mut Stream) -> Photo {
        let noise = self.noise * (BRIGHT - DARK);
        let luminance = self.places().zip(self.lights()).map(|(place, light)| {
            let edge = DARK + (BRIGHT - DARK) * self.share(place);
            (edge * light + noise * stream.normal()) as f32
        });
        Photo {
            width: self.size_px[0],
            height: self.size_px[1],
            luminance: luminance.collect(),
            clip_level: None,
            clips_alone: true,
            transfer: Taken::default(),
            warnings: Vec::new(),
        }
    }

    /// Returns the true MTF50, cycles per pixel.
    fn mtf50(&self) -> f64 {
        let (sin, cos) = self.normal_deg.to_radians().sin_cos();
        let mtf = |f: f64| {
            let blur = (-2.0 * (PI * self.blur_px * f).powi(2)).exp();
            blur * sinc(PI * f * cos) * sinc(PI * f * sin)
        };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if mtf(middle) > 0.5 {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }

    /// Measures MTF50, and whether the light was corrected.
    fn measured(&self, stream: &mut Stream) -> Result<(Measured, bool), String> {
        let edge = measure::edge(&self.photo(stream), None, &[]).map_err(|e| e.to_string())?;
        let slant = Slant::of(&edge.line, &edge.window);
        slant.check().map_err(|e| e.to_string())?;
        let half = Curve::new(&edge.profile, 1.0, 512).falls_to(0.5);
        Ok((half.ok_or("lost")?, edge.unevenness > 0.0))
    }
}

/// Errors of the regions of one kind of light.
struct Errors {
    /// Errors over the truth, and standard errors over it.
    found: Vec<[f64; 2]>,
    corrected: usize,
    refused: usize,
}

fn errors(draws: std::ops::Range<u64>, change: impl Fn(Lit) -> Lit) -> Errors {
    let mut all = Errors {
        found: Vec::new(),
        corrected: 0,
        refused: 0,
    };
    for seed in draws {
        let mut stream = Stream(0x11e4 << 20 | seed);
        let lit = change(Lit::drawn(&mut stream));
        let found = lit.measured(&mut stream);
        let truth = lit.mtf50();
        match found {
            Ok((half, is_corrected)) => {
                let (error, stated) = (half.value / truth - 1.0, half.standard_error / truth);
                all.found.push([error, stated]);
                all.corrected += usize::from(is_corrected);
                let z = error / stated;
                if std::env::var("ALL").is_ok() || z.abs() > 2.5 {
                    println!(
                        "{:?} {:?} deg {:.1} blur {:.2} fall {:.3} {:.2?} bow {:.2} noise {:.4} corrected {is_corrected}: error {:+.2} % stated {:.2} % z {z:+.2}{}",
                        lit.shape,
                        lit.size_px,
                        lit.normal_deg,
                        lit.blur_px,
                        lit.fall,
                        lit.brightest,
                        lit.bow_px,
                        lit.noise,
                        100.0 * error,
                        100.0 * stated,
                        if error.abs() > 0.01 && z.abs() > 2.5 {
                            " FAR"
                        } else {
                            ""
                        }
                    );
                }
            }
            Err(fault) => {
                println!("{lit:?}: {fault}");
                all.refused += 1;
            }
        }
    }
    let pulls = || all.found.iter().map(|[error, stated]| error / stated);
    let n = all.found.len() as f64;
    let beyond = |limit: f64| pulls().filter(|pull| pull.abs() > limit).count();
    let mean = pulls().sum::<f64>() / n;
    let square = pulls().map(|pull| pull * pull).sum::<f64>() / n;
    let far = all
        .found
        .iter()
        .filter(|[e, s]| e.abs() > 0.01 && e.abs() > 2.5 * s)
        .count();
    println!(
        "{n} found, {} refused, {} corrected; mean pull {mean:+.3}, mean square {square:.3}, {} beyond 1.96, {} beyond 2.5, {} beyond 3.5; {far} beyond 1 % and 2.5 errors",
        all.refused,
        all.corrected,
        beyond(1.96),
        beyond(2.5),
        beyond(3.5)
    );
    all
}

/// Even light is left alone: chance corrects 1 of 10,000 regions.
#[test]
#[ignore = "minutes: `make test-full` runs it"]
fn statistics_of_even_light() {
    let all = errors(0..500, |lit| Lit {
        shape: Shape::Even,
        ..lit
    });
    assert!(all.found.len() == 500 && all.corrected < 2);
}

/// Of 500 normal errors 6.2 lie beyond 2.5 standard errors, and 17 or more in 1 of 10^4 cases.
#[test]
#[ignore = "minutes: `make test-full` runs it"]
fn statistics_of_uneven_light() {
    let all = errors(0..500, |lit| lit);
    let is_far = |[error, stated]: &&[f64; 2]| error.abs() > 0.01 && error.abs() > 2.5 * stated;
    let far = all.found.iter().filter(is_far).count();
    assert!(all.corrected > 250 && far < 17, "{far}");
}

/// Light that falls by 30 % has 1/0.7 - 1 = 0.429 times more at its brightest pixel than at its
/// darkest. The fall is a Taylor series of second order: its rest at an end of a bar twice as far
/// away as the picture is wide, 4 (1/5)^3 of the light, is 0.03 of it, and less when fitted over all
/// pixels. The noise adds 0.001.
#[test]
fn unevenness_is_the_ratio_of_largest_to_smallest_light() {
    for (seed, shape) in UNEVEN.into_iter().enumerate() {
        let lit = Lit {
            size_px: [200, 200],
            normal_deg: 5.0,
            offset_px: 0.2,
            blur_px: 1.0,
            bow_px: 0.0,
            shape,
            brightest: [1.0, 0.4],
            fall: 0.3,
            noise: 1.0 / 300.0,
        };
        let photo = lit.photo(&mut Stream(seed as u64));
        let edge = measure::edge(&photo, None, &[]).expect("it has an edge");
        println!("{shape:?}: {:.4}", edge.unevenness);
        assert!(
            (edge.unevenness - (1.0 / 0.7 - 1.0)).abs() < 0.03,
            "{shape:?}: {}",
            edge.unevenness
        );
    }
}
