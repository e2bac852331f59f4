//! Tables of made-up numbers, of every kind that the format knows.

#![allow(dead_code, reason = "each test file takes what it needs")]

use ndarray::{Array2, Array3, Array4, Array5};
use tables::deviation::{Deviations, Grid, counted};
use tables::options::{Back, Front, Losses, Method, Sampler, StatedOptions};
use tables::{Axes, Exact, Fate, Path, Provenance, Table};

/// Generator of reproducible numbers (splitmix64).
pub(crate) struct Numbers(pub u64);

impl Numbers {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(crate) fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

pub(crate) fn provenance() -> Provenance {
    Provenance {
        generator: "bake 0.1.0".to_owned(),
        design: "triangular-pair".to_owned(),
        mesh_hash: "00ff".repeat(16),
        edge_length: 0.08,
        edge_length_unit: "mm".to_owned(),
        azimuth_zero: [1.0, -0.5, 0.25],
        refractive_index: 1.49,
        back: Back::Mirror.into(),
        losses: Losses::None.into(),
        reflectance: 1.0,
        method: Method::Rays.into(),
        sampler: Some(Sampler::Sobol.into()),
        seed: 7,
        angular_tolerance_deg: 0.5,
        tolerance: 0.0,
        lattice: Some([[1.0, 0.0], [0.5, 0.75]]),
        wavelength_nm: None,
        metal_index: None,
        shards: None,
        symmetry: tables::Symmetry::NONE,
        direction_tolerance: None,
        options: StatedOptions::none(),
    }
}

pub(crate) fn axes() -> Axes {
    Axes {
        incidence_deg: vec![0.0, 10.0, 45.5],
        azimuth_deg: vec![0.0, 30.0],
        bins: 8,
        range: 2.0,
    }
}

/// Counts in every direction but the last, where nothing returns.
pub(crate) fn rays(randomisations: usize, seed: u64) -> Table {
    rays_with("", randomisations, seed)
}

/// Counts of a bake with these options.
fn rays_with(options: &str, randomisations: usize, seed: u64) -> Table {
    let mut provenance = provenance();
    provenance.options = options.into();
    let fates = Fate::of(provenance.options.front(), false).len();
    rays_of(provenance, fates, randomisations, seed)
}

/// Counts of a bake of this provenance, with `f` fates.
fn rays_of(mut provenance: Provenance, f: usize, randomisations: usize, seed: u64) -> Table {
    let axes = axes();
    let ((i, j), b) = (axes.shape(), axes.bins);
    let mut numbers = Numbers(seed);
    let mut counts = Array5::from_shape_fn((i, j, randomisations, b, b), |_| numbers.below(1000));
    counts
        .slice_mut(ndarray::s![i - 1, j - 1, .., .., ..])
        .fill(0);
    let mut fates = Array4::from_shape_fn((i, j, randomisations, f), |_| numbers.below(9000));
    for i in 0..i {
        for j in 0..j {
            for r in 0..randomisations {
                fates[[i, j, r, Fate::Retroreflected as usize]] =
                    counts.slice(ndarray::s![i, j, r, .., ..]).sum();
            }
        }
    }
    fates
        .slice_mut(ndarray::s![i - 1, j - 1, .., Fate::OutOfRange as usize])
        .fill(0);
    provenance.seed = seed;
    Table::from_counts(axes, counts, fates, provenance)
}

/// Counts with light that the front face traps.
pub(crate) fn trapped_rays() -> Table {
    rays_with("--front trapped", 2, 5)
}

/// Exact table with light that the front face traps, and with Jones matrices.
pub(crate) fn trapped() -> Table {
    let mut table = exact();
    table.provenance.options = "--front trapped".into();
    let (i, j) = table.axes.shape();
    let mut fate = Array3::zeros((i, j, 11));
    fate.slice_mut(ndarray::s![.., .., ..10])
        .assign(&table.fate);
    for at in ndarray::indices((i, j)) {
        fate[[at.0, at.1, Fate::Trapped as usize]] = 0.25 * fate[[at.0, at.1, 7]];
        fate[[at.0, at.1, Fate::Missed as usize]] *= 0.75;
    }
    table.fate = fate;
    let paths = table.exact.iter_mut().flat_map(|exact| &mut exact.paths);
    for (k, path) in (0_u32..).zip(paths.flatten()) {
        let x = f64::from(k);
        path.passes = k % 3;
        path.jones = Some([[[x, 0.5], [-x, 0.25]], [[0.0, x], [1.0, -0.125]]]);
        // Every third path has no cube.
        let (sine, cosine) = x.sin_cos();
        let cube = [[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]];
        path.cube = (k % 3 != 2).then_some(cube);
    }
    table
}

/// Exact table with losses, whose front face reflects light.
pub(crate) fn lossy() -> Table {
    let mut table = exact();
    table.provenance.losses = Losses::Fresnel.into();
    let (i, j) = table.axes.shape();
    let mut fate = Array3::zeros((i, j, Fate::ALL.len()));
    fate.slice_mut(ndarray::s![.., .., ..10])
        .assign(&table.fate);
    for at in ndarray::indices((i, j)) {
        let missed = fate[[at.0, at.1, Fate::Missed as usize]];
        fate[[at.0, at.1, Fate::Missed as usize]] = 0.5 * missed;
        fate[[at.0, at.1, Fate::Trapped as usize]] = 0.375 * missed;
        fate[[at.0, at.1, Fate::ReflectedByFront as usize]] = 0.125 * missed;
    }
    table.fate = fate;
    table
}

/// Counts with losses behind a front face.
pub(crate) fn lossy_rays() -> Table {
    let mut from = provenance();
    from.losses = Losses::Fresnel.into();
    rays_of(from, Fate::ALL.len(), 2, 6)
}

/// Rays with their deviations, in 4 x 4 cells and 5 x 5 bins.
pub(crate) fn deviations(seed: u64) -> Table {
    let mut table = rays(2, seed);
    let grid = Grid {
        cells: 4,
        bins: 5,
        range: 2e-3,
    };
    let mut numbers = Numbers(seed + 1);
    let counts = table.counts.as_ref().unwrap();
    let (_, azimuths) = table.axes.shape();
    let mut found = Deviations::new(grid, table.retroreflected.len());
    for (direction, entries) in found.entries.iter_mut().enumerate() {
        let mut places = Vec::new();
        let here = ndarray::s![direction / azimuths, direction % azimuths, .., .., ..];
        for ((_, v, u), &rays) in counts.slice(here).indexed_iter() {
            for _ in 0..rays {
                let bin = [(); 2].map(|()| numbers.below(5) as usize);
                places.push(grid.place([v / 2, u / 2], bin));
            }
        }
        *entries = counted(&mut places);
    }
    table.deviations = Some(found);
    table
}

/// Mean over all azimuths.
pub(crate) fn mean() -> Table {
    let source = rays(2, 11);
    let pick = |a: &Array5<u64>| a.slice(ndarray::s![.., ..1, .., .., ..]).to_owned();
    let axes = Axes {
        azimuth_deg: vec![f64::NAN],
        ..source.axes.clone()
    };
    let fates = source
        .fate_counts
        .as_ref()
        .unwrap()
        .slice(ndarray::s![.., ..1, .., ..])
        .to_owned();
    Table::from_counts(
        axes,
        pick(source.counts.as_ref().unwrap()),
        fates,
        source.provenance,
    )
}

/// Exact table whose azimuths stand for their images.
pub(crate) fn symmetric() -> Table {
    let mut table = exact();
    table.provenance.symmetry = tables::Symmetry {
        rotations: 6,
        mirror_deg: Some(0.0),
    };
    table.provenance.direction_tolerance = Some(0.01);
    table.provenance.options = "--normals file".into();
    table
}

/// Exact table with two paths in each direction, and none in the last.
pub(crate) fn exact() -> Table {
    let axes = axes();
    let ((i, j), b) = (axes.shape(), axes.bins);
    let mut provenance = provenance();
    (provenance.method, provenance.sampler) = (Method::Exact.into(), None);
    let mut numbers = Numbers(3);
    let mut paths = Vec::new();
    let mut eta = Array2::zeros((i, j));
    let mut fate = Array3::zeros((i, j, Fate::of(Front::Once, false).len()));
    let mut histogram = Array4::zeros((i, j, b, b));
    for direction in 0..i * j {
        let at = (direction / j, direction % j);
        let empty = direction + 1 == i * j;
        let mut here = Vec::new();
        for _ in 0..if empty { 0 } else { 2 } {
            let size = 0.1 + 0.5 * numbers.unit();
            here.push(Path {
                polygon: vec![
                    [0.0, 0.0],
                    [size, 0.0],
                    [0.5 * size, size],
                    [0.0, 0.5 * size],
                ],
                matrix: [[-2.0, 0.1 * numbers.unit()], [0.0, -2.0]],
                offset: [numbers.unit(), -numbers.unit()],
                weight: 1.0,
                deviation: [1e-3 * numbers.unit(), -1e-3 * numbers.unit()],
                passes: 0,
                jones: None,
                cube: None,
            });
            eta[at] += (0.5 + 0.25 - 0.125 - 0.125 + 0.125) * size * size;
        }
        fate[[at.0, at.1, Fate::Retroreflected as usize]] = eta[at];
        fate[[at.0, at.1, Fate::Missed as usize]] = 1.0 - eta[at];
        if !empty {
            histogram[[at.0, at.1, 1, 2]] = 0.25;
            histogram[[at.0, at.1, 3, 4]] = 0.75;
        }
        paths.push(here);
    }
    Table {
        axes,
        histogram,
        counts: None,
        retroreflected: eta,
        standard_error: Array2::zeros((i, j)),
        fate,
        fate_counts: None,
        rays: Array2::zeros((i, j)),
        deviations: None,
        exact: Some(Exact {
            entrance_area: 1.0,
            paths,
        }),
        provenance,
        passage: None,
        errors_rad: [0.0; 3],
    }
}

/// Python interpreter that `make test` sets up.
pub(crate) fn python() -> std::ffi::OsString {
    std::env::var_os("AIRR_PYTHON").expect(
        "AIRR_PYTHON is not set: run `make test`, which sets up a Python with h5py, xarray and \
        h5netcdf",
    )
}
