//! Names of the file format: every HDF5 name, and the version.
//!
//! `FORMAT.md` describes them for authors of other readers, so change it together with this file.
//! Raise [`VERSION`] if an old reader would misread the file.

use std::ffi::CStr;

/// Newest version of the format, the first that has the fate `reflected_by_front`.
///
/// A table is written in the first version that can say all of it.
pub const VERSION: u64 = 4;

/// First version that has [`deviation::GROUP`] and [`attribute::OPTIONS`].
pub(crate) const VERSION_OF_DEVIATIONS: u64 = 2;

/// First version that has the fate `trapped`, [`exact::PATH_PASSES`] and [`exact::PATH_JONES`].
pub(crate) const VERSION_OF_PASSES: u64 = 3;

/// Value of the root attribute `format`.
pub(crate) const FORMAT: &str = "retroreflective ray-shift table";

/// Value of the root attribute `Conventions`: the rules that names of dimensions and units follow.
pub(crate) const CONVENTIONS: &str = "CF-1.11";

/// Conventions of the frame in one sentence.
pub(crate) const FRAME: &str = "Travel direction d = -n cos(incidence) + t sin(incidence), n the \
outward normal of the sheet and t the in-plane unit vector at the azimuth, right-handed about n \
from azimuth_zero; a ray that enters at p and leaves at p' has the shift p' - p = (u, v) with u \
along t and v along n x t, in edge lengths; arrays are [incidence, azimuth, shift_v, shift_u].";

/// Dimension scale: name, unit and meaning.
#[derive(PartialEq)]
pub(crate) struct DimensionScale {
    pub(crate) name: &'static str,
    pub(crate) c_name: &'static CStr,
    pub(crate) units: &'static str,
    pub(crate) long_name: &'static str,
}

/// Dataset over scales.
pub(crate) struct Variable {
    pub(crate) name: &'static str,
    pub(crate) scales: &'static [&'static DimensionScale],
    pub(crate) units: &'static str,
    pub(crate) long_name: &'static str,
}

pub(crate) const INCIDENCE: DimensionScale = DimensionScale {
    name: "incidence_deg",
    c_name: c"incidence_deg",
    units: "degree",
    long_name: "angle of incidence outside the sheet, from its normal",
};
pub(crate) const AZIMUTH: DimensionScale = DimensionScale {
    name: "azimuth_deg",
    c_name: c"azimuth_deg",
    units: "degree",
    long_name: "azimuth of incidence about the normal, from azimuth_zero; NaN for the mean over \
    all azimuths",
};
pub(crate) const SHIFT_V: DimensionScale = DimensionScale {
    name: "shift_v",
    c_name: c"shift_v",
    units: "edge_length",
    long_name: "ray shift along v = n x u, bin centres",
};
pub(crate) const SHIFT_U: DimensionScale = DimensionScale {
    name: "shift_u",
    c_name: c"shift_u",
    units: "edge_length",
    long_name: "ray shift along u, the in-plane travel direction, bin centres",
};
pub(crate) const FATE_NAME: DimensionScale = DimensionScale {
    name: "fate_name",
    c_name: c"fate_name",
    units: "1",
    long_name: "what became of a ray",
};
pub(crate) const RANDOMISATION: DimensionScale = DimensionScale {
    name: "randomisation",
    c_name: c"randomisation",
    units: "1",
    long_name: "index of the independent randomisation of the samples",
};

pub(crate) const HISTOGRAM: Variable = Variable {
    name: "histogram",
    scales: &[&INCIDENCE, &AZIMUTH, &SHIFT_V, &SHIFT_U],
    units: "1",
    long_name: "probability of the shift, given that the ray is retroreflected within the range",
};
pub(crate) const COUNTS: Variable = Variable {
    name: "counts",
    scales: &[&INCIDENCE, &AZIMUTH, &RANDOMISATION, &SHIFT_V, &SHIFT_U],
    units: "1",
    long_name: "retroreflected rays in the bin",
};
pub(crate) const RETROREFLECTED: Variable = Variable {
    name: "retroreflected",
    scales: &[&INCIDENCE, &AZIMUTH],
    units: "1",
    long_name: "retroreflected fraction of the launched rays, out_of_range included",
};
pub(crate) const STANDARD_ERROR: Variable = Variable {
    name: "standard_error",
    scales: &[&INCIDENCE, &AZIMUTH],
    units: "1",
    long_name: "standard error of retroreflected",
};
pub(crate) const FATE: Variable = Variable {
    name: "fate",
    scales: &[&INCIDENCE, &AZIMUTH, &FATE_NAME],
    units: "1",
    long_name: "fraction of the launched rays by fate",
};
pub(crate) const FATE_COUNTS: Variable = Variable {
    name: "fate_counts",
    scales: &[&INCIDENCE, &AZIMUTH, &RANDOMISATION, &FATE_NAME],
    units: "1",
    long_name: "launched rays by fate",
};
pub(crate) const RAYS: Variable = Variable {
    name: "rays",
    scales: &[&INCIDENCE, &AZIMUTH],
    units: "1",
    long_name: "launched rays, 0 if exact",
};

