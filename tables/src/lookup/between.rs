//! Interpolation of the polygons of an exact table between its directions.
//!
//! The lines on which the edges of a polygon lie are interpolated. Let tau = tan(incidence inside)
//! (cos azimuth, sin azimuth). The shadow of a planar facet's corner on the entrance plane is
//! linear in tau, however often the facet is unfolded. The line through two such shadows is linear
//! in tau too, up to a factor; for an ideal cube it keeps its slope. The corners of a polygon obey
//! no such law: they come and go as lines pass each other. If a direction lacks an edge, because
//! other lines lie before it, the line comes from the directions that have it. A path that ends
//! between two directions ends where its lines leave no area.
//!
//! Lines, maps and weights are interpolated by moving least squares. The result is the value of the
//! affine function of tau that fits the directions around best, with the inverse fourth power of
//! the distance as weight. It equals the table in the table's own directions, and the truth
//! wherever the truth is affine. Elsewhere the error is of second order in the spacing.
//!
//! Polygons are taken relative to the fixed point of their map, so that the map has no offset.
//! Cubes that lie elsewhere, as the images of symmetry and of a lattice do, then become the same
//! cube. The result is placed where the steepest direction has it.

use std::collections::HashSet;

use num_complex::Complex64;

use crate::table::exact::{Jones, Path};
use crate::table::polygon::{self, area};

/// Direction of the table near the direction that is asked for.
pub(crate) struct NearDirection {
    /// tan(incidence inside the sheet) (cos azimuth, sin azimuth).
    pub tau: [f64; 2],
    /// Azimuth of the frame of `paths`, radians.
    pub azimuth_rad: f64,
    /// Paths of the direction, in its incidence frame.
    pub paths: Vec<Path>,
    /// Share in a bilinear mixture of the four directions around; 0 for directions further away.
    pub share: f64,
    /// Corner of the gap, if the node is one: 1 for the greater incidence, and for the greater
    /// azimuth.
    pub corner: [f64; 2],
}

/// Greatest distance of the unit normals of two lines that may be one line that turned.
const SAME_SLOPE: f64 = 0.3;

/// Shortest edge that has a usable direction, edge lengths.
pub(crate) const SHORT: f64 = 1e-6;

/// Smallest area that is more than rounding, square edge lengths.
const NO_AREA: f64 = 1e-12;

/// Greatest move of a line for each unit of tau, edge lengths.
///
/// Light in a cube passes its height of 0.6 down and up, twice.
pub(crate) const FASTEST: f64 = 4.0;

/// Greatest change of the numbers of [`astray`] for each unit of tau, as a part of the greatest of
/// these numbers.
///
/// They are w x (tau, -1) for light that is turned by the small rotation w. They change by |w| at
/// most, and they are |w| where w lies across the light. The turn about the normal, w_z, is
/// compared beside them; the map shows it up to a part of |tau|.
const TURN: f64 = 1.5;

/// Rotation of light, rad, below which paths are not told apart by it: far above rounding, far
/// below any error of a facet.
const LEAST_ASTRAY: f64 = 1e-9;

/// Part of a path's area from which on its absence in a direction is a jump.
///
/// The lines of the path are continued to the direction that lacks it. If they leave more than this
/// part there, the path ends by a jump, as at the limit of total reflection.
const JUMP: f64 = 0.25;

/// Returns the shapes of the paths of each node, or `None` if one cannot be interpolated.
pub(crate) fn shapes(nodes: &[NearDirection], index: f64) -> Option<Vec<Vec<PathShape>>> {
    let of = |node: &NearDirection| {
        let shapes = node
            .paths
            .iter()
            .map(|path| PathShape::new(path, node, index));
        shapes.collect()
    };
    nodes.iter().map(of).collect()
}

/// Returns the nodes with a share that lack a family by a jump.
pub(crate) fn absent<'a>(
    nodes: &'a [NearDirection],
    family: &[(usize, usize)],
    lines: &[LineTrack],
    members: &[(&NearDirection, &PathShape)],
) -> Vec<&'a NearDirection> {
    let lacking = nodes.iter().enumerate().filter(|&(index, node)| {
        let lacks = node.share > 0.0 && family.iter().all(|&(member, _)| member != index);
        let there = || area(&outline(lines, members, node.tau));
        lacks && there() > JUMP * members[0].1.area
    });
    lacking.map(|(_, node)| node).collect()
}

