//! Mid-air images of whole pictures, and how alike two pictures look (feature `images`).
//!
//! A picture, a result and a table enter; a rendered picture or measures of likeness leave. The room may touch
//! predictions, samples, the model and the reading of pictures.

pub mod metrics;
pub mod plane;
pub mod render;
pub mod sheet;
pub mod spot;
