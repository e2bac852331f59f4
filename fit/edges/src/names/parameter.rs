//! Names of the parameters that an estimate, its covariance and its bounds refer to.

use std::cmp::Ordering;
use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::names::kernel::Kernel;

/// The quantity that a parameter measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ParameterKind {
    /// Corner size c, mm.
    CornerSize,
    /// Roughness of the front of a baseline, without unit.
    SurfaceRoughness,
    /// Diffraction spread a, 1/mm.
    APerMm,
    /// Diffraction spread A = a R, without unit.
    ATimesR,
    /// Roughness of the facets of a baseline, without unit.
    Roughness,
    /// Blur of the mid-air photographs that the reference does not have: standard deviation, pixels;
    /// negative if the reference is less sharp.
    OwnBlur,
    /// Standard deviation of the direction of the returned light, mrad.
    AngularSpread,
    /// Error of the dihedral angle at edge 1 of all cubes, mrad.
    DihedralError1,
    /// The same at edge 2.
    DihedralError2,
    /// The same at edge 3.
    DihedralError3,
    /// Reflectance mu.
    Mu,
    /// Azimuth that is added to those of the captures, degrees. It has no row in the covariance.
    Azimuth,
}

impl ParameterKind {
    /// Errors of the dihedral angles, by edge.
    pub const DIHEDRAL_ERRORS: [ParameterKind; 3] = [
        ParameterKind::DihedralError1,
        ParameterKind::DihedralError2,
        ParameterKind::DihedralError3,
    ];

    /// All kinds of parameters.
    pub const ALL: [ParameterKind; 12] = [
        ParameterKind::CornerSize,
        ParameterKind::SurfaceRoughness,
        ParameterKind::APerMm,
        ParameterKind::ATimesR,
        ParameterKind::Roughness,
        ParameterKind::OwnBlur,
        ParameterKind::AngularSpread,
        ParameterKind::DihedralError1,
        ParameterKind::DihedralError2,
        ParameterKind::DihedralError3,
        ParameterKind::Mu,
        ParameterKind::Azimuth,
    ];

    /// Returns the name in files.
    pub const fn name(self) -> &'static str {
        match self {
            ParameterKind::CornerSize => "c_mm",
            ParameterKind::SurfaceRoughness => "surface_roughness",
            ParameterKind::APerMm => "a_per_mm",
            ParameterKind::ATimesR => "a_times_r",
            ParameterKind::Roughness => "roughness",
            ParameterKind::OwnBlur => "own_blur_px",
            ParameterKind::AngularSpread => "angular_spread_mrad",
            ParameterKind::DihedralError1 => "dihedral_error_1_mrad",
            ParameterKind::DihedralError2 => "dihedral_error_2_mrad",
            ParameterKind::DihedralError3 => "dihedral_error_3_mrad",
            ParameterKind::Mu => "mu",
            ParameterKind::Azimuth => "azimuth_deg",
        }
    }

    /// Returns the size that all angles share in a kernel: c, or the roughness of a baseline's
    /// front.
    pub const fn size_of(kernel: Kernel) -> ParameterKind {
        match kernel {
            Kernel::SaitoSurface => ParameterKind::SurfaceRoughness,
            _ => ParameterKind::CornerSize,
        }
    }

    /// Returns the spread of a kernel: a, a R or a roughness.
    pub const fn spread_of(kernel: Kernel) -> ParameterKind {
        match kernel {
            Kernel::Angular => ParameterKind::ATimesR,
            _ if kernel.is_baseline() => ParameterKind::Roughness,
            _ => ParameterKind::APerMm,
        }
    }

    /// Returns whether the blur of this parameter vanishes as the parameter grows. This holds for a
    /// and a R, which are reciprocal widths. The blur of the other kinds vanishes as they fall to
    /// 0.
    pub const fn fades_upwards(self) -> bool {
        matches!(self, ParameterKind::APerMm | ParameterKind::ATimesR)
    }

    /// Returns the parameter of this kind that all photographs share.
    pub const fn shared(self) -> ParameterId {
        ParameterId {
            kind: self,
            at: None,
        }
    }

    /// Returns the parameter of this kind at one incidence (degrees) or floating distance (mm).
    pub const fn at(self, at: f64) -> ParameterId {
        ParameterId {
            kind: self,
            at: Some(at),
        }
    }

    /// Returns one parameter for each incidence (degrees) or floating distance (mm) if `apart` is set,
    /// else one for all.
    pub fn each(self, places: &[f64], apart: bool) -> Vec<ParameterId> {
        if apart {
            places.iter().map(|&place| self.at(place)).collect()
        } else {
            vec![self.shared()]
        }
    }
}

