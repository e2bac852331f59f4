//! `fit evaluate`: compares a rendered image with a photograph.

use std::path::PathBuf;
use tables::cli as terminal;

use serde::Serialize;

use crate::cli::failure::Failure;
use crate::cli::output;
use crate::cli::parse;
use crate::images::Shown;
use crate::images::metrics;
use crate::images::metrics::error::Error;
use crate::images::metrics::lpips;
use crate::images::metrics::lpips::Lpips;
use crate::photographs::photo;
use crate::photographs::photo::transfer::Transfer;

/// Compares two pictures by PSNR, SSIM, FLIP and, with weights that you bring, LPIPS.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Both pictures must show the same thing at the same size and place, in the same
units. They are compared as a display shows them: the light times --exposure,
clipped to 0..1, as sRGB.

PSNR (dB) and SSIM (Gaussian window, mean of the colours) are higher for
pictures that are more alike. FLIP (mean) and LPIPS (AlexNet, v0.1) are lower.

Examples:
  fit evaluate aerial.png photograph.png
  fit evaluate aerial.exr photograph.png --exposure 10 --json")]
pub(crate) struct Arguments {
    /// Rendered image.
    pub rendered: PathBuf,
    /// Photograph that the rendered image should look like.
    pub photo: PathBuf,
    /// Factor on the light of both pictures.
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = parse::positive)]
    pub exposure: f64,
    /// Pixels per degree of view, for FLIP.
    #[arg(long, value_name = "N", default_value_t = 67.020_64, value_parser = parse::positive)]
    pub pixels_per_degree: f64,
    /// Weights for LPIPS, from fit/doc/lpips_weights.py.
    ///
    /// Without this option, LPIPS is left out.
    #[arg(long, value_name = "WEIGHTS.safetensors")]
    pub lpips: Option<PathBuf>,
    /// Meaning of integers in both files: linear or srgb.
    ///
    /// Without this option each file decides: its cICP chunk, ICC profile, sRGB chunk, gAMA chunk
    /// or Exif data; without these, 8 bits are sRGB and 16 bits are linear.
    #[arg(long, value_name = "NAME", value_parser = parse::transfer)]
    pub transfer: Option<Transfer>,
    /// Prints one JSON object in place of lines of text.
    #[arg(long)]
    pub json: bool,
}

#[derive(Serialize)]
struct Report {
    width: usize,
    height: usize,
    /// Peak signal-to-noise ratio, dB; null if the pictures are equal.
    psnr_db: Option<f64>,
    ssim: f64,
    flip: f64,
    /// LPIPS distance; null without weights.
    lpips: Option<f64>,
    warnings: Vec<String>,
}

/// Runs the verb.
///
/// # Errors
/// Fails if a picture or the weights cannot be read, if the pictures differ in size, or if they are
/// too small for a metric.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (rendered, photo) = (&arguments.rendered, &arguments.photo);
    let lpips = arguments.lpips.as_deref().map(Lpips::read).transpose();
    let lpips = lpips.map_err(Error::from)?;
    let [a, b] = [
        photo::load_colour(rendered, arguments.transfer)?,
        photo::load_colour(photo, arguments.transfer)?,
    ];
    let mut warnings: Vec<String> = a.warnings.iter().chain(&b.warnings).cloned().collect();
    warnings.dedup();
    let above = |picture: &photo::picture::Picture| {
        let samples = picture.planes.iter().flatten();
        samples
            .filter(|&&v| f64::from(v) * arguments.exposure > 1.0)
            .count()
    };
    let clipped = above(&a) + above(&b);
    if clipped > 0 {
        warnings.push(format!(
            "{clipped} values are above 1 and count as 1; give a smaller --exposure"
        ));
    }
    let [a, b] = [a, b].map(|picture| Shown::new(&picture, arguments.exposure));
    let sizes = [a.size(), b.size()];
    if sizes[0] != sizes[1] {
        return Err(Error::Sizes {
            rendered: rendered.clone(),
            photo: photo.clone(),
            sizes,
        }
        .into());
    }
    let [width, height] = sizes[0];
    let needs = [
        ("SSIM", metrics::SMALLEST, true),
        ("LPIPS", lpips::SMALLEST, lpips.is_some()),
    ];
    for (metric, least, wanted) in needs {
        if wanted && width.min(height) < least {
            return Err(Error::Small {
                rendered: rendered.clone(),
                least,
                metric,
            }
            .into());
        }
    }
    let report = Report {
        width,
        height,
        psnr_db: metrics::psnr(&a, &b),
        ssim: metrics::ssim(&a, &b),
        flip: metrics::flip(&b, &a, arguments.pixels_per_degree as f32),
        lpips: lpips.map(|network| network.distance(&a, &b)),
        warnings,
    };
    if arguments.json {
        return Ok(terminal::print(&output::json(&report))?);
    }
    terminal::warn(&report.warnings);
    let psnr = match report.psnr_db {
        Some(psnr) => format!("{psnr:.2} dB"),
        None => "infinite (the pictures are equal)".into(),
    };
    let lpips = report
        .lpips
        .map_or(String::new(), |d| format!("LPIPS  {d:.4}\n"));
    Ok(terminal::print(&format!(
        "PSNR   {psnr}\nSSIM   {:.4}\nFLIP   {:.4}\n{lpips}",
        report.ssim, report.flip
    ))?)
}
