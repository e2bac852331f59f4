//! TODO

pub mod element;
pub mod light;
pub mod material;
pub mod mirror;
pub mod ray;
pub mod roughness;
pub mod triangle;
