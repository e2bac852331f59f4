//! Photographs, estimates and images.

mod campaigns;
mod channels;
mod edges;
mod forward;
mod many_edges;
mod pictures;
mod predict;
