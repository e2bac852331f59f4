//! Several programs at one file: each reader gets the old table or the new one, whole.

use crate::sample;

use std::sync::atomic::{AtomicBool, Ordering};

use tables::{read, write};

#[test]
fn a_read_during_a_write_gets_one_of_the_tables() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("table.h5");
    // The tables have different lengths, so that a mixture would show.
    let tables = [sample::rays(1, 7), sample::rays(3, 8)];
    write(&tables[0], &file).unwrap();
    let done = AtomicBool::new(false);
    let mut seen = [0, 0];
    std::thread::scope(|scope| {
        let writers = [0, 1].map(|which| {
            let (table, file) = (&tables[which], &file);
            scope.spawn(move || (0..100).for_each(|_| write(table, file).unwrap()))
        });
        let reader = scope.spawn(|| {
            let mut seen = [0, 0];
            while !done.load(Ordering::Relaxed) {
                let table = read(&file).unwrap();
                let which = tables.iter().position(|known| *known == table);
                seen[which.expect("one of the two, whole")] += 1;
            }
            seen
        });
        for writer in writers {
            writer.join().unwrap();
        }
        done.store(true, Ordering::Relaxed);
        seen = reader.join().unwrap();
    });
    println!("200 writes, {seen:?} reads of the two tables");
    assert!(seen[0] + seen[1] >= 20, "{seen:?}");
    let left = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(left, 1, "a temporary file was left");
}
