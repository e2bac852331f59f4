//! Wave optics of the effective aperture, the `wave` kernel.
//!
//! It computes ray shift and diffraction together, and c is its only free parameter. It goes beyond
//! the paper.
//!
//! A corner cube turns the light on its effective aperture K by half a turn about the foot q of its
//! apex. K' is K times c, with the tangential axis times the cosine of the incidence. Seen from the
//! image at the distance R, K' carries the phase 2 pi |y|^2/(lambda R) about q. Each facet order of
//! the cube returns the light of its piece of K' with a Jones matrix J of its own: total reflection
//! and metals turn the polarisation. The OTF is the autocorrelation of the pupil at the lag
//! s = lambda R nu. For unpolarised light, with P the power, it is
//!
//! `OTF(nu) = 1/P sum_ab tr(J_a J_b^H)/2 int over (K'_a and K'_b - s) of exp(-4 pi i nu.(y + s/2)) dy`.
//!
//! It is real, because the way back along a facet order is the order turned round. Behind polarisers
//! ([`crate::Passage`]) it is complex where the two ways differ. With ideal mirrors all J are alike.
//! Then this is the scalar OTF, the integral of cos(4 pi nu.(y + s/2)) over the overlap of K' and
//! K' - s. For lambda -> 0 it is the OTF of the
//! ray shift; for a small K' it is the autocorrelation of the aperture. Against a vector calculation
//! the scalar OTF of aluminium is right to 0.003, and that of totally reflecting prisms is wrong by
//! half (Murphy and Goodrow, Applied Optics 52, 2013, measured their Strehl ratio of 0.264).
//!
//! Along an edge normal the integrand depends on one coordinate. So K is cut across the normal into
//! strips between its corners. The ends of the chords in a strip are straight lines, and the
//! integral over such chords is a sinc. No polygon is clipped, and nothing cancels at nu = 0.
//!
//! Light of a facet order that deviates by the angle d from the way back has the phase 2 pi d.y /
//! lambda too. It depends on both coordinates. Then the overlap of each pair of pieces is clipped,
//! and its integral is the Fourier transform of a polygon, which is exact as well.
//!
//! Different cubes add incoherently, weighted by what they return. The pieces of one cube add
//! coherently. A spectrum is the weighted sum over its lines.

use std::f64::consts::PI;

use num_complex::Complex64;

use crate::lookup::direction::Direction;
use crate::otf::polygon_wave::{PolygonWave, sinc};
use crate::table::exact::Path;
use crate::table::polygon::{area, clip};

/// Deviation of light, rad, up to which it is left out, with an error of 0.45 deviation x c/lambda
/// in the OTF. A mesh in single precision deviates by less.
const STRAIGHT: f64 = 1e-7;

/// Greatest difference of a path's map from a point reflection, and greatest tangent of the
/// deviation of its light. It is convention: larger errors send the light so far aside that no image
/// is left.
const ASTRAY: f64 = 0.02;

/// Distance of the fixed points of two paths of one cube, edge lengths, without deviation: that of
/// rounded meshes.
///
/// A path leaves the apex of its cube where it is. So its fixed point is half the deviation times
/// the depth of the cube from the foot of the apex, whose depth seen obliquely is a few edge
/// lengths at most.
const SAME_FOOT: f64 = 1e-3;

/// Step of ln c in the differences that give the derivative by ln c of tilted pieces. The third
/// derivative is some 10^2, so its error is 1e-7.
const STEP: f64 = 1e-4;

/// Share of the smaller one of two polygons from which on they overlap.
///
/// The pieces of a cube do not overlap, but interpolation moves their sides.
const OVERLAP: f64 = 0.1;

/// Greatest number of corners of a direction: ten times those of cubes behind a front that traps
/// light.
const MOST_CORNERS: usize = 1024;

/// Greatest number of pairs of chords in all strips. A hundred corners have some ten chords in a
/// strip, 10^4 pairs; the pairs that are allowed take some 10 ms at each frequency.
const MOST_PAIRS: usize = 1 << 18;

/// Smallest distance of two corners that bound a strip, edge lengths.
const SAME_CORNER: f64 = 1e-12;

