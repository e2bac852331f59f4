//! Rough facets: normals against the density of visible ones, exit directions against first order,
//! tables against smooth ones.

use crate::error::Error;
use crate::tests::cells;

use crate::geometry::Stream;
use crate::optics::{Incidence, Rules, deviation};
use crate::plan::{Plan, Request};
use crate::rays::{Index, Outcome, RandomNumbers, Scene, Tracer, trace};
use crate::tests::bakes;
use glam::{DMat2, DMat3, DVec2, DVec3};
use std::f64::consts::PI;
use tables::options::{Method, Roughness, Sampler, SceneOptions, Slopes};
use tables::{Fate, Table};

const KINDS: [Slopes; 2] = [Slopes::Beckmann, Slopes::Ggx];

fn rough(slopes: Slopes, alpha: f64) -> Option<Roughness> {
    Some(Roughness::new(slopes, alpha).expect("a roughness"))
}

fn stream(seed: u64) -> Stream {
    Stream::new(Sampler::Random, seed, 0.0, 0.0, 0)
}

/// Returns the density of slopes of unit roughness.
fn density(slopes: Slopes, slope: DVec2) -> f64 {
    let squared = slope.length_squared();
    match slopes {
        Slopes::Beckmann => (-squared).exp() / PI,
        Slopes::Ggx => 1.0 / (PI * (1.0 + squared).powi(2)),
    }
}

/// Returns the visible area of all small mirrors per area of the facet (Walter et al. 2007; Heitz
/// 2014): cosine (1 + Lambda).
fn projected(slopes: Slopes, sine: f64, cosine: f64) -> f64 {
    match slopes {
        Slopes::Beckmann => {
            let a = cosine / sine;
            0.5 * cosine * libm::erfc(-a) + sine * (-a * a).exp() / (2.0 * PI.sqrt())
        }
        Slopes::Ggx => 0.5 * (cosine + cosine.hypot(sine)),
    }
}

/// The chi-square of the drawn slopes against the visible density is likely. There are 24 x 24 bins
/// over [-3, 3] alpha and one bin for the slopes beyond.
#[test]
fn normals_have_the_density_of_visible_ones() {
    const BINS: usize = 24;
    const DRAWS: u64 = 1 << 18;
    let side = 6.0 / BINS as f64;
    let facet = DVec3::new(0.3, -0.5, 0.9).normalize();
    let mut cases = 0;
    for (case, slopes) in KINDS.into_iter().enumerate() {
        for alpha in [1e-4, 0.05, 0.7] {
            for incidence_deg in [0.0, 20.0, 54.7, 80.0, 89.9_f64] {
                let (sine, cosine) = incidence_deg.to_radians().sin_cos();
                let x = DVec3::new(0.9, 0.0, -0.3).normalize();
                assert!(x.dot(facet).abs() < 1e-12);
                let y = facet.cross(x);
                let travel = -(facet * cosine + x * sine);
                let roughness = rough(slopes, alpha).unwrap();
                let stream = stream(100 + case as u64);
                let mut counts = [0_u32; BINS * BINS + 1];
                for index in 0..DRAWS {
                    let normal = crate::optics::roughness::normal(
                        &roughness,
                        facet,
                        travel,
                        stream.at_bounce(index, 0),
                    );
                    assert!((normal.length() - 1.0).abs() < 1e-14);
                    // The normal is towards the ray: -travel.normal >= 0 but for rounding.
                    assert!(travel.dot(normal) < 1e-12);
                    let slope = -DVec2::new(normal.dot(x), normal.dot(y)) / normal.dot(facet);
                    let bin = (slope / alpha + 3.0) / side;
                    let inside = bin.min_element() >= 0.0 && bin.max_element() < BINS as f64;
                    let bin = match inside {
                        true => bin.y as usize * BINS + bin.x as usize,
                        false => BINS * BINS,
                    };
                    counts[bin] += 1;
                }
                // The integral is taken in stretched space. By 16 x 16 midpoints a bin is good to
                // some 1e-4 of itself, also at a kink, which adds DRAWS x 1e-8 to chi-square.
                let stretched = DVec2::new(alpha * sine, cosine).normalize();
                let whole = projected(slopes, stretched.x, stretched.y);
                let seen = |slope: DVec2| {
                    let area = (stretched.y - stretched.x * slope.x).max(0.0);
                    area * density(slopes, slope) / whole
                };
                let (mut chi2, mut freedom) = (0.0, 0.0);
                let (mut rest, mut rest_expected) = (f64::from(DRAWS as u32), DRAWS as f64);
                for (bin, &count) in counts[..BINS * BINS].iter().enumerate() {
                    let corner = DVec2::new((bin % BINS) as f64, (bin / BINS) as f64);
                    let parts = (0..256).map(|k| {
                        let inner = DVec2::new(f64::from(k % 16) + 0.5, f64::from(k / 16) + 0.5);
                        seen((corner + inner / 16.0) * side - 3.0)
                    });
                    let expected = DRAWS as f64 * parts.sum::<f64>() / 256.0 * side * side;
                    if expected >= 10.0 {
                        chi2 += (f64::from(count) - expected).powi(2) / expected;
                        freedom += 1.0;
                        rest -= f64::from(count);
                        rest_expected -= expected;
                    }
                }
                // The bins with few draws are taken together. They must hold the rest of the
                // density, whose integral is 1.
                if rest_expected >= 10.0 {
                    chi2 += (rest - rest_expected).powi(2) / rest_expected;
                } else {
                    assert!(
                        rest <= 30.0 && rest_expected > -1.0,
                        "{rest} {rest_expected}"
                    );
                }
                // The test follows Wilson and Hilferty. In 999 of 1,000 seeds 30 cases stay within
                // 4 sigma.
                let spread: f64 = 2.0 / (9.0 * freedom);
                let sigmas = ((chi2 / freedom).cbrt() - (1.0 - spread)) / spread.sqrt();
                assert!(
                    freedom > 100.0 && sigmas.abs() < 4.0,
                    "{slopes:?} {alpha} {incidence_deg}: chi-square {chi2:.0} of {freedom}, \
                    {sigmas:.1} sigma"
                );
                cases += 1;
            }
        }
    }
    println!("{cases} chi-squares");
    assert_eq!(cases, 30);
}

