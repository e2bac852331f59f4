//! All facets of a cell, ready for the search of the nearest facet of a ray.
//!
//! Where the cell is periodic, a ray crosses the walls between its cells and goes from prism to
//! prism. The list of facets holds every copy that overlaps the prism over the lattice
//! parallelogram. So a ray needs that one list only, seen from the prism that it is in. A prism is
//! an exact pair of integers: no ray is pushed over a wall by an epsilon, and no ray is lost at a
//! wall.

use crate::cell::{PROGRAM_FACETS, SMALL};
use crate::optics::{Ray, Triangle, triangle};
use crate::rays::hierarchy::bvh::Hierarchy;
use crate::rays::hierarchy::bvh::Nearest;
use crate::rays::simd::fetch;
use crate::rays::walls::Walls;
use glam::{DMat2, DVec2, DVec3};
use meshes::{Cell, Entrance, Normals};
use std::borrow::Cow;

/// Smallest number of facets that do not fit in the caches near a processor (2 MB).
///
/// In such a scene, neighbouring rays are traced after each other.
const LARGE: usize = 1 << 14;

/// Largest number of prisms that a ray may cross between two hits.
///
/// A ray at 89.9 degrees needs 573 of them per edge length of depth. A ray along a groove would
/// never stop.
const PRISM_LIMIT: u32 = 1_000_000;

/// Facets of a cell, indexed for speed.
pub(crate) struct Scene {
    /// All facets; of a periodic cell every copy that overlaps the prism of the lattice
    /// parallelogram.
    facets: Vec<Triangle>,
    /// Normals at the corners of facets that stand for curved faces; `None` where all are planar.
    normals: Option<Normals>,
    /// True for each facet that light goes through; empty if all facets are mirrors.
    glass: Vec<bool>,
    hierarchy: Option<Hierarchy>,
    walls: Option<Walls>,
    /// Height of the entrance plane over the apex, edge lengths.
    height: f64,
    /// Height of the lowest corner, edge lengths.
    bottom: f64,
    /// Greatest distance of an origin in the cell from any corner, edge lengths.
    ///
    /// Rounding errors are in proportion to it.
    reach: f64,
}

/// Way in which the nearest facet is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(
    not(test),
    expect(dead_code, reason = "tests hold each way against the others")
)]
pub(crate) enum Index {
    /// The faster one for the number of facets.
    Auto,
    /// A loop over all facets, against which tests check the hierarchy.
    Loop,
    /// The bounding volume hierarchy.
    Hierarchy,
}

/// Next event on the way of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Event {
    /// Hit on a facet.
    Hit {
        /// Distance from the ray's origin, edge lengths.
        distance: f64,
        /// Point of the hit in the prism of the first cell, with the bound on its error; direction
        /// as before.
        arrival: Ray,
        /// Unit normal about which light is reflected, within 90 degrees of `front_normal`.
        normal: DVec3,
        /// Unit normal of the facet's front; equal to `normal` unless the facet stands for a curved
        /// face.
        front_normal: DVec3,
        /// True if light goes through the facet; otherwise the facet is a mirror.
        glass: bool,
        /// True if the ray meets the facet from the front.
        front: bool,
        /// Prism of the hit, relative to that of the ray's origin, in lattice vectors.
        prism: [i32; 2],
    },
    /// No facet, because the ray is out of the sheet.
    Out,
    /// Ray that runs along the sheet without end.
    Endless,
}

impl Scene {
    /// Makes the scene of a cell.
    pub(crate) fn new(cell: &Cell, index: Index) -> Self {
        let normals = cell.normals.as_ref();
        Scene::with(&cell.facets, normals, &cell.glass, &cell.entrance, index)
    }

    /// Makes the scene of planar `facets` under `entrance`.
    ///
    /// Facets of zero area are left out, because no ray can meet them.
    pub(crate) fn of(facets: &[[DVec3; 3]], entrance: &Entrance, index: Index) -> Self {
        Scene::with(facets, None, &[], entrance, index)
    }

