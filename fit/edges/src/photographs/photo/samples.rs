//! The stored samples of a picture, before they become light.

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
    /// Exchanges black and white of the first of `channels` samples of each pixel.
    pub(crate) fn invert(&mut self, channels: usize) {
        match self {
            Samples::Bytes(v) => v.iter_mut().step_by(channels).for_each(|s| *s = !*s),
            Samples::Words(v) => v.iter_mut().step_by(channels).for_each(|s| *s = !*s),
            Samples::Floats(v, _) => v.iter_mut().step_by(channels).for_each(|s| *s = 1.0 - *s),
        }
    }
}

/// Turns a plane of light upright, and returns it with its new size. `orientation` is the number of
/// the side that is up, from 1 to 8 (TIFF 6.0).
pub(crate) fn upright(
    plane: Vec<f32>,
    [width, height]: [usize; 2],
    orientation: u64,
) -> (Vec<f32>, [usize; 2]) {
    // Bits of what is done: a flip of the columns, a flip of the rows, and their exchange.
    let [columns, rows, exchange] = match orientation {
        2 => [true, false, false],
        3 => [true, true, false],
        4 => [false, true, false],
        5 => [false, false, true],
        6 => [false, true, true],
        7 => [true, true, true],
        8 => [true, false, true],
        _ => return (plane, [width, height]),
    };
    let size = if exchange {
        [height, width]
    } else {
        [width, height]
    };
    let pixel = |place: usize| {
        let (x, y) = (place % size[0], place / size[0]);
        let (x, y) = if exchange { (y, x) } else { (x, y) };
        let x = if columns { width - 1 - x } else { x };
        let y = if rows { height - 1 - y } else { y };
        plane[y * width + x]
    };
    ((0..plane.len()).map(pixel).collect(), size)
}
