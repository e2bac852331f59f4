//! `fit mtf`: the slanted-edge MTF of one photograph.

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

/// Points of the curve from 0 to the pixel frequency.
const POINTS: usize = 512;

/// Measures the slanted-edge MTF of one photograph (ISO 12233 style) and writes it as CSV or JSON.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Conventions: fourfold oversampling along the edge normal; the edge is located by least squares \
over all pixels; bin \
averaging and the difference are divided out (at half the sampling frequency: +5 %); Tukey \
window, flat over 70 %; \
frequencies are along the edge normal, not along the rows.

Examples:
  fit mtf edge.exr --pixel-pitch 0.05
  fit mtf photo.png --roi 200,150,320,256 --accept doubled --json -o mtf.json")]
pub(crate) struct Arguments {
    /// The photograph: EXR, 16-bit PNG or TIFF (linear), 8-bit PNG or JPEG (sRGB); camera raw with
    /// the feature raw
    pub image: PathBuf,
    /// Region that holds one edge, pixels; if left out, the picture's only slanted edge is found
    #[arg(long, value_name = "X,Y,W,H", value_parser = roi)]
    pub roi: Option<Roi>,
    /// One pixel, mm: frequencies are then in 1/mm, else in cycles per pixel
    #[arg(long, value_name = "MM", value_parser = parse::positive, allow_negative_numbers = true)]
    pub pixel_pitch: Option<f64>,
    /// Transfer function, where the format's own does not hold: linear or srgb
    #[arg(long, value_parser = transfer)]
    pub transfer: Option<Transfer>,
    /// Colour channel: luminance, red, green, blue, or a channel's name
    #[arg(long, default_value = "luminance", value_parser = channel)]
    pub channel: Channel,
    /// Measure an edge with this fault all the same, with a warning: doubled
    #[arg(long, value_name = "FAULT", value_parser = accepted)]
    pub accept: Vec<Accepted>,
    /// One JSON object instead of CSV
    #[arg(long)]
    pub json: bool,
    /// Write there instead of standard output
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
    // As a message or a manifest writes it, too.
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
    edge_angle_deg: f64,
    edge_angle_standard_error_deg: f64,
    edge_offset_px: f64,
    contrast: f64,
    pixel_noise: [f64; 2],
    frequency_unit: &'static str,
    mtf50: Option<f64>,
    frequency: Vec<f64>,
    mtf: Vec<f64>,
    standard_error: Vec<f64>,
    warnings: Vec<String>,
}

/// Runs the verb.
///
/// # Errors
/// The photograph cannot be read or holds no edge; the output cannot be written.
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

/// The edge of a photograph and its curve, up to the sampling frequency.
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
    // Up to the sampling frequency, which is a quarter of a period.
    let estimator = Estimator::new(&profile, pitch, 4 * POINTS, POINTS);
    let mtf = estimator.measure(&profile).modulus;
    let standard_error = sfr::standard_error(&estimator.response(&profile), &profile);
    let frequency = estimator.frequencies_per_mm;
    let (dark, bright) = profile.plateaus();
    Ok(Report {
        image: arguments.image.display().to_string(),
        edge_angle_deg: line.normal_rad.to_degrees(),
        edge_angle_standard_error_deg: line.normal_standard_error_rad.to_degrees(),
        edge_offset_px: line.offset_px,
        contrast: bright - dark,
        pixel_noise: profile.noise,
        frequency_unit: if arguments.pixel_pitch.is_some() {
            "1/mm"
        } else {
            "cycles/pixel"
        },
        mtf50: crossing(&frequency, &mtf, 0.5),
        frequency,
        mtf,
        standard_error,
        warnings,
    })
}

impl Report {
    /// The edge in one line, for a person.
    fn line(&self) -> String {
        let (angle, contrast) = (self.edge_angle_deg, self.contrast);
        let unit = self.frequency_unit;
        let half = self
            .mtf50
            .map_or("not reached".into(), |f| format!("{f:.4} {unit}"));
        format!("edge normal {angle:.3} deg, MTF50 {half}, contrast {contrast:.5}")
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
