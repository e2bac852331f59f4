//! The symmetry of a cell about the sheet's normal, found from its facets.
//!
//! Of a symmetric cell only a sector of azimuths is baked. The symmetry is that of what light
//! meets:
//!
//! - A cell that falls into bodies ([`crate::cell::bodies`]) has every symmetry that carries its
//!   bodies onto copies of each other, wherever they lie. So a pair of cubes has the six rotations
//!   of its tiling.
//! - A periodic cell is compared modulo its lattice.
//! - Any other cell is compared as it is, with its rim.

use crate::cell::body::Part;
use crate::cell::planes::PlanarFacet;
use glam::{DMat2, DVec2, DVec3};
use tables::Symmetry;

/// Largest distance of corners that coincide, relative to the extent of the cell. Files of six
/// digits and of single precision round to less. A corner that is off by this much puts the same
/// share of its light in the wrong place. This is below all errors but those of the exact method.
const SAME: f64 = 1e-6;

/// Largest number of rotations that is tried. No lattice has more than 6.
const MOST_ROTATIONS: u32 = 12;

/// Largest number of facets in all bodies. The number of comparisons grows with its square.
const MOST_COMPARED: usize = 512;

/// Largest difference of a mirror plane's azimuth from a multiple of a quarter degree that is
/// rounded away, degrees. Nearly all designs have their mirror planes at such round angles.
const ROUND_DEG: f64 = 1e-4;

/// Returns the symmetry of a cell that light meets as `parts`.
///
/// It is [`Symmetry::NONE`] if the cell has none or if the parts have too many facets to look.
pub(crate) fn of(parts: &[Part]) -> Symmetry {
    let forms: Vec<Form> = parts.iter().map(Form::of).collect();
    let facets: usize = forms.iter().map(|form| form.facets.len()).sum();
    if facets == 0 || facets > MOST_COMPARED {
        return Symmetry::NONE;
    }
    let extent = forms.iter().map(Form::extent).fold(1.0, f64::max);
    let holds = |map: DMat2| {
        let onto = |from: &Form| {
            forms
                .iter()
                .any(|to| from.maps_onto(to, map, SAME * extent))
        };
        forms.iter().all(onto)
    };
    let rotations = (2..=MOST_ROTATIONS)
        .rev()
        .find(|&n| holds(DMat2::from_angle(std::f64::consts::TAU / f64::from(n))))
        .unwrap_or(1);
    // The angle between two mirror planes is half the angle of a rotation.
    let step = 180.0 / f64::from(rotations);
    let mut mirrors: Vec<f64> = mirrors_deg(&forms)
        .into_iter()
        // Adding 0 turns -0 into 0.
        .map(|mirror| rounded(mirror.rem_euclid(step)).rem_euclid(step) + 0.0)
        .collect();
    mirrors.sort_by(f64::total_cmp);
    mirrors.dedup();
    let reflection = |mirror_deg: f64| {
        let (sin, cos) = (2.0 * mirror_deg).to_radians().sin_cos();
        DMat2::from_cols(DVec2::new(cos, sin), DVec2::new(sin, -cos))
    };
    Symmetry {
        rotations,
        mirror_deg: mirrors
            .into_iter()
            .find(|&mirror| holds(reflection(mirror))),
    }
}

/// Rounds an angle in degrees to a quarter degree if it is within [`ROUND_DEG`] of one.
fn rounded(angle_deg: f64) -> f64 {
    let round = (4.0 * angle_deg).round() / 4.0;
    if (angle_deg - round).abs() < ROUND_DEG {
        round
    } else {
        angle_deg
    }
}

/// Returns the azimuths of the planes that would carry one facet's normal onto another's, degrees.
fn mirrors_deg(forms: &[Form]) -> Vec<f64> {
    let slopes = || {
        let facets = forms.iter().flat_map(|form| form.facets);
        let slopes = facets.map(|facet| facet.normal.truncate());
        slopes.filter(|slope| slope.length() > 0.1)
    };
    let azimuth = |slope: DVec2| slope.y.atan2(slope.x).to_degrees();
    let first = slopes().next().map(azimuth);
    first.map_or(Vec::new(), |first| {
        slopes()
            .map(|other| 0.5 * (first + azimuth(other)))
            .collect()
    })
}

/// A part in the form that maps are tried on.
struct Form<'a> {
    facets: &'a [PlanarFacet],
    /// Corners of the rim, none if there is a lattice.
    rim: Vec<DVec3>,
    lattice: Option<DMat2>,
    copies: usize,
}

