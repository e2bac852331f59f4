//! LPIPS 0.1 (Zhang et al. 2018) with AlexNet: the distance of two pictures, measured by five
//! layers of a neural network.
//!
//! The weights come from the user, in a safetensors file of f32 tensors: `conv1.weight` to
//! `conv5.weight` (outputs, inputs, rows, columns), `conv1.bias` to `conv5.bias`, and `lin1.weight`
//! to `lin5.weight` with one weight per output of that layer. The script fit/doc/lpips_weights.py
//! writes the file from the `lpips` package.

use std::io::Read;
use std::path::{Path, PathBuf};

use nalgebra::DMatrix;
use serde_json::Value;

use crate::images::metrics::Shown;

/// Shape of a layer: outputs, inputs, size, stride, padding, and whether pixels are pooled before
/// the layer.
type Convolution = (usize, usize, usize, usize, usize, bool);

/// Convolutions of torchvision's AlexNet.
const LAYERS: [Convolution; 5] = [
    (64, 3, 11, 4, 2, false),
    (192, 64, 5, 1, 2, true),
    (384, 192, 3, 1, 1, true),
    (256, 384, 3, 1, 1, false),
    (256, 256, 3, 1, 1, false),
];

/// Offsets that centre the network's input, for values in -1..1 (ScalingLayer of the package).
const SHIFT: [f32; 3] = [-0.030, -0.088, -0.188];
/// Divisors that scale the network's centred input (ScalingLayer of the package).
const SCALE: [f32; 3] = [0.458, 0.448, 0.450];

/// Smallest side of a picture that leaves a pixel after both poolings, pixels.
pub(crate) const SMALLEST: usize = 31;

/// Reason why weights cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum Error {
    /// File that the system cannot read.
    #[error("{}: cannot be read ({source}); check the path", file.display())]
    Read {
        /// File with the weights.
        file: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// File that is not a safetensors file.
    #[error("{}: is not a whole safetensors file; write it with fit/doc/lpips_weights.py",
        file.display())]
    Format {
        /// File with the weights.
        file: PathBuf,
    },
    /// Tensor that is missing, or that has another type or size.
    #[error("{}: tensor {name} is missing, or is not {count} numbers of type F32; write the file \
        with fit/doc/lpips_weights.py", file.display())]
    Tensor {
        /// File with the weights.
        file: PathBuf,
        /// Name of the tensor.
        name: String,
        /// Count of numbers that the tensor must hold.
        count: usize,
    },
}

/// The network with its weights.
#[derive(Debug, Clone)]
pub(crate) struct Lpips {
    layers: Vec<Layer>,
}

/// One layer of the network.
#[derive(Debug, Clone)]
struct Layer {
    shape: Convolution,
    /// Weights of the convolution: a row per (input, row, column), a column per output.
    weights: DMatrix<f32>,
    bias: Vec<f32>,
    /// Weight of the squared difference of each output.
    linear: Vec<f32>,
}

impl Lpips {
    /// Reads the weights from a safetensors file.
    ///
    /// # Errors
    /// Returns [`Error::Read`] if the system cannot read the file, [`Error::Format`] if it is not a
    /// safetensors file, and [`Error::Tensor`] if a tensor is missing or has another type or size.
    pub(crate) fn read(path: &Path) -> Result<Lpips, Error> {
        let file = || path.to_owned();
        // The weights have 10 MB.
        let mut bytes = Vec::new();
        crate::document::open(path)
            .and_then(|weights| weights.take(1 << 28).read_to_end(&mut bytes))
            .map_err(|source| Error::Read {
                file: file(),
                source,
            })?;
        let (header, data) = split(&bytes).ok_or_else(|| Error::Format { file: file() })?;
        Lpips::from_tensors(|name, count| {
            tensor(&header, data, name, count).ok_or_else(|| Error::Tensor {
                file: file(),
                name: name.to_owned(),
                count,
            })
        })
    }

    /// Builds the network from a function that returns a tensor by its name and its count of
    /// numbers.
    ///
    /// # Errors
    /// Returns the first error of `tensor`.
    pub(crate) fn from_tensors<E>(
        mut tensor: impl FnMut(&str, usize) -> Result<Vec<f32>, E>,
    ) -> Result<Lpips, E> {
        let mut layers = Vec::with_capacity(LAYERS.len());
        for (i, shape) in LAYERS.into_iter().enumerate() {
            let (outputs, inputs, size, ..) = shape;
            let count = inputs * size * size;
            let weights = tensor(&format!("conv{}.weight", i + 1), outputs * count)?;
            layers.push(Layer {
                shape,
                weights: DMatrix::from_vec(count, outputs, weights),
                bias: tensor(&format!("conv{}.bias", i + 1), outputs)?,
                linear: tensor(&format!("lin{}.weight", i + 1), outputs)?,
            });
        }
        Ok(Lpips { layers })
    }

