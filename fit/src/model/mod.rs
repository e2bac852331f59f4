//! TODO

pub mod baseline;
pub mod camera;
pub mod kernel;
pub mod lobe;
pub mod microfacet;
pub mod model;
pub mod shift;
pub mod spread;
pub mod wave;
