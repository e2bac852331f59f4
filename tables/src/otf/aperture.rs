//! Apertures of single cubes: pieces with their Jones matrices, and the strips into which they are
//! cut across an edge normal.
//!
//! Paths of a direction enter. Cubes leave, and the integral of a wave over the overlap of two
//! chords. [`crate::otf::wave`] says what is computed, and why.

use num_complex::Complex64;

use crate::otf::polygon_wave::sinc;
use crate::table::exact::Path;
use crate::table::polygon::{area, clip};

/// Deviation of light, rad, up to which it is left out, with an error of 0.45 deviation x c/lambda
/// in the OTF. A mesh in single precision deviates by less.
const STRAIGHT: f64 = 1e-7;

/// Distance of the fixed points of two paths of one cube, edge lengths, without deviation: that of
/// rounded meshes.
///
/// A path leaves the apex of its cube where it is. So its fixed point is half the deviation times
/// the depth of the cube from the foot of the apex, whose depth seen obliquely is a few edge
/// lengths at most.
const SAME_FOOT: f64 = 1e-3;

/// Share of the smaller one of two polygons from which on they overlap.
///
/// The pieces of a cube do not overlap, but interpolation moves their sides.
const OVERLAP: f64 = 0.1;

/// Smallest distance of two corners that bound a strip, edge lengths.
const SAME_CORNER: f64 = 1e-12;

/// Straight line over a strip: its values at both ends.
pub(crate) type EndValues = [f64; 2];

/// Part of a piece along the normal within a strip, measured from the cube's q.
#[derive(Debug, Clone)]
pub(crate) struct Chord {
    low: EndValues,
    high: EndValues,
    /// Number of the piece.
    pub(crate) piece: usize,
}

/// Part of an aperture between two neighbouring corners, across the edge normal; edge lengths.
#[derive(Debug, Clone)]
pub(crate) struct Strip {
    /// Width of the strip, across the normal.
    pub(crate) width: f64,
    pub(crate) chords: Vec<Chord>,
}

/// Piece of an aperture whose light is tilted; edge lengths, (along the normal, across it).
#[derive(Debug, Clone)]
pub(crate) struct Piece {
    pub(crate) polygon: Vec<[f64; 2]>,
    /// Tangents of the deviation.
    pub(crate) tilt: [f64; 2],
    /// Product of the tilt with the place from which its phase counts.
    pub(crate) origin: f64,
}

/// Aperture of a cube.
#[derive(Debug, Clone)]
pub(crate) enum Aperture {
    Straight(Vec<Strip>),
    Tilted(Vec<Piece>),
}

/// Aperture of a cube, and the products of the amplitudes of its pieces.
#[derive(Debug, Clone)]
pub(crate) struct Cube {
    pub(crate) aperture: Aperture,
    /// tr(J_a J_b^H)/2 in row-major order.
    products: Vec<Complex64>,
    pieces: usize,
    /// For each piece, the one that it becomes by half a turn, if there are such. Then `aperture` is
    /// the half from the middle on.
    pub(crate) turned: Option<Vec<usize>>,
    /// Whether all pieces have one amplitude, or amplitudes that do not change if the aperture is
    /// turned by half a turn: then only cosines count.
    pub(crate) is_even: bool,
}

/// Returns the tangent of the angle by which light leaves off the way back.
pub(crate) fn astray(path: &Path) -> f64 {
    path.deviation[0].hypot(path.deviation[1])
}

/// Returns half the trace of J_a J_b^H, the product of two pieces for unpolarised light. Ideal
/// mirrors keep the field in space.
fn product(a: &Path, b: &Path) -> Complex64 {
    let (Some(ours), Some(theirs)) = (&a.jones, &b.jones) else {
        return (a.weight.max(0.0) * b.weight.max(0.0)).sqrt().into();
    };
    let pairs = ours.as_flattened().iter().zip(theirs.as_flattened());
    let complex = |&[re, im]: &[f64; 2]| Complex64::new(re, im);
    let sum: Complex64 = pairs.map(|(a, b)| complex(a) * complex(b).conj()).sum();
    0.5 * sum
}

