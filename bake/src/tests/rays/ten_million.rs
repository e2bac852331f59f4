//! Ten million rays of each kind of cell: the fast ways against one ray at a time against all
//! facets.
//!
//! `cargo test --release -p bake --lib ten_million -- --ignored --nocapture`

use crate::geometry::{Launch, Stream};
use crate::optics::{Backing, Rules};
use crate::rays::{Accumulator, Bins, Index, Kernel, Scene};
use crate::tests::cells;
use crate::tests::rays::kernels::uneven;
use meshes::Cell;
use meshes::design::{Design, Shape};
use std::sync::Arc;
use tables::deviation::Grid;
use tables::options::{Roughness, Sampler, Slopes};

const RAYS: u64 = 10_000_000;

/// Each ray has the fate, the bin and the exit direction that it has alone.
#[test]
#[ignore = "minutes: ten million rays one by one, in nine cases"]
fn ten_million_rays_of_each_case_agree() {
    let mirrors = Rules {
        angular_tolerance_rad: 0.009,
        ..Rules::mirrors(1.0)
    };
    let bare = Rules {
        refractive_index: 1.49,
        mirror_back: false,
        losses: Some(Backing::Bare),
        ..mirrors
    };
    let lossy = Rules {
        refractive_index: 1.49,
        losses: Some(Backing::Mirror { reflectance: 0.9 }),
        ..mirrors
    };
    let rough = Rules {
        roughness: Roughness::new(Slopes::Beckmann, 1e-3).ok(),
        ..mirrors
    };
    let errors = |shape| {
        cells::designed(&Design {
            dihedral_error_rad: [5e-4, 0.0, -3e-4],
            ..Design::new(shape)
        })
    };
    let cases: [(&str, Cell, Rules, Sampler); 9] = [
        ("ideal cube", cells::triangular(), mirrors, Sampler::Random),
        (
            "dihedral errors",
            errors(Shape::Triangular),
            mirrors,
            Sampler::Random,
        ),
        (
            "dihedral errors",
            errors(Shape::Triangular),
            mirrors,
            Sampler::Sobol,
        ),
        ("Fresnel losses", cells::triangular(), bare, Sampler::Random),
        (
            "Fresnel losses, errors",
            errors(Shape::Triangular),
            bare,
            Sampler::Sobol,
        ),
        ("mirrors of 0.9", cells::pair(), lossy, Sampler::Random),
        (
            "full cubes, lattice, errors",
            errors(Shape::FullCube),
            mirrors,
            Sampler::Random,
        ),
        ("rough facets", cells::triangular(), rough, Sampler::Random),
        (
            "unlike cubes, one mesh",
            uneven(3, 2),
            mirrors,
            Sampler::Random,
        ),
    ];
    let grid = Grid {
        cells: 8,
        bins: 401,
        range: 0.02,
    };
    let bins = Bins::new(64, 2.0);
    let (incidence, azimuth) = (20.0, 17.0);
    let mut compared = 0;
    for (name, cell, rules, sampler) in cases {
        let launch = Launch::new(&cell.entrance);
        let [scene, oracle] =
            [Index::Auto, Index::Loop].map(|index| Arc::new(Scene::new(&cell, index)));
        let kernel = |scene| {
            Kernel::new(scene, &launch, &rules, &bins, incidence, azimuth).recording(Some(grid))
        };
        let stream = Stream::new(sampler, 7, incidence, azimuth, 0);
        let (mut fast, mut plain) = (Accumulator::new(&bins), Accumulator::new(&bins));
        kernel(&scene).trace(&stream, 0..RAYS, &mut fast);
        kernel(&oracle).trace_one_by_one(&stream, 0..RAYS, &mut plain);
        assert_eq!(fast.take_exits(), plain.take_exits(), "{name}");
        assert_eq!(fast, plain, "{name}");
        let sum: u64 = fast.fates.iter().sum();
        assert_eq!(sum, RAYS, "{name}");
        println!("{name}, {sampler:?}: {sum} rays, by fate {:?}", fast.fates);
        compared += sum;
    }
    assert_eq!(compared, 9 * RAYS);
}
