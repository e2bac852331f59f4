//! `fit render`: makes the mid-air image of any picture.

use std::borrow::Cow;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::time::Instant;
use tables::cli as terminal;

use tables::{Outputs, Table};

use crate::cli::estimate::{check_model, read_channel};
use crate::cli::failure::Failure;
use crate::cli::options::by_hand::Numbers;
use crate::cli::options::light::Light;
use crate::cli::options::parse;
use crate::cli::options::sampled::Samples;
use crate::cli::output;
use crate::cli::progress::Bar;
use edges::names::Family;
use edges::photographs::photo;
use edges::photographs::photo::picture::Picture;
use edges::photographs::photo::transfer::Transfer;
use estimator::estimate::Forward;
use estimator::predict::Fitted;
use estimator::result::ResultFile;
use pictures::images::mid_air::{Exposure, Look, MidAir, Seconds, clipped};
use pictures::images::render::camera::Camera;
use pictures::images::render::view::CameraView;
use pictures::images::{RenderStep, Scale, Viewpoint, Writing};

/// Renders the mid-air image of a picture: blurred and dimmed by the fitted sheet.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The source is an EXR, PNG, TIFF or JPEG, grey or in colour. It shows the
picture upright, as it appears in mid air. Its pixels are squares of even
light. What lies outside of the source is black. A pixel of the result is the
mean of the mid-air image over its square, in the units of the source. The
result is as dim as the mid-air image; --exposure brightens it.

Examples:
  fit render --source content.png --params result.json --table pair.h5 \\
      --distance 300 --incidence 20 --azimuth 30 -o aerial.exr
  fit render --source content.png --params result.json --table pair.h5 \\
      --distance 150 --incidence 0 --azimuth 30 --exposure 10 --luminance 500 \\
      --ambient-nits 1 -o aerial.png --json
  fit render --source content.png --params result.json --table pair.h5 \\
      --distance 300 --incidence 20 --azimuth 30 --forward render --samples 64 \\
      -o sampled.exr --json

Without a fit, name a sheet, or give the numbers of a sheet by hand. These signs
are 0.2 m wide, and 1 m and 3 m away:
  fit render --source content.png --sheet prism-0.1 --width 200 --distance 1000 \\
      --incidence 20 --auto-exposure --beside -o near.png
  fit render --source content.png --c 0.15 --wavelength-nm 550 --mu 0.5 \\
      --table pair.h5 --distance 3000 --incidence 20 --azimuth 30 \\
      --width 200 --auto-exposure --beside -o far.png

Prisms bend blue light more than red. These tables of 650, 550 and 450 nm are
those of an example of bake trace:
  fit render --source content.png --c 0.15 --a-times-r 700 --mu 0.5 \\
      --table pair-650.h5 pair-550.h5 pair-450.h5 --distance 500 \\
      --incidence 40 --width 200 --auto-exposure -o dispersed.png

With --view, a camera sees the sheet. Each pixel then has its own incidence,
azimuth and distance, and with them its own blur and brightness. The table must
hold directions all around (bake trace --azimuth 0:345:15). VIEW.toml gives all
places in mm, as if the half mirror were not there:
    [camera]
    position_mm = [0, 0, 600]
    [image]                         # the mid-air image
    centre_mm = [0, 0, 0]
    right = [1, 0, 0]               # direction in which columns are counted
    down = [0, -1, 0]               # direction in which rows are counted
    pixel_pitch_mm = 0.2
    [sheet]
    position_mm = [0, 0, -300]
    normal = [0.34, 0, 0.94]        # towards the light
    first_edge = [0, 1, 0]          # azimuth 0
    seen_in_mirror = false          # true if the half mirror shows the sheet
    [ambient]                       # may be left out
    luminance = 0.002               # of the scene behind, source white = 1
    [coating]                       # may be left out
    refractive_index = 1.5          # adds the mirror image in the flat front

