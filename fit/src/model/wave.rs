//! The waves of a table's direction for the spectrum of the source, as the kernel `wave` needs
//! them.

use tables::{Direction, NoWaves, WaveLine};

use crate::names::Spectrum;

/// Reason why a direction has no waves.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// No wavelength given.
    #[error(
        "the wave kernel needs the source's wavelength; give --wavelength-nm, or wavelength_nm in \
        [setup]"
    )]
    NoWavelength,
    /// Table without the polygons from which waves are computed.
    #[error(transparent)]
    Table(#[from] NoWaves),
}

/// Computes the waves of a direction along the unit edge normal `normal` (tangential, sagittal).
/// [`WaveLine::new`] explains the other arguments.
///
/// # Errors
/// Returns [`Fault::NoWavelength`] if `spectrum` is `None`, and [`Fault::Table`] if the table holds
/// no polygons of ideal corner cubes for the direction.
pub(crate) fn line(
    direction: &Direction,
    incidence_rad: f64,
    normal: [f64; 2],
    spectrum: Option<&Spectrum>,
) -> Result<WaveLine, Fault> {
    let lines = spectrum.ok_or(Fault::NoWavelength)?.lines().iter();
    let lines: Vec<(f64, f64)> = lines
        .map(|line| (line.wavelength_nm, line.weight))
        .collect();
    Ok(WaveLine::new(direction, incidence_rad, normal, &lines)?)
}
