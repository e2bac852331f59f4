//! The light and the pixels of one simulated photograph.
//!
//! The computation is independent of the estimator on purpose. Shifts are in closed form rather
//! than from a table, blurs are convolved in space rather than multiplied as OTFs, and each
//! photograph is one profile evaluated at pixel centres.
//!
//! In a photograph x runs to the right, y downward, and the origin is the centre of the picture.
//! The edge normal points from dark to bright. `offset_px` moves the edge along the rows by that
//! many columns to the left.
//!
//! The level of a pixel is veil + exposure x contrast x light x (dark_ratio + (1 - dark_ratio)
//! E(s)). The contrast is source_level for the reference, and source_level x mu x eta x T x R of
//! the half mirror for a capture. The photograph then gets shot noise and read noise in electrons,
//! is sharpened if the camera does so, is rounded to the converter's steps, and is clipped to [0, 1]. It may then go through JPEG.

use crate::simulate::camera::PlantedCamera;
use crate::simulate::cell;
use crate::simulate::cell::CubeShift;
use crate::simulate::error::Error;
use crate::simulate::jpeg;
use crate::simulate::noise::PixelNoise;
use crate::simulate::params::{ByIncidence, Params, PlantedEdge};
use crate::simulate::params::{PlantedSheet, no_entry};
use crate::simulate::profile::{EdgeBlur, EdgeProfile, LensBlur, STEPS_PER_PIXEL, Spread};
use edges::document::FileLine;
use edges::names::Kernel;
use edges::names::LobeShape;
use edges::names::{SpectralLine, Spectrum};

/// Returns the light on each pixel without noise, rounding or clipping, full scale 1, row-major.
///
/// `index` names a capture; `None` means the reference (a default edge if the campaign has no
/// reference). The values are accurate to 1e-6 of the contrast.
///
/// # Errors
/// Returns [`Error::Params`] if a table by incidence lacks the incidence of the capture (never
/// after [`Params::load`]), and [`Error::Unplanted`] if the kernel or the lobe is that of a
/// baseline.
///
/// # Panics
/// Panics if `index` is not below the number of captures.
pub(crate) fn light(params: &Params, index: Option<usize>) -> Result<Vec<f64>, Error> {
    smeared(params, index, &[(0.0, 1.0)])
}

/// Returns the same where the light of each point is displaced along the edge normal: by some
/// offsets (pixels), with their shares.
///
/// # Errors
/// Fails as [`light`] does.
pub(crate) fn smeared(
    params: &Params,
    index: Option<usize>,
    offsets_px: &[(f64, f64)],
) -> Result<Vec<f64>, Error> {
    let camera = &params.camera;
    let (edge, blur, contrast) = match index {
        None => {
            let edge = params.reference.unwrap_or(PlantedEdge::SOURCE);
            (edge, source_blur(camera, &edge), camera.source_level)
        }
        Some(index) => {
            let (blur, contrast) = aerial_blur(params, index)?;
            (params.captures[index].edge, blur, contrast)
        }
    };
    let pitch = camera.pixel_pitch_mm;
    let (sin, cos) = edge.normal_deg.to_radians().sin_cos();
    let (centre_x, centre_y) = (
        0.5 * (camera.width as f64 - 1.0),
        0.5 * (camera.height as f64 - 1.0),
    );
    let distance_mm = |x: usize, y: usize| {
        let (x, y) = (x as f64 - centre_x + edge.offset_px, y as f64 - centre_y);
        let (across, along) = (x * cos + y * sin, y * cos - x * sin);
        nearest(&edge, camera.height as f64, across, along) * pitch
    };
    let bent = edge.bow_px.abs() + edge.ripple_px.abs();
    let farthest = offsets_px.iter().map(|(offset, _)| offset.abs());
    let farthest = farthest.fold(0.0, f64::max);
    let reach_mm = (centre_x.hypot(centre_y) + edge.offset_px.abs() + bent + farthest) * pitch;
    let profile = EdgeProfile::new(&blur, reach_mm, STEPS_PER_PIXEL);
    let (to_right, to_bottom) = (edge.light_to_right, edge.light_to_bottom);
    let risen = |distance_mm: f64| -> f64 {
        let parts = offsets_px.iter();
        parts
            .map(|(offset, share)| share * profile.at(distance_mm - offset * pitch))
            .sum()
    };
    let level = |(x, y): (usize, usize)| {
        let share = camera.dark_ratio + (1.0 - camera.dark_ratio) * risen(distance_mm(x, y));
        let light = 1.0
            + to_right * (x as f64 - centre_x) / centre_x
            + to_bottom * (y as f64 - centre_y) / centre_y;
        let field2 = ((x as f64 - centre_x).powi(2) + (y as f64 - centre_y).powi(2))
            / (centre_x * centre_x + centre_y * centre_y);
        // cos^4 of an angle whose tangent grows with the distance from the middle.
        let corner = (1.0 - edge.vignetting).powf(-0.5) - 1.0;
        let light = light / (1.0 + corner * field2).powi(2);
        camera.veil + edge.exposure * contrast * light * share
    };
    Ok((0..camera.height)
        .flat_map(|y| (0..camera.width).map(move |x| (x, y)))
        .map(level)
        .collect())
}

