//! The action of one surface on light: reflection, refraction, losses, roughness, and the rules
//! that decide what counts as retroreflected.
//!
//! Directions, normals and refractive indices enter. Directions, fields and fates leave. This
//! module knows no mesh, only one triangle at a time.

pub(crate) mod element;
mod elementary;
mod light;
pub(crate) mod material;
pub(crate) mod mirror;
mod quick;
mod ray;
pub(crate) mod roughness;
mod rules;
pub(crate) mod triangle;

pub(crate) use light::{Backing, PolarisedLight, passes_outside};
pub use material::{metal, refractive_index};
#[cfg(test)]
pub(crate) use mirror::deviation;
pub(crate) use mirror::{mirrored, reflect, reflection, refract};
pub(crate) use quick::Quick;
pub(crate) use ray::{Incidence, Ray};
pub(crate) use roughness::reach_rad;
pub(crate) use rules::{BOUNCE_LIMIT, LEAST_POWER, Leaving, PASSES, Rules, fate_of_leaving};
pub(crate) use triangle::{EDGE_ON, Triangle, slack_after};
