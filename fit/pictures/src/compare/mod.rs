//! Sheets side by side, for a designer who has to choose one: what can be read of the mid-air image
//! by each, in which ambient light, and from where.
//!
//! Sheets and the conditions of a place enter. Numbers leave, as text, CSV, JSON or one page of
//! HTML, which shows a picture through each sheet too. The criterion of a readable letter is that of
//! [`estimator::predict::Criterion`].

mod comparison;
mod gallery;
mod page;
mod seat;
mod text;

pub use comparison::{Compared, Comparison, Conditions, Contender, Everywhere, Ratio, compare};
pub use gallery::{Gallery, Shown, gallery};
pub use page::page;
pub use seat::{Behind, Seat, Sight};