/// Returns the first-order covariance of the exit direction of light along `travel` that meets the
/// facets of an ideal cube in the given order. The facets' unit normals are the edges of the cube.
fn first_order(order: [usize; 3], travel: DVec3, alpha: f64) -> DMat3 {
    let axes = cells::edges(0.0);
    let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
    let (mut covariance, mut direction) = (DMat3::ZERO, travel);
    for facet in order {
        let normal = axes[facet];
        let mirror = DMat3::IDENTITY - outer(normal, normal) * 2.0;
        // The derivative of d - 2 (d.n) n by n -> n - s, with s perpendicular to n, of the
        // covariance alpha^2 / 2.
        let by_slope = (outer(normal, direction) + DMat3::IDENTITY * direction.dot(normal)) * 2.0;
        let slope = (DMat3::IDENTITY - outer(normal, normal)) * (0.5 * alpha * alpha);
        covariance =
            mirror * covariance * mirror.transpose() + by_slope * slope * by_slope.transpose();
        direction = mirror * direction;
    }
    covariance
}

/// Returns the order in which a ray from `point` of the aperture of an ideal cube meets the facets,
/// and the least part of its way by which it misses the other orders. Facet k is where the
/// coordinate along edge k is 0.
fn order_of(point: DVec3, travel: DVec3) -> ([usize; 3], f64) {
    let axes = cells::edges(0.0);
    let mut way: Vec<(f64, usize)> = (0..3)
        .map(|k| (-point.dot(axes[k]) / travel.dot(axes[k]), k))
        .collect();
    way.sort_by(|a, b| a.0.total_cmp(&b.0));
    let apart = (way[1].0 - way[0].0).min(way[2].0 - way[1].0);
    ([0, 1, 2].map(|k| way[k].1), apart)
}

