//! Cameras that change the edge: noise reduction by a bilateral filter, a mosaic of colours that is
//! filled in, sharpening, and JPEG. The filters stand here in their own form, and share nothing with
//! the estimator.

use rayon::prelude::*;

use crate::planted::{SHARED, Stream, camera, fitted, params, table, truth};
use crate::simulate::error::Error;
use crate::simulate::jpeg::{packed, unpacked};
use crate::simulate::photograph::photograph;
use crate::simulate::{Params, PlantedEdge};
use crate::study::trial::{campaign, source};
use edges::names::{Kernel, LobeShape};
use estimator::estimate::{Kind, Loss, Scene, Verdict, goodness};

/// What a camera does after the sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum After {
    Nothing,
    /// A bilateral filter, with its deviations in space (pixels) and in light.
    Bilateral(f64, f64),
    /// A mosaic of colours (Bayer), filled in by means of neighbours.
    Mosaic,
    /// Both of them and JPEG of 8 bits, with light sharpening, as ordinary cameras do; the filter has this deviation in
    /// light.
    Ordinary(f64),
}

/// A picture in one channel.
#[derive(Clone)]
pub(super) struct Picture {
    pub size: [usize; 2],
    pub values: Vec<f64>,
}

impl Picture {
    /// Returns the value at a place; beyond the border that of the nearest pixel.
    fn at(&self, x: isize, y: isize) -> f64 {
        let [width, height] = self.size.map(|side| side as isize - 1);
        let (x, y) = (x.clamp(0, width) as usize, y.clamp(0, height) as usize);
        self.values[y * self.size[0] + x]
    }

    fn map(&self, value: impl Fn(isize, isize) -> f64) -> Picture {
        let [width, height] = self.size.map(|side| side as isize);
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Picture {
            size: self.size,
            values: places.map(|(x, y)| value(x, y)).collect(),
        }
    }

    /// Weighs neighbours by their distance and by the difference of their values.
    fn bilateral(&self, sigma_px: f64, range: f64) -> Picture {
        let reach = (2.5 * sigma_px).ceil() as isize;
        self.map(|x, y| {
            let own = self.at(x, y);
            let (mut sum, mut weights) = (0.0, 0.0);
            for dy in -reach..=reach {
                for dx in -reach..=reach {
                    let other = self.at(x + dx, y + dy);
                    let apart = (dx * dx + dy * dy) as f64 / (sigma_px * sigma_px);
                    let unlike = ((other - own) / range).powi(2);
                    let weight = (-0.5 * (apart + unlike)).exp();
                    sum += weight * other;
                    weights += weight;
                }
            }
            sum / weights
        })
    }

    /// Adds `amount` of what a mean over 3 x 3 pixels takes away.
    fn sharpened(&self, amount: f64) -> Picture {
        let near = [-1_isize, 0, 1];
        self.map(|x, y| {
            let places = near.iter().flat_map(|dy| near.map(|dx| (x + dx, y + dy)));
            let mean = places.map(|(x, y)| self.at(x, y)).sum::<f64>() / 9.0;
            let own = self.at(x, y);
            own + amount * (own - mean)
        })
    }

    /// Keeps the pixels of one colour of a Bayer mosaic (0 red, 1 green, 2 blue), and fills in the
    /// others by the mean of those next to them.
    fn colour(&self, colour: usize) -> Picture {
        let is_own = |x: isize, y: isize| (x.rem_euclid(2) + y.rem_euclid(2)) as usize == colour;
        let near = [-1_isize, 0, 1];
        let [width, height] = self.size.map(|side| side as isize);
        self.map(|x, y| {
            if is_own(x, y) {
                return self.at(x, y);
            }
            let places = near.iter().flat_map(|dy| near.map(|dx| (x + dx, y + dy)));
            let own = places.filter(|&(x, y)| {
                is_own(x, y) && (0..width).contains(&x) && (0..height).contains(&y)
            });
            let (sum, count) = own.fold((0.0, 0.0), |(sum, count), (x, y)| {
                (sum + self.at(x, y), count + 1.0)
            });
            sum / count
        })
    }

    fn through(&self, value: fn(f64) -> f64) -> Picture {
        self.map(|x, y| value(self.at(x, y)))
    }

    fn jpeg(&self, quality: u8) -> Picture {
        let light: Vec<f32> = self.values.iter().map(|v| *v as f32).collect();
        let bytes = packed(&light, self.size, quality).expect("the sides are short");
        let light = unpacked(&bytes).expect("it was just packed");
        Picture {
            size: self.size,
            values: light.into_iter().map(f64::from).collect(),
        }
    }
}

/// The curve of sRGB and its inverse, without their linear parts: a gamma is enough for a filter.
fn coded(light: f64) -> f64 {
    light.max(0.0).powf(1.0 / 2.2)
}

fn linear(code: f64) -> f64 {
    code.max(0.0).powf(2.2)
}

impl After {
    pub(super) fn of(self, seen: &Picture) -> Picture {
        let luminance = |channels: [Picture; 3]| {
            seen.map(|x, y| {
                let parts = channels.iter().zip([0.2126, 0.7152, 0.0722]);
                parts
                    .map(|(channel, weight)| weight * channel.at(x, y))
                    .sum()
            })
        };
        match self {
            After::Nothing => seen.clone(),
            After::Bilateral(sigma_px, range) => seen.bilateral(sigma_px, range),
            After::Mosaic => luminance([0, 1, 2].map(|colour| seen.colour(colour))),
            After::Ordinary(range) => luminance([0, 1, 2].map(|colour| {
                let coded = seen.colour(colour).through(coded);
                coded.bilateral(1.5, range).sharpened(0.3).through(linear)
            }))
            .jpeg(90),
        }
    }
}

