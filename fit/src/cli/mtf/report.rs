//! Measurement and summary of one photograph by `fit mtf`.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::cli::failure::Failure;
use edges::photographs::crossing::{Curve, Measured};
use edges::photographs::edge::fault::Accepted;
use edges::photographs::edge::fault::Fault;
use edges::photographs::edge::slant;
use edges::photographs::edge::slant::Slant;
use edges::photographs::photo;
use edges::photographs::photo::channel::Decode;
use edges::photographs::photo::plane::Photo;
use edges::photographs::{Measurement, Roi, measure};

/// Number of points of the curve, from frequency 0 to the sampling frequency.
const POINTS: usize = 512;

/// Wishes that hold for every photograph.
pub(crate) struct Request {
    /// Channel of the files, and meaning of their integers.
    pub decode: Decode,
    /// Region that holds the edge.
    pub roi: Option<Roi>,
    /// Faults that are accepted.
    pub accept: Vec<Accepted>,
    /// Side of a pixel, mm. With it frequencies are in 1/mm, else in cycles per pixel.
    pub pitch_mm: Option<f64>,
    /// Frequencies at which the MTF is named, in the unit in use.
    pub at: Vec<f64>,
}

impl Request {
    /// Returns the unit in use.
    pub(crate) fn unit(&self) -> &'static str {
        if self.pitch_mm.is_some() {
            "1/mm"
        } else {
            "cycles/pixel"
        }
    }

    /// Returns a frequency of the unit in use in cycles per pixel.
    fn per_pixel(&self, frequency: f64) -> f64 {
        frequency * self.pitch_mm.unwrap_or(1.0)
    }

    /// Refuses frequencies above the sampling frequency, where no curve is.
    ///
    /// # Errors
    /// Returns [`Failure::Frequency`] with the first such frequency.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        let above = |frequency: &&f64| self.per_pixel(**frequency) > 1.0;
        match self.at.iter().find(above) {
            Some(&frequency) => Err(Failure::Frequency {
                frequency,
                most: 1.0 / self.pitch_mm.unwrap_or(1.0),
                unit: self.unit(),
            }),
            None => Ok(()),
        }
    }
}

/// A frequency with its standard error, in both units.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Frequency {
    /// In cycles per pixel.
    pub cycles_per_pixel: f64,
    /// Standard error in cycles per pixel.
    pub cycles_per_pixel_standard_error: f64,
    /// In 1/mm; only with a pixel pitch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub per_mm: Option<f64>,
    /// Standard error in 1/mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub per_mm_standard_error: Option<f64>,
}

/// The MTF at a frequency that was asked for.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct At {
    /// In cycles per pixel.
    pub cycles_per_pixel: f64,
    /// In 1/mm; only with a pixel pitch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub per_mm: Option<f64>,
    /// The MTF there.
    pub mtf: f64,
    /// Standard error of the MTF.
    pub standard_error: f64,
}

/// Measurement of one photograph.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    /// File of the photograph, as it was named.
    pub image: String,
    /// Relation of the file's values to light that was taken, and what named it.
    pub transfer: String,
    pub transfer_from: String,
    pub edge_angle_deg: f64,
    pub edge_angle_standard_error_deg: f64,
    /// Angle between the edge and the nearer of rows and columns.
    pub edge_tilt_deg: f64,
    pub edge_offset_px: f64,
    /// Height of the curve that the edge follows, and its order; 0 and 1 for a straight edge.
    pub edge_bow_px: f64,
    pub edge_order: usize,
    pub contrast: f64,
    pub pixel_noise: [f64; 2],
    /// Contrast over the root mean square of the noise of dark and bright pixels.
    pub signal_to_noise: f64,
    pub frequency_unit: &'static str,
    /// In `frequency_unit`, as the four keys that follow.
    pub mtf50: Option<f64>,
    pub mtf50_standard_error: Option<f64>,
    pub mtf10: Option<f64>,
    pub mtf10_standard_error: Option<f64>,
    /// Only with a pixel pitch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mtf50_per_mm: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mtf10_per_mm: Option<f64>,
    pub mtf50_cycles_per_pixel: Option<f64>,
    pub mtf10_cycles_per_pixel: Option<f64>,
    pub at: Vec<At>,
    pub frequency: Vec<f64>,
    pub mtf: Vec<f64>,
    pub standard_error: Vec<f64>,
    pub warnings: Vec<String>,
    /// MTF50 and MTF10 in both units.
    #[serde(skip)]
    pub levels: [Option<Frequency>; 2],
}

