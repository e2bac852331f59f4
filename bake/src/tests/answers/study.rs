//! Tests of `bake study`: measured slopes against those of theory, and its estimate of errors.

use crate::plan::Request;
use crate::rays::Tracer;
use crate::study::{
    Reached, Reference, Series, Study, StudyPlan, StudyPoint, StudyRequest, expected_exponent,
    picture, report,
};
use crate::tests::bakes::asked;
use crate::tests::cells::designed;
use meshes::design::{Design, Shape};
use tables::options::Sampler;

fn study(trace: Request, repeats: usize, target: f64) -> Study {
    StudyPlan::new(StudyRequest {
        trace,
        repeats,
        target,
        longest_seconds: f64::INFINITY,
    })
    .expect("a valid request")
    .run(
        &designed(&Design::new(Shape::TriangularPair)),
        &|_, _, _| (),
    )
    .expect("bakes")
}

/// Errors fall with the slopes of theory and are as large as estimated. The study has 2 directions,
/// 16 x 16 bins of which some 100 are met in each direction, and 4 repeats.
///
/// The tolerances are four standard deviations, derived as follows. The error of a bin is half
/// normal: its standard deviation is 0.756 of its mean. The mean L1 of 2 directions x 4 repeats is
/// a sum of 800 of them, some larger than others, so that half as many count: it is good to 0.756 /
/// sqrt 400 = 3.8 %.
///
/// The six points of random rays from 1,024 rays on (4 rays per bin) lie ln 4 apart. So their slope
/// is good to 3.8 % / (ln 4 sqrt 17.5) = 0.0065. With Sobol rays, neighbouring bins share errors:
/// an elementary box that one loses the other gains. A third as many errors are independent, which
/// gives 6.5 %. The four points from 16,384 rays on (4 rays per bin and randomisation) give a slope
/// good to 6.5 % / (ln 4 sqrt 5) = 0.021.
#[test]
#[ignore = "half a minute: `make test-slowest` runs it"]
fn errors_fall_as_theory_says() {
    let target = 0.02;
    let found = study(
        Request {
            refractive_index: Some(1.49),
            ..asked("--incidence 0,20 --azimuth 30 --bins 16 --rays 1048576")
        },
        4,
        target,
    );
    assert!(matches!(found.reference, Reference::Exact { seconds } if seconds > 0.0));
    assert_eq!((found.directions, found.programs), (2, 2));
    assert_eq!(found.series.len(), 4);
    let mut points = 0;
    for series in &found.series {
        let name = report::title(series);
        let slope = series.slope.expect("enough rays");
        let (expected, error, first) = match series.sampler {
            Sampler::Random => (-0.5, 0.0065, 1024.0),
            Sampler::Sobol => (-0.75, 0.021, 16_384.0),
        };
        println!(
            "{name}: slope {:.4} over {:?} rays",
            slope.exponent, slope.range
        );
        assert_eq!(expected_exponent(series.sampler, false), expected);
        assert_eq!(slope.range, [first, f64::from(1 << 20)], "{name}");
        assert!(
            (slope.exponent - expected).abs() < 4.0 * error,
            "{name}: {}",
            slope.exponent
        );
        for point in &series.points {
            assert!(point.seconds > 0.0 && point.l1 <= point.worst_l1, "{name}");
            assert!(point.estimated_l1 <= point.worst_estimated_l1, "{name}");
            if point.rays as f64 >= first {
                println!(
                    "{name}, {} rays: true/estimated {:.3}",
                    point.rays,
                    point.ratio()
                );
                // The tolerance is four times the scatter of the error itself. The estimate knows
                // its sigmas 15 times better (random), or to 18 % each (16 randomisations), which
                // the sum over bins averages out.
                let scatter = if series.sampler == Sampler::Random {
                    0.031
                } else {
                    0.053
                };
                assert!(
                    (point.ratio() - 1.0).abs() < 4.0 * scatter,
                    "{name}, {} rays: {}",
                    point.rays,
                    point.ratio()
                );
            }
            points += 1;
        }
        let after = series
            .points
            .iter()
            .position(|point| point.worst_l1 <= target)
            .expect("within reach");
        let ends = [after - 1, after].map(|at| series.points[at].seconds);
        let Reached::At(seconds) = series.reached else {
            panic!("{name}: the first point is above the target");
        };
        assert!(
            seconds >= ends[0].min(ends[1]) && seconds <= ends[0].max(ends[1]),
            "{name}"
        );
    }
    assert_eq!(points, 4 * 6);
    // The samples do not depend on the tracer. At most a ray on a boundary of a bin may change
    // sides.
    let of = |tracer, sampler| {
        found
            .series
            .iter()
            .find(|series| (series.tracer, series.sampler) == (tracer, sampler))
            .expect("all four")
    };
    for sampler in [Sampler::Random, Sampler::Sobol] {
        let [fast, plain] = [Tracer::Fastest, Tracer::OneByOne].map(|tracer| of(tracer, sampler));
        for (fast, plain) in fast.points.iter().zip(&plain.points) {
            assert!(
                (fast.l1 - plain.l1).abs() <= 4.0 / fast.rays as f64,
                "{} rays",
                fast.rays
            );
        }
    }
}

