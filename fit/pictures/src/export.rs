//! Nearest lobe for renderers that know no ray shift: one retroreflective GGX lobe, in three file
//! forms. For Mitsuba, whose plugins of `midair.mitsuba` know it, the sheet itself.
//!
//! OpenPBR 1.2 (draft), MaterialX (from 1.39.5) and glTF (KHR_materials_retroreflection, draft)
//! share the minimal retroreflective microfacet model (`baseline`, mrm). The roughness is chosen at
//! one distance and one incidence: its MTF has the least squared difference from the MTF of the
//! sheet, over both axes. The reflectance is the share of the light that the sheet returns there.
//! At another distance the blur differs from that of the sheet, because a ray shift does not grow
//! with the distance and a lobe does.

use std::path::Path;

use charts::escape;
use serde_json::{Value, json};
use tables::Table;

use edges::names::Kernel;
use edges::names::LobeShape;
use edges::names::ParameterKind;
use estimator::Error;
use estimator::model::{Baseline, Blur};
use estimator::predict::{Fitted, Places, Prediction, predict};
use estimator::result::{Domain, ResultFile};

/// File form of a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// open_pbr_surface with specular_retroreflectivity (OpenPBR 1.2, draft), as MaterialX.
    Openpbr,
    /// generalized_schlick_bsdf with retroreflective (MaterialX 1.39.5).
    Materialx,
    /// KHR_materials_retroreflection (draft).
    Gltf,
}

/// Writes a sheet for Mitsuba with `midair.mitsuba`, ray shift included: a scene of one BSDF, for
/// `<include>`.
///
/// It names the files of the result and of the table, so it stays true when the sheet is fitted
/// again. Their paths are made absolute, because Mitsuba looks for files beside the scene that
/// includes.
///
/// # Errors
/// Returns [`crate::Error::NoBsdf`] if the kernel holds in no scene, and the errors of
/// [`Fitted::new`].
pub fn mitsuba(
    result: &ResultFile,
    table: &Table,
    [result_path, table_path]: [&Path; 2],
    floating_distance_mm: f64,
) -> Result<String, crate::Error> {
    Fitted::new(result, table)?;
    if result.dihedral_errors_mrad.is_some() {
        return Err(crate::Error::BentCubes);
    }
    let kernel = result.kernel;
    let distance = match kernel {
        Kernel::Eq1 | Kernel::Lobe => {
            format!("        <float name=\"R\" value=\"{floating_distance_mm}\"/>\n")
        }
        Kernel::Angular | Kernel::Shift => String::new(),
        _ => return Err(crate::Error::NoBsdf(kernel)),
    };
    let path = |path: &Path| {
        let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        escape(&whole.to_string_lossy())
    };
    let domain = result.domain.as_ref();
    let measured = domain.map_or("Measured places are unknown".into(), |domain| {
        measured(domain)
    });
    Ok(format!(
        "<scene version=\"3.0.0\">\n    <!-- {measured}. -->\n    \
         <bsdf type=\"midair_sheet\" id=\"sheet\">\n        \
         <string name=\"table\" value=\"{}\"/>\n        \
         <string name=\"params\" value=\"{}\"/>\n{distance}    </bsdf>\n</scene>\n",
        path(table_path),
        path(result_path),
    ))
}

impl Form {
    /// Returns what must be known of a form that is a draft.
    pub fn draft(self) -> Option<&'static str> {
        match self {
            Form::Openpbr => Some(
                "specular_retroreflectivity is of OpenPBR 1.2, a draft which no released library \
                declares yet (MaterialX 1.39.5 has OpenPBR 1.1, and renders a plain mirror); --to \
                materialx writes the same lobe for it",
            ),
            Form::Materialx => None,
            Form::Gltf => Some(
                "KHR_materials_retroreflection is a draft of Khronos, which viewers do not know \
                yet: they show a plain metal",
            ),
        }
    }
}

/// Retroreflective lobe that is nearest to a sheet, and the place where it was compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Nearest {
    /// Roughness alpha of GGX: the width of the distribution of slopes.
    pub alpha: f64,
    /// Share of the light that comes back, without the losses of the half mirror.
    pub reflectance: f64,
    /// Root mean square difference of the MTFs, over both axes and all compared frequencies.
    pub rms: f64,
    /// Highest compared frequency, 1/mm.
    ///
    /// There the MTF of the sheet is below `FAINT` along both axes.
    pub end_per_mm: f64,
    /// Distance R: optical path from the sheet to the image, mm.
    pub floating_distance_mm: f64,
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Azimuth, degrees; `None` for a mean table.
    pub azimuth_deg: Option<f64>,
    /// Distances and directions of the photographs; `None` for an older result.
    pub measured: Option<Domain>,
}

