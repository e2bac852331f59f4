//! The file format: every HDF5 name, the version, and the round trip between [`Table`] and file.
//!
//! `FORMAT.md` describes the same for writers of other readers; a change here is a change there, and of
//! [`VERSION`] where an old reader would misread the file.

mod deviations;
mod load;
mod place;
mod polygons;
mod store;

use std::ffi::CStr;

pub(crate) use deviations::Flat as FlatDeviations;
pub(crate) use load::load;
pub(crate) use store::{create, store};

/// Newest version of the format. A table is written in the first version that says all of it.
pub const VERSION: u64 = 2;

/// The first version that has [`deviation::GROUP`] and [`attribute::OPTIONS`].
const VERSION_OF_DEVIATIONS: u64 = 2;

/// Value of the root attribute `format`.
pub(crate) const FORMAT: &str = "retroreflective ray-shift table";

/// The frame conventions in one sentence.
const FRAME: &str = "Travel direction d = -n cos(incidence) + t sin(incidence), n the outward normal of the sheet \
and t the in-plane unit vector at the azimuth, right-handed about n from azimuth_zero; a ray that enters at p and \
leaves at p' has the shift p' - p = (u, v) with u along t and v along n x t, in edge lengths; arrays are \
[incidence, azimuth, shift_v, shift_u].";

/// Greatest number of bytes that the arrays of one table may take in memory.
pub(crate) const MOST_BYTES: u64 = 1 << 31;

/// A dimension scale: name, unit and meaning.
#[derive(PartialEq)]
struct Scale {
    name: &'static str,
    c_name: &'static CStr,
    units: &'static str,
    long_name: &'static str,
}

/// A dataset over scales.
struct Variable {
    name: &'static str,
    scales: &'static [&'static Scale],
    units: &'static str,
    long_name: &'static str,
}

const INCIDENCE: Scale = Scale {
    name: "incidence_deg",
    c_name: c"incidence_deg",
    units: "degree",
    long_name: "angle of incidence outside the sheet, from its normal",
};
const AZIMUTH: Scale = Scale {
    name: "azimuth_deg",
    c_name: c"azimuth_deg",
    units: "degree",
    long_name: "azimuth of incidence about the normal, from azimuth_zero; NaN for the mean over all azimuths",
};
const SHIFT_V: Scale = Scale {
    name: "shift_v",
    c_name: c"shift_v",
    units: "edge_length",
    long_name: "ray shift along v = n x u, bin centres",
};
const SHIFT_U: Scale = Scale {
    name: "shift_u",
    c_name: c"shift_u",
    units: "edge_length",
    long_name: "ray shift along u, the in-plane travel direction, bin centres",
};
const FATE_NAME: Scale = Scale {
    name: "fate_name",
    c_name: c"fate_name",
    units: "1",
    long_name: "what became of a ray",
};
const RANDOMISATION: Scale = Scale {
    name: "randomisation",
    c_name: c"randomisation",
    units: "1",
    long_name: "index of the independent randomisation of the samples",
};

const HISTOGRAM: Variable = Variable {
    name: "histogram",
    scales: &[&INCIDENCE, &AZIMUTH, &SHIFT_V, &SHIFT_U],
    units: "1",
    long_name: "probability of the shift, given that the ray is retroreflected within the range",
};
const COUNTS: Variable = Variable {
    name: "counts",
    scales: &[&INCIDENCE, &AZIMUTH, &RANDOMISATION, &SHIFT_V, &SHIFT_U],
    units: "1",
    long_name: "retroreflected rays in the bin",
};
const RETROREFLECTED: Variable = Variable {
    name: "retroreflected",
    scales: &[&INCIDENCE, &AZIMUTH],
    units: "1",
    long_name: "retroreflected fraction of the launched rays, out_of_range included",
};
const STANDARD_ERROR: Variable = Variable {
    name: "standard_error",
    scales: &[&INCIDENCE, &AZIMUTH],
    units: "1",
    long_name: "standard error of retroreflected",
};
const FATE: Variable = Variable {
    name: "fate",
    scales: &[&INCIDENCE, &AZIMUTH, &FATE_NAME],
    units: "1",
    long_name: "fraction of the launched rays by fate",
};
const FATE_COUNTS: Variable = Variable {
    name: "fate_counts",
    scales: &[&INCIDENCE, &AZIMUTH, &RANDOMISATION, &FATE_NAME],
    units: "1",
    long_name: "launched rays by fate",
};
const RAYS: Variable = Variable {
    name: "rays",
    scales: &[&INCIDENCE, &AZIMUTH],
    units: "1",
    long_name: "launched rays, 0 if exact",
};

/// The group of polygons, its attribute and its flat datasets.
mod exact {
    pub const GROUP: &str = "exact";
    pub const ENTRANCE_AREA: &str = "entrance_area";
    pub const PATH_DIRECTION: &str = "path_direction";
    pub const PATH_MATRIX: &str = "path_matrix";
    pub const PATH_OFFSET: &str = "path_offset";
    pub const PATH_WEIGHT: &str = "path_weight";
    pub const PATH_DEVIATION: &str = "path_deviation";
    pub const POLYGON_START: &str = "polygon_start";
    pub const POLYGON_VERTEX: &str = "polygon_vertex";
}

/// The group of exit directions of a table of rays, its attributes and its flat datasets.
mod deviation {
    pub const GROUP: &str = "deviation";
    pub const CELLS: &str = "cells";
    pub const BINS: &str = "bins";
    pub const RANGE: &str = "range";
    pub const START: &str = "entry_start";
    pub const PLACE: &str = "entry_place";
    pub const RAYS: &str = "entry_rays";
}

/// Root attributes.
mod attribute {
    pub const FORMAT: &str = "format";
    pub const VERSION: &str = "version";
    pub const FRAME: &str = "frame";
    pub const AZIMUTHS: &str = "azimuths";
    pub const CONTENT_HASH: &str = "content_hash";
    pub const SHIFT_RANGE: &str = "shift_range";
    pub const GENERATOR: &str = "generator";
    pub const DESIGN: &str = "design";
    pub const MESH_HASH: &str = "mesh_hash";
    pub const EDGE_LENGTH: &str = "edge_length";
    pub const EDGE_LENGTH_UNIT: &str = "edge_length_unit";
    pub const AZIMUTH_ZERO: &str = "azimuth_zero";
    pub const REFRACTIVE_INDEX: &str = "refractive_index";
    pub const BACK: &str = "back";
    pub const LOSSES: &str = "losses";
    pub const REFLECTANCE: &str = "reflectance";
    pub const METHOD: &str = "method";
    pub const SAMPLER: &str = "sampler";
    pub const SEED: &str = "seed";
    pub const ANGULAR_TOLERANCE_DEG: &str = "angular_tolerance_deg";
    pub const TOLERANCE: &str = "tolerance";
    pub const LATTICE: &str = "lattice";
    pub const WAVELENGTH_NM: &str = "wavelength_nm";
    pub const METAL_INDEX: &str = "metal_index";
    pub const SHARDS: &str = "shards";
    pub const SYMMETRY_ROTATIONS: &str = "symmetry_rotations";
    pub const SYMMETRY_MIRROR_DEG: &str = "symmetry_mirror_deg";
    pub const DIRECTION_TOLERANCE: &str = "direction_tolerance";
    pub const OPTIONS: &str = "options";
    pub const UNITS: &str = "units";
    pub const LONG_NAME: &str = "long_name";
}
