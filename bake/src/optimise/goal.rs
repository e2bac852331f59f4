//! What is wanted of a cell and what may vary: a TOML file.

use crate::datasheet::Surface;
use crate::error::Error;
use crate::optics::{Rules, metal};
use crate::plan::default;
use documents::{Bounded, Bounds, Document, Table, choice, choices, incidence, readers, turn};
use meshes::design::{Design, Shape};
use num_complex::Complex64;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use std::path::Path;

/// Largest number of views after all lists are combined.
const MOST_AIMS: usize = 200;

readers! {
    distance = Bounds::new("from 1 to 1e6 mm", |x| (1.0..=1e6).contains(&x));
    frequency = Bounds::new("from 0.001 to 1000 /mm", |x| (0.001..=1e3).contains(&x));
    contrast = Bounds::new("at least 0 and below 1", |x| (0.0..1.0).contains(&x));
    weight = Bounds::new("from 0.001 to 1000", |x| (0.001..=1e3).contains(&x));
    wavelength = Bounds::new("from 100 to 1e6 nm", |x| (100.0..=1e6).contains(&x));
    cells = Bounds::new("from 100 to 1000000", |x| (200.0..=1e6).contains(&x));
    seed = Bounds::new("from 0 to 1e9", |x| (0.0..=1e9).contains(&x));
    edge_length = Bounds::new("from 0.001 to 100 mm", |x| (0.001..=100.0).contains(&x));
    cant = Bounds::new("from -34.5 to 52 degrees", |x| (-34.5..=52.0).contains(&x));
    truncation = Bounds::new("from 0 to 0.49", |x| (0.0..=0.49).contains(&x));
    index = Bounds::new("from 1 to 10", |x| (1.0..=10.0).contains(&x));
    errors = Bounds::new("from -10 to 10 mrad", |x| x.abs() <= 10.0);
}

/// What is made as large as possible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Best {
    /// Sharpness alone.
    Mtf,
    /// Light alone.
    Luminance,
    /// Both, as a front.
    Both,
}

impl Best {
    const NAMES: [&str; 3] = ["mtf", "luminance", "both"];

    fn from_name(name: &str) -> Option<Best> {
        match name {
            "mtf" => Some(Best::Mtf),
            "luminance" => Some(Best::Luminance),
            "both" => Some(Best::Both),
            _ => None,
        }
    }
}

/// Parameter of a cell that may vary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Parameter {
    /// Edge length c, mm.
    EdgeLength,
    /// Cant, degrees.
    Cant,
    /// Truncation, part of the height of the ideal top.
    Truncation,
    /// Refractive index.
    Index,
    /// Error of the dihedral angle at edge 1, 2 or 3, mrad.
    Error(usize),
}

impl Parameter {
    /// All parameters, in the order of the values of a cell.
    pub(crate) const ALL: [Parameter; 7] = [
        Parameter::EdgeLength,
        Parameter::Cant,
        Parameter::Truncation,
        Parameter::Index,
        Parameter::Error(0),
        Parameter::Error(1),
        Parameter::Error(2),
    ];

    /// Returns the name, with its unit.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Parameter::EdgeLength => "edge_length_mm",
            Parameter::Cant => "cant_deg",
            Parameter::Truncation => "truncation",
            Parameter::Index => "refractive_index",
            Parameter::Error(0) => "dihedral_error_1_mrad",
            Parameter::Error(1) => "dihedral_error_2_mrad",
            Parameter::Error(_) => "dihedral_error_3_mrad",
        }
    }

    /// Returns whether cells of a design have this parameter.
    ///
    /// Only canted cells have a cant. A truncated pair is a smaller pair, so that only full cubes
    /// have a truncation.
    pub(crate) fn is_of(self, shape: Shape) -> bool {
        let [cant, truncation] = match shape {
            Shape::Triangular | Shape::TriangularPair => [false, false],
            Shape::FullCube => [false, true],
            Shape::Canted => [true, false],
        };
        match self {
            Parameter::Cant => cant,
            Parameter::Truncation => truncation,
            Parameter::EdgeLength | Parameter::Index | Parameter::Error(_) => true,
        }
    }
}

/// Ends of the ranges of all parameters, in the order of [`Parameter::ALL`].
pub(crate) type Ranges = [[f64; 2]; Parameter::ALL.len()];

/// Distances at which one direction is seen.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Aim {
    /// Incidence in the air and azimuth, degrees.
    pub direction_deg: [f64; 2],
    /// Distances from the sheet to the image, mm, and their weights. The weights of all aims
    /// together sum to 1.
    pub distances: Vec<(f64, f64)>,
}

/// Directions of one view: incidences and azimuths, degrees.
pub(crate) type Directions = [Vec<f64>; 2];

