//! Options of a bake as types, for the provenance of tables and for `bake trace`.
//!
//! The words of a table or of a command line enter; types leave. [`Word`] and [`StatedOptions`]
//! hold the words of a table. A word that this version knows becomes a type. A word of a later
//! version is kept as it is, so that a table that is written again keeps its bytes. No other crate
//! reads or makes these words. With the feature `cli` the types are values and options of a command
//! line (clap).

mod scene;
mod stated;
mod values;
mod word;

pub use scene::Record;
pub use scene::SceneOptions;
pub use scene::{NoRoughness, Roughness, Slopes};
pub use stated::StatedOptions;
pub use values::{Back, Element, Front, Losses, Method, NormalsFrom, Sampler};
pub use word::{Named, Word};
