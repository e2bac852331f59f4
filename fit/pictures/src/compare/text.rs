//! A comparison as text for a terminal, and as CSV.

use std::fmt::Write;

use crate::compare::comparison::{Compared, Comparison, Conditions};
use crate::report::page::markup::significant;
use estimator::predict::{Legibility, Letter, Limit};
use estimator::result::Number;

/// Digits of a number without an error; one with an error has one more.
const DIGITS: usize = 3;

/// Writes a number, with its standard error if it has one, times a factor.
pub(super) fn number(number: Number, factor: f64) -> String {
    let scaled = [number.value, number.standard_error].map(|part| part.map(|own| own * factor));
    match scaled {
        [None, _] => "-".into(),
        [Some(value), Some(error)] if error > 0.0 => {
            format!("{} \u{b1} {}", significant(value, 4), significant(error, 1))
        }
        [Some(value), _] => significant(value, DIGITS),
    }
}

/// Writes the height of a letter, mm, and what limits it if that is not the blur.
pub(super) fn letter(letter: Option<Letter>) -> String {
    match letter {
        None => "-".into(),
        Some(Letter {
            limit: Limit::Contrast,
            ..
        }) => "none".into(),
        Some(own) => {
            let by = match own.limit {
                Limit::Eye => " (eye)",
                _ => "",
            };
            format!("{}{by}", number(own.height_mm, 1.0))
        }
    }
}

/// Writes a number as it was given, with two decimals at most.
pub(super) fn plain(given: f64) -> String {
    format!("{}", (100.0 * given).round() / 100.0)
}

/// Writes ranges of incidence, degrees.
pub(super) fn ranges(ranges: &[[f64; 2]]) -> String {
    let shown = ranges
        .iter()
        .map(|[from, to]| format!("{from:.1} to {to:.1}"));
    match ranges {
        [] => "nowhere".into(),
        _ => shown.collect::<Vec<_>>().join(", ") + " deg",
    }
}

impl Conditions {
    /// Describes distance, light and viewer in a line.
    pub(super) fn words(&self) -> String {
        let light = match self.source_cd_m2 {
            Some(source) => format!(
                "source {} cd/m\u{b2}, ambient light {} cd/m\u{b2}",
                significant(source, DIGITS),
                significant(source * self.viewing.ambient, DIGITS)
            ),
            None => format!(
                "ambient light {} of the source",
                significant(self.viewing.ambient, DIGITS)
            ),
        };
        format!(
            "{} mm from the sheet, {light}, viewer {} m from the image",
            plain(self.floating_distance_mm),
            plain(1e-3 * self.viewing.viewer_mm)
        )
    }

    /// Returns the unit of luminances, and the factor from ratios to the source to it.
    pub(super) fn luminances(&self) -> (&'static str, f64) {
        match self.source_cd_m2 {
            Some(source) => ("cd/m\u{b2}", source),
            None => ("of the source", 1.0),
        }
    }
}

/// Returns the luminance with the ambient light.
pub(super) fn lit(own: &Legibility, ambient: f64) -> Number {
    Number {
        value: own.luminance.value.map(|light| light + ambient),
        ..own.luminance
    }
}

impl Compared {
    /// Says which letters, mm, are readable over the whole range of incidence, and which incidence
    /// decides.
    pub(super) fn everywhere_in_words(&self) -> String {
        self.everywhere.map_or("-".into(), |own| {
            let deg = plain(own.decided_at_deg);
            match own.height_mm {
                Some(height) => format!("{} (at {deg}\u{b0})", significant(height, DIGITS)),
                None => format!("none at {deg}\u{b0}"),
            }
        })
    }
}

impl Comparison {
    /// Describes distance, light, viewer and azimuth in a line.
    pub(super) fn words(&self) -> String {
        let azimuth = |sheet: &Compared| sheet.at.first().and_then(|at| at.azimuth_deg);
        let first = self.sheets.first().and_then(azimuth);
        let is_shared = self.sheets.iter().all(|sheet| azimuth(sheet) == first);
        let azimuth = first.filter(|_| is_shared).map_or(String::new(), |deg| {
            format!(", azimuth {}\u{b0}", plain(deg))
        });
        self.conditions.words() + &azimuth
    }

    /// Returns the range of incidence in words; `None` for a single incidence.
    pub(super) fn range(&self) -> Option<String> {
        let degrees = &self.conditions.incidence_deg;
        let first = degrees.iter().copied().fold(f64::INFINITY, f64::min);
        let last = degrees.iter().copied().fold(0.0, f64::max);
        (first < last).then(|| format!("{}\u{b0} to {}\u{b0}", plain(first), plain(last)))
    }

    /// Writes the numbers as a table, then ratios, readable ranges and agreement.
    pub fn text(&self) -> String {
        let conditions = &self.conditions;
        let (unit, factor) = conditions.luminances();
        let heads = [
            "incidence",
            "sheet",
            &format!("luminance ({unit})"),
            "with ambient light",
            "contrast",
            "letter in the dark (mm)",
            "letter (mm)",
            "MTF50 (1/mm)",
        ];
        let mut rows = vec![heads.map(String::from).to_vec()];
        for (k, deg) in conditions.incidence_deg.iter().enumerate() {
            for own in &self.sheets {
                let at = &own.at[k];
                rows.push(vec![
                    plain(*deg),
                    own.name.clone(),
                    number(at.luminance, factor),
                    number(lit(at, conditions.viewing.ambient), factor),
                    number(at.contrast, 1.0),
                    letter(Some(at.letter_in_the_dark)),
                    letter(at.letter),
                    number(at.mtf50_per_mm, 1.0),
                ]);
            }
        }
        let mut text = format!("{}\n\n{}", self.words(), aligned(&rows));
        if rows.iter().flatten().any(|cell| cell == "none") {
            let _ = writeln!(
                text,
                "none: strokes of letters of any height stay below a contrast of {}",
                self.criterion.contrast
            );
        }
        text.push_str(&self.ratios());
        if let Some(range) = self.range() {
            let row = |own: &Compared| vec![own.name.clone(), own.everywhere_in_words()];
            let rows: Vec<_> = self.sheets.iter().map(row).collect();
            let _ = write!(
                text,
                "\nsmallest letters (mm) readable at all incidences of {range}:\n{}",
                aligned(&rows)
            );
        }
        if let Some(letter_mm) = conditions.letter_mm {
            let _ = writeln!(text, "\ncapital letters of {letter_mm} mm are readable:");
            let all = self.sheets.iter().map(|own| {
                let found = own.readable_deg.as_deref().unwrap_or_default();
                vec![own.name.clone(), ranges(found)]
            });
            text.push_str(&aligned(&all.collect::<Vec<_>>()));
        }
        text.push_str(&self.agreements());
        text
    }

