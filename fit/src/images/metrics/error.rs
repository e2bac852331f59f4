//! Reasons why two pictures cannot be compared.

use std::path::PathBuf;

use crate::images::metrics::lpips;

/// Reason why two pictures cannot be compared.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum Error {
    /// Pictures of different sizes.
    #[error("{} is {} x {} pixels, {} is {} x {}; crop or render one to the size of the other",
        rendered.display(), sizes[0][0], sizes[0][1], photo.display(), sizes[1][0], sizes[1][1])]
    Sizes {
        /// Rendered picture.
        rendered: PathBuf,
        /// Photograph.
        photo: PathBuf,
        /// Columns and rows of both pictures.
        sizes: [[usize; 2]; 2],
    },
    /// Pictures smaller than a metric's window.
    #[error("{}: is smaller than {least} x {least} pixels, which {metric} needs; compare a larger \
    part", rendered.display())]
    Small {
        /// Rendered picture.
        rendered: PathBuf,
        /// Smallest side that the metric can compare, pixels.
        least: usize,
        /// Name of the metric.
        metric: &'static str,
    },
    /// LPIPS weights that cannot be used.
    #[error(transparent)]
    Lpips(#[from] lpips::Error),
}
