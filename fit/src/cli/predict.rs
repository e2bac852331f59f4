//! `fit predict`: predicts MTF and luminance of a fitted sheet at other distances and angles.

use std::fmt::Write;
use std::path::PathBuf;
use tables::cli as terminal;

use serde::Serialize;
use tables::{Outputs, Table};

use crate::cli::estimate::{check_model, read_channel};
use crate::cli::failure::Failure;
use crate::cli::options::by_hand::Numbers;
use crate::cli::options::parse;
use crate::cli::output;
use edges::names::{Family, Kernel};
#[cfg(feature = "full")]
use estimator::predict::{Around, around};
use estimator::predict::{Axis, Fitted, Places, Prediction, Viewpoint, between, predict, remarks};
use estimator::result::ResultFile;
#[cfg(feature = "full")]
use pictures::report::Variable;
#[cfg(feature = "full")]
use pictures::report::plot;

/// Predicts MTF and luminance of a fitted sheet at other distances and angles.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The MTF is that of the mid-air image itself, without a camera: tangential
(contrast along the plane of incidence) and sagittal (contrast across it). The
luminance is relative to the source and contains the half mirror. Parameters
that were fitted per angle are interpolated linearly between the fitted angles,
and held constant beyond them.

Intervals hold the truth with 95 % confidence, by the covariance of the result
(CSV: mtf_low, mtf_high; JSON: mtf_interval and others; bands in plots). They do
not hold what the model does not describe. A place outside of the photographs
gets a warning, a name in the column outside, and a dashed line or a shaded
region in plots.

A LIST is 0,5,10 or start:stop:step with both ends, such as 0:45:5.

Examples:
  fit predict result.json --table pair.h5 --distance 150,300 --incidence 0:45:5 \\
      --azimuth 30
  fit predict result.json --table pair.h5 --distance 500 --incidence 20 \\
      --azimuth 30 --plot mtf.svg --json
  fit predict result.json --table pair.h5 --distance 150 --incidence 0:45:5 \\
      --frequency 0.5,1,2 --against incidence --plot against.svg -o against.csv
  fit predict --sheet prism-0.1 --distance 1000,3000 --incidence 0,20
  fit predict --c 0.15 --wavelength-nm 550 --mu 0.5 --table pair.h5 \\
      --distance 3000 --incidence 20 --azimuth 30
  fit predict result.json --table pair.h5 --distance 150 --incidence 20 \\
      --frequency 0.5,1,2 --against direction --plot polar.svg --json -o polar.json

Words and formulas: fit/doc/model.md")]
pub(crate) struct Arguments {
    /// Result that `fit estimate -o` wrote, as JSON.
    ///
    /// Without a fit, give --sheet, or --c and its companions, instead.
    #[arg(required_unless_present = "own_sheet", conflicts_with = "own_sheet")]
    pub result: Option<PathBuf>,
    /// Ray-shift table of the fitted cell, from `bake trace`.
    ///
    /// Give the table of the fit, or one of the same mesh and refractive index with more
    /// directions. A --sheet brings its own.
    #[arg(long, value_name = "TABLE.h5", required_unless_present = "sheet")]
    pub table: Option<PathBuf>,
    /// Floating distances R, mm.
    ///
    /// R is the length of the principal ray from the sheet to the image.
    #[arg(
        long,
        visible_alias = "floating-distance",
        value_name = "LIST",
        value_parser = parse::positives
    )]
    pub distance: std::vec::Vec<f64>,
    /// Incidence angles in the air, degrees.
    #[arg(
        long,
        value_name = "LIST",
        value_parser = parse::incidences,
        allow_negative_numbers = true
    )]
    pub incidence: std::vec::Vec<f64>,
    /// Azimuths of the light, degrees; that of the table if it holds one, 0 for a --sheet.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true, value_parser = parse::turns)]
    pub azimuth: Option<std::vec::Vec<f64>>,
    /// Numbers of a sheet without a fit.
    #[command(flatten)]
    pub by_hand: Numbers,
    /// Channel of a result of several channels: red, green or blue.
    ///
    /// `fit estimate --channel each` writes such results.
    #[arg(long, value_name = "NAME", help_heading = "Result")]
    pub channel: Option<String>,
    /// Spatial frequencies in the image, 1/mm.
    ///
    /// Without this option there are 101, from 0 to where the last of the MTFs is below a tenth.
    #[arg(long, value_name = "LIST", value_parser = parse::not_negatives)]
    pub frequency: Option<std::vec::Vec<f64>>,
    /// Model that is required.
    ///
    /// The command fails if the result is of another model. Without this option, any model will do.
    #[arg(long, value_enum, help_heading = "Result")]
    pub model: Option<Family>,
    /// Writes one JSON object in place of CSV.
    #[arg(long, help_heading = "Output")]
    pub json: bool,
    /// Quantity against which --plot draws the MTF.
    ///
    /// The picture then shows the MTF at each --frequency, in place of MTF curves. direction draws
    /// a polar picture for each place, and adds its curves to the JSON (key around).
    #[cfg(feature = "full")]
    #[arg(long, value_enum, requires = "plot", help_heading = "Output")]
    pub against: Option<Variable>,
    /// File that receives the MTF curves as a picture, .svg.
    #[cfg(feature = "full")]
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub plot: Option<PathBuf>,
    /// File that receives CSV or JSON, in place of standard output.
    #[arg(short, long, value_name = "FILE", help_heading = "Output")]
    pub output: Option<PathBuf>,
}