/// The covariance of the exit direction outside is the one of first order, for rays that all meet
/// the facets in one order: all six orders, hollow and solid, normal and oblique incidence.
#[test]
fn exit_directions_spread_as_three_facets_do() {
    const RAYS: u64 = 1 << 15;
    let alpha = 1e-3;
    let scene = Scene::new(&cells::triangular(), Index::Loop);
    let (mut cases, mut worst) = (0, 0.0_f64);
    for index in [1.0, 1.49] {
        for (incidence, azimuth) in [(0.0, 0.0), (15.0, 20.0), (25.0, 200.0_f64)] {
            let incidence: f64 = incidence;
            let light = Incidence::new(incidence.to_radians(), azimuth.to_radians(), index);
            let rules = Rules {
                roughness: rough(Slopes::Beckmann, alpha),
                ..Rules::mirrors(index)
            };
            // A point for each order, so far from the edges between orders that slopes of 6 alpha
            // could not carry the light across.
            let mut points: Vec<([usize; 3], DVec2)> = Vec::new();
            for step in 0..100 {
                let flat = DVec2::new(f64::from(step / 10) - 4.5, f64::from(step % 10) - 4.5) / 9.0;
                let (order, apart) = order_of(flat.extend(cells::HEIGHT), light.travel);
                // The ray is as far from the rim on its way out.
                let returns = |turn: i32| {
                    let aside = DVec2::from_angle(f64::from(turn)) * 0.03;
                    let outcome = trace(&scene, &Rules::mirrors(index), &light, flat + aside, 0.5);
                    outcome.fate == Fate::Retroreflected
                };
                let known = points.iter().any(|(other, _)| *other == order);
                if apart > 0.05 && !known && (0..6).all(returns) {
                    points.push((order, flat));
                }
            }
            assert!(points.len() >= 4, "{incidence} {azimuth}: {points:?}");
            for (order, point) in points {
                let samples = (0..RAYS).map(|sample| {
                    let random = RandomNumbers {
                        chance: 0.5,
                        sample: (stream(cases), sample),
                    };
                    trace(&scene, &rules, &light, point, random)
                });
                let inside = |way: DVec3| {
                    let flat = light.to_frame(way.truncate());
                    flat.extend(way.z)
                };
                let spots: Vec<DVec2> = samples
                    .map(|outcome: Outcome| {
                        assert_eq!(outcome.bounces, 3);
                        deviation(inside(light.travel), inside(outcome.travel), index)
                    })
                    .collect();
                let mean = spots.iter().sum::<DVec2>() / RAYS as f64;
                let moment = |i: usize, k: usize| {
                    let products = spots.iter().map(|s| (s[i] - mean[i]) * (s[k] - mean[k]));
                    products.sum::<f64>() / RAYS as f64
                };
                // The covariance is turned into the incidence frame and then outside: sines grow by
                // the index, and in the plane of incidence angles grow by 1 / cosine more.
                let cosine = incidence.to_radians().cos();
                let covariance = first_order(order, light.travel, alpha);
                let frame = [light.u.extend(0.0), light.v().extend(0.0)];
                let grown = DVec2::new(index / cosine, index);
                let expected =
                    |i: usize, k: usize| frame[i].dot(covariance * frame[k]) * grown[i] * grown[k];
                for (i, k) in [(0, 0), (0, 1), (1, 1)] {
                    let spread = expected(i, i) * expected(k, k);
                    let sigma = ((spread + expected(i, k).powi(2)) / RAYS as f64).sqrt();
                    let off = (moment(i, k) - expected(i, k)) / sigma;
                    worst = worst.max(off.abs());
                    // First order leaves out alpha^2 tan^2, 1e-5 against the 8e-3 of one sigma. In
                    // 1,499 of 1,500 seeds 100 numbers stay within 4.5 sigma.
                    assert!(
                        off.abs() < 4.5,
                        "{index} {incidence} {order:?} {i}{k}: {off:.1} sigma"
                    );
                }
                cases += 1;
            }
        }
    }
    println!("{cases} covariances, within {worst:.1} sigma of the closed form");
    assert!(cases >= 30, "{cases}");
}

fn request(incidence: &str, roughness: Option<Roughness>, rays: u64) -> Request {
    Request {
        incidence: incidence.into(),
        azimuth: "0,40".into(),
        refractive_index: Some(1.0),
        rays: Some(rays),
        bins: 32,
        scene: SceneOptions {
            roughness,
            ..SceneOptions::default()
        },
        ..Request::default()
    }
}

fn bake(request: Request) -> Table {
    let plan = Plan::new(&request).expect("a plan");
    bakes::bake(&cells::pair(), &plan).expect("bakes")
}

