//! A tracer in three dimensions that shares no sign with the model: a cube of three planes, the half
//! mirror as a reflection of the world, and a camera with a right-handed frame.

use edges::names::{Kernel, LobeShape};
use nalgebra::{Matrix3, Vector3};

use crate::planted::{Stream, truth};
use crate::simulate::PlantedSheet;

type V = Vector3<f64>;

/// Corner size, mm.
pub const C_MM: f64 = 0.6;
/// Incidence, degrees.
pub const INCIDENCE_DEG: f64 = 30.0;
/// Azimuth, degrees.
pub const AZIMUTH_DEG: f64 = 15.0;
/// Direction of the tangential axis in the picture, degrees.
pub const AXIS_DEG: f64 = 20.0;

/// A hollow cube and a camera far away, in mm. The sheet's normal is z and azimuth 0 is x.
pub struct World {
    /// Direction in which the light arrives, along the camera's view before any mirror.
    pub arriving: V,
    /// Direction of the light within the sheet.
    u: V,
    /// Reflection of all places and directions by the half mirror; the identity if the camera does
    /// not look into it.
    pub mirror: Matrix3<f64>,
}

impl World {
    /// Makes the world of a camera that sees the sheet itself or in the half mirror.
    pub fn new(seen_in_mirror: bool) -> World {
        let (sine, cosine) = INCIDENCE_DEG.to_radians().sin_cos();
        let (up, azimuth) = (V::z(), AZIMUTH_DEG.to_radians());
        let u = V::x() * azimuth.cos() + V::y() * azimuth.sin();
        let across = V::new(0.3, -0.5, 0.8).normalize();
        let reflection = Matrix3::identity() - across * across.transpose() * 2.0;
        World {
            arriving: u * sine - up * cosine,
            u,
            mirror: if seen_in_mirror {
                reflection
            } else {
                Matrix3::identity()
            },
        }
    }

    /// Returns the directions of columns and rows. The tangential axis, along which the light
    /// arrives, lies at `AXIS_DEG` in the picture. Columns, rows and the view are right-handed in
    /// every camera.
    pub fn columns_and_rows(&self) -> [V; 2] {
        let view = self.mirror * self.arriving;
        let along = self.u - self.arriving * self.u.dot(&self.arriving);
        let tangential = self.mirror * along.normalize();
        let (sine, cosine) = AXIS_DEG.to_radians().sin_cos();
        let below = view.cross(&tangential);
        let right = tangential * cosine - below * sine;
        [right, view.cross(&right)]
    }

    /// Traces one ray that enters the cube at `at` of its aperture (two numbers in 0..1). Returns
    /// the displacement of the light after three mirrors, (columns, rows) in mm, or `None` if the
    /// ray leaves earlier.
    fn trace(&self, at: [f64; 2]) -> Option<[f64; 2]> {
        // Edges of the cube from its apex: at right angles, and alike towards the normal.
        let edges = [0.0_f64, 120.0, 240.0].map(|turn| {
            let (sine, cosine) = turn.to_radians().sin_cos();
            let outward = V::new(cosine, sine, 0.0) * (2.0_f64 / 3.0).sqrt();
            outward + V::z() / 3.0_f64.sqrt()
        });
        // A point of the triangle between the ends of the edges, seen from the apex.
        let [s, t] = if at[0] + at[1] > 1.0 {
            at.map(|x| 1.0 - x)
        } else {
            at
        };
        let enters = (edges[0] * (1.0 - s - t) + edges[1] * s + edges[2] * t) * C_MM;
        let (mut place, mut ray) = (enters, self.arriving);
        let mut met = 0;
        let front = |place: &V, ray: &V| (enters.z - place.z) / ray.z;
        loop {
            let hit = |edge: &V| (-place.dot(edge) / ray.dot(edge), *edge);
            let approached = edges.iter().filter(|edge| ray.dot(edge) < 0.0).map(hit);
            let next = approached.min_by(|a, b| a.0.total_cmp(&b.0));
            let leaves = if ray.z > 0.0 {
                front(&place, &ray)
            } else {
                f64::INFINITY
            };
            match next {
                Some((far, normal)) if far < leaves => {
                    place += ray * far;
                    ray -= normal * (2.0 * ray.dot(&normal));
                    met += 1;
                }
                _ => {
                    place += ray * leaves;
                    break;
                }
            }
        }
        // The cube's opening is a triangle: outside of it a ray would meet the neighbour.
        let inside = edges.iter().all(|edge| place.dot(edge) > 0.0);
        (met == 3 && inside).then(|| {
            assert!((ray + self.arriving).norm() < 1e-12);
            let seen = self.mirror * (place - enters);
            self.columns_and_rows().map(|axis| seen.dot(&axis))
        })
    }
}

/// Light that a world sends back: displacements in pixels, and their share of all rays.
pub struct Traced {
    /// Displacements, pixels.
    pub offsets: Vec<[f64; 2]>,
    /// Share of the rays that come back.
    pub returned: f64,
}

/// Traces `side` x `side` rays, evenly spread over the aperture, one in each cell of a net.
pub fn traced(seen_in_mirror: bool, side: usize, pitch_mm: f64) -> Traced {
    let world = World::new(seen_in_mirror);
    let mut stream = Stream(3);
    let cells = (0..side).flat_map(|i| (0..side).map(move |j| [i, j]));
    let rays = cells.map(|cell| cell.map(|i| (i as f64 + stream.between(0.0, 1.0)) / side as f64));
    let rays: Vec<[f64; 2]> = rays.collect();
    let back = rays.iter().filter_map(|&at| world.trace(at));
    let offsets: Vec<[f64; 2]> = back.map(|at| at.map(|x| x / pitch_mm)).collect();
    Traced {
        returned: offsets.len() as f64 / rays.len() as f64,
        offsets,
    }
}

/// The sheet of the tests: single hollow cubes, whose blur is the ray shift alone.
pub fn sheet() -> PlantedSheet {
    PlantedSheet {
        refractive_index: 1.0,
        pair: false,
        ..truth(Kernel::Shift, LobeShape::Radial, 1.0, C_MM, 0.6)
    }
}

/// Returns the root mean square of the differences of two lists.
pub fn rms(a: &[f64], b: &[f64]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b).powi(2));
    (squares.sum::<f64>() / a.len() as f64).sqrt()
}
