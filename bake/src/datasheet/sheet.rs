//! The data sheet of one cell: what its mesh says, its maps, its spots and its tolerances.

use crate::cell::{ExactCell, Part, Prepared};
use crate::datasheet::bend::Corner;
use crate::datasheet::map::EtaMap;
use crate::datasheet::request::DatasheetRequest;
use crate::datasheet::spots::{ERRORS_MRAD, SpotDiagram};
use crate::datasheet::surface::Surface;
use crate::datasheet::tolerance::{Tolerance, random_cells};
use crate::error::Error;
use crate::geometry::polygon;
use crate::plan;
use crate::run::Progress;
use meshes::EdgeLengthFrom;
use rayon::prelude::*;
use tables::Symmetry;

/// What the mesh of a cell says.
#[derive(Debug, Clone, PartialEq)]
pub struct CellFacts {
    /// Name of the design.
    pub design: String,
    /// Hash of the mesh file, lower-case hex.
    pub mesh_hash: String,
    /// Edge length as used, file units.
    pub edge_length: f64,
    /// Where the edge length comes from.
    pub edge_length_from: EdgeLengthFrom,
    /// Unit of the file; `None` if nobody says it, and mm is taken.
    pub unit: Option<String>,
    /// Edge length c, mm.
    pub c_mm: f64,
    /// Coarsest step of the coordinates in the file, file units; `None` if they have the digits of
    /// f64.
    pub coordinate_step: Option<f64>,
    /// Refractive index behind the front face; 1 for a hollow cell.
    pub refractive_index: f64,
    /// Symmetry about the sheet's normal.
    pub symmetry: Symmetry,
    /// Lattice vectors in the entrance plane, edge lengths; `None` if the cell has none.
    pub lattice: Option<[[f64; 2]; 2]>,
    /// Number of cubes in the mesh if they are separate, and how many of them differ; `None` if the
    /// mesh is one piece.
    pub cubes: Option<[usize; 2]>,
    /// Area of the entrance of the mesh, square edge lengths.
    pub entrance_area: f64,
    /// Height of the entrance plane over the apex, edge lengths.
    pub depth: f64,
    /// Dihedral errors of the mesh itself: largest over its cubes, mrad; `None` without one corner
    /// in each cube.
    pub dihedral_error_mrad: Option<f64>,
}

/// Map of one surface.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceSheet {
    /// Surface of the facets.
    pub surface: Surface,
    /// Eta over all directions.
    pub map: EtaMap,
}

/// Data sheet of a cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Datasheet {
    /// Name for titles: the design, unless the caller gives another one.
    pub name: String,
    /// What the mesh says.
    pub cell: CellFacts,
    /// Conditions of the data sheet.
    pub request: DatasheetRequest,
    /// One map for each surface, the same directions in all.
    pub surfaces: Vec<SurfaceSheet>,
    /// Spots of ideal mirrors, for each incidence and each error; empty if the cell has not one
    /// corner in each cube.
    pub spots: Vec<SpotDiagram>,
    /// Tolerances for each surface and each incidence.
    pub tolerances: Vec<Tolerance>,
    /// Remarks, one sentence each.
    pub remarks: Vec<String>,
}

/// Makes the data sheet of a cell.
///
/// `coordinate_step` is the coarsest step of the coordinates in the file, file units; `None` if they
/// have the digits of f64. `progress` is told one for each azimuth of a map and for each tolerance.
///
/// # Errors
/// Returns an [`Error`] if a condition is out of range, if the cell has facets that the exact method
/// does not take, or if the caller stopped the work.
pub fn datasheet(
    prepared: &Prepared,
    coordinate_step: Option<f64>,
    request: &DatasheetRequest,
    progress: Progress<'_>,
) -> Result<Datasheet, Error> {
    request.check()?;
    let no_planes = |reason: &str| {
        Error::Failed(format!(
            "a data sheet needs plane facets, which the exact method follows: {reason}; for other \
            cells, `bake trace` and `bake inspect` give eta by rays"
        ))
    };
    let exact = prepared.exact().map_err(no_planes)?;
    if !prepared.cell().glass.is_empty() {
        return Err(no_planes("light goes through faces of glass"));
    }
    let parts = prepared.cubes().unwrap_or_default();
    let corners: Option<Vec<Corner>> = parts.iter().map(Corner::of).collect();
    let corners = corners.filter(|corners| !corners.is_empty());
    let cell = facts(prepared, coordinate_step, request, corners.as_deref());
    let of_mesh = prepared
        .cell()
        .refractive_index_at(Some(request.wavelength_nm));
    let index_left_out = request.refractive_index.or(of_mesh).is_none();
    let of_surface = |surface: &Surface| {
        let tolerance = request.angular_tolerance_deg.to_radians();
        (
            *surface,
            surface.rules(cell.refractive_index, request.metal_index, tolerance),
        )
    };
    let surfaces: Vec<_> = Surface::of_index(cell.refractive_index)
        .iter()
        .map(of_surface)
        .collect();
    let steps = [request.step_deg, request.up_to_deg];
    let mut maps = Vec::new();
    for (surface, rules) in &surfaces {
        let map = EtaMap::new(exact, rules, cell.symmetry, steps, &|azimuths| {
            progress.tell(azimuths as u64);
        });
        maps.push(SurfaceSheet {
            surface: *surface,
            map,
        });
        if progress.is_stopped() {
            return Err(Error::Stopped);
        }
    }
    let random = corners
        .as_ref()
        .and_then(|all| random_cells(&parts, all, request));
    let places = surfaces
        .iter()
        .flat_map(|own| request.incidence_deg.iter().map(move |i| (own, i)));
    let places: Vec<_> = places.collect();
    let tolerances: Vec<Tolerance> = places
        .into_par_iter()
        .map(|((surface, rules), &incidence)| {
            let place = (incidence, cell.c_mm);
            let own = Tolerance::new(exact, random.as_deref(), (*surface, rules), request, place);
            progress.tell(1);
            own
        })
        .collect();
    Ok(Datasheet {
        name: cell.design.clone(),
        spots: corners.map_or(Vec::new(), |all| {
            spots(&parts, &all, request, &surfaces[0].1)
        }),
        remarks: remarks(&cell, random.is_none(), index_left_out),
        cell,
        request: request.clone(),
        surfaces: maps,
        tolerances,
    })
}