/// Reason why a direction has no waves.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NoWaves {
    /// Table that holds only a histogram.
    #[error(
        "the wave kernel needs the polygons of the aperture, which the table does not hold at \
        incidence {incidence_deg} deg; bake this direction with `bake trace --method exact`"
    )]
    NoPolygons {
        /// Incidence, degrees.
        incidence_deg: f64,
    },
    /// Apertures of so many pieces that their waves would take without end.
    #[error(
        "the wave kernel takes apertures of at most {MOST_CORNERS} corners, cut into few pieces, \
        and the table has {corners} at incidence {incidence_deg} deg; bake the cell with fewer \
        facets, or take the kernel angular"
    )]
    ManyPieces {
        /// Incidence, degrees.
        incidence_deg: f64,
        /// Number of corners of all polygons.
        corners: usize,
    },
    /// Facets that are no corner cubes, or whose errors are large.
    #[error(
        "the wave kernel needs corner cubes, but the facets of the table send light more than \
        {limit} rad off the way back at incidence {incidence_deg} deg; bake smaller dihedral \
        errors, or take the kernel angular, for a sheet given by hand with --a-times-r in place of \
        the wavelength (about 2.8 c / wavelength for triangular cubes: 764 for 0.15 mm and 550 nm)",
        limit = ASTRAY
    )]
    NoPointReflection {
        /// Incidence, degrees.
        incidence_deg: f64,
    },
}

/// Straight line over a strip: its values at both ends.
type EndValues = [f64; 2];

/// Part of a piece along the normal within a strip, measured from the cube's q.
#[derive(Debug, Clone)]
struct Chord {
    low: EndValues,
    high: EndValues,
    /// Number of the piece.
    piece: usize,
}

/// Part of an aperture between two neighbouring corners, across the edge normal; edge lengths.
#[derive(Debug, Clone)]
struct Strip {
    /// Width of the strip, across the normal.
    width: f64,
    chords: Vec<Chord>,
}

/// Piece of an aperture whose light is tilted; edge lengths, (along the normal, across it).
#[derive(Debug, Clone)]
struct Piece {
    polygon: Vec<[f64; 2]>,
    /// Tangents of the deviation.
    tilt: [f64; 2],
    /// Product of the tilt with the place from which its phase counts.
    origin: f64,
}

/// Aperture of a cube.
#[derive(Debug, Clone)]
enum Aperture {
    Straight(Vec<Strip>),
    Tilted(Vec<Piece>),
}

/// Aperture of a cube, and the products of the amplitudes of its pieces.
#[derive(Debug, Clone)]
struct Cube {
    aperture: Aperture,
    /// tr(J_a J_b^H)/2 in row-major order.
    products: Vec<Complex64>,
    pieces: usize,
    /// For each piece, the one that it becomes by half a turn, if there are such. Then `aperture` is
    /// the half from the middle on.
    turned: Option<Vec<usize>>,
    /// Whether all pieces have one amplitude, or amplitudes that do not change if the aperture is
    /// turned by half a turn: then only cosines count.
    is_even: bool,
}

/// Wave OTF of one direction along one line, for a spectrum.
#[derive(Debug, Clone)]
pub struct WaveLine {
    cubes: Vec<Cube>,
    /// Sum of power x area over all cubes, square edge lengths.
    power: f64,
    /// Longest lag at which any cube overlaps itself, edge lengths.
    reach: f64,
    /// Wavelengths, mm, and their shares, which sum to 1.
    lines: Vec<(f64, f64)>,
}

