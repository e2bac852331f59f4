//! The `wave` kernel of a photograph: the waves of a table's direction, for the spectrum of the
//! source.

use tables::{Direction, NoWaves, WaveLine};

use crate::names::Spectrum;

/// Why a direction has no waves.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// No wavelength.
    #[error(
        "the wave kernel needs the source's wavelength; give --wavelength-nm, or wavelength_nm in \
        [setup]"
    )]
    NoWavelength,
    /// The table does not hold what they are made of.
    #[error(transparent)]
    Table(#[from] NoWaves),
}

/// The waves of a direction along the unit edge normal `normal`; otherwise as [`WaveLine::new`].
///
/// # Errors
/// [`Fault`] where no wavelength is named, or the table holds no polygons of corner cubes for the
/// direction.
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
