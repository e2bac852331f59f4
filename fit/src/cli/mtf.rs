//! `fit mtf`: measures the slanted-edge MTF of one photograph.

use std::fmt::Write;
use std::path::PathBuf;
use tables::cli as terminal;

use serde::Serialize;
use tables::Outputs;

use crate::cli::failure::Failure;
use crate::cli::output;
use crate::cli::parse;
use crate::photographs::Measurement;
use crate::photographs::Roi;
use crate::photographs::edge::accepted::Accepted;
use crate::photographs::measure;
use crate::photographs::photo;
use crate::photographs::photo::channel::{Channel, Decode};
use crate::photographs::photo::plane::Photo;
use crate::photographs::photo::transfer::Transfer;
use crate::photographs::sfr;
use crate::photographs::{Estimator, crossing};

/// Number of points of the curve, from frequency 0 to the sampling frequency.
const POINTS: usize = 512;

/// Measures the MTF of one photograph of a slanted edge, as CSV or JSON.
///
/// The method follows ISO 12233.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Conventions:
- Frequencies are along the edge normal, not along the rows.
- The edge is located by least squares over all pixels.
- Bins along the edge normal are a quarter of a pixel wide.
- The effects of averaging in bins and of the difference are divided out.
  This is +5 % at half the sampling frequency.
- The window is a Tukey window, flat over 70 %.
fit/doc/mtf.md describes the accuracy.

Examples:
  fit mtf edge.exr --pixel-pitch 0.05
  fit mtf photo.png --roi 200,150,320,256 --accept doubled --json -o mtf.json

Words and formulas: fit/doc/model.md")]
pub(crate) struct Arguments {
    /// Photograph of an edge: EXR, PNG, TIFF or JPEG.
    ///
    /// Camera raw needs a `fit` that was built with the feature raw.
    pub image: PathBuf,
    /// Region that holds one edge, in pixels.
    ///
    /// X and Y are its upper left corner in the picture as shown, which is turned by its Exif
    /// orientation. Without this option, `fit` finds the edge, which must be the only slanted edge
    /// of the picture.
    #[arg(long, value_name = "X,Y,W,H", value_parser = roi)]
    pub roi: Option<Roi>,
    /// Side of a pixel, mm, so that frequencies are in 1/mm.
    ///
    /// Without this option, frequencies are in cycles per pixel.
    #[arg(long, value_name = "MM", value_parser = parse::positive, allow_negative_numbers = true)]
    pub pixel_pitch: Option<f64>,
    /// Relation of the file's values to light: linear or srgb.
    ///
    /// Without this option, EXR is linear. Other files are read as their cICP chunk, ICC profile,
    /// sRGB chunk or gAMA chunk says; without these, 8 bits are sRGB and 16 bits are linear.
    #[arg(long, value_parser = transfer)]
    pub transfer: Option<Transfer>,
    /// Channel: luminance, red, green, blue or a name.
    ///
    /// A name is that of a channel in the file.
    #[arg(long, default_value = "luminance", value_parser = channel)]
    pub channel: Channel,
    /// Fault that is accepted with a warning: doubled.
    ///
    /// Without this option, an edge that the sheet doubles is refused.
    #[arg(long, value_name = "FAULT", value_parser = accepted)]
    pub accept: Vec<Accepted>,
    /// Writes one JSON object in place of CSV.
    #[arg(long)]
    pub json: bool,
    /// File that receives the curve, in place of standard output.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

fn channel(text: &str) -> Result<Channel, std::convert::Infallible> {
    Ok(Channel::from_name(text))
}

fn accepted(text: &str) -> Result<Accepted, String> {
    Accepted::from_name(text).ok_or_else(|| format!("use {}", Accepted::NAMES.join(" or ")))
}

fn transfer(text: &str) -> Result<Transfer, String> {
    Transfer::from_name(text).ok_or_else(|| "use linear or srgb".into())
}

fn roi(text: &str) -> Result<Roi, String> {
    // The form `roi = [...]` of messages and manifests is read too.
    let pasted = text
        .strip_prefix("roi = [")
        .and_then(|text| text.strip_suffix(']'));
    let text = pasted.unwrap_or(text);
    let parts: Result<Vec<usize>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match parts.as_deref() {
        Ok(&[x, y, width, height]) if width > 0 && height > 0 => Ok(Roi {
            x,
            y,
            width,
            height,
        }),
        _ => Err("write x,y,width,height in whole pixels, the last two above 0".into()),
    }
}

#[derive(Serialize)]
struct Report {
    image: String,
    /// Relation of the file's values to light that was taken, and what named it.
    transfer: String,
    transfer_from: String,
    edge_angle_deg: f64,
    edge_angle_standard_error_deg: f64,
    edge_offset_px: f64,
    /// Height of the curve that the edge follows, and its order; 0 and 1 for a straight edge.
    edge_bow_px: f64,
    edge_order: usize,
    contrast: f64,
    pixel_noise: [f64; 2],
    frequency_unit: &'static str,
    /// In `frequency_unit`.
    mtf50: Option<f64>,
    /// Only with a pixel pitch.
    #[serde(skip_serializing_if = "Option::is_none")]
    mtf50_per_mm: Option<f64>,
    frequency: Vec<f64>,
    mtf: Vec<f64>,
    standard_error: Vec<f64>,
    warnings: Vec<String>,
}

/// Runs the verb.
///
/// # Errors
/// Fails if the photograph cannot be read or holds no edge, or if the output cannot be written.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let output = terminal::reserve(
        arguments.output.as_deref(),
        &mut Outputs::beside([arguments.image.as_path()]),
    )?;
    let decode = Decode {
        transfer: arguments.transfer,
        channel: arguments.channel.clone(),
    };
    let photo = photo::load(&arguments.image, &decode)?;
    if let Some(roi) = arguments
        .roi
        .filter(|roi| !roi.fits(photo.width, photo.height))
    {
        return Err(Failure::Roi {
            image: arguments.image.clone(),
            roi,
            width: photo.width,
            height: photo.height,
            turned: photo.is_turned(),
        });
    }
    let report = measured(&photo, arguments)?;
    let text = if arguments.json {
        output::json(&report)
    } else {
        for warning in &report.warnings {
            terminal::warn([format!("{}: {warning}", arguments.image.display())]);
        }
        terminal::note(report.line());
        report.csv(arguments.pixel_pitch.is_some())
    };
    Ok(terminal::deliver(&text, output)?)
}

