//! `fit compare`: shows sheets side by side.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use tables::cli as terminal;

use clap::ArgGroup;
use tables::{Outputs, Table};

use crate::cli::estimate::read_channel;
use crate::cli::failure::Failure;
use crate::cli::options::by_hand::{HALF_MIRROR, sheets};
use crate::cli::options::light::Light;
use crate::cli::options::parse;
use crate::cli::output;
use crate::cli::progress::Bar;
use edges::photographs::photo;
use edges::photographs::photo::picture::Picture;
use edges::photographs::photo::transfer::Transfer;
use estimator::predict::{Fitted, Viewing};
use estimator::result::{Nominal, ResultFile, TableResult};
use pictures::compare::{Behind, Conditions, Contender, Seat, Sight};
use pictures::compare::{compare, gallery, page};
use pictures::images::RenderStep;

/// Shows sheets side by side: luminance, contrast, smallest readable letter, sharpness.
#[derive(Debug, clap::Args)]
#[command(
    group = ArgGroup::new("contenders").args(["sheet", "results"]).multiple(true).required(true),
    after_help = "\
Without -o it prints a table, with ratios to the first sheet. The page (.html)
shows the picture of --source through each sheet too. Several results of one
cell are compared with each other: their scatter against their errors.

A capital letter is readable if its strokes keep a contrast of 0.1, and if it is
at least 5 minutes of arc high for the viewer (doc/which.md has the sources).

Examples:
  fit compare --sheet prism-0.1 --sheet prism-0.2 --sheet hollow-0.2 \\
      --distance 1000 --incidence 0:30:10
  fit compare --sheet prism-0.1 --sheet hollow-0.2 result.json:pair.h5 \\
      --distance 300 --incidence 0:30:10 --luminance 500 --ambient-nits 100 \\
      --letter 20 --source content.png --width 200 -o which.html
  fit compare --sheet prism-0.1 --sheet prism-0.2 --distance 1000 \\
      --incidence 20 -o which.csv

From where do you look? --viewer 0.4,0.6,2 is 0.4 m to the right of the image,
0.6 m above it and 2 m in front of it. A sheet of --sheet-tilt 0 is upright and
faces you, one of 90 lies flat and faces up. Incidence and azimuth follow:
  fit compare --sheet prism-0.1 --sheet prism-0.2 --viewer 0,1.2,1.5 \\
      --sheet-tilt 60 --sheet-height -0.5 --letter 30