/// Returns the distance (pixels) of a place from the edge, which may follow an arc and a wave over
/// `length` pixels. `across` and `along` are the distances from the edge's line and along it.
///
/// The distance is that of the nearest point, found by steps along the curve. Each step leaves a
/// share (slope^2 + distance x curvature) of the error, 2 % for a bow of 3 px.
fn nearest(edge: &PlantedEdge, length: f64, across: f64, along: f64) -> f64 {
    if edge.bow_px == 0.0 && edge.ripple_px == 0.0 {
        return across;
    }
    let half = 0.5 * length;
    let turn = std::f64::consts::TAU / length;
    let curve = |t: f64| {
        let (mut height, mut slope) = (
            edge.ripple_px * (turn * t + 0.7).sin(),
            edge.ripple_px * turn * (turn * t + 0.7).cos(),
        );
        if edge.bow_px != 0.0 {
            let radius = (half * half + edge.bow_px * edge.bow_px) / (2.0 * edge.bow_px);
            let root = (radius * radius - t * t).max(1.0).sqrt();
            height += radius - root * radius.signum();
            slope += t / root * radius.signum();
        }
        (height, slope)
    };
    let mut foot = along;
    for _ in 0..8 {
        let (height, slope) = curve(foot);
        foot = along + (across - height) * slope;
    }
    let (height, slope) = curve(foot);
    (across - height) * slope.hypot(1.0)
}

/// Returns the pixels of a photograph with noise, rounded and clipped. They depend on the
/// parameters and `index` alone.
///
/// # Errors
/// Returns [`Error::Params`] if a table by incidence lacks the incidence of the capture (never
/// after [`Params::load`]), and [`Error::Unplanted`] if the kernel or the lobe is that of a
/// baseline.
///
/// # Panics
/// Panics if `index` is not below the number of captures.
pub(crate) fn photograph(params: &Params, index: Option<usize>) -> Result<Vec<f32>, Error> {
    Ok(exposed(params, index, light(params, index)?))
}

/// Returns the pixels of a photograph of this light, with noise, rounded and clipped.
pub(crate) fn exposed(params: &Params, index: Option<usize>, light: Vec<f64>) -> Vec<f32> {
    let camera = &params.camera;
    let steps = ((1_u64 << camera.bits) - 1) as f64;
    let number = index.map_or(0, |index| index as u64 + 1);
    let expose = |(pixel, level): (usize, f64)| {
        let mut noise = PixelNoise::new(params.seed, number, pixel as u64);
        let electrons =
            noise.poisson(level * camera.full_well_e) + camera.read_noise_e * noise.normal();
        let is_hot = camera.hot_share > 0.0 && noise.uniform() < camera.hot_share;
        if is_hot {
            1.0
        } else {
            electrons / camera.full_well_e
        }
    };
    let pixels = light.into_iter().enumerate();
    let mut levels: Vec<f64> = pixels.map(expose).collect();
    if camera.sharpening > 0.0 {
        levels = sharpened(&levels, camera);
    }
    let stored = |level: f64| (level.clamp(0.0, 1.0) * steps).round() / steps;
    levels
        .into_iter()
        .map(|level| stored(level) as f32)
        .collect()
}

/// Adds a share of the difference between each pixel and the mean of the 3 x 3 pixels about it. The
/// border is repeated.
fn sharpened(levels: &[f64], camera: &PlantedCamera) -> Vec<f64> {
    let (width, height) = (camera.width, camera.height);
    let mean = |i: usize| {
        let (x, y) = (i % width, i / width);
        let rows = [y.saturating_sub(1), y, (y + 1).min(height - 1)];
        let columns = [x.saturating_sub(1), x, (x + 1).min(width - 1)];
        let all = rows
            .iter()
            .flat_map(|y| columns.map(|x| levels[y * width + x]));
        all.sum::<f64>() / 9.0
    };
    let pixels = levels.iter().enumerate();
    pixels
        .map(|(i, level)| level + camera.sharpening * (level - mean(i)))
        .collect()
}

/// Returns the pixels of a photograph as its file has them: those of [`photograph`], through JPEG
/// if the camera saves JPEG.
///
/// # Errors
/// Returns the errors of [`photograph`], and [`Error::Jpeg`] if JPEG cannot hold the photograph.
pub(crate) fn saved(params: &Params, index: Option<usize>) -> Result<Vec<f32>, Error> {
    let pixels = photograph(params, index)?;
    let camera = &params.camera;
    let Some(quality) = camera.jpeg_quality else {
        return Ok(pixels);
    };
    let bytes = jpeg::packed(&pixels, [camera.width, camera.height], quality)?;
    Ok(jpeg::unpacked(&bytes)?)
}

