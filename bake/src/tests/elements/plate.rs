//! A micro-mirror array plate, unfolded by hand.
//!
//! A layer has slits of the clear width w and the depth h. Light goes s w along the normal of the
//! mirrors, with s = h tan(theta) |cos phi| / w. Unfolded, the light that enters at x in (0, w)
//! arrives at X = x + s w, and passes m mirrors if X lies in (m w, (m + 1) w). An odd m turns the
//! light round and brings it to (m + 1) w - X in the slit. This is a share 1 - |1 - (s mod 2)| of
//! the light. The lines of entering and leaving light, extended to the lower end of the layer, are
//! (m + 1) w - 2 X apart. Extended to its upper end, they are 2 s w further apart.

use crate::plan::{Plan, Request};
use crate::tests::bakes;
use crate::tests::cells::of_mesh;
use glam::DVec2;
use meshes::Cell;
use meshes::design::Plate;
use tables::options::{Element, Losses, Method, Sampler, SceneOptions};
use tables::{Fate, Table};

const INCIDENCES: &str = "0,10,25,40,55,70";
const AZIMUTHS: &str = "-70,0,15,45,100,225";

fn cell(depth: f64, thickness: f64) -> Cell {
    let plate = Plate {
        pitch: 0.5,
        depth,
        thickness,
    };
    of_mesh(&plate.mesh().expect("a legal design"), |_| ())
}

fn request() -> Request {
    Request {
        incidence: INCIDENCES.into(),
        azimuth: AZIMUTHS.into(),
        range: 8.0,
        scene: SceneOptions {
            element: Element::Plate,
            ..SceneOptions::default()
        },
        ..Request::default()
    }
}

fn bake(cell: &Cell, request: Request) -> Table {
    let plan = Plan::new(&request).expect("a valid request");
    bakes::bake(cell, &plan).expect("bakes")
}

/// Returns the share of a layer's light that is turned round (edges of mirrors included), the share
/// that goes straight through, and the range of the shift along the light, on the plane of the
/// layer's lower end.
fn layer(depth: f64, thickness: f64, slope: f64) -> (f64, f64, [f64; 2]) {
    let w = 1.0 - thickness;
    let s = depth * slope.abs() / w;
    let odd = 1.0 - (1.0 - s.rem_euclid(2.0)).abs();
    let whole = s.floor();
    let m = if whole % 2.0 == 1.0 {
        whole
    } else {
        whole + 1.0
    };
    let low = (m * w).max(s * w);
    let high = ((m + 1.0) * w).min((s + 1.0) * w);
    let shift = |x: f64| (m + 1.0) * w - 2.0 * x;
    (w * odd, w * (1.0 - s).max(0.0), [shift(high), shift(low)])
}

