//! `fit mtf`: measures the slanted-edge MTF of photographs.

mod report;
mod table;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use tables::Outputs;
use tables::cli as terminal;

use crate::cli::failure::Failure;
use crate::cli::mtf::report::{Report, Request, measured};
use crate::cli::mtf::table::{Entry, Photographs};
use crate::cli::options::parse;
use crate::cli::output;
use crate::cli::progress::Bar;
use edges::photographs::Roi;
use edges::photographs::edge::fault::Accepted;
use edges::photographs::photo::channel::{Channel, Decode};
use edges::photographs::photo::format::{Format, extension, is_raw};
use edges::photographs::photo::in_memory::InMemory;
use edges::photographs::photo::transfer::Transfer;
#[cfg(feature = "full")]
use pictures::report::plot;

/// Measures the MTF of photographs of a slanted edge, as CSV or JSON.
///
/// The method follows ISO 12233. One photograph gives its curve. Several photographs, or a folder,
/// give one row each.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Conventions:
- Frequencies are along the edge normal, not along the rows.
- The edge is located by least squares over all pixels.
- Bins along the edge normal are a quarter of a pixel wide.
- The effects of averaging in bins and of the difference are divided out.
  This is +5 % at half the sampling frequency.
- The window is a Tukey window, flat over 70 %.
- MTF50 and MTF10 are read off a smooth curve through the MTF about them.
- An edge that is aligned with the pixels is refused. Tilt it by 2 to 10
  degrees, best by 5.
fit/doc/mtf.md describes the accuracy, and what sfrmat5 does otherwise.

Several photographs, or a folder: a photograph that is refused has the reason
in the column `error`. The others are measured, and the exit code is 1.

Examples:
  fit mtf edge.exr --pixel-pitch 0.05
  fit mtf photo.png --roi 200,150,320,256 --accept doubled --json -o mtf.json
  fit mtf edge.exr --at 0.1,0.25,0.5 --plot edge.svg -o edge.csv
  fit mtf edge.exr photo.png --at 0.1,0.25 -o edges.csv

Words and formulas: fit/doc/model.md")]
pub(crate) struct Arguments {
    /// Photographs of an edge: EXR, PNG, TIFF or JPEG; or folders of them.
    ///
    /// Camera raw needs a `fit` that was built with the feature raw. The pictures of a folder are
    /// taken in the order of their names; other files in it are left out.
    #[arg(required = true)]
    pub image: Vec<PathBuf>,
    /// Region that holds one edge, in pixels.
    ///
    /// X and Y are its upper left corner in the picture as shown, which is turned by its Exif
    /// orientation. Without this option, `fit` finds the edge, which must be the only slanted edge
    /// of the picture. The region holds for every photograph.
    #[arg(long, value_name = "X,Y,W,H", value_parser = roi)]
    pub roi: Option<Roi>,
    /// Side of a pixel, mm, so that frequencies are in 1/mm.
    ///
    /// Without this option, frequencies are in cycles per pixel.
    #[arg(long, value_name = "MM", value_parser = parse::positive, allow_negative_numbers = true)]
    pub pixel_pitch: Option<f64>,
    /// Frequencies at which the MTF is named too.
    ///
    /// They are in 1/mm with --pixel-pitch, else in cycles per pixel. A list, or start:stop:step.
    #[arg(long, value_name = "F,F,...", value_parser = parse::positives)]
    pub at: Option<std::vec::Vec<f64>>,
    /// Relation of the file's values to light: linear or srgb.
    ///
    /// Without this option, EXR is linear. Other files are read as their cICP chunk, ICC profile,
    /// sRGB chunk, gAMA chunk or Exif data say; without these, 8 bits are sRGB and 16 bits are
    /// linear.
    #[arg(long, value_parser = parse::transfer)]
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
    /// File that receives the curves as a picture, .svg.
    #[cfg(feature = "full")]
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// File that receives the curve or the rows, in place of standard output.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

fn channel(text: &str) -> Result<Channel, std::convert::Infallible> {
    Ok(Channel::from_name(text))
}

fn accepted(text: &str) -> Result<Accepted, String> {
    Accepted::from_name(text).ok_or_else(|| format!("use {}", Accepted::NAMES.join(" or ")))
}

fn roi(text: &str) -> Result<Roi, String> {
    // The form `roi = [...]` of messages and manifests is read too.
    let pasted = text
        .strip_prefix("roi = [")
        .and_then(|text| text.strip_suffix(']'));
    let text = pasted.unwrap_or(text);
    let parts: Result<Vec<usize>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let roi = parts.ok().and_then(|parts| Roi::of(&parts));
    roi.ok_or_else(|| "write x,y,width,height in whole pixels, the last two above 0".into())
}

impl Arguments {
    /// Returns what holds for every photograph.
    ///
    /// # Errors
    /// Returns [`Failure::Frequency`] if a frequency lies above the sampling frequency.
    fn request(&self) -> Result<Request, Failure> {
        let request = Request {
            decode: Decode {
                transfer: self.transfer,
                channel: self.channel.clone(),
            },
            roi: self.roi,
            accept: self.accept.clone(),
            pitch_mm: self.pixel_pitch,
            at: self.at.clone().unwrap_or_default(),
        };
        request.check()?;
        Ok(request)
    }
}

/// Measures one photograph, from its file or from memory, and returns the measurement as JSON.
///
/// # Errors
/// Fails if the photograph cannot be read or holds no edge.
pub(super) fn measurement(
    arguments: &Arguments,
    held: Option<&InMemory>,
) -> Result<String, Failure> {
    let request = arguments.request()?;
    let report = match (held, &arguments.image[..]) {
        (Some(held), _) => {
            let photo = held.photo(&request.decode)?;
            report::of_photo(&held.name, &photo, &request)?
        }
        (None, [image]) => measured(image, &request)?,
        (None, _) => {
            return Err(Failure::conflict(
                "fit mtf",
                "name one photograph at a time",
            ));
        }
    };
    Ok(output::json(&report))
}

/// Runs the verb.
///
/// # Errors
/// Fails if a photograph cannot be read or holds no edge, or if an output cannot be written. Of
/// several photographs, all others are measured and written first.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let request = arguments.request()?;
    let images = photographs(&arguments.image)?;
    let mut outputs = Outputs::beside(images.iter().map(PathBuf::as_path));
    let output = terminal::reserve(arguments.output.as_deref(), &mut outputs)?;
    #[cfg(feature = "full")]
    let picture = terminal::reserve_plot(arguments.plot.as_deref(), &mut outputs)?;
    if let [image] = &arguments.image[..]
        && !image.is_dir()
    {
        let report = measured(image, &request)?;
        #[cfg(feature = "full")]
        if let Some(output) = picture {
            output.commit(drawn(&[&report], &request).as_bytes())?;
        }
        let text = if arguments.json {
            output::json(&report)
        } else {
            warn(&report);
            terminal::note(report.summary());
            report.csv()
        };
        return Ok(terminal::deliver(&text, output)?);
    }
    let entries = all(&images, &request);
    #[cfg(feature = "full")]
    if let Some(output) = picture {
        let reports: Vec<&Report> = entries.iter().filter_map(Entry::report).collect();
        if !reports.is_empty() {
            output.commit(drawn(&reports, &request).as_bytes())?;
        }
    }
    let text = if arguments.json {
        output::json(&Photographs {
            photographs: &entries,
        })
    } else {
        table::csv(&entries, &request)
    };
    terminal::deliver(&text, output)?;
    match entries.iter().filter(|e| e.report().is_none()).count() {
        0 => Ok(()),
        refused => Err(Failure::Refused {
            refused,
            of: entries.len(),
        }),
    }
}

