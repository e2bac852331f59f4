//! What real cameras and sheets have and the model does not, each planted in its physical form, and
//! campaigns drawn over their sizes: verdicts, and the coverage of the stated 95 % intervals.

use edges::names::{Kernel, LobeShape, ParameterKind};
use estimator::estimate::campaign::{Estimated, undiagnosed};
use estimator::estimate::{Candidates, Options, Progress, Value, Verdict};
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::cameras::{After, Picture};
use crate::planted::{Stream, camera, params, table, truth};
use crate::simulate::cell::{self, CubeShift};
use crate::simulate::photograph::{exposed, photograph, smeared};
use crate::simulate::{Error, Params};
use crate::study::trial;

type V = Vector3<f64>;

/// What the camera or the sheet has beside the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Effect {
    /// Nothing.
    None,
    /// Defocus of the mid-air photographs by a disc of this radius, pixels.
    Disc(f64),
    /// Another standard deviation of the lens than that of the reference, pixels.
    Lens(f64),
    /// The same of the photographs at the nearer and at the farther distance.
    Focus([f64; 2]),
    /// Independent errors of all dihedral angles of this standard deviation, mrad.
    Dihedral(f64),
    /// Errors of the dihedral angles at the edges 1, 2 and 3 of all cubes, mrad.
    Common([f64; 3]),
    /// A perfect round pupil with this radius of its blur, 1 / cut-off, pixels.
    Pupil(f64),
    /// A halo of this share of the light, with tails of 20 pixels.
    Halo(f64),
    /// Linear sharpening of this strength.
    Sharpening(f64),
    /// What the camera does after the sensor.
    After(After),
}

/// Returns the offsets (pixels) along an edge normal that a disc causes, with their shares: the
/// chords of the disc, by the rule of Gauss and Chebyshev of the second kind.
fn disc(radius_px: f64) -> Vec<(f64, f64)> {
    const NODES: usize = 16;
    let step = std::f64::consts::PI / (NODES + 1) as f64;
    let node = |k: usize| {
        let (sine, cosine) = (k as f64 * step).sin_cos();
        (radius_px * cosine, 2.0 / (NODES + 1) as f64 * sine * sine)
    };
    (1..=NODES).map(node).collect()
}

/// Light that cubes with dihedral errors behind a flat front send back: directions outside.
pub(super) struct Cubes {
    pub incidence_rad: f64,
    pub refractive_index: f64,
    /// Standard deviation of independent errors, rad.
    pub error_rad: f64,
}

impl Cubes {
    /// Traces a ray through a cube of random errors, by any order of its facets. Returns the
    /// deviation of the light from the exact way back, (tangential, sagittal) rad.
    pub(super) fn ray(&self, stream: &mut Stream) -> [f64; 2] {
        let azimuth_rad = stream.between(0.0, std::f64::consts::TAU);
        let normals = facets(std::array::from_fn(|_| self.error_rad * stream.normal()));
        let mut order = [0, 1, 2];
        order.swap(0, (stream.between(0.0, 3.0) as usize).min(2));
        order.swap(1, 1 + (stream.between(0.0, 2.0) as usize).min(1));
        let light = Light::new(self.incidence_rad, azimuth_rad, self.refractive_index);
        light.deviation(&normals, order)
    }
}

/// Returns the normals, towards the light, of the facets of a cube whose axis is z, and whose edge 1 is
/// at azimuth 0. The dihedral angles at the edges 1, 2 and 3 have these errors, rad.
fn facets(errors: [f64; 3]) -> [V; 3] {
    let edges = [0.0_f64, 120.0, 240.0].map(|turn| {
        let (sine, cosine) = turn.to_radians().sin_cos();
        V::new(cosine, sine, 0.0) * (2.0_f64 / 3.0).sqrt() + V::z() / 3.0_f64.sqrt()
    });
    // The facets 1 and 2 meet at edge 3, and so on.
    let [bc, ac, ab] = errors.map(f64::sin);
    let gram = Matrix3::new(1.0, ab, ac, ab, 1.0, bc, ac, bc, 1.0);
    let rows = gram.cholesky().expect("errors are small").l();
    [0, 1, 2].map(|i| {
        let parts = edges.iter().enumerate();
        parts.map(|(k, edge)| edge * rows[(i, k)]).sum::<V>()
    })
}

