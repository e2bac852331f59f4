//! The stored samples of a picture, before they become light.

use image::metadata::Orientation;
use image::{DynamicImage, ImageBuffer, Luma, imageops};

/// Samples, those of a pixel side by side, row by row from the top left.
#[derive(Debug)]
pub(crate) enum Samples {
    /// Whole numbers up to 255.
    Bytes(Vec<u8>),
    /// Whole numbers up to 65535.
    Words(Vec<u16>),
    /// Any other numbers. True: they were whole numbers, and 1 is the largest that the file can
    /// hold. False: they were floats, without such a limit.
    Floats(Vec<f32>, bool),
}

/// What a sample beside the colours says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Alpha {
    /// Nothing that is known: there is none, or its meaning is not stated.
    None,
    /// The share of its pixel that is there. The colours are those of this share.
    Straight,
    /// The share of its pixel that is there. The colours were multiplied by it.
    Premultiplied,
}

/// The stored samples of a picture.
#[derive(Debug)]
pub(crate) struct Stored {
    /// Width and height, pixels.
    pub(crate) size: [usize; 2],
    pub(crate) samples: Samples,
    /// Number of samples of a pixel. The colours come first, then alpha.
    pub(crate) channels: usize,
    /// True for red, green and blue, false for grey.
    pub(crate) has_colour: bool,
    pub(crate) alpha: Alpha,
}

impl From<DynamicImage> for Stored {
    fn from(picture: DynamicImage) -> Stored {
        let colour = picture.color();
        Stored {
            size: [picture.width() as usize, picture.height() as usize],
            channels: colour.channel_count().into(),
            has_colour: colour.has_color(),
            alpha: if colour.has_alpha() {
                Alpha::Straight
            } else {
                Alpha::None
            },
            samples: match picture {
                DynamicImage::ImageLuma8(p) => Samples::Bytes(p.into_raw()),
                DynamicImage::ImageLumaA8(p) => Samples::Bytes(p.into_raw()),
                DynamicImage::ImageRgb8(p) => Samples::Bytes(p.into_raw()),
                DynamicImage::ImageRgba8(p) => Samples::Bytes(p.into_raw()),
                DynamicImage::ImageLuma16(p) => Samples::Words(p.into_raw()),
                DynamicImage::ImageLumaA16(p) => Samples::Words(p.into_raw()),
                DynamicImage::ImageRgb16(p) => Samples::Words(p.into_raw()),
                DynamicImage::ImageRgba16(p) => Samples::Words(p.into_raw()),
                DynamicImage::ImageRgb32F(p) => Samples::Floats(p.into_raw(), false),
                DynamicImage::ImageRgba32F(p) => Samples::Floats(p.into_raw(), false),
                _ => unreachable!("a PNG or JPEG has 8 or 16 bits"),
            },
        }
    }
}

impl Stored {
    /// Returns the number of colours.
    pub(crate) fn colours(&self) -> usize {
        if self.has_colour { 3 } else { 1 }
    }

    /// Returns the alpha of each pixel, from 0 to 1.
    pub(crate) fn alphas(&self) -> Vec<f32> {
        let at = self.colours();
        let every = |count: usize| (0..count).map(move |i| i * self.channels + at);
        match &self.samples {
            Samples::Bytes(v) => {
                let shares = every(v.len() / self.channels).map(|i| f32::from(v[i]) / 255.0);
                shares.collect()
            }
            Samples::Words(v) => {
                let shares = every(v.len() / self.channels).map(|i| f32::from(v[i]) / 65535.0);
                shares.collect()
            }
            Samples::Floats(v, _) => every(v.len() / self.channels).map(|i| v[i]).collect(),
        }
    }
}

impl Samples {
    /// Puts planes of one sample a pixel together.
    pub(crate) fn interleaved(planes: Vec<Samples>) -> Samples {
        fn woven<S: Copy>(planes: &[Vec<S>]) -> Vec<S> {
            let pixels = 0..planes.iter().map(Vec::len).min().unwrap_or(0);
            pixels
                .flat_map(|i| planes.iter().map(move |plane| plane[i]))
                .collect()
        }
        let (mut bytes, mut words, mut floats, mut is_whole) = (vec![], vec![], vec![], false);
        for plane in planes {
            match plane {
                Samples::Bytes(plane) => bytes.push(plane),
                Samples::Words(plane) => words.push(plane),
                Samples::Floats(plane, whole) => {
                    floats.push(plane);
                    is_whole = whole;
                }
            }
        }
        if !bytes.is_empty() {
            Samples::Bytes(woven(&bytes))
        } else if !words.is_empty() {
            Samples::Words(woven(&words))
        } else {
            Samples::Floats(woven(&floats), is_whole)
        }
    }

    /// Exchanges black and white of the first of `channels` samples of each pixel.
    pub(crate) fn invert(&mut self, channels: usize) {
        match self {
            Samples::Bytes(v) => v.iter_mut().step_by(channels).for_each(|s| *s = !*s),
            Samples::Words(v) => v.iter_mut().step_by(channels).for_each(|s| *s = !*s),
            Samples::Floats(v, _) => v.iter_mut().step_by(channels).for_each(|s| *s = 1.0 - *s),
        }
    }
}

/// Turns a plane of light upright, and returns it with its new size.
pub(crate) fn upright(
    plane: Vec<f32>,
    [width, height]: [usize; 2],
    orientation: Orientation,
) -> (Vec<f32>, [usize; 2]) {
    use imageops::{flip_horizontal, flip_vertical, rotate90, rotate180, rotate270};
    if orientation == Orientation::NoTransforms {
        return (plane, [width, height]);
    }
    let plane = ImageBuffer::<Luma<f32>, _>::from_raw(width as u32, height as u32, plane)
        .expect("a plane has a value for each pixel");
    let turned = match orientation {
        Orientation::NoTransforms => plane,
        Orientation::Rotate90 => rotate90(&plane),
        Orientation::Rotate180 => rotate180(&plane),
        Orientation::Rotate270 => rotate270(&plane),
        Orientation::FlipHorizontal => flip_horizontal(&plane),
        Orientation::FlipVertical => flip_vertical(&plane),
        Orientation::Rotate90FlipH => flip_horizontal(&rotate90(&plane)),
        Orientation::Rotate270FlipH => flip_horizontal(&rotate270(&plane)),
    };
    let size = [turned.width() as usize, turned.height() as usize];
    (turned.into_raw(), size)
}
