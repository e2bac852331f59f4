//! Exposure by which an image looks as bright as its source.

use edges::photographs::photo::picture::Picture;

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

#[cfg(test)]
mod tests {
    use super::*;
    use edges::photographs::photo::transfer::Transfer;

    fn picture(pixels: &[[f32; 3]]) -> Picture {
        Picture {
            width: pixels.len(),
            height: 1,
            planes: [0, 1, 2]
                .map(|k| pixels.iter().map(|p| p[k]).collect())
                .to_vec(),
            transfer: Transfer::Linear,
            warnings: Vec::new(),
        }
    }

    /// Checks exposures by hand, with the weights of Rec. 709: 0.2126, 0.7152 and 0.0722. Numbers
    /// of f32 round by 1e-7.
    #[test]
    fn the_brightest_pixels_become_alike_unless_a_colour_is_clipped() {
        let white = picture(&[[0.0; 3], [0.8; 3]]);
        let cases = [
            // Light of 0.2 with 0.05 about it.
            (picture(&[[0.1; 3], [0.2; 3]]), 0.0, 0.8 / 0.2),
            (picture(&[[0.1; 3], [0.2; 3]]), 0.05, 0.8 / 0.25),
            // Pure green of 0.4: its luminance would allow 0.8 / 0.28608, its code 0.8 / 0.4.
            (picture(&[[0.0, 0.4, 0.0]]), 0.0, 0.8 / 0.4),
            (picture(&[[0.0; 3]]), 0.0, 1.0),
        ];
        for (image, ambient, expected) in &cases {
            let found = automatic(&white, image, *ambient);
            assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
        }
        // The brightest pixel of the source is its green one; its brightest colour is the blue one.
        let source = picture(&[[0.0, 0.5, 0.0], [0.0, 0.0, 1.0]]);
        for ambient in [0.0, 0.03] {
            let found = automatic(&source, &picture(&[[0.1, 0.2, 0.0]]), ambient);
            let luminance = 0.1 * 0.2126 + 0.2 * 0.7152 + ambient;
            assert!(
                (found / (0.5 * 0.7152 / luminance) - 1.0).abs() < 1e-6,
                "{found}"
            );
        }
    }
}