/// Name of a dimension without coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Dimension(pub(crate) &'static str);

/// Names of the group of polygons, its attribute, its flat datasets and their dimensions.
pub(crate) mod exact {
    use super::Dimension;

    pub(crate) const PATH: Dimension = Dimension("path");
    pub(crate) const BOUND: Dimension = Dimension("bound");
    pub(crate) const VERTEX: Dimension = Dimension("vertex");
    pub(crate) const SHIFT_AXIS: Dimension = Dimension("shift_axis");
    pub(crate) const ENTRY_AXIS: Dimension = Dimension("entry_axis");
    pub(crate) const DEVIATION_AXIS: Dimension = Dimension("deviation_axis");
    pub(crate) const FIELD_OUT: Dimension = Dimension("field_out");
    pub(crate) const FIELD_IN: Dimension = Dimension("field_in");
    pub(crate) const COMPLEX_PART: Dimension = Dimension("complex_part");
    pub(crate) const PLANE: Dimension = Dimension("plane");
    pub(crate) const NORMAL_AXIS: Dimension = Dimension("normal_axis");
    pub(crate) const GROUP: &str = "exact";
    pub(crate) const ENTRANCE_AREA: &str = "entrance_area";
    pub(crate) const PATH_DIRECTION: &str = "path_direction";
    pub(crate) const PATH_MATRIX: &str = "path_matrix";
    pub(crate) const PATH_OFFSET: &str = "path_offset";
    pub(crate) const PATH_WEIGHT: &str = "path_weight";
    pub(crate) const PATH_DEVIATION: &str = "path_deviation";
    pub(crate) const PATH_PASSES: &str = "path_passes";
    pub(crate) const PATH_JONES: &str = "path_jones";
    pub(crate) const PATH_CUBE: &str = "path_cube";
    pub(crate) const POLYGON_START: &str = "polygon_start";
    pub(crate) const POLYGON_VERTEX: &str = "polygon_vertex";
}

/// Names of the group of rays by shift and deviation, its attributes, its flat datasets and their
/// dimensions.
pub(crate) mod deviation {
    use super::Dimension;

    pub(crate) const BOUND: Dimension = Dimension("bound");
    pub(crate) const ENTRY: Dimension = Dimension("entry");
    pub(crate) const GROUP: &str = "deviation";
    pub(crate) const CELLS: &str = "cells";
    pub(crate) const BINS: &str = "bins";
    pub(crate) const RANGE: &str = "range";
    pub(crate) const START: &str = "entry_start";
    pub(crate) const PLACE: &str = "entry_place";
    pub(crate) const RAYS: &str = "entry_rays";
}

/// Names of the attributes of the root and of datasets.
pub(crate) mod attribute {
    pub(crate) const CONVENTIONS: &str = "Conventions";
    pub(crate) const FORMAT: &str = "format";
    pub(crate) const VERSION: &str = "version";
    pub(crate) const FRAME: &str = "frame";
    pub(crate) const AZIMUTHS: &str = "azimuths";
    pub(crate) const CONTENT_HASH: &str = "content_hash";
    pub(crate) const SHIFT_RANGE: &str = "shift_range";
    pub(crate) const GENERATOR: &str = "generator";
    pub(crate) const DESIGN: &str = "design";
    pub(crate) const MESH_HASH: &str = "mesh_hash";
    pub(crate) const EDGE_LENGTH: &str = "edge_length";
    pub(crate) const EDGE_LENGTH_UNIT: &str = "edge_length_unit";
    pub(crate) const AZIMUTH_ZERO: &str = "azimuth_zero";
    pub(crate) const REFRACTIVE_INDEX: &str = "refractive_index";
    pub(crate) const BACK: &str = "back";
    pub(crate) const LOSSES: &str = "losses";
    pub(crate) const REFLECTANCE: &str = "reflectance";
    pub(crate) const METHOD: &str = "method";
    pub(crate) const SAMPLER: &str = "sampler";
    pub(crate) const SEED: &str = "seed";
    pub(crate) const ANGULAR_TOLERANCE_DEG: &str = "angular_tolerance_deg";
    pub(crate) const TOLERANCE: &str = "tolerance";
    pub(crate) const LATTICE: &str = "lattice";
    pub(crate) const WAVELENGTH_NM: &str = "wavelength_nm";
    pub(crate) const METAL_INDEX: &str = "metal_index";
    pub(crate) const SHARDS: &str = "shards";
    pub(crate) const SYMMETRY_ROTATIONS: &str = "symmetry_rotations";
    pub(crate) const SYMMETRY_MIRROR_DEG: &str = "symmetry_mirror_deg";
    pub(crate) const DIRECTION_TOLERANCE: &str = "direction_tolerance";
    pub(crate) const OPTIONS: &str = "options";
    pub(crate) const UNITS: &str = "units";
    pub(crate) const LONG_NAME: &str = "long_name";
}
