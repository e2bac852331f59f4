//! Tables of versions 1 to 4, as bake wrote them when each version was new. Every later version
//! must read them and give these numbers. Never replace the files; add those of a new version
//! beside them.

use std::path::{Path, PathBuf};

use tables::{Fate, is_sealed, read};

fn kept(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/kept")
        .join(name)
}

/// Table of rays, made by `bake trace triangular.obj --method rays --rays 16384 --bins 16
/// --incidence 0,20 --azimuth 0,30 --refractive-index 1.49 --seed 3`.
#[test]
fn a_table_of_rays_of_version_1() {
    let file = kept("version_1_rays.h5");
    assert!(is_sealed(&file).unwrap());
    let table = read(&file).unwrap();
    assert_eq!(
        table.content_hash(),
        "7dca89b474c6db0ae9d90a6a453b0b8c2369db97394c794fb4fbb1fbef3db4ec"
    );
    assert_eq!(table.axes.incidence_deg, [0.0, 20.0]);
    assert_eq!(table.axes.azimuth_deg, [0.0, 30.0]);
    assert_eq!((table.axes.bins, table.axes.range), (16, 2.0));
    assert!(table.rays.iter().all(|&rays| rays == 16384));
    let counts = table.counts.as_ref().unwrap();
    assert_eq!(counts.shape(), [2, 2, 16, 16, 16]);
    assert_eq!(counts.slice(ndarray::s![1, 1, 0, .., ..]).sum(), 609);
    assert_eq!(counts.slice(ndarray::s![1, 1, .., 7, 8]).sum(), 300);
    // 9718 of 16384 rays return; 300 of them are in the bin.
    assert_eq!(table.retroreflected[[1, 1]], 9718.0 / 16384.0);
    assert_eq!(table.histogram[[1, 1, 7, 8]], 300.0 / 9718.0);
    assert!((table.standard_error[[1, 1]] - 5.486_378_187_071_346e-4).abs() < 1e-18);
    assert_eq!(
        table.fate[[1, 1, Fate::LeftAfter2 as usize]],
        1.0 - 9718.0 / 16384.0
    );
    let provenance = &table.provenance;
    assert_eq!(
        (provenance.generator.as_str(), provenance.design.as_str()),
        ("bake 0.1.0", "triangular")
    );
    assert_eq!((provenance.seed, provenance.refractive_index), (3, 1.49));
}

/// Exact table, made by `bake trace triangular-pair.obj --bins 16 --incidence 0,20 --azimuth 0,30
/// --refractive-index 1.49`.
#[test]
fn an_exact_table_of_version_1() {
    let file = kept("version_1_exact.h5");
    assert!(is_sealed(&file).unwrap());
    let table = read(&file).unwrap();
    assert_eq!(
        table.content_hash(),
        "3dcfce00b42195dcbcd2055af16bae85aa5c61420636473f134caf85e75a5f07"
    );
    // Closed form of an ideal cube, (2/3)(1 - 2 tan^2) with the angle inside, to rounding.
    let inside = (20_f64.to_radians().sin() / 1.49).asin();
    let eta = [2.0 / 3.0, 2.0 / 3.0 * (1.0 - 2.0 * inside.tan().powi(2))];
    for ((i, _), retroreflected) in table.retroreflected.indexed_iter() {
        assert!((retroreflected - eta[i]).abs() < 1e-14);
    }
    assert_eq!(table.retroreflected.dim(), (2, 2));
    let exact = table.exact.as_ref().unwrap();
    assert_eq!(exact.paths.iter().map(Vec::len).collect::<Vec<_>>(), [2; 4]);
    let corners = exact.paths.iter().flatten().map(|path| path.polygon.len());
    assert_eq!(corners.sum::<usize>(), 48);
    assert!((table.histogram[[1, 1, 7, 8]] - 0.030_450_690_031_287_784).abs() < 1e-17);
    assert_eq!((table.rays.sum(), table.counts), (0, None));
}

/// Table with deviations, made by `bake trace uneven.obj --method rays --rays 16384 --bins 16
/// --incidence 0,20 --azimuth 0,30 --refractive-index 1.49 --seed 3`. The mesh was made by `bake
/// design triangular --dihedral-error-mrad 0.4,0,-0.2 -o uneven.obj`.
#[test]
fn a_table_of_rays_of_version_2() {
    let file = kept("version_2_deviations.h5");
    assert!(is_sealed(&file).unwrap());
    let table = read(&file).unwrap();
    assert_eq!(
        table.content_hash(),
        "ee7e38100d3eb762848041cabe31fc6bd434876444fa933f81c705149ec6cdf8"
    );
    let found = table.deviations.as_ref().unwrap();
    assert_eq!((found.grid.cells, found.grid.bins), (16, 4095));
    assert!((found.grid.range - 0.004129209125243509).abs() < 1e-12);
    let entries = &found.entries[3];
    let rays: u64 = entries.iter().map(|entry| entry.rays).sum();
    assert_eq!((entries.len(), rays), (66, 9716));
    assert_eq!((entries[0].place, entries[0].rays), (1147363342, 3));
    let spread = found.spread(3);
    assert!((spread.rms_rad - 0.0011152820360447561).abs() < 1e-15);
    assert!((spread.largest_rad - 0.0013328981055523632).abs() < 1e-15);
}