Words and formulas: fit/doc/model.md")]
pub(crate) struct Arguments {
    /// Picture that becomes a mid-air image.
    #[arg(long, value_name = "IMAGE")]
    pub source: PathBuf,
    /// Result that `fit estimate -o` wrote, as JSON.
    ///
    /// Without a fit, give --sheet, or --c and its companions, instead.
    #[arg(
        long,
        value_name = "RESULT.json",
        required_unless_present = "own_sheet",
        conflicts_with = "own_sheet"
    )]
    pub params: Option<PathBuf>,
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
    /// A --sheet brings its own. Three tables are those of red, green and blue light, where the
    /// index of the prisms differs; green's is that of the fit.
    #[arg(
        long,
        value_name = "TABLE.h5",
        num_args = 1..=3,
        required_unless_present = "sheet"
    )]
    pub table: Vec<PathBuf>,
    /// Floating distance R, mm.
    ///
    /// R is the length of the principal ray from the sheet to the image.
    #[arg(
        long,
        visible_alias = "floating-distance",
        value_name = "MM",
        value_parser = parse::positive,
        allow_negative_numbers = true,
        required_unless_present = "view",
        help_heading = "Place"
    )]
    pub distance: Option<f64>,
    /// Incidence in the air, degrees.
    #[arg(
        long,
        value_name = "DEG",
        value_parser = parse::incidence,
        allow_negative_numbers = true,
        required_unless_present = "view",
        help_heading = "Place"
    )]
    pub incidence: Option<f64>,
    /// File with the places of camera, image and sheet.
    ///
    /// Each pixel then has its own distance, incidence and azimuth. The file also gives pixel
    /// pitch, axes and ambient light. All its keys are shown below.
    #[arg(
        long,
        value_name = "VIEW.toml",
        conflicts_with_all = [
            "distance", "incidence", "azimuth", "pixel_pitch", "width", "tangential_axis",
            "seen_in_mirror", "ambient", "ambient_nits"
        ],
        help_heading = "Place"
    )]
    pub view: Option<PathBuf>,
    /// Largest error between tiles of --view, as a share.
    ///
    /// The share is of the brightest pixel. A smaller share makes more tiles.
    #[arg(
        long,
        value_name = "SHARE",
        default_value_t = 0.01,
        value_parser = parse::positive,
        help_heading = "Place"
    )]
    pub tolerance: f64,
    /// Azimuth of the light, degrees; that of the table if it holds one, 0 for a --sheet.
    #[arg(
        long,
        value_name = "DEG",
        value_parser = parse::turn,
        allow_negative_numbers = true,
        help_heading = "Place"
    )]
    pub azimuth: Option<f64>,
    /// Side of a pixel in the plane of the mid-air image, mm.
    ///
    /// Without this option, it is that of the fitted photographs.
    #[arg(long, value_name = "MM", value_parser = parse::positive, help_heading = "Picture")]
    pub pixel_pitch: Option<f64>,
    /// Width of the picture in the air, mm, in place of --pixel-pitch.
    ///
    /// Under a blur of more than 8191 pixels, the picture gets fewer of them, and a warning says
    /// so.
    #[arg(
        long,
        value_name = "MM",
        value_parser = parse::positive,
        allow_negative_numbers = true,
        conflicts_with = "pixel_pitch",
        help_heading = "Picture"
    )]
    pub width: Option<f64>,
    /// Direction of the plane of incidence, degrees.
    ///
    /// It is measured in the picture: 0 is right, 90 is down.
    #[arg(
        long,
        value_name = "DEG",
        default_value_t = 0.0,
        value_parser = parse::turn,
        allow_negative_numbers = true,
        help_heading = "Picture"
    )]
    pub tangential_axis: f64,
    /// The sheet is seen in the half mirror, not straight.
    ///
    /// It turns the direction of azimuths and of the sagittal axis in the picture: looked at
    /// straight, that axis is 90 degrees counter-clockwise from the tangential one.
    #[arg(long, help_heading = "Picture")]
    pub seen_in_mirror: bool,
    /// Light of source and room.
    #[command(flatten)]
    pub light: Light,
    /// Factor on the light of the result, like an exposure.
    #[arg(
        long,
        value_name = "X",
        default_value_t = 1.0,
        value_parser = parse::positive,
        help_heading = "Picture"
    )]
    pub exposure: f64,
    /// Makes the brightest pixel of the result as bright as that of the source.
    ///
    /// It is a little darker if a single colour would be brighter than any of the source. The
    /// factor is printed. Ambient light is made brighter with it.
    #[arg(long, conflicts_with = "exposure", help_heading = "Picture")]
    pub auto_exposure: bool,
    /// Puts the source beside the image, on the left.
    #[arg(long, help_heading = "Picture")]
    pub beside: bool,
    /// Camera that photographs the image: adds the blur of its pixel and of its lens.
    ///
    /// The result is that of `fit estimate`, which measured the lens in the reference photograph;
    /// with --channel, of the same channel. Use it to compare an image with a photograph, unless
    /// the source is a photograph by this camera, which has the blur already.
    #[arg(
        long,
        value_name = "RESULT.json",
        conflicts_with = "view",
        help_heading = "Picture"
    )]
    pub camera: Option<PathBuf>,
    /// Meaning of integers in the source: linear or srgb.
    ///
    /// Without this option the file decides: its cICP chunk, ICC profile, sRGB chunk, gAMA chunk or
    /// Exif data; without these, 8 bits are sRGB and 16 bits are linear.
    #[arg(long, value_name = "NAME", value_parser = parse::transfer, help_heading = "Picture")]
    pub transfer: Option<Transfer>,
    /// Forward model.
    ///
    /// spectral uses Fourier transforms. render draws samples, as a check.
    #[arg(long, value_enum, default_value_t, help_heading = "Forward model")]
    pub forward: Forward,
    /// Samples of the blur.
    #[command(flatten)]
    pub samples: Samples,
    /// Model that is required.
    ///
    /// The command fails if the result is of another model. Without this option, any model will do.
    #[arg(long, value_enum, help_heading = "Forward model")]
    pub model: Option<Family>,
    /// Number of threads; one per core if left out.
    #[arg(
        long,
        value_name = "N",
        help_heading = "Output and threads",
        value_parser = terminal::whole::<NonZeroUsize>(1..)
    )]
    pub threads: Option<NonZeroUsize>,
    /// Prints facts about the image as one JSON object.
    ///
    /// They are energy, contrast against the ambient light, angles, distance, errors and seconds.
    #[arg(long, help_heading = "Output and threads")]
    pub json: bool,
    /// File that receives the image: .exr, .png, .tif or .jpg.
    ///
    /// An .exr is linear, in 32-bit floats. A .png or .tif has 8 bits in sRGB, or 16 bits of linear
    /// light if the source is linear; a .png names this in a chunk. A .jpg is in sRGB.
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
}

