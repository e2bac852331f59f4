//! Page in which a designer moves sliders and sees the mid-air image at once.
//!
//! A result, a table and pictures enter. One self-contained page in HTML leaves as bytes. The
//! transform of the ray shift is computed here ahead, on a `grid` of directions. The page mixes the
//! nodes of the grid and convolves; `mixed` does the same in Rust, so that the error of mixing can
//! be measured and stated.

mod gaps;
mod grid;
mod lattice;
mod mixed;
mod page;
mod scaling;
mod search;
mod span;
mod stencil;
mod unit;

pub(crate) use grid::MOST_CORNERS;
#[cfg(test)]
pub(crate) use mixed::misfit_of;
pub use page::{Explorer, Source, Start, page};
pub use search::WANTED;
#[cfg(test)]
pub(crate) use search::grid;
pub use span::Span;
