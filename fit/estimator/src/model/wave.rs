//! The waves of a table's direction for the spectrum of the source, as the kernel `wave` needs
//! them.

use tables::options::Back;
use tables::{Direction, Exact, NoWaves, Table, WaveLine};

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

/// Largest relative error of MTF for each deviation x c / wavelength of the cubes, which
/// [`WaveLine`] leaves out.
const BY_DEVIATION: f64 = 0.45;

/// Error of MTF from which on a remark names it.
const SEEN: f64 = 0.01;

/// Number of wavelengths below which a cube is too small for waves of small angles.
///
/// The light of an aperture of 10 wavelengths leaves within some 0.1 rad.
const SMALL: f64 = 10.0;

/// Returns whether the cubes of a table reflect totally, so that each facet order turns the
/// polarisation of light in its own way. Scalar waves know nothing of it.
pub(crate) fn polarises(table: &Table) -> bool {
    table.provenance.back.is(Back::Tir)
}

/// Returns remarks on the waves of cubes of the size `c_mm`, one sentence each.
pub fn remarks(table: &Table, spectrum: &Spectrum, c_mm: f64) -> Vec<String> {
    let mut remarks = Vec::new();
    if polarises(table) {
        remarks.push(
            "the cubes of the table reflect totally (back tir), and the kernel wave is scalar: it \
            leaves out that total reflection turns the polarisation, so its MTF is far too high \
            (MTF50 by a factor of two); take a lobe (kernel angular), or a metal back"
                .into(),
        );
    }
    let of_lines = || {
        spectrum
            .lines()
            .iter()
            .map(|line| 1e-6 * line.wavelength_nm)
    };
    let shortest_mm = of_lines().fold(f64::INFINITY, f64::min);
    let longest_mm = of_lines().fold(0.0, f64::max);
    if c_mm < SMALL * longest_mm {
        remarks.push(format!(
            "c is {c_mm} mm, {:.2} of the longest wavelength: the kernel wave holds for cubes of \
            more than {SMALL} wavelengths; c is in mm",
            c_mm / longest_mm
        ));
    }
    let deviation = table
        .exact
        .as_ref()
        .map_or(0.0, Exact::largest_deviation_rad);
    let error = BY_DEVIATION * deviation * c_mm / shortest_mm;
    if error > SEEN {
        remarks.push(format!(
            "the cubes of the table send light up to {:.3} mrad off the way back, and the kernel \
            wave takes them as exact: its MTF errs by up to {:.2}; bake exact cubes, or take the \
            kernel angular",
            1e3 * deviation,
            error.min(1.0)
        ));
    }
    remarks
}
