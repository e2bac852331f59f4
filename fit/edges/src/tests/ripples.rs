//! An edge whose blur has ripples on both sides, as waves make them, is one edge.

use crate::photographs::edge::fault::Fault;
use crate::photographs::measure::edge;
use crate::tests::photographs::photo;

/// Returns the light of a blurred edge at the distance `s`, pixels: 0 before it and 1 beyond.
fn rise(s: f64) -> f64 {
    0.5 * libm::erfc(-s / (0.8 * std::f64::consts::SQRT_2))
}

/// Two lesser edges on both sides of an edge are a ripple of its blur if their distances and their
/// steepnesses differ by less than a factor of 2. Otherwise the steeper of them is a second edge.
#[test]
fn a_ripple_alike_on_both_sides_is_no_second_edge() {
    for ([left, right], [before, beyond], is_ripple) in [
        ([0.4, 0.4], [6.0, 6.0], true),
        ([0.4, 0.3], [6.0, 7.0], true),
        ([0.4, 0.0], [6.0, 6.0], false),
        ([0.0, 0.4], [6.0, 6.0], false),
        ([0.5, 0.15], [6.0, 6.0], false),
        ([0.4, 0.4], [5.0, 14.0], false),
    ] {
        let (sin, cos) = 6_f64.to_radians().sin_cos();
        let found = photo(240, 200, |x, y| {
            let s = (x - 120.3) * cos + (y - 99.1) * sin;
            0.1 + 0.3 * (rise(s) + left * rise(s + before) + right * rise(s - beyond))
        });
        let found = edge(&found, None, &[]);
        let doubled = matches!(found, Err(Fault::Doubled { .. }));
        assert_eq!(doubled, !is_ripple, "{left} {right} {before} {beyond}");
        assert!(doubled || found.is_ok(), "{:?}", found.err());
    }
}
