//! Spots of a fitted sheet: the image of a point of light at any place, from a result and a table
//! of its cell.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use estimator::model::Lobe;
use num_complex::Complex64;
use tables::Direction;

use crate::images::plane::ShiftPlane;
use crate::images::spot::{Sampler, Sheet, Spot, TAIL, Viewpoint};
use edges::names::LobeShape;
use estimator::Error;
use estimator::model::Baseline;
use estimator::model::Blur;
use estimator::model::further;
use estimator::model::wave;
use estimator::predict::Fitted;
use estimator::samples::ShiftSampler;
use estimator::samples::has_samples;
use estimator::samples::normals;
use tables::WaveLine;

impl Sheet for Fitted<'_> {
    fn spot(&self, place: &Viewpoint, finest_per_mm: f64) -> Result<Box<dyn Spot + '_>, Error> {
        let direction = self
            .table
            .direction(place.incidence_deg, place.azimuth_deg)?;
        spot_of(self, direction, place, finest_per_mm, None)
    }
}

/// Wave optics along those directions of an image that were needed so far, by their normals. Spots at
/// all distances share them, if incidence and azimuth are the same.
#[derive(Default)]
pub(crate) struct Lines(Mutex<HashMap<[i64; 2], Arc<WaveLine>>>);

impl Lines {
    /// Normals that agree to this share of 1 are one: those of a lattice of frequencies, whose
    /// multiples differ by rounding.
    const SAME: f64 = 1e-9;

    /// Returns the line of a normal, which `make` makes at its first use.
    fn line(
        &self,
        normal: [f64; 2],
        make: impl FnOnce() -> Result<WaveLine, Error>,
    ) -> Result<Arc<WaveLine>, Error> {
        let key = normal.map(|part| (part / Lines::SAME).round() as i64);
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(line) = known.get(&key) {
            return Ok(Arc::clone(line));
        }
        let line = Arc::new(make()?);
        known.insert(key, Arc::clone(&line));
        Ok(line)
    }
}

/// Computes the spot at one place, whose direction is known already. Its OTF keeps the waves of
/// `lines`, if there are any, which is worth while where few directions of the image are needed.
///
/// # Errors
/// Returns the errors of [`Sheet::spot`].
pub(crate) fn spot_of<'a>(
    sheet: &Fitted<'a>,
    direction: Direction,
    place: &Viewpoint,
    finest_per_mm: f64,
    lines: Option<&Arc<Lines>>,
) -> Result<Box<dyn Spot + 'a>, Error> {
    let blur = sheet.blur(place.incidence_deg)?;
    let returns = sheet.returned(place.incidence_deg, direction.retroreflected) > 0.0;
    let energy = if returns {
        sheet.luminance(place.incidence_deg, direction.retroreflected)
    } else {
        Some(0.0)
    };
    let cosine = place.incidence_deg.to_radians().cos();
    let kernel = sheet.result.kernel;
    let direction = if kernel.shifts_rays() {
        direction.seen_from(place.r_mm, blur.c_mm, cosine)?
    } else {
        direction
    };
    let shift = (kernel.shifts_rays() && returns)
        .then(|| ShiftPlane::new(&direction, cosine, blur.c_mm, finest_per_mm));
    let shape = sheet.result.lobe.unwrap_or(LobeShape::Radial);
    let lobe = kernel
        .has_lobe()
        .then(|| (shape, blur.spread / kernel.distance_scale(place.r_mm)));
    let gain = sheet.tangential_gain(place.incidence_deg);
    let variance_mm2 = |normal| {
        let per_mrad2 = further::variance_per_mrad2(place.r_mm, normal, gain);
        blur.angular_spread_mrad2 * per_mrad2
    };
    let mut spot = FittedSpot {
        sheet: *sheet,
        place: *place,
        direction,
        blur,
        energy,
        returns,
        shift,
        lobe,
        angular_mm: [[1.0, 0.0], [0.0, 1.0]].map(|axis| variance_mm2(axis).sqrt()),
        reach_mm: 0.0,
        end_per_mm: f64::INFINITY,
        lines: lines.map(Arc::clone),
    };
    spot.reach_mm = spot.reach()?;
    if returns {
        let widest = spot.angular_mm[0].max(spot.angular_mm[1]);
        spot.reach_mm += REACH * widest;
    }
    spot.end_per_mm = spot.end();
    Ok(Box::new(spot))
}

