//! TODO

pub mod baseline;
pub mod blur;
pub mod camera;
pub mod lobe;
pub mod microfacet;
pub mod model;
pub mod shift;
pub mod spread;
pub mod wave;
