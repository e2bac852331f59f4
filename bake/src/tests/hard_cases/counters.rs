//! Samples, accumulators, sums and tables from one ray to more than 2^34.

use crate::geometry::{Launch, Stream};
use crate::optics::Rules;
use crate::plan::Request;
use crate::rays::{Accumulator, Bins, Index, Kernel, Scene, Sums};
use crate::tests::bakes::compare;
use crate::tests::hard_cases::both::{BothOptions, bake, cell, sound};
use meshes::design::Shape;
use ndarray::{Array4, Array5};
use std::sync::Arc;
use tables::options::{Front, Method, Sampler};
use tables::{Fate, Table};

/// One ray makes a whole table, by either sampler, that can be written, read and compared with the
/// exact one.
#[test]
fn one_ray() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut cases = 0;
    for shape in Shape::ALL {
        for sampler in [Sampler::Random, Sampler::Sobol] {
            let request = Request {
                rays: Some(1),
                sampler,
                ..BothOptions::new("0,20", "0").request(Method::Rays)
            };
            let table = bake(&cell(shape), &request);
            sound(&table, shape.name());
            assert!(table.rays.iter().all(|&rays| rays == 1));
            assert!(
                table
                    .retroreflected
                    .iter()
                    .all(|&eta| eta == 0.0 || eta == 1.0)
            );
            assert!(table.standard_error.iter().all(|&error| error == 0.0));
            let file = folder.path().join("one.h5");
            tables::write(&table, &file).expect("writes");
            assert_eq!(tables::read(&file).expect("reads"), table);
            let exact = BothOptions::new("0,20", "0").bake(&cell(shape), Method::Exact);
            assert!(
                tables::l1(&table, &exact)
                    .iter()
                    .all(|l1| (0.0..=2.0).contains(l1))
            );
            cases += 1;
        }
    }
    println!("one ray: {cases} tables written and read again");
    assert_eq!(cases, 2 * Shape::ALL.len());
}

/// The program counts what the plain tracer counts at the last samples of a Sobol randomisation
/// (2^32 less a few) and at random samples beyond 2^34. These random samples do not repeat those
/// from 0 on.
#[test]
fn the_last_samples() {
    let cube = cell(Shape::TriangularPair);
    let bins = Bins::new(32, 2.0);
    let rules = Rules::mirrors(1.0);
    let scene = Arc::new(Scene::new(&cube, Index::Loop));
    let kernel = Kernel::new(
        &scene,
        &Launch::new(&cube.entrance),
        &rules,
        &bins,
        20.0,
        30.0,
    );
    assert!(!kernel.programs().is_empty());
    let (long, short) = (100_003, 1_003);
    let mut cases = 0;
    for (sampler, end) in [
        (Sampler::Sobol, 1_u64 << 32),
        (Sampler::Random, (1 << 34) + 50_000),
        (Sampler::Random, 1 << 48),
    ] {
        let stream = Stream::new(sampler, 5, 20.0, 30.0, 15);
        for rays in [long, short] {
            compare(&kernel, &bins, &stream, end - rays..end);
            cases += 1;
        }
        let first: std::collections::HashSet<[u32; 2]> =
            (0..1000).map(|i| stream.pair(i)).collect();
        assert!((end - 1000..end).all(|i| !first.contains(&stream.pair(i))));
    }
    println!("last samples: {cases} runs up to 2^32, 2^34 + 50,000 and 2^48");
    assert_eq!(cases, 6);
}

/// Counters that start near the limits of 2^32 and 2^34 rays a bin go on in 64 bits, from the
/// accumulator to the file.
#[test]
fn more_than_2_to_the_34_rays() {
    let bins = Bins::new(4, 2.0);
    let mut accumulator = Accumulator::new(&bins);
    // An accumulator takes at most 2^32 - 1 rays, so runs are cut to fewer.
    let full = u32::MAX;
    accumulator.histogram[5] = full;
    accumulator.fates[Fate::Retroreflected as usize] = u64::from(full);
    accumulator.fates[Fate::LeftAfter1 as usize] = 1;
    let mut sums = Sums::new(&bins, 2);
    for _ in 0..5 {
        sums.add(0, &accumulator);
        sums.add(1, &accumulator);
    }
    let back = 10 * u64::from(full);
    assert!(back > 1 << 34);
    assert_eq!(sums.counts.iter().sum::<u64>(), back);
    assert_eq!(sums.rays(), back + 10);
    assert_eq!(sums.l1_error(), 0.0, "equal randomisations");

    let light = BothOptions::new("20", "0");
    let request = Request {
        bins: 4,
        ..light.request(Method::Rays)
    };
    let small = bake(&cell(Shape::Triangular), &request);
    let shape = (1, 1, 2, 4, 4);
    let counts = Array5::from_shape_vec(shape, sums.counts.clone()).expect("its shape");
    let known = Fate::of(Front::Once, false).len();
    let fates = sums.fates.iter().flat_map(|fates| &fates[..known]);
    let fates: Vec<u64> = fates.copied().collect();
    let fates = Array4::from_shape_vec((1, 1, 2, known), fates).expect("its shape");
    let large = |seed| {
        let mut provenance = small.provenance.clone();
        (provenance.sampler, provenance.seed) = (Some(Sampler::Sobol.into()), seed);
        Table::from_counts(
            small.axes.clone(),
            counts.clone(),
            fates.clone(),
            provenance,
        )
    };
    let table = large(1);
    sound(&table, "2^34");
    assert_eq!(table.rays[[0, 0]], back + 10);
    let lost = 1.0 - table.retroreflected[[0, 0]];
    println!("{} rays: 10 of them lost make {lost:.3e}", back + 10);
    assert!((lost / (10.0 / (back + 10) as f64) - 1.0).abs() < 1e-6);

    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("large.h5");
    tables::write(&table, &file).expect("writes");
    assert_eq!(tables::read(&file).expect("reads"), table);
    // Seeds 1 and 2 belong to the two randomisations of the first bake, so the next seed is 3.
    let merged = tables::merge(&[table, large(3)]).expect("merges");
    assert_eq!(merged.rays[[0, 0]], 2 * (back + 10));
    assert_eq!(merged.counts.expect("counted").sum(), 2 * back);
}
