//! The smooth curve that an edge follows, and the waves that are left about it.
//!
//! ISO 12233:2023 allows a polynomial along the edge; the order of this one is chosen by the data.
//! The distances of the pixels from the common profile, over the slope of the profile, are how far
//! the edge lies off at their place. They are regressed on Legendre polynomials of the place.

use nalgebra::DMatrix;

use crate::numerics::factor;
use crate::numerics::factor::Products;
use crate::photographs::edge::line::{Bend, EdgeLine, ORDERS, legendre};
use crate::photographs::profile::{BIN_PX, Profile, smoothed};
use crate::photographs::window::Window;

/// Fall of chi-square that an order has to bring beyond that of Bayes' criterion. Noise reaches it
/// once in 3,000 straight edges.
const CLEAR: f64 = 4.0;

/// Height below which an edge counts as straight, pixels. Such a bow lowers the MTF at half the
/// sampling frequency by less than 1e-4.
const STRAIGHT_PX: f64 = 0.01;

/// Slope of the profile below which pixels say nothing of the edge's place, as a share of the
/// steepest.
const STEEP: f64 = 0.05;

/// Steepness of the profile, and what it says of the places of pixels.
pub(crate) struct Steepness {
    smooth: Vec<f64>,
    slopes: Vec<f64>,
    least: f64,
    reach: f64,
}

/// One pixel beside the profile.
pub(crate) struct Told {
    /// Distance from the edge, pixels.
    across_px: f64,
    /// Place along the edge, pixels.
    pub along_px: f64,
    /// Value of the profile at the pixel.
    pub level: f64,
    /// Slope of the profile at the pixel, per pixel.
    pub slope: f64,
    /// Distance of the pixel's value from the profile.
    pub off: f64,
    /// True for every second column, and for every second row.
    pub is_odd: [bool; 2],
}

impl Steepness {
    /// Smooths a profile and takes its slopes.
    pub(crate) fn new(profile: &Profile) -> Steepness {
        let slopes: Vec<f64> = (0..profile.len()).map(|j| profile.slope(j, 4)).collect();
        let steepest = slopes.iter().copied().fold(0.0, f64::max);
        Steepness {
            smooth: smoothed(&profile.mean, 2),
            slopes,
            least: STEEP * steepest,
            reach: profile.reach as f64,
        }
    }

    /// Returns the pixels in the reach of the profile.
    pub(crate) fn all<'a>(
        &'a self,
        window: &'a Window,
        line: &EdgeLine,
    ) -> impl Iterator<Item = Told> + 'a {
        let ruler = line.ruler();
        let last = self.smooth.len() as f64 - 1.0;
        let corner = [window.width(), window.height()].map(|side| 0.5 * (side as f64 - 1.0));
        window.pixels().filter_map(move |pixel| {
            let (across_px, along_px) = ruler.place(pixel.x, pixel.y);
            let at = across_px / BIN_PX + self.reach;
            if !(0.0..last).contains(&at) {
                return None;
            }
            let j = at as usize;
            let part = at - j as f64;
            let between = |curve: &[f64]| curve[j] + (curve[j + 1] - curve[j]) * part;
            let level = between(&self.smooth);
            Some(Told {
                across_px,
                along_px,
                level,
                slope: between(&self.slopes),
                off: pixel.value - level,
                is_odd: [pixel.x + corner[0], pixel.y + corner[1]].map(|at| at as i64 & 1 == 1),
            })
        })
    }

    /// Returns the pixels on the steep part of the edge.
    fn steep<'a>(&'a self, window: &'a Window, line: &EdgeLine) -> impl Iterator<Item = Told> + 'a {
        let is_steep = |told: &Told| told.slope > self.least;
        self.all(window, line).filter(is_steep)
    }

    /// Cuts the steep part of an edge into `count` pieces of equal length, and sums squares and
    /// products over the pixels of each.
    fn pieces(
        &self,
        window: &Window,
        line: &EdgeLine,
        [middle_px, half_px]: [f64; 2],
        count: usize,
    ) -> Vec<Piece> {
        let mut pieces = vec![Piece::default(); count];
        self.steep(window, line).for_each(|told| {
            let place = 0.5 * ((told.along_px - middle_px) / half_px + 1.0) * count as f64;
            let piece = &mut pieces[(place.max(0.0) as usize).min(count - 1)];
            piece.weight += told.slope * told.slope;
            piece.off += told.slope * told.off;
            piece.squares += told.off * told.off;
            piece.pixels += 1.0;
        });
        pieces
    }
}

