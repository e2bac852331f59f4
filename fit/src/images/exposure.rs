//! Exposure by which an image looks as bright as its source.

use crate::photographs::photo::picture::Picture;

/// Returns the exposure that makes the brightest pixel of an image, with this ambient light, as
/// bright as that of its source, or a little darker so that no colour is clipped. Returns 1 if the
/// image is black.
pub(crate) fn automatic(source: &Picture, image: &Picture, ambient: f64) -> f64 {
    let alike = source.peak_luminance() / (image.peak_luminance() + ambient);
    // Blur mixes colours: a colour may then be brighter than any of the source, and be clipped.
    let unclipped = source.peak() / (image.peak() + ambient);
    let exposure = alike.min(unclipped);
    if exposure.is_finite() && exposure > 0.0 {
        exposure
    } else {
        1.0
    }
}
