//! Published models of retroreflective sheets, kept for comparison: rough facets spread the light
//! by an angle, so that the blur grows with the distance; none knows of a ray shift.
//!
//! Where there is a mid-air image at all the roughness is some thousandths, so every model is taken
//! to first order in the slopes of its facets: a slope s turns the light by gain x s, which is a
//! displacement of R x gain x s in the aerial image. The density of slopes (`microfacet`) becomes
//! the blur; independent facets convolve, so their OTFs multiply. With theta outside, theta'
//! inside, m the index and G = m cos theta' - cos theta, the gains (tangential, sagittal) are:
//!
//! - Saito, Yue, Koizumi 2024 (Optical Review 31, 395), five interfaces as in their public sampler.
//!   A tilted front changes the wave vector along the front by G s: (G / cos theta, G), twice. A
//!   tilted facet turns the light by 2 k x s; over the three facets the squares of that sum to 8 in
//!   every direction across k, whatever the azimuth, and refraction out of the front makes m (cos
//!   theta' / cos theta, 1) of it. Every facet takes a third of the sum: exact for Beckmann; for
//!   GGX the true shares depend on the azimuth, and the OTF differs by up to 0.046 (seen along a
//!   cube's axis: two facets of gain 2 against three of sqrt(8/3)).
//! - Guo, Guo, Pan 2018 (Graphical Models 96, 38), eqs. 2, 3 and 12: one lobe about the way back,
//!   of roughness alpha_o^2 = alpha^2 G^2 (1 / cos theta' + 1 / cos theta), the same along both
//!   axes.
//! - Portsmouth, Raab, Belcour, Liu 2026 (JCGT 15(1), 60): f(reflect(v, n), l), a mirror's lobe
//!   turned back: (2, 2 cos theta).
//!
//! Light: Saito's and Guo's effective area is the retroreflected fraction of the table, which is
//! that area exactly, where the authors fit curves to it; each passage of the front takes Fresnel's
//! share; what the facets reflect is mu (Saito's inner reflectance is mu^(1/3)). The minimal model
//! has no area: its reflectance is mu at every angle (Schlick's rise at grazing incidence, 0.2 % of
//! 1 - mu at 45 degrees, is left out). Masking is left out: Smith's 1 - G is below (alpha tan
//! theta)^2 / 2.

use num_complex::Complex64;

use crate::model::blur::Blur;
use crate::names::Kernel;
use crate::names::LobeShape;

/// Facets of one roughness that the light meets one after the other.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Facets {
    /// Turn of the light along the line, rad, by a unit of slope.
    gain: f64,
    count: i32,
}

/// The facets of one direction, seen along one line of the aerial image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Baseline {
    /// Those whose roughness is the spread of a [`Blur`].
    own: Facets,
    /// Those of the front, where its roughness is a parameter beside.
    front: Facets,
}

impl Baseline {
    /// The facets of a kernel at an outside incidence, for a sheet of this index, along the unit
    /// direction `normal` (tangential, sagittal); `None` for kernels that are no baseline.
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

    /// OTF at `frequency` (1/mm) along the line and optical path `r_mm`, and its derivatives by the
    /// logarithms of the roughness and of the front's.
    pub fn otf(&self, shape: LobeShape, blur: Blur, r_mm: f64, frequency: f64) -> [Complex64; 3] {
        let [own, by_own] = self.own_otf(shape, blur.spread * r_mm, frequency);
        let [front, by_front] = self.front_otf(shape, blur.c_mm * r_mm, frequency);
        [own * front, by_own * front, own * by_front].map(Complex64::from)
    }

    /// The factor of the own facets, whose slopes have this scale (roughness times distance, mm),
    /// and its derivative by the scale's logarithm.
    pub fn own_otf(&self, shape: LobeShape, scale_mm: f64, frequency: f64) -> [f64; 2] {
        self.own.otf(shape, scale_mm, frequency).into()
    }

    /// The same of the front; 1 and 0 where it is smooth.
    pub fn front_otf(&self, shape: LobeShape, scale_mm: f64, frequency: f64) -> [f64; 2] {
        self.front.otf(shape, scale_mm, frequency).into()
    }

    /// Distance along the line, mm, beyond which on both sides together lies the share `tail` of
    /// the light, well below 1.
    pub fn reach_mm(&self, shape: LobeShape, blur: Blur, r_mm: f64, tail: f64) -> f64 {
        let spread = self.own.spread(blur.spread * r_mm) + self.front.spread(blur.c_mm * r_mm);
        match shape {
            // Along a line GGX is Student's t: 1 - x / sqrt(x^2 + w^2) = w^2 / 2 x^2 lies beyond x,
            // and tails add.
            LobeShape::Ggx => (0.5 * spread / tail).sqrt(),
            // A normal distribution of variance w^2 / 2: erfc(x / w) < exp(-(x / w)^2) lies beyond
            // x.
            _ => (-spread * tail.ln()).sqrt(),
        }
    }
}

impl Facets {
    /// Squared width of what they make of slopes of this scale, mm^2.
    fn spread(&self, scale_mm: f64) -> f64 {
        f64::from(self.count) * (self.gain * scale_mm).powi(2)
    }

    /// OTF of facets whose slopes have this scale (roughness times distance, mm), and its
    /// derivative by the scale's logarithm.
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

/// The share of the light that a sheet returns before mu: `eta` of the table, and what the kernel
/// makes of it.
pub(crate) fn returned(kernel: Kernel, eta: f64, incidence_rad: f64, refractive_index: f64) -> f64 {
    match kernel {
        Kernel::Eq1 | Kernel::Angular | Kernel::Shift | Kernel::Lobe | Kernel::Wave => eta,
        Kernel::Saito | Kernel::SaitoSurface | Kernel::Guo => {
            eta * (1.0 - fresnel(incidence_rad, refractive_index)).powi(2)
        }
        Kernel::Mrm => 1.0,
    }
}

/// Reflectance of a smooth dielectric front for unpolarised light.
pub(crate) fn fresnel(incidence_rad: f64, refractive_index: f64) -> f64 {
    let cos = incidence_rad.cos();
    let inside = (1.0 - (incidence_rad.sin() / refractive_index).powi(2)).sqrt();
    let across = (cos - refractive_index * inside) / (cos + refractive_index * inside);
    let within = (refractive_index * cos - inside) / (refractive_index * cos + inside);
    0.5 * (across * across + within * within)
}
