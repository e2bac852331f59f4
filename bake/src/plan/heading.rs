//! Headings that group the options of a verb in its help.
//!
//! Options of every day have no heading: clap prints them first, under "Options".

/// Options that decide how accurate a table is and what it records.
pub(crate) const ACCURACY: &str = "Accuracy and content of the table";
/// Options about facets, materials and losses.
pub(crate) const MATERIAL: &str = "Facets and material";
/// Options about the mesh file and its cell.
pub(crate) const CELL: &str = "Cell and mesh";
/// Options about the method and its rays.
pub(crate) const RAYS: &str = "Method and rays";
/// Options for bakes that take long or run in parts.
pub(crate) const LONG_RUNS: &str = "Long runs";
/// Options about what is measured, and how often.
pub(crate) const MEASUREMENT: &str = "Measurement";
/// Options about reports and threads.
pub(crate) const OUTPUT: &str = "Output and threads";

/// Options of a design that give the ideal shape of its cubes.
pub(crate) const SHAPE: &str = "Shape of corner cubes";
/// Options of a design that make its cubes less than ideal.
pub(crate) const IMPERFECT: &str = "Imperfect corner cubes";
/// Options of the designs that are no corner cubes.
pub(crate) const ELEMENT: &str = "Plates and beads";
