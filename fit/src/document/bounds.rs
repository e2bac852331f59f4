//! What numbers in TOML inputs may be.

/// What a number may be.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    /// The condition in words, after "must be".
    pub words: &'static str,
    /// Whether a finite number meets it.
    pub holds: fn(f64) -> bool,
}

impl Bounds {
    /// Any finite number.
    pub(crate) const FINITE: Bounds = Bounds {
        words: "a finite number",
        holds: |_| true,
    };
    /// Above zero.
    pub(crate) const POSITIVE: Bounds = Bounds {
        words: "greater than 0",
        holds: |x| x > 0.0,
    };
    /// Zero or above.
    pub(crate) const NOT_NEGATIVE: Bounds = Bounds {
        words: "0 or greater",
        holds: |x| x >= 0.0,
    };
    /// A share that cannot vanish.
    pub(crate) const SHARE: Bounds = Bounds {
        words: "greater than 0 and at most 1",
        holds: |x| x > 0.0 && x <= 1.0,
    };
    /// Incidence angle, degrees from the sheet's normal.
    pub(crate) const INCIDENCE: Bounds = Bounds {
        words: "at least 0 and below 90 degrees",
        holds: |x| (0.0..90.0).contains(&x),
    };
    /// Angle about an axis, degrees.
    pub(crate) const TURN: Bounds = Bounds {
        words: "between -360 and 360 degrees",
        holds: |x| x.abs() <= 360.0,
    };
}
