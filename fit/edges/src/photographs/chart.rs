//! Search for straight edges among other marks: returns a region of interest about each slanted
//! edge.
//!
//! The photograph is averaged down to about 600 x 400 blocks. Neighbouring blocks whose gradients
//! are strong and have a similar direction form a piece (the idea of von Gioi et al., LSD, IPOL
//! 2012). A piece that is long, thin and tilted by 1 to 44 degrees from rows and columns is an
//! edge. Its region is the largest upright rectangle about its middle that holds no other mark.

use crate::photographs::edge::line::EdgeLine;
use crate::photographs::manifest::roi::Roi;
use crate::photographs::photo::plane::Photo;
use crate::photographs::window::Window;

/// Approximate number of blocks in the averaged picture.
const BLOCKS: f64 = 240_000.0;

/// Least strong gradient, as a share of the strongest (the mean of the strongest 1 in 500).
const STRONG: f64 = 0.15;

/// Least strong gradient, as a multiple of the median gradient. The gradient of noise reaches 8
/// times its median once in 10^19 blocks.
const ABOVE_NOISE: f32 = 8.0;

/// Number of blocks of the smallest group that counts as a mark. A smaller one is a hot pixel or
/// dust.
const LEAST_MARK: usize = 14;

/// Cosine of the largest angle (22.5 degrees, as in LSD) between the gradient of a block and the
/// mean gradient of its piece.
const LIKE: f32 = 0.924;

/// Number of pieces that are looked at, the longest first.
const MOST_PIECES: usize = 24;

/// Length of the shortest edge, blocks.
const LEAST_LENGTH: f64 = 12.0;
/// Least ratio of the length of an edge to its width.
const SLENDER: f64 = 2.5;

/// Returns a region about each straight piece of a photograph, the longest piece first. Pieces
/// without room for a region are left out. The caller has to measure a region to know whether it
/// holds an edge.
pub(crate) fn regions(photo: &Photo) -> Vec<Roi> {
    let blocks = Blocks::of(photo);
    let pieces = blocks.pieces();
    let regions = pieces
        .iter()
        .filter_map(|piece| blocks.region(piece, photo));
    regions.take(MOST_PIECES).collect()
}

/// Returns the middle of a region, at most 600 pixels long and wide. This is enough to see whether
/// the region holds an edge.
pub(crate) fn middle(roi: &Roi) -> Roi {
    let part = |at: usize, size: usize| (at + size.saturating_sub(600) / 2, size.min(600));
    let ((x, width), (y, height)) = (part(roi.x, roi.width), part(roi.y, roi.height));
    Roi {
        x,
        y,
        width,
        height,
    }
}

/// Returns whether two edges lie on one line. This means that their directions differ by less than
/// 0.02 rad (1.1 degrees), and that one lies off the line of the other by less than 1 % of their
/// distance plus 2 pixels.
pub(crate) fn one_line((roi_a, a): (&Roi, &EdgeLine), (roi_b, b): (&Roi, &EdgeLine)) -> bool {
    let turn = (a.normal_rad - b.normal_rad).sin().abs();
    let centre = |roi: &Roi| {
        (
            roi.x as f64 + 0.5 * roi.width as f64,
            roi.y as f64 + 0.5 * roi.height as f64,
        )
    };
    let ((ax, ay), (bx, by)) = (centre(roi_a), centre(roi_b));
    let (sin, cos) = a.normal_rad.sin_cos();
    let apart = (bx - ax) * cos + (by - ay) * sin + b.offset_px - a.offset_px;
    turn < 0.02 && apart.abs() < 0.01 * (bx - ax).hypot(by - ay) + 2.0
}

/// A straight piece of strong gradient. Lengths are in blocks.
#[derive(Debug)]
struct Piece {
    /// Middle of the piece.
    middle: [f64; 2],
    /// Unit vector along the piece.
    along: [f64; 2],
    /// Length of the piece.
    length: f64,
    /// Half the width of the strip in which its blocks lie.
    half_width: f64,
}

impl Piece {
    /// Returns the signed distances of a point from the middle, across and along the piece, blocks.
    fn place(&self, x: f64, y: f64) -> (f64, f64) {
        let (dx, dy) = (x - self.middle[0], y - self.middle[1]);
        let [ux, uy] = self.along;
        (dy * ux - dx * uy, dx * ux + dy * uy)
    }
}