/// Runs the verb.
///
/// # Errors
/// Fails if the source, the result, the table or the view cannot be used, if the table lacks a
/// direction, or if the output cannot be written.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let inputs = [&arguments.source].into_iter();
    let inputs = inputs
        .chain(&arguments.table)
        .chain(&arguments.params)
        .chain(&arguments.camera)
        .chain(&arguments.view);
    let mut outputs = Outputs::beside(inputs.map(PathBuf::as_path));
    let ending = || pictures::Error::Ending(arguments.output.clone());
    let writing = Writing::of(&arguments.output).ok_or_else(ending)?;
    let output = outputs.reserve(&arguments.output)?;
    let tables = arguments.tables()?;
    let pool = terminal::pool(arguments.threads)?;

    let started = Instant::now();
    let source = pool.install(|| photo::load_colour(&arguments.source, arguments.transfer))?;
    let result = arguments.result(&tables[tables.len() / 2], source.width)?;
    let tables = SeenTables::new(&result, tables.iter())?;
    let sheet = Fitted::new(&result, tables.own())?;
    let camera = arguments.camera()?;
    let read = started.elapsed().as_secs_f64();

    let progress = Bar::of_steps();
    let show = |part: RenderStep| progress.part(part.what, part.done, part.of);
    let wanted = arguments.wanted(&sheet, source.width, camera.as_ref())?;
    let made = pool.install(|| wanted.image(&sheet, tables.colours(), &source, &show));
    progress.done();
    let (image, mut facts) = made?;
    facts.lit_by(arguments.light.luminance);
    let rendered = started.elapsed().as_secs_f64();

    facts.warnings.extend(clipped(&image, writing));
    let bytes = pool.install(|| encoded(image, writing, arguments))?;
    output.commit(&bytes)?;
    let written = started.elapsed().as_secs_f64();
    terminal::warn(&facts.warnings);
    if !arguments.json {
        return Ok(terminal::print(&facts.text())?);
    }
    facts.seconds = Some(Seconds {
        read,
        render: rendered - read,
        write: written - rendered,
    });
    Ok(terminal::print(&output::json(&facts))?)
}

/// Tables of a sheet as the light of the setup sees them.
pub(in crate::cli) struct SeenTables<'a>(Vec<Cow<'a, Table>>);

impl<'a> SeenTables<'a> {
    /// Takes one table, or those of red, green and blue light.
    ///
    /// # Errors
    /// Returns [`Failure::Usage`] of another count, and the errors of [`ResultFile::seen`].
    pub(in crate::cli) fn new(
        result: &ResultFile,
        tables: impl ExactSizeIterator<Item = &'a Table>,
    ) -> Result<SeenTables<'a>, Failure> {
        if ![1, 3].contains(&tables.len()) {
            let message = "give one table, or three: those of red, green and blue light";
            return Err(Failure::conflict("fit render", message));
        }
        let all = tables.map(|table| result.seen(table));
        Ok(SeenTables(all.collect::<Result<_, _>>()?))
    }

    /// Returns the table of the fit: the only one, or that of green light.
    pub(in crate::cli) fn own(&self) -> &Table {
        &self.0[self.0.len() / 2]
    }

    /// Returns the tables of red, green and blue light, if there are three.
    pub(in crate::cli) fn colours(&self) -> Option<[&Table; 3]> {
        let [red, green, blue] = &self.0[..] else {
            return None;
        };
        Some([red, green, blue])
    }
}

