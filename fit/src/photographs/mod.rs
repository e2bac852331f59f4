//! Photographs, and the edges in them.
//!
//! A manifest and image files enter (EXR, PNG, TIFF, JPEG; camera raw with the feature `raw`); planes of linear light,
//! edges, their profiles and measured MTFs leave, with what spoils them. The room knows no sheet and no model. It may
//! touch `numerics`, `names` and `document`.

pub mod captures;
pub mod chart;
pub mod defects;
pub mod edge;
pub mod illumination;
pub mod measure;
pub mod noise;
pub mod photo;
pub mod profile;
pub mod roi;
pub mod saturation;
pub mod sfr;
pub mod window;