/// Measures all photographs, in parallel, and prints the warnings and refusals in their order.
fn all(images: &[PathBuf], request: &Request) -> Vec<Entry> {
    let (progress, done) = (Bar::of_steps(), AtomicUsize::new(0));
    let one = |image: &PathBuf| {
        let found = measured(image, request);
        let done = 1 + done.fetch_add(1, Ordering::Relaxed);
        progress.part("photographs measured", done, images.len());
        found
    };
    let found: Vec<Result<Report, Failure>> = images.par_iter().map(one).collect();
    progress.done();
    let entries = images.iter().zip(found).map(|(image, found)| match found {
        Ok(report) => {
            warn(&report);
            Entry::Measured(Box::new(report))
        }
        Err(failure) => {
            let error = failure.to_string();
            terminal::warn([format!("refused: {error}")]);
            Entry::Refused {
                image: image.display().to_string(),
                error,
            }
        }
    });
    entries.collect()
}

fn warn(report: &Report) {
    for warning in &report.warnings {
        terminal::warn([format!("{}: {warning}", report.image)]);
    }
}

/// Draws the curves of photographs.
#[cfg(feature = "full")]
fn drawn(reports: &[&Report], request: &Request) -> String {
    let shown: Vec<plot::Shown> = reports
        .iter()
        .map(|report| plot::Shown {
            name: std::path::Path::new(&report.image)
                .file_name()
                .map_or(report.image.clone(), |name| {
                    name.to_string_lossy().into_owned()
                }),
            frequency: &report.frequency,
            mtf: &report.mtf,
            standard_error: &report.standard_error,
            half: report.mtf50,
        })
        .collect();
    plot::measured(&shown, request.unit())
}

/// Returns all photographs: those that were named, and in place of a folder its pictures in the
/// order of their names. Other files of a folder, and folders in it, are left out.
///
/// # Errors
/// Returns [`Failure::Folder`] if a folder cannot be read or holds no picture.
fn photographs(named: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut all = Vec::new();
    for path in named {
        if path.is_dir() {
            all.extend(pictures(path)?);
        } else {
            all.push(path.clone());
        }
    }
    Ok(all)
}

fn pictures(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let failure = |message: String| Failure::Folder {
        folder: folder.to_owned(),
        message,
    };
    let unreadable =
        |error: std::io::Error| failure(format!("the folder cannot be read ({error})"));
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if is_picture(&path) && path.is_file() {
            found.push(path);
        }
    }
    if found.is_empty() {
        let message = "the folder holds no picture (EXR, PNG, TIFF or JPEG)";
        return Err(failure(message.into()));
    }
    found.sort();
    Ok(found)
}

/// Returns whether the name is that of a picture. Hidden files are none.
fn is_picture(path: &Path) -> bool {
    let hidden = path
        .file_name()
        .is_some_and(|name| name.to_string_lossy().starts_with('.'));
    let extension = extension(path);
    let formats = [Format::Exr, Format::Png, Format::Tiff, Format::Jpeg];
    let read = |format: &Format| format.extensions().contains(&extension.as_str());
    let raw = cfg!(feature = "raw") && is_raw(&extension, &[]);
    !hidden && (formats.iter().any(read) || raw)
}
