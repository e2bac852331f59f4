//! Enclosures of the means by which a table is interpolated.
//!
//! `tables` interpolates by moving least squares: the value at tau is sum w_j f_j over directions
//! tau_j. The weights w make sum w_j^2 d_j^4 least, d_j = |tau_j - tau|, among all weights whose
//! sum is 1 and which give back all affine functions. (That is the dual form of least squares with
//! the weights 1 / d^4.) So it is at most S = sum u_j^2 d_j^4 for any other such weights u; here u
//! belongs to three directions around. Let A be an affine function, r_j = f_j - A(tau_j). Then
//! sum w_j f_j = A(tau) + sum w_j r_j, and by Cauchy and Schwarz the last sum is at most
//! sqrt(S) sqrt(sum r_j^2 / d_j^4). A is chosen to be exact in the nearest direction, so that none
//! of these quotients is large.
//!
//! The ridge 1e-12 of the least squares lets the weights give back slopes with a fault T: what
//! is least is then sum w_j^2 d_j^4 + |T|^2 / ridge in the scale of the nearest direction, and it
//! is still at most S, as u has no fault. So |T| <= sqrt(ridge n S) / (nearest distance).
//!
//! If all directions lie on one line, the value does not change across it, and the same holds
//! along it.

use glam::DVec2;

use crate::proof::moving::{Affine, Patch};

/// Values that are affine in the patch, each with a bound of its error.
pub(crate) type Enclosed<const N: usize> = [(Affine, f64); N];

/// Square root of the ridge times the most directions, 16.
const RIDGE: f64 = 4e-6;

/// Part of the slope by which rounding changes it where all directions lie on one line: 16
/// roundings of 1.1e-16 over the ridge, which alone keeps the equations solvable.
const LOOSE: f64 = 2e-3;

/// Weights that give back affine functions: which direction, its value at the nearest one, slope.
type Combination = Vec<(usize, f64, DVec2)>;

/// Encloses the mean of `values`, each a tau and numbers, in all directions of `patch`.
pub(crate) fn enclose<const N: usize>(
    values: &[([f64; 2], [f64; N])],
    patch: &Patch,
) -> Enclosed<N> {
    let places: Vec<DVec2> = values
        .iter()
        .map(|(tau, _)| DVec2::from_array(*tau))
        .collect();
    let distances: Vec<(f64, f64)> = places.iter().map(|&tau| patch.distances(tau)).collect();
    let away = |which: &usize| places[*which].distance(patch.centre);
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|a, b| away(a).total_cmp(&away(b)));
    let nearest = order[0];
    let line = on_line(&places, nearest);
    let slopes = slopes(values, &places, nearest, line);
    let others = || order.iter().copied().filter(|&j| j != nearest);
    let (size, loose) = combination(&places, &distances, &order, line, patch);
    std::array::from_fn(|k| {
        let (start, slope) = (values[nearest].1[k], slopes[k]);
        let at = |tau: DVec2| start + slope.dot(tau - places[nearest]);
        let value = [
            at(patch.centre),
            slope.dot(patch.first),
            slope.dot(patch.second),
        ];
        let residual = |j: usize| (values[j].1[k] - at(places[j])).abs();
        // Residuals that are rounding of numbers below 10 count for nothing but themselves.
        let rounding = 1e-13;
        let quotients = others().map(|j| match residual(j) {
            r if r <= rounding => 0.0,
            r => (r / distances[j].1.powi(2)).powi(2),
        });
        let misfit = quotients.sum::<f64>().sqrt();
        let error = if misfit == 0.0 { 0.0 } else { size * misfit };
        let steep = slope.length();
        let fault = if steep == 0.0 { 0.0 } else { steep * loose };
        (value, error + fault + 16.0 * rounding)
    })
}

/// Returns the direction of the line on which all places lie, 0 if they are one, or `None` if they
/// lie on no line.
fn on_line(places: &[DVec2], nearest: usize) -> Option<DVec2> {
    let from = places[nearest];
    let longest = places.iter().map(|&tau| tau - from);
    let longest = longest.fold(
        DVec2::ZERO,
        |a, b| if b.length() > a.length() { b } else { a },
    );
    let axis = longest.try_normalize().unwrap_or_default();
    let off = places.iter().map(|&tau| (tau - from).perp_dot(axis).abs());
    (off.fold(0.0, f64::max) <= 1e-9 * longest.length().max(1e-9)).then_some(axis)
}

