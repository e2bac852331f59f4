//! Data sheets: maps against the closed form, spots and bent corners against designs with errors,
//! MTF50 against the transform of the shift, random cells against their distribution.

use crate::datasheet::{Datasheet, DatasheetRequest, EtaMap, Surface, datasheet, page, report};
use crate::error::Error;
use crate::optics::{Incidence, Rules, metal};
use crate::run::Progress;
use crate::tests::bakes;
use crate::tests::cells::{self, closed_form, designed, full_cube, pair, triangular};
use meshes::Cell;
use meshes::design::{Design, Shape};
use tables::Symmetry;

/// Returns coarse conditions: a hollow cell, few cells.
fn request(refractive_index: f64) -> DatasheetRequest {
    DatasheetRequest {
        refractive_index: Some(refractive_index),
        metal: "aluminium".into(),
        metal_index: metal("aluminium", Some(550.0)).expect("a known metal"),
        wavelength_nm: 550.0,
        step_deg: 5.0,
        up_to_deg: 70.0,
        incidence_deg: vec![0.0, 20.0],
        azimuth_deg: 0.0,
        distance_mm: 300.0,
        error_mrad: 0.5,
        cells: 4,
        seed: 1,
        angular_tolerance_deg: 0.5,
    }
}

fn made(cell: &Cell, request: &DatasheetRequest) -> Datasheet {
    let prepared = bakes::prepared(cell);
    datasheet(&prepared, None, request, Progress::none()).expect("a data sheet")
}

/// Returns eta of one ideal cube, or of the pair, by the closed form.
fn expected(incidence_deg: f64, azimuth_deg: f64, index: f64, is_pair: bool) -> f64 {
    let inside = (incidence_deg.to_radians().sin() / index).asin();
    let light = Incidence::new(inside, azimuth_deg.to_radians(), 1.0);
    let of = |turn: f64| closed_form(light.travel, turn).0;
    match is_pair {
        true => 0.5 * (of(0.0) + of(180.0)),
        false => of(0.0),
    }
}

/// Every direction of the maps, and every angle of half eta, agree with the closed form. The closed
/// form is bisected here on its own, to 1e-9 degrees; eta rounds to 1e-12 and falls by 0.003 a
/// degree or more, so angles agree to 1e-8.
#[test]
fn maps_and_half_angles_are_those_of_the_closed_form() {
    let (mut directions, mut halves) = (0, 0);
    let cases = [
        (triangular(), 1.0, false),
        (pair(), 1.0, true),
        (pair(), 1.49, true),
    ];
    for (cell, index, is_pair) in cases {
        let sheet = made(&cell, &request(index));
        assert_eq!(sheet.surfaces.len(), if index > 1.0 { 3 } else { 2 });
        let map = &sheet.surfaces[0].map;
        let eta = |incidence, azimuth| expected(incidence, azimuth, index, is_pair);
        assert!((map.eta[[0, 0]] - 2.0 / 3.0).abs() < 1e-12);
        for (a, &azimuth) in map.azimuth_deg.iter().enumerate() {
            for (i, &incidence) in map.incidence_deg.iter().enumerate() {
                let off = map.eta[[i, a]] - eta(incidence, azimuth);
                assert!(
                    off.abs() < 1e-12,
                    "{index}, {incidence}, {azimuth}: {off:e}"
                );
                directions += 1;
            }
            let [mut low, mut high] = [0.0, 70.0];
            while high - low > 1e-9 {
                let middle = 0.5 * (low + high);
                match eta(middle, azimuth) < 1.0 / 3.0 {
                    true => high = middle,
                    false => low = middle,
                }
            }
            let found = map.half_deg[a].expect("eta falls to nothing");
            assert!(
                (found - low).abs() < 1e-7,
                "{index}, {azimuth}: {found} {low}"
            );
            halves += 1;
        }
        let [least, most] = map
            .half_range_deg()
            .map(|deg| deg.expect("eta falls everywhere"));
        assert!(least <= most && map.half_deg.contains(&Some(least)));
    }
    assert_eq!((directions, halves), (3 * 15 * 72, 3 * 72));
}

