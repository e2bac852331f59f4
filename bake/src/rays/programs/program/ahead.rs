//! The facets ahead of the rays of a node, in the order in which the rays meet them.
//!
//! To find the tests that can fail, the entrance is cut along the tests. A facet that takes all
//! rays left at a node gets no test at all. So a ray through a shared edge or an apex meets one
//! facet or the other, and never passes between them.
//!
//! In a periodic cell the copies of its facets are facets like others. They are looked for along
//! the way of the rays of a node, as far as needed.

use crate::optics::Triangle;
use crate::rays::programs::program::{Builder, UnfoldedRay};
use crate::rays::programs::region::{Affine, ROUNDING, Region, extent, needed, split};
use glam::{DVec2, DVec3};

/// Largest number of facets ahead of the rays of a node, one behind the other or side by side.
///
/// Putting more in order takes longer than it saves.
const MOST_AHEAD: usize = 64;

/// Length of the way along which the next facets are looked for first, edge lengths.
///
/// The facets of a periodic cell go on without end.
const REACH: f64 = 2.0;

/// Facet ahead of the rays of a node.
pub(super) struct FacetAhead {
    pub facet: Triangle,
    tests: Vec<Affine>,
    pub distance: Affine,
    region: Region,
    /// Least and greatest distance in the region.
    between: (f64, f64),
}

/// Facet that rays of a node meet next.
pub(super) struct Taken {
    pub facet: FacetAhead,
    /// Tests that rays left at the node can fail.
    pub tests: Vec<Affine>,
    /// Parts of the entrance whose rays meet the facet.
    pub region: Region,
}

/// Volume that all rays of a node pass through.
struct SweptVolume {
    /// Lower corner of the least box of the plane that holds the way, edge lengths.
    low: DVec2,
    /// Upper corner of that box.
    high: DVec2,
    /// True if all rays are out of the sheet at the end of the way.
    exits: bool,
    /// Two unit vectors across the way, each with the least and the greatest position of a ray
    /// along it.
    across: [(DVec3, f64, f64); 2],
}

impl SweptVolume {
    /// Returns whether all rays pass on one side of `facet`, farther from it than rounding.
    fn misses(&self, facet: &Triangle) -> bool {
        self.across.iter().any(|&(axis, low, high)| {
            let positions = facet.corners.map(|corner| corner.dot(axis));
            positions.iter().all(|&at| at < low - ROUNDING)
                || positions.iter().all(|&at| at > high + ROUNDING)
        })
    }
}