/// Returns the slopes of the affine functions that are exact in the nearest direction and fit the
/// others by the weights 1 / distance^4. Any slopes would do.
fn slopes<const N: usize>(
    values: &[([f64; 2], [f64; N])],
    places: &[DVec2],
    nearest: usize,
    line: Option<DVec2>,
) -> [DVec2; N] {
    let (mut moments, mut sums) = ([0.0; 3], [DVec2::ZERO; N]);
    for (place, (_, value)) in places.iter().zip(values) {
        let y = *place - places[nearest];
        if y.length() == 0.0 {
            continue;
        }
        let weight = y.length_squared().powi(-2);
        for (sum, part) in moments.iter_mut().zip([y.x * y.x, y.x * y.y, y.y * y.y]) {
            *sum += weight * part;
        }
        for (sum, k) in sums.iter_mut().zip(0..) {
            *sum += weight * (value[k] - values[nearest].1[k]) * y;
        }
    }
    let [a, b, c] = moments;
    sums.map(|sum| match line {
        Some(axis) if a + c > 0.0 => axis * (sum.dot(axis) / (a + c)),
        Some(_) => DVec2::ZERO,
        None => DVec2::new(c * sum.x - b * sum.y, a * sum.y - b * sum.x) / (a * c - b * b),
    })
}

/// Returns the root of a bound of S, and a bound of |T|, over the patch.
fn combination(
    places: &[DVec2],
    distances: &[(f64, f64)],
    order: &[usize],
    line: Option<DVec2>,
    patch: &Patch,
) -> (f64, f64) {
    let nearest = order[0];
    let from = places[nearest];
    let mut choices: Vec<Combination> = Vec::new();
    let near = &order[1..order.len().min(9)];
    match line {
        Some(axis) if axis == DVec2::ZERO => choices.push(vec![(nearest, 1.0, DVec2::ZERO)]),
        Some(axis) => choices.extend(near.iter().map(|&j| {
            let slope = axis / (places[j] - from).dot(axis);
            vec![(nearest, 1.0, -slope), (j, 0.0, slope)]
        })),
        None => {
            for (n, &i) in near.iter().enumerate() {
                for &j in &near[..n] {
                    let (a, b) = (places[i] - from, places[j] - from);
                    let twice = a.perp_dot(b);
                    if twice.abs() > 1e-6 * a.length() * b.length() {
                        let (to_i, to_j) = (-b.perp() / twice, a.perp() / twice);
                        choices.push(vec![
                            (nearest, 1.0, -to_i - to_j),
                            (i, 0.0, to_i),
                            (j, 0.0, to_j),
                        ]);
                    }
                }
            }
        }
    }
    let others = || order.iter().filter(|&&j| places[j] != from);
    let closest = others()
        .map(|&j| distances[j].1)
        .fold(f64::INFINITY, f64::min);
    let far = distances[nearest].0;
    // The nearest direction of a tau need not be that of the middle.
    let ratio = (far / closest).max(1.0);
    let bounds = choices.iter().map(|choice| {
        let (mut size, mut fault) = (0.0, 0.0);
        for &(j, value, slope) in choice {
            let middle = value + slope.dot(patch.centre - from);
            let change = slope.dot(patch.first).abs() + slope.dot(patch.second).abs();
            let most = middle.abs() + change;
            let squared = distances[j].0.powi(2);
            size += (most * squared).powi(2);
            // Weights but that of the nearest direction fall to 0 there, in proportion to its
            // distance, by which |T| is divided.
            let part = if j == nearest {
                most * far
            } else {
                slope.length() * squared
            };
            fault += (part * ratio).powi(2);
        }
        (size.sqrt(), RIDGE * fault.sqrt())
    });
    let start = (f64::INFINITY, f64::INFINITY);
    let (size, fault) = bounds.fold(start, |a, b| if b.0 < a.0 { b } else { a });
    match line {
        Some(axis) if axis == DVec2::ZERO => (0.0, 0.0),
        Some(_) => {
            let longest = distances.iter().map(|(far, _)| *far).fold(0.0, f64::max);
            (size, fault + LOOSE * longest)
        }
        None => (size, fault),
    }
}
