//! Correction of uneven light (vignetting, gradients of the source): it is found beside the edge.
//!
//! The light is a factor on everything: exp(q), where q is a polynomial in the place x, y within the
//! window, in units of half its width and half its height.
//!
//! ```text
//! first order:   x, y
//! second order:  x^2, x y, y^2
//! third order:   x^3, x^2 y, x y^2, y^3
//! fourth order:  (x^2 + y^2)^2, with x and y in units of half the diagonal
//! ```
//!
//! These are the terms of the loss `edge` (`estimator::compare::light`), turned with the window.
//! Two kinds of differences show them:
//!
//! - Along the edge: an edge is the same all along, so pixels at the same distance from it differ by
//!   the light alone.
//! - Across the edge, light and blur are told apart by symmetry. About its middle a blurred edge is
//!   odd, however far its tails reach. So the even part of the profile is the light's. Where the
//!   window is much wider than the blur, the odd part is that of the light and of tails that fall
//!   with the distance.
//!
//! Both leave out the middle of the profile: there a bowed edge looks like light, and the blur itself
//! may have an even part (coma). A small error in the place, the turn or the bow of the edge is
//! estimated with the light.
//!
//! All terms have a normal distribution before the pixels are seen. What the pixels do not tell
//! stays within it, and reaches the standard errors, see [`Noise`].

use nalgebra::{DMatrix, DVector};

use crate::numerics::chance;
use crate::numerics::factor;
use crate::numerics::factor::Products;
use crate::photographs::edge::line::EdgeLine;
use crate::photographs::edge::shape;
use crate::photographs::profile::{BIN_PX, Noise, Profile, bin_at, smoothed};
use crate::photographs::window::{Pixel, Window};

/// Number of terms of the light, and of those up to second order.
const LIGHT: usize = 10;
const SECOND_ORDER: usize = 5;

/// Standard deviations of the terms before the pixels are seen: first, second, third and fourth
/// order. Light that falls to 0.7 by cos^4 has up to 0.01 of third order and 0.04 of fourth.
const BEFORE: [f64; LIGHT] = [0.5, 0.5, 0.3, 0.3, 0.3, 0.02, 0.02, 0.02, 0.02, 0.05];

/// Probability of the terms up to second order in even light below which the light is uneven.
const RARE: f64 = 1e-4;

/// Least unevenness over the window that is corrected. It moves MTF50 by less than 0.3 %, and the
/// asymmetric halo of a real lens can look like unevenness of this size.
const LEAST: f64 = 0.005;

/// Standard errors by which a step moves the light once it is found.
const FOUND: f64 = 0.1;

/// Number of pieces along the edge. A cubic differs from its means over the pieces by less than
/// 1/1,000 of itself.
const STRIPS: usize = 16;

/// Columns of the regression: the mean of both plateaus; place, turn and bow of the edge; half of the
/// step, and tails that fall as powers of the distance; the light; and what is explained.
const EDGE: usize = 1;
const STEP: usize = 4;
const TAILS: usize = 3;
const FIRST_LIGHT: usize = STEP + 1 + TAILS;
const OFF: usize = FIRST_LIGHT + LIGHT;
const COLUMNS: usize = OFF + 1;

/// Standard deviation of place, turn and bow before the pixels are seen, pixels.
const ASTRAY_PX: f64 = 0.5;

/// Standard deviation of each tail before the pixels are seen, at the distance of a rise, as a share
/// of the step.
const TAIL: f64 = 0.3;

/// Error of the tails as powers of the distance, as a share of the step. Photographs almost without
/// noise would otherwise show it as light.
const TAIL_ERROR: f64 = 1e-3;

/// Rises (10 to 90 %) that the middle of the profile takes on either side, and the least reach for
/// which tails are told from light.
const MIDDLE: f64 = 1.5;
const WIDE: f64 = 6.0;

/// The light about an edge. It is 1 on the edge abreast of the window's centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Light {
    /// Coefficients of the terms.
    terms: [f64; LIGHT],
    /// Half of the window's width and height, pixels.
    half_px: [f64; 2],
    /// The exponent on the edge abreast of the window's centre.
    on_edge: f64,
}

impl Light {
    /// Returns even light over a window.
    pub(crate) fn even(window: &Window) -> Light {
        Light {
            terms: [0.0; LIGHT],
            half_px: [window.width(), window.height()].map(|side| 0.5 * side as f64),
            on_edge: 0.0,
        }
    }

