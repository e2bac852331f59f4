//! The wave optics of exact tables against published numbers and against a pupil on a raster.

use std::f64::consts::PI;

use crate::optics::{Backing, Rules};
use crate::tests::bakes;
use crate::tests::exact::cells::{bent_edges, ideal_edges, pair, single};
use meshes::Cell;
use num_complex::Complex64;
use tables::{Direction, Passage, Path, ShiftLine, WaveLine};

const ALUMINIUM: Complex64 = Complex64::new(0.967, 6.462);
const ONE: Complex64 = Complex64::ONE;
const ZERO: Complex64 = Complex64::ZERO;

fn tir(index: f64) -> Rules {
    Rules {
        mirror_back: false,
        ..Rules::mirrors(index)
    }
}

fn direction(cell: &Cell, rules: &Rules, incidence: f64, azimuth: f64) -> Direction {
    let exact = bakes::exact(cell).unwrap();
    let share = exact.direction(incidence, azimuth, 16, 2.0, rules);
    Direction {
        incidence_deg: incidence,
        azimuth_deg: azimuth,
        retroreflected: share.retroreflected,
        probability: ndarray::Array2::zeros((16, 16)),
        range: 2.0,
        standard_error: 0.0,
        interpolated: false,
        paths: Some(share.paths),
        exits: None,
    }
}

/// Place, distance and colour of an image, mm.
#[derive(Clone, Copy)]
struct Seen {
    c: f64,
    r: f64,
    wavelength: f64,
}

impl Seen {
    /// Returns the frequency, 1/mm, of a lag in edge lengths.
    fn frequency(&self, lag: f64) -> f64 {
        lag * self.c / (self.wavelength * self.r)
    }
}

/// Amplitudes of the pupil at one place, for two orthogonal polarisations.
type Field = [Complex64; 4];

/// OTF of one direction by a pupil on a raster, whose columns lie along the edge normal. It shares
/// the polygons and amplitudes of the paths with the crate, and none of its formulas.
struct Raster {
    seen: Seen,
    step: f64,
    side: usize,
    /// One pupil for each cube.
    cubes: Vec<Vec<Field>>,
}

impl Raster {
    fn new(direction: &Direction, normal: [f64; 2], seen: Seen, side: usize) -> Raster {
        const WIDE: f64 = 1.7;
        let step = WIDE / side as f64;
        let cosine = direction.incidence_deg.to_radians().cos();
        let paths = direction.paths.as_ref().unwrap();
        // The fixed point of the map p -> p + M p + o.
        let foot = |path: &Path| {
            let ([[a, b], [c, d]], [u, v]) = (path.matrix, path.offset);
            let det = a * d - b * c;
            [(b * v - d * u) / det, (c * u - a * v) / det]
        };
        let mut cubes: Vec<([f64; 2], Vec<&Path>)> = Vec::new();
        for path in paths {
            let at = foot(path);
            let near = |other: &[f64; 2]| (at[0] - other[0]).hypot(at[1] - other[1]) < 0.05;
            match cubes.iter_mut().find(|(other, _)| near(other)) {
                Some((_, all)) => all.push(path),
                None => cubes.push((at, vec![path])),
            }
        }
        let pupil = |(_, paths): &([f64; 2], Vec<&Path>)| {
            let feet: Vec<[f64; 2]> = paths.iter().map(|path| foot(path)).collect();
            let apex = [0, 1].map(|k| feet.iter().map(|at| at[k]).sum::<f64>() / feet.len() as f64);
            let left: Vec<Vec<[f64; 2]>> = paths
                .iter()
                .map(|path| {
                    let out = |p: &[f64; 2]| {
                        let by = path.shift(*p);
                        [p[0] + by[0] - apex[0], p[1] + by[1] - apex[1]]
                    };
                    path.polygon.iter().map(out).collect()
                })
                .collect();
            let at = |k: usize| {
                let place = |i: usize| (i as f64 + 0.5) * step - 0.5 * WIDE;
                let (along, across) = (place(k % side), place(k / side));
                let x = along * normal[0] - across * normal[1];
                let y = along * normal[1] + across * normal[0];
                let inside = |polygon: &Vec<[f64; 2]>| {
                    let sides = polygon.iter().zip(polygon.iter().cycle().skip(1));
                    sides.into_iter().all(|(p, q)| {
                        (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x / cosine - p[0]) >= 0.0
                    })
                };
                let turn = 2.0 * PI * seen.c / seen.wavelength;
                let mut sum = Field::default();
                for (which, _) in left.iter().enumerate().filter(|(_, own)| inside(own)) {
                    let path = paths[which];
                    // The light of a path seems to turn about the path's fixed point.
                    let from = [0, 1].map(|k| feet[which][k] - apex[k]);
                    let (x, y) = (x - from[0] * cosine, y - from[1]);
                    let phase = turn * (path.deviation[0] * x + path.deviation[1] * y);
                    let jones = path
                        .jones
                        .unwrap_or([[[1.0, 0.0], [0.0; 2]], [[0.0; 2], [-1.0, 0.0]]]);
                    for (sum, &[re, im]) in sum.iter_mut().zip(jones.as_flattened()) {
                        *sum += Complex64::new(re, im) * Complex64::cis(phase);
                    }
                }
                sum
            };
            (0..side * side).map(at).collect()
        };
        Raster {
            seen,
            step,
            side,
            cubes: cubes.iter().map(pupil).collect(),
        }
    }

