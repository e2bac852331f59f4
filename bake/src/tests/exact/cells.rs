//! Cells built by hand, independent of the mesh designs.

use crate::tests::cells;
use glam::{DMat3, DVec2, DVec3};
use meshes::{Cell, Entrance};

/// Numbers in [0, 1), equal in every run (splitmix64).
pub(crate) struct Draw(pub u64);

impl Draw {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Returns three perpendicular unit edges around +z. The projection of the first one is along +x.
pub(crate) fn ideal_edges() -> [DVec3; 3] {
    cells::edges(0.0)
}

pub(crate) fn cell(
    facets: Vec<[DVec3; 3]>,
    height: f64,
    polygon: Vec<DVec2>,
    lattice: Option<[DVec2; 2]>,
) -> Cell {
    let entrance = Entrance {
        height,
        polygon,
        lattice,
    };
    cells::cell(facets, entrance, "by hand")
}

/// Returns a single cube with its rim in the entrance plane.
pub(crate) fn single(edges: [DVec3; 3]) -> Cell {
    cell(
        cells::faces(DVec3::ZERO, edges),
        edges[0].z,
        edges.map(DVec3::truncate).to_vec(),
        None,
    )
}

/// Returns a cube and its copy turned by 180 deg about the middle of the rim between its first two
/// edges.
pub(crate) fn pair(edges: [DVec3; 3], periodic: bool) -> Cell {
    let middle = (edges[0] + edges[1]).truncate();
    let turn = |x: DVec3| (middle - x.truncate()).extend(x.z);
    let mut facets = cells::faces(DVec3::ZERO, edges);
    facets.extend(facets.clone().iter().map(|t| t.map(turn)));
    let [a, b, c] = edges.map(DVec3::truncate);
    let polygon = vec![c, a, middle - c, b];
    cell(
        facets,
        edges[0].z,
        polygon,
        periodic.then_some([a - c, b - c]),
    )
}

/// Returns the edges of a cube whose axis leans by `tilt_rad` towards +x, cut at the height
/// `height`.
pub(crate) fn canted_edges(tilt_rad: f64, height: f64) -> [DVec3; 3] {
    let lean = DMat3::from_rotation_y(tilt_rad);
    ideal_edges().map(|e| lean * e).map(|e| e * (height / e.z))
}

/// Returns edges that lean together or apart so that each dihedral angle is wider than 90 deg by
/// `errors_rad` (first order). The ends of the edges have one height.
pub(crate) fn bent_edges(errors_rad: [f64; 3]) -> [DVec3; 3] {
    let ideal = ideal_edges();
    // These are normals of the faces. A wider angle at edge i turns its two faces apart.
    let normal = |i: usize| ideal[(i + 2) % 3];
    let turned: Vec<DVec3> = (0..3)
        .map(|i| {
            let other = normal((i + 1) % 3);
            (normal(i) - errors_rad[(i + 1) % 3] * other).normalize()
        })
        .collect();
    // Edge i is shared by the faces (i, i + 1) and (i - 1, i).
    let edge = |i: usize| turned[(i + 2) % 3].cross(turned[i]);
    [edge(0), edge(1), edge(2)].map(|e| e * (1.0 / (3_f64.sqrt() * e.z)))
}

/// Returns a cube whose apex was cut off by a flat facet at `share` of the height: a flat gap at
/// the bottom.
pub(crate) fn blunt(share: f64) -> Cell {
    let edges = ideal_edges();
    let cut = edges.map(|e| e * share);
    let mut facets: Vec<[DVec3; 3]> = (0..3)
        .flat_map(|i| {
            let j = (i + 1) % 3;
            [[cut[i], edges[i], edges[j]], [cut[i], edges[j], cut[j]]]
        })
        .collect();
    facets.push([cut[0], cut[1], cut[2]]);
    cell(
        facets,
        edges[0].z,
        edges.map(DVec3::truncate).to_vec(),
        None,
    )
}

/// Returns a cube whose aperture triangle lost its three corners. The rim is a hexagon, closed by
/// upright walls.
pub(crate) fn truncated(share: f64) -> Cell {
    let edges = ideal_edges();
    let height = edges[0].z;
    let mut facets = Vec::new();
    let mut rim = Vec::new();
    for i in 0..3 {
        let (here, next, before) = (edges[i], edges[(i + 1) % 3], edges[(i + 2) % 3]);
        // The points on the rim near the corner, and the points where the upright wall through them
        // meets the edge.
        let (left, right) = (here.lerp(before, share), here.lerp(next, share));
        let middle = 0.5 * (left + right);
        let foot = here * (middle.truncate().length() / here.truncate().length());
        facets.push([foot, left, right]);
        let next_left = next.lerp(here, share);
        let next_right = next.lerp(before, share);
        let next_foot = next
            * ((0.5 * (next_left + next_right)).truncate().length() / next.truncate().length());
        // The face between the two edges has the corners apex, foot, right, next_left, next_foot.
        facets.push([DVec3::ZERO, foot, right]);
        facets.push([DVec3::ZERO, right, next_left]);
        facets.push([DVec3::ZERO, next_left, next_foot]);
        rim.extend([left.truncate(), right.truncate()]);
    }
    cell(facets, height, rim, None)
}
