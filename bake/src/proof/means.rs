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
//! In a small patch there is more to know. Let u be the weights at tau of the affine least squares
//! whose d_j are frozen at the middle of the patch, d'_j: sum u_j f_j is affine in tau. Both w and
//! u give back affine functions, so v = w - u gives 0 for all of them. As w and u are the least of
//! their kind, sum d_j^4 w_j v_j = 0 and sum d'_j^4 u_j v_j = 0. So sum d_j^4 v_j^2 = - sum d_j^4
//! u_j v_j = - sum (d_j^4 - d'_j^4) u_j v_j. By Cauchy and Schwarz, sum d_j^4 v_j^2 is at most
//! sum (d_j^2 - d'_j^4 / d_j^2)^2 u_j^2, and the mean is off from sum u_j f_j by at most the root
//! of that times sqrt(sum r_j^2 / d_j^4). This error falls with the size of the patch. (With the
//! fault T below, w is the least of the weights that give back tau + T, and u is taken there.)
//!
//! If all directions lie on one line, the value does not change across it, and the same holds
//! along it.

use glam::{DMat3, DVec2};

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
    let values = &shared(values);
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
    let frozen = match line {
        None => frozen(&places, &distances, loose, patch),
        Some(_) => None,
    };
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
        let mut frozen_value = None;
        let misfit = quotients.sum::<f64>().sqrt();
        if let Some((weights, size)) = &frozen
            && misfit > 0.0
        {
            let beyond = |j: usize| values[j].1[k] - start;
            let sum = |of: &dyn Fn(&Frozen) -> f64| -> f64 {
                let parts = weights.iter().enumerate();
                parts.map(|(j, weight)| beyond(j) * of(weight)).sum()
            };
            let steep = DVec2::new(sum(&|u| u.slope.x), sum(&|u| u.slope.y));
            let near = [
                start + sum(&|u| u.middle),
                steep.dot(patch.first),
                steep.dot(patch.second),
            ];
            frozen_value = Some((near, size * misfit + steep.length() * loose));
        }
        let error = if misfit == 0.0 { 0.0 } else { size * misfit };
        let steep = slope.length();
        let fault = if steep == 0.0 { 0.0 } else { steep * loose };
        let whole = (value, error + fault);
        let (value, error) = match frozen_value {
            Some(near) if near.1 < whole.1 => near,
            _ => whole,
        };
        (value, error + 16.0 * rounding)
    })
}

/// Gives all values of one tau their mean, which leaves the mean at any tau as it is: their weights
/// are equal. At normal incidence all azimuths are one tau, and their values differ by rounding.
pub(crate) fn shared<const N: usize>(values: &[([f64; 2], [f64; N])]) -> Vec<([f64; 2], [f64; N])> {
    let mean = |(tau, first): &([f64; 2], [f64; N])| {
        let alike = || values.iter().filter(|(other, _)| other == tau);
        let count = alike().count() as f64;
        let beyond = |k: usize| alike().map(|(_, value)| value[k] - first[k]).sum::<f64>();
        (*tau, std::array::from_fn(|k| first[k] + beyond(k) / count))
    };
    values.iter().map(mean).collect()
}

/// Weight that is affine in tau: its value in the middle of the patch, and its slope.
struct Frozen {
    middle: f64,
    slope: DVec2,
}

/// Returns the weights of the least squares that is frozen at the middle of the patch, and the root
/// of the bound of sum d^4 v^2, or `None` if a direction lies in the patch or close to it.
fn frozen(
    places: &[DVec2],
    distances: &[(f64, f64)],
    loose: f64,
    patch: &Patch,
) -> Option<(Vec<Frozen>, f64)> {
    let away: Vec<f64> = places.iter().map(|p| p.distance(patch.centre)).collect();
    let closest = away.iter().copied().fold(f64::INFINITY, f64::min);
    let size = patch.first.length() + patch.second.length();
    if places.len() < 3 || closest < 2.0 * size || closest == 0.0 {
        return None;
    }
    // Distances from the middle, in units of the closest direction.
    let seen = |j: usize| ((places[j] - patch.centre) / closest).extend(1.0);
    let heavy = |j: usize| (closest / away[j]).powi(4);
    let mut moments = DMat3::ZERO;
    for j in 0..places.len() {
        let y = seen(j);
        moments += DMat3::from_cols(y * y.x, y * y.y, y * y.z) * heavy(j);
    }
    let inverse = moments.inverse();
    // Relative error of the weights by rounding is some 1e-16 by the condition, kept below 1e-8.
    let sizes = |m: DMat3| m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
    if !inverse.is_finite() || sizes(moments) * sizes(inverse) > 1e7 {
        return None;
    }
    let weight = |j: usize| {
        let row = inverse * seen(j) * heavy(j);
        Frozen {
            middle: row.z,
            slope: row.truncate() / closest,
        }
    };
    let weights: Vec<Frozen> = (0..places.len()).map(weight).collect();
    let parts = weights
        .iter()
        .zip(distances)
        .zip(&away)
        .map(|((u, (far, near)), at)| {
            let moved = u.slope.dot(patch.first).abs() + u.slope.dot(patch.second).abs();
            let most = u.middle.abs() + moved + u.slope.length() * loose;
            let change = |d: f64| (d * d - at.powi(4) / (d * d)).abs();
            (most * change(*far).max(change(*near))).powi(2)
        });
    let size = parts.sum::<f64>().sqrt();
    Some((weights, size))
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
