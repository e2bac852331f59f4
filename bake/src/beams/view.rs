//! A cell seen along one direction: everything that the beams of that direction share.
//!
//! The frame is the cell frame, turned about n so that the light travels towards +x: x = u, y = v,
//! z = n.
//!
//! Beams are followed in **unfolded** space. There the facets are reflected instead of the beam, so
//! the beam runs straight along `direction` for ever. A point of it is named by its entry point p =
//! (u, v) on the entrance plane and by its `depth`, the distance travelled since. Facets then
//! become shadows on the entrance plane, and all clipping happens there.

use glam::{DMat3, DVec2, DVec3};

use crate::cell::{Body, PlanarFacet};
use crate::geometry::{HalfPlane, Polygon, polygon};
use crate::optics::{EDGE_ON, Incidence};

/// Least distance from its start at which a beam meets the back of a facet, edge lengths. It is far
/// above rounding.
const OFF: f64 = 1e-12;

/// The distance that light has travelled, edge lengths, as an affine function of its entry point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Depth {
    /// Entry point at which the distance is `value`.
    pub anchor: DVec2,
    /// Distance at `anchor`, edge lengths.
    pub value: f64,
    /// Gradient of the distance by the entry point.
    pub gradient: DVec2,
}

impl Depth {
    /// Returns the distance for the light that entered at `p`, edge lengths.
    pub(crate) fn at(&self, p: DVec2) -> f64 {
        self.value + self.gradient.dot(p - self.anchor)
    }

    /// Returns the half-plane of the entry points where `self` is at most `other` + `slack`.
    pub(crate) fn at_most(&self, other: &Depth, slack: f64) -> HalfPlane {
        HalfPlane {
            gradient: self.gradient - other.gradient,
            anchor: self.anchor,
            constant: self.value - other.at(self.anchor) - slack,
        }
    }
}

/// The map x -> linear x + shift from unfolded space to real space, where the light really is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Isometry {
    pub linear: DMat3,
    pub shift: DVec3,
}

impl Isometry {
    pub(crate) const IDENTITY: Isometry = Isometry {
        linear: DMat3::IDENTITY,
        shift: DVec3::ZERO,
    };

    /// Returns this map followed by the reflection in the plane normal.x = offset.
    pub(crate) fn reflected(&self, normal: DVec3, offset: f64) -> Isometry {
        let mirror = |x: DVec3| x - 2.0 * normal.dot(x) * normal;
        let l = &self.linear;
        Isometry {
            linear: DMat3::from_cols(mirror(l.x_axis), mirror(l.y_axis), mirror(l.z_axis)),
            shift: mirror(self.shift) + 2.0 * offset * normal,
        }
    }
}

/// One facet (or a lattice copy of it) as a beam meets it.
#[derive(Debug, Clone)]
pub(crate) struct Shadow {
    /// Number of the facet in [`View::facets`].
    pub facet: usize,
    /// Lattice translation of the copy.
    pub translation: DVec3,
    /// Outline in entry points.
    pub outline: Polygon,
    pub low: DVec2,
    pub high: DVec2,
    /// Distance that light travels to the facet, by entry point.
    pub depth: Depth,
    /// Distance, edge lengths, by which a facet may seem to lie behind the start of a beam that
    /// still meets it. It is negative for the back of a facet: light that leaves the front of the
    /// facet does not meet its back.
    pub slack: f64,
}

/// The displacement of a shadow by a lattice translation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Translation {
    translation: DVec3,
    entry: DVec2,
    depth: f64,
}

impl Shadow {
    /// Returns whether the outline of the copy may overlap the box from `low` to `high` of entry
    /// points.
    pub(crate) fn may_touch(&self, step: &Translation, low: DVec2, high: DVec2) -> bool {
        (self.low + step.entry).cmplt(high).all() && (self.high + step.entry).cmpgt(low).all()
    }

    /// Returns the copy of this shadow that `step` makes.
    pub(crate) fn moved(&self, step: &Translation) -> Shadow {
        Shadow {
            facet: self.facet,
            translation: self.translation + step.translation,
            outline: self.outline.iter().map(|&p| p + step.entry).collect(),
            low: self.low + step.entry,
            high: self.high + step.entry,
            depth: Depth {
                anchor: self.depth.anchor + step.entry,
                value: self.depth.value + step.depth,
                ..self.depth
            },
            slack: self.slack,
        }
    }
}

/// Light on its way, in real space.
pub(crate) struct Flight<'a> {
    /// Map from unfolded space to real space.
    pub isometry: &'a Isometry,
    /// Points from which the light starts.
    pub from: &'a [DVec3],
    /// Direction of travel, unit length.
    pub toward: DVec3,
    /// Distance that the light travels, edge lengths.
    pub travel: f64,
}