impl WaveLine {
    /// Prepares the line of an edge normal for a direction that returns light (eta > 0).
    ///
    /// `normal` is the unit edge normal in the mid-air image, (tangential, sagittal).
    /// `incidence_rad` is the incidence outside, which foreshortens the aperture. `spectrum` is the
    /// source's lines: each a wavelength, nm, and its weight. The weights are normalised here.
    ///
    /// # Errors
    /// Returns [`NoWaves`] if the direction has no polygons, if they are not those of corner cubes,
    /// or if there are too many of them.
    pub fn new(
        direction: &Direction,
        incidence_rad: f64,
        normal: [f64; 2],
        spectrum: &[(f64, f64)],
    ) -> Result<WaveLine, NoWaves> {
        let incidence_deg = direction.incidence_deg;
        let paths = direction
            .paths
            .as_deref()
            .ok_or(NoWaves::NoPolygons { incidence_deg })?;
        let corners = paths.iter().map(|path| path.polygon.len()).sum();
        let many = NoWaves::ManyPieces {
            incidence_deg,
            corners,
        };
        if corners > MOST_CORNERS {
            return Err(many);
        }
        let returns = |path: &Path| {
            let [[uu, uv], [vu, vv]] = path.matrix;
            let off = [uu + 2.0, uv, vu, vv + 2.0, astray(path)];
            off.iter().all(|off| off.abs() <= ASTRAY)
        };
        if !paths.iter().all(returns) {
            return Err(NoWaves::NoPointReflection { incidence_deg });
        }
        let cubes = cubes(paths);
        let cubes = cubes
            .iter()
            .map(|(foot, pieces)| Cube::new(pieces, *foot, incidence_rad.cos(), normal));
        let cubes: Vec<Cube> = cubes.collect();
        if cubes.iter().map(Cube::pairs).sum::<usize>() > MOST_PAIRS {
            return Err(many);
        }
        let total: f64 = spectrum.iter().map(|(_, weight)| weight).sum();
        let lines = spectrum.iter();
        let mut line = WaveLine {
            power: 1.0,
            reach: cubes.iter().map(Cube::extent).fold(0.0, f64::max),
            lines: lines
                .map(|(wavelength_nm, weight)| (wavelength_nm * 1e-6, weight / total))
                .collect(),
            cubes,
        };
        line.power = line.overlap([0.0; 3])[0].re;
        Ok(line)
    }

    /// Returns the OTF and its derivative by ln c at a frequency >= 0 in 1/mm.
    ///
    /// `c_mm` is the corner size and `r_mm` the floating distance, both in mm. The OTF is 1 at 0. It
    /// is that of light at x in the image, exp(-2 pi i frequency x). The only error is rounding, about 1e-14, but for the derivative of cubes with dihedral errors, which is a
    /// difference and errs by 1e-7. A cube of one piece and a line of the spectrum take 1 us, one of
    /// six orders some 13 us.
    pub fn otf(&self, c_mm: f64, r_mm: f64, frequency: f64) -> (Complex64, Complex64) {
        let (mut value, mut slope) = (Complex64::ZERO, Complex64::ZERO);
        for &(wavelength_mm, share) in &self.lines {
            let at = |c_mm: f64| {
                let lag = wavelength_mm * r_mm * frequency / c_mm;
                [
                    lag,
                    4.0 * PI * c_mm * frequency,
                    2.0 * PI * c_mm / wavelength_mm,
                ]
            };
            let here @ [lag, wave, _] = at(c_mm);
            if lag >= self.reach {
                continue;
            }
            let [overlap, by_lag, by_wave] = self.overlap(here);
            value += overlap * share;
            slope += share * (by_wave * wave - by_lag * lag);
            if self.is_tilted() {
                let [less, more] = [-STEP, STEP].map(|step| self.tilted(at(c_mm * step.exp())));
                slope += share * (more - less) / (2.0 * STEP);
            }
        }
        (value, slope)
    }

    /// Returns the OTF of the diffraction alone, as if the cubes did not shift light: the
    /// autocorrelation of the aperture. Arguments are those of [`WaveLine::otf`].
    pub fn diffraction(&self, c_mm: f64, r_mm: f64, frequency: f64) -> f64 {
        let of_line = |&(wavelength_mm, share): &(f64, f64)| {
            let lag = wavelength_mm * r_mm * frequency / c_mm;
            let turn = 2.0 * PI * c_mm / wavelength_mm;
            match lag < self.reach {
                true => share * self.overlap([lag, 0.0, turn])[0].norm(),
                false => 0.0,
            }
        };
        self.lines.iter().map(of_line).sum()
    }

