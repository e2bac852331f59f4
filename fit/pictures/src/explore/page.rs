//! The page: numbers as JSON, scripts, style and markup in one file.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::error::Error;
use crate::explore::gaps::Gaps;
use crate::explore::grid::{Grid, UNIT};
use crate::explore::lattice::{Ending, Lattice, MARGIN};
use crate::explore::mixed::{FAINT, Misfit};
use crate::explore::scaling::{Scaling, stretches};
use crate::explore::search;
use crate::explore::span::{Span, known};
use crate::explore::stencil::Nodes;
use crate::images::{RenderProgress, TAIL};
use edges::names::{Kernel, LobeShape, ParameterKind};
use estimator::model::Lobe;
use estimator::model::{Baseline, CUT};
use estimator::predict::{Criterion, Fitted};
use estimator::result::{Domain, Number, Parameter, ResultFile};

/// Markup of the page, with the places of style, data and scripts.
const MARKUP: &str = include_str!("page/page.html");

/// Style sheet.
const STYLE: &str = include_str!("page/page.css");

/// Scripts, in the order in which the page runs them.
const SCRIPTS: [&str; 7] = [
    include_str!("page/fft.js"),
    include_str!("page/polygons.js"),
    include_str!("page/sheet.js"),
    include_str!("page/blur.js"),
    include_str!("page/pictures.js"),
    include_str!("page/show.js"),
    include_str!("page/main.js"),
];

/// Picture that the page offers besides its own.
#[derive(Debug, Clone)]
pub struct Source {
    /// Name that the page shows.
    pub name: String,
    /// Bytes of a PNG with sRGB values.
    pub png: Vec<u8>,
}

/// Settings that the page shows first; those that are `None` are chosen by the page.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct Start {
    /// Floating distance, mm.
    pub distance: Option<f64>,
    /// Incidence, degrees.
    pub incidence: Option<f64>,
    /// Azimuth, degrees.
    pub azimuth: Option<f64>,
    /// Width of the picture, mm.
    pub width: Option<f64>,
    /// Luminance of the white of the source, cd/m2.
    pub luminance: Option<f64>,
    /// Luminance behind the image, in units of the white of the source.
    pub ambient: Option<f64>,
}

/// Contents of a page.
pub struct Explorer<'a> {
    /// Result and table.
    pub sheet: Fitted<'a>,
    /// Ranges of the sliders.
    pub span: Span,
    /// Settings that are shown first.
    pub start: Start,
    /// Name of the result, for the title.
    pub title: String,
    /// Picture of the user; `None` if the page shows its own only.
    pub source: Option<Source>,
}

/// Page, with what was measured of it.
pub struct Page {
    /// The file.
    pub html: String,
    /// Largest error of mixing.
    pub misfit: Misfit,
    /// True if it is that of a colour, which the page shows by its mean wavelength.
    pub is_of_colours: bool,
    /// Count of places at which it was measured.
    pub places: usize,
    /// Count of directions of the grid.
    pub directions: usize,
}

/// Value of a parameter at an incidence, with the row of the covariance.
#[derive(Serialize)]
struct Value {
    incidence_deg: Option<f64>,
    value: f64,
    standard_error: Option<f64>,
    row: Option<usize>,
}

/// Parameters of the sheet; each is empty if the kernel has none.
#[derive(Serialize)]
struct Values {
    spread: Vec<Value>,
    c: Vec<Value>,
    mu: Vec<Value>,
}

/// Transfer of the lobe with a = 1/mm at evenly spaced frequencies.
#[derive(Serialize)]
struct LobeData {
    /// Distance that holds all light but the share [`TAIL`], mm.
    reach: f64,
    step: f64,
    values: Vec<f64>,
}