    /// Returns the light at a pixel.
    pub(crate) fn at(&self, pixel: &Pixel) -> f64 {
        (self.exponent([pixel.x, pixel.y]) - self.on_edge).exp()
    }

    /// Returns the ratio of the largest to the smallest light in the window, less 1.
    pub(crate) fn unevenness(&self, window: &Window) -> f64 {
        let ends = window.outline().map(|pixel| self.at(&pixel));
        let (low, high) = ends.fold((1.0_f64, 1.0_f64), |(low, high), light| {
            (low.min(light), high.max(light))
        });
        high / low - 1.0
    }

    fn exponent(&self, place: [f64; 2]) -> f64 {
        let powers = self.powers(place);
        powers.iter().zip(&self.terms).map(|(p, c)| p * c).sum()
    }

    /// Returns the terms at a place from the window's centre, pixels.
    fn powers(&self, [x, y]: [f64; 2]) -> [f64; LIGHT] {
        let [width, height] = self.half_px;
        let square = (x * x + y * y) / (width * width + height * height);
        let (x, y) = (x / width, y / height);
        [
            x,
            y,
            x * x,
            x * y,
            y * y,
            x * x * x,
            x * x * y,
            x * y * y,
            y * y * y,
            square * square,
        ]
    }
}

/// Finds the light of a window that is evened out by `so_far`. Returns `None` if no step is left: if
/// the light is even, or noise explains its unevenness, or `so_far` is the light.
pub(crate) fn find(
    window: &Window,
    line: &EdgeLine,
    profile: &Profile,
    so_far: Option<&Light>,
) -> Option<Light> {
    let mut light = so_far.copied().unwrap_or(Light::even(window));
    let bins = bins(window, line, profile, &light);
    let regression = Regression::new(&bins, line, profile, &light);
    let factor = factor::of(regression.along + regression.across.0);
    let falls = factor.column(OFF);
    let noise = (falls[OFF].powi(2) / regression.freedom.max(1) as f64).max(1.0);
    let fall = |terms: usize| falls.rows(FIRST_LIGHT, terms).norm_squared() / noise;
    let is_left = match so_far {
        None => chance::of_squares(fall(SECOND_ORDER), SECOND_ORDER) < RARE,
        Some(_) => fall(LIGHT) > FOUND * FOUND,
    };
    let step = factor::back_substituted(&factor, OFF, OFF);
    for (term, by) in light.terms.iter_mut().zip(&step.as_slice()[FIRST_LIGHT..]) {
        *term += by;
    }
    light.on_edge = light.exponent(on_edge(line));
    let is_seen = so_far.is_some() || light.unevenness(window) > LEAST;
    (is_left && is_seen).then_some(light)
}

/// Returns what the estimate of the light adds to the noise of a profile that is evened out by it.
pub(crate) fn noise(
    window: &Window,
    line: &EdgeLine,
    profile: &Profile,
    light: &Light,
) -> Option<Noise> {
    let bins = bins(window, line, profile, light);
    let Regression {
        along,
        across: (across, pairs),
        freedom: _,
    } = Regression::new(&bins, line, profile, light);
    let own = |normal: DMatrix<f64>| normal.view((0, 0), (OFF, OFF)).into_owned();
    let (along, across) = (own(along), own(across));
    let mut normal = &along + &across;
    normal.fill_lower_triangle_with_upper_triangle();
    let inverse = normal.cholesky()?.inverse();
    let light_rows = inverse.rows(FIRST_LIGHT, LIGHT);
    let mut by_bin = DMatrix::zeros(LIGHT, profile.len());
    for Pair { k, sign, root, row } in &pairs {
        let row = DVector::from_column_slice(&row[..OFF]);
        let change = light_rows * row * (0.5 * root);
        by_bin.column_mut(profile.reach + k).axpy(1.0, &change, 1.0);
        by_bin
            .column_mut(profile.reach - k)
            .axpy(*sign, &change, 1.0);
    }
    let from = light.powers(on_edge(line));
    let by_light = DMatrix::from_fn(profile.len(), LIGHT, |j, i| {
        profile.mean[j] * (bins[j].powers[i] - from[i])
    });
    // The normal matrix of what differs along the edge, and of the priors, is that of its noise.
    let others = light_rows * factor::of(along).transpose();
    Some(Noise {
        by_light,
        by_bin,
        others,
    })
}

/// Returns the place of the edge abreast of the window's centre, pixels.
fn on_edge(line: &EdgeLine) -> [f64; 2] {
    let (sin, cos) = line.normal_rad.sin_cos();
    [line.offset_px * cos, line.offset_px * sin]
}