/// Sums over the pixels of one piece of the edge.
#[derive(Debug, Clone, Copy, Default)]
struct Piece {
    /// Sum of the squares of the slope.
    weight: f64,
    /// Sum of the products of slope and distance from the profile.
    off: f64,
    /// Sum of the squares of the distances.
    squares: f64,
    /// Number of pixels.
    pixels: f64,
}

/// Columns of light that varies along the edge, which looks like a bend. They are an additive light
/// and a factor, both of first and second order, and a factor that turns across the edge.
const LIGHT: usize = 5;

/// First column of the curve. Its columns are the orders 0 to 9.
const CURVE: usize = LIGHT;

/// Column of the distances from the profile.
const OFF: usize = CURVE + ORDERS + 1;

/// Farthest that a term of the curve may move in one step, pixels.
const FARTHEST_PX: f64 = 4.0;

/// Moves the curve of an edge towards the pixels by one Gauss-Newton step, and raises its order if
/// the data ask for it. Returns how far the edge moved at most, pixels, or `None` if it is
/// straight.
pub(crate) fn step(window: &Window, line: &mut EdgeLine, profile: &Profile) -> Option<f64> {
    let steepness = Steepness::new(profile);
    let mut bend = match line.bend {
        Some(bend) => bend,
        None if steepness.looks_straight(window, line) => return None,
        None => span(&steepness, window, line)?,
    };
    let (normal, pixels) = steepness.normal(window, line, &bend);
    let factor = factor::of(normal);
    let falls = factor.column(OFF);
    let variance = window.excess() * falls[OFF].powi(2) / pixels.max(1.0);
    let order = order(&falls.as_slice()[CURVE..OFF], variance, pixels).max(bend.order);
    if order < 2 {
        return None;
    }
    // Columns beyond the chosen order do not touch the rows before them.
    let found = factor::back_substituted(&factor, CURVE + order + 1, OFF);
    // Where pixels are too bright the edge lies further towards the dark side.
    let mut farthest = 0.0_f64;
    for (term, k) in bend.terms_px.iter_mut().zip(2..=order) {
        let step = found[CURVE + k].clamp(-FARTHEST_PX, FARTHEST_PX);
        *term -= step;
        farthest += step.abs();
    }
    let straight = *line;
    bend.order = order;
    line.bend = Some(bend);
    if straight.bend.is_none() && line.bow_px() < STRAIGHT_PX {
        *line = straight;
        return None;
    }
    line.turn((found[CURVE + 1] / bend.half_px).clamp(-0.1, 0.1));
    Some(farthest)
}

/// Returns a straight curve that spans the steep pixels of an edge, or `None` if there are too few.
fn span(steepness: &Steepness, window: &Window, line: &EdgeLine) -> Option<Bend> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    steepness.steep(window, line).for_each(|told| {
        (low, high) = (low.min(told.along_px), high.max(told.along_px));
    });
    (high > low).then_some(Bend {
        middle_px: 0.5 * (low + high),
        half_px: 0.5 * (high - low),
        terms_px: [0.0; ORDERS - 1],
        order: 1,
    })
}

impl Steepness {
    /// Returns whether no order is worth its price by the places of pieces of the edge alone, which
    /// take a fraction of the time of the whole regression. Light that varies along the edge can
    /// only make a straight edge look bent here.
    fn looks_straight(&self, window: &Window, line: &EdgeLine) -> bool {
        let half_px = 0.5 * (window.width() as f64).hypot(window.height() as f64);
        let pieces = self.pieces(window, line, [0.0, half_px], PIECES);
        const COLUMNS: usize = ORDERS + 2;
        let mut normal = Products::new(COLUMNS);
        for (k, piece) in pieces.iter().enumerate().filter(|(_, p)| p.weight > 0.0) {
            let place = (k as f64 + 0.5) / PIECES as f64 * 2.0 - 1.0;
            let (values, _) = legendre(place);
            let root = piece.weight.sqrt();
            let mut row = [0.0; COLUMNS];
            for (column, value) in row.iter_mut().zip(values) {
                *column = root * value;
            }
            row[COLUMNS - 1] = piece.off / root;
            normal.add(&row);
        }
        let squares: f64 = pieces.iter().map(|piece| piece.squares).sum();
        let pixels: f64 = pieces.iter().map(|piece| piece.pixels).sum();
        let factor = factor::of(normal.sum());
        let falls = factor.column(COLUMNS - 1);
        let explained: f64 = falls.iter().take(ORDERS + 1).map(|fall| fall * fall).sum();
        let variance = (squares - explained).max(0.0) / f64::max(pixels, 1.0);
        let variance = window.excess() * variance;
        order(&falls.as_slice()[..=ORDERS], variance, pixels) < 2
    }

