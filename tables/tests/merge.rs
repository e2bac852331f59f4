//! Merging is adding rays: by hand, in every order, and refused where it would lie.

mod sample;

use ndarray::{Axis, s};
use proptest::prelude::*;
use tables::{Error, Fate, Mismatch, Table, merge, merge_shards};

/// A part of a table: its counts where `keep` says so, no rays elsewhere.
fn part(table: &Table, keep: impl Fn(usize, usize, usize) -> bool) -> Table {
    let (mut counts, mut fates) = (
        table.counts.clone().unwrap(),
        table.fate_counts.clone().unwrap(),
    );
    let (i, j, r, _) = fates.dim();
    for (i, j, r) in (0..i).flat_map(|i| (0..j).flat_map(move |j| (0..r).map(move |r| (i, j, r)))) {
        if !keep(i, j, r) {
            counts.slice_mut(s![i, j, r, .., ..]).fill(0);
            fates.slice_mut(s![i, j, r, ..]).fill(0);
        }
    }
    Table::from_counts(table.axes.clone(), counts, fates, table.provenance.clone())
}

fn mismatch(tables: &[Table]) -> Mismatch {
    match merge(tables).unwrap_err() {
        Error::Merge(mismatch) => mismatch,
        other => panic!("{other}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Any split of directions and randomisations gives back the whole, bit for bit, in any order and grouping.
    #[test]
    fn any_split_merges_to_the_whole(owner in prop::collection::vec(0..4_usize, 3 * 2 * 3), turn in 0..4_usize) {
        let whole = sample::rays(3, 7);
        let mut shards: Vec<Table> =
            (0..4).map(|shard| part(&whole, |i, j, r| owner[(i * 2 + j) * 3 + r] == shard)).collect();
        shards.rotate_left(turn);
        let merged = merge(&shards).unwrap();
        prop_assert_eq!(&merged, &whole);
        prop_assert_eq!(merged.content_hash(), whole.content_hash());
        let halves = [merge(&shards[..1]).unwrap(), merge(&shards[1..]).unwrap()];
        prop_assert_eq!(merge(&halves).unwrap(), whole);
    }
}

#[test]
fn seeds_that_follow_one_another_are_more_randomisations() {
    // Seeds 7 and 8, then 9: one bake of three randomisations from seed 7.
    let (first, second) = (sample::rays(2, 7), sample::rays(1, 9));
    for order in [[&first, &second], [&second, &first]] {
        let merged = merge(&order.map(Clone::clone)).unwrap();
        assert_eq!(merged.provenance.seed, 7);
        let counts = merged.counts.as_ref().unwrap();
        assert_eq!(counts.shape()[2], 3);
        assert_eq!(
            counts.slice(s![.., .., ..2, .., ..]),
            first.counts.as_ref().unwrap()
        );
        assert_eq!(
            counts.slice(s![.., .., 2.., .., ..]),
            second.counts.as_ref().unwrap()
        );
        assert_eq!(merged.rays, &first.rays + &second.rays);
        let returned = |table: &Table| {
            let fates = table.fate_counts.as_ref().unwrap().sum_axis(Axis(2));
            fates[[0, 0, Fate::Retroreflected as usize]] + fates[[0, 0, Fate::OutOfRange as usize]]
        };
        let eta = (returned(&first) + returned(&second)) as f64 / merged.rays[[0, 0]] as f64;
        assert_eq!(merged.retroreflected[[0, 0]], eta);
    }
    assert_eq!(merge(std::slice::from_ref(&first)).unwrap(), first);
}

#[test]
fn what_would_count_twice_or_mix_designs_is_refused() {
    let table = sample::rays(2, 7);
    let twice = [table.clone(), table.clone()];
    assert_eq!(
        mismatch(&twice),
        Mismatch::Overlap {
            first: 0,
            second: 1,
            seed: 7,
            direction: (0, 0)
        }
    );
    // The caller may vouch for other samples of the same seed.
    let sum = merge_shards(&twice).unwrap();
    assert_eq!(sum.rays, &table.rays * 2);
    assert_eq!(sum.histogram, table.histogram);

    assert_eq!(mismatch(&[]), Mismatch::Empty);
    assert!(matches!(
        mismatch(&[sample::exact()]),
        Mismatch::NoCounts { index: 0, .. }
    ));
    let gap = [table.clone(), sample::rays(2, 11)];
    assert_eq!(
        mismatch(&gap),
        Mismatch::Seed {
            index: 1,
            expected: 9,
            found: 11
        }
    );
    let overlapping = [table.clone(), sample::rays(2, 8)];
    assert_eq!(
        mismatch(&overlapping),
        Mismatch::Seed {
            index: 1,
            expected: 9,
            found: 8
        }
    );

    type Change = fn(&mut Table);
    let changes: [(&str, Change); 19] = [
        ("generator", |t| t.provenance.generator.push('1')),
        ("design", |t| t.provenance.design.push('1')),
        ("mesh_hash", |t| t.provenance.mesh_hash.push('1')),
        ("edge_length", |t| t.provenance.edge_length = 2.0),
        ("edge_length_unit", |t| {
            t.provenance.edge_length_unit.push('1')
        }),
        ("azimuth_zero", |t| t.provenance.azimuth_zero[2] = 2.0),
        ("refractive_index", |t| t.provenance.refractive_index = 1.5),
        ("back", |t| t.provenance.back = "tir".to_owned()),
        ("losses", |t| t.provenance.losses = "fresnel".to_owned()),
        ("reflectance", |t| t.provenance.reflectance = 0.9),
        ("method", |t| t.provenance.method.push('1')),
        ("sampler", |t| t.provenance.sampler = "random".to_owned()),
        ("angular_tolerance_deg", |t| {
            t.provenance.angular_tolerance_deg = 1.0
        }),
        ("tolerance", |t| t.provenance.tolerance = 1.0),
        ("lattice", |t| t.provenance.lattice = None),
        ("incidence_deg", |t| t.axes.incidence_deg[1] = 11.0),
        ("azimuth_deg", |t| t.axes.azimuth_deg[1] = 31.0),
        ("bins", |t| t.axes.bins = 16),
        ("shift_range", |t| t.axes.range = 3.0),
    ];
    for (name, change) in changes {
        let mut other = sample::rays(2, 9);
        change(&mut other);
        let error = mismatch(&[table.clone(), other]);
        assert!(
            matches!(error, Mismatch::Field { field, index: 1, .. } if field == name),
            "{name}: {error}"
        );
    }
}

#[test]
fn means_merge_too() {
    let mean = sample::mean();
    let shards = [part(&mean, |i, _, _| i == 0), part(&mean, |i, _, _| i > 0)];
    assert_eq!(merge(&shards).unwrap(), mean);
}
