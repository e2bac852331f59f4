//! The waves of a table's direction for the spectrum of the source, as the kernel `wave` needs
//! them.

use tables::options::Back;
use tables::{Direction, NoWaves, Table, WaveLine};

use edges::names::Spectrum;

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
pub fn line(
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

/// Number of wavelengths below which a cube is too small for waves of small angles.
///
/// The light of an aperture of 10 wavelengths leaves within some 0.1 rad.
const SMALL: f64 = 10.0;

/// Returns whether each facet order of a table's cubes turns the polarisation of light in its own
/// way, and the table does not hold how: one that an older `bake` wrote.
pub(crate) fn lacks_polarisation(table: &Table) -> bool {
    let paths = table
        .exact
        .iter()
        .flat_map(|exact| exact.paths.iter().flatten());
    table.provenance.back.is(Back::Tir) && paths.into_iter().any(|path| path.jones.is_none())
}

/// Returns remarks on the waves of cubes of the size `c_mm`, one sentence each.
pub fn remarks(table: &Table, spectrum: &Spectrum, c_mm: f64) -> Vec<String> {
    let mut remarks = Vec::new();
    if lacks_polarisation(table) {
        remarks.push(
            "the cubes of the table reflect totally (back tir), and it does not hold how they turn \
            the polarisation: without this the MTF of the kernel wave is far too high (MTF50 by a \
            factor of two); bake the table again with this version, or take a lobe (kernel angular)"
                .into(),
        );
    }
    let of_lines = || {
        spectrum
            .lines()
            .iter()
            .map(|line| 1e-6 * line.wavelength_nm)
    };
    let longest_mm = of_lines().fold(0.0, f64::max);
    if c_mm < SMALL * longest_mm {
        remarks.push(format!(
            "c is {c_mm} mm, {:.2} of the longest wavelength: the kernel wave holds for cubes of \
            more than {SMALL} wavelengths; c is in mm",
            c_mm / longest_mm
        ));
    }
    remarks
}