/// Exact tables of four plates have the share, the straight light and the box of shifts of the
/// unfolded slits. Shifts fill the box evenly. Rounding is some ulp of the way through the plate, 2
/// h tan(inside) up to 22 here, over areas of 1.
#[test]
fn exact_tables_are_the_unfolded_slits() {
    let (mut cases, mut imaged) = (0, 0);
    for (depth, thickness, index) in [
        (1.0, 0.02, 1.0),
        (3.0, 0.02, 1.5),
        (4.0, 0.3, 1.0),
        (0.7, 1e-6, 1.33),
    ] {
        let plate = cell(depth, thickness);
        let table = bake(
            &plate,
            Request {
                method: Method::Exact,
                refractive_index: Some(index),
                ..request()
            },
        );
        let exact = table.exact.as_ref().expect("planar");
        assert!((exact.entrance_area - 1.0).abs() < 1e-14, "a pitch squared");
        for (direction, (incidence, azimuth)) in table.axes.directions().enumerate() {
            let (i, a) = (direction / 6, direction % 6);
            let inside = (incidence.to_radians().sin() / index).asin().tan();
            let along = DVec2::from_angle(azimuth.to_radians());
            let slopes = along * inside;
            let (odd, straight, x) = layer(depth, thickness, slopes.x);
            let (odd_below, straight_below, y) = layer(depth, thickness, slopes.y);
            let name = format!("{depth} {thickness} {index}: {incidence}, {azimuth}");
            let eta = table.retroreflected[[i, a]];
            assert!((eta - odd * odd_below).abs() < 1e-11, "{name}: {eta}");
            let through = table.fate[[i, a, Fate::Transmitted as usize]];
            assert!(
                (through - straight * straight_below).abs() < 1e-11,
                "{name}: {through}"
            );
            // The lines of the lower layer are compared at its upper end.
            let lead = 2.0 * depth * slopes.y.abs();
            let expected = [x, y.map(|end| end + lead)];
            let mut area = 0.0;
            for path in &exact.paths[direction] {
                area += path.area();
                let [[uu, uv], [vu, vv]] = path.matrix;
                assert!(
                    (uu + 2.0).abs() < 1e-13 && (vv + 2.0).abs() < 1e-13,
                    "{name}"
                );
                assert_eq!(path.deviation, [0.0; 2], "{name}");
                for [u, v] in &path.polygon {
                    let shift =
                        DVec2::new(uu * u + uv * v, vu * u + vv * v) + DVec2::from(path.offset);
                    let shift = along * shift.x + along.perp() * shift.y;
                    for (axis, [low, high]) in expected.into_iter().enumerate() {
                        let at = shift[axis] * slopes[axis].signum();
                        assert!(
                            low - 1e-11 < at && at < high + 1e-11,
                            "{name}: {at} in {low} to {high}"
                        );
                    }
                }
            }
            // The map doubles both sides: the images of the paths fill the box, which has four
            // times their area.
            assert!((area - eta).abs() < 1e-11, "{name}");
            let [[a, b], [c, d]] = expected;
            assert!(
                ((b - a) * (d - c) - 4.0 * eta).abs() < 1e-10 || eta < 1e-11,
                "{name}"
            );
            cases += 1;
            imaged += usize::from(eta > 1e-6);
        }
    }
    println!("{cases} directions of 4 plates, {imaged} of them imaged");
    assert_eq!(cases, 144);
    assert!(imaged > 80, "{imaged}");
}

/// Rays agree with beams, with and without losses. Rays of a plate go one by one, by a tracer of
/// their own. Each fate of each direction is within 4.5 sigma of the exact share. By chance one of
/// 1,440 comparisons is beyond once in a hundred runs, and the seed is fixed.
#[test]
fn rays_agree_with_beams() {
    let plate = cell(3.0, 0.02);
    let (mut compared, mut worst) = (0, 0.0_f64);
    for losses in [Losses::None, Losses::Fresnel] {
        let asked = Request {
            refractive_index: Some(1.5),
            losses,
            reflectance: (losses == Losses::Fresnel).then_some(0.9),
            ..request()
        };
        let exact = bake(
            &plate,
            Request {
                method: Method::Exact,
                ..asked.clone()
            },
        );
        let rays = 20_000;
        let traced = bake(
            &plate,
            Request {
                method: Method::Rays,
                sampler: Sampler::Random,
                rays: Some(rays),
                ..asked
            },
        );
        for (at, &share) in exact.fate.indexed_iter() {
            let sigma = (share * (1.0 - share) / rays as f64).sqrt();
            let off = (traced.fate[at] - share).abs();
            // For a share of less than one ray, sigma has no meaning.
            assert!(
                off <= 4.5 * sigma + 2.0 / rays as f64,
                "{at:?}: {off} of {share}"
            );
            worst = worst.max(if share > 0.01 { off / sigma } else { 0.0 });
            compared += 1;
        }
        for (at, eta) in exact.retroreflected.indexed_iter() {
            let mean = |table: &Table, v: bool| -> f64 {
                let (step, range) = (2.0 * 8.0 / 128.0, 8.0);
                let histogram = table.histogram.index_axis(ndarray::Axis(0), at.0);
                let histogram = histogram.index_axis(ndarray::Axis(0), at.1);
                let centre = |k: usize| (k as f64 + 0.5) * step - range;
                histogram
                    .indexed_iter()
                    .map(|(bin, p)| p * centre(if v { bin.0 } else { bin.1 }))
                    .sum()
            };
            for v in [false, true] {
                let off = (mean(&exact, v) - mean(&traced, v)).abs();
                // Shifts fill a box of up to 2 pitches along x and along y: a standard deviation of
                // at most 0.82.
                assert!(
                    *eta < 1e-3 || off < 4.5 * 0.82 / (eta * rays as f64).sqrt(),
                    "{at:?}: {off}"
                );
                compared += 1;
            }
        }
    }
    println!("{compared} comparisons, the worst off by {worst:.2} sigma");
    // Ten fates without losses, twelve with them, and two more numbers.
    assert_eq!(compared, 36 * (10 + 2) + 36 * (12 + 2));
}
