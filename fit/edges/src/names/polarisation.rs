//! Polarisation of a setup: of the source, of what stands before the camera, of a film on the sheet,
//! and of the half mirror.
//!
//! Angles count from s, the axis across the plane of incidence, towards p: clockwise for who looks
//! into the light on its way to the sheet. The plane of incidence of the half mirror is taken as
//! that of the sheet. Time is exp(-i omega t).

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2, TAU};

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::document::{finite, turn};

/// Jones matrix (s, p), row-major.
type Matrix = [[Complex64; 2]; 2];

/// State that a polariser passes. Its text is `unpolarised`, `linear:30`, `circular:left` or
/// `circular:right`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum State {
    /// No polariser.
    #[default]
    Unpolarised,
    /// Field along an axis, degrees from s.
    Linear(f64),
    /// Field that turns clockwise (right) for who looks into the light, or counter-clockwise.
    Circular {
        /// Whether it turns clockwise.
        right: bool,
    },
}

/// Film that delays one axis of the field. Light passes it before and behind the sheet.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Retarder {
    /// Delay of the slow axis, wavelengths.
    #[serde(deserialize_with = "finite")]
    pub waves: f64,
    /// Fast axis, degrees from s.
    #[serde(deserialize_with = "turn")]
    pub axis_deg: f64,
}

/// Transmittance or reflectance of a half mirror for both polarisations.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ByAxis {
    /// For the field across the plane of incidence.
    pub s: f64,
    /// For the field in the plane of incidence.
    pub p: f64,
}

impl ByAxis {
    /// Both polarisations alike.
    pub fn even(value: f64) -> ByAxis {
        ByAxis { s: value, p: value }
    }

    /// Returns the share of unpolarised light.
    pub fn mean(&self) -> f64 {
        f64::midpoint(self.s, self.p)
    }
}

/// What turns and passes polarised light in a setup.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Polarisation {
    /// State of the source.
    pub source: State,
    /// State that the analyser before the camera passes.
    pub analyser: State,
    /// Film on the sheet.
    pub retarder: Option<Retarder>,
    /// Transmittance of the half mirror.
    pub half_mirror_transmittance: ByAxis,
    /// Reflectance of the half mirror.
    pub half_mirror_reflectance: ByAxis,
}

impl Polarisation {
    /// Returns whether the light needs no Jones matrices: all of it goes one way.
    pub fn is_none(&self) -> bool {
        let even = |axes: &ByAxis| axes.s == axes.p;
        self.source == State::Unpolarised
            && self.analyser == State::Unpolarised
            && even(&self.half_mirror_transmittance)
            && even(&self.half_mirror_reflectance)
    }

    /// Returns the Jones matrices of the way to the sheet and of the way back, each in the frame
    /// (s, p = s x travel) of its own way.
    ///
    /// The half mirror reflects on the way to the sheet, or on the way back if the camera sees the
    /// sheet in it. Its matrices are relative to its means, the product of which is a factor of its
    /// own. An analyser passes at most all light.
    pub fn ways(&self, seen_in_mirror: bool) -> [Matrix; 2] {
        let relative = |axes: &ByAxis, sign: f64| {
            let [s, p] = [axes.s, axes.p].map(|own| (own / axes.mean()).sqrt());
            diagonal(sign * s, p)
        };
        // A mirror turns the field along s round, and with p = s x travel not that along p.
        let mirrored = relative(&self.half_mirror_reflectance, -1.0);
        let passed = relative(&self.half_mirror_transmittance, 1.0);
        let [first, last] = if seen_in_mirror {
            [passed, mirrored]
        } else {
            [mirrored, passed]
        };
        let film = |sign: f64| {
            self.retarder
                .map_or(diagonal(1.0, 1.0), |own| own.matrix(sign))
        };
        // A polarised source has all of its light in one state.
        let amplitude = match self.source {
            State::Unpolarised => 1.0,
            _ => SQRT_2,
        };
        let source = (self.source.projection(1.0)).map(|row| row.map(|own| own * amplitude));
        // Axes in space stand at the opposite angle in the frame of the way back, whose p is turned.
        let analyser = self.analyser.projection(-1.0);
        [
            product(&film(1.0), &product(&first, &source)),
            product(&analyser, &product(&last, &film(-1.0))),
        ]
    }
}

impl State {
    /// Returns the matrix of the polariser. `sign` is -1 in the frame of the way back.
    fn projection(self, sign: f64) -> Matrix {
        let [s, p]: [Complex64; 2] = match self {
            State::Unpolarised => return diagonal(1.0, 1.0),
            State::Linear(deg) => {
                let (sin, cos) = (sign * deg).to_radians().sin_cos();
                [cos.into(), sin.into()]
            }
            // Right-handed is a matter of the light's own way, not of axes in space.
            State::Circular { right } => {
                let turn = if right { FRAC_1_SQRT_2 } else { -FRAC_1_SQRT_2 };
                [FRAC_1_SQRT_2.into(), Complex64::new(0.0, turn)]
            }
        };
        [[s * s.conj(), s * p.conj()], [p * s.conj(), p * p.conj()]]
    }
}

impl Retarder {
    /// Returns the matrix of the film. `sign` is -1 in the frame of the way back.
    fn matrix(&self, sign: f64) -> Matrix {
        let (sin, cos) = (sign * self.axis_deg).to_radians().sin_cos();
        let slow = Complex64::cis(TAU * self.waves);
        let mixed = (Complex64::ONE - slow) * (sin * cos);
        [
            [cos * cos + slow * (sin * sin), mixed],
            [mixed, sin * sin + slow * (cos * cos)],
        ]
    }
}

fn diagonal(s: f64, p: f64) -> Matrix {
    [[s.into(), Complex64::ZERO], [Complex64::ZERO, p.into()]]
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let entry = |i: usize, j: usize| a[i][0] * b[0][j] + a[i][1] * b[1][j];
    [0, 1].map(|i| [0, 1].map(|j| entry(i, j)))
}

impl TryFrom<String> for State {
    type Error = String;

    fn try_from(text: String) -> Result<State, String> {
        let linear = |angle: &str| {
            let deg: f64 = angle.trim().parse().ok()?;
            (deg.abs() <= 360.0).then_some(State::Linear(deg))
        };
        let state = match text.split_once(':') {
            None if text == "unpolarised" => Some(State::Unpolarised),
            Some(("linear", angle)) => linear(angle),
            Some(("circular", "left")) => Some(State::Circular { right: false }),
            Some(("circular", "right")) => Some(State::Circular { right: true }),
            _ => None,
        };
        state.ok_or_else(|| {
            format!(
                "is \"{text}\"; use unpolarised, linear:DEG with an angle from -360 to 360 degrees, \
                circular:left or circular:right"
            )
        })
    }
}

impl From<State> for String {
    fn from(state: State) -> String {
        match state {
            State::Unpolarised => "unpolarised".into(),
            State::Linear(deg) => format!("linear:{deg}"),
            State::Circular { right: true } => "circular:right".into(),
            State::Circular { right: false } => "circular:left".into(),
        }
    }
}
