//! The model of an edge: the OTF of one direction (shift, waves or facets, times a lobe), and the
//! curve into which it blurs an edge.

use num_complex::Complex64;

use crate::model::baseline::Baseline;
use crate::model::further;
use crate::model::further::Further;
use crate::model::lobe::Lobe;
use edges::names::LobeShape;
use edges::names::{Ghost, Haze, Kernel};
use tables::ShiftLine;
use tables::WaveLine;

/// Numbers of the blur at one incidence, which a fit varies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blur {
    /// Spread: a in 1/mm (eq1, lobe), A = a R (angular), or the roughness of a baseline. `shift`
    /// and `wave` ignore it.
    pub spread: f64,
    /// Corner size c, mm, or the roughness of the front (saito-surface). `lobe` and the other
    /// baselines ignore it.
    pub c_mm: f64,
    /// Variance of the blur of the camera that the reference does not have, mm^2. It is negative if
    /// the reference is less sharp.
    pub own_blur_mm2: f64,
    /// Variance of the direction of the returned light, across the plane of incidence, mrad^2.
    pub angular_spread_mrad2: f64,
    /// Errors of the dihedral angles at the edges 1, 2 and 3 of all cubes, mrad.
    pub errors_mrad: [f64; 3],
}

impl Blur {
    /// Makes the blur of a kernel alone.
    pub const fn new(spread: f64, c_mm: f64) -> Blur {
        Blur {
            spread,
            c_mm,
            own_blur_mm2: 0.0,
            angular_spread_mrad2: 0.0,
            errors_mrad: [0.0; 3],
        }
    }
}

/// OTF at one frequency with its derivatives.
#[derive(Debug, Clone, Copy, Default)]
pub struct Otf {
    /// The OTF itself.
    pub value: Complex64,
    /// Derivative by ln(spread).
    pub by_ln_spread: Complex64,
    /// Derivative by ln(c).
    pub by_ln_c: Complex64,
    /// Derivatives by the dihedral errors, 1/mrad; 0 if the model has none.
    pub by_errors: [Complex64; 3],
}

/// Profile of a model over the bins, with its derivatives.
pub struct Curve {
    /// Mean of the unit edge over each bin.
    pub bins: Vec<f64>,
    /// Derivatives by ln(spread) and ln(c), as far as the kernel has them, and by the parameters of
    /// the further blurs that the model has, in the units of [`Blur`].
    pub derivatives: Vec<Vec<f64>>,
}

/// Blur of one direction along one line: kernel, lobe shape, and the direction's shift or waves.
#[derive(Clone, Copy)]
pub struct Model<'a> {
    /// Terms of the model.
    pub kernel: Kernel,
    /// Shape of the kernel's lobe.
    pub shape: LobeShape,
    /// Shift of the direction along the edge normal; `None` only for kernels without a shift.
    pub shift: Option<&'a ShiftLine>,
    /// The same for cubes with dihedral errors; `None` if the model has no such errors.
    pub bent: Option<&'a ShiftLine>,
    /// Waves of the direction along the edge normal; `None` only for kernels without waves. The OTF
    /// of a `wave` kernel is NaN without them.
    pub wave: Option<&'a WaveLine>,
    /// Facets along the edge normal; `None` except for baselines. The OTF of a baseline is NaN
    /// without them.
    pub baseline: Option<Baseline>,
    /// Floating distance (optical path), mm.
    pub r_mm: f64,
    /// Edge normal in the mid-air image, (tangential, sagittal).
    pub normal: [f64; 2],
    /// Further blurs by whose parameters a fit needs derivatives.
    pub further: Further,
    /// Second image of a thick half mirror.
    pub ghost: Option<Ghost>,
    /// Haze of a film; `None` for photographs, where it is part of the plateaus.
    pub haze: Option<Haze>,
    /// Gain of an angular spread in the plane of incidence, see [`further::tangential_gain`].
    pub tangential_gain: f64,
}