/// MTF below which frequencies are not compared.
pub(crate) const FAINT: f64 = 0.05;

/// Properties of a sheet that no file form can express.
pub const LOST: &str = "the material has no ray shift: all of its blur grows with the \
    distance, but a part of the blur of the sheet does not; its reflectance does not fall with the \
    incidence as that of the sheet does";

/// Finds the nearest lobe at one distance and direction.
///
/// # Errors
/// Returns the errors of [`predict`], [`Error::Unknown`] if the result has no mu, and
/// [`Error::Dark`] if nothing is retroreflected.
pub fn nearest(
    result: &ResultFile,
    table: &Table,
    floating_distance_mm: f64,
    incidence_deg: f64,
    azimuth_deg: Option<f64>,
) -> Result<Nearest, Error> {
    // 4,000 frequencies up to 40 /mm resolve a lobe of 0.05 mm. A lobe of 3 mm has 30 of them.
    let frequency_per_mm: Vec<f64> = (1..=4000).map(|i| 0.01 * f64::from(i)).collect();
    let places = Places {
        floating_distance_mm: vec![floating_distance_mm],
        incidence_deg: vec![incidence_deg],
        azimuth_deg,
        frequency_per_mm,
    };
    let axes = predict(result, table, &places)?;
    let luminance = axes.first().and_then(|axis| axis.luminance);
    let luminance = luminance.ok_or(Error::Unknown {
        parameter: ParameterKind::Mu,
    })?;
    if axes.iter().any(|axis| axis.mtf.is_empty()) {
        return Err(Error::Dark { incidence_deg });
    }
    let faint = |axis: &Prediction| axis.mtf.iter().position(|&m| m < FAINT);
    let end = axes.iter().map(faint).max().flatten();
    let end = end.map_or(places.frequency_per_mm.len(), |end| end.max(8));
    let frequencies = &places.frequency_per_mm[..end];
    let index = table.provenance.refractive_index;
    let squares = |ln_alpha: f64| -> f64 {
        let blur = Blur::new(ln_alpha.exp(), 1.0);
        let along = |axis: &Prediction| -> f64 {
            let normal = axis.axis.normal();
            let lobe = Baseline::new(Kernel::Mrm, incidence_deg.to_radians(), index, normal);
            let difference = |(f, m): (&f64, &f64)| {
                lobe.map_or(f64::NAN, |lobe| {
                    lobe.otf(LobeShape::Ggx, blur, floating_distance_mm, *f)[0].re - m
                })
            };
            frequencies
                .iter()
                .zip(&axis.mtf)
                .map(|pair| difference(pair).powi(2))
                .sum()
        };
        axes.iter().map(along).sum()
    };
    let ln_alpha = least(squares, 1e-7_f64.ln(), 0.0);
    Ok(Nearest {
        alpha: ln_alpha.exp(),
        reflectance: luminance / result.half_mirror,
        rms: (squares(ln_alpha) / (axes.len() * end) as f64).sqrt(),
        end_per_mm: frequencies[end - 1],
        floating_distance_mm,
        incidence_deg,
        azimuth_deg,
        measured: result.domain,
    })
}

/// Returns the sentence on where a sheet was measured.
fn measured(domain: &Domain) -> String {
    let both = |[least, most]: [f64; 2], unit: &str| match least == most {
        true => format!("{least} {unit}"),
        false => format!("{least} to {most} {unit}"),
    };
    let azimuth = domain.azimuth_deg.map(|range| both(range, "deg"));
    format!(
        "The sheet was measured at {}, incidence {}{}; elsewhere nothing is known of it",
        both(domain.floating_distance_mm, "mm"),
        both(domain.incidence_deg, "deg"),
        azimuth.map_or(String::new(), |azimuth| format!(", azimuth {azimuth}"))
    )
}

/// Returns where a function with one valley is least.
///
/// The best of 64 points gives the neighbourhood. Golden sections refine it to 1e-6.
fn least(f: impl Fn(f64) -> f64, low: f64, high: f64) -> f64 {
    const POINTS: usize = 64;
    let step = (high - low) / POINTS as f64;
    let point = |i: usize| low + i as f64 * step;
    let best = (0..=POINTS).min_by(|&a, &b| f(point(a)).total_cmp(&f(point(b))));
    let middle = point(best.unwrap_or(0));
    let (mut a, mut b) = (middle - step, middle + step);
    let share = 0.5 * (5.0_f64.sqrt() - 1.0);
    while b - a > 1e-6 {
        let (left, right) = (b - share * (b - a), a + share * (b - a));
        if f(left) < f(right) {
            b = right;
        } else {
            a = left;
        }
    }
    0.5 * (a + b)
}

