//! Options that several verbs share, each with its default and its check.

pub(super) mod by_hand;
pub(super) mod expected;
#[cfg(feature = "full")]
pub(super) mod forward;
#[cfg(feature = "full")]
pub(super) mod light;
pub(super) mod parse;
pub(super) mod sampled;
pub(super) mod terms;
#[cfg(feature = "full")]
pub(super) mod view;
