//! placeholder

pub mod captures;
pub mod photo;