/// Largest number of frequencies that `--against` draws at each place.
#[cfg(feature = "full")]
const MOST_CURVES: usize = 12;

#[derive(Serialize)]
struct Report<'a> {
    kernel: Kernel,
    frequency_per_mm: &'a [f64],
    predictions: Vec<OldNames<&'a Prediction>>,
    #[cfg(feature = "full")]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    around: Vec<OldNames<Around>>,
    warnings: Vec<String>,
}

/// A prediction whose keys of version 0.1 are written too, so that scripts that read them go on.
#[derive(Serialize)]
struct OldNames<T> {
    #[serde(flatten)]
    prediction: T,
    /// `floating_distance_mm`.
    distance_mm: f64,
    /// `retroreflected`, where the prediction has it.
    #[serde(skip_serializing_if = "Option::is_none")]
    eta: Option<f64>,
}

impl<'a> OldNames<&'a Prediction> {
    fn of_prediction(prediction: &'a Prediction) -> Self {
        OldNames {
            prediction,
            distance_mm: prediction.floating_distance_mm,
            eta: Some(prediction.retroreflected),
        }
    }
}

#[cfg(feature = "full")]
impl OldNames<Around> {
    fn of_around(prediction: Around) -> Self {
        OldNames {
            distance_mm: prediction.floating_distance_mm,
            eta: None,
            prediction,
        }
    }
}

/// Runs the verb.
///
/// # Errors
/// Fails if the result or the table cannot be used, if the table lacks a direction, or if an output
/// cannot be written.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    #[cfg(feature = "full")]
    let many = (arguments.frequency.as_ref()).is_none_or(|all| all.len() > MOST_CURVES);
    #[cfg(feature = "full")]
    if arguments.against.is_some() && many {
        return Err(Failure::conflict(
            "fit predict",
            format!(
                "--against draws a curve for every frequency; name at most {MOST_CURVES} with \
                --frequency"
            ),
        ));
    }
    let inputs = arguments.result.iter().chain(&arguments.table);
    let mut outputs = Outputs::beside(inputs.map(PathBuf::as_path));
    let output = terminal::reserve(arguments.output.as_deref(), &mut outputs)?;
    #[cfg(feature = "full")]
    let picture = terminal::reserve_plot(arguments.plot.as_deref(), &mut outputs)?;
    let numbers = &arguments.by_hand;
    let table = numbers.table("fit predict", arguments.table.as_deref())?;
    let result = match &arguments.result {
        Some(file) => {
            let result = read_channel(file, arguments.channel.as_deref())?;
            check_model(file, &result, arguments.model)?;
            result
        }
        None => numbers.result("fit predict", 1.0, &table)?,
    };
    let found = predicted(arguments, &result, &table)?;
    terminal::warn(&found.warnings);
    #[cfg(feature = "full")]
    if let Some(output) = picture {
        let frequencies = &found.frequency_per_mm;
        let svg = match arguments.against {
            Some(Variable::Direction) => plot::around(&found.around, frequencies),
            Some(variable) => plot::against(&found.predictions, frequencies, variable),
            None => plot::predicted(&found.predictions, frequencies),
        };
        output.commit(svg.as_bytes())?;
    }
    let text = if arguments.json {
        found.json(&result)
    } else {
        csv(&found.predictions, &found.frequency_per_mm)
    };
    Ok(terminal::deliver(&text, output)?)
}

