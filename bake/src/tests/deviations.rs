//! Exit directions of rays, against those of the exact method and of the closed form of cubes with
//! dihedral errors.

use crate::tests::bakes;
use crate::tests::bakes::asked;
use crate::tests::cells;

use crate::plan::{Effort, Plan, Request};
use crate::rays::Tracer;
use crate::run::Comparison;
use crate::tests::bakes::{bake, rays_by};
use glam::DVec2;
use meshes::Cell;
use meshes::design::{Design, Plate, Shape};
use num_complex::Complex64;
use tables::options::{Back, Element, Losses, Method, Record, Sampler, SceneOptions};
use tables::{Fate, Path, ShiftLine, Table};

fn plan(request: &Request) -> Plan {
    Plan::new(&Request {
        rays: Some(1 << 18),
        method: Method::Rays,
        ..request.clone()
    })
    .expect("a valid request")
}

fn of(record: Record) -> SceneOptions {
    SceneOptions {
        deviations: record,
        ..SceneOptions::default()
    }
}

/// Returns every bin of deviations that has rays, of one direction of a table of rays: its
/// deviation, its rays and their mean shift.
fn spots(table: &Table, direction: usize) -> Vec<(DVec2, u64, DVec2)> {
    let found = table.deviations.as_ref().expect("recorded");
    let axes = &table.axes;
    assert_eq!(found.grid.cells, axes.bins, "cells are the bins themselves");
    let mut spots: Vec<([usize; 2], u64, DVec2)> = Vec::new();
    for entry in &found.entries[direction] {
        let ([v, u], bin) = found.grid.at(entry.place);
        let shift = DVec2::new(axes.bin_centre(u), axes.bin_centre(v)) * entry.rays as f64;
        match spots.iter_mut().find(|spot| spot.0 == bin) {
            Some(spot) => (spot.1, spot.2) = (spot.1 + entry.rays, spot.2 + shift),
            None => spots.push((bin, entry.rays, shift)),
        }
    }
    let spot = |(bin, rays, shift): ([usize; 2], u64, DVec2)| {
        let deviation = DVec2::from_array(found.grid.deviation(bin));
        (deviation, rays, shift / rays as f64)
    };
    spots.into_iter().map(spot).collect()
}

fn centroid(polygon: &[[f64; 2]]) -> (f64, DVec2) {
    let (mut area, mut moment) = (0.0, DVec2::ZERO);
    let corner = |k: usize| DVec2::from_array(polygon[k % polygon.len()]);
    for k in 0..polygon.len() {
        let (a, b) = (corner(k), corner(k + 1));
        area += 0.5 * a.perp_dot(b);
        moment += (a + b) * a.perp_dot(b) / 6.0;
    }
    (area, moment / area)
}

