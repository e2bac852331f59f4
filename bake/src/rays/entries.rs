//! Entries of rays: samples become points of the entrance, in the order of tiles.
//!
//! Rays that enter side by side meet the same facets. So the samples of all randomisations of a
//! direction are sorted together. Each entry carries the number of its part, by which the ray is
//! counted.

use crate::rays::lane::LANES;
use crate::rays::order::order;
use crate::samples::{Launch, Stream};
use glam::DVec2;
use std::ops::Range;

/// Samples of one randomisation.
#[derive(Debug, Clone)]
pub(crate) struct Part {
    /// Stream of the samples.
    pub stream: Stream,
    /// Indices of the samples.
    pub samples: Range<u64>,
}

/// Returns the number of samples of all `parts`.
pub(crate) fn rays(parts: &[Part]) -> u64 {
    let counts = parts
        .iter()
        .map(|part| part.samples.end - part.samples.start);
    counts.sum()
}

/// Ray at the entrance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Entry {
    /// Point where the ray enters, edge lengths.
    pub point: DVec2,
    /// Number of the sample in its part.
    sample: u32,
    part: u32,
}

impl Entry {
    /// Returns the number of the part that the sample belongs to.
    pub(crate) fn part(&self) -> usize {
        self.part as usize
    }

    /// Returns the stream and the index of the sample; `parts` are those that it was drawn from.
    pub(crate) fn sample<'a>(&self, parts: &'a [Part]) -> (&'a Stream, u64) {
        let Part { stream, samples } = &parts[self.part()];
        (stream, samples.start + u64::from(self.sample))
    }
}

/// Returns the entries of all samples of `parts`, one part after the other, each with the number of
/// the scene that its ray enters.
///
/// A part has at most 2^32 samples.
pub(crate) fn entries<'a>(
    launch: &'a Launch,
    parts: &'a [Part],
) -> impl Iterator<Item = (usize, Entry)> + 'a {
    parts.iter().enumerate().flat_map(move |(part, own)| {
        let part = part as u32;
        own.samples.clone().map(move |index| {
            let (scene, point) = launch.entry(&own.stream, index);
            let sample = (index - own.samples.start) as u32;
            let entry = Entry {
                point,
                sample,
                part,
            };
            (scene, entry)
        })
    })
}

/// Sorts rays by the tiles of the entrance that their points lie in.
///
/// A tile holds about as many rays as a bundle takes.
pub(crate) fn side_by_side<T: Copy>(
    launch: &Launch,
    rays: &[T],
    point: impl Fn(&T) -> DVec2,
) -> Vec<T> {
    let [low, high] = launch.box_of_entrance();
    let size = high - low;
    // The tiles are square. The longer side has at most 65,536 of them.
    let tiles = (rays.len() / LANES).max(1) as f64;
    let side = (size.x * size.y / tiles)
        .sqrt()
        .max(size.max_element() / 65_536.0);
    let last = (size / side).floor();
    let squares = |last: f64| last as usize / SQUARE + 1;
    let columns = squares(last.x);
    order(rays, columns * squares(last.y) * SQUARE * SQUARE, |ray| {
        let tile = ((point(ray) - low) / side).clamp(DVec2::ZERO, last);
        let (x, y) = (tile.x as usize, tile.y as usize);
        let square = y / SQUARE * columns + x / SQUARE;
        (square * SQUARE + y % SQUARE) * SQUARE + x % SQUARE
    })
}

/// Tiles on a side of the squares that rays are sorted into first.
///
/// The rays of a square fit in the caches, and few of the facets that they meet lie on its sides.
const SQUARE: usize = 32;