impl Nearest {
    /// Describes how and where the lobe was fitted, and where the sheet was measured.
    pub fn criterion(&self) -> String {
        let azimuth = self
            .azimuth_deg
            .map_or(String::new(), |a| format!(", azimuth {a} deg"));
        format!(
            "The lobe was fitted to the MTF up to {:.2} /mm at {} mm, incidence {} deg{azimuth}: \
            the root mean square difference is {:.4}{}",
            self.end_per_mm,
            self.floating_distance_mm,
            self.incidence_deg,
            self.rms,
            self.measured
                .as_ref()
                .map_or(String::new(), |domain| format!(". {}", measured(domain)))
        )
    }

    /// Writes the material as text.
    pub fn text(&self, form: Form) -> String {
        match form {
            Form::Openpbr => self.materialx(&self.openpbr_node()),
            Form::Materialx => self.materialx(&self.bsdf_node()),
            Form::Gltf => {
                let mut text = format!("{:#}", self.gltf());
                text.push('\n');
                text
            }
        }
    }

    /// Writes a MaterialX document around a surface shader named "shader".
    fn materialx(&self, shader: &str) -> String {
        format!(
            "<?xml version=\"1.0\"?>\n<materialx version=\"1.39\">\n  <!-- {}. {LOST}. \
            -->\n{shader}  \
             <surfacematerial name=\"retroreflective_sheet\" type=\"material\">\n    \
             <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"shader\" />\n  \
             </surfacematerial>\n</materialx>\n",
            self.criterion()
        )
    }

    /// Writes the BSDF in MaterialX.
    ///
    /// Its roughness is alpha. Equal colours make the reflectance equal at every angle.
    fn bsdf_node(&self) -> String {
        let (alpha, colour) = (self.alpha, self.reflectance);
        let colours: String = ["color0", "color82", "color90"]
            .map(|name| {
                format!(
                    "    <input name=\"{name}\" type=\"color3\" value=\"{colour:.6}, \
                {colour:.6}, {colour:.6}\" />\n"
                )
            })
            .concat();
        format!(
            "  <generalized_schlick_bsdf name=\"lobe\" type=\"BSDF\">\n{colours}    \
             <input name=\"roughness\" type=\"vector2\" value=\"{alpha:.8}, {alpha:.8}\" />\n    \
             <input name=\"retroreflective\" type=\"boolean\" value=\"true\" />\n    \
             <input name=\"distribution\" type=\"string\" value=\"ggx\" />\n    \
             <input name=\"scatter_mode\" type=\"string\" value=\"R\" />\n  \
             </generalized_schlick_bsdf>\n  \
             <surface name=\"shader\" type=\"surfaceshader\">\n    \
             <input name=\"bsdf\" type=\"BSDF\" nodename=\"lobe\" />\n  </surface>\n"
        )
    }

    /// Writes a metal in OpenPBR, where a roughness r means alpha = r^2.
    fn openpbr_node(&self) -> String {
        let (roughness, colour) = (self.alpha.sqrt(), self.reflectance);
        format!(
            "  <!-- OpenPBR 1.2 (draft): specular_retroreflectivity is not yet in the libraries \
            of MaterialX 1.39.5. -->\n  \
             <open_pbr_surface name=\"shader\" type=\"surfaceshader\">\n    \
             <input name=\"base_color\" type=\"color3\" value=\"{colour:.6}, {colour:.6}, \
             {colour:.6}\" />\n    \
             <input name=\"base_metalness\" type=\"float\" value=\"1\" />\n    \
             <input name=\"specular_roughness\" type=\"float\" value=\"{roughness:.8}\" />\n    \
             <input name=\"specular_retroreflectivity\" type=\"float\" value=\"1\" />\n  \
             </open_pbr_surface>\n"
        )
    }

    /// Writes a metal in glTF, whose roughnessFactor means the same as OpenPBR's roughness.
    fn gltf(&self) -> Value {
        let colour = self.reflectance;
        json!({
            "asset": { "version": "2.0", "generator": "fit export" },
            "extensionsUsed": ["KHR_materials_retroreflection"],
            "materials": [{
                "name": "retroreflective sheet",
                "pbrMetallicRoughness": {
                    "baseColorFactor": [colour, colour, colour, 1.0],
                    "metallicFactor": 1.0,
                    "roughnessFactor": self.alpha.sqrt(),
                },
                "extensions": { "KHR_materials_retroreflection": { "retroreflectionFactor": 1.0 } },
                "extras": {
                    "criterion": self.criterion(),
                    "lost": LOST,
                    "extension": "KHR_materials_retroreflection is a draft",
                },
            }],
        })
    }
}