/// Predictions that the options ask for, with the warnings about them.
pub(super) struct Predicted {
    frequency_per_mm: Vec<f64>,
    predictions: Vec<Prediction>,
    #[cfg(feature = "full")]
    around: Vec<Around>,
    warnings: Vec<String>,
}

impl Predicted {
    /// Returns the predictions as JSON.
    pub(super) fn json(self, result: &ResultFile) -> String {
        output::json(&Report {
            kernel: result.kernel,
            frequency_per_mm: &self.frequency_per_mm,
            predictions: self
                .predictions
                .iter()
                .map(OldNames::of_prediction)
                .collect(),
            #[cfg(feature = "full")]
            around: self.around.into_iter().map(OldNames::of_around).collect(),
            warnings: self.warnings,
        })
    }
}

/// Predicts what the options ask for.
///
/// # Errors
/// Returns [`Failure::Estimator`] if the table lacks a direction.
pub(super) fn predicted(
    arguments: &Arguments,
    result: &ResultFile,
    table: &Table,
) -> Result<Predicted, Failure> {
    let table = &*result.seen(table)?;
    let mut places = Places {
        floating_distance_mm: arguments.distance.clone(),
        incidence_deg: arguments.incidence.clone(),
        azimuth_deg: parse::usual_azimuth(table, result),
        frequency_per_mm: Vec::new(),
    };
    let mut predictions = Vec::new();
    #[cfg(feature = "full")]
    let mut polar = Vec::new();
    let azimuths = arguments.azimuth.iter().flatten().copied().map(Some);
    let azimuths: Vec<Option<f64>> = azimuths.collect();
    let azimuths = match azimuths.is_empty() {
        true => vec![places.azimuth_deg],
        false => azimuths,
    };
    places.frequency_per_mm = match &arguments.frequency {
        Some(listed) => listed.iter().map(|f| f.abs()).collect(),
        None => {
            let mut found = Vec::new();
            for &azimuth_deg in &azimuths {
                places.azimuth_deg = azimuth_deg;
                found.extend(predict(result, table, &places)?);
            }
            usual_frequencies(&found)
        }
    };
    for azimuth_deg in azimuths {
        places.azimuth_deg = azimuth_deg;
        predictions.extend(predict(result, table, &places)?);
        #[cfg(feature = "full")]
        if arguments.against == Some(Variable::Direction) {
            polar.extend(around(result, table, &places)?);
        }
    }
    let at: Vec<Viewpoint> = predictions.iter().map(Prediction::place).collect();
    let mut warnings = remarks(result, table, &at)?;
    if arguments.azimuth.is_some() && table.axes.is_mean() {
        warnings.push("the table is a mean over azimuths: --azimuth has no effect".into());
    }
    let interpolated = predictions.iter().filter(|own| own.interpolated);
    let interpolated = interpolated.map(|own| (own.incidence_deg, own.retroreflected));
    warnings.extend(between(&Fitted::new(result, table)?, interpolated));
    if predictions.iter().all(|own| own.retroreflected == 0.0) {
        warnings.push(
            "nothing is returned at any of these places: the table's cell sends no light straight \
            back there"
                .into(),
        );
    }
    Ok(Predicted {
        frequency_per_mm: places.frequency_per_mm,
        predictions,
        #[cfg(feature = "full")]
        around: polar,
        warnings,
    })
}

/// Number of steps of the usual frequencies.
const STEPS: usize = 100;

/// Frequency up to which an MTF is shown that nowhere falls to a tenth, 1/mm.
const SHARP_PER_MM: f64 = 5.0;

