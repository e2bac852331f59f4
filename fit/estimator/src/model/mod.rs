//! The blur of a sheet as a transfer function (ray shift, diffraction lobe, wave optics, rough
//! facets), and that of the camera.
//!
//! A direction of the table, a kernel and its numbers enter. The OTF along a line of the image, its
//! derivatives, and the edge that it blurs leave. Of a photograph this module knows only the
//! widths of its bins.

pub mod baseline;
mod camera;
mod departure;
mod edge;
mod exits;
pub mod further;
mod lobe;
pub mod polarised;
mod spread;
pub mod wave;

pub use baseline::Baseline;
pub use baseline::{fresnel, returned};
pub use camera::{Camera, Lens};
pub use departure::Departure;
pub use edge::{Blur, Curve, Model, Otf};
pub(crate) use exits::ExitBins;
pub use further::{Further, OwnBlur};
pub use lobe::{CUT, Lobe, microfacet};
pub(crate) use spread::{Even, Grid};
pub use wave::Fault;