/// Returns the number of steps that [`datasheet`] tells its progress.
pub(crate) fn steps(refractive_index: f64, request: &DatasheetRequest) -> u64 {
    let surfaces = Surface::of_index(refractive_index).len() as u64;
    let around = (360.0 / request.step_deg).round().max(4.0) as u64;
    surfaces * (around + request.incidence_deg.len() as u64)
}

/// Returns the spots of each incidence and each error.
fn spots(
    parts: &[Part],
    corners: &[Corner],
    request: &DatasheetRequest,
    rules: &crate::optics::Rules,
) -> Vec<SpotDiagram> {
    let bent = |error_mrad: f64| {
        let bent = parts.iter().zip(corners);
        let bent = bent.map(|(part, corner)| corner.bent(part, [1e-3 * error_mrad; 3]));
        ExactCell::new(&bent.collect::<Option<Vec<Part>>>()?).ok()
    };
    let cells = ERRORS_MRAD.map(|error| (error, bent(error)));
    let mut diagrams = Vec::new();
    for &incidence in &request.incidence_deg {
        for (error, cell) in &cells {
            diagrams.extend(cell.as_ref().map(|cell| {
                SpotDiagram::new(cell, rules, *error, [incidence, request.azimuth_deg])
            }));
        }
    }
    diagrams
}

/// Returns what the mesh says.
fn facts(
    prepared: &Prepared,
    coordinate_step: Option<f64>,
    request: &DatasheetRequest,
    corners: Option<&[Corner]>,
) -> CellFacts {
    let cell = prepared.cell();
    let own = cell.refractive_index_at(Some(request.wavelength_nm));
    let lattice = cell.entrance.lattice;
    CellFacts {
        design: cell.design.clone(),
        mesh_hash: cell.mesh_hash.clone(),
        edge_length: cell.edge_length,
        edge_length_from: cell.edge_length_from,
        unit: cell.unit.clone(),
        c_mm: cell.edge_length * mm(cell.unit.as_deref()),
        coordinate_step,
        refractive_index: request.refractive_index.or(own).unwrap_or(1.0),
        symmetry: prepared.symmetry(),
        lattice: lattice.map(|sides| sides.map(|side| side.to_array())),
        cubes: prepared.cubes_apart(),
        entrance_area: polygon::area(&cell.entrance.polygon),
        depth: cell.entrance.height,
        dihedral_error_mrad: corners.map(|corners| {
            let errors = corners.iter().flat_map(Corner::own_errors);
            1e3 * errors.map(f64::abs).fold(0.0, f64::max)
        }),
    }
}

/// Returns the length of a unit, mm; a file without a unit is taken to be in mm.
fn mm(unit: Option<&str>) -> f64 {
    match unit {
        Some("nm") => 1e-6,
        Some("um") => 1e-3,
        Some("cm") => 10.0,
        Some("m") => 1000.0,
        Some("in") => 25.4,
        _ => 1.0,
    }
}

/// Returns the remarks about a cell.
fn remarks(cell: &CellFacts, no_errors: bool, index_left_out: bool) -> Vec<String> {
    let mut remarks = Vec::new();
    if index_left_out {
        remarks.push(plan::INDEX_LEFT_OUT.into());
    }
    if cell.unit.is_none() {
        remarks.push(format!(
            "the mesh does not say its unit: mm are taken, so the edge length is {} mm; give --unit",
            cell.c_mm
        ));
    }
    if no_errors {
        remarks.push(
            "dihedral errors are left out: they need cells of separate cubes, or a periodic cell \
             of one cube, with one corner of three planes in each cube"
                .into(),
        );
    }
    remarks
}
