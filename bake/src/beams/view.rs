//! A cell seen along one direction: everything that the beams of that direction share.
//!
//! Frame: the cell frame turned about n so that the light travels in +x: x = u, y = v, z = n. Beams
//! are followed in **unfolded** space: instead of the beam, the facets are reflected, so the beam
//! runs straight along `direction` for ever and a point of it is named by where it entered, p = (u,
//! v) on the entrance plane, and by its `depth`, the distance travelled since. Facets then become
//! shadows on the entrance plane, and all clipping happens there.

use glam::{DMat3, DVec2, DVec3};

use crate::cell::{Body, Facet};
use crate::geometry::{HalfPlane, Polygon, polygon};
use crate::optics::{EDGE_ON, Incidence};

/// Light that has left a facet's front by less than this is not behind it, edge lengths: far above
/// rounding.
const OFF: f64 = 1e-12;

/// The distance that light has travelled, an affine function of its entry point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Depth {
    pub anchor: DVec2,
    pub value: f64,
    pub gradient: DVec2,
}

impl Depth {
    pub(crate) fn at(&self, p: DVec2) -> f64 {
        self.value + self.gradient.dot(p - self.anchor)
    }

    /// Where `self` is at most `other` + `slack`.
    pub(crate) fn at_most(&self, other: &Depth, slack: f64) -> HalfPlane {
        HalfPlane {
            gradient: self.gradient - other.gradient,
            anchor: self.anchor,
            constant: self.value - other.at(self.anchor) - slack,
        }
    }
}

/// x -> linear x + shift: from unfolded space to where the light really is.
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

    /// Followed by the reflection in the plane normal.x = offset.
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
    pub facet: usize,
    /// Lattice translation of the copy.
    pub translation: DVec3,
    /// Outline in entry points.
    pub outline: Polygon,
    pub low: DVec2,
    pub high: DVec2,
    /// Distance travelled to it, by entry point.
    pub depth: Depth,
    /// How far behind its start a beam may seem to meet it: less than 0 for the back of a facet,
    /// which light that leaves the facet's front does not meet.
    pub slack: f64,
}

/// What a lattice translation does to a shadow.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Translation {
    translation: DVec3,
    entry: DVec2,
    depth: f64,
}

impl Shadow {
    /// Whether the copy's outline can overlap a box of entry points.
    pub(crate) fn may_touch(&self, step: &Translation, low: DVec2, high: DVec2) -> bool {
        (self.low + step.entry).cmplt(high).all() && (self.high + step.entry).cmpgt(low).all()
    }

    /// The copy.
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
    /// From unfolded space to real space.
    pub isometry: &'a Isometry,
    /// Where it starts.
    pub from: &'a [DVec3],
    /// Where it goes, unit length.
    pub toward: DVec3,
    /// How far it goes.
    pub travel: f64,
}

/// An axis of the plane, and the least and the greatest coordinate along it.
type Span = (DVec2, f64, f64);

impl Flight<'_> {
    /// Where the translations lie that bring `facet` into the way of the light, along its way and
    /// across.
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
        // Copies that touch the strip's rim by rounding must not be lost: the strip is widened by
        // far more than that.
        let widen = 1e-9;
        // A translation r is wanted where along.r and across.r lie in these ranges.
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
    // The strip's corners bound j.
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
    pub facets: Vec<Facet>,
    pub lattice: Option<[DVec2; 2]>,
    /// Where light enters, in convex parts; of no use where there is a lattice.
    pub doors: Vec<Polygon>,
    pub entrance_area: f64,
    pub height: f64,
    /// Lowest point of any facet.
    pub floor: f64,
    /// Areas at most this are rounding, square edge lengths.
    pub least_area: f64,
    /// Depths closer than this coincide, edge lengths.
    pub least_depth: f64,
}

impl View {
    /// A body seen along `light`.
    pub(crate) fn new(body: &Body, light: &Incidence) -> View {
        // The frame's u is the light's own, so that nothing but rounding is left of v.
        let (sin, cos) = (light.travel.truncate().dot(light.u), -light.travel.z);
        let turn = |p: DVec2| light.to_frame(p);
        let facets: Vec<Facet> = body.facets.iter().map(|f| f.turned(light)).collect();
        let height = body.height;
        let floor = facets
            .iter()
            .flat_map(|f| &f.corners)
            .map(|x| x.z)
            .fold(height, f64::min);
        // Entry points are known to an ulp of the longest path's extent along u, (height - floor)
        // tan(incidence).
        let extent = 1.0 + (height - floor) * sin / cos;
        View {
            direction: DVec3::new(sin, 0.0, -cos),
            lattice: body.lattice.map(|[a, b]| [turn(a), turn(b)]),
            doors: body
                .doors
                .iter()
                .map(|door| door.iter().map(|&p| turn(p)).collect())
                .collect(),
            entrance_area: body.entrance_area,
            height,
            floor,
            least_area: 4.0 * f64::EPSILON * body.entrance_area * extent,
            least_depth: 16.0 * f64::EPSILON * extent,
            facets,
        }
    }

    /// The point of unfolded space where the light that entered at `p` is after travelling `depth`.
    pub(crate) fn point(&self, p: DVec2, depth: f64) -> DVec3 {
        p.extend(self.height) + depth * self.direction
    }

    /// The facets as `beam` meets them, without those that it meets from behind or along.
    pub(crate) fn shadows(&self, beam: &Isometry) -> Vec<Shadow> {
        (0..self.facets.len())
            .filter_map(|facet| self.shadow(facet, beam))
            .collect()
    }

    fn shadow(&self, facet: usize, beam: &Isometry) -> Option<Shadow> {
        let mirror = &self.facets[facet];
        let fold = beam.linear.transpose();
        let normal = fold * mirror.normal;
        let facing = normal.dot(self.direction);
        if facing > -EDGE_ON {
            return None;
        }
        let land = |x: DVec3| {
            let x = fold * (x - beam.shift);
            let depth = (x.z - self.height) / self.direction.z;
            (DVec2::new(x.x - depth * self.direction.x, x.y), depth)
        };
        let (anchor, value) = land(mirror.corners[0]);
        let mut outline: Polygon = mirror.corners.iter().map(|&x| land(x).0).collect();
        if polygon::area(&outline) < 0.0 {
            outline.reverse();
        }
        let (low, high) = polygon::bounds(&outline);
        let gradient = -normal.truncate() / facing;
        let depth = Depth {
            anchor,
            value,
            gradient,
        };
        Some(Shadow {
            facet,
            translation: DVec3::ZERO,
            outline,
            low,
            high,
            depth,
            slack: if mirror.dark { -OFF } else { 0.0 },
        })
    }

    /// The shadow's copies that light can meet on its flight. Without a lattice, the shadow itself.
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

    /// How far light can travel from the points `from` along `toward` before it leaves the layer of
    /// facets.
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