/// Exact table of version 3, made by `bake trace triangular-pair.obj --bins 16 --range 3
/// --incidence 0,45 --azimuth 0,30 --refractive-index 1.49 --front trapped`.
#[test]
fn an_exact_table_of_version_3() {
    let file = kept("version_3_exact.h5");
    assert!(is_sealed(&file).unwrap());
    let table = read(&file).unwrap();
    assert_eq!(
        table.content_hash(),
        "ffd6a14f4bd59e4251fbfaf7e36dcab041f1302c08a54bb96de8864474ac1732"
    );
    assert_eq!(table.provenance.options.text(), "--front trapped");
    assert_eq!(table.fate.dim(), (2, 2, 11));
    // At normal incidence the closed form; at 45 degrees light of a second cube at azimuth 0 alone.
    assert!((table.retroreflected[[0, 0]] - 2.0 / 3.0).abs() < 1e-14);
    let paths = &table.exact.as_ref().unwrap().paths;
    let passes = |direction: usize| -> Vec<u32> {
        paths[direction].iter().map(|path| path.passes).collect()
    };
    assert_eq!(
        [0, 1, 2, 3].map(passes),
        [vec![0; 2], vec![0; 2], vec![0, 0, 2], vec![0; 2]]
    );
    let area: f64 = paths[2]
        .iter()
        .filter(|path| path.passes == 2)
        .map(|path| path.area())
        .sum();
    let share = area / table.exact.as_ref().unwrap().entrance_area;
    assert!((share - 0.040_550_925_628_2).abs() < 1e-13, "{share}");
    assert!(paths.iter().flatten().all(|path| path.jones.is_none()));
}

/// Exact tables with losses, made by `bake trace triangular-pair.obj --bins 16 --incidence 0,20
/// --azimuth 0,30 --refractive-index 1.49 --losses fresnel --reflectance 0.9`: of version 1, in which
/// light that the front face reflects is absorbed, and of version 4, in which it has its fate.
#[test]
fn exact_tables_with_losses_of_versions_1_and_4() {
    let both = [
        (
            "version_1_lossy.h5",
            10,
            "6915e4095f3353b1e0fc40d37a2d66b27a71fc7daef975101ff8f7ff3273a746",
        ),
        (
            "version_4_exact.h5",
            12,
            "582d09fe5c04d90545206ce4850ed5ca2a20c09685a1418f049d937d0969afd2",
        ),
    ];
    let [older, newer] = both.map(|(name, fates, hash)| {
        let file = kept(name);
        assert!(is_sealed(&file).unwrap());
        let table = read(&file).unwrap();
        assert_eq!(table.content_hash(), hash);
        assert_eq!(table.fate.dim(), (2, 2, fates));
        assert_eq!(table.fates().len(), fates);
        table
    });
    // At normal incidence the front reflects ((n - 1)/(n + 1))^2, and three mirrors keep 0.9^3 of
    // the two thirds that come back.
    let front = (0.49_f64 / 2.49).powi(2);
    let eta = 2.0 / 3.0 * 0.9_f64.powi(3) * (1.0 - front).powi(2);
    assert!((newer.retroreflected[[0, 0]] - eta).abs() < 1e-14);
    assert!((newer.fate[[0, 0, Fate::ReflectedByFront as usize]] - front).abs() < 1e-14);
    let lost = [Fate::Absorbed, Fate::Trapped, Fate::ReflectedByFront];
    for at in ndarray::indices((2, 2)) {
        let of = |table: &tables::Table, fate: Fate| table.fate[[at.0, at.1, fate as usize]];
        let parts: f64 = lost.iter().map(|&fate| of(&newer, fate)).sum();
        assert!((of(&older, Fate::Absorbed) - parts).abs() < 1e-14);
        let left = Fate::LeftAfter2;
        assert!((of(&older, left) - of(&newer, left)).abs() < 1e-14);
    }
    let error = tables::merge(&[older, newer]).unwrap_err().to_string();
    for words in [
        "airr ray-shift table 3",
        "airr ray-shift table 4",
        "bake the table",
    ] {
        assert!(error.contains(words), "{error}");
    }
}
