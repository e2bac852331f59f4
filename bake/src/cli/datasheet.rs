//! `bake datasheet`: reads its options, makes the data sheet of one cell or of two, and writes it.

use crate::cell::Prepared;
use crate::cli::calls::Caller;
use crate::cli::cell::{CellArgs, IndexArgs};
use crate::cli::display::ProgressDisplay;
use crate::datasheet::{Datasheet, DatasheetRequest, datasheet, page, report, steps};
use crate::error::Error;
use crate::optics::material;
use crate::plan::{default, heading};
use crate::run::Progress;
use clap::Args;
use meshes::Mesh;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use tables::Outputs;
use tables::cli::{in_a_line, list, number, print, reserve, warn, whole};
use tables::options::SceneOptions;

/// Options of `bake datasheet`.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub(crate) struct DatasheetArgs {
    /// Mesh file of one cell: .obj, .gltf, .glb, .stl or .ply
    mesh: PathBuf,
    /// Mesh of a second cell, which is compared with the first
    second: Option<PathBuf>,
    /// File to write: .html (a page), .csv (the maps) or .json (everything)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    index: IndexArgs,
    /// Incidences of spots and tolerances, degrees
    ///
    /// One to four angles: a list such as 0,30, or start:stop:step.
    #[arg(
        long,
        value_name = "ANGLES",
        default_value = "0,30",
        allow_hyphen_values = true
    )]
    incidence: String,
    /// Azimuth of spots and tolerances, degrees
    #[arg(long, value_parser = number, value_name = "DEG", default_value_t = 0.0)]
    azimuth: f64,
    /// Distance from the sheet to the mid-air image, mm
    #[arg(long, value_parser = number, value_name = "MM", default_value_t = 300.0)]
    distance: f64,
    /// Standard deviation of the dihedral errors of random cells, mrad
    #[arg(long, value_parser = number, value_name = "MRAD", default_value_t = 0.5)]
    error_mrad: f64,
    /// Number of random cells, 2 to 200
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = whole::<u32>(0..))]
    cells: u32,
    /// Seed of the random cells
    #[arg(long, default_value_t = default::SEED, value_parser = whole::<u64>(0..))]
    seed: u64,
    /// Step of the map's incidences and azimuths, degrees
    #[arg(
        long,
        value_parser = number,
        value_name = "DEG",
        default_value_t = 2.5,
        help_heading = heading::ACCURACY
    )]
    step: f64,
    /// Largest incidence of the map, degrees
    #[arg(
        long,
        value_parser = number,
        value_name = "DEG",
        default_value_t = 70.0,
        help_heading = heading::ACCURACY
    )]
    up_to: f64,
    /// Largest deviation of retroreflected light, degrees
    #[arg(
        long = "angular-tolerance",
        value_parser = number,
        value_name = "DEG",
        default_value_t = default::ANGULAR_TOLERANCE_DEG,
        help_heading = heading::ACCURACY
    )]
    angular_tolerance_deg: f64,
    /// Metal of coated facets: aluminium, silver or N,K
    ///
    /// N,K is the complex refractive index, such as 0.96,6.7.
    #[arg(
        long,
        value_name = "NAME",
        default_value = "aluminium",
        allow_hyphen_values = true,
        help_heading = heading::MATERIAL
    )]
    metal: String,
    /// Wavelength in vacuum, nm
    #[arg(
        long,
        value_parser = number,
        value_name = "NM",
        default_value_t = 550.0,
        help_heading = heading::MATERIAL
    )]
    wavelength_nm: f64,
    /// Options of the meshes; those of two meshes are the same.
    #[command(flatten, next_help_heading = heading::CELL)]
    cell: CellArgs,
    /// Prints everything as one JSON object
    #[arg(long, help_heading = heading::OUTPUT)]
    json: bool,
}

/// Kinds of files that a data sheet is written to.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Html,
    Csv,
    Json,
}

impl DatasheetArgs {
    /// Returns the conditions of the data sheet.
    fn request(&self) -> Result<DatasheetRequest, Error> {
        let nm = Some(self.wavelength_nm);
        let incidence_deg = list(&self.incidence)
            .map_err(|reason| Error::Usage(format!("--incidence {}: {reason}", self.incidence)))?;
        let request = DatasheetRequest {
            refractive_index: self.index.at(nm)?,
            metal: self.metal.clone(),
            metal_index: material::metal(&self.metal, nm)?,
            wavelength_nm: self.wavelength_nm,
            step_deg: self.step,
            up_to_deg: self.up_to,
            incidence_deg,
            azimuth_deg: self.azimuth,
            distance_mm: self.distance,
            error_mrad: self.error_mrad,
            cells: self.cells,
            seed: self.seed,
            angular_tolerance_deg: self.angular_tolerance_deg,
        };
        request.check()?;
        Ok(request)
    }

    /// Returns the meshes: one or two.
    fn meshes(&self) -> Vec<&Path> {
        let second = self.second.as_deref();
        std::iter::once(self.mesh.as_path()).chain(second).collect()
    }
}

/// Returns the kind of file that an output's name promises.
fn kind(file: &Path) -> Result<Kind, Error> {
    let extension = file
        .extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_lowercase();
    match extension.as_str() {
        "html" => Ok(Kind::Html),
        "csv" => Ok(Kind::Csv),
        "json" => Ok(Kind::Json),
        _ => Err(Error::Usage(format!(
            "-o {}: the extension must be .html, .csv or .json",
            file.display()
        ))),
    }
}