    /// Returns the OTF at a lag of whole pixels.
    fn otf(&self, lag: usize) -> Complex64 {
        let (mut sum, mut power) = (Complex64::ZERO, 0.0);
        let frequency = self.seen.frequency(lag as f64 * self.step);
        let middle = 0.5 * (self.side as f64 - 1.0);
        for pupil in &self.cubes {
            for row in pupil.chunks_exact(self.side) {
                for (k, here) in row.iter().enumerate() {
                    power += here.iter().map(Complex64::norm_sqr).sum::<f64>();
                    let Some(there) = row.get(k + lag) else {
                        continue;
                    };
                    let pairs = here.iter().zip(there);
                    let product: Complex64 = pairs.map(|(a, b)| a * b.conj()).sum();
                    let place = (k as f64 + 0.5 * lag as f64 - middle) * self.step;
                    sum += product * Complex64::cis(-4.0 * PI * frequency * self.seen.c * place);
                }
            }
        }
        sum / power
    }
}

/// The OTF is that of the pupil on a raster.
///
/// A raster of n x n places counts an edge of length L to within sqrt(L n) of the n^2 places: with
/// a dozen edges of up to 1.4 in 1.7 of the side, 2e-5 of the pupil for n = 2000, if edges lie at
/// random; along the raster's own axes some edges lie in one row, which costs 1/n of their length,
/// 5e-4. So the normals are oblique, and 2e-4 is allowed: four deviations and an edge near 60
/// degrees.
///
/// The OTF of unpolarised light is real where the light along an order of facets is that of the same
/// order turned round. With errors d of the angles this holds to the first order: phases of
/// 2 pi c/lambda d^2 remain. Behind polarisers it is complex.
#[test]
#[ignore = "half a minute: `make test-slowest` runs it"]
fn waves_are_those_of_a_pupil_on_a_raster() {
    const SIDE: usize = 2000;
    let metal = |index| Rules {
        losses: Some(Backing::Metal(ALUMINIUM)),
        ..Rules::mirrors(index)
    };
    let bare = |index| Rules {
        losses: Some(Backing::Bare),
        ..Rules::mirrors(index)
    };
    let (ideal, two) = (single(ideal_edges()), pair(ideal_edges(), true));
    let errors = single(bent_edges([4e-4, -3e-4, 2e-4]));
    let unpolarised = [[ONE, ZERO], [ZERO, ONE]];
    let along_s = [[Complex64::from(2.0_f64.sqrt()), ZERO], [ZERO, ZERO]];
    // A quarter-wave film at 45 degrees turns light along s to circular light.
    let quarter = Complex64::cis(0.25 * PI);
    let round = [[quarter, ZERO], [quarter.conj(), ZERO]];
    let linear = Passage {
        before: along_s,
        after: unpolarised,
    };
    let circular = Passage {
        before: round,
        after: unpolarised,
    };
    let crossed = Passage {
        before: round,
        after: [[ZERO, ZERO], [ZERO, ONE]],
    };
    let cases: [(&Cell, Rules, [f64; 2], Option<Passage>); 14] = [
        (&ideal, tir(1.49), [0.0, 0.0], None),
        (&ideal, tir(1.49), [15.0, 25.0], None),
        (&two, tir(1.586), [20.0, 100.0], None),
        (&ideal, bare(1.49), [30.0, 10.0], None),
        (&two, metal(1.49), [25.0, 40.0], None),
        (&ideal, metal(1.0), [10.0, 70.0], None),
        (&ideal, Rules::mirrors(1.49), [20.0, 50.0], None),
        (&errors, Rules::mirrors(1.49), [0.0, 0.0], None),
        (&errors, tir(1.49), [10.0, 30.0], None),
        (&errors, metal(1.49), [25.0, 200.0], None),
        (&ideal, tir(1.49), [15.0, 25.0], Some(linear)),
        (&two, tir(1.586), [20.0, 100.0], Some(circular)),
        (&ideal, tir(1.586), [10.0, 70.0], Some(crossed)),
        (&errors, tir(1.49), [10.0, 30.0], Some(linear)),
    ];
    let mut compared = 0;
    for (case, (cell, rules, [incidence, azimuth], passage)) in cases.iter().enumerate() {
        let found = direction(cell, rules, *incidence, *azimuth);
        let found = passage.map_or(found.clone(), |passage| passage.seen(found));
        let normal = [0.77_f64.cos(), 0.77_f64.sin()];
        let seen = Seen {
            c: 0.15,
            r: [150.0, 1000.0][case % 2],
            wavelength: 550e-6,
        };
        let line = WaveLine::new(&found, incidence.to_radians(), normal, &[(550.0, 1.0)]);
        let line = line.expect("corner cubes");
        let raster = Raster::new(&found, normal, seen, SIDE);
        let (mut worst, mut odd) = (0.0_f64, 0.0_f64);
        for lag in [0, 40, 120, 260, 480, 700] {
            let expected = raster.otf(lag);
            let lag = lag as f64 * raster.step;
            let (value, _) = line.otf(seen.c, seen.r, seen.frequency(lag));
            worst = worst.max((expected - value).norm());
            odd = odd.max(expected.im.abs());
            compared += 1;
        }
        println!("case {case}: {worst:.1e}, imaginary part {odd:.1e}");
        assert!(worst < 2e-4, "case {case}: {worst}");
        if passage.is_some() {
            continue;
        }
        let deviation = found.paths.iter().flatten().map(|path| path.deviation);
        let most = deviation.map(|[u, v]| u.hypot(v)).fold(0.0, f64::max);
        let second = 2.0 * PI * seen.c / seen.wavelength * most * most;
        assert!(odd < 1e-14 + second, "case {case}: {odd} {second}");
    }
    assert_eq!(compared, 84);
}

