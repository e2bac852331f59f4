//! Lamps and cameras as functions of the wavelength, and the few lines that stand for them.
//!
//! A lamp is a file of wavelengths and powers, or a named illuminant. What a camera's channel sees of
//! it is its product with the response of the channel; without a response it is the product with the
//! luminous efficiency V of the eye.

use std::path::{Path, PathBuf};

use nalgebra::{DMatrix, SymmetricEigen};

use crate::document::read;
use crate::names::{SpectralLine, Spectrum};
use crate::photographs::photo::channel::{Channel, REC709};

/// V, D65 and LED illuminants.
const TABULATED: &str = include_str!("../../../data/illuminants.csv");

/// Names of the illuminants.
pub const ILLUMINANTS: [&str; 8] = [
    "A", "D65", "E", "LED-B1", "LED-B2", "LED-B3", "LED-B4", "LED-B5",
];

/// Number of lines that stand for a lamp.
///
/// They are the nodes of Gauss' quadrature for its power: a mean over the lamp is exact for
/// polynomials of the degree 15 in the wavelength. The mean of the wave OTF of a white lamp is then
/// off by 1e-5, and by up to 4e-4 at frequencies where the OTF ends within the lamp's wavelengths
/// (tests/in_colour.py).
const LINES: usize = 8;

/// Greatest size of a file, bytes, and of wavelengths in it.
const MOST_BYTES: u64 = 1 << 20;

/// Reason why a file of wavelengths cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}: {fault}", file.display())]
pub struct LampError {
    file: PathBuf,
    fault: String,
}

/// Function of the wavelength: nm, ascending, and one value for each column.
#[derive(Debug, Clone, PartialEq)]
struct Curve {
    nm: Vec<f64>,
    columns: Vec<Vec<f64>>,
}

/// Lamp, and the response of the camera that sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct Lamp {
    power: Curve,
    response: Option<Curve>,
}

impl Lamp {
    /// Reads a lamp: the name of an illuminant, or a file with rows of nm and power.
    ///
    /// # Errors
    /// Returns an error that names file, line and remedy.
    pub fn read(name: &str, folder: &Path) -> Result<Lamp, LampError> {
        let power = match illuminant(name) {
            Some(power) => power,
            None => Curve::read(&folder.join(name), &[1], || {
                format!("; the illuminants are {}", ILLUMINANTS.join(", "))
            })?,
        };
        Ok(Lamp {
            power,
            response: None,
        })
    }

    /// Adds the response of a camera: a file with rows of nm and one value, or nm, red, green and
    /// blue.
    ///
    /// # Errors
    /// Returns an error that names file, line and remedy, also if it sees nothing of the lamp.
    pub fn seen_by(self, file: &Path) -> Result<Lamp, LampError> {
        let response = Curve::read(file, &[1, 3], String::new)?;
        let seen = Lamp {
            response: Some(response),
            ..self
        };
        for channel in Channel::PRIMARIES {
            seen.through(&channel).ok_or_else(|| LampError {
                file: file.to_owned(),
                fault: format!("the response of {channel} sees nothing of the lamp; check both"),
            })?;
        }
        Ok(seen)
    }

    /// Returns what a channel sees of the lamp, as a few lines: `None` for nothing.
    ///
    /// Luminance of a camera with three channels is their sum by the weights of Rec. 709, and that
    /// of a camera with one is its only channel.
    pub fn through(&self, channel: &Channel) -> Option<Spectrum> {
        let eye = efficiency();
        let curve = self.response.as_ref().unwrap_or(&eye);
        let response = |nm: f64| match (curve.columns.len(), channel) {
            (1, _) | (_, Channel::Red) => curve.at(nm, 0),
            (_, Channel::Green) => curve.at(nm, 1),
            (_, Channel::Blue) => curve.at(nm, 2),
            _ => (0..3).map(|k| f64::from(REC709[k]) * curve.at(nm, k)).sum(),
        };
        // Both curves are straight between their own wavelengths.
        let mut all = [&self.power.nm[..], &curve.nm].concat();
        all.sort_by(f64::total_cmp);
        all.dedup();
        let width = |k: usize| {
            let [below, above] = [k.saturating_sub(1), (k + 1).min(all.len() - 1)];
            0.5 * (all[above] - all[below])
        };
        let value = |k: usize| {
            (
                all[k],
                self.power.at(all[k], 0) * response(all[k]) * width(k),
            )
        };
        let values: Vec<(f64, f64)> = (0..all.len()).map(value).collect();
        gauss(&values)
    }