    /// Returns the LPIPS distance of two pictures, 0 for equal pictures.
    ///
    /// Both pictures must have the same size, at least [`SMALLEST`] pixels on both sides.
    pub(crate) fn distance(&self, a: &Shown, b: &Shown) -> f64 {
        let mut pair = [a, b].map(Maps::of);
        let mut sum = 0.0;
        for layer in &self.layers {
            pair = pair.map(|maps| layer.forward(maps));
            sum += layer.difference(&pair);
        }
        sum
    }
}

/// Splits the bytes of a safetensors file into its header and its data.
///
/// The file holds the length of the header, the header in JSON, and the numbers.
fn split(bytes: &[u8]) -> Option<(Value, &[u8])> {
    let (length, rest) = bytes.split_first_chunk::<8>()?;
    let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
    let (header, data) = rest.split_at_checked(length)?;
    Some((serde_json::from_slice(header).ok()?, data))
}

/// Returns the numbers of a tensor, or `None` if it is missing or has another type or size.
fn tensor(header: &Value, data: &[u8], name: &str, count: usize) -> Option<Vec<f32>> {
    let entry = header.get(name)?;
    let offset = |i: usize| usize::try_from(entry["data_offsets"].get(i)?.as_u64()?).ok();
    let bytes = data.get(offset(0)?..offset(1)?)?;
    let number = |four: &[u8]| f32::from_le_bytes([four[0], four[1], four[2], four[3]]);
    (entry["dtype"] == "F32" && bytes.len() == 4 * count)
        .then(|| bytes.chunks_exact(4).map(number).collect())
}

/// Channels of one picture: a row per pixel in row-major order, a column per channel.
struct Maps {
    width: usize,
    height: usize,
    values: DMatrix<f32>,
}

impl Maps {
    fn of(shown: &Shown) -> Maps {
        let bytes = shown.bytes();
        let [width, height] = shown.size();
        let value = |pixel: usize, channel: usize| {
            let value = f32::from(bytes[3 * pixel + channel]) / 127.5 - 1.0;
            (value - SHIFT[channel]) / SCALE[channel]
        };
        Maps {
            width,
            height,
            values: DMatrix::from_fn(width * height, 3, value),
        }
    }

    /// Returns the greatest value of each block of 3 x 3 pixels, at every second column and row.
    fn pooled(&self) -> Maps {
        let [width, height] = [self.width, self.height].map(|n| (n - 3) / 2 + 1);
        let greatest = |pixel: usize, channel: usize| {
            let (x, y) = (2 * (pixel % width), 2 * (pixel / width));
            let rows = (y..y + 3).flat_map(|y| (x..x + 3).map(move |x| (x, y)));
            rows.map(|(x, y)| self.values[(y * self.width + x, channel)])
                .fold(f32::NEG_INFINITY, f32::max)
        };
        Maps {
            width,
            height,
            values: DMatrix::from_fn(width * height, self.values.ncols(), greatest),
        }
    }
}

impl Layer {
    /// Applies the layer: pooling where it has one, convolution, and rectification.
    fn forward(&self, maps: Maps) -> Maps {
        let (outputs, inputs, size, stride, padding, pool) = self.shape;
        let maps = if pool { maps.pooled() } else { maps };
        let [width, height] =
            [maps.width, maps.height].map(|n| (n + 2 * padding - size) / stride + 1);
        let mut values = DMatrix::zeros(width * height, outputs);
        // A row of pixels at a time keeps the patches small.
        let count = inputs * size * size;
        for row in 0..height {
            let patch = |x: usize, i: usize| {
                let (channel, place) = (i / (size * size), i % (size * size));
                let column = (x * stride + place % size).checked_sub(padding);
                let line = (row * stride + place / size).checked_sub(padding);
                match (column, line) {
                    (Some(x), Some(y)) if x < maps.width && y < maps.height => {
                        maps.values[(y * maps.width + x, channel)]
                    }
                    _ => 0.0,
                }
            };
            let patches = DMatrix::from_fn(width, count, patch);
            let sums = patches * &self.weights;
            for ((x, output), sum) in (0..outputs)
                .flat_map(|o| (0..width).map(move |x| (x, o)))
                .zip(sums.iter())
            {
                values[(row * width + x, output)] = (sum + self.bias[output]).max(0.0);
            }
        }
        Maps {
            width,
            height,
            values,
        }
    }

    /// Returns the mean over the pixels of the weighted squared difference of the channels.
    ///
    /// The channels of a pixel are scaled to length 1 first.
    fn difference(&self, [a, b]: &[Maps; 2]) -> f64 {
        let pixels = a.values.nrows();
        let sum: f64 = (0..pixels)
            .map(|pixel| {
                let length = |maps: &Maps| maps.values.row(pixel).norm() + 1e-10;
                let (la, lb) = (length(a), length(b));
                let channels = self.linear.iter().enumerate();
                let squares = channels.map(|(channel, weight)| {
                    let difference =
                        a.values[(pixel, channel)] / la - b.values[(pixel, channel)] / lb;
                    weight * difference * difference
                });
                f64::from(squares.sum::<f32>())
            })
            .sum();
        sum / pixels as f64
    }
}