/// Parallel light that falls on a sheet.
struct Light {
    arriving: V,
    /// Direction within the sheet.
    within: V,
    /// Along the plane of incidence, and across it.
    axes: [V; 2],
    cosine: f64,
    index: f64,
}

impl Light {
    fn new(incidence_rad: f64, azimuth_rad: f64, index: f64) -> Light {
        let (sine, cosine) = incidence_rad.sin_cos();
        let u = V::new(azimuth_rad.cos(), azimuth_rad.sin(), 0.0);
        let arriving = u * sine - V::z() * cosine;
        Light {
            arriving,
            // Snell's law: the components along the face are divided by the index.
            within: refracted(&arriving, index.recip()),
            axes: [u, V::z().cross(&u)],
            cosine,
            index,
        }
    }

    /// Returns the deviation, (tangential, sagittal) rad, of light that meets facets in this order.
    fn deviation(&self, normals: &[V; 3], order: [usize; 3]) -> [f64; 2] {
        let mut ray = self.within;
        for i in order {
            ray -= normals[i] * (2.0 * ray.dot(&normals[i]));
        }
        let off = refracted(&ray, self.index) + self.arriving;
        let sine = self.arriving.dot(&self.axes[0]);
        let tangential = self.axes[0] * self.cosine + V::z() * sine;
        [off.dot(&tangential), off.dot(&self.axes[1])]
    }

    /// Returns the order in which the light meets the facets of a cube whose apex is the origin, if it
    /// enters beside the ray that meets the apex by `entry`, (u, v).
    fn order(&self, normals: &[V; 3], entry: [f64; 2]) -> [usize; 3] {
        const FAR: f64 = 10.0;
        let mut at = self.axes[0] * entry[0] + self.axes[1] * entry[1] - self.within * FAR;
        let mut ray = self.within;
        [0, 1, 2].map(|_| {
            let time = |n: &V| match -ray.dot(n) {
                speed if speed > 0.0 => at.dot(n) / speed,
                _ => f64::INFINITY,
            };
            let times = normals.map(|n| time(&n));
            let first = (0..3).min_by(|&a, &b| times[a].total_cmp(&times[b]));
            let first = first.expect("there are three facets");
            at += ray * times[first];
            ray -= normals[first] * (2.0 * ray.dot(&normals[first]));
            first
        })
    }
}

/// Returns the shifts of a capture through cubes that share dihedral errors, those of the deviation at
/// its distance included: of thin wedges about the apex, whose middle ray is traced.
fn through_bent_cubes(params: &Params, index: usize, errors_mrad: [f64; 3]) -> Vec<CubeShift> {
    const WEDGES: usize = 30;
    let (shot, truth) = (&params.captures[index], &params.truth);
    let (theta, azimuth) = (
        shot.incidence_deg.to_radians(),
        shot.azimuth_deg.to_radians(),
    );
    let cubes = cell::shifts(theta, azimuth, truth.refractive_index, truth.pair);
    let per_tangent = shot.floating_distance_mm / truth.c_mm;
    let normals = facets(errors_mrad.map(|error| 1e-3 * error));
    let mut shifts = Vec::new();
    for (k, cube) in cubes.iter().enumerate() {
        // A cube that is turned by half a turn sees light from the other side.
        let turn = k as f64 * std::f64::consts::PI;
        let light = Light::new(theta, azimuth + turn, truth.refractive_index);
        let corners = cube.polygon.len();
        let share = cube.retroreflected / cubes.len() as f64 / cell::area(&cube.polygon);
        for i in 0..corners {
            let (from, to) = (cube.polygon[i], cube.polygon[(i + 1) % corners]);
            let on = |part: f64| [0, 1].map(|k| from[k] + part * (to[k] - from[k]));
            for w in 0..WEDGES {
                let [a, b] = [w, w + 1].map(|w| on(w as f64 / WEDGES as f64));
                // The shift is minus twice the place of entry.
                let middle = [0, 1].map(|k| -(a[k] + b[k]) / 6.0);
                let order = light.order(&normals, middle);
                let [tangential, v] = light.deviation(&normals, order);
                let off = [per_tangent * tangential / theta.cos(), per_tangent * v];
                let moved = |p: [f64; 2]| [p[0] + off[0], p[1] + off[1]];
                let wedge = [[0.0; 2], a, b];
                shifts.push(CubeShift {
                    polygon: wedge.map(moved).to_vec(),
                    retroreflected: share * cell::area(&wedge),
                });
            }
        }
    }
    shifts
}