/// Reads a photograph and measures its edge and its MTF, up to the sampling frequency.
///
/// # Errors
/// Fails if the photograph cannot be read, if the region does not lie in it, or if it holds no edge
/// that can be measured.
pub(crate) fn measured(image: &Path, request: &Request) -> Result<Report, Failure> {
    of_photo(image, &photo::load(image, &request.decode)?, request)
}

/// Measures the edge and the MTF of a photograph in memory; `image` is its name for messages.
///
/// # Errors
/// Fails as [`measured`] does.
pub(crate) fn of_photo(image: &Path, photo: &Photo, request: &Request) -> Result<Report, Failure> {
    let outside = |roi: &Roi| !roi.fits(photo.width, photo.height);
    if let Some(roi) = request.roi.filter(outside) {
        return Err(Failure::Roi {
            image: image.to_owned(),
            roi,
            width: photo.width,
            height: photo.height,
            turned: photo.is_turned(),
        });
    }
    let edge = |fault| Failure::Edge {
        image: PathBuf::from(image),
        fault,
    };
    let measurement = slanted(photo, request).map_err(edge)?;
    Ok(report(image, photo, measurement, request))
}

/// Measures the edge, and refuses one that is aligned with the pixels.
fn slanted(photo: &Photo, request: &Request) -> Result<Measurement, Fault> {
    let mut measurement = measure::edge(photo, request.roi, &request.accept)?;
    measurement.even_enough()?;
    let slant = Slant::of(&measurement.line, &measurement.window);
    measurement.warnings.extend(slant.check()?);
    Ok(measurement)
}

fn report(image: &Path, photo: &Photo, measurement: Measurement, request: &Request) -> Report {
    let Measurement { line, profile, .. } = &measurement;
    let pitch = request.pitch_mm.unwrap_or(1.0);
    let curve = Curve::new(profile, pitch, POINTS);
    let (dark, bright) = profile.plateaus();
    let [noise_dark, noise_bright] = profile.noise;
    let in_mm = |value: f64| request.pitch_mm.map(|_| value);
    let found = [0.5, 0.1].map(|level| curve.falls_to(level));
    let levels = found.map(|found| {
        found.map(|found: Measured| Frequency {
            cycles_per_pixel: found.value * pitch,
            cycles_per_pixel_standard_error: found.standard_error * pitch,
            per_mm: in_mm(found.value),
            per_mm_standard_error: in_mm(found.standard_error),
        })
    });
    let at = request.at.iter().filter_map(|&frequency| {
        let found = curve.at(frequency)?;
        Some(At {
            cycles_per_pixel: request.per_pixel(frequency),
            per_mm: in_mm(frequency),
            mtf: found.value,
            standard_error: found.standard_error,
        })
    });
    let [half, tenth] = found;
    let lined_up = half
        .and_then(|half| slant::lined_up(profile, half.value * pitch, half.standard_error * pitch));
    Report {
        image: image.display().to_string(),
        transfer: photo.transfer.name.clone(),
        transfer_from: photo.transfer.from.clone(),
        edge_angle_deg: line.normal_rad.to_degrees(),
        edge_angle_standard_error_deg: line.normal_standard_error_rad.to_degrees(),
        edge_tilt_deg: line.tilt_deg(),
        edge_offset_px: line.offset_px,
        edge_bow_px: line.bow_px(),
        edge_order: line.bend.map_or(1, |bend| bend.order),
        contrast: bright - dark,
        pixel_noise: profile.noise,
        signal_to_noise: (bright - dark) / (0.5_f64.sqrt() * noise_dark.hypot(noise_bright)),
        frequency_unit: request.unit(),
        mtf50: half.map(|half| half.value),
        mtf50_standard_error: half.map(|half| half.standard_error),
        mtf10: tenth.map(|tenth| tenth.value),
        mtf10_standard_error: tenth.map(|tenth| tenth.standard_error),
        mtf50_per_mm: half.and_then(|half| in_mm(half.value)),
        mtf10_per_mm: tenth.and_then(|tenth| in_mm(tenth.value)),
        mtf50_cycles_per_pixel: half.map(|half| half.value * pitch),
        mtf10_cycles_per_pixel: tenth.map(|tenth| tenth.value * pitch),
        at: at.collect(),
        frequency: curve.frequency,
        mtf: curve.modulus,
        standard_error: curve.standard_error,
        warnings: measurement.warnings.into_iter().chain(lined_up).collect(),
        levels,
    }
}