/// Standard deviations that contain all but [`TAIL`] of a normal distribution.
const REACH: f64 = 3.0903;

/// Spot of the fitted sheet at one place.
struct FittedSpot<'a> {
    /// Result and table.
    sheet: Fitted<'a>,
    /// Incidence, azimuth and distance.
    place: Viewpoint,
    /// Direction of the table at this place.
    direction: Direction,
    /// Spread and corner size at this incidence.
    blur: Blur,
    /// Luminance of the mid-air image divided by that of the source; `None` without mu.
    energy: Option<f64>,
    /// True if the sheet returns light at this place.
    returns: bool,
    /// Ray shift; `None` for a kernel that has no separate shift.
    shift: Option<ShiftPlane>,
    /// Shape of the lobe, and its a in 1/mm; `None` for a kernel without a lobe.
    lobe: Option<(LobeShape, f64)>,
    /// Standard deviation of the offset that the angular spread causes, (tangential, sagittal) mm.
    angular_mm: [f64; 2],
    /// Distance that contains all but [`TAIL`] of the light along each axis, mm.
    reach_mm: f64,
    /// Frequency beyond which waves pass nothing, 1/mm; infinite for the other kernels.
    end_per_mm: f64,
    /// Waves that are kept; `None` if each is used once.
    lines: Option<Arc<Lines>>,
}

impl FittedSpot<'_> {
    /// Returns the wave optics along one direction of the image.
    fn wave(&self, normal: [f64; 2]) -> Result<Arc<WaveLine>, Error> {
        let incidence_rad = self.place.incidence_deg.to_radians();
        let spectrum = self.sheet.result.wavelength_nm.as_ref();
        let make = || {
            let line = wave::line(&self.direction, incidence_rad, normal, spectrum)?;
            Ok(line)
        };
        match &self.lines {
            Some(lines) => lines.line(normal, make),
            None => make().map(Arc::new),
        }
    }

    /// Returns the frequency beyond which waves pass nothing, 1/mm; infinite for the other kernels.
    fn end(&self) -> f64 {
        let result = self.sheet.result;
        match &result.wavelength_nm {
            Some(spectrum) if result.kernel.has_waves() => {
                let lines = spectrum.lines().iter().map(|line| line.wavelength_nm);
                let shortest_mm = lines.fold(f64::INFINITY, f64::min) * 1e-6;
                WaveLine::highest_frequency(
                    &self.direction,
                    self.place.incidence_deg.to_radians(),
                    [self.blur.c_mm, self.place.r_mm, shortest_mm],
                )
            }
            _ => f64::INFINITY,
        }
    }

    /// Returns the rough facets of a baseline along one direction; `None` for the other kernels.
    fn facets(&self, normal: [f64; 2]) -> Option<Baseline> {
        let incidence_rad = self.place.incidence_deg.to_radians();
        let index = self.sheet.table.provenance.refractive_index;
        Baseline::new(self.sheet.result.kernel, incidence_rad, index, normal)
    }

    /// Returns the distance that contains all but [`TAIL`] of the light along each axis, mm.
    ///
    /// A tail of density T/s^2 along an axis has 2 T/x of the light beyond x, counting both sides.
    fn reach(&self) -> Result<f64, Error> {
        use std::f64::consts::PI;
        if !self.returns {
            return Ok(0.0);
        }
        if let (Some(tangential), Some(sagittal), Some((shape, _))) =
            (self.facets([1.0, 0.0]), self.facets([0.0, 1.0]), self.lobe)
        {
            let reach = |facets: Baseline| facets.reach_mm(shape, self.blur, self.place.r_mm, TAIL);
            return Ok(reach(tangential).max(reach(sagittal)));
        }
        let shift = self.shift.as_ref().map_or(0.0, ShiftPlane::reach_mm);
        if self.sheet.result.kernel.has_waves() {
            let cosine = self.place.incidence_deg.to_radians().cos();
            let plane = ShiftPlane::new(&self.direction, cosine, self.blur.c_mm, 0.0);
            let mut kink: f64 = 0.0;
            for normal in [[1.0, 0.0], [0.0, 1.0]] {
                let line = self.wave(normal)?;
                kink = kink.max(line.kink(self.blur.c_mm, self.place.r_mm));
            }
            return Ok(plane.reach_mm() + kink / (PI * PI * TAIL));
        }
        let lobe = self.lobe.map_or(0.0, |(shape, a)| shape.reach_mm(a, TAIL));
        Ok(shift + lobe)
    }
}