/// Refracts a unit vector at the face z = 0, whose components along the face are multiplied by
/// `index`.
fn refracted(ray: &V, index: f64) -> V {
    let [x, y] = [ray.x * index, ray.y * index];
    V::new(x, y, (1.0 - x * x - y * y).sqrt().copysign(ray.z))
}

/// Returns a histogram of the offsets (pixels) along the edge of a capture that rays through cubes
/// with dihedral errors cause.
fn thrown(params: &Params, index: usize, error_rad: f64) -> Vec<(f64, f64)> {
    const RAYS: usize = 400_000;
    let shot = &params.captures[index];
    let cubes = Cubes {
        incidence_rad: shot.incidence_deg.to_radians(),
        refractive_index: params.truth.refractive_index,
        error_rad,
    };
    let normal = (shot.edge.normal_deg - shot.tangential_axis_deg).to_radians();
    let px = shot.floating_distance_mm / params.camera.pixel_pitch_mm;
    let mut stream = Stream(0xd1ed << 20 | params.seed << 6 | index as u64);
    let offset = |_| {
        let [along, across] = cubes.ray(&mut stream);
        px * (along * normal.cos() + across * normal.sin())
    };
    let mut offsets: Vec<f64> = (0..RAYS).map(offset).collect();
    offsets.sort_by(f64::total_cmp);
    // Groups of neighbours have their mean. Within a group the offsets vary by a thousandth of
    // their variance.
    let groups = offsets.chunks(RAYS / 400);
    let mean = |group: &[f64]| group.iter().sum::<f64>() / group.len() as f64;
    groups
        .map(|group| (mean(group), group.len() as f64 / RAYS as f64))
        .collect()
}

/// Takes a photograph with an effect. Another lens, and the sheet, are those of the mid-air
/// photographs alone; the rest changes the reference too.
pub(super) fn taken(
    effect: Effect,
    params: &Params,
    index: Option<usize>,
) -> Result<Vec<f32>, Error> {
    let smear = |offsets: Vec<(f64, f64)>| {
        let light = smeared(params, index, &offsets)?;
        Ok(exposed(params, index, light))
    };
    let mut other = params.clone();
    match (effect, index) {
        (Effect::Disc(radius_px), Some(_)) => return smear(disc(radius_px)),
        (Effect::Dihedral(mrad), Some(i)) => return smear(thrown(params, i, 1e-3 * mrad)),
        (Effect::Common(errors), Some(i)) => {
            other.captures[i].shifts = Some(through_bent_cubes(params, i, errors));
            return photograph(&other, index);
        }
        _ => {}
    }
    let is_near = |i: usize| params.captures[i].floating_distance_mm <= DISTANCES_MM[0];
    let camera = &mut other.camera;
    match effect {
        Effect::Lens(sigma_px) if index.is_some() => camera.sigma_px = sigma_px,
        Effect::Focus([near, far]) if index.is_some() => {
            camera.sigma_px = if index.is_some_and(is_near) {
                near
            } else {
                far
            };
        }
        Effect::Pupil(blur_px) => camera.pupil_cutoff_per_px = Some(blur_px.recip()),
        Effect::Halo(share) => camera.halo_share = share,
        Effect::Sharpening(strength) => camera.sharpening = strength,
        _ => {}
    }
    let light = photograph(&other, index)?;
    let Effect::After(after) = effect else {
        return Ok(light);
    };
    let seen = Picture {
        size: [params.camera.width, params.camera.height],
        values: light.into_iter().map(f64::from).collect(),
    };
    let light = after.of(&seen).values.into_iter();
    Ok(light.map(|v| v as f32).collect())
}