    /// Returns the normal matrix of light, curve and distances over all pixels of the profile, and
    /// the number of pixels.
    fn normal(&self, window: &Window, line: &EdgeLine, bend: &Bend) -> (DMatrix<f64>, f64) {
        let mut normal = Products::new(OFF + 1);
        let mut pixels = 0.0;
        self.all(window, line).for_each(|told| {
            let (level, slope) = (told.level, told.slope);
            let t = (told.along_px - bend.middle_px) / bend.half_px;
            let across = level * t * told.across_px / bend.half_px;
            let mut row = [0.0; OFF + 1];
            row[..LIGHT].copy_from_slice(&[t, t * t, level * t, level * t * t, across]);
            if slope > self.least {
                let (values, _) = legendre(t.clamp(-1.0, 1.0));
                for (column, value) in row[CURVE..].iter_mut().zip(values) {
                    *column = slope * value;
                }
            }
            row[OFF] = told.off;
            normal.add(&row);
            pixels += 1.0;
        });
        (normal.sum(), pixels)
    }
}

/// Returns the order at which Bayes' criterion is least. `falls` are the roots of the falls of the
/// sum of squares by each order.
fn order(falls: &[f64], variance: f64, pixels: f64) -> usize {
    let price = pixels.max(1.0).ln() + CLEAR;
    let (mut best, mut least, mut sum) = (1, 0.0, 0.0);
    for (k, fall) in falls.iter().enumerate().skip(2) {
        sum += price - fall * fall / variance.max(f64::MIN_POSITIVE);
        if sum < least {
            (best, least) = (k, sum);
        }
    }
    best
}

/// Waves of an edge that are left about its curve.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Waves {
    /// Root mean square of the waves that noise does not explain, pixels.
    pub rms_px: f64,
    /// Largest distance of a piece of the edge from the curve, pixels.
    pub most_px: f64,
    /// Share by which the waves lower the MTF where it is one half.
    pub loss: f64,
}

/// Least length of a piece of the edge, pixels, and largest number of pieces.
const PIECE_PX: f64 = 8.0;
const PIECES: usize = 32;

/// Measures the waves that are left about the curve of an edge: it is cut into pieces, and the
/// place of each is measured. Noise is taken off. Waves shorter than two pieces count as blur.
///
/// `rise_px` is the distance from 10 to 90 % of the step. Waves with the variance v on a blur of
/// variance b lower the MTF to 2^-(v/b) of itself where it is one half.
pub(crate) fn waves(window: &Window, line: &EdgeLine, profile: &Profile, rise_px: f64) -> Waves {
    let none = Waves::default();
    let steepness = Steepness::new(profile);
    let Some(span) = line.bend.or_else(|| span(&steepness, window, line)) else {
        return none;
    };
    let count = ((2.0 * span.half_px / PIECE_PX) as usize).clamp(1, PIECES);
    let extent = [span.middle_px, span.half_px];
    let mut pieces = steepness.pieces(window, line, extent, count);
    pieces.retain(|piece| piece.weight > 0.0);
    let (mut weight, mut square, mut most) = (0.0, 0.0, 0.0_f64);
    let (mut scatter, mut freedom) = (0.0, 0.0);
    for piece in &pieces {
        let explained = piece.off * piece.off / piece.weight;
        scatter += piece.squares - explained;
        freedom += piece.pixels - 1.0;
        weight += piece.weight;
        square += explained;
        most = most.max((piece.off / piece.weight).abs());
    }
    let variance = window.excess() * scatter / f64::max(freedom, 1.0);
    let free = pieces.len().saturating_sub(2).max(1) as f64;
    let noise = variance * free;
    // Chance exceeds this once in 10^6 edges.
    if square <= noise + 5.0 * variance * (2.0 * free).sqrt() || rise_px <= 0.0 {
        return none;
    }
    let rms2 = (square - noise) / weight;
    Waves {
        rms_px: rms2.sqrt(),
        most_px: most,
        loss: loss(rms2, rise_px),
    }
}

/// Returns the share by which places of an edge that scatter with a variance (pixels^2) lower the
/// MTF where it is one half. Both blurs are taken as normal.
pub(crate) fn loss(variance_px2: f64, rise_px: f64) -> f64 {
    // The rise of a normal edge is 2.563 standard deviations.
    let blur2 = (rise_px / 2.563).powi(2);
    if variance_px2 > 0.0 && rise_px > 0.0 {
        1.0 - (-std::f64::consts::LN_2 * variance_px2 / blur2).exp()
    } else {
        0.0
    }
}
