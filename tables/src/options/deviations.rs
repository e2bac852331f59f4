//! Option of a bake of rays: recording the directions in which light leaves.

use std::fmt;
use std::str::FromStr;

/// Value of `--deviations`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Record {
    /// Histogram of exit directions if the cell is not ideal; its range follows from the cell and
    /// the angular tolerance.
    #[default]
    Auto,
    /// No histogram of exit directions.
    Off,
    /// Histogram with this range, mrad, whatever the cell.
    Within(f64),
}

impl FromStr for Record {
    type Err = String;

    fn from_str(text: &str) -> Result<Record, String> {
        let number = || text.parse().ok().filter(|x| (1e-3..=1e3).contains(x));
        match text {
            "auto" => Ok(Record::Auto),
            "off" => Ok(Record::Off),
            _ => number()
                .map(Record::Within)
                .ok_or_else(|| "give auto, off, or a range in mrad from 0.001 to 1000".into()),
        }
    }
}

impl fmt::Display for Record {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Record::Auto => f.write_str("auto"),
            Record::Off => f.write_str("off"),
            Record::Within(mrad) => write!(f, "{mrad}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_asked_is_read_back() {
        for record in [Record::Auto, Record::Off, Record::Within(2.5)] {
            assert_eq!(record.to_string().parse(), Ok(record));
        }
        for bad in ["", "on", "0", "-1", "nan", "inf", "5000"] {
            assert!(bad.parse::<Record>().is_err(), "{bad}");
        }
    }
}
