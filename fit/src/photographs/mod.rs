//! TODO

pub mod captures;
pub mod chart;
pub mod defects;
pub mod edge;
pub mod illumination;
pub mod measure;
pub mod noise;
pub mod photo;
pub mod profile;
pub mod saturation;
pub mod sfr;
pub mod window;
