//! Merging: sums by hand, in every order, and refusals where the sum would be wrong.

use crate::sample;

use ndarray::{Axis, s};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::ops::Range;

use tables::options::{Back, Losses, Sampler, Word};
use tables::{Error, Fate, Shards, Table, merge};

/// Part of a table: its counts where `keep` says so, no rays elsewhere.
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

/// Checks that tables are not merged, and that the error names all of `words`.
fn refused(tables: &[Table], words: &[&str]) {
    let error = merge(tables).unwrap_err();
    assert!(matches!(error, Error::Merge { .. }), "{error:?}");
    for word in words {
        assert!(error.to_string().contains(word), "{word}: {error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Any split of directions and randomisations merges to the whole, bit for bit, in any order
    /// and grouping.
    #[test]
    fn any_split_merges_to_the_whole(
        owner in prop::collection::vec(0..4_usize, 3 * 2 * 3),
        turn in 0..4_usize,
    ) {
        let whole = sample::rays(3, 7);
        let mut shards: Vec<Table> = (0..4)
            .map(|shard| part(&whole, |i, j, r| owner[(i * 2 + j) * 3 + r] == shard))
            .collect();
        shards.rotate_left(turn);
        let merged = merge(&shards).unwrap();
        prop_assert_eq!(&merged, &whole);
        prop_assert_eq!(merged.content_hash(), whole.content_hash());
        let halves = [merge(&shards[..1]).unwrap(), merge(&shards[1..]).unwrap()];
        prop_assert_eq!(merge(&halves).unwrap(), whole);
    }
}

/// Deviations stay with their directions, and add up over seeds.
#[test]
fn deviations_are_merged() {
    let whole = sample::deviations(7);
    let parts = [whole.part(&[2], &[0, 1]), whole.part(&[0, 1], &[0, 1])];
    assert_eq!(merge(&parts).unwrap(), whole);
    let sides = [whole.part(&[0, 1, 2], &[1]), whole.part(&[0, 1, 2], &[0])];
    assert_eq!(merge(&sides).unwrap(), whole);
    let next = sample::deviations(9);
    let sum = merge(&[next.clone(), whole.clone()]).unwrap();
    let [sums, a, b] = [&sum, &whole, &next].map(|table| table.deviations.clone().unwrap());
    let rays = |found: &tables::Deviations, place: u64| {
        let entries = found.entries[1].iter();
        let here = entries.filter(|entry| entry.place == place);
        here.map(|entry| entry.rays).sum::<u64>()
    };
    for place in 0..sums.grid.places() {
        assert_eq!(rays(&sums, place), rays(&a, place) + rays(&b, place));
    }
    assert_eq!(sums.grid.places(), 400);
    let mut other = next.clone();
    other.deviations.as_mut().unwrap().grid.range = 3e-3;
    let without = sample::rays(2, 9);
    for table in [other, without] {
        refused(&[whole.clone(), table], &["deviation of table 1"]);
    }
}

#[test]
fn seeds_that_follow_one_another_are_more_randomisations() {
    // Seeds 7 and 8, then 9, are one bake of three randomisations from seed 7.
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
    let both = ["tables 0 and 1", "rays of seed 7", "(0, 0)"];
    refused(&twice, &both);
    refused(&[], &["no table"]);
    refused(&[table.clone(), sample::exact()], &["of table 1 is"]);
    refused(&[sample::exact(), sample::exact()], &["tables 0 and 1"]);
    for seed in [8, 11] {
        let found = format!("table 1 has seed {seed}");
        let next = [table.clone(), sample::rays(2, seed)];
        refused(&next, &[&found, "--seed 9"]);
    }

    type Change = fn(&mut Table);
    let changes: [(&str, Change); 19] = [
        ("generator", |t| t.provenance.generator.push('1')),
        ("design", |t| t.provenance.design.push('1')),
        ("mesh_hash", |t| t.provenance.mesh_hash.push('1')),
        ("edge_length", |t| t.provenance.edge_length = 2.0),
        ("edge_length_unit", |t| {
            t.provenance.edge_length_unit.push('1');
        }),
        ("azimuth_zero", |t| t.provenance.azimuth_zero[2] = 2.0),
        ("refractive_index", |t| t.provenance.refractive_index = 1.5),
        ("back", |t| t.provenance.back = Back::Tir.into()),
        ("losses", |t| t.provenance.losses = Losses::Fresnel.into()),
        ("reflectance", |t| t.provenance.reflectance = 0.9),
        ("method", |t| {
            t.provenance.method = Word::Other("rays1".to_owned());
        }),
        ("sampler", |t| {
            t.provenance.sampler = Some(Sampler::Random.into());
        }),
        ("angular_tolerance_deg", |t| {
            t.provenance.angular_tolerance_deg = 1.0;
        }),
        ("tolerance", |t| t.provenance.tolerance = 1.0),
        ("lattice", |t| t.provenance.lattice = None),
        ("wavelength_nm", |t| {
            t.provenance.wavelength_nm = Some(550.0);
        }),
        ("metal_index", |t| {
            t.provenance.metal_index = Some([0.97, 6.5]);
        }),
        ("bins", |t| t.axes.bins = 16),
        ("shift_range", |t| t.axes.range = 3.0),
    ];
    for (name, change) in changes {
        let mut other = sample::rays(2, 9);
        change(&mut other);
        refused(&[table.clone(), other], &[&format!("{name} of table 1 is")]);
    }
}

#[test]
fn means_merge_too() {
    let mean = sample::mean();
    let shards = [part(&mean, |i, _, _| i == 0), part(&mean, |i, _, _| i > 0)];
    assert_eq!(merge(&shards).unwrap(), mean);
}

#[test]
fn directions_join_to_the_table_of_all() {
    let mut joined = 0;
    for mut whole in [sample::rays(3, 7), sample::exact(), sample::symmetric()] {
        for parts in [
            vec![whole.part(&[0, 2], &[0, 1]), whole.part(&[1], &[0, 1])],
            vec![whole.part(&[0, 1, 2], &[1]), whole.part(&[0, 1, 2], &[0])],
            vec![
                whole.part(&[0], &[0]),
                whole.part(&[1, 2], &[0, 1]),
                whole.part(&[0], &[1]),
            ],
        ] {
            let merged = merge(&parts).unwrap();
            // Nobody has checked the interpolation in the gaps between the parts.
            whole.provenance.direction_tolerance = None;
            assert_eq!(merged, whole);
            assert_eq!(merged.content_hash(), whole.content_hash());
            joined += 1;
        }
        let gap = [whole.part(&[0], &[0]), whole.part(&[1, 2], &[0, 1])];
        let (incidence, azimuth) = (whole.axes.incidence_deg[0], whole.axes.azimuth_deg[1]);
        let missing = format!("incidence {incidence} deg, azimuth {azimuth} deg of seed");
        refused(&gap, &["no table holds", &missing]);
    }
    assert_eq!(joined, 9);
}

/// Shard `k` of `of`: a share of the counts that sums to them.
fn shard(table: &Table, k: u32, of: u32) -> Table {
    let share = |n: &u64| {
        let Range { start, end } = Shards::samples(k, of, *n);
        end - start
    };
    let mut fates = table.fate_counts.clone().unwrap().mapv(|n| share(&n));
    let counts = table.counts.clone().unwrap().mapv(|n| share(&n));
    // A share of a sum is not the sum of the shares, so the counts of a direction say how many of
    // its rays returned.
    let (i, j, r, _) = fates.dim();
    for (i, j, r) in (0..i).flat_map(|i| (0..j).flat_map(move |j| (0..r).map(move |r| (i, j, r)))) {
        fates[[i, j, r, Fate::Retroreflected as usize]] = counts.slice(s![i, j, r, .., ..]).sum();
    }
    let mut provenance = table.provenance.clone();
    provenance.shards = Some(Shards {
        of,
        rays: 4_194_304,
        held: BTreeSet::from([k]),
    });
    Table::from_counts(table.axes.clone(), counts, fates, provenance)
}

#[test]
fn shards_in_any_order_and_grouping_are_the_whole_bake() {
    let whole = sample::rays(3, 7);
    let shards: Vec<Table> = (1..=5).map(|k| shard(&whole, k, 5)).collect();
    let pick =
        |which: &[usize]| -> Vec<Table> { which.iter().map(|&k| shards[k - 1].clone()).collect() };
    for order in [[1, 2, 3, 4, 5], [4, 2, 5, 1, 3]] {
        let merged = merge(&pick(&order)).unwrap();
        assert_eq!(merged, whole);
        assert_eq!(merged.content_hash(), whole.content_hash());
    }
    let some = merge(&pick(&[5, 1, 2])).unwrap();
    let record = some.provenance.shards.as_ref().unwrap();
    assert_eq!(record.to_string(), "1-2,5/5 of 4194304 rays");
    assert_ne!(some.content_hash(), whole.content_hash());
    assert_eq!(
        merge(&[some.clone(), merge(&pick(&[4, 3])).unwrap()]).unwrap(),
        whole
    );

    let refusals = [
        (
            vec![some.clone(), shards[1].clone()],
            "both hold shard 2 of seed 7",
        ),
        (
            vec![shards[0].clone(), shard(&whole, 2, 4)],
            "shards of table 1 is 2/4",
        ),
        (
            vec![whole.clone(), shards[0].clone()],
            "both hold rays of seed 7",
        ),
        (
            vec![some.clone(), sample::rays(3, 10)],
            "shards 3-4 of 5 of seed 7 are missing",
        ),
        (
            vec![
                shards[0].part(&[0], &[0, 1]),
                shards[1].part(&[1, 2], &[0, 1]),
            ],
            "hold shards 2/5 of 4194304 rays at incidence 10 deg",
        ),
    ];
    let count = refusals.len();
    for (tables, sentence) in refusals {
        refused(&tables, &[sentence]);
    }
    assert_eq!(count, 5);
}

#[test]
fn a_shard_comes_back_from_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("shard.h5");
    let table = shard(&sample::rays(2, 7), 2, 3);
    tables::write(&table, &file).unwrap();
    assert_eq!(tables::read(&file).unwrap(), table);
}

/// Tables of two program versions merge; tables of two generators do not.
#[test]
fn generators_of_one_level_merge() {
    let old = sample::rays(2, 7);
    assert_eq!(old.provenance.generator, "bake 0.1.0");
    let mut new = old.clone();
    new.provenance.generator = tables::GENERATOR.into();
    let mut more = new.clone();
    more.provenance.seed += 2;
    let mut of_the_new = new.clone();
    of_the_new.provenance.seed += 2;
    let whole = merge(&[new.clone(), of_the_new]).unwrap();
    assert_eq!(whole.provenance.generator, tables::GENERATOR);
    assert_eq!(merge(&[old.clone(), more.clone()]).unwrap(), whole);
    assert_eq!(merge(&[more, old.clone()]).unwrap(), whole);
    // Tables of the old generator alone keep its name, and so the hash.
    assert_eq!(merge(std::slice::from_ref(&old)).unwrap(), old);
    assert!(old.provenance.is_of_the_bake(&new.provenance));
    let mut later = new;
    later.provenance.generator = "airr ray-shift table 2".into();
    assert!(!old.provenance.is_of_the_bake(&later.provenance));
    later.provenance.seed += 2;
    refused(
        &[old, later],
        &["generator of table 1 is", "bake the table"],
    );
    // A table that lacks a fate cannot be added, whatever it says of its generator.
    let newer = sample::lossy_rays();
    let (counts, fates) = (newer.counts.clone(), newer.fate_counts.clone());
    let older = fates.unwrap().slice(s![.., .., .., ..10]).to_owned();
    let from = newer.provenance.clone();
    let mut older = Table::from_counts(newer.axes.clone(), counts.unwrap(), older, from);
    older.provenance.seed += 2;
    refused(&[newer, older], &["fate_name of table 1 is"]);
}
