//! Edge profiles of wave optics, by Fresnel integrals over the chords of the aperture.
//!
//! The aperture carries the phase 2 pi |y|^2/(lambda R). It is cut into chords along the edge
//! normal. A chord from l to r makes the field `E(x) = int_l^r exp(2 pi i (n^2 - x n)/(lambda R))
//! dn` on the image. Up to a phase this is `F(r - x/2) - F(l - x/2)` with the Fresnel integral F.
//! The line spread function is the sum of |E|^2 over all chords, divided by lambda R times the area
//! (Parseval). The edge is its integral. The overlaps and transfer functions of the estimator are
//! not used.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::simulate::cell::CubeShift;
use edges::numerics::GAUSS_16;
use tables::Samples;

/// Phase between two tabulated values of F, radians. The interpolation error is step x 0.2^3 / 384,
/// which is 2e-5 of a step.
const PHASE_STEP: f64 = 0.2;

/// Largest number of oscillations of the field across one panel of chords.
const PER_PANEL: f64 = 2.0;
/// Largest number of oscillations of the field across one step of the integral over x.
const PER_STEP: f64 = 1.0 / 32.0;

/// A chord: start, end, and weight (its width across the normal), mm.
type Chord = (f64, f64, f64);

/// Returns the edge at the positions (i - half) step, mm, for i in 0..=2 half. `scale_mm` scales
/// the cubes' polygons to the image. `lines` holds lambda R (mm^2) and the share of every line; the
/// shares sum to 1.
pub(crate) fn wave_edge(
    cubes: &[CubeShift],
    scale_mm: [f64; 2],
    along: [f64; 2],
    lines: &[(f64, f64)],
    step: f64,
    half: usize,
) -> Vec<f64> {
    let end = half as f64 * step;
    // A shift is 2 (q - p), so the aperture about q is half the polygon of shifts, which is its own
    // point reflection.
    let turned: Vec<Vec<[f64; 2]>> = cubes
        .iter()
        .map(|cube| {
            let turn = |p: &[f64; 2]| {
                let (x, y) = (0.5 * scale_mm[0] * p[0], 0.5 * scale_mm[1] * p[1]);
                [along[0] * x + along[1] * y, along[0] * y - along[1] * x]
            };
            cube.polygon.iter().map(turn).collect()
        })
        .collect();
    let corners = turned.iter().flatten().map(|p| p[0].abs());
    let reach = corners.fold(0.0, f64::max);
    let mut edge = vec![0.5; 2 * half + 1];
    for &(area_mm2, share) in lines {
        let fresnel = Fresnel::new(area_mm2, reach + 0.5 * end);
        // Fastest change of the field with a chord's end, and with x; oscillations per mm.
        let by_end = (2.0 * reach + end) / area_mm2;
        let by_x = 2.0 * reach / area_mm2;
        let chords: Vec<Chord> = turned
            .iter()
            .flat_map(|polygon| chords(polygon, by_end))
            .collect();
        let total: f64 = chords.iter().map(|(l, r, w)| w * (r - l)).sum::<f64>() * area_mm2;
        let spread = |x: f64| {
            let light = |&(l, r, w): &Chord| {
                w * (fresnel.at(r - 0.5 * x) - fresnel.at(l - 0.5 * x)).norm_sqr()
            };
            chords.iter().map(light).sum::<f64>() / total
        };
        let parts = (by_x * step / PER_STEP).ceil().max(1.0) as usize;
        let part = step / parts as f64;
        // Simpson's rule on every part. The line spread function is even, so half of the light lies
        // on either side of 0.
        let (mut sum, mut before) = (0.0, spread(0.0));
        for i in 1..=half {
            for k in 0..parts {
                let x = (i - 1) as f64 * step + k as f64 * part;
                let after = spread(x + part);
                sum += part / 6.0 * (before + 4.0 * spread(x + 0.5 * part) + after);
                before = after;
            }
            edge[half + i] += share * sum;
            edge[half - i] -= share * sum;
        }
    }
    edge
}