/// An axis of the plane, with the least and the greatest coordinate along it.
type Span = (DVec2, f64, f64);

impl Flight<'_> {
    /// Returns the range of the translations that bring `facet` into the way of the light, along
    /// the way and across it.
    fn strip(&self, facet: &[DVec3]) -> [Span; 2] {
        let horizontal = self.toward.truncate();
        let along = horizontal.try_normalize().unwrap_or(DVec2::X);
        let span = |points: &[DVec3], axis: DVec2| {
            let start = (f64::INFINITY, f64::NEG_INFINITY);
            let widened = |(low, high), x: f64| (f64::min(low, x), f64::max(high, x));
            points
                .iter()
                .map(|x| x.truncate().dot(axis))
                .fold(start, widened)
        };
        // Widens the strip by far more than rounding, so that no copy is lost that touches its rim.
        let widen = 1e-9;
        // A translation r is wanted if along.r and across.r lie in these ranges.
        [along, along.perp()].map(|axis| {
            let (start, target) = (span(self.from, axis), span(facet, axis));
            let ahead = self.travel * horizontal.dot(axis).abs();
            (
                axis,
                start.0 - target.1 - widen,
                start.1 + ahead - target.0 + widen,
            )
        })
    }
}

/// Visits the lattice vectors i a + j b whose coordinates lie in both spans.
fn vectors_between([a, b]: [DVec2; 2], strip: [Span; 2], mut visit: impl FnMut(DVec2)) {
    // The corners of the strip bound j.
    let [(x, x_low, x_high), (y, y_low, y_high)] = strip;
    let rows = [
        (x_low, y_low),
        (x_high, y_low),
        (x_low, y_high),
        (x_high, y_high),
    ]
    .map(|(along, across)| a.perp_dot(along * x + across * y) / a.perp_dot(b));
    let first = rows.into_iter().fold(f64::INFINITY, f64::min).floor() as i64;
    let last = rows.into_iter().fold(f64::NEG_INFINITY, f64::max).ceil() as i64;
    for j in first..=last {
        let row = j as f64 * b;
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for (axis, range_low, range_high) in strip {
            let (pace, start) = (a.dot(axis), row.dot(axis));
            if pace.abs() > 1e-12 * a.length() {
                let (one, two) = ((range_low - start) / pace, (range_high - start) / pace);
                (low, high) = (low.max(one.min(two)), high.min(one.max(two)));
            } else if start < range_low || start > range_high {
                high = f64::NEG_INFINITY;
            }
        }
        if low <= high {
            (low.ceil() as i64..=high.floor() as i64).for_each(|i| visit(i as f64 * a + row));
        }
    }
}

/// A cell seen along one direction.
#[derive(Debug, Clone)]
pub(crate) struct View {
    /// Travel direction inside the front face, unit length.
    pub direction: DVec3,
    /// Facets in the frame of the light.
    pub facets: Vec<PlanarFacet>,
    /// Lattice vectors in the frame of the light, or `None` for a body without neighbours.
    pub lattice: Option<[DVec2; 2]>,
    /// Openings that light enters by, in convex parts. They are not used if there is a lattice.
    pub openings: Vec<Polygon>,
    /// Area of the entrance, square edge lengths.
    pub entrance_area: f64,
    /// Height of the entrance plane, edge lengths.
    pub height: f64,
    /// Height of the lowest point of any facet, edge lengths.
    pub floor: f64,
    /// Largest area that counts as rounding, square edge lengths.
    pub least_area: f64,
    /// Largest difference of depths that counts as none, edge lengths.
    pub least_depth: f64,
}

impl View {
    /// Turns `body` into the frame of `light`.
    pub(crate) fn new(body: &Body, light: &Incidence) -> View {
        // u of the frame is that of the light, so that only rounding is left of the component along
        // v.
        let (sin, cos) = (light.travel.truncate().dot(light.u), -light.travel.z);
        let turn = |p: DVec2| light.to_frame(p);
        let facets: Vec<PlanarFacet> = body.facets.iter().map(|f| f.turned(light)).collect();
        let height = body.height;
        let floor = facets
            .iter()
            .flat_map(|f| &f.corners)
            .map(|x| x.z)
            .fold(height, f64::min);
        // Rounding moves an entry point by an ulp of the extent of the longest path along u, which
        // is (height - floor) tan(incidence).
        let extent = 1.0 + (height - floor) * sin / cos;
        View {
            direction: DVec3::new(sin, 0.0, -cos),
            lattice: body.lattice.map(|[a, b]| [turn(a), turn(b)]),
            openings: body
                .openings
                .iter()
                .map(|opening| opening.iter().map(|&p| turn(p)).collect())
                .collect(),
            entrance_area: body.entrance_area,
            height,
            floor,
            least_area: 4.0 * f64::EPSILON * body.entrance_area * extent,
            least_depth: 16.0 * f64::EPSILON * extent,
            facets,
        }
    }