/// Compares tables of cubes without errors, bent, with tables of cubes that have the errors: OTFs along
/// two lines, in directions of the table, in images by symmetry, and between them.
///
/// Both leave a different error. The errors e of up to 5e-5 change shifts by up to 4 e edge lengths, and
/// the bent table misses that: 2 pi f c 4 e, with c = 0.3 and f = 2, is 7.5e-4. The second order of the
/// deviation, 6 e^2 at R = 400, is 2 pi f R 6 e^2 = 7.5e-5. Interpolated samples add 3.2e-5.
#[test]
fn bent_tables_are_those_of_cubes_with_errors() {
    let (mut cases, mut worst, mut effect) = (0, 0.0_f64, 0.0_f64);
    let cell = |shape, errors| {
        let design = Design {
            dihedral_error_rad: errors,
            ..Design::new(shape)
        };
        let mesh = design.mesh().expect("a design");
        meshes::normalise(&mesh, "a.obj".as_ref(), &meshes::CellOptions::default()).expect("a cell")
    };
    for (shape, losses) in [
        (Shape::Triangular, Losses::None),
        (Shape::TriangularPair, Losses::None),
        (Shape::TriangularPair, Losses::Fresnel),
        (Shape::FullCube, Losses::None),
        (Shape::Canted, Losses::None),
    ] {
        for (index, errors) in [
            (1.49, [5e-5, 0.0, 0.0]),
            (1.49, [0.0, 5e-5, 0.0]),
            (1.0, [-2e-5, 4e-5, 5e-5]),
        ] {
            if losses == Losses::Fresnel && index == 1.0 {
                continue;
            }
            let request = Request {
                refractive_index: Some(index),
                losses,
                ..asked("--incidence 0,10,20,30 --azimuth 0,15,30,45")
            };
            let plan = Plan::new(&request).expect("a valid request");
            let [ideal, bent] =
                [[0.0; 3], errors].map(|errors| bake(&cell(shape, errors), &plan).expect("bakes"));
            for (incidence_deg, azimuth_deg) in
                [(0.0, 0.0), (20.0, 15.0), (30.0, 45.0), (14.0, 37.0)]
            {
                let [ideal, bent] = [&ideal, &bent].map(|table| {
                    let found = table.direction(incidence_deg, Some(azimuth_deg));
                    found.expect("a direction of the table")
                });
                let theta = f64::to_radians(incidence_deg);
                for normal in [[1.0, 0.0], [0.6, 0.8]] {
                    let plain = ShiftLine::new(&ideal, theta, normal).expect("light");
                    let truth = ShiftLine::new(&bent, theta, normal).expect("light");
                    let line = ShiftLine::with_errors(&ideal, theta, normal, index).expect("cubes");
                    for f in [0.4, 1.0, 2.0] {
                        let truth = truth.otf(0.3, 400.0, f).0;
                        let found = line.otf_with_errors([0.3, 400.0], errors, f)[0];
                        let off = (found - truth).norm();
                        worst = worst.max(off);
                        effect = effect.max((plain.otf(0.3, 400.0, f).0 - truth).norm());
                        cases += 1;
                    }
                }
            }
        }
    }
    println!("{cases} values within {worst:.1e} of {effect:.1e}");
    assert!(worst < 8.6e-4, "{worst:e}");
    assert!(effect > 0.1, "{effect}");
}

/// Every spot that beams find gets its share of the rays, with the mean shift of its own polygons.
/// No ray goes elsewhere.
#[test]
fn rays_go_where_beams_go() {
    let cell = cells::uneven_pair([5e-4, 0.0, -3e-4]);
    let (mut compared, mut furthest) = (0, 0.0_f64);
    for index in [1.0, 1.49] {
        let request = Request {
            refractive_index: Some(index),
            ..asked("--incidence 0,20,40 --azimuth 10,70")
        };
        let by_rays = bake(&cell, &plan(&request)).expect("bakes");
        let exact = Plan::new(&request).expect("a valid request");
        let exact = bake(&cell, &exact).expect("bakes");
        let polygons = exact.exact.as_ref().expect("polygons");
        let grid = by_rays.deviations.as_ref().expect("recorded").grid;
        for (direction, paths) in polygons.paths.iter().enumerate() {
            let launched = by_rays.rays[[direction / 2, direction % 2]] as f64;
            let mut left: u64 = by_rays.deviations.as_ref().unwrap().entries[direction]
                .iter()
                .map(|entry| entry.rays)
                .sum();
            // The spots of the two cubes differ in second order, 2.5e-7 rad. Spots less than a bin
            // apart count as one.
            let near = |a: DVec2, b: DVec2| (a - b).abs().max_element() < 4.0 * grid.bin_width();
            let mut seen: Vec<DVec2> = Vec::new();
            for path in paths {
                let at = DVec2::from_array(path.deviation);
                if seen.iter().any(|&other| near(at, other)) {
                    continue;
                }
                seen.push(at);
                let own: Vec<_> = paths
                    .iter()
                    .filter(|same| near(at, same.deviation.into()))
                    .collect();
                let (mut power, mut shift) = (0.0, DVec2::ZERO);
                for path in &own {
                    let (area, middle) = centroid(&path.polygon);
                    let part = path.weight * area / polygons.entrance_area;
                    power += part;
                    shift += part * DVec2::from_array(path.shift(middle.into()));
                }
                let (mut rays, mut mean) = (0, DVec2::ZERO);
                for (deviation, n, middle) in spots(&by_rays, direction) {
                    // A ray is in the bin of one of them, or next to it by rounding.
                    let goes = |path: &&Path| {
                        let apart = deviation - DVec2::from_array(path.deviation);
                        apart.abs().max_element() < 0.501 * grid.bin_width()
                    };
                    if own.iter().copied().any(|path| goes(&path)) {
                        (rays, mean) = (rays + n, mean + middle * n as f64);
                    }
                }
                left -= rays;
                // The tolerance is five standard deviations of independent rays, and one ray at
                // least. Sobol rays stay below it.
                let sigma = (power * (1.0 - power) / launched)
                    .sqrt()
                    .max(1.0 / launched);
                let share = rays as f64 / launched;
                assert!((share - power).abs() < 5.0 * sigma, "{share} for {power}");
                if rays > 1000 {
                    // Shifts are known to half a bin and spread by less than 1.
                    let apart = (mean / rays as f64 - shift / power).length();
                    let allowed = by_rays.axes.bin_width() + 5.0 / (rays as f64).sqrt();
                    assert!(apart < allowed, "{apart} of {allowed}");
                    furthest = furthest.max(apart);
                }
                compared += 1;
            }
            assert_eq!(left, 0, "rays that no beam explains");
        }
    }
    println!("{compared} spots, their mean shifts within {furthest:.4}");
    assert!(compared > 60, "{compared}");
}