/// One parameter of an estimate. Its text in files is, for example, `a_per_mm` or `a_per_mm_at_20`.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct ParameterId {
    /// The quantity that the parameter measures.
    pub kind: ParameterKind,
    /// Incidence that the parameter belongs to, degrees; for a blur that the reference does not have
    /// the floating distance, mm; `None` if all photographs share the parameter.
    pub at: Option<f64>,
}

impl ParameterId {
    /// Returns the incidence or the floating distance with its unit; `None` if all photographs share
    /// the parameter.
    pub fn place(self) -> Option<String> {
        let at = self.at?;
        Some(match self.kind {
            ParameterKind::OwnBlur => format!("{at} mm"),
            _ => format!("{at}\u{b0}"),
        })
    }
}

/// Text between the kind and the incidence or distance in files.
const AT: &str = "_at_";

impl fmt::Display for ParameterId {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.kind.name())?;
        match self.at {
            Some(place) => write!(formatter, "{AT}{place}"),
            None => Ok(()),
        }
    }
}

/// The error of a text that names no parameter.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "\"{text}\" is no parameter; write c_mm, a_per_mm, a_times_r, roughness, surface_roughness, \
    own_blur_px, angular_spread_mrad, dihedral_error_1_mrad (2, 3) or mu, with _at_ and the incidence \
    where there is one per angle, or the floating distance of a blur"
)]
pub struct NoParameter {
    /// The text that was given.
    pub text: String,
}

impl FromStr for ParameterId {
    type Err = NoParameter;

    fn from_str(text: &str) -> Result<ParameterId, NoParameter> {
        let no = || NoParameter { text: text.into() };
        let (name, at) = match text.split_once(AT) {
            Some((name, place)) => (name, Some(place.parse().map_err(|_| no())?)),
            None => (text, None),
        };
        let kind = ParameterKind::ALL
            .into_iter()
            .find(|kind| kind.name() == name);
        Ok(ParameterId {
            kind: kind.ok_or_else(no)?,
            at,
        })
    }
}

impl TryFrom<String> for ParameterId {
    type Error = NoParameter;

    fn try_from(text: String) -> Result<ParameterId, NoParameter> {
        text.parse()
    }
}

impl From<ParameterId> for String {
    fn from(id: ParameterId) -> String {
        id.to_string()
    }
}

/// Orders parameters by their texts. The `bounds` of a result have this order.
impl Ord for ParameterId {
    fn cmp(&self, other: &ParameterId) -> Ordering {
        self.to_string().cmp(&other.to_string())
    }
}

impl PartialOrd for ParameterId {
    fn partial_cmp(&self, other: &ParameterId) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for ParameterId {
    fn eq(&self, other: &ParameterId) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for ParameterId {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_come_back() {
        let mut cases = 0;
        for kind in ParameterKind::ALL {
            for id in [
                kind.shared(),
                kind.at(0.0),
                kind.at(12.5),
                kind.at(1.0 / 3.0),
            ] {
                assert_eq!(id.to_string().parse(), Ok(id));
                cases += 1;
            }
        }
        assert_eq!(cases, 48);
        assert_eq!(ParameterKind::APerMm.at(20.0).to_string(), "a_per_mm_at_20");
        for bad in [
            "",
            "c",
            "a_per_mm_at_",
            "a_per_mm_at_x",
            "_at_20",
            "mu_at_1_at_2",
        ] {
            assert!(bad.parse::<ParameterId>().is_err(), "{bad}");
        }
    }
}