    /// Returns whether red, green and blue see different light.
    pub fn is_coloured(&self) -> bool {
        self.response
            .as_ref()
            .is_some_and(|own| own.columns.len() == 3)
    }
}

impl Curve {
    /// Reads a file of rows of numbers, with one of these numbers of columns behind the wavelength.
    fn read(file: &Path, columns: &[usize], hint: impl Fn() -> String) -> Result<Curve, LampError> {
        let fault = |fault: String| LampError {
            file: file.to_owned(),
            fault,
        };
        let text = read(file, MOST_BYTES)
            .map_err(|error| fault(format!("cannot be read ({error}){}", hint())))?;
        Curve::parse(&text, columns).map_err(fault)
    }

    /// Reads rows `nm, value, ...`; a first row of words, empty rows and rows that begin with # are
    /// left out.
    fn parse(text: &str, columns: &[usize]) -> Result<Curve, String> {
        let mut curve = Curve {
            nm: Vec::new(),
            columns: Vec::new(),
        };
        for (k, row) in text.lines().enumerate() {
            if row.trim().is_empty() || row.starts_with('#') {
                continue;
            }
            let words = row.split([',', ';', '\t']).map(str::trim);
            let numbers: Result<Vec<f64>, _> = words.map(str::parse).collect();
            let Ok(numbers) = numbers else {
                let blanks = row.split_whitespace();
                if blanks.clone().count() > 1
                    && blanks.clone().all(|own| own.parse::<f64>().is_ok())
                {
                    return Err(format!(
                        "line {}: \"{row}\" has only blanks between its columns; put a comma, a tab \
                        or a semicolon between them",
                        k + 1
                    ));
                }
                if curve.nm.is_empty() {
                    continue;
                }
                return Err(format!(
                    "line {}: \"{row}\" is no row of numbers; correct it",
                    k + 1
                ));
            };
            let wrong = |what: String| Err(format!("line {}: {what}", k + 1));
            let [nm, values @ ..] = &numbers[..] else {
                return wrong("the row is empty; correct it".into());
            };
            if !columns.contains(&values.len()) {
                let wanted: Vec<String> = columns.iter().map(usize::to_string).collect();
                return wrong(format!(
                    "has {} values behind the wavelength, but must have {}; correct it",
                    values.len(),
                    wanted.join(" or ")
                ));
            }
            if !(100.0..=20_000.0).contains(nm) || curve.nm.last().is_some_and(|last| last >= nm) {
                return wrong(format!(
                    "the wavelength {nm} must be above the one before, from 100 to 20000 nm; sort \
                    the rows, and give nanometres"
                ));
            }
            if let Some(value) = values.iter().find(|own| !(own.is_finite() && **own >= 0.0)) {
                return wrong(format!("the value {value} must be at least 0; correct it"));
            }
            curve.columns.resize(values.len(), Vec::new());
            curve.nm.push(*nm);
            for (column, value) in curve.columns.iter_mut().zip(values) {
                column.push(*value);
            }
        }
        match curve.nm.is_empty() || curve.columns.iter().flatten().all(|own| *own == 0.0) {
            true => Err("holds no light; write rows of nm and power".into()),
            false if curve.columns.iter().any(|own| own.len() != curve.nm.len()) => {
                Err("has rows of different lengths; correct them".into())
            }
            false => Ok(curve),
        }
    }