    /// Makes a scene; without `normals` all facets are planar, and without `glass` all are mirrors.
    fn with(
        facets: &[[DVec3; 3]],
        normals: Option<&Normals>,
        glass: &[bool],
        entrance: &Entrance,
        index: Index,
    ) -> Self {
        let own: Vec<Triangle> = facets
            .iter()
            .filter_map(|&corners| Triangle::new(corners))
            .map(|facet| match glass {
                [] => facet,
                _ => facet.two_sided(),
            })
            .collect();
        let walls = entrance.lattice.map(|lattice| Walls {
            lattice,
            lattice_from_plane: DMat2::from_cols(lattice[0], lattice[1]).inverse(),
            corner: entrance.polygon.first().copied().unwrap_or(DVec2::ZERO),
            own: match own.len() <= PROGRAM_FACETS {
                true => own.clone(),
                false => Vec::new(),
            },
        });
        // The normals of facets with an area, in the order of these facets.
        let mut corners = normals.map(|normals| {
            let drawn = facets.iter().zip(&normals.corners);
            let drawn = drawn.filter(|(facet, _)| triangle::normal(*facet).is_some());
            drawn.map(|(_, &corners)| corners).collect::<Vec<_>>()
        });
        let with_area = facets.iter().zip(glass);
        let with_area = with_area.filter(|(facet, _)| triangle::normal(*facet).is_some());
        let mut glass: Vec<bool> = with_area.map(|(_, &glass)| glass).collect();
        let facets = match &walls {
            None => own,
            Some(walls) => {
                let (facets, copied): (Vec<_>, Vec<_>) = walls.copies(&own).into_iter().unzip();
                corners = corners.map(|own| copied.iter().map(|&facet| own[facet]).collect());
                if !glass.is_empty() {
                    glass = copied.iter().map(|&facet| glass[facet]).collect();
                }
                facets
            }
        };
        let normals = normals.zip(corners).map(|(normals, corners)| Normals {
            vectors: normals.vectors.clone(),
            corners,
        });
        let hierarchy = match index {
            Index::Auto => facets.len() >= SMALL,
            Index::Loop => false,
            Index::Hierarchy => !facets.is_empty(),
        }
        .then(|| Hierarchy::new(&facets));
        let height = entrance.height;
        let corners = || facets.iter().flat_map(|facet| facet.corners);
        let rim = || entrance.polygon.iter().map(|p| p.extend(height));
        let low = corners().chain(rim()).fold(DVec3::INFINITY, DVec3::min);
        let high = corners().chain(rim()).fold(DVec3::NEG_INFINITY, DVec3::max);
        Scene {
            facets,
            normals,
            glass,
            hierarchy,
            walls,
            height,
            bottom: low.z,
            reach: (high - low).length(),
        }
    }

    /// Returns the facets that rays are tested against, copies included.
    pub(crate) fn facets(&self) -> &[Triangle] {
        &self.facets
    }

