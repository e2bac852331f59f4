//! Published models of retroreflective sheets, kept for comparison.
//!
//! Rough facets spread the light by an angle, so the blur grows with the distance. None of these
//! models has a ray shift.
//!
//! If there is a mid-air image at all, the roughness is a few thousandths. So each model is taken
//! to first order in the slopes of its facets. A slope s turns the light by gain x s, which
//! displaces it by R x gain x s in the mid-air image. The density of slopes (`microfacet`) becomes
//! the blur. Independent facets convolve, so their OTFs multiply. With theta outside, theta'
//! inside, m the index and G = m cos theta' - cos theta, the gains (tangential, sagittal) are:
//!
//! - Saito, Yue, Koizumi 2024 (Optical Review 31, 395), five interfaces as in their public sampler.
//!   A tilted front changes the wave vector along the front by G s: (G / cos theta, G), twice. A
//!   tilted facet turns the light by 2 k x s. Over the three facets the squares of these turns sum
//!   to 8 in every direction across k, whatever the azimuth. Refraction out of the front multiplies
//!   them by m (cos theta' / cos theta, 1). Each facet takes a third of the sum. This is exact for
//!   Beckmann. For GGX the true shares depend on the azimuth, and the OTF differs by up to 0.046
//!   (along a cube's axis: two facets of gain 2 against three of sqrt(8/3)).
//! - Guo, Guo, Pan 2018 (Graphical Models 96, 38), eqs. 2, 3 and 12: one lobe about the way back,
//!   of roughness alpha_o^2 = alpha^2 G^2 (1 / cos theta' + 1 / cos theta), equal along both axes.
//! - Portsmouth, Raab, Belcour, Liu 2026 (JCGT 15(1), 60): f(reflect(v, n), l), the lobe of a
//!   mirror turned back: (2, 2 cos theta).
//!
//! Light: the effective area of Saito and of Guo is the retroreflected share of the table. The
//! table has that area exactly, whereas the authors fit curves to it. Each passage of the front
//! takes Fresnel's share. mu is what the facets reflect (Saito's inner reflectance is mu^(1/3)).
//! The minimal model of Portsmouth et al. has no area: its reflectance is mu at every angle.
//! Schlick's rise at grazing incidence, 0.2 % of 1 - mu at 45 degrees, is left out. Masking is left
//! out too: Smith's 1 - G is below (alpha tan theta)^2 / 2.

use num_complex::Complex64;

use crate::model::edge::Blur;
use crate::model::lobe::Lobe;
use edges::names::Kernel;
use edges::names::LobeShape;

/// Facets of equal roughness that the light meets one after the other.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Facets {
    /// Turn of the light along the line, rad per unit of slope.
    gain: f64,
    count: i32,
}

/// The facets of one direction, seen along one line of the mid-air image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Baseline {
    /// Facets whose roughness is the spread of a [`Blur`].
    own: Facets,
    /// Facets of the front, if its roughness is a parameter of its own.
    front: Facets,
}

impl Baseline {
    /// Computes the facets of a kernel for an outside incidence and a refractive index, along the
    /// unit direction `normal` (tangential, sagittal). Returns `None` for kernels that are no
    /// baseline.
    pub fn new(
        kernel: Kernel,
        incidence_rad: f64,
        refractive_index: f64,
        normal: [f64; 2],
    ) -> Option<Baseline> {
        let cos = incidence_rad.cos();
        let inside = (1.0 - (incidence_rad.sin() / refractive_index).powi(2)).sqrt();
        let step = refractive_index * inside - cos;
        let along =
            |tangential: f64, sagittal: f64| (normal[0] * tangential).hypot(normal[1] * sagittal);
        let front = Facets {
            gain: along(step / cos, step),
            count: if kernel == Kernel::SaitoSurface { 2 } else { 0 },
        };
        let own = match kernel {
            Kernel::Saito | Kernel::SaitoSurface => Facets {
                gain: (8.0_f64 / 3.0).sqrt() * refractive_index * along(inside / cos, 1.0),
                count: 3,
            },
            Kernel::Guo => Facets {
                gain: step * (1.0 / inside + 1.0 / cos).sqrt(),
                count: 1,
            },
            Kernel::Mrm => Facets {
                gain: along(2.0, 2.0 * cos),
                count: 1,
            },
            Kernel::Eq1 | Kernel::Angular | Kernel::Shift | Kernel::Lobe | Kernel::Wave => {
                return None;
            }
        };
        Some(Baseline { own, front })
    }