/// Returns the paths at `tau` in the frame of `azimuth_rad`, interpolated between `nodes`.
///
/// `index` is the refractive index of the sheet. Returns `None` if the paths of the nodes cannot be
/// interpolated: a polygon is not convex, or a map cannot be inverted.
pub(crate) fn paths(
    nodes: &[NearDirection],
    tau: [f64; 2],
    azimuth_rad: f64,
    index: f64,
) -> Option<Vec<Path>> {
    let seen = shapes(nodes, index)?;
    let mut paths = Vec::new();
    let families = families(nodes, &seen);
    let places = places(&families, &seen);
    for (family, place) in families.into_iter().zip(places) {
        let members: Vec<(&NearDirection, &PathShape)> = family
            .iter()
            .map(|&(node, path)| (&nodes[node], &seen[node][path]))
            .collect();
        let lines = lines(&members);
        let polygon = outline(&lines, &members, tau);
        if area(&polygon) <= NO_AREA {
            continue;
        }
        let absent = absent(nodes, &family, &lines, &members);
        let present = 1.0 - absent.iter().map(|node| node.share).sum::<f64>();
        let taus: Vec<[f64; 2]> = members.iter().map(|(node, _)| node.tau).collect();
        let weights = weights(&taus, tau);
        // The mean is taken relative to the first member: a value that all members share comes out
        // unchanged, to the last digit.
        let seed = members[0].1;
        let mean = |value: &dyn Fn(&PathShape) -> f64| -> f64 {
            let beyond = members.iter().map(|(_, shape)| value(shape) - value(seed));
            let beyond = beyond.zip(&weights).map(|(value, weight)| weight * value);
            value(seed) + beyond.sum::<f64>()
        };
        let weight = mean(&|shape| shape.weight).clamp(0.0, 1.0) * present.max(0.0);
        if weight <= 0.0 {
            continue;
        }
        let [uu, uv, vu, vv] =
            [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[r, c]| mean(&|s| s.matrix[r][c]));
        let matrix = turned_map([[uu, uv], [vu, vv]], -azimuth_rad);
        let [x, y] = turned(place, -azimuth_rad);
        let placed = |&p: &[f64; 2]| {
            let [u, v] = turned(p, -azimuth_rad);
            [u + x, v + y]
        };
        paths.push(Path {
            polygon: polygon.iter().map(placed).collect(),
            matrix,
            offset: matrix.map(|row| -(row[0] * x + row[1] * y)),
            weight,
            deviation: deviation(
                turned([0, 1].map(|k| mean(&|s| s.astray[k])), -azimuth_rad),
                tau,
                index,
            ),
            passes: seed.passes,
            jones: between(&members, &weights).map(|jones| scaled(jones, -azimuth_rad, weight)),
        });
    }
    Some(paths)
}

/// Returns where the polygons of each family are placed: where one of its cube's families has its
/// seed. Pieces of one cube, which have one fixed point in some direction, then still meet, and
/// pieces of different cubes do not.
fn places(families: &[Vec<(usize, usize)>], seen: &[Vec<PathShape>]) -> Vec<[f64; 2]> {
    const SAME: f64 = 1e-3;
    let fixed = |&(node, path): &(usize, usize)| seen[node][path].fixed;
    let of_one_cube = |a: &[(usize, usize)], b: &[(usize, usize)]| {
        a.iter().any(|own| {
            let other = b.iter().find(|other| other.0 == own.0);
            other.is_some_and(|other| distance(fixed(own), fixed(other)) < SAME)
        })
    };
    let mut places: Vec<[f64; 2]> = Vec::new();
    for (k, family) in families.iter().enumerate() {
        let known = (0..k).find(|&other| of_one_cube(family, &families[other]));
        places.push(known.map_or_else(|| fixed(&family[0]), |other| places[other]));
    }
    places
}

/// Jones matrix between fields along the axes x and y of azimuth 0, seen from above.
type Planar = [[Complex64; 2]; 2];

/// Turns a Jones matrix of the incidence frame at an azimuth to the frame of azimuth 0.
///
/// Near normal incidence s and p turn with the azimuth, and the fields do not: there s lies along v,
/// and p along -u before the sheet and along u behind it. Only after this turn can neighbours be
/// averaged.
fn planar(jones: &Jones, azimuth_rad: f64) -> Planar {
    let [[ss, sp], [ps, pp]] = jones.map(|row| row.map(|[re, im]| Complex64::new(re, im)));
    turned_field([[-pp, ps], [-sp, ss]], azimuth_rad)
}

/// Turns a matrix between fields along u and v to axes that are `angle` behind them.
fn turned_field([[uu, uv], [vu, vv]]: Planar, angle: f64) -> Planar {
    let parts = |part: fn(&Complex64) -> f64| {
        turned_map([[part(&uu), part(&uv)], [part(&vu), part(&vv)]], angle)
    };
    let (re, im) = (parts(|z| z.re), parts(|z| z.im));
    [0, 1].map(|row| [0, 1].map(|column| Complex64::new(re[row][column], im[row][column])))
}

/// Returns the mean of the Jones matrices of a family; `None` if a member has none.
fn between(members: &[(&NearDirection, &PathShape)], weights: &[f64]) -> Option<Planar> {
    let mut mean = Planar::default();
    for ((_, shape), weight) in members.iter().zip(weights) {
        let own = shape.jones?;
        for (mean, own) in mean.as_flattened_mut().iter_mut().zip(own.as_flattened()) {
            *mean += own * weight;
        }
    }
    Some(mean)
}

/// Turns a mean back to an azimuth, and gives it the power that a path returns: the mean of phases
/// that differ is too short.
fn scaled(jones: Planar, angle: f64, power: f64) -> Jones {
    let [[uu, uv], [vu, vv]] = turned_field(jones, angle);
    let own: f64 = jones.as_flattened().iter().map(Complex64::norm_sqr).sum();
    let scale = (2.0 * power / own.max(f64::MIN_POSITIVE)).sqrt();
    [[vv, -vu], [uv, -uu]].map(|row| row.map(|z| [scale * z.re, scale * z.im]))
}

/// Returns the direction straight back outside, as its parts along the sheet and up, and 1 /
/// cos(incidence inside).
fn back(tau: [f64; 2], index: f64) -> (f64, f64, f64) {
    let steep = (1.0 + dot(tau, tau)).sqrt();
    let along = index * dot(tau, tau).sqrt() / steep;
    (-along, (1.0 - along * along).max(0.0).sqrt(), steep)
}

