//! Entries of rays: samples become points of the entrance, in their order or sorted by square tiles.
//!
//! Rays that enter side by side meet the same facets. So the samples of all randomisations of a
//! direction are sorted together.

use crate::geometry::{Launch, Stream};
use crate::rays::lane::{LANES, Mask, Reals, UNITS, digits, floor, points};
use crate::rays::simd::{InstructionSet, Task};
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

/// Returns the entries of the samples of `parts` whose rays enter scene number `scene`, sorted by
/// the tiles of the entrance that they lie in.
///
/// A tile holds about as many rays as a vector has lanes. All parts together have fewer than 2^32
/// samples.
pub(crate) fn neighbours(
    launch: &Launch,
    parts: &[SampleRange],
    scene: usize,
    instructions: InstructionSet,
) -> Vec<EntryPoint> {
    instructions.run(Sorting {
        launch,
        parts,
        scene,
        tiles: Tiles::new(launch, rays(parts)),
    })
}

/// Square tiles of the entrance.
struct Tiles {
    /// Corner of the first tile, edge lengths.
    low: DVec2,
    /// Tiles per edge length.
    scale: f64,
    /// Number of the last tile along each axis.
    last: DVec2,
    /// Squares of tiles in a row of squares.
    columns: u32,
    /// Number of tiles in all squares.
    count: u32,
}

/// Tiles on a side of the squares that rays are sorted into first.
///
/// The rays of a square fit in the caches, and few of the facets that they meet lie on its sides.
const SQUARE: u32 = 32;

impl Tiles {
    fn new(launch: &Launch, rays: u64) -> Self {
        let [low, high] = launch.box_of_entrance();
        let size = high - low;
        let tiles = (rays / LANES as u64).max(1) as f64;
        // The longer side has at most 65,536 tiles.
        let side = (size.x * size.y / tiles)
            .sqrt()
            .max(size.max_element() / 65_536.0);
        let last = (size / side).floor();
        let squares = |last: f64| last as u32 / SQUARE + 1;
        let columns = squares(last.x);
        Tiles {
            low,
            scale: 1.0 / side,
            last,
            columns,
            count: columns * squares(last.y) * SQUARE * SQUARE,
        }
    }

    /// Returns the numbers of the tiles of the points (`x`, `y`).
    #[inline(always)]
    fn of(&self, x: &Reals, y: &Reals) -> [u32; LANES] {
        // The low bits of a number with `UNITS` are the number.
        let whole = |along: f64, last: f64| {
            let along = if along > 0.0 { along } else { 0.0 };
            let along = if along < last { along } else { last };
            (floor(along) + UNITS).to_bits() as u32
        };
        let mut tiles = [0; LANES];
        for lane in 0..LANES {
            let x = whole((x[lane] - self.low.x) * self.scale, self.last.x);
            let y = whole((y[lane] - self.low.y) * self.scale, self.last.y);
            let square = y / SQUARE * self.columns + x / SQUARE;
            tiles[lane] = (square * SQUARE + y % SQUARE) * SQUARE + x % SQUARE;
        }
        tiles
    }
}

/// Samples that are drawn and sorted: the arguments of [`neighbours`].
struct Sorting<'a> {
    launch: &'a Launch,
    parts: &'a [SampleRange],
    scene: usize,
    tiles: Tiles,
}

impl Task for Sorting<'_> {
    type Output = Vec<EntryPoint>;

    /// Counts the rays of each tile and then puts every ray in its place.
    ///
    /// The samples are drawn twice, which costs less than a list of them between.
    #[inline(always)]
    fn run(self) -> Vec<EntryPoint> {
        // Rays of other scenes come after all tiles.
        let mut next = vec![0_u32; self.tiles.count as usize + 2];
        self.draw(|drawn, _| {
            for &tile in &drawn.tile[..drawn.count] {
                next[tile as usize + 1] += 1;
            }
        });
        for tile in 1..next.len() {
            next[tile] += next[tile - 1];
        }
        let count = next[self.tiles.count as usize] as usize;
        let mut sorted = vec![EntryPoint::default(); count];
        self.draw(|drawn, (part, first)| {
            for lane in 0..drawn.count {
                let place = &mut next[drawn.tile[lane] as usize];
                *place += 1;
                if let Some(entry) = sorted.get_mut(*place as usize - 1) {
                    *entry = EntryPoint {
                        point: DVec2::new(drawn.x[lane], drawn.y[lane]),
                        sample: first + lane as u32,
                        part,
                    };
                }
            }
        });
        sorted
    }
}

/// Samples of up to [`LANES`] rays, with the tiles of their points.
struct Drawn {
    x: Reals,
    y: Reals,
    tile: [u32; LANES],
    count: usize,
}