    /// Evaluates the OTF at `frequency` (1/mm) along the line and the optical path `r_mm`, and its
    /// derivatives by the logarithms of the roughness and of the front's roughness.
    pub fn otf(&self, shape: LobeShape, blur: Blur, r_mm: f64, frequency: f64) -> [Complex64; 3] {
        let [own, by_own] = self.own_otf(shape, blur.spread * r_mm, frequency);
        let [front, by_front] = self.front_otf(shape, blur.c_mm * r_mm, frequency);
        [own * front, by_own * front, own * by_front].map(Complex64::from)
    }

    /// Returns the gain and the count of the own facets and of those of the front.
    pub fn gains(&self) -> [(f64, i32); 2] {
        [self.own, self.front].map(|facets| (facets.gain, facets.count))
    }

    /// Evaluates the factor of the own facets and its derivative by the logarithm of `scale_mm`,
    /// the roughness times the distance in mm.
    pub fn own_otf(&self, shape: LobeShape, scale_mm: f64, frequency: f64) -> [f64; 2] {
        self.own.otf(shape, scale_mm, frequency).into()
    }

    /// Evaluates the factor of the front and its derivative by the logarithm of `scale_mm`, the
    /// front's roughness times the distance in mm. They are 1 and 0 for a smooth front.
    pub fn front_otf(&self, shape: LobeShape, scale_mm: f64, frequency: f64) -> [f64; 2] {
        self.front.otf(shape, scale_mm, frequency).into()
    }

    /// Returns the distance along the line, mm, beyond which the share `tail` of the light lies,
    /// both sides together. `tail` must be far below 1.
    pub fn reach_mm(&self, shape: LobeShape, blur: Blur, r_mm: f64, tail: f64) -> f64 {
        // Independent widths add by their squares. This is exact for Beckmann, and for the tails of
        // GGX, which add.
        let spread = self.own.spread(blur.spread * r_mm) + self.front.spread(blur.c_mm * r_mm);
        shape.reach_mm(1.0 / spread.sqrt(), tail)
    }
}

impl Facets {
    /// Returns the squared width of the blur by slopes of this scale (roughness times distance,
    /// mm), mm^2.
    fn spread(&self, scale_mm: f64) -> f64 {
        f64::from(self.count) * (self.gain * scale_mm).powi(2)
    }

    /// Evaluates the OTF of facets whose slopes have the scale `scale_mm` (roughness times
    /// distance, mm), and its derivative by the logarithm of the scale.
    fn otf(&self, shape: LobeShape, scale_mm: f64, frequency: f64) -> (f64, f64) {
        let width = self.gain * scale_mm;
        if self.count == 0 || width == 0.0 {
            return (1.0, 0.0);
        }
        let a = 1.0 / width;
        let (one, by_a) = shape.otf(a, frequency, [1.0, 0.0]);
        let others = one.powi(self.count - 1);
        (one * others, -f64::from(self.count) * others * by_a * a)
    }
}

/// Returns the share of the light that a sheet returns before mu: `eta` (1 - F)^2 for `saito`,
/// `saito-surface` and `guo`, with F from [`fresnel`], 1 for `mrm`, and `eta` for all others.
pub fn returned(kernel: Kernel, eta: f64, incidence_rad: f64, refractive_index: f64) -> f64 {
    match kernel {
        Kernel::Eq1 | Kernel::Angular | Kernel::Shift | Kernel::Lobe | Kernel::Wave => eta,
        Kernel::Saito | Kernel::SaitoSurface | Kernel::Guo => {
            eta * (1.0 - fresnel(incidence_rad, refractive_index)).powi(2)
        }
        Kernel::Mrm => 1.0,
    }
}

/// Returns the reflectance of a smooth dielectric front for unpolarised light.
pub fn fresnel(incidence_rad: f64, refractive_index: f64) -> f64 {
    let cos = incidence_rad.cos();
    let inside = (1.0 - (incidence_rad.sin() / refractive_index).powi(2)).sqrt();
    let across = (cos - refractive_index * inside) / (cos + refractive_index * inside);
    let within = (refractive_index * cos - inside) / (refractive_index * cos + inside);
    0.5 * (across * across + within * within)
}