impl Report {
    /// Returns the summary of the photograph for a reader, a few lines.
    pub(crate) fn summary(&self) -> String {
        let mut text = String::new();
        for (name, level) in ["MTF50", "MTF10"].into_iter().zip(&self.levels) {
            let _ = match level {
                Some(level) => writeln!(text, "{name}     {level}"),
                None => writeln!(text, "{name}     not reached, or lost in noise"),
            };
        }
        for at in &self.at {
            let mm = at.per_mm.map(|f| format!(" ({f} 1/mm)"));
            let mm = mm.unwrap_or_default();
            let _ = writeln!(
                text,
                "MTF at    {} cycles/pixel{mm}: {:.4} +- {:.4}",
                at.cycles_per_pixel, at.mtf, at.standard_error
            );
        }
        let bow = if self.edge_order > 1 {
            format!(
                "bow {:.2} pixels (order {})",
                self.edge_bow_px, self.edge_order
            )
        } else {
            "straight".into()
        };
        let _ = writeln!(
            text,
            "edge      normal {:.3} deg, {:.2} deg off the pixel grid, {bow}",
            self.edge_angle_deg, self.edge_tilt_deg
        );
        let _ = writeln!(
            text,
            "contrast  {:.5}, signal-to-noise ratio {:.0}",
            self.contrast, self.signal_to_noise
        );
        let _ = write!(text, "read as   {} ({})", self.transfer, self.transfer_from);
        text
    }

    /// Returns the curve as CSV.
    pub(crate) fn csv(&self) -> String {
        let column = if self.frequency_unit == "1/mm" {
            "frequency_per_mm"
        } else {
            "cycles_per_pixel"
        };
        let mut csv = format!("{column},mtf,standard_error\n");
        let rows = self
            .frequency
            .iter()
            .zip(&self.mtf)
            .zip(&self.standard_error);
        for ((f, m), e) in rows {
            let _ = writeln!(csv, "{f:.6},{m:.6},{e:.6}");
        }
        csv
    }
}