/// Pixels of one bin in one strip along the edge: number, sums of their places and of their
/// distances from the profile.
#[derive(Clone, Copy, Default)]
struct Cell {
    n: f64,
    place: [f64; 2],
    off: f64,
}

/// Pixels of one bin.
struct Bin {
    cells: [Cell; STRIPS],
    /// Means of the terms of the light.
    powers: [f64; LIGHT],
}

/// Sorts the pixels of a window into the bins of the profile.
fn bins(window: &Window, line: &EdgeLine, profile: &Profile, light: &Light) -> Vec<Bin> {
    let mut cells = vec![[Cell::default(); STRIPS]; profile.len()];
    let ruler = line.ruler();
    let (sin, cos) = line.normal_rad.sin_cos();
    let half = 0.5 * (window.width() as f64 * sin.abs() + window.height() as f64 * cos.abs());
    let per_px = 0.5 * STRIPS as f64 / half;
    window.pixels().for_each(|pixel| {
        let (s, t) = ruler.place(pixel.x, pixel.y);
        let Some(expected) = profile.at(s) else {
            return;
        };
        let strip = (((t + half) * per_px).max(0.0) as usize).min(STRIPS - 1);
        let bin = bin_at(s) + profile.reach as f64;
        let cell = &mut cells[bin as usize][strip];
        cell.n += 1.0;
        cell.place[0] += pixel.x;
        cell.place[1] += pixel.y;
        cell.off += pixel.value - expected;
    });
    let bin = |mut cells: [Cell; STRIPS]| {
        let mut powers = [0.0; LIGHT];
        let mut n = 0.0;
        for cell in cells.iter_mut().filter(|cell| cell.n > 0.0) {
            cell.place = cell.place.map(|sum| sum / cell.n);
            cell.off /= cell.n;
            n += cell.n;
            for (sum, power) in powers.iter_mut().zip(light.powers(cell.place)) {
                *sum += cell.n * power;
            }
        }
        Bin {
            cells,
            powers: powers.map(|sum| if n > 0.0 { sum / n } else { 0.0 }),
        }
    };
    cells.into_iter().map(bin).collect()
}

/// What the regression needs to know of a profile.
struct Seen {
    /// Levels of the bins without most of their noise. Columns with the noise of what they explain
    /// would bias the light.
    level: Vec<f64>,
    plateaus: [f64; 2],
    rise_px: f64,
    reach_px: f64,
    /// First bin beyond the middle of the profile.
    first: usize,
}

impl Seen {
    fn new(profile: &Profile) -> Seen {
        let (dark, bright) = profile.plateaus();
        let rise_px = shape::rise_px(profile).unwrap_or(0.0);
        let most = profile.reach / 4;
        Seen {
            level: smoothed(&profile.mean, (profile.reach / 8).max(2)),
            plateaus: [dark, bright],
            rise_px,
            reach_px: profile.reach as f64 * BIN_PX,
            first: (((MIDDLE * rise_px + 1.0) / BIN_PX) as usize).clamp(most.min(8), most),
        }
    }
}

/// Half of the sum or of the difference of two bins at the same distance from the edge.
struct Pair {
    /// Distance, bins.
    k: usize,
    /// Sign of the bin on the dark side.
    sign: f64,
    /// Reciprocal of the standard deviation.
    root: f64,
    row: [f64; COLUMNS],
}

/// Normal equations of the light.
struct Regression {
    /// Those of differences along the edge, and of what is known before.
    along: DMatrix<f64>,
    /// Those of the even part of the profile, with its rows.
    across: (DMatrix<f64>, Vec<Pair>),
    /// Number of independent differences less that of the terms.
    freedom: usize,
}