/// What is wanted of a cell, and what may vary.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Goal {
    /// What is made as large as possible.
    pub best: Best,
    /// Frequencies in the mid-air image, 1/mm.
    pub frequencies: Vec<f64>,
    /// Least MTF of every frequency in every view, along both axes.
    pub least_mtf: f64,
    /// Number of cells to be tried.
    pub cells: u64,
    /// Seed of the search.
    pub seed: u64,
    /// All views, each direction once.
    pub aims: Vec<Aim>,
    /// Directions of each view.
    pub directions: Vec<Directions>,
    /// Designs to choose from.
    pub shapes: Vec<Shape>,
    /// What may vary; a range of one value is fixed.
    pub ranges: Ranges,
    /// Surface of the facets.
    pub surface: Surface,
    /// Complex refractive index of the metal.
    pub metal: Complex64,
    /// Wavelength in vacuum, nm.
    pub wavelength_nm: f64,
}

impl Goal {
    /// Reads and checks a goal.
    ///
    /// # Errors
    /// Returns [`Error::Goal`] with the first fault of the file and its line: an unknown or missing
    /// key, a number out of range, an empty list, or a parameter that no design has.
    pub(crate) fn load(file: &Path) -> Result<Goal, Error> {
        let document = Document::read(file)?;
        let asked: Asked = document.parse()?;
        let (aims, directions) = views(&document, asked.view)?;
        let count: usize = aims.iter().map(|aim| aim.distances.len()).sum();
        if !(1..=MOST_AIMS).contains(&count) || asked.frequency_per_mm.is_empty() {
            let frequencies = asked.frequency_per_mm.len();
            let why = format!(
                "names {count} combinations of distance, incidence and azimuth and {frequencies} \
                 frequencies; give 1 to {MOST_AIMS} in [[view]], and at least one in \
                 `frequency_per_mm`"
            );
            return Err(document.error(why).into());
        }
        let (part, Table(sheet)) = (asked.sheet.span(), asked.sheet.into_inner());
        let wrong = |why: String| Err(document.place(part.clone()).error(why).into());
        let unused = [
            (
                "cant_deg",
                sheet.cant_deg.is_some(),
                Parameter::Cant,
                "canted",
            ),
            (
                "truncation",
                sheet.truncation.is_some(),
                Parameter::Truncation,
                "full-cube",
            ),
        ];
        for (key, is_given, parameter, design) in unused {
            if is_given && !sheet.design.iter().any(|&shape| parameter.is_of(shape)) {
                return wrong(format!(
                    "`{key}` has no effect on these designs; add \"{design}\" to `design`, or \
                     remove it"
                ));
            }
        }
        let errors = sheet
            .dihedral_error_mrad
            .unwrap_or(vec![Range([0.0; 2]); 3]);
        let [Range(e1), Range(e2), Range(e3)] = errors[..] else {
            return wrong(format!(
                "`dihedral_error_mrad` names {} errors; give three, one for each edge",
                errors.len()
            ));
        };
        let metal = match metal(
            &sheet.metal.unwrap_or("aluminium".into()),
            Some(sheet.wavelength_nm),
        ) {
            Ok(metal) => metal,
            Err(error) => return wrong(error.to_string()),
        };
        let usual = Range([Design::new(Shape::Canted).cant_rad.to_degrees(); 2]);
        Ok(Goal {
            best: asked.best,
            frequencies: asked.frequency_per_mm,
            least_mtf: asked.least_mtf.unwrap_or(0.1),
            cells: asked.cells.unwrap_or(10_000),
            seed: asked.seed.unwrap_or(default::SEED),
            aims,
            directions,
            shapes: sheet.design,
            ranges: [
                sheet.edge_length_mm.0,
                sheet.cant_deg.unwrap_or(usual).0,
                sheet.truncation.unwrap_or(Range([0.0; 2])).0,
                sheet.refractive_index.0,
                e1,
                e2,
                e3,
            ],
            surface: sheet.surface,
            metal,
            wavelength_nm: sheet.wavelength_nm,
        })
    }

    /// Returns the rules of light for cells of a refractive index.
    pub(crate) fn rules(&self, refractive_index: f64) -> Rules {
        let tolerance = default::ANGULAR_TOLERANCE_DEG.to_radians();
        self.surface.rules(refractive_index, self.metal, tolerance)
    }
}

/// Checks the views and combines their lists.
fn views(
    document: &Document,
    views: Vec<toml::Spanned<Table<View>>>,
) -> Result<(Vec<Aim>, Vec<Directions>), Error> {
    let total: f64 = views.iter().map(|view| view.get_ref().0.weight()).sum();
    let (mut aims, mut directions) = (Vec::new(), Vec::new());
    for view in views {
        let (part, Table(view)) = (view.span(), view.into_inner());
        let lists = [
            ("distance_mm", &view.distance_mm),
            ("incidence_deg", &view.incidence_deg),
            ("azimuth_deg", &view.azimuth_deg),
        ];
        for (key, list) in lists {
            let is_twice = (1..list.len()).any(|k| list[..k].contains(&list[k]));
            let why = match (list.is_empty(), is_twice) {
                (true, _) => format!("`{key}` is empty; name at least one"),
                (_, true) => format!("`{key}` names a value twice; remove one"),
                _ => continue,
            };
            return Err(document.place(part).error(why).into());
        }
        view.add_to(&mut aims, total);
        directions.push([view.incidence_deg, view.azimuth_deg]);
    }
    Ok((aims, directions))
}