/// A photograph averaged down to blocks, and its gradient.
#[derive(Default)]
struct Blocks {
    width: usize,
    height: usize,
    /// Number of pixels on a side of a block.
    side: usize,
    /// Unit vector of the gradient of each block.
    direction: Vec<[f32; 2]>,
    /// Flag of each block: true if its gradient counts as strong.
    strong: Vec<bool>,
}

impl Blocks {
    fn of(photo: &Photo) -> Blocks {
        let pixels = (photo.width * photo.height) as f64;
        let side = (pixels / BLOCKS).sqrt().ceil().max(1.0) as usize;
        let Some(mean) = Window::of(photo, None).map(|whole| whole.reduced(side)) else {
            return Blocks::default();
        };
        let (width, height) = (mean.width(), mean.height());
        let mut direction = vec![[0.0; 2]; width * height];
        let mut size = vec![0.0_f32; width * height];
        // Sobel's weights: 1 2 1 across the difference.
        for y in 1..height.saturating_sub(1) {
            for x in 1..width.saturating_sub(1) {
                let at = |dx: usize, dy: usize| mean.at(x + dx - 1, y + dy - 1);
                let gx = at(2, 0) - at(0, 0) + 2.0 * (at(2, 1) - at(0, 1)) + at(2, 2) - at(0, 2);
                let gy = at(0, 2) - at(0, 0) + 2.0 * (at(1, 2) - at(1, 0)) + at(2, 2) - at(2, 0);
                let length = gx.hypot(gy);
                size[y * width + x] = length;
                if length > 0.0 {
                    direction[y * width + x] = [gx / length, gy / length];
                }
            }
        }
        let mut sorted = size.clone();
        sorted.sort_unstable_by(f32::total_cmp);
        let median = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
        let top = &sorted[sorted.len() - (sorted.len() / 500).max(1).min(sorted.len())..];
        let strongest = f64::from(top.iter().sum::<f32>()) / top.len().max(1) as f64;
        let least = (ABOVE_NOISE * median).max((STRONG * strongest) as f32);
        let strong = size.iter().map(|&v| v > least && v > 0.0).collect();
        let mut blocks = Blocks {
            width,
            height,
            side,
            direction,
            strong,
        };
        blocks.drop_specks();
        blocks
    }

    /// Returns the indices of the up to eight neighbours of a block.
    fn neighbours(&self, index: usize) -> impl Iterator<Item = usize> + use<> {
        let (width, height) = (self.width, self.height);
        let (x, y) = (index % width, index / width);
        let columns = x.saturating_sub(1)..(x + 2).min(width);
        (y.saturating_sub(1)..(y + 2).min(height))
            .flat_map(move |v| columns.clone().map(move |u| v * width + u))
            .filter(move |&other| other != index)
    }

    /// Collects the blocks that are joined to `start` through free blocks for which `joins` is
    /// true. They are no longer free afterwards.
    fn flood(
        &self,
        start: usize,
        free: &mut [bool],
        mut joins: impl FnMut(usize) -> bool,
    ) -> Vec<usize> {
        let mut group = vec![start];
        free[start] = false;
        let mut next = 0;
        while let Some(&index) = group.get(next) {
            for other in self.neighbours(index) {
                if free[other] && joins(other) {
                    free[other] = false;
                    group.push(other);
                }
            }
            next += 1;
        }
        group
    }

    fn drop_specks(&mut self) {
        let mut free = self.strong.clone();
        for start in 0..free.len() {
            if free[start] {
                let group = self.flood(start, &mut free, |_| true);
                if group.len() < LEAST_MARK {
                    group
                        .into_iter()
                        .for_each(|index| self.strong[index] = false);
                }
            }
        }
    }

    /// Returns the straight pieces, the longest first.
    fn pieces(&self) -> Vec<Piece> {
        let mut free = self.strong.clone();
        let mut pieces = Vec::new();
        for start in 0..free.len() {
            if !free[start] {
                continue;
            }
            let mut sum = self.direction[start];
            let group = self.flood(start, &mut free, |other| {
                let [gx, gy] = self.direction[other];
                let like = gx * sum[0] + gy * sum[1] > LIKE * sum[0].hypot(sum[1]);
                if like {
                    sum = [sum[0] + gx, sum[1] + gy];
                }
                like
            });
            if let Some(piece) = self.piece(&group) {
                pieces.push(piece);
            }
        }
        pieces.sort_by(|a, b| b.length.total_cmp(&a.length));
        pieces
    }