/// Returns chords of a convex polygon at the nodes of Gauss and Legendre between its corners. The
/// panels are narrow enough for fields that turn `by_end` times for each mm that a chord's end
/// moves.
fn chords(polygon: &[[f64; 2]], by_end: f64) -> Vec<Chord> {
    let mut cuts: Vec<f64> = polygon.iter().map(|p| p[1]).collect();
    cuts.sort_by(f64::total_cmp);
    let mut chords = Vec::new();
    for pair in cuts.windows(2).filter(|pair| pair[1] - pair[0] > 1e-12) {
        let slopes = (0..polygon.len()).filter_map(|k| {
            let (p, q) = (polygon[k], polygon[(k + 1) % polygon.len()]);
            let middle = 0.5 * (pair[0] + pair[1]);
            ((p[1] < middle) != (q[1] < middle)).then(|| ((q[0] - p[0]) / (q[1] - p[1])).abs())
        });
        let turns = by_end * (pair[1] - pair[0]) * slopes.fold(0.0, f64::max);
        let panels = (turns / PER_PANEL).ceil().max(1.0) as usize;
        let half = 0.5 * (pair[1] - pair[0]) / panels as f64;
        for panel in 0..panels {
            let middle = pair[0] + (2 * panel + 1) as f64 * half;
            for (node, weight) in GAUSS_16 {
                for t in [middle - node * half, middle + node * half] {
                    let (low, high) = chord(polygon, t);
                    chords.push((low, high, weight * half));
                }
            }
        }
    }
    chords
}

/// Returns the places where the line at height `t` enters and leaves a convex polygon.
fn chord(polygon: &[[f64; 2]], t: f64) -> (f64, f64) {
    let crossings = (0..polygon.len()).filter_map(|k| {
        let (p, q) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        ((p[1] < t) != (q[1] < t)).then(|| p[0] + (t - p[1]) / (q[1] - p[1]) * (q[0] - p[0]))
    });
    crossings.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
        (low.min(x), high.max(x))
    })
}

/// The Fresnel integral F(z) = int_0^z exp(2 pi i u^2 / area) du for |z| <= end. F is odd.
struct Fresnel {
    samples: Samples<Complex64>,
}

impl Fresnel {
    fn new(area_mm2: f64, end: f64) -> Fresnel {
        // The phase turns fastest at the end: by 2 TAU end / area per mm.
        let step = PHASE_STEP * area_mm2 / (2.0 * TAU * end);
        let count = (end / step).ceil() as usize + 2;
        let field = |u: f64| Complex64::cis(TAU * u * u / area_mm2);
        let mut values = vec![Complex64::ZERO];
        let mut sum = Complex64::ZERO;
        for i in 1..count {
            let middle = (i as f64 - 0.5) * step;
            for (node, weight) in GAUSS_16 {
                let offset = 0.5 * step * node;
                sum += (field(middle - offset) + field(middle + offset)) * (0.5 * step * weight);
            }
            values.push(sum);
        }
        let slopes = (0..count).map(|i| field(i as f64 * step)).collect();
        Fresnel {
            samples: Samples::new(step, values, slopes),
        }
    }

    fn at(&self, z: f64) -> Complex64 {
        self.samples.at(z.abs()).0 * z.signum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::cell::shifts;

    /// Checks the light far from the edge. Without curvature a square aperture would give sinc^2.
    /// With curvature, all light has arrived at x but the tail lambda R width/(2 pi^2 area x), by
    /// Parseval.
    #[test]
    fn all_light_arrives_but_the_tail() {
        for (incidence_deg, normal_deg) in [(0.0_f64, 5.0_f64), (20.0, 33.0), (40.0, 97.0)] {
            let cubes = shifts(incidence_deg.to_radians(), 0.5, 1.49, true);
            let along = [normal_deg.to_radians().cos(), normal_deg.to_radians().sin()];
            let scale = [0.2 * incidence_deg.to_radians().cos(), 0.2];
            let (line, end) = (550e-6 * 150.0, 8.0);
            let edge = wave_edge(&cubes, scale, along, &[(line, 1.0)], end / 2000.0, 2000);
            let (mut width, mut area) = (0.0, 0.0);
            for cube in &cubes {
                let across: Vec<f64> = cube
                    .polygon
                    .iter()
                    .map(|p| 0.5 * (along[0] * scale[1] * p[1] - along[1] * scale[0] * p[0]))
                    .collect();
                width += across.iter().copied().fold(f64::NEG_INFINITY, f64::max)
                    - across.iter().copied().fold(f64::INFINITY, f64::min);
                area += 0.25 * scale[0] * scale[1] * crate::simulate::cell::area(&cube.polygon);
            }
            let tail = line * width / (2.0 * std::f64::consts::PI.powi(2) * area * end);
            let missing = 1.0 - edge[4000];
            println!("{incidence_deg} {normal_deg}: {missing:.3e} tail {tail:.3e}");
            // The tail oscillates about its mean by a term of the next order, 1/x of the aperture's
            // size over it.
            assert!(
                (missing - tail).abs() < 0.1 * tail,
                "{missing:e} against {tail:e}"
            );
            assert!(
                edge.windows(2).all(|pair| pair[1] >= pair[0]),
                "light is positive"
            );
        }
    }
}