/// One campaign: verdict, error of c over its standard error before it is raised, and the number of
/// photographs whose noise is called reduced.
struct Found {
    verdict: Verdict,
    pull: f64,
    reduced: usize,
}

/// Draws a campaign of four photographs and a reference, and fits it.
fn found(seed: u64, full_well_e: f64, after: After) -> Found {
    let mut stream = Stream(0xca3e << 20 | seed);
    let (a, c) = (stream.between(2.0, 6.0), stream.between(0.25, 0.5));
    let planted = truth(
        Kernel::Eq1,
        LobeShape::Radial,
        a,
        c,
        stream.between(0.3, 0.8),
    );
    let incidence = [5.0, 30.0];
    let table = table(&planted, &incidence, 20.0);
    let mut params = params(
        seed,
        planted,
        &incidence,
        &[150.0, 250.0],
        camera(full_well_e),
    );
    // Ordinary exposure: the mid-air edge is about half as bright as the reference.
    for shot in &mut params.captures {
        shot.edge = PlantedEdge {
            exposure: 6.0,
            ..shot.edge
        };
    }
    let taken = |params: &Params, index: Option<usize>| -> Result<Vec<f32>, Error> {
        let seen = Picture {
            size: [params.camera.width, params.camera.height],
            values: photograph(params, index)?
                .into_iter()
                .map(f64::from)
                .collect(),
        };
        let light = after.of(&seen).values.into_iter();
        Ok(light.map(|v| v as f32).collect())
    };
    let scene = Scene::of(&campaign(&params, &[]), &table, &source(&params, taken));
    let scene = scene.expect("the edges are visible");
    let fit = fitted(&scene, SHARED, Kind::Edge);
    let loss = Loss::new(Kind::Edge, &scene, (SHARED, &fit.solution.parameters));
    let own = fit.c_mm.expect("the kernel has c");
    Found {
        verdict: goodness(&scene, &loss, &fit).verdict,
        pull: (own.value - c) / own.standard_error,
        reduced: scene
            .shots
            .iter()
            .filter(|shot| shot.reduced_noise.is_some())
            .count(),
    }
}

/// Draws campaigns, prints what was found, and returns the numbers of poor ones and of photographs
/// whose noise is called reduced.
fn drawn(draws: u64, full_well_e: f64, after: After) -> [usize; 2] {
    let all: Vec<Found> = (0..draws)
        .into_par_iter()
        .map(|seed| found(seed, full_well_e, after))
        .collect();
    let poor = all
        .iter()
        .filter(|own| own.verdict == Verdict::Poor)
        .count();
    let reduced = all.iter().map(|own| own.reduced).sum::<usize>();
    let square = all.iter().map(|own| own.pull.powi(2)).sum::<f64>() / draws as f64;
    println!(
        "{after:?} at {full_well_e}: {draws} campaigns, {poor} poor, {reduced} photographs reduced; root \
        mean square pull of c {:.2}",
        square.sqrt()
    );
    [poor, reduced]
}

/// Noise of a sensor is not called reduced where the edge is inclined by a ratio of small numbers. Such
/// an edge has few distances of pixels, none of them in the middle of a bin. (Between middles of bins
/// the noise of 7 of 500 good campaigns was called reduced, all at such ratios.)
#[test]
fn edges_of_simple_slopes_are_not_called_smoothed() {
    let slopes = [
        [1, 2],
        [1, 3],
        [2, 3],
        [3, 1],
        [-1, 2],
        [3, 2],
        [1, 4],
        [-2, 5],
    ];
    let planted = truth(Kernel::Eq1, LobeShape::Radial, 4.0, 0.4, 0.5);
    let incidence = [5.0];
    let table = table(&planted, &incidence, 20.0);
    let mut judged = 0;
    for (seed, [rise, run]) in (0..).zip(slopes) {
        let mut params = params(
            seed,
            planted.clone(),
            &incidence,
            &[150.0, 250.0],
            camera(4e4),
        );
        for shot in &mut params.captures {
            shot.edge.normal_deg = f64::from(rise).atan2(f64::from(run)).to_degrees();
            shot.edge.exposure = 6.0;
        }
        let source = source(&params, photograph);
        let scene =
            Scene::of(&campaign(&params, &[]), &table, &source).expect("the edges are visible");
        for shot in &scene.shots {
            assert_eq!(shot.reduced_noise, None, "{rise} : {run}");
            judged += 1;
        }
    }
    println!("{judged} photographs");
}

/// A bilateral filter moves c by many errors at no misfit. It makes a fit poor, and a clean
/// photograph does not.
#[test]
fn noise_reduction_makes_a_fit_poor() {
    assert_eq!(drawn(2, 4e4, After::Nothing), [0, 0]);
    assert_eq!(drawn(2, 4e4, After::Bilateral(2.0, 0.05)), [2, 8]);
}

/// Over 30 campaigns of each camera: clean ones and filters that treat all pixels alike are never
/// called noise reduction, and noise reduction always is.
#[test]
#[ignore = "minutes: `make test-full` runs it"]
fn statistics_of_cameras() {
    const DRAWS: u64 = 30;
    for full_well_e in [1e4, 1e5] {
        for after in [After::Nothing, After::Mosaic] {
            assert_eq!(drawn(DRAWS, full_well_e, after)[1], 0, "{after:?}");
        }
        for after in [
            After::Bilateral(1.5, 0.03),
            After::Bilateral(2.0, 0.1),
            After::Bilateral(3.0, 0.05),
            After::Ordinary(0.03),
        ] {
            assert_eq!(
                drawn(DRAWS, full_well_e, after)[0] as u64,
                DRAWS,
                "{after:?}"
            );
        }
    }
}