impl Regression {
    fn new(bins: &[Bin], line: &EdgeLine, profile: &Profile, light: &Light) -> Regression {
        let seen = Seen::new(profile);
        let mut along = Products::new(COLUMNS);
        let mut freedom = 0;
        for (j, bin) in bins.iter().enumerate() {
            if j.abs_diff(profile.reach) >= seen.first && profile.count[j] >= 2.0 {
                let level = seen.level[j];
                freedom += add_along(&mut along, bin, (j, level), line, profile, light);
            }
        }
        for (term, (so_far, deviation)) in light.terms.iter().zip(BEFORE).enumerate() {
            let mut row = [0.0; COLUMNS];
            row[FIRST_LIGHT + term] = 1.0 / deviation;
            row[OFF] = -so_far / deviation;
            along.add(&row);
        }
        let step = seen.plateaus[1] - seen.plateaus[0];
        for column in EDGE..FIRST_LIGHT {
            let mut row = [0.0; COLUMNS];
            row[column] = match column {
                EDGE..STEP => 1.0 / ASTRAY_PX,
                // It may be anything.
                STEP => 1e-3 / step,
                _ => 1.0 / TAIL,
            };
            along.add(&row);
        }
        let parts: &[f64] = if seen.reach_px >= WIDE * seen.rise_px {
            &[1.0, -1.0]
        } else {
            &[1.0]
        };
        let both = |k: usize| parts.iter().map(move |&sign| (k, sign));
        let pairs: Vec<Pair> = (seen.first..=profile.reach)
            .flat_map(both)
            .filter_map(|(k, sign)| pair(k, sign, bins, profile, &seen))
            .collect();
        let mut across = Products::new(COLUMNS);
        pairs.iter().for_each(|pair| across.add(&pair.row));
        Regression {
            along: along.sum(),
            freedom: (freedom + pairs.len()).saturating_sub(OFF),
            across: (across.sum(), pairs),
        }
    }
}

/// Adds the differences between the pixels of one bin along the edge, and returns their number.
fn add_along(
    products: &mut Products,
    bin: &Bin,
    (j, level): (usize, f64),
    line: &EdgeLine,
    profile: &Profile,
    light: &Light,
) -> usize {
    let (sin, cos) = line.normal_rad.sin_cos();
    let half = light.half_px[0].hypot(light.half_px[1]);
    let slope = profile.slope(j, 4);
    let cells = || bin.cells.iter().filter(|cell| cell.n > 0.0);
    // The row of a cell before the bin's mean is taken off.
    let whole = |cell: &Cell| {
        let [x, y] = cell.place;
        let t = (y * cos - x * sin) / half;
        let mut row = [0.0; COLUMNS];
        row[EDGE + 1] = slope * t;
        row[EDGE + 2] = slope * t * t;
        let powers = light.powers(cell.place);
        for (column, power) in row[FIRST_LIGHT..].iter_mut().zip(powers) {
            *column = level * power;
        }
        row[OFF] = cell.off;
        row
    };
    let mut mean = [0.0; COLUMNS];
    for cell in cells() {
        for (mean, value) in mean.iter_mut().zip(whole(cell)) {
            *mean += cell.n / profile.count[j] * value;
        }
    }
    let root = (profile.variance[j] * profile.count[j]).sqrt().recip();
    for cell in cells() {
        let mut row = whole(cell);
        for (value, mean) in row.iter_mut().zip(mean) {
            *value = cell.n.sqrt() * root * (*value - mean);
        }
        products.add(&row);
    }
    cells().count().saturating_sub(1)
}

/// Returns the row of the even (`sign` 1) or odd (-1) part of the profile `k` bins from the edge, or
/// `None` if a bin is empty.
fn pair(k: usize, sign: f64, bins: &[Bin], profile: &Profile, seen: &Seen) -> Option<Pair> {
    let (low, high) = (profile.reach - k, profile.reach + k);
    if profile.count[low] == 0.0 || profile.count[high] == 0.0 {
        return None;
    }
    let part = |of: &dyn Fn(usize) -> f64| 0.5 * (of(high) + sign * of(low));
    let [dark, bright] = seen.plateaus;
    let astray = if sign > 0.0 {
        0.0
    } else {
        (2.0 * TAIL_ERROR * (bright - dark)).powi(2)
    };
    let root = 2.0 / (profile.variance[low] + profile.variance[high] + astray).sqrt();
    let mut row = [0.0; COLUMNS];
    if sign > 0.0 {
        row[0] = 1.0;
    } else {
        row[STEP] = 1.0;
        let near = seen.rise_px / (k as f64 * BIN_PX);
        for (power, column) in (1..).zip(&mut row[STEP + 1..FIRST_LIGHT]) {
            *column = (bright - dark) * near.powi(power);
        }
    }
    row[EDGE] = part(&|j| profile.slope(j, 4));
    for (i, column) in row[FIRST_LIGHT..OFF].iter_mut().enumerate() {
        *column = part(&|j| seen.level[j] * bins[j].powers[i]);
    }
    row[OFF] = part(&|j| profile.mean[j]) - 0.5 * (bright + sign * dark);
    Some(Pair {
        k,
        sign,
        root,
        row: row.map(|value| root * value),
    })
}