/// A goal as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Asked {
    #[serde(deserialize_with = "best")]
    best: Best,
    #[serde(deserialize_with = "frequency")]
    frequency_per_mm: Vec<f64>,
    #[serde(default, deserialize_with = "contrast")]
    least_mtf: Option<f64>,
    #[serde(default, deserialize_with = "cells")]
    cells: Option<u64>,
    #[serde(default, deserialize_with = "seed")]
    seed: Option<u64>,
    view: Vec<toml::Spanned<Table<View>>>,
    sheet: toml::Spanned<Table<Sheet>>,
}

/// Views of one weight: every combination of its lists.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct View {
    #[serde(deserialize_with = "distance")]
    distance_mm: Vec<f64>,
    #[serde(deserialize_with = "incidence")]
    incidence_deg: Vec<f64>,
    #[serde(deserialize_with = "turn")]
    azimuth_deg: Vec<f64>,
    #[serde(default, deserialize_with = "weight")]
    weight: Option<f64>,
}

impl View {
    fn weight(&self) -> f64 {
        self.weight.unwrap_or(1.0)
    }

    /// Adds the combinations, which share the weight of the view; `total` is that of all views.
    fn add_to(&self, aims: &mut Vec<Aim>, total: f64) {
        let directions = self.incidence_deg.len() * self.azimuth_deg.len();
        let weight = self.weight() / total / (self.distance_mm.len() * directions) as f64;
        for k in 0..directions {
            let (i, a) = (k / self.azimuth_deg.len(), k % self.azimuth_deg.len());
            let direction_deg = [self.incidence_deg[i], self.azimuth_deg[a]];
            let distances = self.distance_mm.iter().map(|&mm| (mm, weight));
            let known = aims
                .iter_mut()
                .find(|aim| aim.direction_deg == direction_deg);
            match known {
                Some(aim) => aim.distances.extend(distances),
                None => aims.push(Aim {
                    direction_deg,
                    distances: distances.collect(),
                }),
            }
        }
    }
}

/// What may vary, and what light meets.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Sheet {
    #[serde(deserialize_with = "designs")]
    design: Vec<Shape>,
    #[serde(deserialize_with = "edge_length")]
    edge_length_mm: Range,
    #[serde(default, deserialize_with = "cant")]
    cant_deg: Option<Range>,
    #[serde(default, deserialize_with = "truncation")]
    truncation: Option<Range>,
    #[serde(deserialize_with = "index")]
    refractive_index: Range,
    #[serde(default, deserialize_with = "errors")]
    dihedral_error_mrad: Option<Vec<Range>>,
    #[serde(deserialize_with = "surface")]
    surface: Surface,
    metal: Option<String>,
    #[serde(deserialize_with = "wavelength")]
    wavelength_nm: f64,
}

/// Fixed number, or a range `{ from = ..., to = ... }`.
#[derive(Clone, Copy)]
struct Range([f64; 2]);

impl Bounded for Range {
    fn within<'de, D: Deserializer<'de>>(value: D, bounds: Bounds) -> Result<Range, D::Error> {
        let value = toml::Value::deserialize(value)?;
        let read = match value.is_table() {
            true => <[f64; 2]>::within(value, bounds),
            false => f64::within(value, bounds).map(|fixed| [fixed; 2]),
        };
        read.map(Range)
            .map_err(|error| D::Error::custom(error.message()))
    }
}

fn best<'de, D: Deserializer<'de>>(value: D) -> Result<Best, D::Error> {
    choice(value, &Best::NAMES, Best::from_name)
}

fn designs<'de, D: Deserializer<'de>>(value: D) -> Result<Vec<Shape>, D::Error> {
    let known = |name: &str| Shape::from_name(name).ok();
    let shapes = choices(value, &Shape::ALL.map(Shape::name), known)?;
    match (1..shapes.len()).any(|k| shapes[..k].contains(&shapes[k])) {
        true => Err(D::Error::custom("names a design twice; remove one")),
        false => Ok(shapes),
    }
}

fn surface<'de, D: Deserializer<'de>>(value: D) -> Result<Surface, D::Error> {
    choice(value, &Surface::ALL.map(Surface::name), |name| {
        Surface::ALL.into_iter().find(|own| own.name() == name)
    })
}