/// Full cubes return everything at normal incidence. Metal loses more than ideal mirrors, and total
/// reflection loses twice the reflection of the front face, ((m - 1)/(m + 1))^2 = 0.0387 there,
/// while it is total: 35.3 degrees between light and facets' normals are less than the critical
/// angle's complement.
#[test]
fn surfaces_lose_what_they_should() {
    let sheet = made(&full_cube(), &request(1.49));
    let of = |surface: Surface| {
        let own = sheet.surfaces.iter().find(|own| own.surface == surface);
        own.expect("a solid has all").map.eta[[0, 0]]
    };
    assert!((of(Surface::Mirrors) - 1.0).abs() < 1e-12);
    let front = 1.0 - (0.49_f64 / 2.49).powi(2);
    let total = of(Surface::TotalReflection);
    // The light crosses the front face twice.
    assert!((total - front * front).abs() < 1e-9, "{total}");
    let metal = of(Surface::Metal);
    assert!(metal < total && metal > 0.5, "{metal}");
}

/// The cant that is best for 40 degrees, azimuth 0, index 1.49: 7.9 degrees with eta 0.387, against
/// 0.374 of the upright pair. Neighbouring cants are no better.
#[test]
fn the_best_cant_has_its_known_eta() {
    let eta = |cant_deg: f64| {
        let cell = designed(&Design {
            cant_rad: cant_deg.to_radians(),
            ..Design::new(Shape::Canted)
        });
        let at_40 = DatasheetRequest {
            step_deg: 10.0,
            up_to_deg: 40.0,
            ..request(1.49)
        };
        made(&cell, &at_40).surfaces[0].map.eta[[4, 0]]
    };
    let [less, best, more] = [6.9, 7.9, 8.9].map(eta);
    // The figure is rounded to three digits.
    assert!((best - 0.387).abs() < 5e-4, "{best}");
    assert!(less < best && more < best, "{less} {best} {more}");
}

/// A map that one sector stands for equals the map of all azimuths, to rounding.
#[test]
fn a_sector_stands_for_all_azimuths() {
    let mut cases = 0;
    let canted = designed(&Design::new(Shape::Canted));
    for (cell, rotations) in [(pair(), 6), (full_cube(), 3), (canted, 2)] {
        let prepared = bakes::prepared(&cell);
        let exact = prepared.exact().expect("planar");
        assert_eq!(prepared.symmetry().rotations, rotations);
        let rules = Surface::TotalReflection.rules(1.49, metal("0.96,6.7", None).unwrap(), 0.01);
        let map = |symmetry| EtaMap::new(exact, &rules, symmetry, [7.5, 60.0], &|_| ());
        let (folded, whole) = (map(prepared.symmetry()), map(Symmetry::NONE));
        for (a, b) in folded.eta.iter().zip(&whole.eta) {
            assert!((a - b).abs() < 1e-10, "{rotations}: {a} {b}");
            cases += 1;
        }
    }
    assert_eq!(cases, 3 * 9 * 48);
}

/// Spots of a cell that is bent are those of the design with the same errors: six at
/// 4 sqrt(2/3) e (1 - e/2), as in the tests of the exact method, with a sixth of the light each.
#[test]
fn spots_are_those_of_designs_with_errors() {
    let mut cases = 0;
    for index in [1.0, 1.49] {
        for (cell, cubes) in [(triangular(), 1), (pair(), 2), (full_cube(), 1)] {
            let asked = DatasheetRequest {
                step_deg: 15.0,
                ..request(index)
            };
            let sheet = made(&cell, &asked);
            assert_eq!(sheet.spots.len(), 6);
            for own in sheet.spots.iter().filter(|own| own.incidence_deg == 0.0) {
                let error = 1e-3 * own.error_mrad;
                let inside = 4.0 * (2.0_f64 / 3.0).sqrt() * error * (1.0 - error / 2.0);
                let expected = (index * inside.sin()).asin().tan();
                let shares: f64 = own.spots.iter().map(|spot| spot.share).sum();
                assert!((shares - 1.0).abs() < 1e-12);
                assert_eq!(own.spots.len(), if error > 0.0 { 6 } else { 1 });
                for spot in &own.spots {
                    let found = 1e-3 * spot.across_mrad.hypot(spot.along_mrad);
                    // The cubes of a pair differ by the second order, and their mean is given.
                    let off = (found - expected).abs();
                    let slack = if cubes > 1 {
                        error.powi(2)
                    } else {
                        10.0 * error.powi(3)
                    };
                    assert!(off < index * (slack + 1e-12), "{error}: {off:e}");
                    // Shares differ by the part of the aperture that the error moves.
                    let share = 1.0 / own.spots.len() as f64;
                    assert!(
                        (spot.share - share).abs() < 5.0 * error + 1e-12,
                        "{}",
                        spot.share
                    );
                    cases += 1;
                }
            }
        }
    }
    assert_eq!(cases, 2 * 3 * 13);
}