/// Returns frequencies from 0 to a round number at which the last of some MTFs is below a tenth,
/// 1/mm.
fn usual_frequencies(predictions: &[Prediction]) -> Vec<f64> {
    // An MTF that is a tenth at f is nearly nothing at 1.25 f.
    let ends = predictions.iter().filter(|own| own.retroreflected > 0.0);
    let ends = ends.map(|own| own.mtf10_per_mm.map_or(SHARP_PER_MM, |f| 1.25 * f));
    let last = ends.fold(0.0, f64::max);
    let last = if last > 0.0 { last } else { SHARP_PER_MM };
    let power = 10_f64.powf(last.log10().floor());
    let round = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0].map(|part| part * power);
    let end = round
        .into_iter()
        .find(|end| *end >= last)
        .unwrap_or(10.0 * power);
    (0..=STEPS).map(|k| end * k as f64 / STEPS as f64).collect()
}

/// Returns CSV with one row per place and frequency. The luminance is 0 and the MTF is empty at
/// places where nothing is retroreflected.
fn csv(predictions: &[Prediction], frequency_per_mm: &[f64]) -> String {
    let mut text = String::from(
        "floating_distance_mm,incidence_deg,azimuth_deg,axis,retroreflected,luminance,\
        frequency_per_mm,mtf,luminance_low,luminance_high,mtf_low,mtf_high,outside\n",
    );
    for p in predictions {
        let axis = if p.axis == Axis::Tangential {
            "tangential"
        } else {
            "sagittal"
        };
        let azimuth = p.azimuth_deg.map_or(String::new(), |a| a.to_string());
        let luminance = p.luminance.map_or(String::new(), |l| format!("{l:.6}"));
        let luminances = ends(p.luminance_interval.as_ref());
        let outside = p.outside.join(" ");
        for (i, &f) in frequency_per_mm.iter().enumerate() {
            let frequency = match f {
                0.001.. | 0.0 => format!("{f:.6}"),
                _ => format!("{f:e}"),
            };
            let mtf = p.mtf.get(i).map_or(String::new(), |m| format!("{m:.6}"));
            let _ = writeln!(
                text,
                "{},{},{azimuth},{axis},{:.6},{luminance},{frequency},{mtf},{luminances},{},\
                {outside}",
                p.floating_distance_mm,
                p.incidence_deg,
                p.retroreflected,
                ends(p.mtf_interval.get(i))
            );
        }
    }
    text
}

/// Returns the ends of an interval as two columns of CSV, empty without an interval.
fn ends(interval: Option<&[f64; 2]>) -> String {
    interval.map_or(",".into(), |[low, high]| format!("{low:.6},{high:.6}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The usual frequencies end at a round number beyond the last MTF10, and at 5 /mm where
    /// nothing falls so far.
    #[test]
    fn usual_frequencies_follow_the_mtf() {
        let of = |falls: &[Option<f64>]| {
            let own = |&mtf10_per_mm: &Option<f64>| Prediction {
                floating_distance_mm: 3000.0,
                incidence_deg: 0.0,
                azimuth_deg: None,
                axis: Axis::Sagittal,
                retroreflected: 0.5,
                interpolated: false,
                luminance: None,
                luminance_interval: None,
                mtf50_per_mm: None,
                mtf50_per_mm_interval: None,
                mtf10_per_mm,
                mtf10_per_mm_interval: None,
                mtf: Vec::new(),
                mtf_interval: Vec::new(),
                outside: Vec::new(),
            };
            usual_frequencies(&falls.iter().map(own).collect::<Vec<_>>())
        };
        let cases: [(&[Option<f64>], f64); 5] = [
            (&[Some(0.021), Some(0.034)], 0.05),
            (&[Some(0.8)], 1.0),
            (&[Some(3.9)], 5.0),
            (&[None, Some(0.1)], 5.0),
            (&[], 5.0),
        ];
        for (falls, end) in cases {
            let found = of(falls);
            assert_eq!((found.len(), found[0]), (101, 0.0));
            assert!(
                (found[100] / end - 1.0).abs() < 1e-12,
                "{falls:?}: {}",
                found[100]
            );
            assert!((found[1] / end - 0.01).abs() < 1e-12);
        }
    }
}
