//! `fit explore`: writes a page in which sliders change the mid-air image.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use serde::Serialize;
use tables::cli as terminal;
use tables::{Outputs, Table};

use crate::cli::estimate::read_channel;
use crate::cli::failure::Failure;
use crate::cli::options::by_hand::Numbers;
use crate::cli::options::light::Light;
use crate::cli::options::parse;
use crate::cli::output;
use crate::cli::progress::Bar;
use edges::photographs::photo;
use edges::photographs::photo::picture::Picture;
use edges::photographs::photo::transfer::Transfer;
use estimator::predict::{Fitted, NEAR_MM};
use estimator::result::ResultFile;
use pictures::explore::{self, Explorer, Source, Span, Start};
use pictures::images::mid_air::spacious;
use pictures::images::shown;
use pictures::images::{RenderProgress, RenderStep};

/// Writes a page in which you move sliders and see the mid-air image at once.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The page is one file, which needs no network. Open it in a browser. It shows
a picture and its mid-air image beside each other, the MTF, the luminance, and
the smallest letter that stays readable. Sliders change the distance, the
incidence, the azimuth, the width of the picture, and c, a and mu. Drop a
picture of your own on the page. What lies outside of the photographs of the
fit is hatched, and said.

The page mixes the blur of each direction from directions that are computed
here. The error of that is measured, printed, and stated on the page.

Examples:
  fit explore result.json --table pair.h5 -o explore.html
  fit explore result.json --table pair.h5 --source content.png \\
      --farthest 10000 -o explore.html --json

Without a fit, name a sheet, or give the numbers of a sheet by hand:
  fit explore --sheet prism-0.1 --distance 1500 --incidence 20 --width 300 \\
      -o prisms.html
  fit explore --c 0.15 --wavelength-nm 550 --mu 0.5 --table pair.h5 \\
      -o explore.html

Words and formulas: fit/doc/model.md")]
pub(crate) struct Arguments {
    /// Result that `fit estimate -o` wrote, as JSON.
    ///
    /// Without a fit, give --sheet, or --c and its companions, instead.
    #[arg(
        value_name = "RESULT.json",
        required_unless_present = "own_sheet",
        conflicts_with = "own_sheet"
    )]
    pub result: Option<PathBuf>,
    /// Channel of a result of several channels: red, green or blue.
    ///
    /// `fit estimate --channel each` writes such results.
    #[arg(long, value_name = "NAME", conflicts_with = "own_sheet")]
    pub channel: Option<String>,
    /// Numbers of a sheet without a fit.
    #[command(flatten)]
    pub by_hand: Numbers,
    /// Ray-shift table of the fitted cell, from `bake trace`.
    ///
    /// A --sheet brings its own.
    #[arg(long, value_name = "TABLE.h5", required_unless_present = "sheet")]
    pub table: Option<PathBuf>,
    /// Picture that the page shows first.
    ///
    /// Its longer side is brought to at most 512 pixels.
    #[arg(long, value_name = "IMAGE", help_heading = "Page")]
    pub source: Option<PathBuf>,
    /// Meaning of integers in the source: linear or srgb.
    ///
    /// Without this option the file decides, as for `fit render`.
    #[arg(
        long,
        value_name = "NAME",
        value_parser = parse::transfer,
        requires = "source",
        help_heading = "Page"
    )]
    pub transfer: Option<Transfer>,
    /// Floating distance that the page shows first, mm.
    #[arg(
        long,
        visible_alias = "floating-distance",
        value_name = "MM",
        value_parser = parse::positive,
        help_heading = "Page"
    )]
    pub distance: Option<f64>,
    /// Incidence that the page shows first, degrees.
    #[arg(
        long,
        value_name = "DEG",
        value_parser = parse::incidence,
        allow_negative_numbers = true,
        help_heading = "Page"
    )]
    pub incidence: Option<f64>,
    /// Azimuth that the page shows first, degrees.
    #[arg(
        long,
        value_name = "DEG",
        value_parser = parse::turn,
        allow_negative_numbers = true,
        help_heading = "Page"
    )]
    pub azimuth: Option<f64>,
    /// Width of the picture that the page shows first, mm, from 10 to 3000.
    #[arg(
        long,
        value_name = "MM",
        value_parser = parse::positive,
        allow_negative_numbers = true,
        help_heading = "Page"
    )]
    pub width: Option<f64>,
    /// Shortest floating distance of the slider, mm; half the shortest that was photographed.
    ///
    /// Without photographs it is 100 mm.
    #[arg(
        long,
        value_name = "MM",
        value_parser = parse::positive,
        help_heading = "Page"
    )]
    pub nearest: Option<f64>,
    /// Longest floating distance of the slider, mm; 3000 mm, or twice the longest photographed.
    #[arg(
        long,
        value_name = "MM",
        value_parser = parse::positive,
        help_heading = "Page"
    )]
    pub farthest: Option<f64>,
    /// Light that the page shows first.
    #[command(flatten)]
    pub light: Light,
    /// Number of threads; one per core if left out.
    #[arg(
        long,
        value_name = "N",
        help_heading = "Output and threads",
        value_parser = terminal::whole::<NonZeroUsize>(1..)
    )]
    pub threads: Option<NonZeroUsize>,
    /// Prints the facts about the page as one JSON object.
    #[arg(long, help_heading = "Output and threads")]
    pub json: bool,
    /// File that receives the page, as HTML.
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
}