    /// Returns -dOTF/d|f| at zero frequency, mm: the kink that gives an edge its 1/x tails.
    ///
    /// It falls as 1/c.
    pub fn kink(&self, c_mm: f64, r_mm: f64) -> f64 {
        // The slope is taken next to lag 0, because it jumps at lag 0 itself where pieces of one
        // cube touch.
        const NEAR: f64 = 1e-9;
        const APART: f64 = 1e-7;
        let of_line = |&(wavelength_mm, share): &(f64, f64)| {
            let turn = 2.0 * PI * c_mm / wavelength_mm;
            let straight = self.overlap([NEAR * self.reach, 0.0, turn])[1].re;
            let tilted = if self.is_tilted() {
                let step = APART * self.reach;
                (self.tilted([step, 0.0, turn]) - self.tilted([0.0, 0.0, turn])).re / step
            } else {
                0.0
            };
            -share * (straight + tilted) * wavelength_mm
        };
        self.lines.iter().map(of_line).sum::<f64>() * r_mm / c_mm
    }

    /// Returns the frequency beyond which the OTF of a direction is 0 along every line, 1/mm.
    ///
    /// `c_mm` is the corner size, `r_mm` the floating distance and `wavelength_mm` the shortest
    /// wavelength, all in mm. The longest lag is the distance of the two corners of a cube that are
    /// farthest apart, seen from the image. It is 0 if the direction has no polygons.
    pub fn highest_frequency(
        direction: &Direction,
        incidence_rad: f64,
        [c_mm, r_mm, wavelength_mm]: [f64; 3],
    ) -> f64 {
        let paths = direction.paths.as_deref().unwrap_or_default();
        let mut longest = 0.0_f64;
        for (_, pieces) in cubes(paths) {
            let corners = || pieces.iter().flat_map(|path| &path.polygon);
            for a in corners() {
                for b in corners() {
                    let along = (a[0] - b[0]) * incidence_rad.cos();
                    longest = longest.max(along.hypot(a[1] - b[1]));
                }
            }
        }
        longest * c_mm / (wavelength_mm * r_mm)
    }

    fn is_tilted(&self) -> bool {
        let tilted = |cube: &Cube| matches!(cube.aperture, Aperture::Tilted(_));
        self.cubes.iter().any(tilted)
    }

    /// Returns the integral of the pupil's products over the overlap of the apertures at +-lag/2
    /// along the normal, over their power.
    ///
    /// `at` is the lag, 4 pi c nu and 2 pi c / lambda; lengths are edge lengths. The derivatives by
    /// lag and by 4 pi c nu follow, without the part of tilted pieces.
    fn overlap(&self, at @ [lag, wave, _]: [f64; 3]) -> [Complex64; 3] {
        let mut sum = [Complex64::ZERO; 3];
        for cube in &self.cubes {
            let Aperture::Straight(strips) = &cube.aperture else {
                continue;
            };
            for strip in strips {
                for ahead in &strip.chords {
                    for behind in &strip.chords {
                        let Some(part) = common(ahead, behind, [lag, wave], cube.is_even) else {
                            continue;
                        };
                        let weight = strip.width / self.power;
                        let product = weight * cube.product(ahead.piece, behind.piece);
                        // Half a turn exchanges the chords and changes the sign of places.
                        let turned = cube.turned.as_ref().map_or(Complex64::ZERO, |turned| {
                            weight * cube.product(turned[behind.piece], turned[ahead.piece])
                        });
                        for (sum, part) in sum.iter_mut().zip(part) {
                            *sum += part * product + part.conj() * turned;
                        }
                    }
                }
            }
        }
        sum[0] += self.tilted(at);
        sum
    }

    /// Returns the part of [`WaveLine::overlap`] of tilted pieces.
    ///
    /// At the middle m of two points of the pupil that are the lag apart, their phases differ by
    /// turn ((t_a - t_b).m - (t_a + t_b).lag/2), each counted from the fixed point of its path.
    fn tilted(&self, [lag, wave, turn]: [f64; 3]) -> Complex64 {
        let mut sum = Complex64::ZERO;
        for cube in &self.cubes {
            let Aperture::Tilted(pieces) = &cube.aperture else {
                continue;
            };
            for (i, a) in pieces.iter().enumerate() {
                for (j, b) in pieces.iter().enumerate() {
                    let both = intersection(
                        &moved(&a.polygon, 0.5 * lag),
                        &moved(&b.polygon, -0.5 * lag),
                    );
                    let apart = [0, 1].map(|k| turn * (a.tilt[k] - b.tilt[k]));
                    let Some(over) = PolygonWave::new(&both, [wave - apart[0], -apart[1]]) else {
                        continue;
                    };
                    let common =
                        -turn * (0.5 * lag * (a.tilt[0] + b.tilt[0]) + a.origin - b.origin);
                    let light = cube.product(i, j) * Complex64::cis(common) * over.at(1.0).0;
                    sum += light * (area(&both) / self.power);
                }
            }
        }
        sum
    }
}

