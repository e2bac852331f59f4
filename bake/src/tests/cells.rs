//! Cells built by hand, so that the tracer is tested without the loaders.

use glam::{DVec2, DVec3};
use meshes::design::{Design, Shape};
use meshes::{Cell, CellOptions, Entrance, Mesh};

/// Height of the aperture plane of an ideal cube over its apex, edge lengths.
pub(super) const HEIGHT: f64 = 0.577_350_269_189_625_8;

/// Returns the ends of the three edges of an ideal cube, turned by `turn_deg` about n.
pub(super) fn edges(turn_deg: f64) -> [DVec3; 3] {
    [0.0, 120.0, 240.0].map(|azimuth: f64| {
        let (y, x) = (azimuth + turn_deg).to_radians().sin_cos();
        DVec3::new(
            x * (2.0_f64 / 3.0).sqrt(),
            y * (2.0_f64 / 3.0).sqrt(),
            HEIGHT,
        )
    })
}

/// Returns the facets of the cube with the apex at `apex` and the edge ends `ends`.
pub(super) fn faces(apex: DVec3, ends: [DVec3; 3]) -> Vec<[DVec3; 3]> {
    (0..3).map(|i| [apex, ends[i], ends[(i + 1) % 3]]).collect()
}

pub(super) fn cell(facets: Vec<[DVec3; 3]>, entrance: Entrance, design: &str) -> Cell {
    Cell {
        edge_length_from: meshes::EdgeLengthFrom::User,
        facets,
        normals: None,
        glass: Vec::new(),
        entrance,
        refractive_index: None,
        abbe_number: None,
        closed: false,
        edge_length: 1.0,
        unit: None,
        azimuth_zero: DVec3::X,
        design: design.into(),
        mesh_hash: String::new(),
        warnings: Vec::new(),
    }
}

/// Returns one ideal cube with a triangular aperture.
pub(super) fn triangular() -> Cell {
    let ends = edges(0.0);
    let polygon = ends.map(|end| end.truncate()).to_vec();
    cell(
        faces(DVec3::ZERO, ends),
        Entrance {
            height: HEIGHT,
            polygon,
            lattice: None,
        },
        "triangular",
    )
}

/// Returns a pair of cubes with unequal errors of its right angles, rad.
pub(super) fn uneven_pair(dihedral_error_rad: [f64; 3]) -> Cell {
    designed(&Design {
        dihedral_error_rad,
        ..Design::new(Shape::TriangularPair)
    })
}

/// Returns the cell of a design.
pub(super) fn designed(design: &Design) -> Cell {
    of_mesh(&design.mesh().expect("a design"), |_| ())
}

/// Returns the cell of a mesh, by the usual options with one change.
pub(super) fn of_mesh(mesh: &Mesh, change: impl FnOnce(&mut CellOptions)) -> Cell {
    let mut options = CellOptions::default();
    change(&mut options);
    meshes::normalise(mesh, "mesh.obj".as_ref(), &options).expect("a cell")
}

include!("../../../tests/eta.rs");

/// Returns the directions, degrees, in which a cell returns a known share of the light.
pub(super) fn listed(cell: &str) -> impl Iterator<Item = (f64, f64, f64)> {
    known_eta(cell).into_iter().filter(|row| !row.1.is_nan())
}

/// Returns incidences, degrees, with the share that a cube returns in the mean over all azimuths.
pub(super) fn listed_means() -> (Vec<f64>, Vec<f64>) {
    let means = known_eta("cube").into_iter().filter(|row| row.1.is_nan());
    means.map(|(incidence, _, eta)| (incidence, eta)).unzip()
}

/// Returns a cube and its copy turned by 180 deg, which share the rim edge opposite the first edge.
pub(super) fn pair() -> Cell {
    let ends = edges(0.0);
    let centre = (ends[1] + ends[2]).truncate() / 2.0;
    let turned = |p: DVec3| (2.0 * centre - p.truncate()).extend(p.z);
    let mut facets = faces(DVec3::ZERO, ends);
    facets.extend(faces(
        turned(DVec3::ZERO),
        [turned(ends[0]), ends[2], ends[1]],
    ));
    let polygon = [ends[0], ends[1], turned(ends[0]), ends[2]]
        .map(|p| p.truncate())
        .to_vec();
    cell(
        facets,
        Entrance {
            height: HEIGHT,
            polygon,
            lattice: None,
        },
        "triangular-pair",
    )
}