/// Shortest distance of the slider without photographs, mm.
const NEAREST_MM: f64 = 100.0;

/// Longest distance of the slider at least, mm: that of a large stage.
const FARTHEST_MM: f64 = 3000.0;

/// Factors on c, a and mu that the sliders span.
const FACTOR: [f64; 2] = [0.5, 2.0];

/// Longest side of a picture in the page, pixels.
const SIDE: usize = 512;

/// Facts about a page.
#[derive(Serialize)]
pub(in crate::cli) struct Facts {
    megabytes: f64,
    directions: usize,
    distance_mm: [f64; 2],
    /// Largest error of a pixel, in units of the brightest, and of a weight, in units of the
    /// largest.
    mixing_error: f64,
    mixing_error_of_peak: f64,
    /// Places at which the error was measured.
    places: usize,
    warnings: Vec<String>,
}

/// Runs the verb.
///
/// # Errors
/// Fails if the result, the table or the picture cannot be used, or if the page cannot be written.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let inputs = arguments.table.iter();
    let inputs = inputs.chain(&arguments.result).chain(&arguments.source);
    let mut outputs = Outputs::beside(inputs.map(PathBuf::as_path));
    arguments.ending()?;
    let output = outputs.reserve(&arguments.output)?;
    let table = (arguments.by_hand).table("fit explore", arguments.table.as_deref())?;
    let (result, title) = match &arguments.result {
        Some(file) => (
            read_channel(file, arguments.channel.as_deref())?,
            file.display().to_string(),
        ),
        // The page chooses the size of its pixels itself.
        None => (
            arguments.by_hand.result("fit explore", 1.0, &table)?,
            (arguments.by_hand.sheet)
                .map_or("numbers given by hand", |sheet| sheet.name)
                .into(),
        ),
    };
    let table = result.seen(&table)?;
    let sheet = Fitted::new(&result, &table)?;
    let picture = match &arguments.source {
        None => None,
        Some(file) => Some((file, photo::load_colour(file, arguments.transfer)?)),
    };
    let source = picture.as_ref().map(|(file, own)| (file.as_path(), own));
    let progress = Bar::of_steps();
    let show = |part: RenderStep| progress.part(part.what, part.done, part.of);
    let made = made(arguments, sheet, title, source, &show);
    progress.done();
    let made = made?;
    output.commit(made.html.as_bytes())?;
    let facts = &made.facts;
    terminal::warn(&facts.warnings);
    Ok(terminal::print(&match arguments.json {
        true => output::json(facts),
        false => format!(
            "{}: {:.1} MB, {} directions; a pixel errs by at most {} % of the brightest \
            (at {} places)\n",
            arguments.output.display(),
            facts.megabytes,
            facts.directions,
            percent(facts.mixing_error),
            facts.places
        ),
    })?)
}

/// Returns a share in percent, with two digits.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent {
        0.005.. => format!("{percent:.2}"),
        _ => format!("{percent:.0e}"),
    }
}

/// Page, and the facts about it.
pub(in crate::cli) struct Made {
    pub html: String,
    pub facts: Facts,
}

/// Makes the page of a sheet, which shows the picture `source` first if there is one.
///
/// # Errors
/// Fails if an option contradicts the table, or if the sheet has no blur in a direction.
pub(in crate::cli) fn made(
    arguments: &Arguments,
    sheet: Fitted<'_>,
    title: String,
    source: Option<(&Path, &Picture)>,
    progress: RenderProgress<'_>,
) -> Result<Made, Failure> {
    let mut warnings = sheet.warnings();
    let span = arguments.span(sheet.result)?;
    if let Some((_, picture)) = source {
        warnings.extend(picture.warnings.iter().cloned());
    }
    let spread = sheet.result.angular_spread_mrad.and_then(|own| own.value);
    warnings.extend(spread.map(|mrad| {
        format!(
            "the page leaves out the angular spread of {mrad:.3} mrad, so its images are too \
            sharp; `fit render` includes it"
        )
    }));
    warnings.extend(sheet.result.dihedral_errors_mrad.map(|_| {
        "the bands of the page leave out what is not known of the dihedral errors; `fit predict` \
        includes it"
            .to_owned()
    }));
    let shown = arguments.width.zip(arguments.distance);
    warnings.extend(shown.and_then(|(width, distance)| spacious(width, distance)));
    let explorer = Explorer {
        sheet,
        span,
        start: arguments.start(sheet.table)?,
        title,
        source: source.map(|(file, picture)| embedded(file, picture)),
    };
    let pool = terminal::pool(arguments.threads)?;
    let page = pool.install(|| explore::page(&explorer, progress))?;
    if page.misfit.pixel > explore::WANTED {
        let why = match page.is_of_colours {
            true => "it takes each colour's mean wavelength; `fit render` takes all of them",
            false => {
                "no finer grid fits into a page; give a shorter range by --nearest and --farthest"
            }
        };
        warnings.push(format!(
            "a pixel of the page can err by {:.1} % of the brightest, because {why}",
            100.0 * page.misfit.pixel
        ));
    }
    let facts = Facts {
        megabytes: page.html.len() as f64 / 1e6,
        directions: page.directions,
        distance_mm: explorer.span.distance_mm,
        mixing_error: page.misfit.pixel,
        mixing_error_of_peak: page.misfit.peak,
        places: page.places,
        warnings,
    };
    Ok(Made {
        html: page.html,
        facts,
    })
}