Words and formulas: fit/doc/model.md"
)]
pub(crate) struct Arguments {
    /// Fitted sheets: a result of `fit estimate -o` and a table of its cell, joined by a colon.
    #[arg(value_name = "RESULT.json:TABLE.h5", value_parser = pair)]
    pub results: Vec<Pair>,
    /// Sheet whose numbers come from public sources, and from assumptions; may be repeated.
    #[arg(long, value_name = "NAME", value_parser = sheets())]
    pub sheet: Vec<&'static Nominal>,
    /// Channel of results of several channels: red, green or blue.
    #[arg(long, value_name = "NAME", requires = "results")]
    pub channel: Option<String>,
    /// Floating distance R, mm: the path from the sheet to the image.
    #[arg(
        long,
        visible_alias = "floating-distance",
        value_name = "MM",
        value_parser = parse::positive,
        allow_negative_numbers = true,
        required_unless_present = "sheet_height",
        help_heading = "Place"
    )]
    pub distance: Option<f64>,
    /// Incidence angles in the air, degrees: 0,5,10 or start:stop:step.
    #[arg(
        long,
        value_name = "LIST",
        value_parser = parse::incidences,
        allow_negative_numbers = true,
        required_unless_present = "viewer",
        help_heading = "Place"
    )]
    pub incidence: Option<std::vec::Vec<f64>>,
    /// Azimuth of the light, degrees; that of the table if it holds one, 0 for a --sheet.
    ///
    /// With a place of --viewer it is that for a viewer in the middle, above the sheet's normal.
    #[arg(
        long,
        value_name = "DEG",
        value_parser = parse::turn,
        allow_negative_numbers = true,
        help_heading = "Place"
    )]
    pub azimuth: Option<f64>,
    /// Viewer, m from the image: a distance (1 if left out), or a place from which the incidence
    /// follows.
    ///
    /// A place is X,Y,Z from the middle of the image: to the right, up, and towards the viewer, all
    /// as if there were no half mirror.
    #[arg(
        long,
        value_name = "M|X,Y,Z",
        value_parser = viewer,
        allow_hyphen_values = true,
        help_heading = "Place"
    )]
    pub viewer: Option<Viewer>,
    /// Tilt of the sheet, degrees: 0 is upright, 90 lies flat and faces up.
    #[arg(
        long,
        value_name = "DEG",
        default_value_t = 0.0,
        value_parser = parse::turn,
        allow_negative_numbers = true,
        requires = "viewer",
        help_heading = "Place"
    )]
    pub sheet_tilt: f64,
    /// Height of the sheet above the image, m, where the line of sight meets it, in place of
    /// --distance; below the image it is negative.
    #[arg(
        long,
        value_name = "M",
        value_parser = terminal::number,
        allow_negative_numbers = true,
        requires = "viewer",
        conflicts_with = "distance",
        help_heading = "Place"
    )]
    pub sheet_height: Option<f64>,
    /// Light of source and room.
    #[command(flatten)]
    pub light: Light,
    /// Height of capital letters, mm: says at which incidences they are readable.
    #[arg(
        long,
        value_name = "MM",
        value_parser = parse::positive,
        allow_negative_numbers = true,
        help_heading = "Picture"
    )]
    pub letter: Option<f64>,
    /// Picture that the page shows through each sheet.
    #[arg(
        long,
        value_name = "IMAGE",
        requires = "width",
        help_heading = "Picture"
    )]
    pub source: Option<PathBuf>,
    /// Width of the picture in the air, mm.
    #[arg(
        long,
        value_name = "MM",
        value_parser = parse::positive,
        allow_negative_numbers = true,
        help_heading = "Picture"
    )]
    pub width: Option<f64>,
    /// Meaning of integers in the source: linear or srgb.
    ///
    /// Without this option the file decides, as for `fit render`.
    #[arg(
        long,
        value_name = "NAME",
        value_parser = parse::transfer,
        requires = "source",
        help_heading = "Picture"
    )]
    pub transfer: Option<Transfer>,
    /// Number of threads; one per core if left out.
    #[arg(
        long,
        value_name = "N",
        help_heading = "Output and threads",
        value_parser = terminal::whole::<NonZeroUsize>(1..)
    )]
    pub threads: Option<NonZeroUsize>,
    /// Prints the comparison as one JSON object.
    #[arg(long, help_heading = "Output and threads")]
    pub json: bool,
    /// File that receives a page (.html), CSV or JSON, by its ending, in place of the table.
    #[arg(short, long, value_name = "FILE", help_heading = "Output and threads")]
    pub output: Option<PathBuf>,
}

/// A result and a table of its cell.
#[derive(Debug, Clone)]
pub(crate) struct Pair {
    result: PathBuf,
    table: PathBuf,
}

/// Viewer of the image.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Viewer {
    /// At this distance from the image, m.
    Distance(f64),
    /// At this place from the middle of the image, m.
    Place([f64; 3]),
}

/// Distance of the viewer from the image if none is given, m.
const VIEWER_M: f64 = 1.0;

fn pair(text: &str) -> Result<Pair, String> {
    let parts = text
        .rsplit_once(':')
        .filter(|(a, b)| !a.is_empty() && !b.is_empty());
    let (result, table) =
        parts.ok_or("join a result and a table by a colon: result.json:table.h5")?;
    Ok(Pair {
        result: result.into(),
        table: table.into(),
    })
}

fn viewer(text: &str) -> Result<Viewer, String> {
    // Nobody reads a mid-air image from farther away.
    const FARTHEST_M: f64 = 200.0;
    let wrong = || "give a distance above 0, or three numbers: right,up,towards the viewer, m";
    let numbers = terminal::list(text)?;
    if numbers.iter().any(|own| own.abs() > FARTHEST_M) {
        return Err(format!(
            "the viewer would be more than {FARTHEST_M} m away; give metres, not mm"
        ));
    }
    match numbers[..] {
        [distance] if distance > 0.0 => Ok(Viewer::Distance(distance)),
        [x, y, z] => Ok(Viewer::Place([x, y, z])),
        _ => Err(wrong().into()),
    }
}

/// What the file of -o holds.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Format {
    Page,
    Csv,
    Json,
}

