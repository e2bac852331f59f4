//! Text and numbers of the page; all text from a file or a command line goes through [`charts::escape`].

use charts::{escape, minus};

/// Writes a number with as many decimals as show two significant digits of its error.
pub(crate) fn rounded(value: f64, error: f64) -> String {
    let decimals = if error > 0.0 && error.is_finite() {
        (1.0 - error.log10().floor()).clamp(0.0, 12.0) as usize
    } else {
        5
    };
    minus(format!("{value:.decimals$}"))
}

/// Writes a number with `digits` significant digits, as a power of ten if it would be long.
pub(crate) fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return minus(format!("{value}"));
    }
    let power = value.abs().log10().floor();
    if !(-6.0..6.0).contains(&power) {
        let mantissa = format!("{:.*}", digits - 1, value / 10_f64.powf(power));
        return minus(format!("{mantissa}e{power}"));
    }
    let decimals = (digits as f64 - 1.0 - power).max(0.0) as usize;
    minus(format!("{value:.decimals$}"))
}

/// Writes a criterion or a chi-square: with one decimal, or if it is large, whole in groups of
/// three digits.
pub(crate) fn grouped(value: f64) -> String {
    if value.abs() < 10_000.0 || !value.is_finite() {
        return minus(format!("{value:.1}"));
    }
    let digits = format!("{:.0}", value.abs());
    let mut out = String::from(if value < 0.0 { "\u{2212}" } else { "" });
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(digit);
    }
    out
}

/// Writes a number and the noun that it counts.
pub(crate) fn count(number: usize, one: &str, several: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { several })
}

/// Writes a table that scrolls on its own if it is wider than the page.
///
/// Cells are markup. The first cell of a row is its header.
pub(crate) fn table(label: &str, head: &[&str], rows: &[Row]) -> String {
    let mut out = format!(
        "<div class=\"scroll\" role=\"region\" tabindex=\"0\" \
        aria-label=\"{}\"><table>\n<thead><tr>",
        escape(label)
    );
    for title in head {
        out.push_str(&format!("<th scope=\"col\">{title}</th>"));
    }
    out.push_str("</tr></thead>\n<tbody>\n");
    for row in rows {
        out.push_str(if row.chosen {
            "<tr class=\"chosen\">"
        } else {
            "<tr>"
        });
        for (i, cell) in row.cells.iter().enumerate() {
            out.push_str(&match i {
                0 => format!("<th scope=\"row\">{cell}</th>"),
                _ => format!("<td>{cell}</td>"),
            });
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody></table></div>\n");
    out
}

/// Row of a [`table`].
pub(crate) struct Row {
    /// Markup of the cells.
    pub cells: Vec<String>,
    /// True if the row is highlighted.
    pub chosen: bool,
}

impl From<Vec<String>> for Row {
    fn from(cells: Vec<String>) -> Row {
        Row {
            cells,
            chosen: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_show_what_is_known() {
        let cases = [
            (rounded(0.240_026, 0.000_456), "0.24003"),
            (rounded(4.901_98, 0.001_98), "4.9020"),
            (rounded(735.4, 12.0), "735"),
            (rounded(-1.5, 0.0), "\u{2212}1.50000"),
            (significant(0.012_345, 3), "0.0123"),
            (significant(123_456.0, 3), "123456"),
            (significant(1.234e-7, 3), "1.23e\u{2212}7"),
            (significant(0.0, 3), "0"),
            (grouped(-380.27), "\u{2212}380.3"),
            (grouped(7_211_123.4), "7\u{202f}211\u{202f}123"),
        ];
        for (found, wanted) in &cases {
            assert_eq!(found, wanted);
        }
        assert_eq!(cases.len(), 10);
    }
}