/// Numbers of the page.
#[derive(Serialize)]
struct Data<'a> {
    title: &'a str,
    design: &'a str,
    kernel: Kernel,
    lobe: Option<LobeShape>,
    spread_name: &'static str,
    size_name: &'static str,
    by_hand: bool,
    half_mirror: f64,
    seen_in_mirror: bool,
    verdict: Option<&'static str>,
    incidence: Nodes,
    azimuth: Option<Nodes>,
    state: Nodes,
    scaling: Scaling,
    colours: Option<[f64; 3]>,
    bend: f64,
    ends: Ending,
    kink: f64,
    unit: f64,
    lattices: &'a [Lattice],
    gaps: Option<&'a Gaps>,
    margin: usize,
    tail: f64,
    cut: f64,
    faint: f64,
    real: bool,
    energy: &'a [f64],
    reach: &'a [f64],
    values: &'a str,
    table: Option<LobeData>,
    /// Gain and count of own facets and of the front, `[incidence, axis, kind]`.
    gains: Vec<[[(f64, i32); 2]; 2]>,
    parameters: Values,
    covariance: &'a [Vec<Option<f64>>],
    span: Span,
    start: Start,
    domain: Option<&'a Domain>,
    places: usize,
    misfit: [f64; 2],
    goal: f64,
    letter: Criterion,
    warnings: Vec<String>,
    source: Option<[String; 2]>,
    version: &'static str,
}

/// Makes the page of a sheet.
///
/// # Errors
/// Returns [`Error::Sheet`] if the blur cannot be computed, and [`Error::Large`] if the numbers do
/// not fit into a page.
pub fn page(explorer: &Explorer<'_>, progress: RenderProgress<'_>) -> Result<Page, Error> {
    if explorer.sheet.table.passage.is_some() {
        return Err(Error::Polarised);
    }
    let found = search::grid(&explorer.sheet, &explorer.span, progress)?;
    let (sheet, span) = (&explorer.sheet, &explorer.span);
    let (of_colours, more) = search::misfit_of_colours(sheet, span, &found.grid, progress)?;
    let (misfit, places) = (found.misfit.or(of_colours), found.places + more);
    let data = data(explorer, &found.grid, misfit, places);
    // A script element ends at its end tag, wherever that stands; JSON may write < as an escape.
    let json = serde_json::to_string(&data)
        .expect("all keys are strings and all values are numbers or text")
        .replace('<', "\\u003c");
    let scripts = SCRIPTS.concat();
    // A browser runs the script and takes the style sheet that have these hashes, and no others.
    // Both begin with the line feed behind their tags.
    let hash = |text: &str| STANDARD.encode(Sha256::digest(format!("\n{text}")));
    let html = [
        ("{{style hash}}", hash(STYLE).as_str()),
        ("{{script hash}}", &hash(&scripts)),
        ("{{style}}", STYLE),
        ("{{scripts}}", &scripts),
        ("{{data}}", &json),
    ]
    .into_iter()
    .fold(MARKUP.to_owned(), |text, (place, part)| {
        text.replacen(place, part, 1)
    });
    Ok(Page {
        html,
        misfit,
        is_of_colours: misfit.pixel > found.misfit.pixel,
        places,
        directions: found.grid.energy.len(),
    })
}

