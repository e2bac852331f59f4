//! Numbers as a user types them, and lists of them: `0,5,10`, or `start:stop:step` with both ends.

use std::ops::{Bound, RangeBounds};

/// Largest number of values in a list.
pub const LONGEST_LIST: usize = 10_000;

/// Reads one number.
///
/// # Errors
/// Returns a message for clap if `text` is no number, or has a unit.
pub fn number(text: &str) -> Result<f64, String> {
    let read = text.trim().parse();
    read.map_err(|_| "must be a number without a unit".to_owned())
}

/// Returns a parser of whole numbers within `bounds`, for clap.
///
/// ```
/// let parser = tables::cli::whole::<u32>(1..=100);
/// assert_eq!(parser("7"), Ok(7));
/// assert_eq!(parser("1e2"), Ok(100));
/// assert_eq!(parser("7.5").unwrap_err(), "must be a whole number from 1 to 100");
/// let count = tables::cli::whole::<u32>(1..);
/// assert_eq!(count("1e12").unwrap_err(), "is too large");
/// ```
pub fn whole<T: TryFrom<usize>>(
    bounds: impl RangeBounds<usize> + Clone + Send + Sync + 'static,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static {
    move |text| {
        let fault = || format!("must be a whole number{}", words(&bounds));
        let large = || match bounds.end_bound() {
            Bound::Unbounded => "is too large".to_owned(),
            _ => fault(),
        };
        let whole = match text.trim().parse::<usize>() {
            Ok(whole) => whole,
            // Counts of rays are often typed as 1e6. Beyond 2^53 such a number is not exact.
            Err(_) => match text.trim().parse::<f64>() {
                Ok(value) if value < 0.0 || value.fract() != 0.0 || value.is_nan() => {
                    return Err(fault());
                }
                Ok(value) if value <= 2_f64.powi(53) => value as usize,
                Ok(_) => return Err(large()),
                Err(_) => return Err(fault()),
            },
        };
        match bounds.contains(&whole) {
            true => T::try_from(whole).map_err(|_| large()),
            false => Err(fault()),
        }
    }
}

/// Returns the bounds of a whole number in words.
fn words(bounds: &impl RangeBounds<usize>) -> String {
    let low = match bounds.start_bound() {
        Bound::Included(low) => *low,
        Bound::Excluded(below) => below.saturating_add(1),
        Bound::Unbounded => 0,
    };
    match bounds.end_bound() {
        Bound::Included(high) => format!(" from {low} to {high}"),
        Bound::Excluded(above) => format!(" from {low} to {}", above.saturating_sub(1)),
        Bound::Unbounded => format!(", {low} or larger"),
    }
}

/// Reads `0,5,10` or `start:stop:step`, in the order that was typed.
///
/// The stop belongs to the range if a whole number of steps leads there, within the rounding of the
/// three numbers. So `0:0.3:0.1` has four values, and `0:10:3.3334`, which would end beyond 10, has
/// three.
///
/// # Errors
/// Returns a message for clap if a part is no finite number, if a range does not have three parts,
/// or if it has no values or too many.
pub fn list(text: &str) -> Result<Vec<f64>, String> {
    let number = |part: &str| match part.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!(
            "\"{}\" is not a number; write 0,5,10 or start:stop:step",
            part.trim()
        )),
    };
    if !text.contains(':') {
        return text.split(',').map(number).collect();
    }
    let parts: Vec<f64> = text.split(':').map(number).collect::<Result<_, _>>()?;
    let [start, stop, step] = parts[..] else {
        return Err("a range has three parts, start:stop:step".into());
    };
    let count = (stop - start) / step;
    // Each typed number is off by half a unit in the last place, and each operation adds half a
    // unit of its result. So the numerator is off by at most
    // eps/2 (|start| + |stop| + |stop - start|), and the quotient by that over the step and by eps
    // of itself. The sum below is twice this.
    let rounding = f64::EPSILON * ((start.abs() + stop.abs()) / step + 3.0 * count);
    let steps = (count + rounding).floor();
    if !(step > 0.0 && (0.0..LONGEST_LIST as f64).contains(&steps)) {
        return Err(format!(
            "a range needs stop >= start and a step > 0 (at most {LONGEST_LIST} values)"
        ));
    }
    Ok((0..=steps as u32)
        .map(|i| start + f64::from(i) * step)
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ends_of_a_range_belong_to_it() {
        let cases = [
            ("0:45:5", 10),
            ("0:0.3:0.1", 4),
            ("0.1:0.7:0.1", 7),
            ("-0.3:0.3:0.1", 7),
            ("0:1:0.001", 1001),
            ("1000000.1:1000000.7:0.1", 7),
            ("5:5:1", 1),
            ("0:10:3.3333", 4),
            // A whole number of these steps would end beyond 10.
            ("0:10:3.3334", 3),
            ("0:9.9999:1", 10),
            ("0:0.99999999:0.1", 10),
        ];
        for (text, count) in cases {
            assert_eq!(list(text).map(|found| found.len()), Ok(count), "{text}");
        }
        // Decimal steps that divide their range, typed as people type them.
        let mut tried = 0;
        for digits in 0..6_i32 {
            for steps in [1_u32, 3, 7, 10, 99, 1000] {
                for mantissa in [1_u32, 2, 3, 7, 9] {
                    let step = f64::from(mantissa) * 10_f64.powi(-digits);
                    let stop = format!(
                        "{:.*}",
                        digits as usize,
                        f64::from(mantissa * steps) * 10_f64.powi(-digits)
                    );
                    let text = format!("0:{stop}:{:.*}", digits as usize, step);
                    assert_eq!(list(&text).unwrap().len(), steps as usize + 1, "{text}");
                    tried += 1;
                }
            }
        }
        assert_eq!(tried, 180);
    }

    #[test]
    fn a_number_has_no_unit() {
        assert_eq!(number("0.15"), Ok(0.15));
        assert_eq!(number(" -1e-3"), Ok(-1e-3));
        for text in ["0.15mm", "0.15 mm", "1,5", ""] {
            let said = number(text).unwrap_err();
            assert_eq!(said, "must be a number without a unit", "{text}");
        }
    }

    #[test]
    fn what_is_no_list_says_why() {
        assert_eq!(list("30, 0,15"), Ok(vec![30.0, 0.0, 15.0]));
        let cases = [
            ("1,,2", "\"\" is not"),
            ("1,inf", "\"inf\" is not"),
            ("0:x:1", "\"x\" is not"),
            ("0:1", "three parts"),
            ("0:1:0", "step > 0"),
            ("1:0:1", "stop >= start"),
            ("0:1:-1", "step > 0"),
            ("0:1e9:1", "at most 10000"),
        ];
        for (text, reason) in cases {
            let said = list(text).unwrap_err();
            assert!(said.contains(reason), "{text}: {said}");
        }
    }
}