/// One effect with the range of its sizes.
struct Drawn {
    name: &'static str,
    range: [f64; 2],
    effect: fn(f64) -> Effect,
}

/// Error of c, in standard errors, from which on a campaign is printed.
const FAR_OFF: f64 = 4.0;

/// Standard deviation of the reference's lens, pixels.
const SIGMA_PX: f64 = 0.55;

/// Distances of the drawn campaigns, mm.
const DISTANCES_MM: [f64; 2] = [150.0, 300.0];

const DRAWN: [Drawn; 15] = [
    Drawn {
        name: "nothing",
        range: [0.1, 1.0],
        effect: |_| Effect::None,
    },
    Drawn {
        name: "disc of defocus, radius in px",
        range: [0.1, 2.0],
        effect: Effect::Disc,
    },
    Drawn {
        name: "less sharp than the reference, px",
        range: [0.1, 1.0],
        effect: |px| Effect::Lens(SIGMA_PX.hypot(px)),
    },
    Drawn {
        name: "less sharp at the nearer distance alone, px",
        range: [0.1, 1.0],
        effect: |px| Effect::Focus([SIGMA_PX.hypot(px), SIGMA_PX]),
    },
    Drawn {
        name: "focused anew at each distance, and half as much at the farther, px",
        range: [0.1, 1.0],
        effect: |px| Effect::Focus([SIGMA_PX.hypot(px), SIGMA_PX.hypot(0.5 * px)]),
    },
    Drawn {
        name: "sharper than the reference, px",
        range: [0.1, 0.53],
        effect: |px| Effect::Lens((SIGMA_PX.powi(2) - px * px).sqrt()),
    },
    Drawn {
        name: "dihedral errors from cell to cell, mrad",
        range: [0.005, 0.5],
        effect: Effect::Dihedral,
    },
    Drawn {
        name: "equal dihedral errors of all cells, mrad",
        range: [0.005, 0.5],
        effect: |mrad| Effect::Common([mrad; 3]),
    },
    Drawn {
        name: "dihedral error of one edge of all cells, mrad",
        range: [0.005, 0.5],
        effect: |mrad| Effect::Common([0.0, mrad, 0.0]),
    },
    Drawn {
        name: "opposite dihedral errors of two edges of all cells, mrad",
        range: [0.005, 0.5],
        effect: |mrad| Effect::Common([mrad, 0.0, -mrad]),
    },
    Drawn {
        name: "round pupil, 1 / cut-off in px",
        range: [0.5, 3.0],
        effect: Effect::Pupil,
    },
    Drawn {
        name: "halo of 20 px, share",
        range: [0.001, 0.05],
        effect: Effect::Halo,
    },
    Drawn {
        name: "linear sharpening",
        range: [0.03, 1.0],
        effect: Effect::Sharpening,
    },
    Drawn {
        name: "bilateral filter of 2 px, range in light",
        range: [0.003, 0.2],
        effect: |range| Effect::After(After::Bilateral(2.0, range)),
    },
    Drawn {
        name: "JPEG of an ordinary camera, range of its filter",
        range: [0.003, 0.1],
        effect: |range| Effect::After(After::Ordinary(range)),
    },
];

/// One drawn campaign.
struct Outcome {
    /// Place of the size in its range, 0 to 1 on a logarithmic scale.
    place: f64,
    verdict: Verdict,
    /// Errors of c, a and mu in standard errors; infinite if a bound is wrong.
    pulls: [Option<f64>; 3],
    /// Whether a further blur, terms of the lens or noise reduction were found.
    is_named: bool,
    /// Whether a good fit is put down to a mistake, of which there is none.
    is_blamed: bool,
    /// Whether the lens of the mid-air photographs, and the dihedral angles, are taken on trust: no
    /// photograph shows a smaller difference from those of the reference and the table.
    trusts: [bool; 2],
}

