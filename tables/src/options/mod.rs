//! The options of a bake, as types: what a table's provenance is made of, and what `bake trace` is
//! asked for.
//!
//! The words of a table or of a command line enter; types leave. [`Word`] and [`StatedOptions`] are
//! the words of a table: what this version knows as a type, and what a later version wrote as it
//! stands, so that a table that is written again keeps its bytes. No other crate reads or makes
//! these words. With the feature `cli` the types are values and options of a command line (clap).
//! This room touches no other.

mod deviations;
mod roughness;
mod scene;
mod stated;
mod values;
mod word;

pub use deviations::Record;
pub use roughness::{NoRoughness, Roughness, Slopes};
pub use scene::SceneOptions;
pub use stated::StatedOptions;
pub use values::{Back, Element, Losses, Method, NormalsFrom, Sampler};
pub use word::{Named, Word};
