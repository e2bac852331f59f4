//! Data sheets of cells: eta over all directions, spots of dihedral errors, and what tolerances cost.
//!
//! A dissected cell and a [`request::DatasheetRequest`] enter. A [`sheet::Datasheet`] leaves, and
//! text, CSV, JSON and a page of HTML are made of one or of two of them. Everything is exact
//! (`beams`): no ray is traced. Nothing is printed or written.

mod bend;
mod figures;
mod map;
mod page;
pub(crate) mod report;
pub(crate) mod request;
mod sheet;
mod spots;
mod surface;
mod tolerance;

pub use map::EtaMap;
pub(crate) use page::page;
pub use request::DatasheetRequest;
pub(crate) use sheet::steps;
pub use sheet::{CellFacts, Datasheet, SurfaceSheet, datasheet};
pub use spots::{Spot, SpotDiagram};
pub use surface::Surface;
pub use tolerance::{Spread, Tolerance};
