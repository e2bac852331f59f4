//! One facet within one beam: the part of the beam that would meet it, and what it hides.

use glam::DVec2;

use crate::beams::view::{Depth, Shadow};
use crate::geometry::{HalfPlane, Polygon, polygon};

/// A facet's shadow on a beam, cut to the beam.
pub(crate) struct Candidate {
    pub shadow: Shadow,
    /// The cut outline, in entry points.
    pub seen: Polygon,
    /// Nearest and furthest depth over `seen`.
    pub near: f64,
    pub far: f64,
}

impl Candidate {
    /// `None` where the shadow misses `polygon` or lies before `start`.
    pub(crate) fn new(
        shadow: Shadow,
        polygon: &[DVec2],
        start: Option<&Depth>,
        least: f64,
    ) -> Option<Self> {
        let (low, high) = polygon::bounds(polygon);
        if shadow.high.cmple(low).any() || shadow.low.cmpge(high).any() {
            return None;
        }
        let behind = start.map(|start| start.at_most(&shadow.depth, shadow.slack));
        let seen = polygon::clip(polygon, polygon::edges(&shadow.outline).chain(behind));
        if polygon::area(&seen) <= least {
            return None;
        }
        let depths = || seen.iter().map(|&p| shadow.depth.at(p));
        let (near, far) = (
            depths().fold(f64::INFINITY, f64::min),
            depths().fold(f64::NEG_INFINITY, f64::max),
        );
        Some(Candidate {
            shadow,
            seen,
            near,
            far,
        })
    }

    /// Whether the two can overlap, `self` in front somewhere.
    pub(crate) fn may_hide(&self, other: &Candidate) -> bool {
        let ((low, high), (other_low, other_high)) =
            (polygon::bounds(&self.seen), polygon::bounds(&other.seen));
        self.near < other.far + 1e-12 && low.cmplt(other_high).all() && other_low.cmplt(high).all()
    }

    /// Where the facet lies before one at `depth` + `tie`: a positive tie hides a facet that
    /// coincides.
    pub(crate) fn hiding(&self, depth: &Depth, start: Option<&Depth>, tie: f64) -> Vec<HalfPlane> {
        polygon::edges(&self.shadow.outline)
            .chain([self.shadow.depth.at_most(depth, tie)])
            .chain(start.map(|start| start.at_most(&self.shadow.depth, self.shadow.slack)))
            .collect()
    }
}
