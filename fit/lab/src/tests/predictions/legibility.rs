//! Tests of what can be read of a mid-air image: letters against closed forms, errors against
//! differences.

use crate::planted::{table, truth};
use crate::tests::predictions::prediction::{result, with};
use edges::names::{Kernel, LobeShape};
use estimator::predict::{Fitted, Legibility, Limit, Viewing, Viewpoint, legibility};
use estimator::result::ResultFile;
use tables::Table;

fn at(result: &ResultFile, table: &Table, incidence_deg: f64, viewing: Viewing) -> Legibility {
    let sheet = Fitted::new(result, table).expect("it is the table of the result");
    let place = Viewpoint {
        incidence_deg,
        azimuth_deg: Some(20.0),
        r_mm: 170.0,
    };
    legibility(&sheet, &place, &viewing).expect("the table holds the direction")
}

/// The separable lobe has the MTF 1 - pi f / a along both axes, which falls to m at (1 - m) a / pi.
/// A letter has 2.5 periods, and its strokes the contrast C MTF = 0.1 where C = L / (L + 2 A).
#[test]
fn letters_are_those_of_the_closed_form() {
    let planted = truth(Kernel::Lobe, LobeShape::Separable, 4.0, 0.24, 0.25);
    let table = table(&planted, &[0.0, 20.0, 40.0], 20.0);
    let result = result(Kernel::Lobe, LobeShape::Separable, &table);
    let mut cases = 0;
    for incidence_deg in [0.0, 20.0] {
        let a = 4.0 * (1.0 - 0.2 * incidence_deg / 40.0);
        for share in [0.0, 0.3, 2.0, 4.4, 4.6] {
            let dark = Viewing {
                ambient: 0.0,
                viewer_mm: 100.0,
            };
            let light = at(&result, &table, incidence_deg, dark).luminance.value;
            let light = light.expect("mu is known");
            let viewing = Viewing {
                ambient: share * light,
                ..dark
            };
            let found = at(&result, &table, incidence_deg, viewing);
            let contrast = found.contrast.value.expect("mu is known");
            assert!((contrast * (1.0 + 2.0 * share) - 1.0).abs() < 1e-14);
            let height = |level: f64| 2.5 * std::f64::consts::PI / ((1.0 - level) * a);
            let near = |value: Option<f64>, expected: f64| {
                // The search ends at 1e-12 of the frequency.
                let off = value.expect("it is readable") / expected - 1.0;
                assert!(off.abs() < 1e-11, "{off:e}");
            };
            near(found.letter_in_the_dark.height_mm.value, height(0.1));
            near(found.mtf50_per_mm.value, 0.5 * a / std::f64::consts::PI);
            let letter = found.letter.expect("mu is known");
            // From 4.5 times the light of the image on, its contrast is below a tenth.
            if share > 4.5 {
                assert_eq!(letter.limit, Limit::Contrast);
                assert_eq!(letter.height_mm.value, None);
            } else {
                assert_eq!(letter.limit, Limit::Blur);
                near(letter.height_mm.value, height(0.1 * (1.0 + 2.0 * share)));
            }
            cases += 1;
        }
    }
    assert_eq!(cases, 10);
    // Five minutes of arc are 1.4544 mm at a metre: far away, the eye is the limit.
    let far = Viewing {
        ambient: 0.0,
        viewer_mm: 10_000.0,
    };
    let letter = at(&result, &table, 0.0, far)
        .letter
        .expect("no ambient light");
    assert_eq!(letter.limit, Limit::Eye);
    let eye = letter.height_mm.value.expect("it is readable");
    assert!((eye - 14.544).abs() < 5e-4, "{eye}");
}

/// Standard errors are those of differences, as for predictions: a step of 1e-3 of an error of 2 %
/// leaves 1e-10 of the third derivative and 1e-10 of rounding; the slopes of the MTF and the
/// derivatives of tabulated lobes are right to 1e-4.
#[test]
fn standard_errors_are_those_of_differences() {
    let planted = truth(Kernel::Wave, LobeShape::Radial, 4.0, 0.24, 0.25);
    let table = table(&planted, &[0.0, 10.0, 40.0], 20.0);
    let mut cases = 0;
    for kernel in [Kernel::Eq1, Kernel::Angular, Kernel::Wave, Kernel::Saito] {
        let shape = match kernel.is_baseline() {
            true => LobeShape::Ggx,
            false => LobeShape::Radial,
        };
        let result = result(kernel, shape, &table);
        for incidence_deg in [0.0, 10.0] {
            let viewing = Viewing {
                ambient: 0.02,
                viewer_mm: 100.0,
            };
            let numbers = |result: &ResultFile| {
                let found = at(result, &table, incidence_deg, viewing);
                let letter = found.letter.expect("mu is known").height_mm;
                let dark = found.letter_in_the_dark.height_mm;
                [
                    found.luminance,
                    found.contrast,
                    found.mtf50_per_mm,
                    dark,
                    letter,
                ]
            };
            let covariance = &result.covariance;
            let n = covariance.names.len();
            let entry = |i: usize, j: usize| covariance.matrix[i][j].expect("it is finite");
            let slopes: Vec<[f64; 5]> = (0..n)
                .map(|i| {
                    let step = 1e-3 * entry(i, i).sqrt();
                    let moved = |by| numbers(&with(&result, covariance.names[i], by));
                    let sides = [moved(step), moved(-step)];
                    let value = |side: usize, k: usize| sides[side][k].value.expect("known");
                    std::array::from_fn(|k| (value(0, k) - value(1, k)) / (2.0 * step))
                })
                .collect();
            for (k, number) in numbers(&result).into_iter().enumerate() {
                let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
                let terms = pairs.map(|(i, j)| slopes[i][k] * entry(i, j) * slopes[j][k]);
                let expected = terms.sum::<f64>().sqrt();
                let error = number.standard_error.expect("the covariance is whole");
                let off = (error / expected - 1.0).abs();
                assert!(off < 1e-4, "{kernel:?} {k}: {error} {expected}");
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 4 * 2 * 5);
}