    /// Describes a group of blocks as a straight piece, or returns `None` if it is not long and
    /// thin. The axes come from the second moments of the group, taken as those of a uniform bar.
    fn piece(&self, group: &[usize]) -> Option<Piece> {
        let n = group.len() as f64;
        let place = |&index: &usize| ((index % self.width) as f64, (index / self.width) as f64);
        let (mut x, mut y) = (0.0, 0.0);
        for (u, v) in group.iter().map(place) {
            (x, y) = (x + u / n, y + v / n);
        }
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for (u, v) in group.iter().map(place) {
            xx += (u - x) * (u - x) / n;
            xy += (u - x) * (v - y) / n;
            yy += (v - y) * (v - y) / n;
        }
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
        let half = (0.25 * (xx - yy).powi(2) + xy * xy).sqrt();
        let (major, minor) = (0.5 * (xx + yy) + half, (0.5 * (xx + yy) - half).max(0.0));
        let length = (12.0 * major).sqrt();
        let width = (12.0 * minor).sqrt();
        (length >= LEAST_LENGTH && length >= SLENDER * width).then(|| Piece {
            middle: [x, y],
            along: [angle.cos(), angle.sin()],
            length,
            half_width: 0.5 * width + 1.5,
        })
    }

    fn strong_places(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        (0..self.strong.len())
            .filter(|&index| self.strong[index])
            .map(|index| ((index % self.width) as f64, (index / self.width) as f64))
    }

    /// Returns the region of a piece, in pixels: the largest upright rectangle about its middle
    /// that holds no other mark. It ends before the piece does and is at most twice as long across
    /// the edge as along it. Returns `None` if it would be less than 20 pixels wide or high.
    fn region(&self, piece: &Piece, photo: &Photo) -> Option<Roi> {
        let steep = piece.along[1].abs() >= piece.along[0].abs();
        let cosine = piece.along[0].abs().max(piece.along[1].abs());
        // Distances (across, along) from the middle to the blocks of other marks. For a steep edge,
        // across is x.
        let marks: Vec<(f64, f64)> = self
            .strong_places()
            .filter(|&(x, y)| {
                let (across, along) = piece.place(x, y);
                across.abs() > piece.half_width || along.abs() > 0.5 * piece.length
            })
            .map(|(x, y)| {
                let (dx, dy) = ((x - piece.middle[0]).abs(), (y - piece.middle[1]).abs());
                if steep { (dx, dy) } else { (dy, dx) }
            })
            .collect();
        let room = [
            (piece.middle[0], self.width),
            (piece.middle[1], self.height),
        ]
        .map(|(at, size)| at.min(size as f64 - 1.0 - at));
        let [across_room, along_room] = if steep { room } else { [room[1], room[0]] };
        let longest = (0.45 * piece.length * cosine).min(along_room);
        let mut best: Option<(f64, f64)> = None;
        for part in 1..=40 {
            let along = longest * f64::from(part) / 40.0;
            // Two blocks are kept free: the block of the mark, and the next, which its gradient
            // reaches.
            let across = marks
                .iter()
                .filter(|(_, v)| *v <= along + 2.0)
                .map(|(u, _)| u - 2.0)
                .fold(across_room.min(2.0 * along), f64::min);
            if across > 0.0 && best.is_none_or(|(u, v)| across * along > u * v) {
                best = Some((across, along));
            }
        }
        let (across, along) = best?;
        let side = self.side as f64;
        let (half_width, half_height) = if steep {
            (across, along)
        } else {
            (along, across)
        };
        let clamp = |centre: f64, half: f64, size: usize| {
            let start = ((centre + 0.5 - half) * side).max(0.0) as usize;
            let end = (((centre + 0.5 + half) * side) as usize).min(size);
            (start, end.saturating_sub(start))
        };
        let (x, width) = clamp(piece.middle[0], half_width, photo.width);
        let (y, height) = clamp(piece.middle[1], half_height, photo.height);
        (width >= 20 && height >= 20).then_some(Roi {
            x,
            y,
            width,
            height,
        })
    }
}