impl FittedSpot<'_> {
    /// Evaluates the OTF of the kernel.
    fn of_kernel(&self, frequency: [f64; 2]) -> Complex64 {
        let modulus = frequency[0].hypot(frequency[1]);
        if modulus > self.end_per_mm {
            return Complex64::ZERO;
        }
        let normal = if modulus > 0.0 {
            frequency.map(|f| f / modulus)
        } else {
            [1.0, 0.0]
        };
        if let (Some(facets), Some((shape, _))) = (self.facets(normal), self.lobe) {
            return facets.otf(shape, self.blur, self.place.r_mm, modulus)[0];
        }
        if self.sheet.result.kernel.has_waves() {
            // `reach` has prepared both axes. A line fails only where they fail too.
            return self.wave(normal).map_or(Complex64::ZERO, |line| {
                line.otf(self.blur.c_mm, self.place.r_mm, modulus).0
            });
        }
        let lobe = self
            .lobe
            .map_or(1.0, |(shape, a)| shape.otf(a, modulus, normal).0);
        if lobe == 0.0 {
            return Complex64::ZERO;
        }
        let shift = self.shift.as_ref();
        shift.map_or(Complex64::ONE, |shift| shift.otf(frequency)) * lobe
    }
}

impl Spot for FittedSpot<'_> {
    fn energy(&self) -> Option<f64> {
        self.energy
    }

    fn otf(&self, frequency: [f64; 2]) -> Complex64 {
        if !self.returns {
            return Complex64::ZERO;
        }
        // The offset along the frequency times the frequency: a number without unit.
        let along = self.angular_mm[0] * frequency[0];
        let across = self.angular_mm[1] * frequency[1];
        let angular = further::otf(along * along + across * across, 1.0);
        self.of_kernel(frequency) * angular
    }

    fn reach_mm(&self) -> f64 {
        self.reach_mm
    }

    fn samples(&self) -> Option<Box<Sampler<'_>>> {
        if !self.returns || !has_samples(self.sheet.result.kernel) {
            return None;
        }
        let shift = match self.shift {
            Some(_) => Some(ShiftSampler::new(&self.direction)?),
            None => None,
        };
        let lobe = self.lobe;
        let c_mm = self.blur.c_mm;
        let angular_mm = self.angular_mm;
        let tangential_mm = c_mm * self.place.incidence_deg.to_radians().cos();
        Some(Box::new(move |point @ [u, v, w, z]| {
            let mut at = [0.0; 2];
            if let Some(shift) = &shift {
                // The shift includes the deviations here.
                let [along, across] = shift.at([u, v]).shift;
                at = [tangential_mm * along, c_mm * across];
            }
            if let Some((lobe, a)) = lobe {
                let [along, across] = lobe.offset([w, z]);
                at = [at[0] + along / a, at[1] + across / a];
            }
            if angular_mm[1] > 0.0 {
                let [along, across] = normals(point);
                at = [
                    at[0] + angular_mm[0] * along,
                    at[1] + angular_mm[1] * across,
                ];
            }
            at
        }))
    }

    fn interpolated(&self) -> bool {
        self.direction.interpolated
    }
}
