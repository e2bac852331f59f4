//! Tests of the library from outside: the functions that another front end calls.

use bake::{Comparison, Error, Plan, Prepared, Progress, Request, retrace, trace};
use meshes::CellOptions;
use meshes::design::{Design, Shape};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use tables::options::Method;

fn prepared(shape: Shape) -> Prepared {
    let mesh = Design::new(shape).mesh().expect("a design");
    let options = CellOptions::default();
    Prepared::new(meshes::normalise(&mesh, "cell".as_ref(), &options).expect("a cell"))
}

fn plan(method: Method) -> Plan {
    Plan::new(&Request {
        incidence: "0,20,40".into(),
        method,
        rays: Some(1 << 20),
        bins: 32,
        ..Request::default()
    })
    .expect("a valid request")
}

#[test]
fn all_rays_are_told_of_and_the_methods_agree() {
    let pair = prepared(Shape::TriangularPair);
    let tables = [Method::Rays, Method::Exact].map(|method| {
        let told = AtomicU64::new(0);
        let count = |rays| {
            told.fetch_add(rays, Ordering::Relaxed);
        };
        let table = trace(&pair, &plan(method), Progress::new(&count)).expect("bakes");
        assert_eq!(told.into_inner(), 3 << 20, "{method:?}");
        table
    });
    let comparison = Comparison::new(&tables[0], &tables[1]).expect("the same axes");
    assert_eq!(comparison.rows.len(), 3);
    assert!(comparison.agrees());
}

/// Stops a bake after its first rays, and before any.
#[test]
fn a_bake_is_stopped() {
    let pair = prepared(Shape::TriangularPair);
    for method in [Method::Rays, Method::Exact] {
        for before in [true, false] {
            let stop = AtomicBool::new(before);
            let told = |_| stop.store(true, Ordering::Relaxed);
            let progress = Progress::new(&told).stopped_by(&stop);
            let stopped = trace(&pair, &plan(method), progress);
            assert!(
                matches!(stopped, Err(Error::Stopped)),
                "{method:?}, {before}"
            );
        }
    }
}

#[test]
fn a_mesh_judges_its_table_and_another_one() {
    let pair = prepared(Shape::TriangularPair);
    let mut table = trace(&pair, &plan(Method::Exact), Progress::none()).expect("bakes");
    let judged =
        |table: &tables::Table, by: &Prepared| retrace(table, by, 1 << 16, 1, Progress::none());
    assert!(judged(&table, &pair).expect("rays").agrees());
    let other = prepared(Shape::FullCube);
    assert!(!judged(&table, &other).expect("rays").agrees());
    table.provenance.back = tables::options::Word::Other("of-a-later-version".to_owned());
    let unknown = judged(&table, &pair);
    assert!(matches!(unknown, Err(Error::Stated(_))));
}
