//! MTF of a sheet along one direction of the image, with its derivatives and the frequencies at
//! which it falls to a level.

use num_complex::Complex64;
use tables::{Direction, ShiftLine, WaveLine};

use crate::error::Error;
use crate::model::wave;
use crate::model::{Baseline, Blur, Further, Model};
use crate::predict::sheet::Fitted;
use edges::names::{Kernel, LobeShape, Stray};

/// Sheet at one direction of incidence, along one direction of the image.
pub(crate) struct Line {
    kernel: Kernel,
    shape: LobeShape,
    shift: Option<ShiftLine>,
    /// The shift with its derivatives by dihedral errors; `None` if the result has no such errors.
    bent: Option<ShiftLine>,
    wave: Option<WaveLine>,
    baseline: Option<Baseline>,
    normal: [f64; 2],
    tangential_gain: f64,
    blur: Blur,
    stray: Stray,
}

impl Line {
    /// Projects a direction of the table on `normal` (tangential, sagittal), a unit vector of the
    /// image. Returns `None` if nothing returns.
    ///
    /// # Errors
    /// Returns [`Error::Unknown`] if the result lacks a parameter of the blur, and [`Error::Waves`]
    /// if the `wave` kernel lacks its data.
    pub(crate) fn new(
        sheet: &Fitted<'_>,
        direction: &Direction,
        incidence_deg: f64,
        normal: [f64; 2],
    ) -> Result<Option<Line>, Error> {
        let result = sheet.result;
        if sheet.returned(incidence_deg, direction.retroreflected) <= 0.0 {
            return Ok(None);
        }
        let incidence = incidence_deg.to_radians();
        let shift = ShiftLine::new(direction, incidence, normal);
        let wave = (result.kernel.has_waves() && shift.is_some())
            .then(|| wave::line(direction, incidence, normal, result.wavelength_nm.as_ref()))
            .transpose()?;
        let index = sheet.table.provenance.refractive_index;
        let bent = (result.dihedral_errors_mrad.is_some())
            .then(|| ShiftLine::with_errors(direction, incidence, normal, index))
            .flatten();
        Ok(Some(Line {
            kernel: result.kernel,
            shape: result.lobe.unwrap_or(LobeShape::Radial),
            shift,
            bent,
            wave,
            baseline: Baseline::new(result.kernel, incidence, index, normal),
            normal,
            tangential_gain: sheet.tangential_gain(incidence_deg),
            blur: sheet.blur(incidence_deg)?,
            stray: result.stray,
        }))
    }

    /// Returns the curve at the distance R, mm.
    pub(crate) fn at(&self, r_mm: f64) -> Curve<'_> {
        Curve {
            model: Model {
                kernel: self.kernel,
                shape: self.shape,
                shift: self.shift.as_ref(),
                wave: self.wave.as_ref(),
                baseline: self.baseline,
                r_mm,
                normal: self.normal,
                // Errors of the cubes are part of the directions: those of the blur are 0.
                bent: self.bent.as_ref(),
                further: Further::NONE,
                ghost: self.stray.ghost,
                haze: self.stray.haze,
                tangential_gain: self.tangential_gain,
            },
            blur: self.blur,
        }
    }
}

/// MTF along one direction of the image at one distance.
pub(crate) struct Curve<'a> {
    model: Model<'a>,
    blur: Blur,
}

/// A number of a prediction, and its derivatives by the parameters of the blur.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Derived {
    /// The number itself.
    pub value: f64,
    /// Derivatives by the spread and by c, in the units of [`Blur`], and by the angular spread and the
    /// dihedral errors in mrad.
    pub by_blur: [f64; 6],
}

/// First and last frequency at which a crossing is looked for, 1/mm.
const SEARCHED_PER_MM: [f64; 2] = [1e-5, 1e5];

/// Frequency below which no crossing is looked for, 1/mm: that of a blur of a million km.
const LEAST_PER_MM: f64 = 1e-12;

/// Ratio of neighbouring frequencies of the search. An MTF changes over a frequency that is
/// comparable with that of its crossing, 50 of these steps.
const STEP: f64 = 1.02;

/// Relative step of the frequency by which the slope is computed. Its error is the square of the
/// step, times a number about 1.
const SLOPE_STEP: f64 = 1e-4;

impl Curve<'_> {
    /// Evaluates the MTF at a frequency, 1/mm.
    pub(crate) fn mtf(&self, frequency_per_mm: f64) -> f64 {
        self.model.otf(self.blur, frequency_per_mm).value.norm()
    }

    /// Evaluates the MTF at a frequency, 1/mm, with its derivatives.
    pub(crate) fn derived(&self, frequency_per_mm: f64) -> Derived {
        let otf = self.model.otf(self.blur, frequency_per_mm);
        let value = otf.value.norm();
        let slope = |by: Complex64| {
            if by == Complex64::ZERO || value == 0.0 {
                0.0
            } else {
                (otf.value.conj() * by).re / value
            }
        };
        let own = |by: Complex64, parameter: f64| match slope(by) {
            0.0 => 0.0,
            slope => slope / parameter,
        };
        // The derivative by the variance, times that of the variance by the spread.
        let [_, by_variance] = self.model.further_slopes(frequency_per_mm);
        let spread_mrad = self.blur.angular_spread_mrad2.sqrt();
        let by_angular = value * by_variance * 2.0 * spread_mrad;
        let [e1, e2, e3] = otf.by_errors.map(slope);
        Derived {
            value,
            by_blur: [
                own(otf.by_ln_spread, self.blur.spread),
                own(otf.by_ln_c, self.blur.c_mm),
                by_angular,
                e1,
                e2,
                e3,
            ],
        }
    }

    /// Returns the derivative of the MTF by the frequency, mm, at a frequency above 0.
    pub(crate) fn slope(&self, frequency_per_mm: f64) -> f64 {
        let step = SLOPE_STEP * frequency_per_mm;
        (self.mtf(frequency_per_mm + step) - self.mtf(frequency_per_mm - step)) / (2.0 * step)
    }

    /// Finds the frequency (1/mm) at which the MTF first falls to `level`, to 1e-12 of itself, with
    /// its derivatives. Returns `None` if the MTF does not fall so far below 1e5 /mm.
    pub(crate) fn falls_to(&self, level: f64) -> Option<Derived> {
        let [mut first, last] = SEARCHED_PER_MM;
        // A very wide blur falls even before.
        while self.mtf(first) <= level {
            first *= 0.1;
            if first < LEAST_PER_MM {
                return None;
            }
        }
        let (mut low, mut high) = (first, first);
        while self.mtf(high) > level {
            if high > last {
                return None;
            }
            (low, high) = (high, high * STEP);
        }
        while high - low > 1e-12 * high {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if self.mtf(middle) > level {
                low = middle;
            } else {
                high = middle;
            }
        }
        let slope = self.slope(high);
        let at = self.derived(high);
        at.value.is_finite().then(|| Derived {
            value: high,
            by_blur: at.by_blur.map(|by| -by / slope),
        })
    }
}