fn outcome(drawn: &Drawn, number: u64) -> Option<Outcome> {
    const INCIDENCE: [f64; 3] = [0.0, 20.0, 35.0];
    let mut stream = Stream(0xeffe << 20 | number);
    let place = stream.between(0.0, 1.0);
    let [least, most] = drawn.range;
    let effect = (drawn.effect)(least * (most / least).powf(place));
    let planted = [
        stream.between(0.2, 0.5),
        stream.between(2.0, 6.0),
        stream.between(0.3, 0.8),
    ];
    let [c, a, mu] = planted;
    let sheet = truth(Kernel::Eq1, LobeShape::Radial, a, c, mu);
    let table = table(&sheet, &INCIDENCE, 20.0);
    let electrons = 10_f64.powf(stream.between(4.0, 5.0));
    let mut params = params(number, sheet, &INCIDENCE, &DISTANCES_MM, camera(electrons));
    params.camera.source_level = 0.7;
    let source = trial::source(&params, |params, index| taken(effect, params, index));
    let given = trial::campaign(&params, &[]);
    let options = Options::new(Candidates::proposed());
    let found = undiagnosed(&given, &source, &table, &options, &Progress::SILENT);
    let mut found = match found {
        Ok(found) => found,
        Err(error) => {
            println!("   {effect:?}: {error}");
            return None;
        }
    };
    if found.goodness.verdict == Verdict::Good {
        let searched = found.diagnose(&source, &table, &options, &Progress::SILENT);
        searched.expect("nobody cancels the search");
    }
    let pulls = pulls(&found, planted);
    if pulls[0].is_some_and(|pull| pull.abs() > FAR_OFF) {
        println!(
            "   {number} {effect:?}: {:?} {pulls:.1?}",
            found.goodness.verdict
        );
    }
    Some(Outcome {
        place,
        verdict: found.goodness.verdict,
        pulls,
        is_named: is_named(&found),
        is_blamed: !found.suspects.is_empty(),
        trusts: ["lens", "dihedral_angles"]
            .map(|name| found.trusted.iter().any(|own| own.what.name() == name)),
    })
}

fn pulls(found: &Estimated, planted: [f64; 3]) -> [Option<f64>; 3] {
    let best = &found.best;
    let is_eq1 = best.choice.kernel == Kernel::Eq1;
    let bounded = |kind: ParameterKind, truth: f64| {
        let bound = found.bounds.get(&kind.shared())?;
        let holds = bound.at_most.is_none_or(|most| truth <= most)
            && bound.at_least.is_none_or(|least| least <= truth);
        Some(if holds { 0.0 } else { f64::INFINITY })
    };
    let [c, a, mu] = planted;
    let pull = |own: Value, truth: f64| (own.value - truth) / own.standard_error;
    let shared = |all: &[Value], truth: f64| {
        let pulls = all.iter().map(|own| pull(*own, truth));
        pulls.max_by(|a, b| a.abs().total_cmp(&b.abs()))
    };
    [
        best.c_mm
            .map(|own| pull(own, c))
            .or_else(|| bounded(ParameterKind::CornerSize, c)),
        shared(&best.spread, a).filter(|_| is_eq1),
        best.mu.as_ref().and_then(|all| shared(all, mu)),
    ]
}

fn is_named(found: &Estimated) -> bool {
    let best = &found.best;
    let lenses = found.scene.optics.camera.lenses.iter();
    let terms = lenses
        .filter_map(|lens| lens.departure.as_ref())
        .any(|own| !own.terms.is_empty());
    let said = ["hint at", "sharpened", "noise reduction"];
    let shots = found.scene.shots.iter().flat_map(|shot| &shot.warnings);
    let mut warnings = found
        .warnings
        .iter()
        .chain(&found.scene.warnings)
        .chain(shots);
    best.choice.further.has_own_blur()
        || best.angular_spread_mrad.is_some()
        || best.dihedral_errors_mrad.is_some()
        || terms
        || found
            .scene
            .shots
            .iter()
            .any(|shot| shot.reduced_noise.is_some())
        || warnings.any(|own| said.iter().any(|word| own.contains(word)))
}