/// Runs the verb.
///
/// # Errors
/// Fails if a result, a table or the picture cannot be used, if a table lacks a direction, or if the
/// output cannot be written.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let pairs = arguments.results.iter();
    let inputs = pairs.flat_map(|pair| [&pair.result, &pair.table]);
    let mut outputs = Outputs::beside(inputs.chain(&arguments.source).map(PathBuf::as_path));
    let format = arguments.format()?;
    let output = terminal::reserve(arguments.output.as_deref(), &mut outputs)?;
    let pool = terminal::pool(arguments.threads)?;
    let picture = match &arguments.source {
        None => None,
        Some(file) => Some((file, photo::load_colour(file, arguments.transfer)?)),
    };
    let sight = arguments.sight(picture.as_ref().map(|(_, picture)| picture))?;
    let conditions = arguments.conditions(sight.as_ref());
    let held = arguments.held()?;
    let mut contenders = Vec::new();
    for own in &held {
        let azimuth = sight.map_or(arguments.azimuth, |sight| sight.middle.azimuth_deg);
        contenders.push(own.contender(azimuth)?);
    }
    let progress = Bar::of_steps();
    let show = |part: RenderStep| progress.part(part.what, part.done, part.of);
    let made = pool.install(|| {
        let found = compare(&contenders, conditions.clone(), &show)?;
        let axis = sight.map_or(0.0, |sight| sight.tangential_axis_deg);
        let shown = picture.as_ref().zip(arguments.width);
        let shown = shown.map(|((file, picture), width)| {
            let source = (file.display().to_string(), picture);
            gallery(&contenders, &conditions, source, width, axis, &show)
        });
        Ok::<_, pictures::Error>((found, shown.transpose()?))
    });
    progress.done();
    let (mut found, shown) = made?;
    found
        .warnings
        .extend(sight.map(|sight| over_the_picture(&sight)));
    terminal::warn(found.not_measured());
    terminal::warn(&found.warnings);
    let command = output::command_line(std::env::args_os());
    let text = match (format, arguments.json) {
        (Some(Format::Page), _) => page(&found, shown.as_ref(), &command),
        (Some(Format::Csv), _) => found.csv(),
        (Some(Format::Json), _) | (None, true) => output::json(&found),
        (None, false) => found.text(),
    };
    if format.is_some() && arguments.json {
        terminal::print(&output::json(&found))?;
    }
    Ok(terminal::deliver(&text, output)?)
}

/// Describes the incidences over a picture.
fn over_the_picture(sight: &Sight) -> String {
    let middle = sight.middle;
    let [least, most] = sight.incidence_deg;
    let over = match most - least > 0.05 {
        true => format!("; over the picture the incidence is {least:.1} to {most:.1} deg"),
        false => String::new(),
    };
    format!(
        "the viewer sees the middle of the image at incidence {:.1} deg and azimuth {:.1} deg, \
        {:.0} mm from the sheet{over}",
        middle.incidence_deg,
        middle.azimuth_deg.unwrap_or(0.0),
        middle.r_mm
    )
}

/// Result and table of a sheet, with its name.
struct Held {
    name: String,
    result: ResultFile,
    table: Table,
}

impl Held {
    /// Returns the sheet at an azimuth, or at its own if that is `None`.
    ///
    /// # Errors
    /// Returns [`Failure::Estimator`] if the table is not that of the result.
    fn contender(&self, azimuth_deg: Option<f64>) -> Result<Contender<'_>, Failure> {
        let is_mean = self.table.axes.is_mean();
        let own = || parse::usual_azimuth(&self.table, &self.result);
        Ok(Contender {
            name: self.name.clone(),
            sheet: Fitted::new(&self.result, &self.table)?,
            azimuth_deg: azimuth_deg.filter(|_| !is_mean).or_else(own),
        })
    }
}

impl Arguments {
    /// Returns what the file of -o is to hold; `None` without one.
    ///
    /// # Errors
    /// Returns [`Failure::Usage`] for another ending, and for a picture that nothing would show.
    fn format(&self) -> Result<Option<Format>, Failure> {
        let ending = self.output.as_ref().map(|file| {
            let ending = file.extension().and_then(|ending| ending.to_str());
            match ending.map(str::to_ascii_lowercase).as_deref() {
                Some("html") => Ok(Format::Page),
                Some("csv") => Ok(Format::Csv),
                Some("json") => Ok(Format::Json),
                _ => Err(Failure::conflict(
                    "fit compare",
                    format!(
                        "{}: a comparison is written as .html, .csv or .json; give one of these \
                        endings",
                        file.display()
                    ),
                )),
            }
        });
        let format = ending.transpose()?;
        if self.source.is_some() && format != Some(Format::Page) {
            let message = "--source: only the page shows the picture; give -o which.html";
            return Err(Failure::conflict("fit compare", message));
        }
        Ok(format)
    }

