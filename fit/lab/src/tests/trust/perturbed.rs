//! Tests of a scene that is taken otherwise than its manifest says.

use crate::planted::{camera, deviating, params, table, truth};
use crate::simulate::photograph::photograph;
use crate::simulate::{Params, PlantedSheet};
use crate::study::trial;
use crate::tests::estimates::azimuth::all_azimuths;
use edges::names::{Kernel, LobeShape};
use edges::photographs::Campaign;
use estimator::estimate::{Aerial, Conditions, OtherIndex, Scene};
use tables::Table;
use tables::options::{Back, Losses};

const INCIDENCE: [f64; 2] = [10.0, 30.0];

fn sheet() -> PlantedSheet {
    truth(Kernel::Eq1, LobeShape::Radial, 3.4, 0.31, 0.6)
}

/// Three photographs at two incidences, with edges in several directions.
fn planted() -> Params {
    let mut planted = params(5, sheet(), &INCIDENCE, &[150.0, 300.0], camera(2e5));
    planted.captures.truncate(3);
    for (shot, normal_deg) in planted.captures.iter_mut().zip([5.0, 38.0, -61.0]) {
        shot.edge.normal_deg = normal_deg;
    }
    planted
}

/// Measures the photographs of `planted` as a manifest describes them.
fn taken(planted: &Params, manifest: &Campaign, table: &Table) -> Scene {
    Scene::of(manifest, table, &trial::source(planted, photograph)).unwrap()
}

/// Returns the greatest difference of two scenes in anything that a placement decides.
fn apart(found: &Scene, expected: &Scene) -> f64 {
    assert_eq!(found.groups, expected.groups);
    assert_eq!(found.shots.len(), expected.shots.len());
    let mut worst = 0.0_f64;
    for (own, other) in found.shots.iter().zip(&expected.shots) {
        assert_eq!(own.place.group, other.place.group);
        assert_eq!(own.conditions().r_mm, other.conditions().r_mm);
        assert_eq!(own.exposure, other.exposure);
        assert_eq!(
            own.direction.refractive_index,
            other.direction.refractive_index
        );
        worst = worst.max(
            (own.direction.returned.retroreflected - other.direction.returned.retroreflected).abs(),
        );
        for k in 0..2 {
            worst = worst.max((own.normal()[k] - other.normal()[k]).abs());
        }
        let otf = |shot: &Aerial, f| {
            shot.direction
                .shift
                .as_ref()
                .unwrap()
                .otf(0.31, shot.r_mm, f)
                .0
        };
        for f in [0.5, 1.0, 2.0, 4.0] {
            worst = worst.max((otf(own, f) - otf(other, f)).norm());
        }
    }
    worst
}

/// A scene that is perturbed as another manifest says equals the scene of that manifest. The turned
/// axis is rounded on another way: to a few units of 2e-16, which the OTF of shifts up to 2 edge
/// lengths (2 pi c f x 2 = 16) and the sums over its 1000 terms raise to 1e-12 at most.
#[test]
fn a_scene_placed_otherwise_is_the_scene_taken_so() {
    let table = all_azimuths(&sheet(), &INCIDENCE);
    let planted = planted();
    let stated = trial::campaign(&planted, &[]);
    let scene = taken(&planted, &stated, &table);
    // Incidence, azimuth, distance, exposure, tangential axis, mirror.
    let otherwise = [
        (
            "incidences exchanged",
            [30.0, 10.0, 10.0],
            [20.0; 3],
            1.0,
            1.0,
            0.0,
            true,
        ),
        ("one incidence", [12.5; 3], [20.0; 3], 1.0, 1.0, 0.0, true),
        (
            "azimuths",
            [10.0, 10.0, 30.0],
            [0.0, 15.0, 371.0],
            1.0,
            1.0,
            0.0,
            true,
        ),
        (
            "distances",
            [10.0, 10.0, 30.0],
            [20.0; 3],
            10.0,
            1.0,
            0.0,
            true,
        ),
        (
            "exposures",
            [10.0, 10.0, 30.0],
            [20.0; 3],
            1.0,
            1.5,
            0.0,
            true,
        ),
        ("axis", [10.0, 10.0, 30.0], [20.0; 3], 1.0, 1.0, 90.0, true),
        (
            "all",
            [30.0, 11.0, 10.0],
            [1.0, 2.0, 3.0],
            0.5,
            2.0,
            -7.0,
            false,
        ),
    ];
    for (name, incidence, azimuth, distance, exposure, axis, mirror) in otherwise {
        let mut manifest = stated.clone();
        manifest.setup.seen_in_mirror = Some(mirror);
        let mut conditions: Vec<Conditions> = Vec::new();
        for (i, shot) in manifest.captures.iter_mut().enumerate() {
            shot.incidence_deg = incidence[i];
            shot.azimuth_deg = Some(azimuth[i]);
            shot.floating_distance_mm *= distance;
            shot.shot.exposure *= exposure;
            shot.tangential_axis_deg += axis;
            conditions.push(Conditions {
                incidence_deg: incidence[i],
                azimuth_deg: Some(azimuth[i]),
                r_mm: shot.floating_distance_mm,
                exposure: shot.shot.exposure,
                axis_turn_rad: f64::to_radians(axis),
                seen_in_mirror: mirror,
            });
        }
        let expected = taken(&planted, &manifest, &table);
        let found = scene.perturbed(&table, None, &conditions).unwrap();
        let off = apart(&found, &expected);
        println!("{name}: {off:.1e}");
        assert!(off < 1e-12, "{name}: {off}");
        // And back again.
        let own: Vec<Conditions> = scene.shots.iter().map(Aerial::conditions).collect();
        let back = found.perturbed(&table, None, &own).unwrap();
        assert_eq!(apart(&back, &scene), 0.0, "{name}");
    }
}