/// Dissected cell, with the largest step between the digits of its mesh.
type Dissected = (Prepared, Option<f64>);

/// Reads the meshes. Those of `held`, in memory, take the places of the files.
fn cells(args: &DatasheetArgs, held: [Option<&Mesh>; 2]) -> Result<Vec<Dissected>, Error> {
    let dissected = |(file, held): (&Path, Option<&Mesh>)| {
        let read = held.is_none().then(|| meshes::load(file)).transpose()?;
        let mesh = held.or(read.as_ref()).ok_or(Error::Elsewhere)?;
        let step = mesh.steps.iter().map(|step| step.max_element());
        let step = step.max_by(f64::total_cmp);
        let cell = args.cell.of_mesh(mesh, file, &SceneOptions::default())?;
        Ok((Prepared::new(cell), step))
    };
    args.meshes().into_iter().zip(held).map(dissected).collect()
}

/// Makes the data sheets. `begin` is told the name of each, with the number of its steps.
fn sheets(
    args: &DatasheetArgs,
    request: &DatasheetRequest,
    cells: &[Dissected],
    begin: impl Fn(&str, u64),
    progress: Progress<'_>,
) -> Result<Vec<Datasheet>, Error> {
    let named = cells.iter().zip(names(&args.meshes()));
    named
        .map(|((prepared, step), name)| {
            let index = request
                .refractive_index
                .or(prepared.cell().refractive_index);
            begin(&name, steps(index.unwrap_or(1.0), request));
            let sheet = datasheet(prepared, *step, request, progress)?;
            Ok(Datasheet { name, ..sheet })
        })
        .collect()
}

/// Data sheets of one cell or two for another program.
pub struct Sheets {
    /// The page.
    pub page: String,
    /// Everything, as JSON.
    pub json: String,
    /// Warnings, one sentence each.
    pub warnings: Vec<String>,
}

/// Makes the data sheets for another program. Nothing is printed or written.
///
/// # Errors
/// Fails as [`run`] does, and if the caller stopped it.
pub(super) fn called(
    args: &DatasheetArgs,
    held: [Option<&Mesh>; 2],
    caller: &Caller,
) -> Result<Sheets, Error> {
    let request = args.request()?;
    let cells = cells(args, held)?;
    let (done, all) = (AtomicU64::new(0), AtomicU64::new(0));
    let told = |steps| {
        let done = steps + done.fetch_add(steps, Ordering::Relaxed);
        (caller.told)(done, Some(all.load(Ordering::Relaxed)));
    };
    let begin = |_: &str, steps| {
        all.fetch_add(steps, Ordering::Relaxed);
    };
    let progress = Progress::new(&told).stopped_by(caller.stop);
    let sheets = sheets(args, &request, &cells, begin, progress)?;
    let of_cells = cells.iter().flat_map(|(own, _)| &own.cell().warnings);
    let warnings = of_cells.chain(sheets.iter().flat_map(|sheet| &sheet.remarks));
    Ok(Sheets {
        page: page(&sheets, "midair.datasheet"),
        json: report::json(&sheets).to_string(),
        warnings: warnings.cloned().collect(),
    })
}

/// Runs `bake datasheet`.
pub(crate) fn run(args: &DatasheetArgs) -> Result<(), Error> {
    let request = args.request()?;
    let kind = args.output.as_deref().map(kind).transpose()?;
    let mut outputs = Outputs::beside(args.meshes());
    let output = reserve(args.output.as_deref(), &mut outputs)?;
    let cells = cells(args, [None; 2])?;
    for (prepared, _) in &cells {
        warn(&prepared.cell().warnings);
    }
    let display = ProgressDisplay::of_steps();
    let told = |steps: u64| display.advance(steps);
    let begin = |name: &str, steps| display.begin(name, steps);
    let sheets = sheets(args, &request, &cells, begin, Progress::new(&told))?;
    display.finish();
    for sheet in &sheets {
        warn(&sheet.remarks);
    }
    if let (Some(output), Some(kind)) = (output, kind) {
        let text = match kind {
            Kind::Html => page(&sheets, &command()),
            Kind::Csv => report::csv(&sheets),
            Kind::Json => format!("{}\n", report::json(&sheets)),
        };
        output.commit(text.as_bytes())?;
    }
    Ok(print(&match args.json {
        true => format!("{}\n", report::json(&sheets)),
        false => report::text(&sheets),
    })?)
}

/// Returns the names of the meshes: their files without folder and extension where that tells them
/// apart.
fn names(meshes: &[&Path]) -> Vec<String> {
    let stem = |file: &&Path| {
        let stem = file.file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    };
    let stems: Vec<String> = meshes.iter().map(stem).collect();
    match &stems[..] {
        [a, b] if a == b => meshes
            .iter()
            .map(|file| file.display().to_string())
            .collect(),
        _ => stems,
    }
}

/// Returns the command line as typed, for the page.
fn command() -> String {
    let words = std::env::args().skip(1);
    let words = words.map(|word| match word.contains(char::is_whitespace) {
        true => format!("'{word}'"),
        false => word,
    });
    let line = words.fold(String::from("bake"), |line, word| format!("{line} {word}"));
    in_a_line(&line).into_owned()
}
