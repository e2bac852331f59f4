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
}

impl Blur {
    /// Makes the blur of a kernel alone.
    pub const fn new(spread: f64, c_mm: f64) -> Blur {
        Blur {
            spread,
            c_mm,
            own_blur_mm2: 0.0,
            angular_spread_mrad2: 0.0,
        }
    }
}

/// Derivative of the logarithm of the OTF by the parameter of a further blur, by frequency.
#[derive(Debug, Clone, Copy)]
pub struct FurtherSlope {
    /// Derivative of the variance along the normal by the parameter.
    by: f64,
    /// Variance of a ring along the normal, mm^2; `None` for a Gaussian.
    ring_mm2: Option<f64>,
}

impl FurtherSlope {
    /// Evaluates the derivative at a frequency in 1/mm.
    pub fn at(self, frequency: f64) -> f64 {
        let slope = match self.ring_mm2 {
            Some(variance_mm2) => further::ring_slope(variance_mm2, frequency),
            None => further::slope(frequency),
        };
        self.by * slope
    }
}

/// Profile of a model over the bins, with its derivatives by the natural logarithms of spread and
/// c, and by the variances of further blurs.
pub struct Curve {
    /// Mean of the unit edge over each bin.
    pub bins: Vec<f64>,
    /// Derivative by ln(spread), if the kernel has a lobe.
    pub by_ln_spread: Option<Vec<f64>>,
    /// Derivative by ln(c), if the kernel has c.
    pub by_ln_c: Option<Vec<f64>>,
    /// Derivatives by the variances of the further blurs that the model has, in the units of
    /// [`Blur`].
    pub by_further: Vec<Vec<f64>>,
}

impl Curve {
    /// Returns the derivatives in the order of a candidate's columns: spread, c, further blurs.
    pub fn derivatives(&self) -> impl Iterator<Item = &Vec<f64>> {
        let kernel = self.by_ln_spread.iter().chain(&self.by_ln_c);
        kernel.chain(&self.by_further)
    }
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
    /// Further blurs by whose variances a fit needs derivatives.
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
    pub fn otf(&self, blur: Blur, frequency: f64) -> [Complex64; 3] {
        let [sheet, by_ln_c] = self.sheet_otf(blur.c_mm, frequency);
        let [lobe, by_ln_spread] = self.lobe_otf(blur.spread, frequency);
        let mut others = Complex64::from(self.further_otf(blur, frequency));
        if let Some(ghost) = self.ghost {
            others *= ghost.otf(self.normal, frequency);
        }
        if let Some(haze) = self.haze {
            others *= haze.otf(self.r_mm, frequency);
        }
        [sheet * lobe, sheet * by_ln_spread, by_ln_c * lobe].map(|part| part * others)
    }

    /// Evaluates the factor of the OTF by the further blurs.
    fn further_otf(&self, blur: Blur, frequency: f64) -> f64 {
        if blur.angular_spread_mrad2 == 0.0 {
            return further::otf(blur.own_blur_mm2, frequency);
        }
        let spread_mm2 = blur.angular_spread_mrad2 * self.variance_per_mrad2();
        if self.further.is_ring {
            further::otf(blur.own_blur_mm2, frequency) * further::ring(spread_mm2, frequency)
        } else {
            further::otf(blur.own_blur_mm2 + spread_mm2, frequency)
        }
    }

    fn variance_per_mrad2(&self) -> f64 {
        further::variance_per_mrad2(self.r_mm, self.normal, self.tangential_gain)
    }

    /// Returns the derivatives of the logarithm of the OTF by the parameters of the further blurs
    /// that the model has.
    pub fn further_slopes(&self, blur: Blur) -> impl Iterator<Item = FurtherSlope> + use<> {
        let own = self.further.own_blur.then_some(FurtherSlope {
            by: 1.0,
            ring_mm2: None,
        });
        let angular = self.further.angular_spread;
        let angular = angular.then(|| {
            let by = self.variance_per_mrad2();
            let ring = self.further.is_ring;
            FurtherSlope {
                by,
                ring_mm2: ring.then_some(blur.angular_spread_mrad2 * by),
            }
        });
        own.into_iter().chain(angular)
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
