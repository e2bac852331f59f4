//! placeholder

pub mod captures;
pub mod photo;
pub mod simulate;
