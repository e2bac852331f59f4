//! The fitted lobe beside the diffraction of the cubes' aperture.

use serde::{Deserialize, Serialize};

use crate::estimate::search::compared;
use crate::estimate::{Estimate, Scene};
use crate::result::report::ResultFile;

/// Width of the fitted lobe over that of the diffraction by the aperture of the fitted cubes, as the
/// ratio of the frequencies at which their OTFs are 1/2.
///
/// About 1: diffraction explains the lobe. Above it something else blurs too; below it c is too small
/// for this lobe.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WidthResult {
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Ratio of the widths.
    pub lobe_to_diffraction: f64,
}

impl ResultFile {
    /// Says in a sentence how the lobe compares with the diffraction of the cubes; nothing where this
    /// is not known.
    pub fn diffraction_in_words(&self) -> Option<String> {
        let ratios = self.diffraction.iter().map(|own| own.lobe_to_diffraction);
        let [least, most] = ratios.fold([f64::INFINITY, 0.0_f64], |[least, most], own| {
            [least.min(own), most.max(own)]
        });
        let about = match [format!("{least:.2}"), format!("{most:.2}")] {
            _ if self.diffraction.is_empty() => return None,
            [least, most] if least == most => least,
            [least, most] => format!("{least} to {most}"),
        };
        let what = match (least, most) {
            (1.1.., _) => "something else blurs too, such as errors of the cubes or a rough front",
            (_, ..0.9) => "c is too small for so narrow a lobe, or the wavelength too long",
            (0.9.., ..1.1) => "diffraction explains it",
            _ => "diffraction alone explains no such lobe",
        };
        Some(format!(
            "the lobe is {about} times as wide as the diffraction of the cubes' aperture: {what}"
        ))
    }
}

/// Compares the lobe with the diffraction of the aperture, at each incidence at which a photograph
/// was taken; nothing without a lobe, c and wavelengths.
pub(crate) fn widths(scene: &Scene, best: &Estimate) -> Vec<WidthResult> {
    let kernel = best.choice.kernel;
    let (Some(c_mm), true) = (
        best.c_mm.as_ref(),
        kernel.has_lobe() && !kernel.is_baseline(),
    ) else {
        return Vec::new();
    };
    let width = |&incidence_deg: &f64| {
        let shot = (scene.shots.iter()).find(|shot| shot.incidence_deg == incidence_deg)?;
        let line = shot.direction.wave.as_ref().ok()?;
        let model = compared::model(shot, best.choice);
        let spread = best
            .spread
            .get(shot.place.group)
            .or(best.spread.first())?
            .value;
        let lobe = |f: f64| model.lobe_otf(spread, f)[0];
        let aperture = |f: f64| line.diffraction(c_mm.value, shot.r_mm, f);
        Some(WidthResult {
            incidence_deg,
            lobe_to_diffraction: half(&aperture)? / half(&lobe)?,
        })
    };
    scene.groups.iter().filter_map(width).collect()
}

/// Returns the frequency at which a falling curve is 1/2, 1/mm, to a millionth of itself.
fn half(curve: &dyn Fn(f64) -> f64) -> Option<f64> {
    let mut high = 1e-4;
    while curve(high) > 0.5 {
        high *= 2.0;
        if high > 1e5 {
            return None;
        }
    }
    let mut low = 0.5 * high;
    while high - low > 1e-6 * high {
        let middle = f64::midpoint(low, high);
        if curve(middle) > 0.5 {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(high)
}
