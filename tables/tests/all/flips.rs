//! Single flipped bits: everywhere in the file, and in the numbers alone after the seal is gone.

use crate::sample;

use std::fs;
use std::ops::Range;
use std::path::Path;

use sample::Numbers;
use tables::{Table, read, write};

/// Offsets of the numbers of the file: the stored chunks of all datasets.
fn payload(path: &Path) -> Vec<Range<usize>> {
    let file = hdf5::File::open(path).unwrap();
    let groups = [file.as_group().unwrap()]
        .into_iter()
        .chain(file.group("exact"))
        .chain(file.group("deviation"));
    let mut ranges = Vec::new();
    for dataset in groups.flat_map(|group| group.datasets().unwrap()) {
        // Dimensions without coordinates store nothing.
        if dataset.chunk().is_none() && dataset.storage_size() == 0 {
            continue;
        }
        dataset
            .chunks_visit(|chunk| {
                ranges.push(chunk.addr as usize..(chunk.addr + chunk.size) as usize);
                0
            })
            .unwrap();
    }
    ranges.sort_by_key(|range| range.start);
    ranges
}

/// Flips bits one at a time; returns the numbers of flips that were found and that were harmless.
fn found(bytes: &[u8], bits: impl Iterator<Item = usize>, path: &Path, good: &Table) -> [usize; 2] {
    let (mut found, mut harmless) = (0, 0);
    for bit in bits {
        let mut flipped = bytes.to_vec();
        flipped[bit / 8] ^= 1 << (bit % 8);
        fs::write(path, &flipped).unwrap();
        match read(path) {
            Err(_) => found += 1,
            Ok(table) => {
                assert_eq!(table, *good, "bit {bit} changed the table unseen");
                harmless += 1;
            }
        }
    }
    [found, harmless]
}

#[test]
fn every_flipped_bit_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.h5");
    let mut numbers = Numbers(1);
    for (kind, table) in [
        ("rays", sample::rays(2, 7)),
        ("deviations", sample::deviations(7)),
        ("exact", sample::exact()),
    ] {
        write(&table, &path).unwrap();
        let sealed = fs::read(&path).unwrap();
        let unsealed = &sealed[..sealed.len() - 40];
        let payload = payload(&path);
        let length: usize = payload.iter().map(Range::len).sum();
        assert!(length > 1000 && length < unsealed.len(), "{length}");
        let in_payload = |bit: usize| payload.iter().any(|range| range.contains(&(bit / 8)));

        let bits: Vec<usize> = (0..1000)
            .map(|_| numbers.below(8 * sealed.len() as u64) as usize)
            .collect();
        let inside = bits.iter().filter(|&&bit| in_payload(bit)).count();
        assert_eq!(
            found(&sealed, bits.into_iter(), &path, &table),
            [1000, 0],
            "{kind}"
        );
        println!(
            "{kind}, sealed: 1000 of 1000 flips found, {inside} of them in the payload ({length} \
            of {} bytes)",
            sealed.len()
        );

        // Without the seal, the checksums of HDF5, the rules and the content hash find the flips.
        let bits: Vec<usize> = (0..1000)
            .map(|_| {
                let mut at = numbers.below(8 * length as u64) as usize;
                for range in &payload {
                    if at < 8 * range.len() {
                        return 8 * range.start + at;
                    }
                    at -= 8 * range.len();
                }
                unreachable!("the place lies in the payload")
            })
            .collect();
        assert!(bits.iter().all(|&bit| in_payload(bit)));
        assert_eq!(
            found(unsealed, bits.into_iter(), &path, &table),
            [1000, 0],
            "{kind}"
        );
        println!("{kind}, without seal: 1000 of 1000 flips in the payload found");
    }
}

/// Flips anywhere in the file, also in the structures of HDF5, where some bits mean nothing.
#[test]
fn without_the_seal_no_flip_changes_the_table_unseen() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.h5");
    let table = sample::rays(2, 7);
    write(&table, &path).unwrap();
    let sealed = fs::read(&path).unwrap();
    let mut numbers = Numbers(2);
    let bits = (0..1000).map(|_| numbers.below(8 * (sealed.len() as u64 - 40)) as usize);
    let [found, harmless] = found(&sealed[..sealed.len() - 40], bits, &path, &table);
    println!("without seal: {found} of 1000 found, {harmless} read back equal");
    assert_eq!(found + harmless, 1000);
    assert!(found > 300, "{found}");
}