impl std::fmt::Display for Frequency {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (value, error) = (self.cycles_per_pixel, self.cycles_per_pixel_standard_error);
        write!(out, "{value:.5} +- {error:.5} cycles/pixel")?;
        match (self.per_mm, self.per_mm_standard_error) {
            (Some(value), Some(error)) => write!(out, ", {value:.4} +- {error:.4} 1/mm"),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lab::planted::{photo, rise, with_noise};

    const DARK: f64 = 0.1;
    const BRIGHT: f64 = 0.7;

    /// The numbers of a report about an edge that is known: a Gaussian of 1.5 pixels between two
    /// plateaus, in even noise. Its MTF is exp(-2 (pi sigma f)^2). The plateaus are means of some
    /// thousand pixels, and the noise is known to a hundredth; five standard errors are allowed.
    #[test]
    fn a_report_has_the_numbers_of_a_known_edge() {
        const SIGMA_PX: f64 = 1.5;
        const PITCH_MM: f64 = 0.05;
        const NOISE: f64 = 0.001;
        let (sin, cos) = 5.0_f64.to_radians().sin_cos();
        let picture = photo(240, 200, |x, y| {
            let s = (x - 120.3) * cos + (y - 99.1) * sin;
            DARK + (BRIGHT - DARK) * rise(s, SIGMA_PX)
        });
        let picture = with_noise(picture, 4, NOISE);
        let request = |pitch_mm: Option<f64>| Request {
            decode: Decode::default(),
            roi: None,
            accept: Vec::new(),
            pitch_mm,
            at: vec![0.2 / pitch_mm.unwrap_or(1.0)],
        };
        let [plain, scaled] = [None, Some(PITCH_MM)].map(|pitch_mm| {
            of_photo(Path::new("edge"), &picture, &request(pitch_mm)).expect("there is an edge")
        });
        let contrast = BRIGHT - DARK;
        assert!((plain.contrast - contrast).abs() < 5.0 * NOISE / 1000.0_f64.sqrt());
        for noise in plain.pixel_noise {
            assert!((noise / NOISE - 1.0).abs() < 0.05, "{noise}");
        }
        let ratio = plain.signal_to_noise * NOISE / contrast;
        assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
        let falls = |level: f64| (-0.5 * level.ln()).sqrt() / (std::f64::consts::PI * SIGMA_PX);
        for (k, level) in [0.5_f64, 0.1].into_iter().enumerate() {
            let [own, in_mm] = [&plain, &scaled].map(|report| report.levels[k].expect("it falls"));
            let error = own.cycles_per_pixel_standard_error;
            assert!(
                (own.cycles_per_pixel - falls(level)).abs() < 5.0 * error,
                "{own}"
            );
            assert!(own.per_mm.is_none() && error < 0.01 * falls(level), "{own}");
            // Both are measured in their own unit, on the same curve: rounding alone differs.
            for (found, expected) in [
                (Some(in_mm.cycles_per_pixel), own.cycles_per_pixel),
                (Some(in_mm.cycles_per_pixel_standard_error), error),
                (in_mm.per_mm, own.cycles_per_pixel / PITCH_MM),
                (in_mm.per_mm_standard_error, error / PITCH_MM),
                (
                    [scaled.mtf50_per_mm, scaled.mtf10_per_mm][k],
                    own.cycles_per_pixel / PITCH_MM,
                ),
                (
                    [scaled.mtf50, scaled.mtf10][k],
                    own.cycles_per_pixel / PITCH_MM,
                ),
                (
                    [scaled.mtf50_standard_error, scaled.mtf10_standard_error][k],
                    error / PITCH_MM,
                ),
                ([plain.mtf50, plain.mtf10][k], own.cycles_per_pixel),
                (
                    [plain.mtf50_standard_error, plain.mtf10_standard_error][k],
                    error,
                ),
            ] {
                let found = found.expect("it is there");
                assert!(
                    (found / expected - 1.0).abs() < 1e-9,
                    "{level}: {found} {expected}"
                );
            }
        }
        let [one, other] = [&plain.at[0], &scaled.at[0]];
        let known = (-2.0 * (std::f64::consts::PI * SIGMA_PX * 0.2).powi(2)).exp();
        assert!(
            (one.mtf - known).abs() < 5.0 * one.standard_error,
            "{one:?}"
        );
        assert!((one.cycles_per_pixel - 0.2).abs() < 1e-12 && one.per_mm.is_none());
        assert!((other.cycles_per_pixel - 0.2).abs() < 1e-12);
        assert!((other.per_mm.expect("there is a pitch") - 4.0).abs() < 1e-12);
        assert!((other.mtf / one.mtf - 1.0).abs() < 1e-9);
        assert!((other.standard_error / one.standard_error - 1.0).abs() < 1e-9);
    }
}