    /// Returns a column at a wavelength: straight between its own, 0 outside. A curve of one
    /// wavelength is a line.
    fn at(&self, nm: f64, column: usize) -> f64 {
        let values = &self.columns[column];
        let above = self.nm.partition_point(|own| *own < nm);
        match (above.checked_sub(1), self.nm.get(above)) {
            (_, Some(&own)) if own == nm => values[above],
            (Some(below), Some(&end)) => {
                let start = self.nm[below];
                let share = (nm - start) / (end - start);
                values[below] + share * (values[above] - values[below])
            }
            _ => 0.0,
        }
    }
}

/// Returns one of the tabulated curves.
fn tabulated(name: &str) -> Option<Curve> {
    let rows = || TABULATED.lines().filter(|row| !row.starts_with('#'));
    let column = rows().next()?.split(',').position(|own| own == name)?;
    let values = |k: usize| {
        let numbers = rows()
            .skip(1)
            .filter_map(move |row| row.split(',').nth(k)?.parse().ok());
        numbers.collect::<Vec<f64>>()
    };
    Some(Curve {
        nm: values(0),
        columns: vec![values(column)],
    })
}

fn efficiency() -> Curve {
    tabulated("V").expect("the table has V")
}

/// Returns an illuminant of the CIE.
fn illuminant(name: &str) -> Option<Curve> {
    let formula = |power: fn(f64) -> f64| {
        let nm = efficiency().nm;
        let columns = vec![nm.iter().map(|&own| power(own)).collect()];
        Some(Curve { nm, columns })
    };
    match name {
        // The radiation of tungsten at 2848 K with the second constant of its definition, relative
        // to 560 nm.
        "A" => formula(|nm| (560.0 / nm).powi(5) / (1.435e7 / (2848.0 * nm)).exp_m1()),
        "E" => formula(|_| 1.0),
        name if ILLUMINANTS.contains(&name) => tabulated(name),
        _ => None,
    }
}

