//! Edge profiles of a diffraction lobe, computed in space. No OTF is used, so a campaign simulated
//! in this way checks an estimator that uses one.
//!
//! `radial` is sinc^2(a r), cut at a r = 2.4 pi and normalised; `separable` is sinc^2(a x) times
//! sinc^2(a y); `gaussian` is exp(-(a r)^2), whose edge is an error function along every direction.

use std::f64::consts::PI;

use edges::names::LobeShape;

/// Value of a r at which the radial lobe ends.
const RADIAL_END: f64 = 2.4 * PI;

/// Nodes and weights of Gauss and Legendre's rule on [-1, 1]. The rule is exact for polynomials up
/// to degree 2 N - 1.
struct Gauss<const N: usize> {
    nodes: [f64; N],
    weights: [f64; N],
}

impl<const N: usize> Gauss<N> {
    fn new() -> Self {
        let mut rule = Gauss {
            nodes: [0.0; N],
            weights: [0.0; N],
        };
        for k in 0..N {
            let mut x = (PI * (k as f64 + 0.75) / (N as f64 + 0.5)).cos();
            let mut slope = 1.0;
            // Newton's method from Chebyshev's guess converges in five steps for any N of use here.
            for _ in 0..8 {
                let (mut last, mut value) = (1.0, x);
                for n in 2..=N {
                    let n = n as f64;
                    (last, value) = (value, ((2.0 * n - 1.0) * x * value - (n - 1.0) * last) / n);
                }
                slope = N as f64 * (x * value - last) / (x * x - 1.0);
                x -= value / slope;
            }
            rule.nodes[k] = x;
            rule.weights[k] = 2.0 / ((1.0 - x * x) * slope * slope);
        }
        rule
    }

    fn integrate(&self, low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        half * self
            .nodes
            .iter()
            .zip(&self.weights)
            .map(|(x, weight)| weight * f(middle + half * x))
            .sum::<f64>()
    }
}

/// Returns the edge profile of a diffraction lobe along a direction, on the points `i * step_mm`,
/// |i| <= `half`: the share of the light at distances up to each point.
///
/// # Panics
/// Panics for a shape that is not in [`LobeShape::ALL`].
pub(crate) fn lobe_edge(
    shape: LobeShape,
    a_per_mm: f64,
    along: [f64; 2],
    step_mm: f64,
    half: usize,
) -> Vec<f64> {
    let round = |edge: &dyn Fn(f64) -> f64| {
        let places = (0..=2 * half).map(|i| (i as f64 - half as f64) * step_mm);
        places.map(edge).collect()
    };
    match shape {
        LobeShape::Radial => {
            let edge = RadialEdge::new(a_per_mm);
            round(&|x_mm| edge.at(x_mm))
        }
        LobeShape::Separable => separable_edge(a_per_mm, along, step_mm, half),
        LobeShape::Gaussian => round(&|x_mm| 0.5 * libm::erfc(-a_per_mm * x_mm)),
        LobeShape::Beckmann | LobeShape::Ggx => {
            unreachable!("{} is not the shape of a diffraction lobe", shape.name())
        }
    }
}

/// Edge profile of the radial lobe.
struct RadialEdge {
    a_per_mm: f64,
    rule: Gauss<16>,
    total: f64,
}

impl RadialEdge {
    /// Creates the edge profile of the lobe of spread `a_per_mm` > 0.
    fn new(a_per_mm: f64) -> RadialEdge {
        let mut edge = RadialEdge {
            a_per_mm,
            rule: Gauss::new(),
            total: 1.0,
        };
        edge.total = edge.encircled(0.0, RADIAL_END);
        edge
    }

    /// Returns the energy between two radii t = a r: the integral of sin^2 t / t, in panels no
    /// longer than a quarter of its period.
    fn encircled(&self, low: f64, high: f64) -> f64 {
        let panels = ((high - low) / (PI / 2.0)).ceil().max(1.0);
        let step = (high - low) / panels;
        (0..panels as usize)
            .map(|k| {
                let start = low + step * k as f64;
                self.rule.integrate(start, start + step, ring)
            })
            .sum()
    }

