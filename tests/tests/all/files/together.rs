//! Two bakes that write one file at the same time, while a reader reads it. Both must succeed, and
//! the file must always be the whole table of one of them.

use std::sync::atomic::{AtomicBool, Ordering};

use tests::program::bake;

#[test]
fn two_bakes_to_one_file_leave_one_of_them_whole() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    bake(here, "design triangular -o cell.obj").done();
    let trace = |seed: &str, file: &str| {
        let options =
            format!("--method rays --rays 65536 --bins 64 --seed {seed} --refractive-index 1");
        let words = format!("trace cell.obj -o {file} {options}");
        bake(here, &words).done()
    };
    let inspect = |file: &str| bake(here, &format!("inspect {file}")).done();
    trace("1", "first.h5");
    trace("2", "second.h5");
    let known = [inspect("first.h5"), inspect("second.h5")];
    let bytes = ["first.h5", "second.h5"].map(|file| std::fs::read(here.join(file)).unwrap());
    std::fs::copy(here.join("first.h5"), here.join("table.h5")).unwrap();

    let done = AtomicBool::new(false);
    let mut seen = [0, 0];
    std::thread::scope(|scope| {
        let bakes = ["1", "2"].map(|seed| {
            let trace = &trace;
            scope.spawn(move || (0..10).for_each(|_| drop(trace(seed, "table.h5"))))
        });
        let reader = scope.spawn(|| {
            let mut seen = [0, 0];
            while !done.load(Ordering::Relaxed) {
                let text = inspect("table.h5");
                seen[known
                    .iter()
                    .position(|known| *known == text)
                    .expect("one of the two")] += 1;
            }
            seen
        });
        for bake in bakes {
            bake.join().unwrap();
        }
        done.store(true, Ordering::Relaxed);
        seen = reader.join().unwrap();
    });
    println!("20 bakes, {seen:?} reads of the two tables");
    assert!(seen[0] + seen[1] >= 5, "{seen:?}");
    assert!(bytes.contains(&std::fs::read(here.join("table.h5")).unwrap()));
    let mut left: Vec<_> = std::fs::read_dir(here)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    left.sort();
    assert_eq!(left, ["cell.obj", "first.h5", "second.h5", "table.h5"]);
}