/// With waves a thousand times shorter than light, MTF50 is that of the ray shift, whose transform
/// tables compute in another way ([`tables::Direction::otf_along`]). It is bisected here.
#[test]
fn mtf50_is_that_of_the_ray_shift_for_short_waves() {
    let mut cases = 0;
    for (cell, index) in [(pair(), 1.49), (full_cube(), 1.0)] {
        let short = DatasheetRequest {
            wavelength_nm: 1.0,
            // Metals are not known there.
            metal_index: metal("0.96,6.7", None).unwrap(),
            cells: 2,
            ..request(index)
        };
        let sheet = made(&cell, &short);
        let prepared = bakes::prepared(&cell);
        for own in sheet
            .tolerances
            .iter()
            .filter(|own| own.surface == Surface::Mirrors)
        {
            let exact = prepared.exact().expect("planar");
            let rules = Rules::mirrors(index);
            let share = exact.direction(own.incidence_deg, 0.0, 1, 2.0, &rules);
            assert_eq!(own.eta, share.retroreflected);
            let direction = tables::Direction {
                incidence_deg: own.incidence_deg,
                azimuth_deg: 0.0,
                retroreflected: own.eta,
                probability: ndarray::Array2::zeros((1, 1)),
                range: 2.0,
                standard_error: 0.0,
                interpolated: false,
                paths: Some(share.paths),
                exits: None,
            };
            let cosine = own.incidence_deg.to_radians().cos();
            for (k, along) in [[cosine, 0.0], [0.0, 1.0]].into_iter().enumerate() {
                let mtf = |f: f64| direction.otf_along(along, &[f])[0].norm();
                let first = (1..4000).find(|&k| mtf(1e-3 * f64::from(k)) < 0.5);
                let end = 1e-3 * f64::from(first.expect("it falls"));
                let found = own.mtf50_per_mm[k].expect("cubes have waves");
                // Diffraction by 1 nm at 300 mm takes lambda R f / c = 3e-4 of the aperture, and the
                // search here has steps of 1e-3.
                assert!((found - end).abs() < 2e-3 * end.max(0.5), "{found} {end}");
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 2 * 2 * 2);
}

/// Dihedral errors only blur: each random cell and a sheet of them have a lower MTF50 than the ideal
/// cell in the mean, smaller errors blur less, and eta hardly changes (the aperture by the error).
/// The same seed gives the same cells, and another one gives others.
#[test]
fn random_cells_follow_their_error_and_seed() {
    let sheet = |error_mrad: f64, seed: u64| {
        let asked = DatasheetRequest {
            error_mrad,
            seed,
            cells: 8,
            step_deg: 15.0,
            incidence_deg: vec![20.0],
            ..request(1.49)
        };
        made(&pair(), &asked)
    };
    let [small, large, again, other] =
        [(0.01, 1), (0.5, 1), (0.5, 1), (0.5, 2)].map(|(error, seed)| sheet(error, seed));
    assert_eq!(large, again);
    assert_ne!(large.tolerances, other.tolerances);
    let mut cases = 0;
    for (small, large) in small.tolerances.iter().zip(&large.tolerances) {
        let spread = large.eta_spread.expect("cubes have errors");
        assert!((spread.mean - large.eta).abs() < 1e-3, "{spread:?}");
        assert!(spread.standard_deviation < 1e-3 && spread.least <= spread.largest);
        for k in 0..2 {
            let nominal = large.mtf50_per_mm[k].expect("light returns");
            let [fine, coarse] = [small, large].map(|own| own.mtf50_spread[k].expect("waves"));
            assert!(
                (fine.mean / nominal - 1.0).abs() < 0.01,
                "{fine:?} {nominal}"
            );
            assert!(coarse.mean < fine.mean, "{coarse:?} {fine:?}");
            let together = large.mtf50_of_sheet[k].expect("waves");
            assert!((coarse.least..coarse.largest).contains(&together));
            cases += 1;
        }
    }
    assert_eq!(cases, 3 * 2);
}

/// A mesh of one piece with two corners, and one without any, have maps but no tolerances, and say
/// so. Curved and glass cells are refused with a remedy.
#[test]
fn cells_without_corners_have_maps_alone() {
    let ends = cells::edges(0.0);
    let mut flat = triangular();
    // Two facets at right angles and none between them.
    flat.facets.truncate(2);
    flat.facets
        .push([ends[0], ends[1], ends[2]].map(|p| p.with_z(0.1)));
    let sheet = made(&flat, &request(1.0));
    assert!(sheet.spots.is_empty() && sheet.tolerances.iter().all(|own| own.eta_spread.is_none()));
    assert!(
        sheet
            .remarks
            .iter()
            .any(|remark| remark.contains("dihedral errors are left out"))
    );

    let mut glass = triangular();
    glass.glass = vec![true; 3];
    let prepared = bakes::prepared(&glass);
    let refused = datasheet(&prepared, None, &request(1.0), Progress::none());
    let said = refused.expect_err("glass").to_string();
    assert!(
        said.contains("plane facets") && said.contains("bake trace"),
        "{said}"
    );
}

#[test]
fn conditions_out_of_range_are_refused_by_name() {
    type Change = fn(&mut DatasheetRequest);
    let cases: [(&str, Change); 10] = [
        ("--refractive-index", |own| own.refractive_index = Some(0.5)),
        ("--wavelength-nm", |own| own.wavelength_nm = f64::NAN),
        ("--step", |own| own.step_deg = 0.0),
        ("--up-to", |own| own.up_to_deg = 90.0),
        ("--azimuth", |own| own.azimuth_deg = 1e9),
        ("--distance", |own| own.distance_mm = -1.0),
        ("--error-mrad", |own| own.error_mrad = 50.0),
        ("--cells", |own| own.cells = 1),
        ("--incidence", |own| own.incidence_deg = vec![1.0; 5]),
        ("--incidence", |own| own.incidence_deg = vec![89.0]),
    ];
    for (option, change) in cases {
        let mut asked = request(1.0);
        change(&mut asked);
        let refused = asked.check().expect_err(option);
        assert!(matches!(refused, Error::Usage(_)));
        assert!(refused.to_string().starts_with(option), "{refused}");
    }
}

/// Texts of all figures lie within them and beside each other, names become no markup, and CSV and
/// JSON hold the maps.
#[test]
fn pages_and_numbers_hold_everything() {
    let name = "<script>a-mesh-with_a_name_of/many_letters</script>".repeat(2);
    let sheet = |cell: &Cell, index: f64| Datasheet {
        name: name.clone(),
        ..made(cell, &request(index))
    };
    let sheets = [sheet(&pair(), 1.49), sheet(&full_cube(), 1.0)];
    for some in [&sheets[..1], &sheets[1..], &sheets[..]] {
        let page = page(some, "bake datasheet <b>");
        assert_eq!(charts::check::faults(&page), [""; 0]);
        assert!(!page.contains("<script") && !page.contains("<b>") && !page.contains("NaN"));
        let kernel = "azimuth 0\u{b0}, 300 mm from the sheet, 550 nm, corner size c";
        let comparison = page.contains("<h2>MTF50 (1/mm)</h2>");
        assert!(page.contains(kernel) && comparison == (some.len() == 2));
    }
    let csv = report::csv(&sheets);
    // A solid and a hollow cell have two surfaces in common.
    assert_eq!(csv.lines().count(), 1 + 2 * 15 * 72);
    let row = csv.lines().nth(1).expect("a first direction");
    let numbers: Vec<f64> = row.split(',').skip(1).map(|x| x.parse().unwrap()).collect();
    let expected = [0.0, 0.0, 2.0 / 3.0, 1.0, 1.0 / 3.0, 1.5];
    assert!(row.starts_with("mirrors,"), "{row}");
    for (found, expected) in numbers.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-12, "{row}");
    }
    let json = report::json(&sheets);
    assert_eq!(
        json["cells"][0]["surfaces"][2]["eta"][14]
            .as_array()
            .map(Vec::len),
        Some(72)
    );
    let ratio = json["second_against_first"][0]["ratio"][0][0].as_f64();
    assert!((ratio.expect("a ratio") - 1.5).abs() < 1e-12);
}
