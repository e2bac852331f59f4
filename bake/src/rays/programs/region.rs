//! Parts of the entrance, and the affine functions of the entry point that cut them.

use glam::DVec2;

/// Largest distance that counts as rounding when tests are left out, edge lengths.
pub(crate) const ROUNDING: f64 = 1e-12;

/// Largest area of a part of the entrance that counts as empty, square edge lengths.
const SPECK: f64 = 1e-13;

/// Affine function of the entry point p: `x` p.x + `y` p.y + `one`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Affine {
    /// Coefficient of p.x.
    pub x: f64,
    /// Coefficient of p.y.
    pub y: f64,
    /// Constant term.
    pub one: f64,
}

impl Affine {
    /// Evaluates the function at `p`.
    #[inline(always)]
    pub(crate) fn at(&self, p: DVec2) -> f64 {
        self.x * p.x + self.y * p.y + self.one
    }

    /// Returns the difference of two functions.
    pub(crate) fn minus(&self, other: &Affine) -> Affine {
        Affine {
            x: self.x - other.x,
            y: self.y - other.y,
            one: self.one - other.one,
        }
    }

    /// Scales the function to a signed distance from the line where it is 0, edge lengths.
    ///
    /// The sign of the value stays. A function without a slope, beyond rounding, is returned as it
    /// is.
    pub(crate) fn as_distance(&self) -> Affine {
        let slope = self.x.hypot(self.y);
        if slope > ROUNDING {
            self.times(1.0 / slope)
        } else {
            *self
        }
    }

    /// Returns the function times a factor.
    pub(crate) fn times(&self, factor: f64) -> Affine {
        Affine {
            x: self.x * factor,
            y: self.y * factor,
            one: self.one * factor,
        }
    }
}

/// Convex parts of the entrance.
pub(crate) type Region = Vec<Vec<DVec2>>;

/// Returns the parts of `region` where all `tests` pass, and the parts where one fails.
pub(crate) fn split(region: &Region, tests: &[Affine]) -> (Region, Region) {
    let mut inside = region.clone();
    let mut outside = Vec::new();
    for test in tests {
        outside.extend(
            inside
                .iter()
                .map(|part| clip(part, &test.times(-1.0)))
                .filter(|part| !is_speck(part)),
        );
        inside = inside
            .iter()
            .map(|part| clip(part, test))
            .filter(|part| !is_speck(part))
            .collect();
    }
    (inside, outside)
}

/// Returns those of `tests` that a ray of `region` can fail when it passes the others.
pub(crate) fn needed(region: &Region, tests: &[Affine]) -> Vec<Affine> {
    let mut kept = tests.to_vec();
    let mut i = 0;
    while i < kept.len() {
        let test = kept.remove(i);
        let (inside, _) = split(region, &kept);
        if extent(&inside, &test).0 < -ROUNDING {
            kept.insert(i, test);
            i += 1;
        }
    }
    kept
}

/// Returns the least and the greatest value of `function` over the corners of `region`.
///
/// For an empty region it returns (inf, -inf).
pub(crate) fn extent(region: &Region, function: &Affine) -> (f64, f64) {
    region
        .iter()
        .flatten()
        .map(|&corner| function.at(corner))
        .fold(
            (f64::INFINITY, f64::NEG_INFINITY),
            |(least, most), value| (least.min(value), most.max(value)),
        )
}

/// Returns the part of a convex polygon where `test` is not negative.
fn clip(polygon: &[DVec2], test: &Affine) -> Vec<DVec2> {
    let on = |p: DVec2, q: DVec2, part: f64| p + (q - p) * part;
    tables::polygon::clip(polygon, |p| -test.at(p), on)
}

/// Returns whether a part of the entrance is so small that it counts as empty.
fn is_speck(polygon: &[DVec2]) -> bool {
    let doubled: f64 = (1..polygon.len().saturating_sub(1))
        .map(|i| (polygon[i] - polygon[0]).perp_dot(polygon[i + 1] - polygon[0]))
        .sum();
    doubled.abs() < 2.0 * SPECK
}
