//! The blur of a sheet as a transfer function (ray shift, diffraction lobe, wave optics, rough
//! facets), and that of the camera.
//!
//! A direction of the table, a kernel and its numbers enter. The OTF along a line of the image, its
//! derivatives, and the edge that it blurs leave. Of a photograph the room knows only the
//! widths of its bins. It may touch `names`, `numerics` and `photographs`.

pub(crate) mod baseline;
mod blur;
mod camera;
mod edge;
mod exits;
mod lobe;
pub(crate) mod microfacet;
mod spread;
pub(crate) mod wave;

pub(crate) use baseline::Baseline;
#[cfg(test)]
pub(crate) use baseline::{fresnel, returned};
pub(crate) use blur::Blur;
pub(crate) use camera::{Camera, Lens};
pub(crate) use edge::{Curve, Model};
pub(crate) use exits::ExitBins;
pub(crate) use lobe::CUT;
pub(crate) use spread::{Even, Grid};
#[cfg(test)]
pub(crate) use wave::Fault;
