//! Pixels as a camera gives them: their noise, what neighbours share of it, and those that do not
//! follow the light.

pub(super) mod correlation;
pub(super) mod defects;
pub(super) mod noise;
pub(super) mod processing;
pub(super) mod saturation;