/// A mean over azimuths has no exact table: a table of more Sobol rays is the reference, and every
/// report says so.
#[test]
fn without_an_exact_table() {
    let found = study(
        asked("--incidence 0,20 --azimuth mean --bins 8 --rays 20000"),
        1,
        1e-9,
    );
    let Reference::Sobol {
        rays, estimated_l1, ..
    } = found.reference
    else {
        panic!("{:?}", found.reference);
    };
    assert_eq!(rays, 4 * 16_384);
    assert!(estimated_l1 > 0.0);
    assert_eq!(found.series.len(), 2, "no program for a mean over azimuths");
    for series in &found.series {
        assert_eq!(series.tracer, Tracer::OneByOne);
        assert_eq!(series.points.len(), 3);
        assert_eq!(series.reached, Reached::Never);
    }
    let text = report::text(&found);
    assert!(
        text.contains("against a Sobol table of 65536 rays per direction"),
        "{text}"
    );
    assert!(
        text.contains("a mean over all azimuths is a numerical integral"),
        "{text}"
    );
    assert!(text.contains("not reached; give more --rays"), "{text}");
    assert!(!report::csv(&found).contains("exact"));
}

/// Texts of pictures are whole, whatever was measured: nothing, one point, errors of 0, and values
/// over twenty decades.
#[test]
fn no_text_of_a_picture_is_cut_or_covered() {
    let measured = [
        vec![],
        vec![[1024, 1]],
        vec![[1024, 0], [4096, 0]],
        vec![[1024, 1], [4096, 1_000], [1 << 40, 1_000_000_000]],
    ];
    let mut cases = 0;
    for points in &measured {
        for seconds in [1e-7, 2.0, 1e6] {
            let point = |&[rays, time]: &[u64; 2]| StudyPoint {
                rays,
                seconds: seconds * time as f64,
                l1: time as f64 / rays as f64,
                worst_l1: if time == 1 {
                    f64::NAN
                } else {
                    1e-9 * time as f64
                },
                estimated_l1: 0.0,
                worst_estimated_l1: 0.0,
                rays_per_bin: 1.0,
            };
            let series = [Tracer::Fastest, Tracer::OneByOne].map(|tracer| Series {
                tracer,
                sampler: Sampler::Sobol,
                points: points.iter().map(point).collect(),
                slope: None,
                reached: Reached::Never,
            });
            let study = Study {
                design: "a-mesh-with_a_name_of/many_letters".repeat(5),
                directions: 1,
                programs: 1,
                azimuth_mean: false,
                bins: 8,
                threads: None,
                repeats: 1,
                target: 1e-12,
                reference: Reference::Exact { seconds },
                series: series.to_vec(),
            };
            assert_eq!(charts::check::faults(&picture::draw(&study)), [""; 0]);
            cases += 1;
        }
    }
    assert_eq!(cases, 12);
}
