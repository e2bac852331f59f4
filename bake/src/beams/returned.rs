//! What an exact cell returns of the light of one direction: eta, and the OTFs of its waves.

use crate::beams::exact::Share;
use crate::cell::ExactCell;
use crate::optics::Rules;
use ndarray::Array2;
use tables::{Direction, WaveLine};

/// Edge normals of the two OTFs in the mid-air image: (tangential, sagittal).
const NORMALS: [[f64; 2]; 2] = [[1.0, 0.0], [0.0, 1.0]];

/// Light of one direction that a cell returns.
pub(crate) struct Returned {
    /// Retroreflected share of the light.
    pub eta: f64,
    /// Waves along the tangential and the sagittal axis of the image; `None` if nothing returns, or
    /// if the facets are no corner cubes.
    pub lines: [Option<WaveLine>; 2],
    /// Largest deviation from the way back, rad.
    pub deviation: f64,
    /// Highest frequency of the OTF for an edge length and a distance of 1 mm, 1/mm.
    highest: f64,
}

impl Returned {
    /// Follows the light of one direction, degrees in the air, through a cell.
    pub(crate) fn new(
        cell: &ExactCell,
        rules: &Rules,
        [incidence_deg, azimuth_deg]: [f64; 2],
        wavelength_nm: f64,
    ) -> Returned {
        let Share {
            paths,
            retroreflected,
            ..
        } = cell.direction(incidence_deg, azimuth_deg, 1, 2.0, rules);
        let deviation = paths.iter().map(|p| p.deviation[0].hypot(p.deviation[1]));
        let deviation = deviation.fold(0.0, f64::max);
        let direction = Direction {
            incidence_deg,
            azimuth_deg,
            retroreflected,
            probability: Array2::zeros((1, 1)),
            range: 2.0,
            standard_error: 0.0,
            interpolated: false,
            paths: Some(paths),
            exits: None,
        };
        let incidence_rad = incidence_deg.to_radians();
        let spectrum = [(wavelength_nm, 1.0)];
        let line = |normal: [f64; 2]| {
            let line = || WaveLine::new(&direction, incidence_rad, normal, &spectrum).ok();
            (retroreflected > 0.0).then(line).flatten()
        };
        let lengths = [1.0, 1.0, 1e-6 * wavelength_nm];
        Returned {
            eta: retroreflected,
            lines: NORMALS.map(line),
            deviation,
            highest: WaveLine::highest_frequency(&direction, incidence_rad, lengths),
        }
    }

    /// Returns the frequency beyond which both OTFs are 0, 1/mm, for an edge length and a distance
    /// in mm.
    pub(crate) fn highest_frequency(&self, c_mm: f64, distance_mm: f64) -> f64 {
        self.highest * c_mm / distance_mm
    }
}