impl Arguments {
    /// Reads the tables that are named, or that of the nominal sheet.
    ///
    /// # Errors
    /// Returns the errors of reading.
    fn tables(&self) -> Result<Vec<Table>, Failure> {
        if self.table.is_empty() {
            return Ok(vec![self.by_hand.table("fit render", None)?]);
        }
        let all = self.table.iter().map(|file| Ok(tables::read(file)?));
        all.collect()
    }

    /// Returns the result of the file that is named, or the numbers that are given, for a picture
    /// of so many columns.
    ///
    /// # Errors
    /// Fails if the file cannot be used, and returns [`Failure::Usage`] if the numbers say nothing
    /// of diffraction or nothing says how large a pixel is.
    fn result(&self, table: &Table, columns: usize) -> Result<ResultFile, Failure> {
        let Some(file) = &self.params else {
            let pitch = self.pitch_mm(columns);
            let pitch = pitch.or(self.view.is_some().then_some(1.0));
            let pitch = pitch.ok_or_else(|| {
                let message = "nothing says how large the picture is; give --width, its width in \
                    the air, mm";
                Failure::conflict("fit render", message)
            })?;
            return self.by_hand.result("fit render", pitch, table);
        };
        let result = read_channel(file, self.channel.as_deref())?;
        check_model(file, &result, self.model)?;
        Ok(result)
    }

    /// Returns the result whose camera photographs the image.
    ///
    /// # Errors
    /// Fails if the file cannot be used, or holds several channels of which none is named.
    fn camera(&self) -> Result<Option<ResultFile>, Failure> {
        let Some(file) = &self.camera else {
            return Ok(None);
        };
        let only = read_channel(file, None);
        let result = match &self.channel {
            Some(channel) => only.or_else(|_| read_channel(file, Some(channel)))?,
            None => only?,
        };
        Ok(Some(result))
    }

    /// Returns what the options ask for, for a picture of so many columns. `camera` is the result
    /// whose camera photographs the image.
    ///
    /// # Errors
    /// Fails if the file of the view cannot be used, or if the camera has no lens.
    pub(in crate::cli) fn wanted(
        &self,
        sheet: &Fitted<'_>,
        columns: usize,
        camera: Option<&ResultFile>,
    ) -> Result<MidAir, Failure> {
        let camera = camera.map(|own| {
            let file = self.camera.clone().unwrap_or_default();
            Camera::of(&own.camera).ok_or(pictures::Error::NoLens(file))
        });
        let look = match &self.view {
            Some(view) => Look::Camera {
                view: CameraView::load(view).map_err(pictures::Error::from)?,
                tolerance: self.tolerance,
            },
            None => Look::Afar {
                place: Viewpoint {
                    incidence_deg: self.incidence.unwrap_or(0.0),
                    azimuth_deg: (self.azimuth).or(parse::usual_azimuth(sheet.table, sheet.result)),
                    r_mm: self.distance.unwrap_or(f64::NAN),
                },
                scale: Scale {
                    pitch_mm: (self.pitch_mm(columns))
                        .unwrap_or(sheet.result.camera.pixel_pitch_mm),
                    tangential_axis_deg: self.tangential_axis,
                    seen_in_mirror: self.seen_in_mirror,
                },
                may_reduce: self.width.is_some(),
            },
        };
        Ok(MidAir {
            look,
            camera: camera.transpose()?,
            forward: self.forward,
            sampling: self.samples.sampling(),
            ambient: self.light.ambient(),
            exposure: match self.auto_exposure {
                true => Exposure::Automatic,
                false => Exposure::Factor(self.exposure),
            },
            beside: self.beside,
        })
    }

    /// Returns the side of a pixel that the options name, mm, for a picture of so many columns.
    fn pitch_mm(&self, columns: usize) -> Option<f64> {
        self.pixel_pitch
            .or(self.width.map(|width_mm| width_mm / columns as f64))
    }
}

fn encoded(
    image: Picture,
    writing: Writing,
    arguments: &Arguments,
) -> Result<Vec<u8>, pictures::Error> {
    let failed = |message| pictures::Error::Encode(arguments.output.clone(), message);
    writing.bytes(image).map_err(failed)
}