impl Builder<'_> {
    /// Returns the facets that rays of `region` on `line` meet next, each with its rays, front to
    /// back, and the parts of the region whose rays leave the sheet.
    ///
    /// Returns `None` if the cell does not fit.
    pub(super) fn hits(&self, line: &UnfoldedRay, region: Region) -> Option<(Vec<Taken>, Region)> {
        let mut reach = REACH;
        loop {
            let swept = self.swept(line, &region, reach);
            let (hits, left, farthest) = self.hits_along(line, &region, &swept)?;
            // A facet beyond this way hides none of the hits on it.
            if swept.exits || left.is_empty() && farthest <= reach {
                return Some((hits, left));
            }
            reach *= 2.0;
        }
    }

    /// Returns the facets that rays of `region` meet next if there are none beyond `swept`, the
    /// parts of the region whose rays meet none, and the length of the longest way to a hit.
    fn hits_along(
        &self,
        line: &UnfoldedRay,
        region: &Region,
        swept: &SweptVolume,
    ) -> Option<(Vec<Taken>, Region, f64)> {
        let mut ahead = self.ahead(line, region, swept)?;
        let (mut hits, mut left, mut farthest) = (Vec::new(), region.clone(), 0.0_f64);
        while !ahead.is_empty() && !left.is_empty() {
            let facet = ahead.swap_remove(foremost(&ahead)?);
            let (inside, outside) = split(&left, &facet.tests);
            if inside.is_empty() {
                continue;
            }
            let tests = if outside.is_empty() {
                Vec::new()
            } else {
                needed(&left, &facet.tests)
            };
            // A step without a test takes all rays, because what it leaves is a strip no wider than
            // rounding.
            left = if tests.is_empty() {
                Vec::new()
            } else {
                outside
            };
            let lead = facet.distance.minus(&line.start);
            farthest = farthest.max(extent(&inside, &lead).1);
            hits.push(Taken {
                facet,
                tests,
                region: inside,
            });
        }
        Some((hits, left, farthest))
    }

    /// Returns the facets that rays of `region` on `line` can meet on `swept`.
    ///
    /// Returns `None` if the rays see an edge of a facet end-on, or the facets are too many.
    fn ahead(
        &self,
        line: &UnfoldedRay,
        region: &Region,
        swept: &SweptVolume,
    ) -> Option<Vec<FacetAhead>> {
        let height = self.scene.height();
        let mut ahead = Vec::new();
        for facet in self.scene.facets_above(swept.low, swept.high)?.iter() {
            let cosine = line.direction.dot(facet.normal);
            if cosine.abs() < ROUNDING || swept.misses(facet) {
                continue;
            }
            let [a, b, c] = facet.corners;
            let [b, c] = if cosine < 0.0 { [b, c] } else { [c, b] };
            let edges = [(a, b), (b, c), (c, a)].map(|(from, to)| line.beside(from, to, height));
            let [Some(ab), Some(bc), Some(ca)] = edges else {
                return None;
            };
            let mut tests = vec![ab, bc, ca];
            let distance = line.distance(facet, height);
            let lead = distance.minus(&line.start);
            let (inside, _) = split(region, &tests);
            let (least, most) = extent(&inside, &lead);
            // The rounding error of a distance grows as 1/cosine.
            let rounding = ROUNDING / cosine.abs();
            // A mirror in the entrance plane lies where the rays start.
            let starts_on = cosine < 0.0 && least >= -rounding;
            if inside.is_empty() || most <= rounding && !starts_on {
                continue;
            }
            if least < -rounding {
                tests.push(lead.as_distance());
            }
            let (region, _) = split(region, &tests);
            ahead.push(FacetAhead {
                facet: *facet,
                tests,
                distance,
                between: extent(&region, &distance),
                region,
            });
            if ahead.len() > MOST_AHEAD {
                return None;
            }
        }
        Some(ahead)
    }

    /// Returns the way of all rays of `region` on `line`, from where they are now up to the length
    /// `reach`, or until they are out of the sheet.
    fn swept(&self, line: &UnfoldedRay, region: &Region, reach: f64) -> SweptVolume {
        let height = self.scene.height();
        let d = line.direction;
        let end = if d.z > 0.0 {
            height
        } else {
            self.scene.bottom()
        };
        let [x, y, z] = DVec3::AXES.map(|axis| line.along(axis, height));
        let mut swept = SweptVolume {
            low: DVec2::INFINITY,
            high: DVec2::NEG_INFINITY,
            exits: true,
            across: {
                let (one, other) = d.any_orthonormal_pair();
                [one, other].map(|axis| (axis, f64::INFINITY, f64::NEG_INFINITY))
            },
        };
        for &corner in region.iter().flatten() {
            let at_zero = DVec3::new(x.at(corner), y.at(corner), z.at(corner));
            for (axis, low, high) in &mut swept.across {
                let at = at_zero.dot(*axis);
                (*low, *high) = (low.min(at), high.max(at));
            }
            let start = line.start.at(corner);
            let out = (end - at_zero.z) / d.z;
            swept.exits &= out <= start + reach;
            for distance in [start, out.min(start + reach)] {
                let point = (at_zero + d * distance).truncate();
                swept.low = swept.low.min(point);
                swept.high = swept.high.max(point);
            }
        }
        swept
    }
}

/// Returns the number of the facet that no other facet hides anywhere.
///
/// Returns `None` if two facets pierce each other, or all hide each other in a circle.
fn foremost(ahead: &[FacetAhead]) -> Option<usize> {
    let mut candidate = None;
    for (i, front) in ahead.iter().enumerate() {
        let mut hidden = false;
        for (_, back) in ahead.iter().enumerate().filter(|(j, _)| *j != i) {
            // Facets one behind the other, as most are, need no closer look.
            if back.between.0 >= front.between.1 {
                continue;
            }
            let (both, _) = split(&front.region, &back.tests);
            let (least, most) = extent(&both, &back.distance.minus(&front.distance));
            if least < -1e-9 && most > 1e-9 {
                return None;
            }
            hidden |= least < -1e-9;
        }
        if !hidden && candidate.is_none() {
            candidate = Some(i);
        }
    }
    candidate
}