    /// Returns the point of unfolded space that the light which entered at `p` reaches after the
    /// distance `depth`.
    pub(crate) fn point(&self, p: DVec2, depth: f64) -> DVec3 {
        p.extend(self.height) + depth * self.direction
    }

    /// Returns the shadows of the facets that `beam` meets from the front. Facets that it would
    /// meet from behind or edge-on are left out.
    pub(crate) fn shadows(&self, beam: &Isometry) -> Vec<Shadow> {
        (0..self.facets.len())
            .filter_map(|facet| self.shadow(facet, beam))
            .collect()
    }

    /// Returns the distance that a beam on its way up travels to the front face.
    pub(crate) fn depth_of_front(&self, beam: &Isometry) -> Depth {
        let normal = beam.linear.transpose() * DVec3::NEG_Z;
        self.depth_of_plane(beam, DVec3::Z * self.height, normal)
    }

    /// Returns the distance that a beam travels to the plane through the point `x` of real space.
    /// `normal` is the normal of the plane in unfolded space.
    fn depth_of_plane(&self, beam: &Isometry, x: DVec3, normal: DVec3) -> Depth {
        let (anchor, value) = self.entry_of(beam, x);
        Depth {
            anchor,
            value,
            gradient: -normal.truncate() / normal.dot(self.direction),
        }
    }

    /// Returns the entry point of the light of `beam` that reaches the point `x` of real space, and
    /// the distance that it travels.
    fn entry_of(&self, beam: &Isometry, x: DVec3) -> (DVec2, f64) {
        let x = beam.linear.transpose() * (x - beam.shift);
        let depth = (x.z - self.height) / self.direction.z;
        (DVec2::new(x.x - depth * self.direction.x, x.y), depth)
    }

    fn shadow(&self, facet: usize, beam: &Isometry) -> Option<Shadow> {
        let mirror = &self.facets[facet];
        let normal = beam.linear.transpose() * mirror.normal;
        if normal.dot(self.direction) > -EDGE_ON {
            return None;
        }
        let corners = mirror.corners.iter();
        let mut outline: Polygon = corners.map(|&x| self.entry_of(beam, x).0).collect();
        if polygon::area(&outline) < 0.0 {
            outline.reverse();
        }
        let (low, high) = polygon::bounds(&outline);
        Some(Shadow {
            facet,
            translation: DVec3::ZERO,
            outline,
            low,
            high,
            depth: self.depth_of_plane(beam, mirror.corners[0], normal),
            slack: if mirror.dark { -OFF } else { 0.0 },
        })
    }

    /// Visits the copies of `shadow` that light may meet on its flight. Without a lattice this is
    /// the shadow itself.
    pub(crate) fn copies(
        &self,
        shadow: &Shadow,
        flight: &Flight,
        mut visit: impl FnMut(&Translation),
    ) {
        let still = Translation {
            translation: DVec3::ZERO,
            entry: DVec2::ZERO,
            depth: 0.0,
        };
        let Some(lattice) = self.lattice else {
            visit(&still);
            return;
        };
        let fold = flight.isometry.linear.transpose();
        let step = |translation: DVec2| {
            let translation = translation.extend(0.0);
            let folded = fold * translation;
            let depth = folded.z / self.direction.z;
            Translation {
                translation,
                entry: DVec2::new(folded.x - depth * self.direction.x, folded.y),
                depth,
            }
        };
        let facet = &self.facets[shadow.facet].corners;
        vectors_between(lattice, flight.strip(facet), |vector| visit(&step(vector)));
    }

    /// Returns the distance that light can travel from the points `from` along `toward` before it
    /// leaves the layer of facets, edge lengths.
    pub(crate) fn travel_to_leave(&self, from: &[DVec3], toward: DVec3) -> f64 {
        let far = if toward.z > 0.0 {
            self.height
        } else {
            self.floor
        };
        let clearance = from
            .iter()
            .map(|x| (far - x.z) * toward.z.signum())
            .fold(0.0, f64::max);
        if clearance == 0.0 {
            0.0
        } else {
            clearance / toward.z.abs()
        }
    }
}
