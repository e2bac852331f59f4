//! Sums over the pixels of a window, by bins of the distance from the edge, as a likelihood needs
//! them.
//!
//! Across a quarter of a pixel an edge is a short Taylor series in the distance d. The effects of
//! angle and of a gradient of the light are linear in the position t along the edge. So two numbers
//! hold what the pixels of a bin say: their mean, and their slope along the edge. The moments of
//! the pixels' positions are kept beside these two numbers. With them the model is averaged over
//! the pixels' own positions, and no position is rounded to a bin.
//!
//! Uneven light is not linear along the edge. For it each bin is cut into strips, each with two
//! numbers of its own.
//!
//! One part is lost: the differences between pixels of one bin across the edge. Its share of the
//! information is (1/4 px)^2/12 over the variance of the blur. This is 1 % for a lens of half a
//! pixel and 0.1 % for a mid-air image.

use edges::numerics::clip::Cut;
use edges::photographs::edge::line::EdgeLine;
use edges::photographs::{BIN_PX, bin_at};
use edges::photographs::{Raster, Window};

/// Pixels of one bin, with u the distance from the bin's centre along the normal and t the position
/// along the edge, both in pixels.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Bin {
    /// Number of the bin: its centre lies at this number times [`BIN_PX`] from the line.
    pub number: i64,
    /// Number of pixels.
    pub count: f64,
    /// Means of u, u^2 and u^3.
    pub across: [f64; 3],
    /// Mean of t.
    pub along: f64,
    /// Mean of the place across the edge, from the window's middle, and its slope along the edge,
    /// which a bent edge has.
    pub from_middle: [f64; 2],
    /// Sum of (t - mean t)^2.
    pub spread: f64,
    /// Variance of t, and covariance of t and u.
    pub variance: [f64; 2],
    /// Slopes of u and of u^2 along t; 0 if `spread` is 0.
    pub tilt: [f64; 2],
    /// Mean of the values, linear light.
    pub mean: f64,
    /// Slope of the values along t (per pixel); 0 if `spread` is 0.
    pub slope: f64,
    /// Sum of squares of the values about their mean, sum of the products of value and u about both
    /// means, and sum of squares of u about its mean.
    pub scatter: [f64; 3],
}

/// Number of pieces along the edge into which uneven light needs a bin cut.
pub(crate) const STRIPS: usize = 4;

/// All pixels of a window, sorted by their distance from a line.
#[derive(Debug, Clone)]
pub struct Pixels {
    /// Line from which distances are measured.
    pub line: EdgeLine,
    /// Bins in ascending order of distance. None is empty.
    pub bins: Vec<Bin>,
    /// Finer bins of the same pixels: each bin is cut into `STRIPS` pieces along the edge.
    pub strips: Vec<Bin>,
    /// Factor by which means over many pixels scatter more, as a variance, than those of
    /// independent pixels.
    pub excess: f64,
    /// Limits at which the camera cut its noise off.
    pub cut: Cut,
    /// Positions of the pixels in the window.
    pub raster: Raster,
}

impl Pixels {
    /// Sorts all pixels of a window by their distance from `line`.
    pub fn new(window: &Window, line: &EdgeLine) -> Pixels {
        // No Legendre polynomial exceeds 1 within the curve.
        let bow = line
            .bend
            .map_or(0.0, |bend| bend.terms_px.iter().map(|t| t.abs()).sum());
        let reach = (window.width() + window.height()) as f64 + line.offset_px.abs() + bow;
        let limit = (reach / BIN_PX) as i64 + 1;
        let mut sums = vec![[Sums::default(); STRIPS]; 2 * limit as usize + 1];
        let ruler = line.ruler();
        let (sin, cos) = line.normal_rad.sin_cos();
        let half = 0.5 * (window.width() as f64 * sin.abs() + window.height() as f64 * cos.abs());
        let per_px = 0.5 * STRIPS as f64 / half;
        window.pixels().for_each(|p| {
            let (d, t) = ruler.place(p.x, p.y);
            let j = bin_at(d);
            let strip = (((t + half) * per_px).max(0.0) as usize).min(STRIPS - 1);
            let sum = &mut sums[(j as i64 + limit) as usize][strip];
            sum.add(d - j * BIN_PX, t, p.value);
            sum.place(p.x * cos + p.y * sin, t);
        });
        let (mut bins, mut strips) = (Vec::new(), Vec::new());
        for (number, parts) in (-limit..).zip(&sums) {
            let filled = || parts.iter().filter(|part| part.count > 0.0);
            bins.extend(
                filled()
                    .copied()
                    .reduce(Sums::with)
                    .map(|all| all.bin(number)),
            );
            strips.extend(filled().map(|part| part.bin(number)));
        }
        Pixels {
            line: *line,
            bins,
            strips,
            excess: window.excess(),
            cut: Cut {
                zero: window.cuts_off_at_zero(),
                full: window.ceiling(),
            },
            raster: window.raster(),
        }
    }

