//! The limit of reflections, which all tracers of rays and the exact method share.

use crate::geometry::{Launch, Stream};
use crate::optics::{Incidence, Rules};
use crate::rays::{Accumulator, Bins, Index, Kernel, Scene, trace};
use crate::tests::bakes;
use crate::tests::exact::cells::cell;
use glam::{DVec2, DVec3};
use meshes::Cell;
use std::sync::Arc;
use tables::Fate;
use tables::options::Sampler;

/// Returns a wedge that reflects all light from straight above exactly `reflections` times.
///
/// Its two mirrors meet at the angle pi / N. Unfolded at each mirror, the path becomes a straight
/// line across a regular polygon of 2 N sides, each of which is the entrance of one copy of the
/// wedge. The line enters by one side and leaves by the opposite one, and crosses N mirrors.
///
/// Each mirror is one triangle with its tip at the bottom. It is twice as wide as high.
fn wedge(reflections: u32) -> Cell {
    let half = (0.5 * std::f64::consts::PI / f64::from(reflections)).tan();
    let right = [
        DVec3::ZERO,
        DVec3::new(half, -1.0, 1.0),
        DVec3::new(half, 1.0, 1.0),
    ];
    let left = [
        DVec3::ZERO,
        DVec3::new(-half, 1.0, 1.0),
        DVec3::new(-half, -1.0, 1.0),
    ];
    // A path comes as near to the bottom as it enters to the middle, 0.2 half or more. There the
    // mirrors reach 0.2 half to each side, twice as far as the light.
    let corners = [(0.2, -0.1), (0.8, -0.1), (0.8, 0.1), (0.2, 0.1)];
    let entrance = corners.map(|(x, y)| half * DVec2::new(x, y));
    cell(vec![right, left], 1.0, entrance.to_vec(), None)
}

/// Returns the fates of rays from straight above: one by one and together down a hierarchy.
fn fates(cell: &Cell, rules: &Rules, rays: u64) -> Vec<[u64; Fate::ALL.len()]> {
    let bins = Bins::new(8, 2.0);
    let launch = Launch::new(&cell.entrance);
    let stream = Stream::new(Sampler::Random, 3, 0.0, 0.0, 0);
    let mut found = Vec::new();
    for index in [Index::Loop, Index::Hierarchy] {
        let scene = Arc::new(Scene::new(cell, index));
        assert_eq!(scene.has_hierarchy(), index == Index::Hierarchy);
        let kernel = Kernel::new(&scene, &launch, rules, &bins, 0.0, 0.0);
        assert!(kernel.programs().is_empty(), "programs are not that deep");
        for together in [false, true] {
            let mut accumulator = Accumulator::new(&bins);
            match together {
                true => kernel.trace(&stream, 0..rays, &mut accumulator),
                false => kernel.trace_one_by_one(&stream, 0..rays, &mut accumulator),
            }
            found.push(accumulator.fates);
        }
    }
    found
}

/// Light that needs 63 or 64 reflections leaves the wedge straight back, but not turned about as by
/// a corner; light that needs 65 or 66 has the fate `bounce_limit`. Every tracer agrees.
#[test]
fn light_is_followed_to_64_reflections_and_no_further() {
    let rules = Rules::mirrors(1.0);
    let down = Incidence::new(0.0, 0.0, 1.0);
    let rays = 500;
    for (reflections, fate) in [
        (63, Fate::AntiparallelOther),
        (64, Fate::AntiparallelOther),
        (65, Fate::BounceLimit),
        (66, Fate::BounceLimit),
    ] {
        let cell = wedge(reflections);
        let mut all = [0; Fate::ALL.len()];
        all[fate as usize] = rays;
        for fates in fates(&cell, &rules, rays) {
            assert_eq!(fates, all, "{reflections} reflections");
        }
        let point = cell.entrance.polygon[0].midpoint(cell.entrance.polygon[2]);
        let outcome = trace(&Scene::new(&cell, Index::Loop), &rules, &down, point, 0.5);
        assert_eq!((outcome.fate, outcome.bounces), (fate, reflections.min(64)));

        let exact = bakes::exact(&cell).expect("two planes");
        let share = exact.direction(0.0, 0.0, 8, 2.0, &rules);
        // One area is divided by itself after 64 cuts that round by an ulp or two each.
        let whole = share.fate[fate as usize];
        assert!((whole - 1.0).abs() < 1e-13, "{reflections}: {whole}");
    }
}

/// In a sheet with glass the limit counts the facets met, reflections and crossings alike, and is
/// as large.
#[test]
fn light_in_a_sheet_with_glass_is_followed_as_far() {
    let rules = Rules {
        glass_index: Some(1.5),
        ..Rules::mirrors(1.0)
    };
    let rays = 500;
    for (reflections, fate) in [(64, Fate::Retroreflected), (65, Fate::BounceLimit)] {
        let cell = Cell {
            glass: vec![false; 2],
            ..wedge(reflections)
        };
        let mut all = [0; Fate::ALL.len()];
        all[fate as usize] = rays;
        for fates in fates(&cell, &rules, rays) {
            assert_eq!(fates, all, "{reflections} reflections");
        }
    }
}