/// Returns the nodes and weights of Gauss' quadrature for a discrete measure, by Lanczos' recursion
/// and the eigenvalues of its matrix (Golub and Welsch, Math. Comp. 23, 1969); `None` for a measure
/// of nothing.
fn gauss(values: &[(f64, f64)]) -> Option<Spectrum> {
    let lit: Vec<(f64, f64)> = values.iter().copied().filter(|own| own.1 > 0.0).collect();
    let total: f64 = lit.iter().map(|own| own.1).sum();
    let (first, last) = (lit.first()?.0, lit.last()?.0);
    let (middle, half) = (f64::midpoint(first, last), (0.5 * (last - first)).max(1.0));
    let place = |nm: f64| (nm - middle) / half;
    let mut before = vec![0.0; lit.len()];
    let mut vector: Vec<f64> = lit.iter().map(|own| (own.1 / total).sqrt()).collect();
    let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
    for _ in 0..LINES.min(lit.len()) {
        let pairs = lit.iter().zip(&vector);
        let alpha: f64 = pairs.map(|(own, v)| place(own.0) * v * v).sum();
        let beta = beside.last().copied().unwrap_or(0.0);
        let next = lit.iter().zip(&vector).zip(&before);
        let next: Vec<f64> = next
            .map(|((own, v), old)| (place(own.0) - alpha) * v - beta * old)
            .collect();
        diagonal.push(alpha);
        let norm = next.iter().map(|own| own * own).sum::<f64>().sqrt();
        if norm < 1e-12 {
            break;
        }
        before = vector;
        vector = next.iter().map(|own| own / norm).collect();
        beside.push(norm);
    }
    let count = diagonal.len();
    let matrix = DMatrix::from_fn(count, count, |i, j| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => beside[i.min(j)],
        _ => 0.0,
    });
    let found = SymmetricEigen::new(matrix);
    let mut lines: Vec<SpectralLine> = (0..count)
        .map(|k| SpectralLine {
            wavelength_nm: middle + half * found.eigenvalues[k],
            weight: found.eigenvectors[(0, k)].powi(2),
        })
        .collect();
    lines.retain(|line| line.weight > 0.0);
    lines.sort_by(|a, b| a.wavelength_nm.total_cmp(&b.wavelength_nm));
    Spectrum::of_lines(lines).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Few lines have the moments of the lamp: eight lines those up to the degree 15, within the
    /// rounding of an eigenvalue problem of 80 values.
    #[test]
    fn few_lines_have_the_moments_of_the_lamp() {
        let here = Path::new("");
        let mut cases = 0;
        for name in ILLUMINANTS {
            let lamp = Lamp::read(name, here).expect("an illuminant");
            let few = lamp.through(&Channel::Luminance).expect("light");
            assert_eq!(few.lines().len(), LINES, "{name}");
            let v = efficiency();
            let all: Vec<(f64, f64)> =
                v.nm.iter()
                    .map(|&nm| (nm, lamp.power.at(nm, 0) * v.at(nm, 0)))
                    .collect();
            let total: f64 = all.iter().map(|own| own.1).sum();
            for degree in [1, 2, 7, 15] {
                let power = |nm: f64| ((nm - 580.0) / 200.0).powi(degree);
                let expected: f64 = all.iter().map(|own| power(own.0) * own.1).sum::<f64>() / total;
                let lines = few.lines().iter();
                let found: f64 = lines.map(|own| own.weight * power(own.wavelength_nm)).sum();
                // The ends of the range have half the width; V is 4e-5 there.
                assert!(
                    (found - expected).abs() < 1e-5,
                    "{name} {degree}: {found} {expected}"
                );
                cases += 1;
            }
        }
        assert_eq!(cases, 32);
    }

    /// A lamp of two lines stays two lines, each weighted with V by hand: 0.1 of two at 505 nm
    /// (0.4073) and one at 600 nm (0.631).
    #[test]
    fn two_lines_stay_two_lines() {
        let power = Curve::parse("nm,power\n505,2\n505.001,0\n599.999,0\n600,1\n", &[1]).unwrap();
        let lamp = Lamp {
            power,
            response: None,
        };
        let seen = lamp.through(&Channel::Green).expect("light");
        let mean = |of: &dyn Fn(f64) -> f64| -> f64 {
            seen.lines()
                .iter()
                .map(|own| own.weight * of(own.wavelength_nm))
                .sum()
        };
        let [a, b] = [2.0 * 0.4073, 0.631].map(|own| own / (2.0 * 0.4073 + 0.631));
        let expected = a * 505.0 + b * 600.0;
        // Lines of a width of 0.001 nm.
        assert!(
            (mean(&|nm| nm) - expected).abs() < 0.02,
            "{} {expected}",
            mean(&|nm| nm)
        );
    }

    /// Every fault of a file is refused with its line.
    #[test]
    fn faults_name_their_line() {
        let cases = [
            ("", "holds no light"),
            ("nm,power\n500,0\n", "holds no light"),
            ("500,1\n490,1\n", "line 2: the wavelength 490"),
            ("500,1\n510,-1\n", "line 2: the value -1"),
            ("500,1\n510\n", "line 2: has 0 values"),
            ("500,1,2\n", "line 1: has 2 values"),
            ("500,1\n510,x\n", "line 2: \"510,x\""),
            ("0.5,1\n", "line 1: the wavelength 0.5"),
            (
                "nm power\n400 1\n",
                "line 2: \"400 1\" has only blanks between its columns",
            ),
        ];
        for (text, expected) in cases {
            let error = Curve::parse(text, &[1, 3]).unwrap_err();
            assert!(error.starts_with(expected), "{text}: {error}");
        }
        assert_eq!(cases.len(), 9);
        let missing = Lamp::read("led.csv", Path::new("nowhere"))
            .unwrap_err()
            .to_string();
        assert!(
            missing.contains("LED-B5") && missing.contains("led.csv"),
            "{missing}"
        );
    }
}