impl Sorting<'_> {
    /// Hands all samples to `take`, some at a time, with the number of their part and that of their
    /// first sample there.
    #[inline(always)]
    fn draw(&self, mut take: impl FnMut(&Drawn, (u32, u32))) {
        for (part, own) in self.parts.iter().enumerate() {
            let count = (own.samples.end - own.samples.start) as u32;
            for first in (0..count).step_by(LANES) {
                let (x, y, here) = self.points(&own.stream, own.samples.start + u64::from(first));
                let mut tile = self.tiles.of(&x, &y);
                for lane in 0..LANES {
                    let inside = here[lane] >> 63 == 1;
                    tile[lane] = if inside { tile[lane] } else { self.tiles.count };
                }
                let count = LANES.min((count - first) as usize);
                take(&Drawn { x, y, tile, count }, (part as u32, first));
            }
        }
    }

    /// Returns the points of the samples from `first` on, and a mask of those that enter the scene.
    #[inline(always)]
    fn points(&self, stream: &Stream, first: u64) -> (Reals, Reals, Mask) {
        let (a, b) = digits(stream, first);
        if let [piece] = self.launch.pieces() {
            return points(piece, &a, &b);
        }
        let (mut x, mut y, mut here) = ([0.0; LANES], [0.0; LANES], [0; LANES]);
        for lane in 0..LANES {
            let (scene, point) = self.launch.entry_of([a[lane], b[lane]]);
            (x[lane], y[lane]) = (point.x, point.y);
            here[lane] = u64::from(scene == self.scene) << 63;
        }
        (x, y, here)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::entries::entries;
    use meshes::Entrance;
    use std::collections::BTreeMap;
    use tables::options::Sampler;

    fn entrance(corners: &[[f64; 2]]) -> Entrance {
        Entrance {
            height: 0.5,
            polygon: corners.iter().map(|&corner| corner.into()).collect(),
            lattice: None,
        }
    }

    /// One piece, a polygon of several and two scenes: the rays of a scene are those of
    /// [`entries`], to the last bit, on every instruction set. Rays of one tile come after each
    /// other, and a tile is a square no wider than it should be.
    #[test]
    fn neighbours_are_the_entries_in_tiles() {
        let square = entrance(&[[-1.0, 0.5], [2.0, 0.5], [2.0, 1.5], [-1.0, 1.5]]);
        let bent = entrance(&[[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [1.0, 1.0], [1.0, 3.0]]);
        let (mut cases, mut compared) = (0, 0);
        for (entrances, scenes) in [
            (vec![(&square, 1)], 1),
            (vec![(&bent, 1)], 1),
            (vec![(&square, 2), (&bent, 1)], 2),
        ] {
            let launch = Launch::among(&entrances);
            for sampler in [Sampler::Random, Sampler::Sobol] {
                let part = |number, samples| SampleRange {
                    stream: Stream::new(sampler, 3, 20.0, 0.0, number),
                    samples,
                };
                let parts = [part(0, 5..4_100), part(1, 0..1), part(2, 640..10_000)];
                let mut all: Vec<BTreeMap<(u32, u32), [u64; 2]>> = vec![BTreeMap::new(); scenes];
                for (scene, entry) in entries(&launch, &parts) {
                    let point = entry.point.to_array().map(f64::to_bits);
                    all[scene].insert((entry.part, entry.sample), point);
                }
                let tiles = Tiles::new(&launch, rays(&parts));
                for (scene, instructions) in (0..scenes).flat_map(|scene| {
                    InstructionSet::available()
                        .into_iter()
                        .map(move |i| (scene, i))
                }) {
                    let found = neighbours(&launch, &parts, scene, instructions);
                    assert_eq!(found.len(), all[scene].len());
                    for entry in &found {
                        let point = entry.point.to_array().map(f64::to_bits);
                        assert_eq!(all[scene].get(&(entry.part, entry.sample)), Some(&point));
                    }
                    let tile =
                        |e: &EntryPoint| tiles.of(&[e.point.x; LANES], &[e.point.y; LANES])[0];
                    assert!(found.is_sorted_by_key(tile));
                    for of_tile in found.chunk_by(|a, b| tile(a) == tile(b)) {
                        let low = of_tile.iter().map(|e| e.point).reduce(DVec2::min);
                        let high = of_tile.iter().map(|e| e.point).reduce(DVec2::max);
                        let size =
                            (high.zip(low)).map_or(0.0, |(high, low)| (high - low).max_element());
                        assert!(size <= (1.0 + 1e-9) / tiles.scale, "{size}");
                    }
                    compared += found.len();
                    cases += 1;
                }
            }
        }
        let sets = InstructionSet::available().len();
        assert_eq!(cases, (1 + 1 + 2) * 2 * sets);
        assert_eq!(compared, 3 * 2 * (4_095 + 1 + 9_360) * sets);
    }
}
