//! Tests of images by samples against images by transforms.

use crate::images::Scale;
use crate::images::render;
use crate::images::render::sampled;
use crate::images::render::sampled::Sampled;
use crate::images::{SILENT, Sampler, Sheet, Spot, Viewpoint};
use edges::names::Kernel;
use edges::names::LobeShape;
use edges::photographs::photo::picture::Picture;
use estimator::Error;
use estimator::predict::Fitted;
use estimator::samples::Sampling;
use estimator::samples::Sequence;
use num_complex::Complex64;

use crate::tests::render::views::{load, view};
use crate::tests::render::{Square, picture, place, result};
use lab::planted::{table, truth};

/// Root mean square difference of two images.
fn distance(image: &Picture, other: &Picture) -> f64 {
    let both = image.planes.iter().zip(&other.planes);
    let values: Vec<f64> = both
        .flat_map(|(plane, other)| {
            plane
                .iter()
                .zip(other)
                .map(|(a, b)| f64::from(a - b).powi(2))
        })
        .collect();
    (values.iter().sum::<f64>() / values.len() as f64).sqrt()
}

fn sampling(samples: usize, sequence: Sequence) -> Sampling {
    Sampling {
        samples,
        seed: 3,
        sequence,
    }
}

#[test]
fn samples_meet_the_transforms_within_their_error() {
    let truth = truth(Kernel::Eq1, LobeShape::Radial, 4.9, 0.24, 0.25);
    let table = table(&truth, &[0.0, 20.0], 20.0);
    let scale = Scale {
        pitch_mm: 0.08,
        tangential_axis_deg: 30.0,
        seen_in_mirror: false,
    };
    // The image of a point is the spot itself.
    let (width, height) = (81, 61);
    let mut point = picture(width, height, 0);
    for plane in &mut point.planes {
        plane.fill(0.0);
        plane[(height / 2) * width + width / 2] = 1.0;
    }
    for (kernel, lobe) in [
        ("eq1", Some("radial")),
        ("eq1", Some("separable")),
        ("angular", Some("radial")),
        ("shift", None),
        ("lobe", Some("radial")),
    ] {
        let result = result(kernel, lobe, &table);
        let sheet = Fitted::new(&result, &table).unwrap();
        let place = place(150.0, 20.0);
        let psf = render::uniform_psf(&sheet, &place, &scale, None, SILENT).unwrap();
        for source in [&point, &picture(width, height, 8)] {
            let spectral = render::uniform(source, &psf, SILENT);
            for sequence in [Sequence::Sobol, Sequence::Independent] {
                let Sampled {
                    image,
                    standard_error,
                    seen,
                } = sampled::uniform(
                    source,
                    &sheet,
                    &place,
                    &scale,
                    sampling(256, sequence),
                    SILENT,
                )
                .unwrap();
                let error = standard_error.unwrap();
                let distance = distance(&image, &spectral);
                // Number of pixels whose errors are independent. For a point these are the pixels
                // that it lights (their variance follows their light). For a picture these are the
                // blocks of samples that pixels share: 32,768 samples by 32. The relative scatter
                // of the mean square of n errors is sqrt(2/n), and that of the error from 8
                // randomisations sqrt(2/7n); the roots have half of that.
                let counting = if std::ptr::eq(source, &point) {
                    let light = || spectral.planes[0].iter().map(|&v| f64::from(v.abs()));
                    light().sum::<f64>().powi(2) / light().map(|v| v * v).sum::<f64>()
                } else {
                    1024.0
                };
                let scatter = 0.5 * (2.0 / counting + 2.0 / (7.0 * counting)).sqrt();
                let own = psf.error * psf.energy.unwrap();
                assert!(
                    (distance / error.hypot(own) - 1.0).abs() < 4.0 * scatter,
                    "{kernel} {lobe:?} {sequence:?}: {distance} against {error}"
                );
                assert_eq!(seen[0].energy, psf.energy);
            }
        }
    }
    let wave = result("wave", None, &table);
    let sheet = Fitted::new(&wave, &table).unwrap();
    let refused = sampled::uniform(
        &point,
        &sheet,
        &place(150.0, 20.0),
        &scale,
        sampling(8, Sequence::Sobol),
        SILENT,
    );
    let message = refused.unwrap_err().to_string();
    assert!(message.contains("use --forward spectral"), "{message}");
}

#[test]
fn samples_of_a_view_meet_its_tiles() {
    let source = picture(40, 30, 0);
    let view = load(&view(400.0, 20.0, false)).unwrap();
    let tolerance = 0.002;
    let (tiled, _) = render::viewed(&source, &Millimetre, &view, 1.0, tolerance, SILENT).unwrap();
    let sampled = sampled::viewed(
        &source,
        &Millimetre,
        &view,
        1.0,
        sampling(512, Sequence::Sobol),
        SILENT,
    )
    .unwrap();
    let error = sampled.standard_error.unwrap();
    let energy = sampled
        .seen
        .iter()
        .map(|seen| seen.energy.unwrap())
        .fold(0.0, f64::max);
    let distance = distance(&sampled.image, &tiled);
    // 1,200 pixels of three planes, each with its own samples: the scatter of their root mean
    // square is 2 %.
    assert!(
        distance < 1.1 * error + tolerance * energy,
        "{distance} against {error}"
    );
    assert_eq!(sampled.seen.len(), 40 * 30);
}

/// A square away from the point, which shows a wrong sign or a wrong turn of a spot.
struct Displaced(Square);

const AWAY_MM: [f64; 2] = [0.3, -0.7];

impl Spot for Displaced {
    fn energy(&self) -> Option<f64> {
        self.0.energy()
    }
    fn otf(&self, f: [f64; 2]) -> Complex64 {
        let turn = -std::f64::consts::TAU * (f[0] * AWAY_MM[0] + f[1] * AWAY_MM[1]);
        self.0.otf(f) * Complex64::from_polar(1.0, turn)
    }
    fn reach_mm(&self) -> f64 {
        self.0.reach_mm() + 0.7
    }
    fn samples(&self) -> Option<Box<Sampler<'_>>> {
        let square = self.0.samples()?;
        Some(Box::new(move |point| {
            let at = square(point);
            [at[0] + AWAY_MM[0], at[1] + AWAY_MM[1]]
        }))
    }
}

/// A sheet whose spots are squares of half a millimetre and more. They grow with distance; their
/// energy falls with the incidence.
struct Millimetre;

impl Sheet for Millimetre {
    fn spot(&self, place: &Viewpoint, _: f64) -> Result<Box<dyn Spot + '_>, Error> {
        Ok(Box::new(Displaced(Square {
            width: place.r_mm / 600.0,
            energy: 1.0 / (1.0 + place.incidence_deg),
        })))
    }
}
