//! Numbers of several sheets under the same conditions.

use rayon::prelude::*;
use serde::Serialize;

use crate::error::Error;
use crate::images::RenderProgress;
use crate::images::progress::Pieces;
use estimator::predict::{
    Criterion, Fitted, Legibility, Letter, Viewing, Viewpoint, between, legibility, remarks,
};
use estimator::result::agreement::{Agreement, agreement};
use estimator::result::{Number, ResultFile};

/// Sheet of a comparison.
#[derive(Debug, Clone)]
pub struct Contender<'a> {
    /// Name, unlike that of all others.
    pub name: String,
    /// Result and table.
    pub sheet: Fitted<'a>,
    /// Azimuth, degrees; `None` for a mean table.
    pub azimuth_deg: Option<f64>,
}

/// Place and light that are the same for all sheets.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Conditions {
    /// Distance R: optical path from the sheet to the image, mm.
    pub floating_distance_mm: f64,
    /// Incidences, degrees.
    pub incidence_deg: Vec<f64>,
    /// Ambient light and distance of the viewer.
    pub viewing: Viewing,
    /// Luminance of the white of the source, cd/m2; `None` if only ratios to it are wanted.
    pub source_cd_m2: Option<f64>,
    /// Height of the capital letters that have to be readable, mm.
    pub letter_mm: Option<f64>,
}

/// What is known of one sheet.
#[derive(Debug, Clone, Serialize)]
pub struct Compared {
    /// Name of the sheet.
    pub name: String,
    /// What can be read at each incidence.
    pub at: Vec<Legibility>,
    /// Numbers divided by those of the first sheet, at each incidence; empty for the first sheet.
    pub ratio: Vec<Ratio>,
    /// Ranges of incidence in which the letters that were asked for are readable, degrees; null
    /// without such letters.
    pub readable_deg: Option<Vec<[f64; 2]>>,
    /// Smallest letter that is readable over the whole range of the incidences; null for a single
    /// incidence.
    pub everywhere: Option<Everywhere>,
    /// The same numbers at every degree of the table, for charts.
    #[serde(skip)]
    pub curve: Vec<Legibility>,
}

/// Smallest letter that is readable over a range of incidence, in the ambient light if there is any.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Everywhere {
    /// Its height, mm; null if some incidence has no readable letter.
    pub height_mm: Option<f64>,
    /// Incidence that decides, degrees: that of the largest letter, or the first one without any.
    pub decided_at_deg: f64,
}

/// Numbers divided by those of another sheet. Their errors are taken as independent.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Ratio {
    /// Luminance without ambient light.
    pub luminance: Number,
    /// MTF50.
    pub mtf50_per_mm: Number,
    /// Smallest letter without ambient light.
    pub letter_in_the_dark: Number,
    /// Smallest letter in the ambient light.
    pub letter: Number,
}

/// Sheets under the same conditions.
#[derive(Debug, Clone, Serialize)]
pub struct Comparison {
    /// The conditions.
    pub conditions: Conditions,
    /// When a letter is readable.
    pub criterion: Criterion,
    /// Height of the smallest letter for the eye of the viewer, mm.
    pub eye_mm: f64,
    /// The sheets, in the order in which they were named.
    pub sheets: Vec<Compared>,
    /// Parameters of results whose cell and kernel are the same, compared with each other.
    pub agreement: Vec<Agreement>,
    /// Names of the sheets that nobody measured.
    pub nominal: Vec<String>,
    /// What these sheets are and what is assumed of them, one text each.
    pub assumptions: Vec<String>,
    /// Other warnings, one sentence each.
    pub warnings: Vec<String>,
}

