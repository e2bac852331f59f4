//! What a person looks at: pictures of curves, and the page in HTML (feature `report`).
//!
//! Results, predictions and studies enter; SVG, PNG and HTML leave as bytes. The room computes nothing that a result
//! does not hold, but for the profiles of the likelihood. It may touch every room but
//! `cli`.

pub mod page;
pub mod picture;
pub mod plot;
pub mod speed;