    /// Returns the facets that rays can meet above the box from `low` to `high` of the plane, edge
    /// lengths; of a periodic cell every copy.
    ///
    /// Returns `None` if the facets of the cell are too many for a program.
    pub(crate) fn facets_above(&self, low: DVec2, high: DVec2) -> Option<Cow<'_, [Triangle]>> {
        match &self.walls {
            None if self.facets.len() > PROGRAM_FACETS => None,
            None => Some(Cow::Borrowed(&self.facets)),
            Some(walls) if walls.own.is_empty() => None,
            Some(walls) => Some(Cow::Owned(walls.copies_above(low, high)?)),
        }
    }

    /// Returns whether facets stand for curved faces.
    ///
    /// Rays that meet the same facet then diverge.
    pub(crate) fn is_curved(&self) -> bool {
        self.normals.is_some()
    }

    /// Returns whether rays are traced faster beside their neighbours.
    pub(crate) fn is_large(&self) -> bool {
        self.has_hierarchy() && self.facets.len() >= LARGE
    }

    /// Returns whether hits are found by the hierarchy.
    pub(crate) fn has_hierarchy(&self) -> bool {
        self.hierarchy.is_some()
    }

    /// Returns whether rays of directions of their own can be traced side by side: few mirrors,
    /// all of them planar, in a cell that is not periodic.
    pub(crate) fn is_flown_through(&self) -> bool {
        !self.has_hierarchy() && !self.is_curved() && self.walls.is_none() && self.glass.is_empty()
    }

    /// Returns whether rays cross into neighbouring cells.
    #[cfg(test)]
    pub(crate) fn is_periodic(&self) -> bool {
        self.walls.is_some()
    }

    /// Returns the height of the entrance plane over the apex, edge lengths.
    pub(crate) fn height(&self) -> f64 {
        self.height
    }

    /// Returns the height of the lowest corner, edge lengths.
    pub(crate) fn bottom(&self) -> f64 {
        self.bottom
    }

    /// Returns the greatest distance of an origin in the cell from any corner, edge lengths.
    pub(crate) fn reach(&self) -> f64 {
        self.reach
    }

    /// Makes the ray that enters at `point` of the entrance plane.
    pub(crate) fn enter(&self, point: DVec2, direction: DVec3) -> Ray {
        Ray::new(point.extend(self.height), direction, self.reach)
    }

    /// Returns the displacement of `prism` lattice vectors; zero if the cell is not periodic.
    pub(crate) fn displacement(&self, prism: [i32; 2]) -> DVec2 {
        self.walls
            .as_ref()
            .map_or(DVec2::ZERO, |walls| walls.displacement(prism))
    }

    /// Finds the next event of `ray`.
    pub(crate) fn next(&self, ray: &Ray) -> Event {
        match &self.walls {
            None => self.event(ray, &self.nearest(ray, f64::INFINITY)),
            Some(walls) => self.walk(walls, ray),
        }
    }

    /// Makes the next event of `ray` in a cell that is not periodic from its nearest facet.
    pub(crate) fn event(&self, ray: &Ray, nearest: &Nearest) -> Event {
        nearest.facet.map_or(Event::Out, |facet| {
            self.hit(ray, ray, facet, nearest, [0, 0])
        })
    }

    /// Brings the normals of the facets found into the caches.
    pub(crate) fn fetch_normals(&self, found: &[Nearest]) {
        let Some(normals) = &self.normals else { return };
        let facets = || found.iter().filter_map(|nearest| nearest.facet);
        facets().for_each(|facet| fetch(&normals.corners[facet]));
        for index in facets().flat_map(|facet| normals.corners[facet]) {
            fetch(&normals.vectors[index as usize]);
        }
    }

    /// Returns the hierarchy if rays can go down it together, which they cannot in a periodic cell.
    pub(crate) fn for_groups(&self) -> Option<&Hierarchy> {
        let hierarchy = self.hierarchy.as_ref();
        hierarchy.filter(|_| self.walls.is_none())
    }

    /// Finds the nearest facet along `ray`, up to `limit` edge lengths away.
    fn nearest(&self, ray: &Ray, limit: f64) -> Nearest {
        if let Some(hierarchy) = &self.hierarchy {
            return hierarchy.nearest(&self.facets, ray, limit);
        }
        let mut nearest = Nearest::within(limit);
        for (index, facet) in self.facets.iter().enumerate() {
            nearest.offer(index, facet, ray);
        }
        nearest
    }

    /// Goes from prism to prism until a facet is met inside the prism that the ray is in.
    fn walk(&self, walls: &Walls, ray: &Ray) -> Event {
        let end = if ray.direction.z > 0.0 {
            self.height
        } else {
            self.bottom
        };
        // A level ray stays in the sheet until it meets a facet.
        let last = if ray.direction.z == 0.0 {
            f64::INFINITY
        } else {
            (end - ray.origin.z) / ray.direction.z
        };
        let start = walls.lattice_from_plane * (ray.origin.truncate() - walls.corner);
        let rate = walls.lattice_from_plane * ray.direction.truncate();
        let mut prism = [start.x.floor() as i32, start.y.floor() as i32];
        for _ in 0..PRISM_LIMIT {
            let exit = |axis: usize| {
                let wall = f64::from(prism[axis]) + if rate[axis] > 0.0 { 1.0 } else { 0.0 };
                if rate[axis] == 0.0 {
                    f64::INFINITY
                } else {
                    (wall - start[axis]) / rate[axis]
                }
            };
            let axis = usize::from(exit(1) < exit(0));
            // A facet that overlaps the wall is in the lists of both prisms. So a hit at the wall,
            // within rounding, is found from one prism or the other.
            let limit = exit(axis).max(0.0) * (1.0 + 1e-12) + 1e-12;
            let local = Ray {
                origin: ray.origin - walls.displacement(prism).extend(0.0),
                ..*ray
            };
            let away = f64::from(prism[0].abs().max(prism[1].abs()));
            // Far from its start the position of the ray is less accurate.
            let slack = ray.slack * (1.0 + away);
            let local = Ray {
                slack,
                grain: ray.grain * (1.0 + away),
                ..local
            };
            let nearest = self.nearest(&local, limit);
            if let Some(facet) = nearest.facet {
                return self.hit(ray, &local, facet, &nearest, prism);
            }
            if exit(axis) > last {
                return Event::Out;
            }
            prism[axis] += if rate[axis] > 0.0 { 1 } else { -1 };
        }
        Event::Endless
    }

    /// Makes the event of a hit on facet number `facet`; `local` is `ray` seen from `prism`.
    fn hit(
        &self,
        ray: &Ray,
        local: &Ray,
        facet: usize,
        nearest: &Nearest,
        prism: [i32; 2],
    ) -> Event {
        let number = facet;
        let facet = &self.facets[number];
        let origin = local.origin + local.direction * nearest.distance;
        let curved = |normals: &Normals| {
            let mut mix = DVec3::ZERO;
            for (weight, index) in facet
                .weights(origin)
                .into_iter()
                .zip(normals.corners[number])
            {
                mix += normals.vectors[index as usize] * weight;
            }
            mix.normalize()
        };
        let slack = facet.slack_after(ray.direction, nearest.distance, self.reach);
        Event::Hit {
            distance: nearest.distance,
            arrival: Ray {
                slack,
                ..Ray::new(origin, ray.direction, self.reach)
            },
            normal: self.normals.as_ref().map_or(facet.normal, curved),
            front_normal: facet.normal,
            glass: self.glass.get(number).copied().unwrap_or(false),
            front: nearest.front,
            prism,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meshes::design::{Design, Shape};
    use meshes::{CellOptions, normalise};
    use std::path::Path;

    /// Checks that a level ray over a periodic cell crosses prisms until it meets a mirror.
    #[test]
    fn level_rays_are_not_lost() {
        let mesh = Design::new(Shape::FullCube).mesh().expect("a design");
        let cell =
            normalise(&mesh, Path::new("full-cube"), &CellOptions::default()).expect("a cell");
        let scene = Scene::new(&cell, Index::Auto);
        let mut met = 0;
        for step in 0..360 {
            let (y, x) = f64::from(step).to_radians().sin_cos();
            let ray = Ray::new(DVec3::new(0.01, 0.02, 0.5), DVec3::new(x, y, 0.0), 3.0);
            // From inside the cell, at half its depth, every level direction ends at a facet.
            assert!(
                matches!(scene.next(&ray), Event::Hit { front: true, .. }),
                "{step} deg"
            );
            met += 1;
        }
        assert_eq!(met, 360);
    }
}
