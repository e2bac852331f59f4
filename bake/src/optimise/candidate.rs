//! One cell of the search: its design, and how good it is.

use crate::beams::Returned;
use crate::cell::Prepared;
use crate::error::Error;
use crate::optimise::evolve::Merit;
use crate::optimise::goal::{Best, Goal, Parameter, Ranges};
use meshes::design::{Design, Shape};
use meshes::{CellOptions, Mesh};

/// Values of all parameters of a cell, in the order of [`Parameter::ALL`].
pub(crate) type Values = [f64; Parameter::ALL.len()];

/// Cell of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Candidate {
    /// Design.
    pub shape: Shape,
    /// Values of its parameters.
    pub values: Values,
}

/// How good a cell is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Quality {
    /// Weighted mean of the MTF over views, frequencies and both axes.
    pub mtf: f64,
    /// Weighted mean of eta over views, with the losses of the surface.
    pub luminance: f64,
    /// Lowest MTF of a frequency in a view.
    pub least: f64,
}

impl Quality {
    /// Quality of a cell that cannot be made.
    pub(crate) const NONE: Quality = Quality {
        mtf: 0.0,
        luminance: 0.0,
        least: f64::NEG_INFINITY,
    };

    /// Returns what the search compares.
    pub(crate) fn merit(self, goal: &Goal) -> Merit {
        Merit {
            values: match goal.best {
                Best::Mtf => vec![self.mtf],
                Best::Luminance => vec![self.luminance],
                Best::Both => vec![self.mtf, self.luminance],
            },
            lack: (goal.least_mtf - self.least).max(0.0),
        }
    }
}

impl Candidate {
    /// Returns the parameters that vary for a design, with the ends of their ranges.
    pub(crate) fn varied(shape: Shape, ranges: &Ranges) -> Vec<(usize, [f64; 2])> {
        let all = ranges.iter().copied().enumerate();
        all.filter(|&(k, [from, to])| Parameter::ALL[k].is_of(shape) && from < to)
            .collect()
    }

    /// Returns the cell at a place of the search: for each parameter that varies, a share of its
    /// range.
    pub(crate) fn at(shape: Shape, ranges: &Ranges, shares: &[f64]) -> Candidate {
        let mut values = ranges.map(|[from, _]| from);
        for ((k, [from, to]), share) in Candidate::varied(shape, ranges).into_iter().zip(shares) {
            values[k] = from + share * (to - from);
        }
        Candidate { shape, values }
    }

    /// Returns the value of a parameter.
    pub(crate) fn value(&self, parameter: Parameter) -> f64 {
        let place = Parameter::ALL.iter().position(|&own| own == parameter);
        self.values[place.unwrap_or(0)]
    }

    /// Returns the mesh of the cell, in mm.
    ///
    /// # Errors
    /// Returns [`Error::Usage`] if a value is out of the range of the design.
    pub(crate) fn mesh(&self) -> Result<Mesh, Error> {
        let ideal = Design::new(self.shape);
        let of = |parameter: Parameter, unused: f64| match parameter.is_of(self.shape) {
            true => self.value(parameter),
            false => unused,
        };
        let design = Design {
            edge_length: self.value(Parameter::EdgeLength),
            cant_rad: of(Parameter::Cant, 0.0).to_radians(),
            truncation: of(Parameter::Truncation, 0.0),
            dihedral_error_rad: [0, 1, 2].map(|k| 1e-3 * self.value(Parameter::Error(k))),
            ..ideal
        };
        design
            .mesh()
            .map_err(|fault| Error::Usage(fault.to_string()))
    }

    /// Returns the dissected cell.
    ///
    /// # Errors
    /// Returns the errors of [`Candidate::mesh`].
    pub(crate) fn prepared(&self) -> Result<Prepared, Error> {
        let name = format!("{}.obj", self.shape.name());
        let cell = meshes::normalise(&self.mesh()?, name.as_ref(), &CellOptions::default())?;
        Ok(Prepared::new(cell))
    }

    /// Follows the light of all views.
    ///
    /// # Errors
    /// Returns an [`Error`] if the cell cannot be made.
    pub(crate) fn quality(&self, goal: &Goal) -> Result<Quality, Error> {
        let prepared = self.prepared()?;
        let exact = prepared.exact();
        let exact = exact.map_err(|reason| Error::Failed(reason.to_owned()))?;
        let rules = goal.rules(self.value(Parameter::Index));
        let c_mm = self.value(Parameter::EdgeLength);
        let count = (2 * goal.frequencies.len()) as f64;
        let mut quality = Quality {
            mtf: 0.0,
            luminance: 0.0,
            least: 1.0,
        };
        for aim in &goal.aims {
            let light = Returned::new(exact, &rules, aim.direction_deg, goal.wavelength_nm);
            for &(distance, weight) in &aim.distances {
                quality.luminance += weight * light.eta;
                for line in &light.lines {
                    for &frequency in &goal.frequencies {
                        let otf = line
                            .as_ref()
                            .map(|line| line.otf(c_mm, distance, frequency));
                        let mtf = otf.map_or(0.0, |(otf, _)| otf.norm());
                        quality.mtf += weight * mtf / count;
                        quality.least = quality.least.min(mtf);
                    }
                }
            }
        }
        Ok(quality)
    }
}
