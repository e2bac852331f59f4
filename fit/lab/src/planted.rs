//! Planted answers for tests: simulated photographs and the closed-form table of the ideal cube,
//! without `bake`.

use crate::simulate::cell;
use crate::simulate::{ByIncidence, Params, PlantedCamera, PlantedEdge, PlantedSheet, PlantedShot};
use edges::names::Kernel;
use edges::names::LobeShape;
use edges::names::Spectrum;
pub use edges::numerics::Stream;
use edges::photographs::manifest::captures;
use edges::photographs::photo::plane::Photo;
use edges::photographs::photo::taken::Taken;
use estimator::estimate::search::optimum::optimum;
use estimator::estimate::{Choice, Estimate, Kind, Loss, Scene, estimate, refined};
use estimator::model::Further;
use ndarray::{Array2, Array3, Array4};
use tables::options::{Back, Losses, Method, StatedOptions};
use tables::{Axes, Exact, Path, Provenance, Table};

/// Returns the exact table of the ideal cell from the closed form: shift polygons as paths, empty
/// bins.
#[allow(clippy::too_many_lines, reason = "most of it is one literal")]
pub fn table(truth: &PlantedSheet, incidence_deg: &[f64], azimuth_deg: f64) -> Table {
    let n = incidence_deg.len();
    let cubes = if truth.pair { 2.0 } else { 1.0 };
    let mut paths = Vec::new();
    let mut retroreflected = Array2::zeros((n, 1));
    for (i, incidence) in incidence_deg.iter().enumerate() {
        let shifts = cell::shifts(
            incidence.to_radians(),
            azimuth_deg.to_radians(),
            truth.refractive_index,
            truth.pair,
        );
        retroreflected[[i, 0]] = shifts.iter().map(|s| s.retroreflected).sum::<f64>() / cubes;
        // A ray that enters at p is shifted by 2 (q - p). The place of the cubes in the cell has no
        // effect.
        let edge = |angle: f64| {
            let (sine, cosine) = (angle - azimuth_deg.to_radians()).sin_cos();
            let [across, up] = [2.0, 1.0].map(|part: f64| (part / 3.0).sqrt());
            [across * cosine, across * sine, up]
        };
        let path = |(k, shifts): (usize, Vec<[f64; 2]>)| {
            let half_turn = k as f64 * std::f64::consts::PI;
            let q = [3.0 * k as f64, 0.5];
            Path {
                polygon: shifts
                    .iter()
                    .map(|s| [q[0] - 0.5 * s[0], q[1] - 0.5 * s[1]])
                    .collect(),
                matrix: [[-2.0, 0.0], [0.0, -2.0]],
                offset: q.map(|q| 2.0 * q),
                weight: 1.0,
                deviation: [0.0; 2],
                passes: 0,
                jones: None,
                cube: Some(
                    [0.0, 1.0, 2.0].map(|j| edge(half_turn + j * std::f64::consts::TAU / 3.0)),
                ),
            }
        };
        paths.push(
            shifts
                .into_iter()
                .map(|s| s.polygon)
                .enumerate()
                .filter(|(_, p)| p.len() > 2)
                .map(path)
                .collect(),
        );
    }
    Table {
        axes: Axes {
            incidence_deg: incidence_deg.to_vec(),
            azimuth_deg: vec![azimuth_deg],
            bins: 4,
            range: 2.0,
        },
        histogram: Array4::zeros((n, 1, 4, 4)),
        counts: None,
        retroreflected,
        standard_error: Array2::zeros((n, 1)),
        fate: Array3::zeros((n, 1, 10)),
        fate_counts: None,
        rays: Array2::zeros((n, 1)),
        // A shift polygon has four times the area of its entrance polygon.
        deviations: None,
        exact: Some(Exact {
            entrance_area: 4.0 * cubes * 0.75_f64.sqrt(),
            paths,
        }),
        passage: None,
        errors_rad: [0.0; 3],
        provenance: Provenance {
            generator: "closed form".into(),
            design: "ideal".into(),
            mesh_hash: "0".repeat(64),
            edge_length: 1.0,
            edge_length_unit: "file unit".into(),
            azimuth_zero: [1.0, 0.0, 0.0],
            refractive_index: truth.refractive_index,
            back: Back::Mirror.into(),
            losses: Losses::None.into(),
            reflectance: 1.0,
            method: Method::Exact.into(),
            sampler: None,
            seed: 0,
            angular_tolerance_deg: 0.5,
            tolerance: 0.0,
            lattice: None,
            wavelength_nm: None,
            metal_index: None,
            shards: None,
            symmetry: tables::Symmetry::NONE,
            direction_tolerance: None,
            options: StatedOptions::none(),
        },
    }
}