/// A table of one index stands for another: eta and OTF are those of a table made with it. The
/// table holds the directions that are asked for, so both come from one closed form at one angle
/// inside, whose rounding (1e-16, times the slope of the OTF, below 100) is all that differs.
#[test]
fn a_table_holds_the_shifts_of_other_indices() {
    let (mut cases, mut least) = (0, f64::INFINITY);
    let planted = planted();
    let stated = trial::campaign(&planted, &[]);
    for (own, other) in [(1.49, 1.586), (1.49, 1.505), (1.0, 1.49), (1.49, 1.0)] {
        let with = |refractive_index| PlantedSheet {
            refractive_index,
            ..sheet()
        };
        let held = INCIDENCE.map(|deg| (deg.to_radians().sin() * own / other).asin().to_degrees());
        let both = [held[0], held[1], INCIDENCE[0], INCIDENCE[1]];
        let mut angles = both.to_vec();
        angles.sort_by(f64::total_cmp);
        let of_own = table(&with(own), &angles, 20.0);
        let of_other = table(&with(other), &INCIDENCE, 20.0);
        let scene = taken(&planted, &stated, &of_own);
        let conditions: Vec<Conditions> = scene.shots.iter().map(Aerial::conditions).collect();
        let index = OtherIndex::of(&of_own, other).unwrap();
        let found = scene.perturbed(&of_own, Some(index), &conditions).unwrap();
        let expected = taken(&planted, &stated, &of_other);
        let off = apart(&found, &expected);
        assert!(off < 1e-13, "{own} for {other}: {off}");
        let eta = |scene: &Scene| scene.shots[2].direction.returned.retroreflected;
        least = least.min((eta(&found) - eta(&scene)).abs());
        cases += 1;
    }
    println!("eta at 30 degrees changes by {least:.4} at least");
    assert!(least > 1e-3, "{least}");
    assert_eq!(cases, 4);
}

/// Only a table without losses, of mirrors that send light straight back, stands for another index,
/// and no index is below 1.
#[test]
fn tables_whose_light_depends_on_the_index_stand_for_no_other() {
    let own = || table(&sheet(), &INCIDENCE, 20.0);
    let mut lossy = own();
    lossy.provenance.losses = Losses::Fresnel.into();
    let mut bare = own();
    bare.provenance.back = Back::Tir.into();
    let mut plate = own();
    plate.provenance.options = "--element plate".into();
    let mut later = own();
    later.provenance.options = "--of-a-later-version 3".into();
    let mut trapped = own();
    trapped.provenance.options = "--front trapped".into();
    let astray = deviating(own(), |_| [1e-4, 0.0]);
    let refused = [lossy, bare, plate, later, trapped, astray];
    for (case, table) in refused.iter().enumerate() {
        assert_eq!(OtherIndex::of(table, 1.5), None, "case {case}");
    }
    assert_eq!(OtherIndex::of(&own(), 0.99), None);
    assert!(OtherIndex::of(&own(), 1.5).is_some());
    // The steepest light of the index 1 is not in a table that ends at 30 degrees.
    let planted = planted();
    let scene = taken(&planted, &trial::campaign(&planted, &[]), &own());
    let conditions: Vec<Conditions> = scene.shots.iter().map(Aerial::conditions).collect();
    let hollow = OtherIndex::of(&own(), 1.0);
    let refused = scene.perturbed(&own(), hollow, &conditions).err().unwrap();
    assert!(refused.to_string().contains("30"), "{refused}");
}
