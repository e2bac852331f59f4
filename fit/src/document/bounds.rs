//! Ranges that numbers of TOML files, results and options must lie in.
//!
//! No length in mm, angle, factor or count of this field is beyond them, and sums and products of
//! such numbers stay finite.

/// Least number above 0: a picometre in mm, and less.
const LEAST: f64 = 1e-9;
/// Greatest number: a thousand kilometres in mm.
const MOST: f64 = 1e9;

/// A condition that a number in a TOML file must meet.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    /// The condition in words, to follow "must be" in a message.
    pub words: &'static str,
    /// The condition as a function: true for a finite number that meets it.
    pub holds: fn(f64) -> bool,
}

impl Bounds {
    /// Any number of the field.
    pub(crate) const FINITE: Bounds = Bounds {
        words: "a finite number, at most 1e9 in size",
        holds: |x| x.abs() <= MOST,
    };
    /// A number above 0.
    pub(crate) const POSITIVE: Bounds = Bounds {
        words: "greater than 0, from 1e-9 to 1e9",
        holds: |x| (LEAST..=MOST).contains(&x),
    };
    /// 0 or a number above 0.
    pub(crate) const NOT_NEGATIVE: Bounds = Bounds {
        words: "0, or from 1e-9 to 1e9",
        holds: |x| x == 0.0 || (LEAST..=MOST).contains(&x),
    };
    /// A share of a whole, above 0 and at most 1.
    pub(crate) const SHARE: Bounds = Bounds {
        words: "greater than 0 and at most 1",
        holds: |x| x > 0.0 && x <= 1.0,
    };
    /// Incidence, degrees from the sheet's normal: from 0 to below 90.
    pub(crate) const INCIDENCE: Bounds = Bounds {
        words: "at least 0 and below 90 degrees",
        holds: |x| (0.0..90.0).contains(&x),
    };
    /// Angle of a turn about an axis, degrees, from -360 to 360.
    pub(crate) const TURN: Bounds = Bounds {
        words: "from -360 to 360 degrees",
        holds: |x| x.abs() <= 360.0,
    };
}