/// Three equal errors send light into six spots at 4 sqrt(2/3) eps (1 - eps/2), and one error into
/// two spots at 1.633 eps, both times the index, as in the model.
#[test]
fn spots_of_equal_errors() {
    let eps = 1e-3;
    let root = (2.0_f64 / 3.0).sqrt();
    let mut compared = 0;
    for (errors, index, radius, count) in [
        ([eps; 3], 1.0, 4.0 * root * eps * (1.0 - eps / 2.0), 6),
        // Outside a prism the first order is known. The second order is below eps^2 times the
        // index.
        ([eps; 3], 1.49, 1.49 * 4.0 * root * eps, 6),
        ([eps, 0.0, 0.0], 1.0, 2.0 * root * eps, 2),
    ] {
        let request = Request {
            incidence: "0".into(),
            refractive_index: Some(index),
            scene: of(Record::Within(1.02e3 * radius)),
            ..Request::default()
        };
        let table = bake(&cells::uneven_pair(errors), &plan(&request)).expect("bakes");
        let grid = table.deviations.as_ref().expect("recorded").grid;
        let spots = spots(&table, 0);
        let returned: u64 = spots.iter().map(|spot| spot.1).sum();
        let mut left = spots.clone();
        while let Some((at, ..)) = left.first().copied() {
            // The spots of the two cubes differ in second order.
            let same = |spot: &(DVec2, u64, DVec2)| (spot.0 - at).length() < 10.0 * eps * eps;
            let own: Vec<_> = left.extract_if(.., |spot| same(spot)).collect();
            // The tolerance is half the diagonal of a bin, and the first order if nothing better is
            // known.
            let bin = grid.bin_width() / 2_f64.sqrt();
            let known = index == 1.0 && errors == [eps; 3];
            let order = if known { 0.0 } else { 4.0 * index * eps * eps };
            for (deviation, ..) in &own {
                let apart = (deviation.length() - radius).abs();
                assert!(apart < bin + order, "{deviation} {radius}");
            }
            let rays: u64 = own.iter().map(|spot| spot.1).sum();
            let (share, expected) = (rays as f64 / returned as f64, 1.0 / count as f64);
            let sigma = (expected * (1.0 - expected) / returned as f64).sqrt();
            assert!((share - expected).abs() < 5.0 * sigma, "{share}");
            compared += 1;
        }
    }
    assert_eq!(compared, 14);
}