impl Model<'_> {
    /// Evaluates the OTF of the mid-air image at `frequency` (1/mm) along the normal, and its
    /// derivatives by ln(spread) and ln(c).
    pub fn otf(&self, blur: Blur, frequency: f64) -> Otf {
        let [sheet, by_ln_c, by_errors @ ..] = self.sheet(blur.c_mm, blur.errors_mrad, frequency);
        let [lobe, by_ln_spread] = self.lobe_otf(blur.spread, frequency);
        let mut others = Complex64::from(self.further_otf(blur, frequency));
        if let Some(ghost) = self.ghost {
            others *= ghost.otf(self.normal, frequency);
        }
        if let Some(haze) = self.haze {
            others *= haze.otf(self.r_mm, frequency);
        }
        Otf {
            value: sheet * lobe * others,
            by_ln_spread: sheet * by_ln_spread * others,
            by_ln_c: by_ln_c * lobe * others,
            by_errors: by_errors.map(|by| by * lobe * others),
        }
    }

    /// Evaluates the factor of the OTF that depends on c and on the dihedral errors, and its derivatives
    /// by ln(c) and by the errors.
    pub(crate) fn sheet(&self, c_mm: f64, errors_mrad: [f64; 3], frequency: f64) -> [Complex64; 5] {
        let Some(line) = self.bent else {
            let [value, by_ln_c] = self.sheet_otf(c_mm, frequency);
            let none = Complex64::ZERO;
            return [value, by_ln_c, none, none, none];
        };
        let errors_rad = errors_mrad.map(|error| 1e-3 * error);
        let parts = line.otf_with_errors([c_mm, self.r_mm], errors_rad, frequency);
        let [value, by_c, e1, e2, e3] = parts;
        [value, by_c * c_mm, e1 * 1e-3, e2 * 1e-3, e3 * 1e-3]
    }

    /// Evaluates the factor of the OTF by the further blurs.
    fn further_otf(&self, blur: Blur, frequency: f64) -> f64 {
        let by_spread = self.variance_per_mrad2();
        let variance_mm2 = blur.own_blur_mm2 + blur.angular_spread_mrad2 * by_spread;
        further::otf(variance_mm2, frequency)
    }

    /// Returns the derivative of the variance along the normal by that of the angular spread.
    fn variance_per_mrad2(&self) -> f64 {
        further::variance_per_mrad2(self.r_mm, self.normal, self.tangential_gain)
    }

    /// Returns the derivatives of the logarithm of the OTF by the variances of own blur and angular
    /// spread at a frequency in 1/mm.
    pub fn further_slopes(&self, frequency: f64) -> [f64; 2] {
        [1.0, self.variance_per_mrad2()].map(|by| by * further::slope(frequency))
    }

    /// Evaluates the OTF at a frequency in 1/mm, and its derivatives by ln(spread), ln(c), the variances
    /// of own blur and angular spread, and the dihedral errors.
    pub(crate) fn parts(&self, blur: Blur, frequency: f64) -> [Complex64; 8] {
        let otf = self.otf(blur, frequency);
        let [e1, e2, e3] = otf.by_errors;
        let [own, spread] = self
            .further_slopes(frequency)
            .map(|slope| otf.value * slope);
        [
            otf.value,
            otf.by_ln_spread,
            otf.by_ln_c,
            own,
            spread,
            e1,
            e2,
            e3,
        ]
    }

    /// Returns the indices of those derivatives of [`Model::parts`] by which a fit varies the model, each
    /// with the kink of the derivative.
    pub(crate) fn wanted(&self, blur: Blur) -> impl Iterator<Item = (usize, f64)> + use<> {
        let [_, by_spread, by_c] = self.kink(blur);
        let own_blur = self.further.has_own_blur();
        let Further {
            angular_spread,
            common_errors,
            ..
        } = self.further;
        // Further blurs do not change the kink at frequency 0.
        [
            (self.kernel.has_lobe(), by_spread),
            (self.kernel.has_c(), by_c),
            (own_blur, 0.0),
            (angular_spread, 0.0),
            (common_errors, 0.0),
            (common_errors, 0.0),
            (common_errors, 0.0),
        ]
        .into_iter()
        .enumerate()
        .filter_map(|(part, (is_wanted, kink))| is_wanted.then_some((part + 1, kink)))
    }

    /// Evaluates the factor of the OTF that depends on c (shift, waves or a rough front), and its
    /// derivative by ln(c). They are 1 and 0 if the kernel has no such factor.
    pub fn sheet_otf(&self, c_mm: f64, frequency: f64) -> [Complex64; 2] {
        if let Some(facets) = self.baseline {
            return facets
                .front_otf(self.shape, c_mm * self.r_mm, frequency)
                .map(Complex64::from);
        }
        match (self.kernel, self.wave, self.shift) {
            (Kernel::Wave, Some(line), _) => line.otf(c_mm, self.r_mm, frequency).into(),
            (kernel, ..) if kernel.has_waves() || kernel.is_baseline() => {
                [Complex64::from(f64::NAN); 2]
            }
            (kernel, _, Some(line)) if kernel.shifts_rays() => {
                let (value, by_c) = line.otf(c_mm, self.r_mm, frequency);
                [value, by_c * c_mm]
            }
            _ => [Complex64::ONE, Complex64::ZERO],
        }
    }

    /// Evaluates the lobe's factor of the OTF, and its derivative by ln(spread). They are 1 and 0
    /// if the kernel has no lobe.
    pub fn lobe_otf(&self, spread: f64, frequency: f64) -> [f64; 2] {
        if let Some(facets) = self.baseline {
            return facets.own_otf(self.shape, spread * self.r_mm, frequency);
        }
        if !self.kernel.has_lobe() {
            return [1.0, 0.0];
        }
        let a = spread / self.kernel.distance_scale(self.r_mm);
        let (value, slope) = self.shape.otf(a, frequency, self.normal);
        [value, slope * a]
    }

    /// Returns the kink of the OTF at frequency 0, -d OTF/d|f| (mm), and its derivatives by
    /// ln(spread) and ln(c).
    pub fn kink(&self, blur: Blur) -> [f64; 3] {
        if let (Kernel::Wave, Some(line)) = (self.kernel, self.wave) {
            let kink = line.kink(blur.c_mm, self.r_mm);
            return [kink, 0.0, -kink];
        }
        if !self.kernel.has_lobe() || self.kernel.is_baseline() {
            return [0.0; 3];
        }
        let a = blur.spread / self.kernel.distance_scale(self.r_mm);
        let (kink, slope) = self.shape.kink(a, self.normal);
        [kink, slope * a, 0.0]
    }
}