/// Compares sheets under the same conditions. Ratios are to the first one.
///
/// # Errors
/// Returns [`Error::Contender`] if a table lacks an incidence, or a result a parameter of the blur.
pub fn compare(
    sheets: &[Contender<'_>],
    conditions: Conditions,
    progress: RenderProgress<'_>,
) -> Result<Comparison, Error> {
    let mut compared: Vec<Compared> = Vec::new();
    let (mut assumptions, mut warnings) = (Vec::new(), Vec::new());
    let degrees: Vec<Vec<f64>> = sheets.iter().map(Contender::degrees).collect();
    let places = sheets.len() * conditions.incidence_deg.len();
    let places = places + degrees.iter().map(Vec::len).sum::<usize>();
    let done = Pieces::new(progress, "directions", places);
    for (own, degrees) in sheets.iter().zip(&degrees) {
        let at = own.named(own.all(&conditions.incidence_deg, &conditions, &done))?;
        let curve = own.named(own.all(degrees, &conditions, &done))?;
        let readable_deg = (conditions.letter_mm)
            .map(|letter_mm| own.named(own.readable(&curve, letter_mm, &conditions)))
            .transpose()?;
        let ratio = compared.first().map_or(Vec::new(), |first| {
            let pairs = at.iter().zip(&first.at);
            pairs.map(|(own, other)| Ratio::of(own, other)).collect()
        });
        let [assumed, others] = own.named(own.warnings(&at))?;
        assumptions.extend(assumed);
        warnings.extend(others);
        warnings.extend(own.turned(&at));
        compared.push(Compared {
            name: own.name.clone(),
            everywhere: Everywhere::of(&at, &curve),
            at,
            ratio,
            readable_deg,
            curve,
        });
    }
    warnings.extend(half_mirrors(sheets));
    let nominal = sheets.iter().filter(|own| own.sheet.result.is_nominal());
    Ok(Comparison {
        criterion: Criterion::USUAL,
        eye_mm: conditions.viewing.eye_mm(),
        conditions,
        sheets: compared,
        agreement: agreements(sheets),
        nominal: nominal.map(|own| own.name.clone()).collect(),
        assumptions,
        warnings,
    })
}

impl Contender<'_> {
    /// Returns every degree of the table.
    fn degrees(&self) -> Vec<f64> {
        let table = &self.sheet.table.axes.incidence_deg;
        let (first, last) = (table[0], table[table.len() - 1]);
        let steps = (last - first).floor() as usize;
        (0..=steps).map(|k| first + k as f64).collect()
    }

    fn place(&self, incidence_deg: f64, conditions: &Conditions) -> Viewpoint {
        Viewpoint {
            incidence_deg,
            azimuth_deg: self.azimuth_deg,
            r_mm: conditions.floating_distance_mm,
        }
    }

    fn at(
        &self,
        incidence_deg: f64,
        conditions: &Conditions,
    ) -> Result<Legibility, estimator::Error> {
        let place = self.place(incidence_deg, conditions);
        legibility(&self.sheet, &place, &conditions.viewing)
    }

    fn all(
        &self,
        incidence_deg: &[f64],
        conditions: &Conditions,
        done: &Pieces<'_>,
    ) -> Result<Vec<Legibility>, estimator::Error> {
        let at = |&deg: &f64| {
            let own = self.at(deg, conditions);
            done.one();
            own
        };
        incidence_deg.par_iter().map(at).collect()
    }

    /// Returns the ranges of incidence in which letters of a height are readable. Their ends
    /// between the places of `curve` are found by bisection.
    fn readable(
        &self,
        curve: &[Legibility],
        letter_mm: f64,
        conditions: &Conditions,
    ) -> Result<Vec<[f64; 2]>, estimator::Error> {
        const FINE_DEG: f64 = 0.05;
        let is_readable = |at: &Legibility| {
            let height = at.letter.and_then(|letter| letter.height_mm.value);
            height.is_some_and(|height| height <= letter_mm)
        };
        let mut ranges: Vec<[f64; 2]> = Vec::new();
        let mut before: Option<(&Legibility, bool)> = None;
        for at in curve {
            let here = is_readable(at);
            let edge = match before {
                Some((other, was)) if was != here => {
                    let mut ends = [other.incidence_deg, at.incidence_deg];
                    while ends[1] - ends[0] > FINE_DEG {
                        let middle = 0.5 * (ends[0] + ends[1]);
                        let same = is_readable(&self.at(middle, conditions)?) == was;
                        ends[usize::from(!same)] = middle;
                    }
                    0.5 * (ends[0] + ends[1])
                }
                _ => at.incidence_deg,
            };
            match (before.is_some_and(|(_, was)| was), here, ranges.last_mut()) {
                (true, _, Some(range)) => range[1] = edge,
                (false, true, _) => ranges.push([edge, at.incidence_deg]),
                _ => {}
            }
            before = Some((at, here));
        }
        Ok(ranges)
    }

    /// Returns what is assumed of a nominal sheet, and the other warnings about a sheet at some
    /// places, with its name if they do not have it.
    fn warnings(&self, at: &[Legibility]) -> Result<[Vec<String>; 2], estimator::Error> {
        let places: Vec<Viewpoint> = at
            .iter()
            .map(|own| Viewpoint {
                incidence_deg: own.incidence_deg,
                azimuth_deg: own.azimuth_deg,
                r_mm: own.floating_distance_mm,
            })
            .collect();
        let mut warnings = remarks(self.sheet.result, self.sheet.table, &places)?;
        let interpolated = at.iter().filter(|own| own.interpolated);
        let interpolated = interpolated.map(|own| (own.incidence_deg, own.retroreflected));
        warnings.extend(between(&self.sheet, interpolated));
        let result = self.sheet.result;
        let is_assumed = |text: &String| result.is_nominal() && result.warnings.contains(text);
        let (assumed, others): (Vec<String>, Vec<String>) =
            warnings.into_iter().partition(is_assumed);
        let named = |text: String| match text.starts_with(&self.name) {
            true => text,
            false => format!("{}: {text}", self.name),
        };
        Ok([assumed, others].map(|texts| texts.into_iter().map(named).collect()))
    }

    /// Warns if the sheet would be far brighter when it is turned about its normal, at the place
    /// where that helps most.
    fn turned(&self, at: &[Legibility]) -> Option<String> {
        const FAR_BRIGHTER: f64 = 2.0;
        const STEP_DEG: f64 = 10.0;
        let own_deg = self.azimuth_deg?;
        let table = self.sheet.table;
        let period = 360.0 / f64::from(table.provenance.symmetry.rotations.max(1));
        let mut best: Option<(f64, String)> = None;
        for own in at {
            for k in 1..(period / STEP_DEG).round() as usize {
                let turn = k as f64 * STEP_DEG;
                // A table of few azimuths does not tell.
                let Ok(other) = table.direction(own.incidence_deg, Some(own_deg + turn)) else {
                    continue;
                };
                let gain = other.retroreflected / own.retroreflected.max(1e-12);
                if gain > FAR_BRIGHTER && best.as_ref().is_none_or(|(most, _)| gain > *most) {
                    let times = match own.retroreflected > 1e-3 {
                        true => format!("{gain:.1} times as bright"),
                        false => "no longer dark".into(),
                    };
                    let deg = own.incidence_deg;
                    let said = format!(
                        "{}: turned by {turn} deg about its normal (--azimuth {}) the sheet is \
                        {times} at incidence {deg} deg",
                        self.name,
                        own_deg + turn
                    );
                    best = Some((gain, said));
                }
            }
        }
        best.map(|(_, said)| said)
    }

    /// Adds the name of the sheet to an error.
    fn named<T>(&self, found: Result<T, estimator::Error>) -> Result<T, Error> {
        found.map_err(|error| Error::Contender(self.name.clone(), error))
    }
}

