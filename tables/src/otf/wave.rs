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
use crate::otf::aperture::{Aperture, Cube, astray, common, cubes, intersection, moved};
use crate::otf::polygon_wave::PolygonWave;
use crate::table::exact::Path;
use crate::table::polygon::area;

/// Greatest difference of a path's map from a point reflection, and greatest tangent of the
/// deviation of its light. It is convention: larger errors send the light so far aside that no image
/// is left.
const ASTRAY: f64 = 0.02;

/// Step of ln c in the differences that give the derivative by ln c of tilted pieces. The third
/// derivative is some 10^2, so its error is 1e-7.
const STEP: f64 = 1e-4;

/// Greatest number of corners of a direction: ten times those of cubes behind a front that traps
/// light.
const MOST_CORNERS: usize = 1024;

/// Greatest number of pairs of chords in all strips. A hundred corners have some ten chords in a
/// strip, 10^4 pairs; the pairs that are allowed take some 10 ms at each frequency.
const MOST_PAIRS: usize = 1 << 18;

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

#[cfg(test)]
mod tests;
