//! Rough facets: normals against the density of visible ones, exit directions against first order,
//! tables against smooth ones.

use crate::tests::cells;

use crate::optics::{Incidence, Rules, deviation};
use crate::plan::{Plan, Request};
use crate::rays::{Index, Luck, Outcome, Scene, Tracer, trace};
use crate::run::RunError;
use crate::samples::Stream;
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

/// Density of slopes of unit roughness.
fn density(slopes: Slopes, slope: DVec2) -> f64 {
    let squared = slope.length_squared();
    match slopes {
        Slopes::Beckmann => (-squared).exp() / PI,
        Slopes::Ggx => 1.0 / (PI * (1.0 + squared).powi(2)),
    }
}

/// The visible area of all small mirrors per area of the facet (Walter et al. 2007; Heitz 2014):
/// cosine (1 + Lambda).
fn projected(slopes: Slopes, sine: f64, cosine: f64) -> f64 {
    match slopes {
        Slopes::Beckmann => {
            let a = cosine / sine;
            0.5 * cosine * libm::erfc(-a) + sine * (-a * a).exp() / (2.0 * PI.sqrt())
        }
        Slopes::Ggx => 0.5 * (cosine + cosine.hypot(sine)),
    }
}

/// Chi-square of the drawn slopes, in 24 x 24 bins over [-3, 3] alpha and one beyond, against the
/// visible density.
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
                    // -travel.normal >= 0 but for rounding.
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
                // In stretched space; the integral of a bin by 16 x 16 midpoints is good to some
                // 1e-4 of it, a kink included, which adds DRAWS x 1e-8 to chi-square.
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
                // What is left must hold what the integral leaves: the density is whole.
                if rest_expected >= 10.0 {
                    chi2 += (rest - rest_expected).powi(2) / rest_expected;
                } else {
                    assert!(
                        rest <= 30.0 && rest_expected > -1.0,
                        "{rest} {rest_expected}"
                    );
                }
                // Wilson and Hilferty; 30 cases stay within 4 sigma but for once in 1,000 seeds.
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

/// Sequences of the ideal cube's facets, the unit normals along its edges, for light along
/// `travel`: what each does to the direction.
fn first_order(order: [usize; 3], travel: DVec3, alpha: f64) -> DMat3 {
    let axes = cells::edges(0.0);
    let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
    let (mut covariance, mut direction) = (DMat3::ZERO, travel);
    for facet in order {
        let normal = axes[facet];
        let mirror = DMat3::IDENTITY - outer(normal, normal) * 2.0;
        // d - 2 (d.n) n with n -> n - s, s square to n, of the covariance alpha^2 / 2.
        let by_slope = (outer(normal, direction) + DMat3::IDENTITY * direction.dot(normal)) * 2.0;
        let slope = (DMat3::IDENTITY - outer(normal, normal)) * (0.5 * alpha * alpha);
        covariance =
            mirror * covariance * mirror.transpose() + by_slope * slope * by_slope.transpose();
        direction = mirror * direction;
    }
    covariance
}

/// Which facets a ray from `point` of the aperture of the ideal cube meets, and by what least part
/// of its way it misses the other orders: facet k is where the coordinate along edge k vanishes.
fn order_of(point: DVec3, travel: DVec3) -> ([usize; 3], f64) {
    let axes = cells::edges(0.0);
    let mut way: Vec<(f64, usize)> = (0..3)
        .map(|k| (-point.dot(axes[k]) / travel.dot(axes[k]), k))
        .collect();
    way.sort_by(|a, b| a.0.total_cmp(&b.0));
    let apart = (way[1].0 - way[0].0).min(way[2].0 - way[1].0);
    ([0, 1, 2].map(|k| way[k].1), apart)
}

/// The exit direction's covariance outside, of rays that all meet the facets in one order: all six
/// orders, hollow and solid, normally and obliquely.
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
            // A point for each order, far from the edges between orders as slopes of 6 alpha could
            // carry the light.
            let mut points: Vec<([usize; 3], DVec2)> = Vec::new();
            for step in 0..100 {
                let flat = DVec2::new(f64::from(step / 10) - 4.5, f64::from(step % 10) - 4.5) / 9.0;
                let (order, apart) = order_of(flat.extend(cells::HEIGHT), light.travel);
                // As far from the rim on its way out.
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
                    let luck = Luck {
                        chance: 0.5,
                        sample: (stream(cases), sample),
                    };
                    trace(&scene, &rules, &light, point, luck)
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
                // Along the incidence frame, then outside: sines grow by the index, and in the
                // plane of incidence angles by 1 / cosine more.
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
                    // First order leaves alpha^2 tan^2 of it, 1e-5 against the 8e-3 of one sigma.
                    // 100 numbers stay within 4.5 sigma but for once in 1,500 seeds.
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

/// A slope of 1e-12 moves no ray of these over the edge of a bin or a facet.
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
                let all: f64 = (0..Fate::ALL.len())
                    .map(|fate| table.fate[[i, a, fate]])
                    .sum();
                assert!(rays == 1 << 14 && (all - 1.0).abs() < 1e-12);
                // A closed cell under its aperture: what enters is reflected at least once.
                assert_eq!(table.fate[[i, a, Fate::Missed as usize]], 0.0);
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 36);
}

/// What turns by more than the tolerance does not return, about as much as the warning says.
#[test]
fn the_warning_knows_how_much_deviates() {
    let cell = cells::triangular();
    let tolerance = 0.5_f64.to_radians();
    let mut cases = 0;
    for (slopes, alpha, slack) in [
        // The lobe moves some light to other paths: a part of the order of alpha.
        (Slopes::Beckmann, 1.5e-3, 3.0 * 1.5e-3),
        (Slopes::Beckmann, 4e-3, 3.0 * 4e-3),
        // One large slope of three is the leading term only: its square is the next.
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
    let said = refused.map_err(|error: RunError| error.to_string());
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

/// The frame in which [`first_order`] speaks is that of the cell: one facet by hand.
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
    // Twice the slope: variance 4 alpha^2 / 2, of 65,536 draws within 4.5 x sqrt(2 / 65,536) = 2.5
    // % and 4 alpha^2.
    for k in 0..2 {
        let ratio = found.col(k)[k] / (2.0 * alpha * alpha);
        assert!((ratio - 1.0).abs() < 0.025 + 4.0 * alpha * alpha, "{ratio}");
    }
}

/// Three perpendicular facets turn light about each axis by 2 alpha rms: a table's exit directions
/// have that spread along and across the plane of incidence, times the index, and in the plane
/// times cos inside over cos outside.
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
            // Sheppard: a bin adds its width^2 / 12.
            let width = found.grid.bin_width();
            let variance = squares / rays - mean * mean - width * width / 12.0;
            let rms = 2.0 * alpha * index * DVec2::new(inside.cos() / outside.cos(), 1.0);
            for axis in 0..2 {
                let off = (variance[axis] / rms[axis].powi(2) - 1.0).abs();
                worst = worst.max(off);
                // Light near edges meets other facets, a part of some alpha; four numbers a case
                // within 4.5 sigma of counting.
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
