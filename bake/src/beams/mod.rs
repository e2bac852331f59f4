//! TODO

pub mod beam;
pub mod bins;
pub mod body;
pub mod candidate;
pub mod exact;
pub mod mean;
pub mod parts;
pub mod paths;
pub mod rim;
pub mod view;