    /// Says in a sentence which sheets nobody measured; the page and JSON say what is assumed.
    pub fn not_measured(&self) -> Option<String> {
        let are = match self.nominal.len() {
            0 => return None,
            1 => "is no measured sheet",
            _ => "are no measured sheets",
        };
        let names = self.nominal.join(", ");
        Some(format!(
            "{names} {are}; the page (.html) and --json say what is assumed"
        ))
    }

    /// Writes the ratios to the first sheet; nothing for a single one.
    fn ratios(&self) -> String {
        let [first, others @ ..] = &self.sheets[..] else {
            return String::new();
        };
        if others.is_empty() {
            return String::new();
        }
        let heads = [
            "incidence".into(),
            format!("divided by {}", first.name),
            "luminance".into(),
            "letter in the dark".into(),
            "letter".into(),
            "MTF50".into(),
        ];
        let mut rows = vec![heads.to_vec()];
        for (k, deg) in self.conditions.incidence_deg.iter().enumerate() {
            for Compared { name, ratio, .. } in others {
                let own = &ratio[k];
                let cells = [
                    own.luminance,
                    own.letter_in_the_dark,
                    own.letter,
                    own.mtf50_per_mm,
                ];
                let cells = cells.map(|cell| number(cell, 1.0));
                let mut row = vec![plain(*deg), name.clone()];
                row.extend(cells);
                rows.push(row);
            }
        }
        format!("\n{}", aligned(&rows))
    }

    /// Writes how results of one cell agree; nothing without several.
    fn agreements(&self) -> String {
        if self.agreement.is_empty() {
            return String::new();
        }
        let heads = ["results", "parameter", "mean", "chi2", "freedom", "chance"];
        let mut rows = vec![heads.map(String::from).to_vec()];
        rows.extend(self.agreement.iter().map(|own| {
            vec![
                own.results.to_string(),
                own.parameter.to_string(),
                number(own.mean, 1.0),
                significant(own.chi2, DIGITS),
                own.degrees_of_freedom.to_string(),
                significant(own.p_value, 2),
            ]
        }));
        format!(
            "\nresults of the same cell, if they are of one sheet (chance: that noise alone \
             scatters them so far or farther):\n{}",
            aligned(&rows)
        )
    }

    /// Writes CSV with one row per sheet and incidence. What is not known is empty; letters that
    /// are not readable are `inf`.
    pub fn csv(&self) -> String {
        let mut text = String::from(
            "sheet,incidence_deg,azimuth_deg,floating_distance_mm,retroreflected,luminance,\
             luminance_error,luminance_cd_m2,luminance_with_ambient_cd_m2,contrast,contrast_error,\
             letter_in_the_dark_mm,letter_in_the_dark_error_mm,letter_mm,letter_error_mm,\
             mtf50_per_mm,mtf50_error_per_mm\n",
        );
        let bare = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
        let two =
            |number: Number| format!("{},{}", bare(number.value), bare(number.standard_error));
        let letter = |letter: Option<Letter>| match letter {
            None => ",".into(),
            Some(own) if own.limit == Limit::Contrast => "inf,".into(),
            Some(own) => two(own.height_mm),
        };
        let source = self.conditions.source_cd_m2;
        let in_cd_m2 = |share: Option<f64>| bare(share.zip(source).map(|(own, all)| own * all));
        for sheet in &self.sheets {
            let name = match sheet.name.contains([',', '"', '\n']) {
                true => format!("\"{}\"", sheet.name.replace('"', "\"\"")),
                false => sheet.name.clone(),
            };
            for at in &sheet.at {
                let ambient = self.conditions.viewing.ambient;
                let _ = writeln!(
                    text,
                    "{name},{},{},{},{},{},{},{},{},{},{},{}",
                    at.incidence_deg,
                    bare(at.azimuth_deg),
                    at.floating_distance_mm,
                    at.retroreflected,
                    two(at.luminance),
                    in_cd_m2(at.luminance.value),
                    in_cd_m2(lit(at, ambient).value),
                    two(at.contrast),
                    letter(Some(at.letter_in_the_dark)),
                    letter(at.letter),
                    two(at.mtf50_per_mm),
                );
            }
        }
        text
    }
}

/// Writes rows with columns of even width: numbers to the right, the second column to the left.
fn aligned(rows: &[Vec<String>]) -> String {
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |k: usize| {
        let cells = rows.iter().filter_map(|row| row.get(k));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..count).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let cells = row.iter().zip(&widths).enumerate();
        let cells = cells.map(|(k, (cell, &wide))| match k == 1 || count == 2 {
            true => format!("{cell:<wide$}"),
            false => format!("{cell:>wide$}"),
        });
        let line = cells.collect::<Vec<_>>().join("  ");
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}