    /// Returns the share of the light at distances up to `x_mm` along any direction: 0 far on the
    /// dark side, 1/2 at 0, 1 far on the bright side. It is twice the Abel integral of the lobe;
    /// the absolute error is below 1e-12.
    fn at(&self, x_mm: f64) -> f64 {
        let z = (self.a_per_mm * x_mm).abs();
        if z >= RADIAL_END {
            return if x_mm > 0.0 { 1.0 } else { 0.0 };
        }
        // A ring of radius t > z has the share asin(z/t)/pi of its light between 0 and z. The
        // panels double in length. In the first, the substitution t = z + span v^2 removes the
        // square root at t = z.
        let share = |t: f64| ring(t) * (z / t).min(1.0).asin() / PI;
        let mut outer = 0.0;
        let mut low = z;
        while low < RADIAL_END && z > 0.0 {
            let high = (low + low.min(PI / 2.0)).min(RADIAL_END);
            let span = high - low;
            outer += if low == z {
                self.rule
                    .integrate(0.0, 1.0, |v| 2.0 * span * v * share(low + span * v * v))
            } else {
                self.rule.integrate(low, high, share)
            };
            low = high;
        }
        let half = (0.5 * self.encircled(0.0, z) + outer) / self.total;
        0.5 + half.copysign(x_mm)
    }
}

/// Returns sinc^2(t) t: the energy of the lobe in a ring, per dt and without the factor 2 pi.
fn ring(t: f64) -> f64 {
    if t < 1e-9 { t } else { t.sin().powi(2) / t }
}

/// One axis of the separable lobe, seen along a direction: the density (a/pi) sinc^2(a t).
#[derive(Debug, Clone, Copy)]
struct Axis {
    a_per_mm: f64,
}

impl Axis {
    fn density(&self, t_mm: f64) -> f64 {
        let z = self.a_per_mm * t_mm;
        let sinc = if z.abs() < 1e-8 { 1.0 } else { z.sin() / z };
        self.a_per_mm / PI * sinc * sinc
    }

    fn cumulative(&self, t_mm: f64) -> f64 {
        let z = (self.a_per_mm * t_mm).abs();
        let half = if z < 1e-9 {
            z
        } else {
            sine_and_cosine_integral(2.0 * z).0 - z.sin().powi(2) / z
        } / PI;
        0.5 + half.copysign(t_mm)
    }

    /// Returns the integral of `cumulative`, up to a constant. Its second differences are masses
    /// under a hat function.
    fn twice_integrated(&self, t_mm: f64) -> f64 {
        let z = (self.a_per_mm * t_mm).abs();
        let (sine, cosine) = sine_and_cosine_integral(2.0 * z);
        0.5 * t_mm + (z * sine + 0.5 * (2.0 * z).cos() - 0.5 * cosine) / (PI * self.a_per_mm)
    }
}

/// Returns Si(x) and Cin(x) = gamma + ln x - Ci(x) for x >= 0, to about 1e-14. Below 4 it sums the
/// series, from 4 on it uses Lentz's continued fraction of E1(i x) (Abramowitz and Stegun 5.2.14,
/// 5.1.22).
fn sine_and_cosine_integral(x: f64) -> (f64, f64) {
    const EULER: f64 = 0.577_215_664_901_532_9;
    if x < 4.0 {
        let (mut sine, mut cosine, mut term) = (0.0, 0.0, 1.0);
        for k in 1..40 {
            // term = x^k / k!
            term *= x / f64::from(k);
            let signed = if (k / 2) % 2 == 0 { term } else { -term } / f64::from(k);
            if k % 2 == 1 {
                sine += signed;
            } else {
                cosine -= signed;
            }
        }
        return (sine, cosine);
    }
    type C = nalgebra::Complex<f64>;
    let mut b = C::new(1.0, x);
    let mut c = C::new(1e300, 0.0);
    let mut d = C::new(1.0, 0.0) / b;
    let mut h = d;
    for k in 1..200 {
        let a = -f64::from(k * k);
        b += 2.0;
        d = C::new(1.0, 0.0) / (d * a + b);
        c = b + C::new(a, 0.0) / c;
        let factor = c * d;
        h *= factor;
        if (factor - 1.0).norm() < 1e-16 {
            break;
        }
    }
    h *= C::new(x.cos(), -x.sin());
    (PI / 2.0 + h.im, EULER + x.ln() + h.re)
}