/// Verdicts, and coverage of the stated 95 % intervals of c, a and mu (the largest error, the mean and
/// the root mean square, in standard errors), by thirds of the range of each effect. `DRAWS` and
/// `EFFECT` of the environment set the number of campaigns and a part of a name: so the figures of
/// BENCHMARKS.md are made.
///
/// Where the verdict is not `poor`, at least nine in ten intervals hold, but for campaigns whose lens or
/// dihedral angles are others and are taken on trust. The three intervals of a campaign are not
/// independent: three standard deviations of a third of their number are allowed.
#[test]
#[ignore = "minutes: `make test-full` runs it"]
fn stated_intervals_hold_beside_effects_of_laboratories() {
    let of = |name: &str| std::env::var(name).ok();
    let draws = of("DRAWS").and_then(|n| n.parse().ok()).unwrap_or(3);
    let only = of("EFFECT").unwrap_or_default();
    let (mut held, mut stated) = (0, 0);
    for drawn in DRAWN.iter().filter(|own| own.name.contains(&only)) {
        let all: Vec<Outcome> = (0..draws)
            .into_par_iter()
            .filter_map(|number| outcome(drawn, number))
            .collect();
        println!("{}: {} campaigns", drawn.name, all.len());
        let trusted = match (drawn.effect)(drawn.range[0]) {
            Effect::Disc(_) | Effect::Lens(_) | Effect::Focus(_) => Some(0),
            Effect::Common(_) => Some(1),
            _ => None,
        };
        for third in 0..3 {
            let rows = all.iter().filter(|own| (3.0 * own.place) as usize == third);
            let (hidden, rows): (Vec<&Outcome>, Vec<&Outcome>) = rows.partition(|own| {
                let is_poor = own.verdict == Verdict::Poor;
                !is_poor && trusted.is_some_and(|k| own.trusts[k])
            });
            let size = |part: f64| drawn.range[0] * (drawn.range[1] / drawn.range[0]).powf(part);
            let from = third as f64 / 3.0;
            print!(
                "  {:.3} to {:.3}: {} named, {} blamed, {} on trust (largest error of c {:.1}) ",
                size(from),
                size(from + 1.0 / 3.0),
                rows.iter().filter(|own| own.is_named).count(),
                rows.iter().filter(|own| own.is_blamed).count(),
                hidden.len(),
                largest(&hidden, 0)
            );
            for verdict in [Verdict::Good, Verdict::Strained, Verdict::Poor] {
                let own = rows.iter().filter(|own| own.verdict == verdict);
                let own: Vec<&Outcome> = own.copied().collect();
                print!("| {verdict:?} {}:", own.len());
                for k in 0..3 {
                    let pulls: Vec<f64> = own.iter().filter_map(|own| own.pulls[k]).collect();
                    let inside = pulls.iter().filter(|pull| pull.abs() < 1.96).count();
                    let mean = |power: i32| {
                        let sum: f64 = pulls.iter().map(|pull| pull.powi(power)).sum();
                        sum / pulls.len() as f64
                    };
                    let (mean, rms) = (mean(1), mean(2).sqrt());
                    let most = largest(&own, k);
                    print!(
                        " {inside}/{} ({most:.1}, {mean:+.2}, {rms:.2})",
                        pulls.len()
                    );
                    if verdict != Verdict::Poor {
                        held += inside;
                        stated += pulls.len();
                    }
                }
                print!(" ");
            }
            println!();
        }
    }
    let share = held as f64 / stated as f64;
    println!("{held} of {stated} intervals hold");
    let least = 0.9 - 3.0 * (0.9 * 0.1 / (stated as f64 / 3.0)).sqrt();
    // Of a single effect, all fits may be poor.
    assert!(stated > 0 || !only.is_empty());
    assert!(stated == 0 || share >= least, "{share} {least}");
}

/// Returns the largest error of a parameter, standard errors.
fn largest(all: &[&Outcome], parameter: usize) -> f64 {
    let pulls = all.iter().filter_map(|own| own.pulls[parameter]);
    pulls.map(f64::abs).fold(0.0, f64::max)
}