/// Returns the tangent of the angle by which light leaves off the way back.
fn astray(path: &Path) -> f64 {
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
    fn new(paths: &[&Path], foot: [f64; 2], cosine: f64, normal: [f64; 2]) -> Cube {
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

    fn product(&self, a: usize, b: usize) -> Complex64 {
        self.products[a * self.pieces + b]
    }

    /// Returns the number of pairs that an evaluation takes.
    fn pairs(&self) -> usize {
        match &self.aperture {
            Aperture::Straight(strips) => {
                strips.iter().map(|strip| strip.chords.len().pow(2)).sum()
            }
            Aperture::Tilted(pieces) => pieces.len().pow(2),
        }
    }

    /// Returns the longest lag at which the cube overlaps itself, edge lengths.
    fn extent(&self) -> f64 {
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
type CubePaths<'a> = ([f64; 2], Vec<&'a Path>);

/// Sorts paths by their cubes: the paths of one cube have one fixed point, and do not overlap.
///
/// Cubes of two kinds may have one fixed point, because each is seen from its own rim.
///
/// Light along an order of facets and along the same order turned round deviates to opposite sides, so
/// the mean of the fixed points is the foot of the apex.
fn cubes(paths: &[Path]) -> Vec<CubePaths<'_>> {
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
fn intersection(a: &[[f64; 2]], b: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let sides = b.iter().zip(b.iter().cycle().skip(1));
    sides.fold(a.to_vec(), |rest, (p, q)| {
        let outside =
            |at: [f64; 2]| (q[1] - p[1]) * (at[0] - p[0]) - (q[0] - p[0]) * (at[1] - p[1]);
        clip(&rest, outside, |p, q, part| {
            [0, 1].map(|k| p[k] + part * (q[k] - p[k]))
        })
    })
}

fn moved(polygon: &[[f64; 2]], by: f64) -> Vec<[f64; 2]> {
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
fn common(
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Half width of the aperture along the normal, edge lengths.
    const HALF: f64 = 0.5;

    /// Weights of its two halves.
    const WEIGHTS: [f64; 2] = [0.9, 0.4];

    const INCIDENCE_DEG: f64 = 30.0;

    /// Source lines, (nm, weight).
    const LINES: [(f64, f64); 2] = [(450.0, 1.0), (650.0, 3.0)];

    /// Makes one cube whose aperture is a rectangle of two halves with different losses.
    fn cube() -> Direction {
        let (middle, low, high) = ([0.2, -0.1], -0.4, 0.3);
        let half = |from: f64, to: f64, weight: f64| {
            let at = |x: f64, y: f64| [middle[0] + x, middle[1] + y];
            Path {
                polygon: vec![at(from, low), at(to, low), at(to, high), at(from, high)],
                matrix: [[-2.0, 0.0], [0.0, -2.0]],
                offset: [2.0 * middle[0], 2.0 * middle[1]],
                weight,
                deviation: [0.0; 2],
                passes: 0,
                jones: None,
            }
        };
        Direction {
            incidence_deg: INCIDENCE_DEG,
            azimuth_deg: 0.0,
            retroreflected: 0.4,
            probability: ndarray::Array2::zeros((4, 4)),
            range: 2.0,
            standard_error: 0.0,
            interpolated: false,
            exits: None,
            paths: Some(vec![
                half(-HALF, 0.0, WEIGHTS[0]),
                half(0.0, HALF, WEIGHTS[1]),
            ]),
        }
    }

    /// Returns the waves of the cube along a normal.
    fn along(normal: [f64; 2]) -> WaveLine {
        let incidence_rad = INCIDENCE_DEG.to_radians();
        WaveLine::new(&cube(), incidence_rad, normal, &LINES).expect("an ideal cube")
    }

    /// Returns the waves of the cube along the tangential axis.
    fn two_halves() -> WaveLine {
        along([1.0, 0.0])
    }

    /// The rectangle, foreshortened, overlaps itself up to its diagonal, along the diagonal only.
    /// Directions of 0.1 degrees miss the diagonal by 1 - cos(0.05 deg) = 4e-7 of the lag.
    #[test]
    fn no_line_passes_a_frequency_beyond_the_highest() {
        let (c_mm, r_mm, shortest_mm) = (0.2, 150.0, 450e-6);
        let incidence_rad = INCIDENCE_DEG.to_radians();
        let end = WaveLine::highest_frequency(&cube(), incidence_rad, [c_mm, r_mm, shortest_mm]);
        let diagonal = (2.0 * HALF * incidence_rad.cos()).hypot(0.7);
        let expected = diagonal * c_mm / (shortest_mm * r_mm);
        assert!((end / expected - 1.0).abs() < 1e-14, "{end} {expected}");
        let mut longest = 0.0_f64;
        for k in 0..1800 {
            let (sin, cos) = (0.1 * f64::from(k)).to_radians().sin_cos();
            let line = along([cos, sin]);
            assert_eq!(
                line.otf(c_mm, r_mm, end * (1.0 + 1e-12)).0,
                Complex64::ZERO,
                "{k}"
            );
            longest = longest.max(line.reach);
        }
        let short = 1.0 - longest / diagonal;
        assert!((0.0..1e-6).contains(&(short + 1e-14)), "{short}");
        println!("1800 lines");
    }

    /// Paths of a cube whose coordinates are rounded are one aperture, also where the apex lies far
    /// from the origin. Cubes of two kinds with one foot are two.
    ///
    /// The maps of the halves are off by 1e-4, and the feet by half of that. So the aperture moves
    /// against the foot by 5e-5, which turns each phase by at most that times the wave.
    #[test]
    fn nearly_equal_paths_are_one_aperture_and_kinds_are_not() {
        let (exact, away) = (cube(), [30.0, -20.0]);
        let mut rounded = cube();
        for (k, path) in rounded.paths.iter_mut().flatten().enumerate() {
            let off = 1e-4 * (1.0 - 2.0 * k as f64);
            path.matrix = [[-2.0 + off, 0.5 * off], [-off, -2.0 - 0.3 * off]];
            path.polygon
                .iter_mut()
                .flatten()
                .enumerate()
                .for_each(|(i, x)| *x += away[i % 2]);
            let foot = [
                0.5 * path.offset[0] + away[0] + 0.5 * off,
                0.5 * path.offset[1] + away[1],
            ];
            path.offset = path.matrix.map(|row| -row[0] * foot[0] - row[1] * foot[1]);
        }
        // A second kind: a quarter of the size, of the same foot.
        let kinds = |both: [bool; 2]| {
            let mut kinds = cube();
            let own = kinds.paths.take().unwrap_or_default();
            let other = own.iter().map(|path| {
                let about = [0, 1].map(|i| 0.5 * path.offset[i]);
                let mut path = path.clone();
                for corner in &mut path.polygon {
                    *corner = [0, 1].map(|i| about[i] + 0.5 * (corner[i] - about[i]));
                }
                path
            });
            let all = [own.clone(), other.collect()];
            let kept = all.into_iter().zip(both).filter(|(_, kept)| *kept);
            kinds.paths = Some(kept.flat_map(|(paths, _)| paths).collect());
            kinds
        };
        let mut cases = 0;
        for normal in [[1.0, 0.0], [0.0, 1.0], [0.6, -0.8]] {
            let of = |direction: &Direction| {
                let incidence_rad = INCIDENCE_DEG.to_radians();
                WaveLine::new(direction, incidence_rad, normal, &LINES).expect("nearly exact")
            };
            let [exact, rounded] = [&exact, &rounded].map(of);
            let [large, small, both] =
                [[true, false], [false, true], [true, true]].map(|which| of(&kinds(which)));
            for frequency in [0.1, 0.4, 0.83, 1.4, 2.0] {
                let at = |line: &WaveLine| line.otf(0.2, 150.0, frequency).0.re;
                let off = at(&rounded) - at(&exact);
                let turned = 5e-5 * 4.0 * PI * 0.2 * frequency;
                assert!(off.abs() < turned, "{normal:?} {frequency}: {off:e}");
                // Four fifths of the light are of the large kind.
                let off = at(&both) - 0.8 * at(&large) - 0.2 * at(&small);
                assert!(off.abs() < 1e-13, "{normal:?} {frequency}: {off:e}");
                cases += 1;
            }
        }
        assert_eq!(cases, 15);
    }

    /// Returns the integral of cos(wave a) times the amplitudes at a - lag/2 and a + lag/2, over
    /// the power.
    ///
    /// Both ends of the pair lie in one half, or one end in each. The amplitude is the root of the
    /// weight.
    fn overlap(half: f64, lag: f64, wave: f64) -> f64 {
        let end = half - 0.5 * lag;
        let inner = (0.5 * lag).min(end);
        let part = |from: f64, to: f64| ((wave * to).sin() - (wave * from).sin()) / wave;
        let [left, right] = WEIGHTS;
        let both = left * part(-end, -inner) + right * part(inner, end);
        (both + (left * right).sqrt() * part(-inner, inner)) / ((left + right) * half)
    }

    /// Compares the OTF of two halves and two lines with its closed form. Both are sums of a few
    /// terms of order 1 / wave, and wave is above 0.2, so they round by less than 1e-14.
    ///
    /// The derivative by ln c is compared with differences. With wave up to 5.1 and a half aperture
    /// of 0.44, the third derivative by ln c is below 125, of which h^2/6 are 2.1e-9.
    #[test]
    fn two_halves_in_two_colours_meet_their_closed_form() {
        let line = two_halves();
        let half = HALF * INCIDENCE_DEG.to_radians().cos();
        let (c_mm, r_mm, h) = (0.2, 150.0, 1e-5_f64);
        let mut cases = 0;
        for frequency in [0.1, 0.4, 0.83, 1.4, 2.0] {
            let total: f64 = LINES.iter().map(|(_, weight)| weight).sum();
            let of = |&(nm, weight): &(f64, f64)| {
                let lag = nm * 1e-6 * r_mm * frequency / c_mm;
                let wave = 4.0 * PI * c_mm * frequency;
                if lag >= 2.0 * half {
                    0.0
                } else {
                    weight / total * overlap(half, lag, wave)
                }
            };
            let expected: f64 = LINES.iter().map(of).sum();
            let (value, by_ln_c) = line.otf(c_mm, r_mm, frequency);
            let (value, by_ln_c) = (value.re, by_ln_c.re);
            assert!(
                (value - expected).abs() < 1e-13,
                "{frequency}: {value} {expected}"
            );
            let at = |by: f64| line.otf(c_mm * by.exp(), r_mm, frequency).0.re;
            let difference = (at(h) - at(-h)) / (2.0 * h);
            assert!(
                (by_ln_c - difference).abs() < 3e-9,
                "{frequency}: {by_ln_c} {difference}"
            );
            cases += 1;
        }
        assert_eq!(cases, 5);
    }

    /// Compares the kink with that of the closed form: the lag shortens each half by itself and
    /// adds itself where its ends lie in different halves. The code takes the slope at a lag of
    /// 1e-9 of the aperture, where it is the same.
    #[test]
    fn the_kink_of_two_halves_is_that_of_the_mean_wavelength() {
        let [left, right] = WEIGHTS;
        let half = HALF * INCIDENCE_DEG.to_radians().cos();
        let mean_mm = (450.0 + 3.0 * 650.0) / 4.0 * 1e-6;
        let fall = (left + right - (left * right).sqrt()) / ((left + right) * half);
        let expected = fall * mean_mm * 150.0 / 0.2;
        let kink = two_halves().kink(0.2, 150.0);
        assert!((kink / expected - 1.0).abs() < 1e-13, "{kink} {expected}");
    }
}