impl Cube {
    /// Makes the aperture of a cube with its apex over `foot`. `cosine` is that of the incidence
    /// outside.
    pub(crate) fn new(paths: &[&Path], foot: [f64; 2], cosine: f64, normal: [f64; 2]) -> Cube {
        let turned =
            |x: f64, y: f64| [normal[0] * x + normal[1] * y, normal[0] * y - normal[1] * x];
        let is_tilted = paths.iter().any(|path| astray(path) > STRAIGHT);
        let seen = |path: &&Path| {
            let leaving = |p: &[f64; 2]| {
                let shift = path.shift(*p);
                // Without a tilt, pieces that touch before the sheet touch behind it too, whatever
                // rounding their maps have.
                let [x, y] = [0, 1].map(|k| match is_tilted {
                    true => p[k] + shift[k] - foot[k],
                    false => foot[k] - p[k],
                });
                turned(x * cosine, y)
            };
            let [across, along] = path.deviation;
            let tilt = turned(across, along);
            // Light through the apex of depth D leaves its foot by 2 f = D tilt aside, and its way is
            // longer by D tilt^2/2: so its phase is that of a tilt about the fixed point f.
            let [x, y] = fixed_point(path);
            let fixed = turned((x - foot[0]) * cosine, y - foot[1]);
            Piece {
                polygon: path.polygon.iter().map(leaving).collect(),
                tilt,
                origin: tilt[0] * fixed[0] + tilt[1] * fixed[1],
            }
        };
        let pieces: Vec<Piece> = paths.iter().map(seen).collect();
        let products: Vec<Complex64> = paths
            .iter()
            .flat_map(|a| paths.iter().map(|b| product(a, b)))
            .collect();
        let turned = (!is_tilted).then(|| turned_pieces(&pieces)).flatten();
        Cube {
            pieces: pieces.len(),
            is_even: paths.iter().all(|path| path.jones.is_none())
                || products.iter().all(|&own| own == products[0]),
            products,
            aperture: if is_tilted {
                Aperture::Tilted(pieces)
            } else {
                Aperture::Straight(strips(&pieces, turned.is_some()))
            },
            turned,
        }
    }

    pub(crate) fn product(&self, a: usize, b: usize) -> Complex64 {
        self.products[a * self.pieces + b]
    }

    /// Returns the number of pairs that an evaluation takes.
    pub(crate) fn pairs(&self) -> usize {
        match &self.aperture {
            Aperture::Straight(strips) => {
                strips.iter().map(|strip| strip.chords.len().pow(2)).sum()
            }
            Aperture::Tilted(pieces) => pieces.len().pow(2),
        }
    }

    /// Returns the longest lag at which the cube overlaps itself, edge lengths.
    pub(crate) fn extent(&self) -> f64 {
        let width = |places: &mut dyn Iterator<Item = f64>| {
            let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
                (low.min(at), high.max(at))
            });
            high - low
        };
        match &self.aperture {
            Aperture::Straight(strips) => {
                let own = strips.iter().map(|strip| {
                    let chords = strip.chords.iter();
                    width(&mut chords.flat_map(|chord| {
                        [chord.low[0], chord.low[1], chord.high[0], chord.high[1]]
                    }))
                });
                own.fold(0.0, f64::max)
            }
            Aperture::Tilted(pieces) => {
                let corners = pieces.iter().flat_map(|piece| &piece.polygon);
                width(&mut corners.map(|corner| corner[0]))
            }
        }
    }
}

/// Foot q of a cube's apex, and the paths of the cube.
pub(crate) type CubePaths<'a> = ([f64; 2], Vec<&'a Path>);

/// Sorts paths by their cubes: the paths of one cube have one fixed point, and do not overlap.
///
/// Cubes of two kinds may have one fixed point, because each is seen from its own rim.
///
/// Light along an order of facets and along the same order turned round deviates to opposite sides, so
/// the mean of the fixed points is the foot of the apex.
pub(crate) fn cubes(paths: &[Path]) -> Vec<CubePaths<'_>> {
    let mut cubes: Vec<CubePaths> = Vec::new();
    let same = SAME_FOOT + 2.0 * paths.iter().map(astray).fold(0.0, f64::max);
    for path in paths {
        let foot = fixed_point(path);
        let own = cubes.iter_mut().find(|(other, pieces)| {
            (foot[0] - other[0]).hypot(foot[1] - other[1]) < same
                && !pieces.iter().any(|piece| overlap(piece, path))
        });
        match own {
            Some((_, pieces)) => pieces.push(path),
            None => cubes.push((foot, vec![path])),
        }
    }
    if same > SAME_FOOT {
        for (foot, pieces) in &mut cubes {
            let mean = |k: usize| {
                let all = pieces.iter().map(|path| fixed_point(path)[k]);
                all.sum::<f64>() / pieces.len() as f64
            };
            *foot = [mean(0), mean(1)];
        }
    }
    cubes
}