    /// Returns whether the light beside the edge is darker than the dark plateau, and cut off at 0.
    ///
    /// Only a camera that sharpens does this. Noise that is cut off leaves more light near the edge
    /// than on the plateau.
    pub(crate) fn undershoots_zero(&self) -> bool {
        // Bins of one pixel together. Noise that is cut off at 0 has a mean of 0.4 of its standard
        // deviation and scatters by 0.6: so many pixels have a twentieth of it by no chance.
        const TOGETHER: usize = 4;
        const LEAST: f64 = 64.0;
        const SHARE: f64 = 0.05;
        let dark = self.bins.partition_point(|bin| bin.number < 0);
        let dark = &self.bins[..dark];
        let light = |bins: &[Bin]| {
            let of = |bin: &Bin| [bin.count, bin.count * bin.mean];
            let sums = bins.iter().map(of);
            sums.fold([0.0; 2], |sum, own| [sum[0] + own[0], sum[1] + own[1]])
        };
        // Something bright far from the edge is in one of these quarters.
        let quarters = dark[..dark.len() / 2].chunks(dark.len().div_ceil(4).max(1));
        let levels = quarters.map(|bins| {
            let [count, sum] = light(bins);
            sum / count.max(1.0)
        });
        let plateau = levels.reduce(f64::min).unwrap_or(0.0);
        let mut near = dark[dark.len() / 2..].windows(TOGETHER).map(light);
        self.cut.zero && near.any(|[count, sum]| count >= LEAST && sum < SHARE * plateau * count)
    }

    /// Returns the mean levels of the outer twelfth of the bins, on the dark and on the bright side.
    pub(crate) fn plateaus(&self) -> [f64; 2] {
        let ends = (self.bins.len() / 12).max(4).min(self.bins.len());
        let level = |bins: &[Bin]| {
            let count: f64 = bins.iter().map(|bin| bin.count).sum();
            bins.iter().map(|bin| bin.count * bin.mean).sum::<f64>() / count
        };
        let (dark, bright) = (&self.bins[..ends], &self.bins[self.bins.len() - ends..]);
        [level(dark), level(bright)]
    }

    /// Returns the number of bins from the line to the farther end.
    pub fn reach(&self) -> usize {
        let ends = [self.bins.first(), self.bins.last()];
        let far = ends
            .into_iter()
            .flatten()
            .map(|bin| bin.number.unsigned_abs() as usize);
        far.max().unwrap_or(0)
    }
}

impl Bin {
    /// Returns the mean distance of the pixels from the line, pixels.
    pub fn distance_px(&self) -> f64 {
        self.number as f64 * BIN_PX + self.across[0]
    }
}

#[derive(Clone, Copy, Default)]
struct Sums {
    count: f64,
    u: [f64; 3],
    t: f64,
    tt: f64,
    tu: f64,
    tuu: f64,
    y: f64,
    yy: f64,
    yu: f64,
    yt: f64,
    s: f64,
    st: f64,
}

impl Sums {
    fn add(&mut self, u: f64, t: f64, y: f64) {
        self.count += 1.0;
        self.u[0] += u;
        self.u[1] += u * u;
        self.u[2] += u * u * u;
        self.t += t;
        self.tt += t * t;
        self.tu += t * u;
        self.tuu += t * u * u;
        self.y += y;
        self.yy += y * y;
        self.yu += y * u;
        self.yt += y * t;
    }

    /// Adds the place across the edge, from the window's middle, of the pixel that was added.
    fn place(&mut self, s: f64, t: f64) {
        self.s += s;
        self.st += s * t;
    }

    /// Returns the sums over the pixels of both.
    fn with(self, other: Sums) -> Sums {
        Sums {
            count: self.count + other.count,
            u: std::array::from_fn(|i| self.u[i] + other.u[i]),
            t: self.t + other.t,
            tt: self.tt + other.tt,
            tu: self.tu + other.tu,
            tuu: self.tuu + other.tuu,
            y: self.y + other.y,
            yy: self.yy + other.yy,
            yu: self.yu + other.yu,
            yt: self.yt + other.yt,
            s: self.s + other.s,
            st: self.st + other.st,
        }
    }

    /// Returns the bin of this number. There must be a pixel.
    fn bin(&self, number: i64) -> Bin {
        let n = self.count;
        let across = self.u.map(|sum| sum / n);
        let (along, mean) = (self.t / n, self.y / n);
        // With fewer than two distinct positions there is no slope, and the difference is mere
        // rounding.
        let spread = self.tt - n * along * along;
        let spread = if spread > 1e-9 * self.tt { spread } else { 0.0 };
        let per_spread = |sum: f64| if spread > 0.0 { sum / spread } else { 0.0 };
        let cross = [
            self.tu - n * along * across[0],
            self.tuu - n * along * across[1],
        ];
        Bin {
            number,
            count: n,
            across,
            along,
            from_middle: [self.s / n, per_spread(self.st - self.s * along)],
            spread,
            variance: [spread / n, cross[0] / n],
            tilt: cross.map(per_spread),
            mean,
            slope: per_spread(self.yt - n * along * mean),
            scatter: [
                self.yy - n * mean * mean,
                self.yu - n * mean * across[0],
                self.u[1] - n * across[0] * across[0],
            ],
        }
    }
}
