//! Why two pictures cannot be compared.

use std::path::PathBuf;

use crate::images::metrics::lpips;

/// Why two pictures cannot be compared.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum Error {
    /// Of two sizes.
    #[error("{} is {} x {} pixels, {} is {} x {}; crop or render one to the size of the other",
        rendered.display(), sizes[0][0], sizes[0][1], photo.display(), sizes[1][0], sizes[1][1])]
    Sizes {
        /// One.
        rendered: PathBuf,
        /// The other.
        photo: PathBuf,
        /// Columns and rows of both.
        sizes: [[usize; 2]; 2],
    },
    /// Too small for a window.
    #[error("{}: is smaller than {least} x {least} pixels, which {metric} needs; compare a larger \
    part", rendered.display())]
    Small {
        /// One.
        rendered: PathBuf,
        /// Pixels needed.
        least: usize,
        /// What needs them.
        metric: &'static str,
    },
    /// Weights that are none.
    #[error(transparent)]
    Lpips(#[from] lpips::Error),
}