    /// Returns what a viewer at a place sees; `None` without a place.
    ///
    /// # Errors
    /// Returns [`Failure::Usage`] for an incidence beside a place and for a tilt without one, and
    /// [`Failure::Pictures`] for a place from which the image is not seen.
    fn sight(&self, picture: Option<&Picture>) -> Result<Option<Sight>, Failure> {
        let conflict = |message| Err(Failure::conflict("fit compare", message));
        let Some(Viewer::Place(place)) = self.viewer else {
            if self.incidence.is_none() {
                return conflict(
                    "--viewer: a distance gives no incidence; give --incidence, or a place X,Y,Z",
                );
            }
            if self.sheet_height.is_some() || self.sheet_tilt != 0.0 {
                return conflict("--sheet-tilt and --sheet-height: need a place, --viewer X,Y,Z");
            }
            return Ok(None);
        };
        if self.incidence.is_some() {
            return conflict(
                "--incidence: follows from the place of --viewer; leave one of them out",
            );
        }
        let behind = match (self.sheet_height, self.distance) {
            (Some(height), _) => Behind::Height(1000.0 * height),
            (None, distance) => Behind::Distance(distance.unwrap_or(f64::NAN)),
        };
        let width = self.width.unwrap_or(0.0);
        let shape = picture.map_or(0.0, |own| own.height as f64 / own.width as f64);
        let seat = Seat {
            viewer_mm: place.map(|own| 1000.0 * own),
            behind,
            tilt_deg: self.sheet_tilt,
            azimuth_deg: self.azimuth.unwrap_or(0.0),
            size_mm: [width, width * shape],
        };
        Ok(Some(seat.sight()?))
    }

    fn conditions(&self, sight: Option<&Sight>) -> Conditions {
        let viewer_mm = match (sight, self.viewer) {
            (Some(sight), _) => sight.viewer_mm,
            (None, Some(Viewer::Distance(distance))) => 1000.0 * distance,
            (None, _) => 1000.0 * VIEWER_M,
        };
        let middle = sight.map(|sight| sight.middle);
        Conditions {
            floating_distance_mm: (middle.map(|place| place.r_mm))
                .or(self.distance)
                .unwrap_or(f64::NAN),
            incidence_deg: match middle {
                // As an angle is typed; messages name it.
                Some(place) => vec![(1e4 * place.incidence_deg).round() / 1e4],
                None => self.incidence.clone().unwrap_or_default(),
            },
            viewing: Viewing {
                ambient: self.light.ambient(),
                viewer_mm,
            },
            source_cd_m2: self.light.luminance,
            letter_mm: self.letter,
        }
    }

    /// Reads all sheets: the nominal ones, then the fitted ones.
    ///
    /// # Errors
    /// Returns the errors of reading.
    fn held(&self) -> Result<Vec<Held>, Failure> {
        let mut held = Vec::new();
        for sheet in &self.sheet {
            let table = sheet.table()?;
            held.push(Held {
                name: sheet.name.into(),
                result: sheet.result(TableResult::of(&table), None, HALF_MIRROR, 1.0),
                table,
            });
        }
        for pair in &self.results {
            let result = read_channel(&pair.result, self.channel.as_deref())?;
            let table = result.seen(&tables::read(&pair.table)?)?.into_owned();
            held.push(Held {
                name: name(pair, &self.results),
                result,
                table,
            });
        }
        Ok(held)
    }
}

/// Returns the name of a result: that of its file without the ending, or its path if another file
/// has this name.
fn name(pair: &Pair, all: &[Pair]) -> String {
    let stem = |file: &Path| {
        file.file_stem()
            .map(|stem| stem.to_string_lossy().into_owned())
    };
    let own = stem(&pair.result);
    let same = all.iter().filter(|other| stem(&other.result) == own);
    match own {
        Some(own) if same.count() == 1 => own,
        _ => pair.result.display().to_string(),
    }
}