/// Returns a pair whose facets are cut fine and bent, so that rays go down the hierarchy.
fn bent() -> Cell {
    let mut cell = cells::pair();
    for _ in 0..4 {
        cell.facets = cell
            .facets
            .iter()
            .flat_map(|&[a, b, c]| {
                let [d, e, f] = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
                [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
            })
            .collect();
    }
    for corner in cell.facets.iter_mut().flatten() {
        let depth = cell.entrance.height - corner.z;
        corner.z -= 2e-3 * depth * (3.0 * corner.x).sin();
    }
    cell
}

#[test]
fn swarms_record_what_single_rays_do() {
    let request = Request {
        incidence: "0,25".into(),
        ..Request::default()
    };
    let (cell, plan) = (bent(), plan(&request));
    let [fast, slow] = [Tracer::Fastest, Tracer::OneByOne]
        .map(|tracer| rays_by(tracer, &cell, &plan).expect("bakes"));
    let grid = fast.deviations.as_ref().expect("recorded").grid;
    assert_eq!((grid.cells, grid.bins), (16, 127));
    let spread = fast.deviations.as_ref().unwrap().spread(0);
    println!(
        "{} entries, {spread:?}",
        fast.deviations.as_ref().unwrap().entries[0].len()
    );
    assert!(spread.rms_rad > 1e-3 && spread.outermost == 0.0);
    assert!(fast == slow);
}

/// Programs record shift, fate and exit direction of every ray as the tracer of one ray does: pairs
/// and periodic full cubes with errors, hollow and solid, and ideal ones with the record asked for,
/// without losses and with losses of each kind.
#[test]
#[ignore = "half a minute: `make test-slowest` runs it"]
fn programs_record_what_single_rays_do() {
    let lossless = Request::default();
    let bare = Request {
        losses: Losses::Fresnel,
        back: Back::Tir,
        ..lossless.clone()
    };
    let coated = Request {
        losses: Losses::Fresnel,
        reflectance: Some(0.8),
        ..lossless.clone()
    };
    let metal = Request {
        losses: Losses::Fresnel,
        metal: Some(Complex64::new(1.2, 7.3)),
        ..lossless.clone()
    };
    let errors = [
        ([4e-4, 0.0, -2e-4], 1.0),
        ([0.0, 4e-4, 0.0], 1.49),
        ([1e-3, -2e-3, 3e-3], 1.586),
        ([0.0; 3], 1.49),
    ];
    let shapes = [Shape::TriangularPair, Shape::FullCube];
    let scenes = shapes
        .iter()
        .flat_map(|&shape| errors.map(|errors| (shape, errors)));
    let (mut cases, mut recorded) = (0, 0);
    for (shape, (errors, index)) in scenes {
        let cell = cells::designed(&Design {
            dihedral_error_rad: errors,
            ..Design::new(shape)
        });
        let surfaces = [&lossless, &bare, &coated, &metal];
        let samplers = [Sampler::Sobol, Sampler::Random];
        let all = surfaces
            .iter()
            .flat_map(|&s| samplers.map(|sampler| (s, sampler)));
        for (surface, sampler) in all {
            let request = Request {
                incidence: "0,20,41.5,60".into(),
                azimuth: "17,90".into(),
                bins: 64,
                refractive_index: Some(index),
                sampler,
                scene: of(Record::Within(4.0)),
                ..surface.clone()
            };
            let plan = Plan {
                effort: Effort::Rays(40_000),
                ..plan(&request)
            };
            let [fast, slow] = [Tracer::Fastest, Tracer::OneByOne]
                .map(|tracer| rays_by(tracer, &cell, &plan).expect("bakes"));
            let entries = |table: &Table| -> usize {
                let found = table.deviations.as_ref().expect("recorded");
                found.entries.iter().map(Vec::len).sum()
            };
            recorded += entries(&fast);
            assert!(fast == slow, "{shape:?} {errors:?} {surface:?} {sampler:?}");
            cases += 1;
        }
    }
    println!("{recorded} places");
    assert!(cases == 64 && recorded > 10_000);
}

/// Shards add up to the bake that was never split.
#[test]
fn shards_add_up() {
    let cell = cells::uneven_pair([0.0, 4e-4, 0.0]);
    let request = asked("--incidence 0,30 --bins 32");
    let whole = bake(&cell, &plan(&request)).expect("bakes");
    let shards = ["3/3", "1/3", "2/3"].map(|shard| {
        let request = Request {
            shard: Some(shard.into()),
            ..request.clone()
        };
        bake(&cell, &plan(&request)).expect("bakes")
    });
    let merged = tables::merge(&shards).expect("merges");
    assert!(merged == whole);
    let entries = &merged.deviations.as_ref().expect("recorded").entries;
    assert!(entries.iter().all(|entries| entries.len() > 100));
}

/// Rough facets send light everywhere. The mean square of the deviation is that of three
/// reflections at random slopes.
#[test]
fn rough_facets_spread_light() {
    let roughness = "0.0005".parse().expect("a roughness");
    let request = Request {
        incidence: "0".into(),
        scene: SceneOptions {
            roughness: Some(roughness),
            deviations: Record::Within(6.0),
            ..SceneOptions::default()
        },
        ..Request::default()
    };
    let table = bake(&cells::pair(), &plan(&request)).expect("bakes");
    let found = table.deviations.as_ref().expect("recorded");
    let spread = found.spread(0);
    println!("{spread:?}, {} entries", found.entries[0].len());
    // A facet whose normal is off by the slope s, across and along the plane of reflection, turns
    // light by 2 s along and by 2 s cos across that plane, with cos = 1/sqrt 3. There are three
    // facets, with slopes of mean square alpha^2 / 2 each.
    let rms = (3.0_f64 * 4.0 * 0.5 * (1.0 + 1.0 / 3.0)).sqrt() * 5e-4;
    // Counting adds an error of 1/sqrt(2 n) for n = 3 components. Bins add w^2/12 twice, 1e-3 of
    // the square. Slopes seen from aside, and light that leaves the path at rims of facets, change
    // squares by parts of alpha.
    assert!(
        (spread.rms_rad / rms - 1.0).abs() < 5e-3,
        "{spread:?} {rms}"
    );
}

#[test]
fn ideal_cells_record_nothing() {
    let mut rounded = cells::pair();
    for corner in rounded.facets.iter_mut().flatten() {
        *corner = (*corner * 1e6).round() / 1e6;
    }
    let design = |edge_radius, segments| {
        cells::designed(&Design {
            edge_radius,
            segments,
            ..Design::new(Shape::TriangularPair)
        })
    };
    // Rounded edges send light far away or not at all. Rounding of coordinates to single precision
    // is no error of an angle.
    let worn = design(0.03, 1);
    let mut single = design(0.0, 20);
    for corner in single.facets.iter_mut().flatten() {
        *corner = corner.as_vec3().as_dvec3();
    }
    let ideal = [
        cells::triangular(),
        cells::pair(),
        cells::full_cube(),
        rounded,
        worn,
        single,
    ];
    let uneven = cells::uneven_pair([1e-4, 0.0, 0.0]);
    let grid = |cell: &Cell, record| {
        let request = Request {
            scene: of(record),
            ..Request::default()
        };
        plan(&request).deviations(&bakes::prepared(cell))
    };
    for cell in &ideal {
        assert_eq!(grid(cell, Record::Auto), None, "{}", cell.design);
    }
    assert_eq!(grid(&uneven, Record::Off), None);
    let auto = grid(&uneven, Record::Auto).expect("recorded");
    let asked = grid(&ideal[0], Record::Within(2.0)).expect("asked for");
    // The range is 2 sqrt 3 times the error, doubled for steep incidence.
    assert!(
        (auto.range - 4.0 * 3_f64.sqrt() * 1e-4).abs() < 1e-9,
        "{auto:?}"
    );
    assert_eq!((asked.range, asked.cells), (2e-3, 128));
}

/// An exact mean over azimuths would not store where the light goes. So rays are traced, or
/// `--method exact` is refused with this reason.
#[test]
fn means_of_cells_that_are_not_ideal_are_of_rays() {
    let mean = |method, record, cell: &Cell| {
        let request = Request {
            method,
            scene: of(record),
            ..asked("--incidence 0,20 --azimuth mean --rays 4096")
        };
        bake(cell, &Plan::new(&request).expect("a valid request"))
    };
    let (wide, ideal) = (cells::uneven_pair([1e-4, 0.0, 0.0]), cells::pair());
    let auto = mean(Method::Auto, Record::Auto, &wide).expect("rays");
    assert_eq!(auto.provenance.method.text(), "rays");
    let found = auto.deviations.as_ref().expect("recorded");
    assert!(found.entries.iter().all(|entries| !entries.is_empty()));
    let refused = mean(Method::Exact, Record::Auto, &wide).expect_err("it has no directions");
    assert!(
        refused.to_string().contains("--deviations off"),
        "{refused}"
    );
    for (record, cell) in [(Record::Off, &wide), (Record::Auto, &ideal)] {
        let exact = mean(Method::Auto, record, cell).expect("a mean");
        assert_eq!(exact.provenance.method.text(), "exact");
    }
}

/// A plate with leaning mirrors makes its image beside the right place, although its mirrors meet
/// at right angles.
#[test]
fn leaning_mirrors_of_a_plate_are_recorded() {
    let plate = Plate {
        pitch: 0.5,
        depth: 3.0,
        thickness: 0.05,
    };
    let mesh = plate.mesh().expect("a design");
    let mut cell = cells::of_mesh(&mesh, |_| ());
    let request = |method| Request {
        incidence: "30".into(),
        azimuth: "45".into(),
        method,
        rays: Some(1 << 14),
        scene: SceneOptions {
            element: Element::Plate,
            ..SceneOptions::default()
        },
        ..Request::default()
    };
    let grid = |cell: &Cell| {
        let plan = Plan::new(&request(Method::Rays)).expect("a valid request");
        plan.deviations(&bakes::prepared(cell))
    };
    assert_eq!(grid(&cell), None, "upright mirrors");
    for corner in cell.facets.iter_mut().flatten() {
        corner.x += 2e-3 * corner.z;
    }
    // Without the flat facets, no two planes are off a right angle.
    cell.facets
        .retain(|[a, b, c]| (b - a).cross(c - a).normalize().z.abs() < 0.5);
    assert!(grid(&cell).is_some(), "leaning ones");
    let bake = |method| {
        let plan = Plan::new(&request(method)).expect("a valid request");
        bake(&cell, &plan).expect("bakes")
    };
    let exact = bake(Method::Exact);
    let beams = exact.exact.as_ref().expect("beams").largest_deviation_rad();
    let rays = bake(Method::Rays);
    let found = rays.deviations.as_ref().expect("recorded");
    let spread = found.spread(0);
    println!("beams {beams:e}, {spread:?}");
    // The middle of a bin is at most half its diagonal away.
    assert!((spread.largest_rad - beams).abs() < 0.71 * found.grid.bin_width());
    assert!(beams > 2e-3);
}

/// Light within the tolerance of straight back, by a map that is not, is that whose deviation in
/// the air is. With the widest tolerance all three reflections are paths with their deviations, so
/// their areas say how much light that is. Every tracer agrees. In dihedral errors of some mrad
/// behind index 1.586 the angle inside would be half as large as that in the air.
#[test]
fn light_is_straight_in_the_air() {
    let (mut cases, mut most) = (0, 0.0_f64);
    for errors in [[3e-3, 3e-3, 3e-3], [4e-3, -2e-3, 3e-3], [2e-3, 5e-3, -4e-3]] {
        let cell = cells::uneven_pair(errors);
        let request = Request {
            refractive_index: Some(1.586),
            ..asked("--incidence 0,25,40 --azimuth 10,50 --bins 16")
        };
        let narrow = plan(&request);
        let wide = plan(&Request {
            angular_tolerance_deg: 10.0,
            ..request.clone()
        });
        let exactly = |plan: &Plan| {
            let plan = Plan {
                method: Method::Exact,
                ..plan.clone()
            };
            bake(&cell, &plan).expect("bakes")
        };
        let tables = [exactly(&wide), exactly(&narrow)];
        let tolerance = request.angular_tolerance_deg.to_radians().tan();
        for direction in 0..6 {
            let straight = tables.each_ref().map(|table| {
                let exact = table.exact.as_ref().expect("polygons");
                let near = |path: &&Path| DVec2::from(path.deviation).length() <= tolerance;
                let paths = exact.paths[direction].iter().filter(near);
                paths.map(Path::area).sum::<f64>() / exact.entrance_area
            });
            let [wide, within] = straight;
            let fate = Fate::AntiparallelOther as usize;
            let found = tables[1].fate[[direction / 2, direction % 2, fate]];
            assert!(
                (found - (wide - within)).abs() < 1e-12,
                "{errors:?} {direction}: {found}"
            );
            most = most.max(found);
            cases += 1;
        }
        for tracer in [Tracer::Fastest, Tracer::OneByOne] {
            let rays = rays_by(tracer, &cell, &narrow).expect("bakes");
            let judged = Comparison::new(&tables[1], &rays).expect("the same axes");
            assert!(judged.agrees(), "{errors:?} {tracer:?}");
        }
    }
    println!("{cases} directions, up to {most:.3} straight by another map");
    assert!(cases == 18 && most > 0.01);
}
