//! Polarised light: what light passes before and behind the sheet, such as polarisers, retarders and
//! the half mirror.

use num_complex::Complex64;

use crate::error::Error;
use crate::lookup::direction::Direction;
use crate::options::{Back, Losses};
use crate::table::exact::Path;
use crate::table::table::Table;

/// Jones matrix (s, p), row-major.
pub type Matrix = [[Complex64; 2]; 2];

/// What light passes before and behind the sheet.
///
/// An unpolarised field of power 1 that passes `before`, a path's Jones matrix J and `after` has the
/// Jones matrix `after J before`: so a sheet between them is a sheet with other matrices. Both are
/// in the frames of [`Jones`](crate::Jones): s along v, and p = s x the direction of travel, which
/// turns round on the way back. Light from a polariser of power 1 is sqrt 2 times its projection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passage {
    /// Matrix of the way to the sheet.
    pub before: Matrix,
    /// Matrix of the way back.
    pub after: Matrix,
}

impl Passage {
    /// Returns the Jones matrix of a path between both ways.
    ///
    /// A path without a matrix is that of ideal mirrors, which keep the field in space.
    fn through(&self, path: &Path) -> Matrix {
        let own = match path.jones {
            Some(rows) => rows.map(|row| row.map(|[re, im]| Complex64::new(re, im))),
            None => ideal(path.weight.max(0.0).sqrt()),
        };
        product(&self.after, &product(&own, &self.before))
    }

    /// Returns a direction as it is between both ways. Without paths it is one of ideal mirrors.
    pub fn seen(&self, mut direction: Direction) -> Direction {
        let share = match &mut direction.paths {
            Some(paths) => {
                let light = |paths: &[Path]| -> f64 {
                    paths.iter().map(|path| path.weight * path.area()).sum()
                };
                let unpolarised = light(paths);
                for path in &mut *paths {
                    let through = self.through(path);
                    path.weight = power(&through);
                    path.jones = Some(through.map(|row| row.map(|own| [own.re, own.im])));
                }
                match unpolarised {
                    0.0 => 0.0,
                    _ => light(paths) / unpolarised,
                }
            }
            None => power(&product(&self.after, &product(&ideal(1.0), &self.before))),
        };
        direction.retroreflected *= share;
        direction.standard_error *= share;
        direction.probability *= share;
        if let Some(exits) = &mut direction.exits {
            exits
                .probability
                .iter_mut()
                .for_each(|(_, own)| *own *= share);
        }
        direction
    }
}

/// Returns the matrix of an ideal mirror with this amplitude. The field stays in space, and p points
/// the other way on the way back.
fn ideal(amplitude: f64) -> Matrix {
    let zero = Complex64::ZERO;
    [[amplitude.into(), zero], [zero, (-amplitude).into()]]
}

/// Returns the product of two matrices.
fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let entry = |i: usize, j: usize| a[i][0] * b[0][j] + a[i][1] * b[1][j];
    [0, 1].map(|i| [0, 1].map(|j| entry(i, j)))
}

/// Returns the share of unpolarised light that a matrix passes.
fn power(matrix: &Matrix) -> f64 {
    let entries = matrix.as_flattened().iter();
    0.5 * entries.map(Complex64::norm_sqr).sum::<f64>()
}

impl Table {
    /// Returns the table as light sees it that passes something before and behind the sheet: from
    /// now on [`Table::direction`] returns what both ways and the sheet do together.
    ///
    /// Its arrays stay those of unpolarised light.
    ///
    /// # Errors
    /// Returns [`Error::Polarised`] if the table does not say how its cubes turn the polarisation.
    pub fn seen_through(mut self, passage: Passage) -> Result<Table, Error> {
        let known = |path: &Path| path.jones.is_some();
        let holds = match &self.exact {
            Some(exact) if !self.axes.is_mean() => exact.paths.iter().flatten().all(known),
            _ => false,
        };
        let provenance = &self.provenance;
        let keeps = provenance.back.is(Back::Mirror) && provenance.losses.is(Losses::None);
        if !(holds || keeps) {
            return Err(Error::Polarised);
        }
        self.passage = Some(passage);
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Between crossed polarisers ideal mirrors return nothing; a quarter-wave film at 45 degrees in
    /// front of them, which light passes twice, turns the field by 90 degrees and lets all of it
    /// through. Each product rounds by 4 x 2e-16.
    #[test]
    fn a_film_of_a_quarter_wave_opens_crossed_polarisers() {
        let (one, zero) = (Complex64::ONE, Complex64::ZERO);
        let root = Complex64::from(std::f64::consts::FRAC_1_SQRT_2);
        let i = Complex64::I;
        // Phases of +-45 degrees along and across an axis at +-45 degrees.
        let film = |sign: f64| [[root, sign * i * root], [sign * i * root, root]];
        let source = [[one * std::f64::consts::SQRT_2, zero], [zero, zero]];
        let analyser = [[zero, zero], [zero, one]];
        let of =
            |before: Matrix, after: Matrix| power(&product(&after, &product(&ideal(1.0), &before)));
        assert_eq!(of(source, analyser), 0.0);
        let open = of(
            product(&film(1.0), &source),
            product(&analyser, &film(-1.0)),
        );
        assert!((open - 1.0).abs() < 1e-14, "{open}");
    }
}