/// The Strehl ratio of a solid cube of index 1.457 with total reflection in linear polarisation at
/// normal incidence is 0.264 (Murphy and Goodrow, Applied Optics 52, 117, 2013), and 0.262 by a
/// raster of 400 x 400 places, whose last digit is rounding.
///
/// The middle of the pattern is the square of the mean amplitude of the six orders.
#[test]
fn the_middle_of_a_totally_reflecting_cube_is_as_dark_as_published() {
    let found = direction(&single(ideal_edges()), &tir(1.457), 0.0, 0.0);
    let paths = found.paths.unwrap();
    assert_eq!(paths.len(), 6, "six orders of three faces");
    let whole: f64 = paths.iter().map(Path::area).sum();
    for launched in [0, 1] {
        let amplitude = |left: usize| -> Complex64 {
            let parts = paths.iter().map(|path| {
                let [re, im] = path.jones.unwrap()[left][launched];
                Complex64::new(re, im) * path.area() / whole
            });
            parts.sum()
        };
        let strehl = amplitude(0).norm_sqr() + amplitude(1).norm_sqr();
        assert!((strehl - 0.264).abs() < 2e-3, "{strehl}");
    }
}

/// The OTF of the pair of index 1.49 with total reflection equals that of an independent vector
/// calculation by a raster of 400 x 400 places, which is good to 0.002. That of a metal is scalar.
#[test]
fn vector_waves_meet_an_independent_calculation() {
    let cell = pair(ideal_edges(), true);
    let seen = Seen {
        c: 0.1,
        r: 1000.0,
        wavelength: 550e-6,
    };
    let at = |rules: &Rules, normal: [f64; 2], lag: f64| {
        let found = direction(&cell, rules, 0.0, 0.0);
        let line = WaveLine::new(&found, 0.0, normal, &[(550.0, 1.0)]).unwrap();
        line.otf(seen.c, seen.r, seen.frequency(lag)).0.re
    };
    let vector = [
        ([1.0, 0.0], [0.607, 0.294, 0.066, -0.009]),
        ([0.0, 1.0], [0.589, 0.269, 0.067, 0.059]),
    ];
    let scalar = [
        ([1.0, 0.0], [0.842, 0.694, 0.556, 0.428]),
        ([0.0, 1.0], [0.858, 0.717, 0.575, 0.434]),
    ];
    let metal = Rules {
        losses: Some(Backing::Metal(ALUMINIUM)),
        ..Rules::mirrors(1.49)
    };
    let mirror = Rules {
        losses: Some(Backing::Mirror { reflectance: 0.9 }),
        ..Rules::mirrors(1.49)
    };
    let mut cases = 0;
    for (rules, expected, allowed) in [
        (tir(1.49), vector, 3e-3),
        (Rules::mirrors(1.49), scalar, 3e-3),
        (metal, scalar, 5e-3),
    ] {
        for (normal, values) in expected {
            for (k, expected) in values.into_iter().enumerate() {
                let value = at(&rules, normal, 0.1 * (k + 1) as f64);
                assert!((value - expected).abs() < allowed, "{value} {expected}");
                cases += 1;
            }
        }
    }
    // A mirror that keeps the field takes an equal part of the light of all orders: at normal
    // incidence its waves are the scalar ones.
    for lag in [0.1, 0.3, 0.7] {
        let own = at(&mirror, [0.6, 0.8], lag);
        let ideal = at(&Rules::mirrors(1.49), [0.6, 0.8], lag);
        assert!((own - ideal).abs() < 1e-12, "{own} {ideal}");
        cases += 1;
    }
    assert_eq!(cases, 27);
}

/// A dihedral error that turns light by many times the angle of diffraction gives separate spots,
/// where geometry has them: the OTF is that of the shift with its deviations, but for interference
/// of pieces, which a wavelength four times shorter makes less.
#[test]
fn short_waves_of_a_bent_cube_are_its_rays() {
    let found = direction(
        &single(bent_edges([2e-3, -1e-3, 15e-4])),
        &Rules::mirrors(1.49),
        10.0,
        40.0,
    );
    let (c, r, normal, theta) = (0.2, 150.0, [0.8, 0.6], 10_f64.to_radians());
    let rays = ShiftLine::new(&found, theta, normal).unwrap();
    let shift = rays.otf(c, r, 0.7).0;
    let [near, far] = [4.0, 1.0].map(|nm| {
        let line = WaveLine::new(&found, theta, normal, &[(nm, 1.0)]).unwrap();
        (line.otf(c, r, 0.7).0 - shift).norm()
    });
    println!("{shift:.4}: {near:.1e}, {far:.1e}");
    assert!(far < 0.02 && far < near, "{near} {far}");
}
