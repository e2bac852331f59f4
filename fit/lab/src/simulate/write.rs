//! Writing of a simulated campaign: photographs, truth.json and captures.toml.
//!
//! A folder that has captures.toml is whole: the manifest is the first file that goes and the last
//! that comes.

use std::fmt::Write as _;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage,
};
use serde_json::json;
use tempfile::TempDir;

use crate::simulate::error::Error;
use crate::simulate::jpeg;
use crate::simulate::params::{Params, PlantedShot};
use crate::simulate::photograph::photograph;

/// Name of the manifest.
const MANIFEST: &str = "captures.toml";

/// A summary of the files that were written.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Path of the manifest.
    pub manifest: PathBuf,
    /// Number of photographs, the reference included.
    pub photographs: usize,
    /// Number of pixels at full scale, over all photographs.
    pub clipped: usize,
    /// Warnings about the campaign, one sentence each.
    pub warnings: Vec<String>,
}

/// Simulates a campaign into `folder`, which is created. The same parameters give the same bytes.
///
/// All files are made in a temporary folder beside `folder`. If there is no `folder` yet, the
/// temporary one is renamed, in one step. Else an old manifest is removed, the files are moved one
/// by one, and the manifest comes last. So a folder that has a manifest is whole, whenever the
/// program is killed.
///
/// # Errors
/// Returns [`Error::NotEmpty`] if the folder holds anything and `force` is not set,
/// [`Error::Write`] if a file or folder cannot be written, and
/// [`Error::Params`] or [`Error::Unplanted`] for parameters built in code that cannot be
/// simulated.
pub fn run(params: &Params, folder: &Path, force: bool) -> Result<Report, Error> {
    let cannot = |file: &Path| {
        let file = file.to_owned();
        move |source| Error::Write { file, source }
    };
    if folder.exists() && !force {
        let mut entries = std::fs::read_dir(folder).map_err(cannot(folder))?;
        if entries.next().is_some() {
            return Err(Error::NotEmpty {
                folder: folder.to_owned(),
            });
        }
    }
    let parent = folder
        .parent()
        .filter(|path| !path.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    std::fs::create_dir_all(parent).map_err(cannot(parent))?;
    let scratch = tables::scratch_folder(parent).map_err(cannot(parent))?;

    let mut report = Report {
        manifest: folder.join(MANIFEST),
        photographs: 0,
        clipped: 0,
        warnings: Vec::new(),
    };
    let mut names = Vec::new();
    if params.reference.is_some() {
        names.push(source_name(params));
        save(
            params,
            None,
            &scratch.path().join(source_name(params)),
            &mut report,
        )?;
    }
    for (index, shot) in params.captures.iter().enumerate() {
        let name = image_name(params, index, shot);
        save(
            params,
            Some(index),
            &scratch.path().join(&name),
            &mut report,
        )?;
        names.push(name);
    }
    for (name, text) in [("truth.json", truth(params)), (MANIFEST, manifest(params))] {
        let file = scratch.path().join(name);
        std::fs::write(&file, text).map_err(cannot(&file))?;
        names.push(name.to_owned());
    }
    put(&scratch, folder, &names)?;
    if report.clipped > 0 {
        report.warnings.push(format!(
            "{} pixels are clipped at full scale; lower `exposure`.",
            report.clipped
        ));
    }
    Ok(report)
}

/// Moves the files of a temporary folder to their place, the last of `names` last.
///
/// # Errors
/// Returns [`Error::Write`] if a file or folder cannot be moved.
fn put(scratch: &TempDir, folder: &Path, names: &[String]) -> Result<(), Error> {
    let cannot = |file: &Path| {
        let file = file.to_owned();
        move |source| Error::Write { file, source }
    };
    if !folder.exists() {
        return std::fs::rename(scratch.path(), folder).map_err(cannot(folder));
    }
    let manifest = folder.join(MANIFEST);
    match std::fs::remove_file(&manifest) {
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(cannot(&manifest)(error)),
        _ => {}
    }
    for name in names {
        let target = folder.join(name);
        std::fs::rename(scratch.path().join(name), &target).map_err(cannot(&target))?;
    }
    Ok(())
}

fn save(
    params: &Params,
    index: Option<usize>,
    file: &Path,
    report: &mut Report,
) -> Result<(), Error> {
    let pixels = photograph(params, index)?;
    report.photographs += 1;
    report.clipped += pixels.iter().filter(|&&value| value >= 1.0).count();
    if let Some(quality) = params.camera.jpeg_quality {
        let size = [params.camera.width, params.camera.height];
        let bytes = jpeg::packed(&pixels, size, quality)?;
        return std::fs::write(file, bytes).map_err(|source| Error::Write {
            file: file.to_owned(),
            source,
        });
    }
    let channel = AnyChannel::new("Y", FlatSamples::F32(pixels));
    let size = (params.camera.width, params.camera.height);
    let channels = AnyChannels::sort(std::iter::once(channel).collect());
    let layer = Layer::new(
        size,
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        channels,
    );
    let written = Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_file(file);
    written.map_err(|source| Error::Write {
        file: file.to_owned(),
        source: std::io::Error::other(source),
    })
}

/// Returns the extension of the photographs.
fn extension(params: &Params) -> &'static str {
    match params.camera.jpeg_quality {
        Some(_) => "jpg",
        None => "exr",
    }
}

