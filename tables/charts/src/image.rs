//! Pictures of cells within a chart, small whatever their number.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::colour::{STEPS, difference_colour, step_colour};

/// Cells of an even grid, each of one colour of the ordered scale.
#[derive(Debug, Clone)]
pub struct Image {
    /// Picture as PNG, in base64.
    pub(crate) png: String,
    pub(crate) from: [f64; 2],
    pub(crate) to: [f64; 2],
}

impl Image {
    /// Makes a picture of steps of the ordered scale, row by row from above; 0 is no colour.
    ///
    /// `from` is its lower left and `to` its upper right corner on the axes of the panel.
    pub fn of(steps: &[Vec<u8>], from: [f64; 2], to: [f64; 2]) -> Image {
        Image::coloured(steps, from, to, false)
    }

    /// Makes a picture of steps of the scale of differences, as [`Image::of`] does: from 1 (less)
    /// over the middle (none) to [`STEPS`] (more); 0 is no colour.
    pub fn of_differences(steps: &[Vec<u8>], from: [f64; 2], to: [f64; 2]) -> Image {
        Image::coloured(steps, from, to, true)
    }

    fn coloured(steps: &[Vec<u8>], from: [f64; 2], to: [f64; 2], is_signed: bool) -> Image {
        let columns = steps.first().map_or(0, Vec::len);
        Image {
            png: STANDARD.encode(png(columns, &steps.concat(), is_signed)),
            from,
            to,
        }
    }
}

/// Encodes steps of the ordered scale, or of that of differences, as PNG; without any step it is
/// empty.
pub(crate) fn png(columns: usize, steps: &[u8], is_signed: bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    if columns == 0 {
        return bytes;
    }
    let rows = steps.len() / columns;
    let colour = if is_signed {
        difference_colour
    } else {
        step_colour
    };
    let palette: Vec<u8> = (0..=STEPS).flat_map(colour).collect();
    let mut encoder = png::Encoder::new(&mut bytes, columns as u32, rows as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette);
    encoder.set_trns(&[0][..]);
    encoder.set_compression(png::Compression::High);
    let written = encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(steps));
    written.expect("memory takes any picture whose size is that of its data");
    bytes
}
