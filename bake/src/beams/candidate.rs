//! One facet within one beam: the part of the beam that would meet the facet, and what the facet
//! hides.

use glam::DVec2;

use crate::beams::view::{Depth, Shadow};
use crate::geometry::{HalfPlane, Polygon, polygon};

/// The shadow of a facet on a beam, cut to the beam.
pub(crate) struct Candidate {
    pub shadow: Shadow,
    /// Outline of the shadow within the beam, in entry points.
    pub visible: Polygon,
    /// Least depth over `visible`, edge lengths.
    pub near: f64,
    /// Greatest depth over `visible`, edge lengths.
    pub far: f64,
}

impl Candidate {
    /// Cuts `shadow` to the beam `polygon`, whose light starts at the depth `start`.
    ///
    /// Returns `None` if no more than the area `least` of the shadow lies in `polygon` and behind
    /// `start`.
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
        let visible = polygon::clip(polygon, polygon::edges(&shadow.outline).chain(behind));
        if polygon::area(&visible) <= least {
            return None;
        }
        let depths = || visible.iter().map(|&p| shadow.depth.at(p));
        let (near, far) = (
            depths().fold(f64::INFINITY, f64::min),
            depths().fold(f64::NEG_INFINITY, f64::max),
        );
        Some(Candidate {
            shadow,
            visible,
            near,
            far,
        })
    }

    /// Returns whether this facet may hide a part of `other`: they may overlap, and some of this
    /// facet is nearer than some of `other`.
    pub(crate) fn may_hide(&self, other: &Candidate) -> bool {
        let ((low, high), (other_low, other_high)) = (
            polygon::bounds(&self.visible),
            polygon::bounds(&other.visible),
        );
        self.near < other.far + 1e-12 && low.cmplt(other_high).all() && other_low.cmplt(high).all()
    }

    /// Returns half-planes; this facet hides a facet at `depth` in their intersection.
    ///
    /// That is where the depth of this facet is at most `depth` + `tie`. With a positive `tie` a
    /// facet hides one that coincides with it; with a negative `tie` it does not.
    pub(crate) fn hiding(&self, depth: &Depth, start: Option<&Depth>, tie: f64) -> Vec<HalfPlane> {
        polygon::edges(&self.shadow.outline)
            .chain([self.shadow.depth.at_most(depth, tie)])
            .chain(start.map(|start| start.at_most(&self.shadow.depth, self.shadow.slack)))
            .collect()
    }
}