impl Everywhere {
    /// Returns the largest letter at all places `at`, and at those of `curve` between them; `None`
    /// for a single place.
    fn of(at: &[Legibility], curve: &[Legibility]) -> Option<Everywhere> {
        let degrees = || at.iter().map(|own| own.incidence_deg);
        let first = degrees().fold(f64::INFINITY, f64::min);
        let last = degrees().fold(f64::NEG_INFINITY, f64::max);
        let between = curve
            .iter()
            .filter(|own| (first..=last).contains(&own.incidence_deg));
        let mut all: Vec<&Legibility> = at.iter().chain(between).collect();
        all.sort_by(|a, b| a.incidence_deg.total_cmp(&b.incidence_deg));
        let mut most: Option<(f64, f64)> = None;
        for own in all.into_iter().filter(|_| first < last) {
            let letter = own.letter.unwrap_or(own.letter_in_the_dark);
            let Some(height) = letter.height_mm.value else {
                return Some(Everywhere {
                    height_mm: None,
                    decided_at_deg: own.incidence_deg,
                });
            };
            if most.is_none_or(|(largest, _)| height > largest) {
                most = Some((height, own.incidence_deg));
            }
        }
        most.map(|(height, deg)| Everywhere {
            height_mm: Some(height),
            decided_at_deg: deg,
        })
    }
}

