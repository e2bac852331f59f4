//! Estimates the diffraction spread `a`, corner size `c` and reflectance `mu` of a retroreflective sheet from
//! photographs of mid-air images.

#![forbid(unsafe_code)]

pub mod baseline;
pub mod bound;
pub mod camera;
pub mod captures;
pub mod chart;
pub mod cli;
pub mod clip;
pub mod covariance;
pub mod defects;
pub mod edge;
pub mod estimate;
pub mod export;
pub mod factor;
pub mod hermite;
pub mod illumination;
pub mod joint;
pub mod kernel;
pub mod layout;
pub mod likelihood;
pub mod lobe;
pub mod loss;
pub mod measure;
pub mod microfacet;
pub mod noise;
pub mod page;
pub mod photo;
pub mod pixels;
pub mod place;
pub mod plane;
pub mod plot;
pub mod predict;
pub mod profile;
pub mod reference;
pub mod reflectance;
pub mod report;
pub mod saturation;
pub mod scene;
pub mod select;
pub mod sfr;
pub mod sheet;
pub mod shift;
pub mod simulate;
pub mod solve;
pub mod spot;
pub mod spread;
pub mod start;
pub mod study;
pub mod truth;
pub mod verbs;
pub mod view;
pub mod wave;
pub mod window;
