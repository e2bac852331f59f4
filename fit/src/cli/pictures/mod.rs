//! Verbs of `pictures`: what a person looks at.

pub(super) mod compare;
pub(super) mod explore;
pub(super) mod export;
pub(super) mod render;