/// A slope of 1e-12 moves no ray of this bake over the edge of a bin or a facet.
#[test]
fn without_roughness_the_table_is_that_of_smooth_facets() {
    let smooth = request("0:60:20", None, 1 << 15);
    let plan = Plan::new(&smooth).expect("a plan");
    let smooth = bakes::rays_by(Tracer::OneByOne, &cells::pair(), &plan).expect("bakes");
    let mut cases = 0;
    for slopes in KINDS {
        let rough = bake(request("0:60:20", rough(slopes, 1e-12), 1 << 15));
        assert_eq!(rough.provenance.method.text(), "rays");
        assert_eq!(rough.counts, smooth.counts, "{slopes:?}");
        assert_eq!(rough.fate_counts, smooth.fate_counts, "{slopes:?}");
        cases += 1;
    }
    assert_eq!(cases, 2);
}

#[test]
fn every_ray_has_a_fate_however_rough() {
    let mut cases = 0;
    for slopes in KINDS {
        for alpha in [1e-3, 0.1, 1.0] {
            let table = bake(request("0,45,89.9", rough(slopes, alpha), 1 << 14));
            assert_eq!(tables::check(&table), Ok(()), "{slopes:?} {alpha}");
            for ((i, a), &rays) in table.rays.indexed_iter() {
                let all: f64 = table.fate.slice(ndarray::s![i, a, ..]).sum();
                assert!(rays == 1 << 14 && (all - 1.0).abs() < 1e-12);
                // The cell is closed under its aperture: light that enters is reflected at least
                // once.
                assert_eq!(table.fate[[i, a, Fate::Missed as usize]], 0.0);
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 36);
}

/// Light that turns by more than the tolerance does not return. Its share is about the one that the
/// warning states.
#[test]
fn the_warning_knows_how_much_deviates() {
    let cell = cells::triangular();
    let tolerance = 0.5_f64.to_radians();
    let mut cases = 0;
    for (slopes, alpha, slack) in [
        // The lobe moves a share of the order of alpha to other paths.
        (Slopes::Beckmann, 1.5e-3, 3.0 * 1.5e-3),
        (Slopes::Beckmann, 4e-3, 3.0 * 4e-3),
        // One large slope of three is the leading term only. The next term is its square.
        (Slopes::Ggx, 3e-4, 3.0 * 0.0142_f64.powi(2) + 3.0 * 3e-4),
        (Slopes::Ggx, 1e-3, 3.0 * 0.137_f64.powi(2) + 3.0 * 1e-3),
    ] {
        let said = crate::optics::roughness::part_beyond(&rough(slopes, alpha).unwrap(), tolerance);
        let plan = |roughness| {
            let request = Request {
                azimuth: "0".into(),
                method: Method::Rays,
                ..request("0", roughness, 1 << 17)
            };
            Plan::new(&request).expect("a plan")
        };
        let [rough, smooth] = [rough(slopes, alpha), None]
            .map(|roughness| bakes::bake(&cell, &plan(roughness)).expect("bakes"));
        let kept = rough.retroreflected[[0, 0]] / smooth.retroreflected[[0, 0]];
        let error = 4.0 * rough.standard_error[[0, 0]];
        let off = (1.0 - kept - said).abs();
        println!(
            "{slopes:?} {alpha}: {:.4} deviate, {said:.4} said",
            1.0 - kept
        );
        assert!(off < slack + error, "{slopes:?} {alpha}: {off}");
        let warned = plan(self::rough(slopes, alpha)).warnings(&bakes::prepared(&cell));
        assert_eq!(warned.len(), usize::from(said > 0.01), "{warned:?}");
        cases += 1;
    }
    assert_eq!(cases, 4);
}

#[test]
fn threads_and_shards_do_not_show() {
    let of = |threads: usize, shard: Option<&str>, sampler: Sampler| Request {
        threads: Some(threads),
        shard: shard.map(str::to_owned),
        sampler,
        ..request("0,30", rough(Slopes::Ggx, 0.002), (1 << 17) + 5)
    };
    let mut cases = 0;
    for sampler in [Sampler::Sobol, Sampler::Random] {
        let whole = bake(of(1, None, sampler));
        assert_eq!(bake(of(3, None, sampler)), whole);
        let parts = ["1/3", "2/3", "3/3"].map(|shard| bake(of(2, Some(shard), sampler)));
        let sum = parts
            .iter()
            .skip(1)
            .fold(parts[0].counts.clone().expect("counts"), |sum, part| {
                sum + part.counts.as_ref().expect("counts")
            });
        assert_eq!(Some(sum), whole.counts);
        cases += 1;
    }
    assert_eq!(cases, 2);
}

#[test]
fn the_exact_method_refuses_and_auto_traces_rays() {
    let asked = request("0", rough(Slopes::Beckmann, 0.001), 1 << 10);
    let plan = Plan::new(&Request {
        method: Method::Exact,
        ..asked.clone()
    });
    let refused = bakes::bake(&cells::pair(), &plan.expect("a plan"));
    let said = refused.map_err(|error: Error| error.to_string());
    assert_eq!(
        said.expect_err("no planes"),
        "--method exact: --roughness 0.001 leaves no plane mirrors, which the exact method needs"
    );
    assert_eq!(bake(asked).provenance.method.text(), "rays");
    for text in [
        "0",
        "-1",
        "2",
        "nan",
        "ggx",
        "ggx:",
        "gauss:0.1",
        "0.1:ggx",
        "",
    ] {
        assert!(text.parse::<Roughness>().is_err(), "{text}");
    }
}

/// Checks by one facet, by hand, that the frame of [`first_order`] is that of the cell.
#[test]
fn one_slope_turns_light_by_twice_itself() {
    let normal = DVec3::Z;
    let travel = DVec3::NEG_Z;
    let (alpha, mut sum) = (0.01, DMat2::ZERO);
    let roughness = rough(Slopes::Beckmann, alpha).unwrap();
    let draws = 1 << 16;
    for index in 0..draws {
        let drawn = crate::optics::roughness::normal(
            &roughness,
            normal,
            travel,
            stream(3).at_bounce(index, 0),
        );
        let left = (travel - drawn * (2.0 * travel.dot(drawn))).truncate();
        sum += DMat2::from_cols(left * left.x, left * left.y);
    }
    let found = sum * (1.0 / draws as f64);
    // The direction turns by twice the slope, so its variance is 4 alpha^2 / 2. Over 65,536 draws
    // it is within 4.5 x sqrt(2 / 65,536) = 2.5 % and 4 alpha^2.
    for k in 0..2 {
        let ratio = found.col(k)[k] / (2.0 * alpha * alpha);
        assert!((ratio - 1.0).abs() < 0.025 + 4.0 * alpha * alpha, "{ratio}");
    }
}

/// Three perpendicular facets turn light about each axis by 2 alpha rms. The exit directions of a
/// table have this spread times the index along and across the plane of incidence, and in the plane
/// also times cos inside over cos outside.
#[test]
fn a_table_has_the_spread_of_its_roughness() {
    let alpha = 5e-4;
    let (mut cases, mut worst) = (0, 0.0_f64);
    for index in [1.0, 1.49] {
        let table = bake(Request {
            refractive_index: Some(index),
            ..request("0,20", rough(Slopes::Beckmann, alpha), 1 << 18)
        });
        let found = table.deviations.as_ref().expect("exit directions");
        for (direction, entries) in found.entries.iter().enumerate() {
            let outside = table.axes.incidence_deg[direction / 2].to_radians();
            let inside = (outside.sin() / index).asin();
            let (mut rays, mut sum, mut squares) = (0.0, DVec2::ZERO, DVec2::ZERO);
            for entry in entries {
                let (_, bin) = found.grid.at(entry.place);
                assert!(!found.grid.is_outermost(bin), "all light lies in the grid");
                let at = DVec2::from_array(found.grid.deviation(bin));
                let n = entry.rays as f64;
                (rays, sum, squares) = (rays + n, sum + at * n, squares + at * at * n);
            }
            let mean = sum / rays;
            // By Sheppard's correction a bin adds its width^2 / 12.
            let width = found.grid.bin_width();
            let variance = squares / rays - mean * mean - width * width / 12.0;
            let rms = 2.0 * alpha * index * DVec2::new(inside.cos() / outside.cos(), 1.0);
            for axis in 0..2 {
                let off = (variance[axis] / rms[axis].powi(2) - 1.0).abs();
                worst = worst.max(off);
                // Light near edges meets other facets, a share of some alpha. The four numbers of a
                // case are within 4.5 sigma of counting.
                let allowed = 4.5 * (2.0 / rays).sqrt() + 4.0 * alpha;
                assert!(
                    off < allowed,
                    "{index} {direction} {axis}: {off} of {allowed}"
                );
                cases += 1;
            }
        }
    }
    println!("{cases} variances within {worst:.1e} of the closed form");
    assert_eq!(cases, 2 * 4 * 2);
}