/// Returns an exact table in which the light of path `k` of each direction has the deviation
/// `of(k)`.
pub fn deviating(mut table: Table, of: impl Fn(usize) -> [f64; 2]) -> Table {
    let directions = table.exact.iter_mut().flat_map(|exact| &mut exact.paths);
    for paths in directions {
        for (k, path) in paths.iter_mut().enumerate() {
            path.deviation = of(k);
        }
    }
    table
}

/// Returns a camera of few pixels, which sees the sheet in the mirror.
pub fn camera(full_well_e: f64) -> PlantedCamera {
    PlantedCamera {
        width: 192,
        height: 128,
        pixel_pitch_mm: 0.08,
        seen_in_mirror: true,
        sigma_px: 0.55,
        sigma_down_px: None,
        pupil_cutoff_per_px: None,
        halo_share: 0.0,
        halo_px: 20.0,
        sharpening: 0.0,
        source_level: 0.9,
        half_mirror_transmittance: 0.5,
        half_mirror_reflectance: 0.5,
        veil: 0.004,
        dark_ratio: 0.01,
        full_well_e,
        read_noise_e: 3.0,
        bits: 14,
        hot_share: 0.0,
        jpeg_quality: None,
    }
}

/// Returns a campaign over the given incidences and distances. The edges are tilted by varied
/// angles.
pub fn params(
    seed: u64,
    truth: PlantedSheet,
    incidence_deg: &[f64],
    distance_mm: &[f64],
    camera: PlantedCamera,
) -> Params {
    let mut stream = Stream(seed);
    let mut captures = Vec::new();
    for &incidence_deg in incidence_deg {
        for &floating_distance_mm in distance_mm {
            let edge = PlantedEdge {
                normal_deg: stream.between(4.0, 9.0),
                offset_px: stream.between(-1.0, 1.0),
                exposure: 4.0,
                ..PlantedEdge::AERIAL
            };
            captures.push(PlantedShot {
                edge,
                floating_distance_mm,
                path_mm: None,
                incidence_deg,
                azimuth_deg: 20.0,
                tangential_axis_deg: 0.0,
                shifts: None,
            });
        }
    }
    Params {
        seed,
        camera,
        truth,
        reference: Some(PlantedEdge::SOURCE),
        captures,
    }
}

/// Returns the truth of a campaign.
pub fn truth(kernel: Kernel, lobe: LobeShape, a: f64, c_mm: f64, mu: f64) -> PlantedSheet {
    PlantedSheet {
        kernel,
        lobe,
        spectrum: (kernel.has_waves()).then(|| Spectrum::parse("550").expect("one line")),
        refractive_index: 1.49,
        pair: true,
        a: ByIncidence::Shared(a),
        c_mm,
        angular_spread_mrad: 0.0,
        mu: ByIncidence::Shared(mu),
    }
}

/// Simulates the campaign on disk and measures it in the same way as the program.
pub fn scene(params: &Params, table: &Table) -> Scene {
    let folder = tempfile::tempdir().expect("a temporary folder");
    crate::simulate::run(params, folder.path(), true).expect("the campaign can be written");
    let campaign =
        captures::load(&folder.path().join("captures.toml")).expect("the manifest is valid");
    Scene::load(&campaign, table).expect("the photographs hold edges")
}

/// One a and one mu for all angles, by the literal Eq. (1) with a radial lobe.
pub const SHARED: Choice = Choice {
    kernel: Kernel::Eq1,
    shape: LobeShape::Radial,
    per_angle_a: false,
    per_angle_mu: false,
    further: Further::NONE,
};

/// Fits `choice` to a scene by a loss.
pub fn fitted(scene: &Scene, choice: Choice, kind: Kind) -> Estimate {
    let start = optimum(scene, choice);
    let loss = Loss::new(kind, scene, (choice, &start.solution.parameters));
    estimate(scene, &loss, refined(scene, &loss, start))
}

/// Returns a photograph whose pixel (x, y) has the given light.
pub fn photo(width: usize, height: usize, light: impl Fn(f64, f64) -> f64) -> Photo {
    let at = |i: usize| light((i % width) as f64, (i / width) as f64) as f32;
    Photo {
        width,
        height,
        luminance: (0..width * height).map(at).collect(),
        clip_level: Some(1.0),
        clips_alone: true,
        transfer: Taken::default(),
        warnings: Vec::new(),
    }
}

/// Adds normal noise of a standard deviation.
pub fn with_noise(mut photo: Photo, seed: u64, deviation: f64) -> Photo {
    let mut stream = Stream(seed);
    for value in &mut photo.luminance {
        *value += (deviation * stream.normal()) as f32;
    }
    photo
}

/// Share of a Gaussian below s.
pub fn rise(s: f64, sigma: f64) -> f64 {
    0.5 * libm::erfc(-s / sigma / std::f64::consts::SQRT_2)
}
