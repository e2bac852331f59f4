//! Wavelengths of the source and their weights.

use std::fmt;

use serde::{Deserialize, Serialize};

/// One wavelength of a spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectralLine {
    /// Wavelength in vacuum, nm.
    pub wavelength_nm: f64,
    /// Weight of the line relative to the other lines; positive, not normalised.
    pub weight: f64,
}

/// A light source as a sum of one or more lines. Its text in files is, for example,
/// `450:0.2,550:0.5`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Spectrum {
    lines: Vec<SpectralLine>,
}

/// A reason why a text or a number is not a spectrum, with the remedy, to follow its key.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct SpectrumError(String);

/// Greatest number of wavelengths of a spectrum: those of silicon in steps of a nanometre, and some.
/// The time of every verb is proportional to it.
const MOST_LINES: usize = 1000;

/// Greatest ratio of two wavelengths of a spectrum.
///
/// Sources and cameras of silicon span 350 to 1100 nm. The time of a picture grows with the square
/// of the ratio: the shortest wavelength says how fine its transform is, the longest how wide.
const MOST_RATIO: f64 = 5.0;

impl Spectrum {
    /// Returns a spectrum of one line with weight 1.
    ///
    /// # Errors
    /// Returns an error if the wavelength is outside 100 to 20000 nm.
    pub fn monochromatic(wavelength_nm: f64) -> Result<Spectrum, SpectrumError> {
        Ok(Spectrum {
            lines: vec![line(wavelength_nm, 1.0)?],
        })
    }

    /// Reads a spectrum from text such as `550` or `450:0.2,550:0.5,620:0.3`. A line without a
    /// weight has weight 1.
    ///
    /// # Errors
    /// Returns an error about the first wrong entry: one that is not `wavelength` or
    /// `wavelength:weight`, a wavelength outside 100 to 20000 nm, or a weight that is not finite
    /// and positive. It is an error too if one wavelength is more than 5 times another, and if
    /// there are more than 1000.
    pub fn parse(text: &str) -> Result<Spectrum, SpectrumError> {
        let read = |entry: &str| {
            let number = |word: &str| {
                word.trim().parse::<f64>().map_err(|_| {
                    SpectrumError(format!(
                        "has the entry \"{}\", which is not a wavelength such as 550 or a pair such \
                        as 550:0.5; correct it",
                        entry.trim()
                    ))
                })
            };
            match entry.split_once(':') {
                Some((wavelength, weight)) => line(number(wavelength)?, number(weight)?),
                None => line(number(entry)?, 1.0),
            }
        };
        let lines = text.split(',').count();
        if lines > MOST_LINES {
            return Err(SpectrumError(format!(
                "has {lines} wavelengths, above the limit of {MOST_LINES}; merge neighbouring ones"
            )));
        }
        Spectrum::of_lines(text.split(',').map(read).collect::<Result<_, _>>()?)
    }

    /// Returns the spectrum of lines that have been checked one by one, of which there is at least
    /// one.
    pub(crate) fn of_lines(lines: Vec<SpectralLine>) -> Result<Spectrum, SpectrumError> {
        let lengths = || lines.iter().map(|line| line.wavelength_nm);
        let (least_nm, most_nm) = (
            lengths().fold(f64::INFINITY, f64::min),
            lengths().fold(0.0, f64::max),
        );
        if most_nm > MOST_RATIO * least_nm {
            return Err(SpectrumError(format!(
                "mixes {least_nm} nm and {most_nm} nm, but the longest wavelength may be at most 5 \
                times the shortest; correct it, or take each by itself"
            )));
        }
        Ok(Spectrum { lines })
    }

    /// Returns the lines in the order given. There is at least one.
    pub fn lines(&self) -> &[SpectralLine] {
        &self.lines
    }

    /// Returns the mean wavelength, nm, by the weights.
    pub fn mean_nm(&self) -> f64 {
        let sum = |of: fn(&SpectralLine) -> f64| self.lines.iter().map(of).sum::<f64>();
        sum(|line| line.weight * line.wavelength_nm) / sum(|line| line.weight)
    }

    /// Returns whether a wavelength is that of the line, or lies between those of several, within 1
    /// nm.
    pub fn holds(&self, wavelength_nm: f64) -> bool {
        let lengths = || self.lines.iter().map(|line| line.wavelength_nm);
        let least_nm = lengths().fold(f64::INFINITY, f64::min);
        let most_nm = lengths().fold(0.0, f64::max);
        (least_nm - 1.0..=most_nm + 1.0).contains(&wavelength_nm)
    }
}

impl fmt::Display for Spectrum {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, line) in self.lines.iter().enumerate() {
            let comma = if i > 0 { "," } else { "" };
            write!(formatter, "{comma}{}", line.wavelength_nm)?;
            if self.lines.len() > 1 || line.weight != 1.0 {
                write!(formatter, ":{}", line.weight)?;
            }
        }
        Ok(())
    }
}

impl TryFrom<String> for Spectrum {
    type Error = SpectrumError;

    fn try_from(text: String) -> Result<Spectrum, SpectrumError> {
        Spectrum::parse(&text)
    }
}

impl From<Spectrum> for String {
    fn from(spectrum: Spectrum) -> String {
        spectrum.to_string()
    }
}

fn line(wavelength_nm: f64, weight: f64) -> Result<SpectralLine, SpectrumError> {
    if !(100.0..=20_000.0).contains(&wavelength_nm) {
        return Err(SpectrumError(format!(
            "is {wavelength_nm} nm but must be between 100 and 20000 nm; give it in nanometres"
        )));
    }
    if !(weight.is_finite() && weight > 0.0) {
        return Err(SpectrumError(format!(
            "gives {wavelength_nm} nm the weight {weight}, which must be finite and greater than \
            0; correct it"
        )));
    }
    Ok(SpectralLine {
        wavelength_nm,
        weight,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn good_and_bad_spectra() {
        let good = [
            ("550", 1),
            ("450:0.2,550:0.5,620:0.3", 3),
            (" 450 : 1 , 550", 2),
            ("1000,200", 2),
        ];
        for (text, lines) in good {
            assert_eq!(
                Spectrum::parse(text).map(|it| it.lines().len()),
                Ok(lines),
                "{text}"
            );
            let back = Spectrum::parse(text).map(|it| Spectrum::parse(&it.to_string()));
            assert_eq!(back, Ok(Spectrum::parse(text)), "{text}");
        }
        assert_eq!(Spectrum::parse("550"), Spectrum::monochromatic(550.0));
        let bad = [
            "",
            "green",
            "550:",
            "0.55",
            "550:-1",
            "550:nan",
            "nan",
            "450;550",
            "450:1:2",
            "200,10000",
            "1001:1,500:1,200:1",
        ];
        for text in bad {
            assert!(Spectrum::parse(text).is_err(), "{text}");
        }
        let lamp = Spectrum::parse("450:0.2,550,620").unwrap();
        for (nm, is_held) in [(448.9, false), (449.1, true), (500.0, true), (621.5, false)] {
            assert_eq!(lamp.holds(nm), is_held, "{nm}");
        }
        // 1000 wavelengths, and one more.
        let lines = |count| vec!["550"; count].join(",");
        assert!(Spectrum::parse(&lines(1000)).is_ok());
        let many = Spectrum::parse(&lines(1001)).unwrap_err().to_string();
        assert!(many.contains("1001 wavelengths"), "{many}");
    }
}