fn source_blur(camera: &PlantedCamera, edge: &PlantedEdge) -> EdgeBlur {
    let normal_rad = edge.normal_deg.to_radians();
    // Variances of an elliptic Gaussian along its axes add up along a normal.
    let sigma_px = camera.sigma_down_px.map_or(camera.sigma_px, |down| {
        let (sin, cos) = normal_rad.sin_cos();
        (camera.sigma_px * cos).hypot(down * sin)
    });
    EdgeBlur {
        normal_rad,
        normal_in_picture_rad: normal_rad,
        spread: Spread::None,
        shifts: Vec::new(),
        scale_mm: [0.0, 0.0],
        pixel_pitch_mm: camera.pixel_pitch_mm,
        lens: LensBlur {
            sigma_mm: sigma_px * camera.pixel_pitch_mm,
            pupil_cutoff_per_mm: camera
                .pupil_cutoff_per_px
                .map(|cutoff| cutoff / camera.pixel_pitch_mm),
            halo_share: camera.halo_share,
            halo_mm: camera.halo_px * camera.pixel_pitch_mm,
        },
    }
}

/// Returns the standard deviation of the offset that the angular spread of a sheet causes along the
/// edge normal, mm.
///
/// Behind a flat front, the direction is spread more in the plane of incidence: the cosine of the
/// angle within the sheet, divided by that outside.
fn angular_offset_mm(truth: &PlantedSheet, incidence_rad: f64, normal_rad: f64, r_mm: f64) -> f64 {
    let within_rad = (incidence_rad.sin() / truth.refractive_index).asin();
    let gain = within_rad.cos() / incidence_rad.cos();
    let across_mm = 1e-3 * truth.angular_spread_mrad * r_mm;
    across_mm * (gain * normal_rad.cos()).hypot(normal_rad.sin())
}

/// Returns the blur of a capture, and its bright level at exposure 1 without the veil.
fn aerial_blur(params: &Params, index: usize) -> Result<(EdgeBlur, f64), Error> {
    let (camera, truth, shot) = (&params.camera, &params.truth, &params.captures[index]);
    let look_up = |key: &'static str, values: &ByIncidence| {
        values.at(shot.incidence_deg).ok_or_else(|| {
            let (file, line) = ("parameters".into(), index + 1);
            no_entry(FileLine { file, line }, key, shot.incidence_deg)
        })
    };
    let (a, mu) = (look_up("a", &truth.a)?, look_up("mu", &truth.mu)?);
    let incidence_rad = shot.incidence_deg.to_radians();
    let sum = |shifts: &[CubeShift]| shifts.iter().map(|part| part.retroreflected).sum::<f64>();
    let (shifts, eta) = match &shot.shifts {
        Some(shifts) => (shifts.clone(), sum(shifts)),
        None => {
            let azimuth_rad = shot.azimuth_deg.to_radians();
            let cubes = cell::shifts(
                incidence_rad,
                azimuth_rad,
                truth.refractive_index,
                truth.pair,
            );
            let eta = sum(&cubes) / cubes.len() as f64;
            (cubes, eta)
        }
    };
    let half_mirror = camera.half_mirror_transmittance * camera.half_mirror_reflectance;
    let contrast = camera.source_level * mu * eta * half_mirror;
    let r_mm = shot.path_mm.unwrap_or(shot.floating_distance_mm);
    let a_per_mm = match truth.kernel {
        Kernel::Angular => a / r_mm,
        _ => a,
    };
    let spread = match (truth.kernel, truth.lobe) {
        (Kernel::Shift, _) => Spread::None,
        (Kernel::Wave, _) => {
            let lines = truth.spectrum.iter().flat_map(Spectrum::lines);
            let total: f64 = lines.clone().map(|line| line.weight).sum();
            let line =
                |line: &SpectralLine| (line.wavelength_nm * 1e-6 * r_mm, line.weight / total);
            Spread::Wave {
                lines: lines.map(line).collect(),
            }
        }
        (kernel, shape) if kernel.is_baseline() || !LobeShape::ALL.contains(&shape) => {
            return Err(Error::Unplanted { kernel });
        }
        (_, shape) => Spread::Lobe { shape, a_per_mm },
    };
    let source = source_blur(camera, &shot.edge);
    let in_picture_rad = (shot.edge.normal_deg - shot.tangential_axis_deg).to_radians();
    // From the tangential axis towards the sagittal one, which runs down only in the mirror.
    let normal_rad = if camera.seen_in_mirror {
        in_picture_rad
    } else {
        -in_picture_rad
    };
    let offset_mm = angular_offset_mm(truth, incidence_rad, normal_rad, r_mm);
    let blur = EdgeBlur {
        normal_rad,
        // Two independent normal offsets add up to one.
        lens: LensBlur {
            sigma_mm: source.lens.sigma_mm.hypot(offset_mm),
            ..source.lens
        },
        spread,
        shifts: if truth.kernel == Kernel::Lobe {
            Vec::new()
        } else {
            shifts
        },
        scale_mm: [truth.c_mm * incidence_rad.cos(), truth.c_mm],
        ..source
    };
    Ok((blur, contrast))
}