fn source_name(params: &Params) -> String {
    format!("source.{}", extension(params))
}

fn image_name(params: &Params, index: usize, shot: &PlantedShot) -> String {
    let from_axis = (shot.edge.normal_deg - shot.tangential_axis_deg).to_radians();
    let axis = if from_axis.cos().abs() >= from_axis.sin().abs() {
        "tan"
    } else {
        "sag"
    };
    format!(
        "aerial_{:03}_{}mm_{:02}deg_{axis}.{}",
        index + 1,
        shot.floating_distance_mm,
        shot.incidence_deg,
        extension(params)
    )
}

fn manifest(params: &Params) -> String {
    let camera = &params.camera;
    let mut text = format!(
        "[setup]\npixel_pitch_mm = {}\nseen_in_mirror = {}\nhalf_mirror_transmittance = {}\n\
        half_mirror_reflectance = {}\n",
        camera.pixel_pitch_mm,
        camera.seen_in_mirror,
        camera.half_mirror_transmittance,
        camera.half_mirror_reflectance
    );
    // Writing to a String cannot fail.
    if let Some(spectrum) = &params.truth.spectrum {
        let _ = writeln!(text, "wavelength_nm = \"{spectrum}\"");
    }
    if let Some(edge) = params.reference {
        let _ = write!(
            text,
            "\n[reference]\nimage = \"{}\"\nexposure = {}\n",
            source_name(params),
            edge.exposure
        );
    }
    for (index, shot) in params.captures.iter().enumerate() {
        let _ = write!(
            text,
            "\n[[capture]]\nimage = \"{}\"\nfloating_distance_mm = {}\nincidence_deg = {}\n\
            azimuth_deg = {}\nexposure = {}\n",
            image_name(params, index, shot),
            shot.floating_distance_mm,
            shot.incidence_deg,
            shot.azimuth_deg,
            shot.edge.exposure
        );
        if let Some(path_mm) = shot.path_mm {
            let _ = writeln!(text, "path_mm = {path_mm}");
        }
        if shot.tangential_axis_deg != 0.0 {
            let _ = writeln!(text, "tangential_axis_deg = {}", shot.tangential_axis_deg);
        }
    }
    text
}

fn truth(params: &Params) -> String {
    let mut truth = json!(params.truth);
    truth["ior"] = json!(params.truth.refractive_index); // the name of 0.1
    let document = json!({
        "seed": params.seed,
        "camera": params.camera,
        "truth": truth,
        "captures": params.captures,
    });
    format!("{document:#}\n")
}