/// Converts a deviation ([`Path::deviation`], incidence frame) to numbers that are affine in tau.
fn astray(deviation: [f64; 2], tau: [f64; 2], index: f64) -> [f64; 2] {
    if deviation == [0.0; 2] {
        return deviation;
    }
    let (along, up, steep) = back(tau, index);
    // `bake` defines the deviation as straight back plus tangents across it. Snell's law keeps the
    // part along the sheet times the index.
    let [across, v] = deviation;
    let length = (1.0 + across * across + v * v).sqrt();
    let left = [along + across * up, v].map(|x| x / (length * index));
    [steep * left[0] - along * steep / index, steep * left[1]]
}

/// Converts numbers that are affine in tau to a deviation; the inverse of [`astray`].
pub(crate) fn deviation(astray: [f64; 2], tau: [f64; 2], index: f64) -> [f64; 2] {
    if astray == [0.0; 2] {
        return astray;
    }
    let (along, up, steep) = back(tau, index);
    let [x, y] = [along + index * astray[0] / steep, index * astray[1] / steep];
    let z = (1.0 - x * x - y * y).max(0.0).sqrt();
    let straight = x * along + z * up;
    [(x * up - z * along) / straight, y / straight]
}

/// Turns a vector counter-clockwise by `angle`, radians.
fn turned([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

/// Turns a linear map, R M transpose(R): first its columns, then its rows.
fn turned_map([[a, b], [c, d]]: [[f64; 2]; 2], angle: f64) -> [[f64; 2]; 2] {
    let ([a, c], [b, d]) = (turned([a, c], angle), turned([b, d], angle));
    [turned([a, b], angle), turned([c, d], angle)]
}

/// Returns the scalar product.
fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Returns the distance of two points.
pub(crate) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Half-plane normal . p <= offset.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line {
    pub normal: [f64; 2],
    pub offset: f64,
}

/// Path in the frame of azimuth 0, relative to the fixed point of its map.
pub(crate) struct PathShape {
    pub corners: Vec<[f64; 2]>,
    lines: Vec<Line>,
    area: f64,
    /// Fixed point of the map in the frame of azimuth 0, with the origin of the table's polygons.
    fixed: [f64; 2],
    pub matrix: [[f64; 2]; 2],
    pub weight: f64,
    /// Deviation in a form that is affine in tau; 0 for an ideal cube.
    ///
    /// It is the part along the sheet of (M + 1) (tau, -1), where M is the linear map of the path
    /// inside.
    pub astray: [f64; 2],
    pub passes: u32,
    jones: Option<Planar>,
}

impl PathShape {
    /// Makes the shape of a path, or `None` if the polygon is not convex or the map has no fixed
    /// point.
    fn new(path: &Path, node: &NearDirection, index: f64) -> Option<PathShape> {
        let azimuth_rad = node.azimuth_rad;
        let ([[a, b], [c, d]], [u, v]) = (path.matrix, path.offset);
        let determinant = a * d - b * c;
        if determinant.abs() < 1e-3 {
            return None;
        }
        let fixed = [(b * v - d * u) / determinant, (c * u - a * v) / determinant];
        let corners: Vec<[f64; 2]> = path
            .polygon
            .iter()
            .map(|p| turned([p[0] - fixed[0], p[1] - fixed[1]], azimuth_rad))
            .collect();
        let ends = corners.iter().zip(corners.iter().cycle().skip(1));
        let lines: Vec<Line> = ends
            .filter(|(a, b)| distance(**a, **b) > SHORT)
            .map(|(a, b)| {
                let length = distance(*a, *b);
                let normal = [(b[1] - a[1]) / length, (a[0] - b[0]) / length];
                Line {
                    normal,
                    offset: dot(normal, [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]),
                }
            })
            .collect();
        let inside = |line: &Line| {
            corners
                .iter()
                .all(|&p| dot(line.normal, p) <= line.offset + SHORT)
        };
        lines.iter().all(inside).then(|| PathShape {
            area: area(&corners),
            fixed: turned(fixed, azimuth_rad),
            lines,
            corners,
            matrix: turned_map(path.matrix, azimuth_rad),
            weight: path.weight,
            astray: turned(astray(path.deviation, node.tau, index), azimuth_rad),
            passes: path.passes,
            jones: path.jones.as_ref().map(|jones| planar(jones, azimuth_rad)),
        })
    }

    /// Returns the turn of the light about the normal of the sheet, w_z of [`TURN`].
    ///
    /// Exit directions near normal incidence do not show it.
    fn about(&self) -> f64 {
        let [[_, b], [c, _]] = self.matrix;
        0.5 * (c - b)
    }

    /// Returns the greatest reach of the polygon along `normal`.
    fn reach(&self, normal: [f64; 2]) -> f64 {
        let along = self.corners.iter().map(|&p| dot(normal, p));
        along.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns the greatest difference of the reaches of two polygons along all their normals.
    fn unlike(&self, other: &PathShape) -> f64 {
        let normals = self
            .lines
            .iter()
            .chain(&other.lines)
            .map(|line| line.normal);
        let apart = normals.map(|normal| (self.reach(normal) - other.reach(normal)).abs());
        apart.fold(0.0, f64::max)
    }
}

/// Picks pairs from `costs`, the cheapest first, with each row and each column at most once.
fn assigned(mut costs: Vec<(f64, usize, usize)>) -> Vec<(usize, usize)> {
    costs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut rows, mut columns) = (HashSet::new(), HashSet::new());
    let mut pairs: Vec<(usize, usize)> = Vec::new();
    for (_, row, column) in costs {
        if !rows.contains(&row) && columns.insert(column) {
            rows.insert(row);
            pairs.push((row, column));
        }
    }
    pairs
}

/// Groups the paths of all nodes into families of (node, path): one family is one path of the
/// sheet.
///
/// A family begins at one of the four directions around, at the steepest that has the path. It goes
/// on from there to the next nodes. The steepest is first because cubes of all orientations look
/// alike at normal incidence, and after a wide turn one cube looks like another.
pub(crate) fn families(
    nodes: &[NearDirection],
    seen: &[Vec<PathShape>],
) -> Vec<Vec<(usize, usize)>> {
    let steepness = |index: usize| dot(nodes[index].tau, nodes[index].tau);
    let (mut order, mut rest): (Vec<usize>, Vec<usize>) =
        (0..nodes.len()).partition(|&index| nodes[index].share > 0.0);
    order.sort_by(|&a, &b| steepness(b).total_cmp(&steepness(a)));
    let away = |index: usize| {
        let corners = order
            .iter()
            .map(|&corner| distance(nodes[corner].tau, nodes[index].tau));
        corners.fold(f64::INFINITY, f64::min)
    };
    rest.sort_by(|&a, &b| away(a).total_cmp(&away(b)));
    order.extend(rest);
    // Light of one path hardly turns against the errors of its facets. So exit directions tell
    // paths apart whose polygons are alike, as those of one cube with errors are at its limit.
    let lengths = seen.iter().flatten().map(|s| distance(s.astray, [0.0; 2]));
    let most_astray = lengths.fold(0.0, f64::max);
    let mut families: Vec<Vec<(usize, usize)>> = Vec::new();
    for index in order {
        let mut costs = Vec::new();
        for (which, family) in families.iter().enumerate() {
            // A member that is less than half as steep is too flat to compare with.
            let tells = |&&(node, _): &&(usize, usize)| 4.0 * steepness(node) >= steepness(index);
            let apart = |node: usize| distance(nodes[index].tau, nodes[node].tau);
            let nearest = family
                .iter()
                .filter(tells)
                .min_by(|a, b| apart(a.0).total_cmp(&apart(b.0)));
            let &(like, first) = nearest.unwrap_or(&family[0]);
            let most = FASTEST * apart(like) + SHORT;
            for (path, shape) in seen[index].iter().enumerate() {
                let known = &seen[like][first];
                let unlike = shape.unlike(known);
                // Ideal cells have rounding errors only, which must not break ties.
                let turned = if most_astray > LEAST_ASTRAY {
                    let about = shape.about() - known.about();
                    distance(shape.astray, known.astray).hypot(about) / most_astray
                } else {
                    0.0
                };
                let turns = turned <= TURN * apart(like) + SHORT;
                if unlike <= most && turns && shape.passes == known.passes {
                    costs.push((unlike + FASTEST * turned, which, path));
                }
            }
        }
        let pairs = assigned(costs);
        for &(which, path) in &pairs {
            families[which].push((index, path));
        }
        if nodes[index].share > 0.0 {
            let free = |path: &usize| pairs.iter().all(|(_, taken)| taken != path);
            let new = (0..seen[index].len()).filter(free);
            families.extend(new.map(|path| vec![(index, path)]));
        }
    }
    families
}

/// Line as the directions that have it show it: tau and the line there.
pub(crate) type LineTrack = Vec<([f64; 2], Line)>;

/// Finds the lines of a family.
pub(crate) fn lines(members: &[(&NearDirection, &PathShape)]) -> Vec<LineTrack> {
    let mut courses: Vec<LineTrack> = Vec::new();
    // For each line, the members that have it as an edge.
    let mut holders: Vec<Vec<usize>> = Vec::new();
    for (member, (node, shape)) in members.iter().enumerate() {
        let mut costs = Vec::new();
        for (which, course) in courses.iter().enumerate() {
            let near = course
                .iter()
                .min_by(|a, b| distance(a.0, node.tau).total_cmp(&distance(b.0, node.tau)));
            let known = near.map_or(course[0].1, |near| near.1);
            for (index, line) in shape.lines.iter().enumerate() {
                let turn = distance(line.normal, known.normal);
                if turn < SAME_SLOPE {
                    costs.push((turn + (line.offset - known.offset).abs(), which, index));
                }
            }
        }
        let pairs = assigned(costs);
        for (index, &line) in shape.lines.iter().enumerate() {
            let known = pairs.iter().find(|(_, taken)| *taken == index);
            let which = known.map_or(courses.len(), |&(which, _)| which);
            if which == courses.len() {
                courses.push(Vec::new());
                holders.push(Vec::new());
            }
            courses[which].push((node.tau, line));
            holders[which].push(member);
        }
    }
    for (course, holders) in courses.iter_mut().zip(&holders) {
        keep_clear(course, members, holders);
    }
    courses
}

/// Keeps a line clear of the polygons of the members that lack it.
///
/// In such a member the line lies beyond the polygon. If the other members' lines would lead it
/// through the polygon, a line is added that touches the polygon. It moves the line elsewhere, so
/// this goes on until the line is clear of all.
fn keep_clear(course: &mut LineTrack, members: &[(&NearDirection, &PathShape)], holders: &[usize]) {
    let mut without: Vec<usize> = (0..members.len())
        .filter(|member| !holders.contains(member))
        .collect();
    loop {
        let mut touching = LineTrack::new();
        without.retain(|&member| {
            let (node, shape) = members[member];
            let Line { normal, offset } = line_at(course, node.tau);
            let reach = shape.reach(normal);
            let clear = offset >= reach;
            if !clear {
                let line = Line {
                    normal,
                    offset: reach,
                };
                touching.push((node.tau, line));
            }
            clear
        });
        if touching.is_empty() {
            return;
        }
        course.extend(touching);
    }
}

/// Interpolates a line at `tau`; its normal need not be of unit length.
fn line_at(course: &LineTrack, tau: [f64; 2]) -> Line {
    let places: Vec<[f64; 2]> = course.iter().map(|(place, _)| *place).collect();
    let (mut normal, mut offset) = ([0.0; 2], 0.0);
    for (weight, (_, line)) in weights(&places, tau).into_iter().zip(course) {
        normal = [0, 1].map(|k| normal[k] + weight * line.normal[k]);
        offset += weight * line.offset;
    }
    Line { normal, offset }
}

/// Returns the polygon that the lines leave at `tau`, empty if they leave nothing.
///
/// Nothing is left where the polygons of the members cannot have moved to. Lines that hardly turn
/// from each other can meet far away, after the path between them has ended.
fn outline(
    courses: &[LineTrack],
    members: &[(&NearDirection, &PathShape)],
    tau: [f64; 2],
) -> Vec<[f64; 2]> {
    let moved = members
        .iter()
        .map(|(node, _)| FASTEST * distance(node.tau, tau));
    let margin = moved.fold(f64::INFINITY, f64::min) + SHORT;
    let corners = || members.iter().flat_map(|(_, shape)| &shape.corners);
    let side = |axis: usize| {
        let along = || corners().map(|corner| corner[axis]);
        let low = along().fold(f64::INFINITY, f64::min) - margin;
        (low, along().fold(f64::NEG_INFINITY, f64::max) + margin)
    };
    let ((left, right), (low, high)) = (side(0), side(1));
    let mut polygon = vec![[left, low], [right, low], [right, high], [left, high]];
    for course in courses {
        polygon = clipped(&polygon, line_at(course, tau));
    }
    polygon
}

/// Returns the part of a convex polygon in a half-plane.
pub(crate) fn clipped(polygon: &[[f64; 2]], line: Line) -> Vec<[f64; 2]> {
    let beyond = |p: [f64; 2]| dot(line.normal, p) - line.offset;
    let on = |p: [f64; 2], q: [f64; 2], part: f64| [0, 1].map(|k| p[k] + part * (q[k] - p[k]));
    polygon::clip(polygon, beyond, on)
}

/// Returns the shares of values at `places` in the interpolated value at `tau`.
///
/// They belong to the best affine function by the weights 1 / distance^4. If the places lie on one
/// line, the function does not change across it.
pub(crate) fn weights(places: &[[f64; 2]], tau: [f64; 2]) -> Vec<f64> {
    let nearest = places
        .iter()
        .map(|&place| distance(place, tau))
        .fold(f64::INFINITY, f64::min);
    if nearest == 0.0 {
        let here: Vec<f64> = places
            .iter()
            .map(|&place| f64::from(u8::from(place == tau)))
            .collect();
        let count: f64 = here.iter().sum();
        return here.iter().map(|one| one / count).collect();
    }
    let terms: Vec<(f64, [f64; 3])> = places
        .iter()
        .map(|place| {
            let [x, y] = [0, 1].map(|k| (place[k] - tau[k]) / nearest);
            ((x * x + y * y).powi(-2), [1.0, x, y])
        })
        .collect();
    let mut normal = [[0.0; 3]; 3];
    for (weight, basis) in &terms {
        for (row, a) in normal.iter_mut().zip(basis) {
            for (sum, b) in row.iter_mut().zip(basis) {
                *sum += weight * a * b;
            }
        }
    }
    // The ridge makes slopes 0 that nothing determines. It is small, because close to a direction
    // the weights of the others are small, and they alone determine the slopes.
    let ridge = 1e-12 * normal[0][0];
    normal[1][1] += ridge;
    normal[2][2] += ridge;
    let [[a, b, c], [_, d, e], [_, _, f]] = normal;
    // First column of the inverse, by cofactors.
    let column = [d * f - e * e, c * e - b * f, b * e - c * d];
    let determinant = a * column[0] + b * column[1] + c * column[2];
    let value = |(weight, basis): &(f64, [f64; 3])| {
        let sum: f64 = basis.iter().zip(&column).map(|(x, y)| x * y).sum();
        weight * sum / determinant
    };
    terms.iter().map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the aperture of an ideal cube of edge 1, its centroid in the origin, its first
    /// corner at azimuth 0.
    fn triangle() -> Vec<[f64; 2]> {
        let radius = (2.0_f64 / 3.0).sqrt();
        let corner = |k: u32| turned([radius, 0.0], f64::from(k) * 120_f64.to_radians());
        (0..3).map(corner).collect()
    }

    fn tau(incidence_deg: f64, azimuth_deg: f64) -> [f64; 2] {
        let tangent = incidence_deg.to_radians().tan();
        turned([tangent, 0.0], azimuth_deg.to_radians())
    }

    /// Returns the path of a cube by its closed form, or `None` if nothing returns.
    ///
    /// Light that enters at p in T leaves at 2 q - p in T, where q is the apex seen along the
    /// light.
    fn path(tau: [f64; 2], turn: f64) -> Option<Path> {
        let q = tau.map(|x| -x / 3_f64.sqrt());
        let corners: Vec<[f64; 2]> = triangle().iter().map(|&p| turned(p, turn)).collect();
        let mut polygon = corners.clone();
        for (k, a) in corners.iter().enumerate() {
            let b = corners[(k + 1) % 3];
            // Edge of the triangle turned about q by half a turn: the normal changes its sign.
            let normal = [a[1] - b[1], b[0] - a[0]];
            let offset = 2.0 * dot(normal, q) - dot(normal, *a);
            polygon = clipped(&polygon, Line { normal, offset });
        }
        (area(&polygon) > 1e-9).then(|| Path {
            polygon,
            matrix: [[-2.0, 0.0], [0.0, -2.0]],
            offset: q.map(|x| 2.0 * x),
            weight: 1.0,
            deviation: [0.0; 2],
            passes: 0,
            jones: None,
        })
    }

    /// Returns directions all around in steps of `step_deg`, each in its own frame.
    fn nodes(incidences: &[f64], step_deg: f64, cubes: &[f64]) -> Vec<NearDirection> {
        let azimuths: Vec<f64> = (0..(360.0 / step_deg) as u32)
            .map(|k| f64::from(k) * step_deg)
            .collect();
        let count = (azimuths.len() * incidences.len()) as f64;
        let node = |azimuth: f64, incidence: f64| {
            let (tau, azimuth_rad) = (tau(incidence, azimuth), azimuth.to_radians());
            let paths = cubes.iter().filter_map(|&turn| path(tau, turn));
            let turned = |path: Path| Path {
                polygon: path
                    .polygon
                    .iter()
                    .map(|&p| turned(p, -azimuth_rad))
                    .collect(),
                offset: turned(path.offset, -azimuth_rad),
                ..path
            };
            NearDirection {
                tau,
                azimuth_rad,
                paths: paths.map(turned).collect(),
                share: 1.0 / count,
                corner: [0.0; 2],
            }
        };
        let around = azimuths
            .iter()
            .flat_map(|&a| incidences.iter().map(move |&i| node(a, i)));
        around.collect()
    }

    include!("../../../tests/eta.rs");

    /// Returns the known shares of the hollow cube up to 45 degrees.
    fn known() -> Vec<(f64, f64, f64)> {
        let within = |&(incidence, azimuth, _): &(f64, f64, f64)| {
            (1.0..=45.0).contains(&incidence) && !azimuth.is_nan()
        };
        known_eta("cube").into_iter().filter(within).collect()
    }

    /// Checks an ideal cube between few directions.
    ///
    /// Hexagons lose corners at 19.47 deg and paths end at 35.26 deg. Neither incidence is in the
    /// table.
    #[test]
    fn an_ideal_cube_is_exact_between_few_directions() {
        let whole = area(&triangle());
        let nodes = nodes(&[0.0, 15.0, 28.0], 60.0, &[0.0]);
        let mut cases = 0;
        for (incidence, azimuth, eta) in known() {
            let paths = paths(&nodes, tau(incidence, azimuth), 0.0, 1.0).unwrap();
            let found: f64 = paths.iter().map(|path| area(&path.polygon)).sum();
            // The figures are rounded to 5 digits.
            assert!(
                (found / whole - eta).abs() < 6e-6,
                "{incidence} {azimuth}: {}",
                found / whole
            );
            cases += 1;
        }
        // Below 19.47 deg the share is (2/3)(1 - 2 tan^2); the ridge costs 1e-10 of the slopes.
        for step in 0..200 {
            let (incidence, azimuth) = (f64::from(step) * 0.0973, f64::from(step) * 1.9);
            let paths = paths(&nodes, tau(incidence, azimuth), azimuth.to_radians(), 1.0).unwrap();
            let found: f64 = paths.iter().map(|path| area(&path.polygon)).sum();
            let tangent = incidence.to_radians().tan();
            let eta = 2.0 / 3.0 * (1.0 - 2.0 * tangent * tangent);
            assert!(
                (found / whole - eta).abs() < 1e-8,
                "{incidence}: {} {eta}",
                found / whole
            );
            cases += 1;
        }
        assert_eq!(cases, 212);
    }

    /// Checks that two cubes stay two: cubes of both orientations look alike at normal incidence,
    /// and the families must not mix them.
    #[test]
    fn a_pair_stays_two_cubes() {
        let half_turn = std::f64::consts::PI;
        let mut cases = 0;
        for step in 0..300 {
            let azimuth = f64::from(step) * 7.3;
            let tau = tau(f64::from(step % 60) * 0.5, azimuth);
            // Keep the two azimuths around and the next ones beyond them.
            let mut nodes = nodes(&[0.0, 15.0, 28.0], 30.0, &[0.0, half_turn]);
            let away = |node: &NearDirection| {
                let away = (node.azimuth_rad.to_degrees() - azimuth).rem_euclid(360.0);
                away.min(360.0 - away)
            };
            nodes.retain(|node| away(node) < 60.0);
            for node in &mut nodes {
                node.share = if away(node) < 30.0 { 1.0 / 6.0 } else { 0.0 };
            }
            let found = paths(&nodes, tau, 0.0, 1.0).unwrap();
            let mut areas: Vec<f64> = found.iter().map(|path| area(&path.polygon)).collect();
            let expected = [0.0, half_turn].map(|turn| path(tau, turn));
            let mut expected: Vec<f64> = expected
                .iter()
                .flatten()
                .map(|p| area(&p.polygon))
                .collect();
            areas.sort_by(f64::total_cmp);
            expected.sort_by(f64::total_cmp);
            assert_eq!(areas.len(), expected.len(), "{step}");
            assert!(
                areas
                    .iter()
                    .zip(&expected)
                    .all(|(a, b)| (a - b).abs() < 1e-8),
                "{step}: {areas:?} {expected:?}"
            );
            cases += 1;
        }
        assert_eq!(cases, 300);
    }

    #[test]
    fn a_path_that_jumps_away_keeps_the_share_of_those_that_have_it() {
        let mut nodes = nodes(&[0.0, 15.0], 60.0, &[0.0]);
        nodes[1].paths.clear();
        let paths = paths(&nodes, tau(10.0, 0.0), 0.0, 1.0).unwrap();
        assert_eq!(paths.len(), 1);
        assert!((paths[0].weight - 11.0 / 12.0).abs() < 1e-9);
    }

    /// Checks deviations between directions: the light of a path is off by one rotation at every
    /// direction, seen through the front face.
    #[test]
    fn deviations_are_exact_between_directions() {
        let (index, axis) = (1.49, [3e-3, -2e-3, 5e-3]);
        // (M + 1) d for M = -(1 + axis x), a rotation by the angles of `axis` to first order. Any
        // other linear map would do.
        let off = |tau: [f64; 2]| {
            let [x, y, z] = [tau[0], tau[1], -1.0];
            [axis[2] * y - axis[1] * z, axis[0] * z - axis[2] * x]
        };
        let seen =
            |at: [f64; 2], azimuth_rad: f64| deviation(turned(off(at), -azimuth_rad), at, index);
        let mut nodes = nodes(&[0.0, 15.0, 28.0], 60.0, &[0.0]);
        for node in &mut nodes {
            for path in &mut node.paths {
                path.deviation = seen(node.tau, node.azimuth_rad);
            }
        }
        let mut cases = 0;
        for step in 0..200 {
            let (incidence, azimuth) = (f64::from(step) * 0.0973, f64::from(step) * 1.9);
            let (at, azimuth_rad) = (tau(incidence, azimuth), azimuth.to_radians());
            let paths = paths(&nodes, at, azimuth_rad, index).unwrap();
            let truth = seen(at, azimuth_rad);
            // The angles are about 1e-2, in doubles, through a dozen operations.
            assert!(distance(paths[0].deviation, truth) < 1e-12, "{step}");
            let again = deviation(astray(truth, at, index), at, index);
            assert!(distance(again, truth) < 1e-12, "{step}");
            cases += 1;
        }
        assert_eq!(cases, 200);
    }

    #[test]
    fn what_cannot_be_interpolated_is_not() {
        let mut bent = nodes(&[0.0, 15.0], 60.0, &[0.0]);
        bent[3].paths[0].polygon.insert(1, [0.0, 0.0]);
        assert!(
            paths(&bent, tau(10.0, 0.0), 0.0, 1.0).is_none(),
            "not convex"
        );
        let mut flat = nodes(&[0.0, 15.0], 60.0, &[0.0]);
        flat[3].paths[0].matrix = [[1.0, 2.0], [0.5, 1.0]];
        assert!(
            paths(&flat, tau(10.0, 0.0), 0.0, 1.0).is_none(),
            "no fixed point"
        );
    }

    /// Weights by hand: on a cross about `tau` the slopes are 0 by symmetry, and the weights are in
    /// proportion to the inverse fourth power of the distance.
    #[test]
    fn weights_fall_with_the_fourth_power_of_the_distance() {
        let cross = [[1.5, 0.5], [-0.5, 0.5], [0.5, 2.5], [0.5, -1.5]];
        let found = weights(&cross, [0.5, 0.5]);
        let expected = [8.0 / 17.0, 8.0 / 17.0, 1.0 / 34.0, 1.0 / 34.0];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-15, "{found} {expected}");
        }
    }

    /// Computes a deviation by Snell's law in three dimensions, from its definition alone: light is
    /// launched down along (tau, 0, -1) and leaves along (off, 0) less that.
    #[test]
    fn deviations_follow_snells_law() {
        let index = 1.49;
        let outside = |inside: [f64; 3]| {
            let length = inside.iter().map(|x| x * x).sum::<f64>().sqrt();
            let [x, y] = [0, 1].map(|k| index * inside[k] / length);
            [x, y, (1.0 - x * x - y * y).sqrt()]
        };
        let scalar = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut cases = 0;
        for tangent in [0.0, 0.2, 0.5, 0.8] {
            let back = outside([-tangent, 0.0, 1.0]);
            // The axis across the way back, in the plane of incidence, towards u.
            let across = [back[2], 0.0, -back[0]];
            for [x, y] in [[3e-3, 0.0], [0.0, -2e-3], [-4e-3, 5e-3]] {
                // A small rotation keeps the length of the light's direction.
                let steep = 1.0 + tangent * tangent;
                let along = [x - tangent, y];
                let up = (steep - along[0] * along[0] - along[1] * along[1]).sqrt();
                let left = outside([along[0], along[1], up]);
                let straight = scalar(left, back);
                let expected = [scalar(left, across) / straight, left[1] / straight];
                let tau = [tangent, 0.0];
                let found = deviation([x, y], tau, index);
                // Angles of 1e-2 from sums of numbers up to 1, divided by cosines above 0.3.
                assert!(distance(found, expected) < 1e-14, "{found:?} {expected:?}");
                assert!(distance(astray(expected, tau, index), [x, y]) < 1e-14);
                cases += 1;
            }
        }
        assert_eq!(cases, 12);
    }

    /// A direction that lacks a path counts as a jump if the path's lines leave more than a quarter
    /// of its area there. The area that they leave is known from the closed form.
    #[test]
    fn a_path_jumps_away_above_a_quarter_of_its_area() {
        let area_at = |incidence| path(tau(incidence, 0.0), 0.0).map_or(0.0, |p| area(&p.polygon));
        let held = area_at(15.0);
        for (part, expected) in [(0.26, 6.0 / 7.0), (0.24, 1.0)] {
            let (mut low, mut high) = (20.0, 36.0);
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                if area_at(middle) > part * held {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            let mut nodes = nodes(&[15.0], 60.0, &[0.0]);
            nodes.push(NearDirection {
                tau: tau(low, 0.0),
                azimuth_rad: 0.0,
                paths: Vec::new(),
                share: 1.0,
                corner: [0.0; 2],
            });
            nodes.iter_mut().for_each(|node| node.share = 1.0 / 7.0);
            let found = paths(&nodes, tau(10.0, 0.0), 0.0, 1.0).unwrap();
            assert_eq!(found.len(), 1);
            assert!((found[0].weight - expected).abs() < 1e-15, "{part}");
        }
    }

    /// Returns a path of weight 1 that mirrors `polygon` at the origin.
    fn point_mirror(polygon: Vec<[f64; 2]>) -> Path {
        Path {
            polygon,
            matrix: [[-2.0, 0.0], [0.0, -2.0]],
            offset: [0.0; 2],
            weight: 1.0,
            deviation: [0.0; 2],
            passes: 0,
            jones: None,
        }
    }

    /// The square of the third direction lacks the edge across a corner that the first two have.
    /// That edge moves out by too little to clear the corner by itself. In its own direction the
    /// square stays whole.
    #[test]
    fn a_line_keeps_clear_of_a_polygon_that_lacks_it() {
        let node = |x: f64, cut: f64| {
            let corner = [[1.0, 1.0 - cut], [1.0 - cut, 1.0]];
            let mut polygon = vec![[-1.0, -1.0], [1.0, -1.0]];
            polygon.extend(&corner[..if cut > 0.0 { 2 } else { 1 }]);
            polygon.push([-1.0, 1.0]);
            NearDirection {
                tau: [x, 0.0],
                azimuth_rad: 0.0,
                paths: vec![point_mirror(polygon)],
                share: 1.0 / 3.0,
                corner: [0.0; 2],
            }
        };
        // Continued to 0.2, the edge would cut off 0.3 of both sides.
        let nodes = [node(0.0, 0.5), node(0.1, 0.4), node(0.2, 0.0)];
        for (node, expected) in nodes.iter().zip([4.0 - 0.125, 4.0 - 0.08, 4.0]) {
            let found = paths(&nodes, node.tau, 0.0, 1.0).unwrap();
            assert_eq!(found.len(), 1);
            // The cuts of the square round by an ulp of 1000, the size of the first frame.
            let area = found[0].area();
            assert!((area - expected).abs() < 1e-12, "{area} {expected}");
        }
    }

    /// Returns two directions at `at` and `-at` in tau, each with half of the share and one
    /// polygon.
    fn two(at: f64, polygons: [Vec<[f64; 2]>; 2]) -> [NearDirection; 2] {
        let mut side = 1.0;
        polygons.map(|polygon| {
            side = -side;
            NearDirection {
                tau: [side * at, 0.3],
                azimuth_rad: 0.0,
                paths: vec![point_mirror(polygon)],
                share: 0.5,
                corner: [0.0; 2],
            }
        })
    }

    /// Two paths have one polygon and one exit direction, as two facet orders of a cube with errors
    /// may have near normal incidence, but turn the light about the normal by opposite angles. They
    /// are told apart in whatever order a direction lists them.
    #[test]
    fn paths_are_told_apart_by_their_turn_about_the_normal() {
        let turn = 4e-4;
        let path = |turn: f64| Path {
            matrix: [[-2.0, -turn], [turn, -2.0]],
            deviation: [1e-3, 0.0],
            ..point_mirror(square(1.0, 0.0))
        };
        let mut nodes = two(0.01, [square(1.0, 0.0), square(1.0, 0.0)]);
        nodes[0].paths = vec![path(turn), path(-turn)];
        nodes[1].paths = vec![path(-turn), path(turn)];
        let found = paths(&nodes, [0.0, 0.3], 0.0, 1.0).unwrap();
        let mut turns: Vec<f64> = found.iter().map(|path| path.matrix[1][0]).collect();
        turns.sort_by(f64::total_cmp);
        assert_eq!(turns.len(), 2);
        // Means of equal numbers; the matrices have ulps of 2.
        assert!(
            (turns[0] + turn).abs() < 1e-15 && (turns[1] - turn).abs() < 1e-15,
            "{turns:?}"
        );
    }

    /// Returns the square of half side `half`, turned by `turn` about its centre in the origin.
    fn square(half: f64, turn: f64) -> Vec<[f64; 2]> {
        let corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
        corners.map(|p| turned(p, turn)).to_vec()
    }
}