/// Returns a periodic array of full cubes: square faces, hexagonal outline, non-planar rim.
pub(super) fn full_cube() -> Cell {
    let e = edges(0.0);
    let mut facets = Vec::new();
    for i in 0..3 {
        let (a, b) = (e[i], e[(i + 1) % 3]);
        facets.push([DVec3::ZERO, a, a + b]);
        facets.push([DVec3::ZERO, a + b, b]);
    }
    // Two neighbours share a part of their rims: the lattice vectors are differences of edges and
    // have no height.
    let lattice = [(e[0] - e[2]).truncate(), (e[1] - e[0]).truncate()];
    let corner = -(lattice[0] + lattice[1]) / 2.0;
    let polygon = vec![
        corner,
        corner + lattice[0],
        corner + lattice[0] + lattice[1],
        corner + lattice[1],
    ];
    let entrance = Entrance {
        height: 2.0 * HEIGHT,
        polygon,
        lattice: Some(lattice),
    };
    assert!(lattice[0].perp_dot(lattice[1]) > 0.0);
    cell(facets, entrance, "full-cube")
}

/// Returns twice the area of a polygon, positive if it runs counter-clockwise.
fn doubled_area(polygon: &[DVec2]) -> f64 {
    (0..polygon.len())
        .map(|i| polygon[i].perp_dot(polygon[(i + 1) % polygon.len()]))
        .sum()
}

/// Returns the area of a polygon, positive whichever way it runs.
pub(super) fn area(polygon: &[DVec2]) -> f64 {
    doubled_area(polygon).abs() / 2.0
}

/// Returns the part of a convex polygon with `normal` . p >= `offset` (Sutherland and Hodgman).
pub(super) fn clip(polygon: &[DVec2], normal: DVec2, offset: f64) -> Vec<DVec2> {
    let mut kept = Vec::new();
    for (i, &p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (hp, hq) = (normal.dot(p) - offset, normal.dot(q) - offset);
        if hp >= 0.0 {
            kept.push(p);
        }
        if (hp > 0.0 && hq < 0.0) || (hp < 0.0 && hq > 0.0) {
            kept.push(p + (q - p) * (hp / (hp - hq)));
        }
    }
    kept
}

/// Evaluates the closed form of an ideal hollow cube seen at the *inside* direction `travel`, cell
/// frame: the polygon of ray shifts, cell frame, and the retroreflected share.
///
/// With the apex q carried along the light and the aperture T, light enters in K = T intersected
/// with 2q - T, and its shift is 2 (q - p).
pub(super) fn closed_form(travel: DVec3, turn_deg: f64) -> (f64, Vec<DVec2>) {
    let triangle = edges(turn_deg).map(|end| end.truncate());
    // The apex seen along the ray is the point of the plane z = HEIGHT on the line through the
    // origin.
    let q = (travel * (HEIGHT / travel.z)).truncate();
    let mut k: Vec<DVec2> = triangle.to_vec();
    for i in 0..3 {
        let (a, b) = (2.0 * q - triangle[i], 2.0 * q - triangle[(i + 1) % 3]);
        let inward = (b - a).perp();
        k = clip(&k, inward, inward.dot(a));
    }
    let fraction = area(&k) / area(&triangle);
    (fraction, k.iter().map(|&p| 2.0 * (q - p)).collect())
}

/// Returns the area of the intersection of a convex polygon with each bin of [-range, range]^2, v
/// slow, u fast.
pub(super) fn bin_areas(polygon: &[DVec2], bins: usize, range: f64) -> Vec<f64> {
    let width = 2.0 * range / bins as f64;
    let edge = |i: usize| i as f64 * width - range;
    let mut areas = Vec::with_capacity(bins * bins);
    for v in 0..bins {
        let row = clip(&clip(polygon, DVec2::Y, edge(v)), -DVec2::Y, -edge(v + 1));
        for u in 0..bins {
            areas.push(area(&clip(
                &clip(&row, DVec2::X, edge(u)),
                -DVec2::X,
                -edge(u + 1),
            )));
        }
    }
    areas
}
