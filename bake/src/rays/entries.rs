//! Entries of rays: samples become points of the entrance.

use crate::samples::{Launch, Stream};
use glam::DVec2;
use std::ops::Range;

/// Samples of one randomisation.
#[derive(Debug, Clone)]
pub(crate) struct SampleRange {
    /// Stream of the samples.
    pub stream: Stream,
    /// Indices of the samples.
    pub samples: Range<u64>,
}

/// Returns the number of samples of all `parts`.
pub(crate) fn rays(parts: &[SampleRange]) -> u64 {
    let counts = parts
        .iter()
        .map(|part| part.samples.end - part.samples.start);
    counts.sum()
}

/// Ray at the entrance.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct EntryPoint {
    /// Point where the ray enters, edge lengths.
    pub point: DVec2,
    /// Number of the sample in its part.
    pub sample: u32,
    /// Number of the part, by which the ray is counted.
    pub part: u32,
}

impl EntryPoint {
    /// Returns the number of the part that the sample belongs to.
    pub(crate) fn part(&self) -> usize {
        self.part as usize
    }

    /// Returns the stream and the index of the sample; `parts` are those that it was drawn from.
    pub(crate) fn sample<'a>(&self, parts: &'a [SampleRange]) -> (&'a Stream, u64) {
        let SampleRange { stream, samples } = &parts[self.part()];
        (stream, samples.start + u64::from(self.sample))
    }
}

/// Returns the entries of all samples of `parts`, one part after the other, each with the number of
/// the scene that its ray enters.
///
/// A part has at most 2^32 samples.
pub(crate) fn entries<'a>(
    launch: &'a Launch,
    parts: &'a [SampleRange],
) -> impl Iterator<Item = (usize, EntryPoint)> + 'a {
    parts.iter().enumerate().flat_map(move |(part, own)| {
        let part = part as u32;
        own.samples.clone().map(move |index| {
            let (scene, point) = launch.entry(&own.stream, index);
            let sample = (index - own.samples.start) as u32;
            let entry = EntryPoint {
                point,
                sample,
                part,
            };
            (scene, entry)
        })
    })
}