fn data<'a>(explorer: &'a Explorer<'_>, grid: &'a Grid, misfit: Misfit, places: usize) -> Data<'a> {
    let (result, table) = (explorer.sheet.result, explorer.sheet.table);
    let kernel = result.kernel;
    let size = ParameterKind::size_of(kernel);
    Data {
        title: &explorer.title,
        design: &result.table.design,
        kernel,
        lobe: result.lobe,
        spread_name: ParameterKind::spread_of(kernel).name(),
        size_name: size.name(),
        by_hand: result.is_by_hand(),
        half_mirror: result.half_mirror,
        seen_in_mirror: result.seen_in_mirror == Some(true),
        verdict: result.fit.as_ref().map(|fit| fit.verdict.name()),
        incidence: grid.incidence,
        azimuth: known(grid.azimuth.first).map(|_| grid.azimuth),
        state: grid.state,
        scaling: grid.scaling,
        colours: stretches(result),
        bend: grid.bend,
        ends: grid.ends,
        kink: grid.kink,
        unit: UNIT,
        lattices: &grid.lattices,
        gaps: grid.gaps.as_ref(),
        margin: MARGIN,
        tail: TAIL,
        cut: CUT,
        faint: FAINT,
        real: grid.real,
        energy: &grid.energy,
        reach: &grid.reach,
        values: &grid.text,
        table: table_of(kernel, result.lobe),
        gains: gains(kernel, grid, table.provenance.refractive_index),
        parameters: values(result),
        covariance: &result.covariance.matrix,
        span: explorer.span,
        start: explorer.start,
        domain: result.domain.as_ref(),
        places,
        misfit: [misfit.pixel, misfit.peak],
        goal: search::WANTED,
        letter: Criterion::USUAL,
        warnings: explorer.sheet.warnings(),
        source: explorer.source.as_ref().map(|source| {
            let address = format!("data:image/png;base64,{}", STANDARD.encode(&source.png));
            [source.name.clone(), address]
        }),
        version: env!("CARGO_PKG_VERSION"),
    }
}

/// Returns the parameters of a result.
fn values(result: &ResultFile) -> Values {
    let row = |kind: ParameterKind, incidence_deg: Option<f64>| {
        let names = &result.covariance.names;
        names
            .iter()
            .position(|name| name.kind == kind && name.at == incidence_deg)
    };
    let one = |kind: ParameterKind, number: &Number| Value {
        incidence_deg: None,
        value: number.value.unwrap_or(0.0),
        standard_error: number.standard_error,
        row: row(kind, None),
    };
    let all = |kind: ParameterKind, parameter: Option<&Parameter>| -> Vec<Value> {
        match parameter {
            None => Vec::new(),
            Some(Parameter::Shared(number)) => vec![one(kind, number)],
            Some(Parameter::PerAngle { per_angle }) => per_angle
                .iter()
                .map(|own| Value {
                    incidence_deg: Some(own.incidence_deg),
                    value: own.value.unwrap_or(0.0),
                    standard_error: own.standard_error,
                    row: row(kind, Some(own.incidence_deg)),
                })
                .collect(),
        }
    };
    let size = ParameterKind::size_of(result.kernel);
    let sizes = result.c_mm.or(result.surface_roughness);
    Values {
        spread: all(ParameterKind::spread_of(result.kernel), result.spread()),
        c: sizes.iter().map(|own| one(size, own)).collect(),
        mu: all(ParameterKind::Mu, result.mu.as_ref()),
    }
}

/// Returns the transfer of a round lobe; `None` for the separable one, which the page computes
/// itself, and for kernels without a lobe.
fn table_of(kernel: Kernel, lobe: Option<LobeShape>) -> Option<LobeData> {
    // A cubic through points of this step errs by 0.0157^4 x 260 x 9/384 = 4e-7 for the radial
    // lobe, whose fourth derivative by 2 pi f is at most 260.
    const STEP: f64 = 0.0025;
    const END: f64 = 3.5;
    let shape = lobe.filter(|&lobe| kernel.has_lobe() && lobe.round())?;
    let count = (END / STEP) as usize;
    let at = |k: usize| shape.otf(1.0, STEP * k as f64, [1.0, 0.0]).0;
    let digits = |value: f64| (value * 1e7).round() / 1e7;
    Some(LobeData {
        reach: shape.reach_mm(1.0, TAIL),
        step: STEP,
        values: (0..=count).map(|k| digits(at(k))).collect(),
    })
}

/// Returns the gains of rough facets at the incidences of the grid; none for other kernels.
fn gains(kernel: Kernel, grid: &Grid, index: f64) -> Vec<[[(f64, i32); 2]; 2]> {
    let at = |k: usize| {
        let radians = grid.incidence.place(k).to_radians();
        let along = |normal| Baseline::new(kernel, radians, index, normal);
        Some([along([1.0, 0.0])?.gains(), along([0.0, 1.0])?.gains()])
    };
    (0..grid.incidence.count).filter_map(at).collect()
}
