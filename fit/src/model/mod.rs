//! The blur of a sheet as a transfer function: ray shift, diffraction lobe, wave optics, rough facets; and the camera's.
//!
//! A direction of the table, a kernel and its numbers enter; the OTF along a line of the image leaves, with its derivatives, and the
//! edge that it blurs. The room knows no photograph but for the widths of its bins. It may touch `names`, `numerics` and
//! `photographs`.

pub mod baseline;
pub mod blur;
pub mod camera;
pub mod edge;
pub mod lobe;
pub mod microfacet;
pub mod spread;
pub mod wave;