/// Returns the point whose shift is 0.
fn fixed_point(path: &Path) -> [f64; 2] {
    let [[uu, uv], [vu, vv]] = path.matrix;
    let [u, v] = path.offset;
    let determinant = uu * vv - uv * vu;
    [
        (uv * v - vv * u) / determinant,
        (vu * u - uu * v) / determinant,
    ]
}

/// Returns whether the polygons of two paths overlap.
fn overlap(a: &Path, b: &Path) -> bool {
    let both = intersection(&a.polygon, &b.polygon);
    area(&both) > OVERLAP * a.area().min(b.area())
}

/// Returns the part of a convex polygon within another one.
pub(crate) fn intersection(a: &[[f64; 2]], b: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let sides = b.iter().zip(b.iter().cycle().skip(1));
    sides.fold(a.to_vec(), |rest, (p, q)| {
        let outside =
            |at: [f64; 2]| (q[1] - p[1]) * (at[0] - p[0]) - (q[0] - p[0]) * (at[1] - p[1]);
        clip(&rest, outside, |p, q, part| {
            [0, 1].map(|k| p[k] + part * (q[k] - p[k]))
        })
    })
}

pub(crate) fn moved(polygon: &[[f64; 2]], by: f64) -> Vec<[f64; 2]> {
    polygon.iter().map(|&[x, y]| [x + by, y]).collect()
}

/// Returns for each piece the one that it becomes by half a turn about the foot of the apex; `None`
/// if a piece has none.
fn turned_pieces(pieces: &[Piece]) -> Option<Vec<usize>> {
    let same =
        |[x, y]: [f64; 2], other: &[f64; 2]| (x + other[0]).hypot(y + other[1]) < SAME_CORNER;
    let becomes = |a: &Piece, b: &Piece| {
        let mut corners = a.polygon.iter();
        a.polygon.len() == b.polygon.len()
            && corners.all(|&own| b.polygon.iter().any(|other| same(own, other)))
    };
    let of = |a: &Piece| pieces.iter().position(|b| becomes(a, b));
    pieces.iter().map(of).collect()
}

/// Cuts the pieces of one cube at all their corners; only its half from the middle on, if
/// `is_half`.
fn strips(pieces: &[Piece], is_half: bool) -> Vec<Strip> {
    let corners = pieces.iter().flat_map(|piece| &piece.polygon);
    let mut cuts: Vec<f64> = corners.map(|corner| corner[1]).collect();
    if is_half {
        cuts.push(0.0);
        cuts.retain(|&cut| cut >= 0.0);
    }
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|a, b| *a - *b < SAME_CORNER);
    let strip = |cut: &[f64]| {
        let middle = 0.5 * (cut[0] + cut[1]);
        let mut chords = Vec::new();
        for (piece, Piece { polygon, .. }) in pieces.iter().enumerate() {
            let mut sides: Vec<EndValues> = Vec::new();
            for (k, p) in polygon.iter().enumerate() {
                let q = polygon[(k + 1) % polygon.len()];
                if (p[1] < middle) != (q[1] < middle) {
                    let slope = (q[0] - p[0]) / (q[1] - p[1]);
                    sides.push([0, 1].map(|end| p[0] + slope * (cut[end] - p[1])));
                }
            }
            sides.sort_by(|a, b| (a[0] + a[1]).total_cmp(&(b[0] + b[1])));
            // A line that enters a polygon also leaves it, so the sides come in pairs.
            let pairs = sides.chunks_exact(2);
            chords.extend(pairs.map(|pair| Chord {
                low: pair[0],
                high: pair[1],
                piece,
            }));
        }
        Strip {
            width: cut[1] - cut[0],
            chords,
        }
    };
    cuts.windows(2).map(strip).collect()
}