/// Measures the edge of a photograph and its MTF, up to the sampling frequency.
fn measured(photo: &Photo, arguments: &Arguments) -> Result<Report, Failure> {
    let Measurement {
        line,
        profile,
        warnings,
        ..
    } = measure::edge(photo, arguments.roi, &arguments.accept).map_err(|fault| Failure::Edge {
        image: arguments.image.clone(),
        fault,
    })?;
    let pitch = arguments.pixel_pitch.unwrap_or(1.0);
    // The curve ends at the sampling frequency, a quarter of the period of the spectrum.
    let estimator = Estimator::new(&profile, pitch, 4 * POINTS, POINTS);
    let mtf = estimator.measure(&profile).modulus;
    let standard_error = sfr::standard_error(&estimator.response(&profile), &profile);
    let frequency = estimator.frequencies_per_mm;
    let (dark, bright) = profile.plateaus();
    let mtf50 = crossing(&frequency, &mtf, 0.5);
    Ok(Report {
        image: arguments.image.display().to_string(),
        transfer: photo.transfer.name.clone(),
        transfer_from: photo.transfer.from.clone(),
        edge_angle_deg: line.normal_rad.to_degrees(),
        edge_angle_standard_error_deg: line.normal_standard_error_rad.to_degrees(),
        edge_offset_px: line.offset_px,
        edge_bow_px: line.bow_px(),
        edge_order: line.bend.map_or(1, |bend| bend.order),
        contrast: bright - dark,
        pixel_noise: profile.noise,
        frequency_unit: if arguments.pixel_pitch.is_some() {
            "1/mm"
        } else {
            "cycles/pixel"
        },
        mtf50,
        mtf50_per_mm: mtf50.filter(|_| arguments.pixel_pitch.is_some()),
        frequency,
        mtf,
        standard_error,
        warnings,
    })
}

impl Report {
    /// Returns the edge in one line, for a reader.
    fn line(&self) -> String {
        let (angle, contrast) = (self.edge_angle_deg, self.contrast);
        let unit = self.frequency_unit;
        let half = self
            .mtf50
            .map_or("not reached".into(), |f| format!("{f:.4} {unit}"));
        let (name, from) = (&self.transfer, &self.transfer_from);
        format!(
            "edge normal {angle:.3} deg, MTF50 {half}, contrast {contrast:.5}, read as {name} \
            ({from})"
        )
    }

    fn csv(&self, in_mm: bool) -> String {
        let column = if in_mm {
            "frequency_per_mm"
        } else {
            "cycles_per_pixel"
        };
        let mut csv = format!("{column},mtf,standard_error\n");
        let rows = self
            .frequency
            .iter()
            .zip(&self.mtf)
            .zip(&self.standard_error);
        for ((f, m), e) in rows {
            let _ = writeln!(csv, "{f:.6},{m:.6},{e:.6}");
        }
        csv
    }
}