/// Returns the edge profile of the separable lobe along a direction, on the points `i * step_mm`,
/// |i| <= `half`.
///
/// Both axes contribute, each seen along the direction with its spread divided by its cosine. The
/// wider axis is used as its closed-form edge. The narrower axis is summed over that edge: by
/// samples at a step that its band limit a/pi makes exact, or, if it is narrower than the grid, by
/// exact masses.
///
/// The 1/t^2 tails of the narrower axis beyond `reach` count as if they lay on the plateau. This
/// leaves an error of order s^3 / (a^2 reach^5): below 1e-9 for a > 1/mm, with reach = 8 times the
/// half-width of the picture.
fn separable_edge(a_per_mm: f64, along: [f64; 2], step_mm: f64, half: usize) -> Vec<f64> {
    let (most, least) = (
        along[0].abs().max(along[1].abs()),
        along[0].abs().min(along[1].abs()),
    );
    let wide = Axis {
        a_per_mm: a_per_mm / most,
    };
    let points = 2 * half + 1;
    let position = |i: usize| (i as f64 - half as f64) * step_mm;
    // Below this limit the second axis has no effect but its tail: 1/(pi a1 t) < 1e-9 at one step.
    if least < 1e-12 {
        return (0..points).map(|i| wide.cumulative(position(i))).collect();
    }
    let narrow = Axis {
        a_per_mm: a_per_mm / least,
    };
    let exact_step = PI / (wide.a_per_mm + narrow.a_per_mm);
    let stride = ((0.9 * exact_step / step_mm).floor() as usize).max(1);
    let sampled = exact_step > step_mm;
    let spacing = stride as f64 * step_mm;
    let reach_steps = (8.0 * half as f64 / stride as f64).ceil() as usize;
    let mass = |k: usize| {
        let t = k as f64 * spacing;
        if sampled {
            spacing * narrow.density(t)
        } else {
            let hat = |t: f64| {
                let p2 = |t: f64| narrow.twice_integrated(t);
                (p2(t + spacing) - 2.0 * p2(t) + p2(t - spacing)) / spacing
            };
            hat(t) - (hat(t + spacing) - 2.0 * hat(t) + hat(t - spacing)) / 12.0
        }
    };
    let masses: Vec<f64> = (0..=reach_steps).map(mass).collect();
    let beyond = 0.5 * (1.0 - masses[0] - 2.0 * masses[1..].iter().sum::<f64>());
    let table_half = half + reach_steps * stride;
    let table: Vec<f64> = (0..=2 * table_half)
        .map(|i| wide.cumulative((i as f64 - table_half as f64) * step_mm))
        .collect();
    let reach_mm = reach_steps as f64 * spacing;
    (0..points)
        .map(|i| {
            let centre = i + table_half - half;
            let inner: f64 = (1..=reach_steps)
                .map(|k| masses[k] * (table[centre - k * stride] + table[centre + k * stride]))
                .sum();
            // Left of -reach the wide edge is 1 - 1/(2 pi a2 (t + s)), right of reach it is 1/(2 pi
            // a2 (t - s)).
            let tilt = 2.0 * position(i)
                / (3.0 * reach_mm.powi(3))
                / (4.0 * PI * PI * wide.a_per_mm * narrow.a_per_mm);
            masses[0] * table[centre] + inner + beyond + tilt
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_integral_meets_its_tables() {
        // Abramowitz and Stegun, tables 5.1 and 5.3: Si(x), Ci(x).
        let known = [
            (0.5, 0.493_107_418_0, -0.177_784_078_8),
            (1.0, 0.946_083_070_4, 0.337_403_922_9),
            (5.0, 1.549_931_244_9, -0.190_029_749_7),
            (10.0, 1.658_347_594_2, -0.045_456_433_0),
        ];
        for (x, si, ci) in known {
            let (sine, cosine) = sine_and_cosine_integral(x);
            let found = 0.577_215_664_901_532_9 + f64::ln(x) - cosine;
            assert!((sine - si).abs() < 1e-9, "Si({x}) = {sine}");
            assert!((found - ci).abs() < 1e-9, "Ci({x}) = {found}");
        }
        // The series and the continued fraction agree at 4, where one takes over from the other.
        let (below, above) = (
            sine_and_cosine_integral(4.0 - 1e-12),
            sine_and_cosine_integral(4.0),
        );
        assert!((below.0 - above.0).abs() < 1e-11 && (below.1 - above.1).abs() < 1e-11);
    }

    #[test]
    fn radial_edge_equals_a_sum_over_the_plane() {
        // Brute force: midpoint squares over the disc. Squares cut the rim (value 0.016, length 2
        // pi R), which leaves an error of at most rim value x (area of the squares on it) / total.
        // The measured error is about 30 times smaller.
        let a = 3.0;
        let cells = 1600;
        let radius = RADIAL_END / a;
        let side = 2.0 * radius / f64::from(cells);
        let edge = RadialEdge::new(a);
        let mut columns = vec![0.0; cells as usize];
        for i in 0..cells {
            for j in 0..cells {
                let centre = |k: i32| (f64::from(k) + 0.5) * side - radius;
                let r = centre(i).hypot(centre(j));
                if r < radius {
                    columns[i as usize] += ring(a * r) / (a * r);
                }
            }
        }
        let total: f64 = columns.iter().sum();
        let mut sum = 0.0;
        let mut cases = 0;
        for (i, column) in columns.iter().enumerate() {
            sum += column;
            if i % 50 == 49 {
                let x = (i + 1) as f64 * side - radius;
                let error = (edge.at(x) - sum / total).abs();
                assert!(error < 2e-5, "x {x}: {error}");
                cases += 1;
            }
        }
        assert_eq!(cases, 32);
        assert_eq!((edge.at(-1e9), edge.at(0.0), edge.at(1e9)), (0.0, 0.5, 1.0));
    }

    #[test]
    fn separable_edge_equals_its_closed_form() {
        // The line spread function is the transform of (1 - f/f1)(1 - f/f2) up to the smaller of
        // f1, f2 = a / (pi |cosine|). Its edge is 1/2 + integral of that times sin(2 pi f s) / (pi
        // f). The integral is computed here in 20,000 midpoints over at most 13 periods: error (2
        // pi 13 / 20,000)^2 / 24 = 7e-7 of a sum that is at most 0.3.
        let mut cases = 0;
        for (a, angle) in [
            (4.2_f64, 5.0_f64),
            (1.6, 45.0),
            (8.0, 97.0),
            (4.2, 0.05),
            (2.0, 0.0),
        ] {
            let along = [angle.to_radians().cos(), angle.to_radians().sin()];
            let (step, half) = (0.05 / 32.0, 3200);
            let found = separable_edge(a, along, step, half);
            let limits = along.map(|c| a / (PI * c.abs().max(1e-300)));
            let band = limits[0].min(limits[1]);
            for i in (0..=2 * half).step_by(400) {
                let s = (i as f64 - half as f64) * step;
                let n = 20_000;
                let width = band / f64::from(n);
                let expected: f64 = 0.5
                    + (0..n)
                        .map(|k| {
                            let f = (f64::from(k) + 0.5) * width;
                            let otf = (1.0 - f / limits[0]) * (1.0 - f / limits[1]);
                            otf * (2.0 * PI * f * s).sin() / (PI * f) * width
                        })
                        .sum::<f64>();
                let error = (found[i] - expected).abs();
                assert!(
                    error < 2e-7,
                    "a {a}, {angle} deg, s {s}: {} {expected} {error:e}",
                    found[i]
                );
                cases += 1;
            }
        }
        assert_eq!(cases, 85);
    }
}