impl Ratio {
    fn of(own: &Legibility, other: &Legibility) -> Ratio {
        let height = |letter: Option<Letter>| letter.map_or(Number::UNKNOWN, |own| own.height_mm);
        Ratio {
            luminance: ratio(own.luminance, other.luminance),
            mtf50_per_mm: ratio(own.mtf50_per_mm, other.mtf50_per_mm),
            letter_in_the_dark: ratio(
                own.letter_in_the_dark.height_mm,
                other.letter_in_the_dark.height_mm,
            ),
            letter: ratio(height(own.letter), height(other.letter)),
        }
    }
}

/// Divides two numbers with independent errors, to first order. A number without an error adds
/// none; without both the ratio has none.
fn ratio(own: Number, other: Number) -> Number {
    let (Some(a), Some(b)) = (own.value, other.value) else {
        return Number::UNKNOWN;
    };
    if b == 0.0 {
        return Number::UNKNOWN;
    }
    let parts = [(own, a), (other, b)].map(|(number, value)| {
        let error = number.standard_error?;
        (value != 0.0).then(|| error / value)
    });
    let relative = match parts {
        [None, None] => None,
        [a, b] => Some(a.unwrap_or(0.0).hypot(b.unwrap_or(0.0))),
    };
    Number {
        value: Some(a / b),
        standard_error: relative.map(|relative| relative * (a / b).abs()),
    }
}

/// Returns a warning if the half mirrors of the sheets differ, because luminances hold them.
fn half_mirrors(sheets: &[Contender<'_>]) -> Option<String> {
    let first = sheets.first()?;
    let own = |sheet: &Contender<'_>| sheet.sheet.result.half_mirror;
    let other = sheets.iter().find(|sheet| own(sheet) != own(first))?;
    Some(format!(
        "the half mirror of {} passes {:.3} of the light (transmittance times reflectance), that \
        of {} {:.3}: luminances hold this difference, which is none of the sheets; give both the \
        same half mirror ([setup] of captures.toml)",
        first.name,
        own(first),
        other.name,
        own(other)
    ))
}

/// Compares the parameters of fits whose cell and kernel are those of the first of them.
fn agreements(sheets: &[Contender<'_>]) -> Vec<Agreement> {
    let fits = sheets.iter().map(|own| own.sheet.result);
    let mut rest: Vec<&ResultFile> = fits.filter(|own| !own.is_by_hand()).collect();
    let mut all = Vec::new();
    while let Some(&first) = rest.first() {
        let same = |own: &&ResultFile| {
            own.kernel == first.kernel
                && own.lobe == first.lobe
                && own.table.same_cell(&first.table)
        };
        let (group, others) = rest.into_iter().partition::<Vec<_>, _>(same);
        all.extend(agreement(&group));
        rest = others;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 6 +- 3 % over 2 +- 4 % is 3 +- 5 %; rounding is below 1e-15.
    #[test]
    fn relative_errors_of_a_ratio_are_added_as_squares() {
        let number = |value: f64, part: Option<f64>| Number {
            value: Some(value),
            standard_error: part.map(|part| part * value),
        };
        let found = ratio(number(6.0, Some(0.03)), number(2.0, Some(0.04)));
        assert_eq!(found.value, Some(3.0));
        let error = found.standard_error.expect("both have one");
        assert!((error - 0.15).abs() < 1e-14, "{error}");
        let one = ratio(number(6.0, None), number(2.0, Some(0.04)));
        assert!(
            one.standard_error
                .is_some_and(|error| (error - 0.12).abs() < 1e-14)
        );
        assert_eq!(
            ratio(number(6.0, None), number(2.0, None)).standard_error,
            None
        );
        assert_eq!(ratio(number(6.0, None), number(0.0, None)), Number::UNKNOWN);
    }
}