fn middle(corners: &[DVec3]) -> DVec3 {
    corners.iter().sum::<DVec3>() / corners.len() as f64
}

impl<'a> Form<'a> {
    fn of(part: &'a Part) -> Self {
        let Part {
            facets,
            entrance,
            copies,
        } = part;
        let rim = || entrance.polygon.iter().map(|p| p.extend(entrance.height));
        Form {
            facets,
            rim: entrance
                .lattice
                .map_or_else(|| rim().collect(), |_| Vec::new()),
            lattice: entrance.lattice.map(|[a, b]| DMat2::from_cols(a, b)),
            copies: *copies,
        }
    }

    fn extent(&self) -> f64 {
        let corners = self.facets.iter().flat_map(|facet| &facet.corners);
        corners.map(|x| x.length()).fold(0.0, f64::max)
    }

    /// Returns all polygons: the facets and the rim.
    fn polygons(&self) -> impl Iterator<Item = &[DVec3]> {
        let facets = self.facets.iter().map(|facet| facet.corners.as_slice());
        facets.chain((!self.rim.is_empty()).then_some(self.rim.as_slice()))
    }

    /// Returns whether `map` and a translation carry this form onto `other`, to the distance
    /// `same`.
    fn maps_onto(&self, other: &Form, map: DMat2, same: f64) -> bool {
        if self.copies != other.copies || self.facets.len() != other.facets.len() {
            return false;
        }
        let turn = |x: DVec3| (map * x.truncate()).extend(x.z);
        let moves: Vec<DVec3> = match &self.lattice {
            Some(lattice) => {
                let image = lattice.inverse() * map * *lattice;
                let whole = |x: DVec2| (x - x.round()).abs().max_element() <= same;
                if !(whole(image.x_axis) && whole(image.y_axis)) {
                    return false;
                }
                // The first facet must land on one of the facets.
                let from = turn(middle(&self.facets[0].corners));
                let onto = other
                    .facets
                    .iter()
                    .map(|facet| middle(&facet.corners) - from);
                onto.collect()
            }
            None => {
                let centre = |form: &Form| {
                    let middles = form.polygons().map(middle);
                    middles.sum::<DVec3>() / form.polygons().count() as f64
                };
                vec![centre(other) - turn(centre(self))]
            }
        };
        moves.into_iter().any(|by| {
            self.polygons().all(|polygon| {
                let image: Vec<DVec3> = polygon.iter().map(|&x| turn(x) + by).collect();
                let lands = |target: &[DVec3]| self.coincide(&image, target, same);
                other.polygons().any(lands)
            })
        })
    }

    /// Returns whether two polygons have the same corners, to the distance `same` and up to a
    /// lattice vector.
    fn coincide(&self, one: &[DVec3], other: &[DVec3], same: f64) -> bool {
        let apart = middle(other) - middle(one);
        let step = self.lattice.map_or(DVec2::ZERO, |lattice| {
            lattice * (lattice.inverse() * apart.truncate()).round()
        });
        let near = |a: DVec3, b: DVec3| (a + step.extend(0.0) - b).length() <= same;
        let has = |a: &DVec3| other.iter().any(|&b| near(*a, b));
        one.len() == other.len() && one.iter().all(has)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::planes::join;
    use meshes::Entrance;

    /// A corner of three equal facets has the symmetry of its rim. If one corner of its triangle is
    /// cut off, one mirror plane is left, which goes through the cut.
    #[test]
    fn a_corner_is_as_symmetric_as_its_rim() {
        // Any height gives three equal facets.
        let end = |k: f64| DVec2::from_angle(k * std::f64::consts::TAU / 3.0).extend(0.7);
        let ends = [0.0, 1.0, 2.0].map(end);
        let facets = join(&[0, 1, 2].map(|i| [DVec3::ZERO, ends[i], ends[(i + 1) % 3]]));
        let [a, b, c] = ends.map(DVec3::truncate);
        let cut = vec![a.lerp(c, 0.2), a.lerp(b, 0.2), b, c];
        for (polygon, rotations) in [(vec![a, b, c], 3), (cut, 1)] {
            let part = Part {
                facets: facets.clone(),
                entrance: Entrance {
                    height: ends[0].z,
                    polygon,
                    lattice: None,
                },
                copies: 1,
            };
            let expected = Symmetry {
                rotations,
                mirror_deg: Some(0.0),
            };
            assert_eq!(of(&[part]), expected);
        }
    }
}
