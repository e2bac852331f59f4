//! Damaged files: any bytes give an answer and no panic.

use std::path::{Path, PathBuf};

use meshes::{CellOptions, Mesh, gltf, normalise, obj, ply, stl};

/// Number of damaged copies of each file.
///
/// The first run found a panic in the validation of the `gltf` crate. A run with 20,000 copies of
/// each (two million files) found none.
const DAMAGES: usize = 150;

fn files() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files: Vec<PathBuf> = ["tests/good", "tests/bad", "designs"]
        .iter()
        .flat_map(|folder| std::fs::read_dir(root.join(folder)).expect("a folder"))
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| {
            let known = ["obj", "gltf", "glb", "stl", "ply"];
            path.extension()
                .is_some_and(|e| known.iter().any(|known| e == *known))
        })
        .collect();
    files.sort();
    files
}

#[test]
fn damaged_files_get_an_answer() {
    let mut state = 1_u64;
    let mut below = |n: usize| {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 33) as usize % n.max(1)
    };
    let interesting: [&[u8]; 12] = [
        b"-",
        b"9",
        b"e308",
        b"nan",
        b"\n",
        b"f",
        b"v",
        b"\\",
        b"\"",
        b"4294967295",
        b"\xff\xff\xff\xff",
        b"\0\0\0\0",
    ];
    let (mut cases, mut accepted) = (0, 0);
    for path in files() {
        let whole = std::fs::read(&path).expect("a file");
        for _ in 0..DAMAGES {
            let mut bytes = whole.clone();
            for _ in 0..1 + below(4) {
                let at = below(bytes.len());
                match below(8) {
                    // Half of the damage is to numbers, because such files get furthest.
                    4.. => {
                        if let Some(digit) = (at..bytes.len()).find(|&i| bytes[i].is_ascii_digit())
                        {
                            bytes[digit] = b'0' + below(10) as u8;
                        }
                    }
                    0 => bytes.truncate(at),
                    1 if !bytes.is_empty() => bytes[at] ^= 1 << below(8),
                    2 => drop(bytes.splice(
                        at..at,
                        interesting[below(interesting.len())].iter().copied(),
                    )),
                    _ => {
                        let end = (at + below(6)).min(bytes.len());
                        drop(bytes.splice(
                            at..end,
                            interesting[below(interesting.len())].iter().copied(),
                        ));
                    }
                }
            }
            let extension = path.extension().and_then(|e| e.to_str());
            let mesh: Result<Mesh, _> = match extension {
                Some("obj") => obj::parse(&bytes),
                Some("stl") => stl::parse(&bytes),
                Some("ply") => ply::parse(&bytes),
                _ => gltf::parse(&bytes, None),
            };
            cases += 1;
            let Ok(mesh) = mesh else { continue };
            if let Ok(cell) = normalise(&mesh, &path, &CellOptions::default()) {
                accepted += 1;
                let finite = cell.facets.iter().flatten().all(|p| p.is_finite());
                assert!(
                    finite && cell.edge_length > 0.0 && cell.entrance.height.is_finite(),
                    "{}",
                    path.display()
                );
                assert!(
                    cell.entrance.polygon.len() >= 3
                        && cell.entrance.polygon.iter().all(|p| p.is_finite())
                );
            }
        }
    }
    println!("{cases} damaged files, {accepted} still a cell");
    assert!(
        cases >= DAMAGES * 120 && accepted > DAMAGES,
        "{cases} {accepted}"
    );
}
