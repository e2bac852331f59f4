//! Optical transfer functions of a direction: of its ray shift, and of the waves of its polygons.
//!
//! A direction and a line enter; complex values by frequency leave.

pub(crate) mod aperture;
pub(crate) mod hermite;
pub(crate) mod polygon_wave;
pub(crate) mod ruling;
pub(crate) mod shift;
pub(crate) mod spots;
pub(crate) mod transform;
pub(crate) mod wave;
pub(crate) mod waves;