/// Least and greatest width of a picture on the page, mm.
const WIDTHS: [f64; 2] = [10.0, 3000.0];

impl Arguments {
    /// Checks that the page would not get the name of a picture.
    ///
    /// # Errors
    /// Returns [`Failure::Usage`] if it would.
    fn ending(&self) -> Result<(), Failure> {
        let ending = self.output.extension().and_then(|ending| ending.to_str());
        match ending.map(str::to_ascii_lowercase).as_deref() {
            Some("png" | "jpg" | "jpeg" | "svg" | "exr" | "pdf") => Err(Failure::conflict(
                "fit explore",
                format!(
                    "{}: the page is written as .html; give this ending (fit render writes \
                    pictures)",
                    self.output.display()
                ),
            )),
            _ => Ok(()),
        }
    }

    /// Returns the settings that the page shows first.
    ///
    /// # Errors
    /// Returns [`Failure::Usage`] if the table does not cover the incidence.
    fn start(&self, table: &Table) -> Result<Start, Failure> {
        let all = &table.axes.incidence_deg;
        let (least, most) = (all[0], all[all.len() - 1]);
        if let Some(asked) = (self.incidence).filter(|asked| !(least..=most).contains(asked)) {
            let message = format!(
                "the table covers incidence {least} to {most} degrees, and not --incidence {asked}"
            );
            return Err(Failure::conflict("fit explore", message));
        }
        let known = |azimuth: f64| table.direction(least, Some(azimuth)).is_ok();
        if let Some(asked) = self.azimuth.filter(|&asked| !known(asked)) {
            let message = format!(
                "the table does not hold azimuth {asked} degrees, nor those around it; leave \
                --azimuth out, or bake this azimuth"
            );
            return Err(Failure::conflict("fit explore", message));
        }
        if let Some(asked) = (self.width).filter(|asked| !(WIDTHS[0]..=WIDTHS[1]).contains(asked)) {
            let [least, most] = WIDTHS;
            let message = format!(
                "the page shows pictures {least} to {most} mm wide, and not --width {asked}; fit \
                render shows other sizes"
            );
            return Err(Failure::conflict("fit explore", message));
        }
        Ok(Start {
            distance: self.distance,
            incidence: self.incidence,
            azimuth: self.azimuth.map(|azimuth| azimuth.rem_euclid(360.0)),
            width: self.width,
            luminance: self.light.luminance,
            ambient: Some(self.light.ambient()).filter(|own| *own > 0.0),
        })
    }

    /// Returns the ranges of the sliders.
    ///
    /// # Errors
    /// Returns [`Failure::Usage`] if the nearest distance is below 10 mm, or not below the farthest
    /// one.
    fn span(&self, result: &ResultFile) -> Result<Span, Failure> {
        let photographed = result.domain.map(|domain| domain.floating_distance_mm);
        let [near, far] = match photographed {
            Some([near, far]) => [(0.5 * near).max(NEAR_MM), FARTHEST_MM.max(2.0 * far)],
            None => [NEAREST_MM, FARTHEST_MM],
        };
        let [near, far] = match self.distance {
            Some(distance) => [near.min(distance), far.max(distance)],
            None => [near, far],
        };
        let distance_mm = [self.nearest.unwrap_or(near), self.farthest.unwrap_or(far)];
        if distance_mm[0] < NEAR_MM {
            let message = format!(
                "the page would begin {} mm from the sheet; distances are in mm, from {NEAR_MM} \
                mm on",
                distance_mm[0]
            );
            return Err(Failure::conflict("fit explore", message));
        }
        if distance_mm[0] >= distance_mm[1] {
            let message = format!(
                "the nearest distance, {} mm, is not below the farthest, {} mm; give --nearest or \
                --farthest so that it is",
                distance_mm[0], distance_mm[1]
            );
            return Err(Failure::conflict("fit explore", message));
        }
        Ok(Span {
            distance_mm,
            width_mm: WIDTHS,
            factor: FACTOR,
        })
    }
}

/// Returns a picture as a PNG of at most [`SIDE`] pixels, in sRGB.
fn embedded(file: &Path, picture: &Picture) -> Source {
    Source {
        name: file
            .file_name()
            .map(|name| name.to_string_lossy().into_owned())
            .unwrap_or_default(),
        png: shown::png(&shown::at_most(picture, SIDE)),
    }
}
