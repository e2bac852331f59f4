//! Tests of the refractive index: what is said if it was left out.

use crate::plan::{Plan, Request};
use crate::tests::{bakes, cells};
use tables::options::{Back, Element, SceneOptions};

/// Checks when `bake trace` says that the index was left out: only if neither the user nor the mesh
/// gives one, and only where a front face would have one.
#[test]
fn an_index_that_was_left_out_is_said() {
    let open = cells::pair;
    let with = |index| meshes::Cell {
        refractive_index: index,
        ..open()
    };
    let base = Request::default;
    let scene = |scene| Request { scene, ..base() };
    let of = |index| Request {
        refractive_index: index,
        ..base()
    };
    let plate = SceneOptions {
        element: Element::Plate,
        ..SceneOptions::default()
    };
    let glass = SceneOptions {
        glass_index: Some(1.9),
        ..SceneOptions::default()
    };
    let bare = Request {
        back: Back::Tir,
        ..base()
    };
    let cases = [
        (base(), open(), "--refractive-index was left out"),
        (of(Some(1.0)), open(), ""),
        (of(Some(1.49)), open(), ""),
        // The mesh says that it is hollow, or of what it is.
        (base(), with(Some(1.0)), ""),
        (base(), with(Some(1.49)), ""),
        (
            of(Some(1.49)),
            with(Some(1.0)),
            "--refractive-index 1.49 overrides the 1 that",
        ),
        (scene(plate), open(), ""),
        (scene(glass), open(), ""),
        (bare, open(), "--back tir without a refractive index"),
    ];
    let count = cases.len();
    for (case, (request, cell, expected)) in cases.into_iter().enumerate() {
        let plan = Plan::new(&request).expect("a plan");
        let said = plan.warnings(&bakes::prepared(&cell));
        assert_eq!(
            said.len(),
            usize::from(!expected.is_empty()),
            "{case}: {said:?}"
        );
        assert!(
            said.iter().all(|said| said.starts_with(expected)),
            "{case}: {said:?}"
        );
    }
    assert_eq!(count, 9);
}