/// Returns the mean over a strip of the integral of exp(-i wave m) over the overlap of two chords,
/// `None` if they do not overlap; of its real part if `is_even`, because the sines cancel over the
/// pairs then.
///
/// The overlap goes from where both chords have begun to where one ends. The chord `ahead` is moved
/// by +lag/2, the other by -lag/2. The derivatives by lag and by wave follow.
pub(crate) fn common(
    ahead: &Chord,
    behind: &Chord,
    [lag, wave]: [f64; 2],
    is_even: bool,
) -> Option<[Complex64; 3]> {
    let moved = |side: EndValues, by: f64| side.map(|end| end + by * lag);
    // Beginnings and ends of the chords, each with its motion by lag.
    let lows = [
        (moved(ahead.low, 0.5), 0.5),
        (moved(behind.low, -0.5), -0.5),
    ];
    let highs = [
        (moved(ahead.high, 0.5), 0.5),
        (moved(behind.high, -0.5), -0.5),
    ];
    // Most pieces of a cube lie beside each other at most lags.
    let apart = |low: &EndValues, high: &EndValues| low[0] >= high[0] && low[1] >= high[1];
    if apart(&lows[0].0, &highs[1].0) || apart(&lows[1].0, &highs[0].0) {
        return None;
    }
    // Between the crossings of these lines, one beginning and one end bound the overlap throughout.
    let mut cuts = [0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0];
    let lines = [lows[0].0, lows[1].0, highs[0].0, highs[1].0];
    let mut count = 1;
    for (i, a) in lines.iter().enumerate() {
        for b in &lines[i + 1..] {
            let (start, end) = (a[0] - b[0], a[1] - b[1]);
            if start * end < 0.0 {
                cuts[count] = start / (start - end);
                count += 1;
            }
        }
    }
    cuts[..count].sort_by(f64::total_cmp);
    let at = |line: &EndValues, place: f64| line[0] + (line[1] - line[0]) * place;
    let mut sum = [Complex64::ZERO; 3];
    for part in cuts[..=count].windows(2) {
        let (width, middle) = (part[1] - part[0], 0.5 * (part[0] + part[1]));
        let by_place = |a: &&(EndValues, f64), b: &&(EndValues, f64)| {
            at(&a.0, middle).total_cmp(&at(&b.0, middle))
        };
        let (Some(low), Some(high)) = (lows.iter().max_by(by_place), highs.iter().min_by(by_place))
        else {
            continue;
        };
        if at(&high.0, middle) <= at(&low.0, middle) {
            continue;
        }
        for (line, motion, sign) in [(high.0, high.1, width), (low.0, low.1, -width)] {
            let centre = at(&line, middle);
            let half = 0.5 * (line[1] - line[0]) * width;
            let means = Means::new(wave, centre, half);
            let even = means.even();
            let odd = if is_even { [0.0; 3] } else { means.odd() };
            let motions = [1.0, motion, 1.0];
            for k in 0..3 {
                sum[k] += Complex64::new(even[k], -odd[k]) * (sign * motions[k]);
            }
        }
    }
    Some(sum)
}

/// Means over x from centre - half to centre + half, at a wave.
struct Means {
    wave: f64,
    centre: f64,
    half: f64,
    sin: f64,
    cos: f64,
    /// sinc(wave half) and its derivative.
    across: [f64; 2],
}

impl Means {
    fn new(wave: f64, centre: f64, half: f64) -> Means {
        let (sin, cos) = (wave * centre).sin_cos();
        let (across, slope) = sinc(wave * half);
        Means {
            wave,
            centre,
            half,
            sin,
            cos,
            across: [across, slope],
        }
    }

    /// Returns the means of sin(wave x)/wave, of its derivative by x, and of that by wave.
    fn even(&self) -> [f64; 3] {
        let &Means {
            centre, half, cos, ..
        } = self;
        let [across, across_slope] = self.across;
        let place = self.wave * centre;
        let (along, along_slope) = if place.abs() < 0.5 {
            sinc(place)
        } else {
            let along = self.sin / place;
            (along, (cos - along) / place)
        };
        [
            centre * along * across,
            cos * across,
            centre * (centre * along_slope * across + along * half * across_slope),
        ]
    }

    /// Returns the means of (1 - cos(wave x))/wave, of its derivative by x, and of that by wave.
    ///
    /// The closed form cancels near wave = 0: two terms of the series then leave out (wave x)^4 /
    /// 360.
    fn odd(&self) -> [f64; 3] {
        const SERIES: f64 = 1e-3;
        let &Means {
            wave,
            centre,
            half,
            sin,
            cos,
            across: [across, across_slope],
        } = self;
        let by_place = sin * across;
        let (c2, h2) = (centre * centre, half * half);
        if wave.abs() * centre.abs().max(half.abs()) < SERIES {
            let second = c2 + h2 / 3.0;
            let fourth = c2 * c2 + 2.0 * c2 * h2 + h2 * h2 / 5.0;
            let square = wave * wave;
            return [
                wave * (second / 2.0 - square * fourth / 24.0),
                by_place,
                second / 2.0 - square * fourth / 8.0,
            ];
        }
        let value = (1.0 - cos * across) / wave;
        let by_wave = (centre * sin * across - cos * half * across_slope - value) / wave;
        [value, by_place, by_wave]
    }
}
