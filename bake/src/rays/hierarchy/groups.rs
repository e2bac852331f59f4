//! Rays with directions of their own that are traced beside their neighbours, for scenes with a
//! hierarchy.
//!
//! Rays diverge on curved or rough faces, and each photon is absorbed at random. But neighbours
//! still travel alike for some reflections. A [`RayGroup`] holds rays that enter side by side. In
//! each step they are sorted by the signs of their directions, and rays of equal signs go down the
//! hierarchy together. Then each ray passes its own facet as [`crate::rays::path::trace`] lets
//! it pass.

use crate::optics::{Incidence, Rules};
use crate::rays::hierarchy::bvh::Hierarchy;
use crate::rays::hierarchy::coherent::CoherentRays;
use crate::rays::lane::LANES;
use crate::rays::path::{Outcome, RandomNumbers, RayPath};
use crate::rays::scene::Scene;
use glam::{DVec2, DVec3};

/// Largest number of rays in a group.
pub(crate) const MOST_RAYS: usize = LANES;

/// Rays under way in one scene.
pub(crate) struct RayGroup<'a> {
    scene: &'a Scene,
    hierarchy: &'a Hierarchy,
    rules: &'a Rules,
    rays: Vec<OpenRay>,
    /// Numbers of the rays that are still under way.
    open: Vec<u32>,
    coherent: Box<CoherentRays>,
}

/// Ray of a group.
struct OpenRay {
    path: RayPath,
    /// Direction of launch.
    direction: Incidence,
}

impl<'a> RayGroup<'a> {
    /// Makes a group without rays in `scene`, whose facets `hierarchy` holds.
    pub(crate) fn new(scene: &'a Scene, hierarchy: &'a Hierarchy, rules: &'a Rules) -> Self {
        RayGroup {
            scene,
            hierarchy,
            rules,
            rays: Vec::new(),
            open: Vec::new(),
            coherent: Box::new(CoherentRays::new()),
        }
    }

    /// Traces the rays of `starts` and hands the number of each, its direction of launch and its
    /// outcome to `end`.
    ///
    /// A start is a direction, a point of the entrance plane (edge lengths), and random numbers.
    pub(crate) fn trace(
        &mut self,
        starts: impl Iterator<Item = (Incidence, DVec2, RandomNumbers)>,
        mut end: impl FnMut(usize, &Incidence, &Outcome),
    ) {
        let (scene, rules) = (self.scene, self.rules);
        self.rays.clear();
        self.open.clear();
        for (number, (direction, point, random)) in starts.enumerate() {
            let path = RayPath::new(scene, rules, &direction, point, random);
            match path.enter() {
                Ok(()) => self.open.push(number as u32),
                Err(fate) => {
                    let outcome = path.outcome(fate, scene, rules, &direction);
                    end(number, &direction, &outcome);
                }
            }
            self.rays.push(OpenRay { path, direction });
        }
        while !self.open.is_empty() {
            self.step(&mut end);
        }
    }

    /// Takes every open ray to its next facet and past it.
    fn step(&mut self, end: &mut impl FnMut(usize, &Incidence, &Outcome)) {
        let RayGroup {
            scene,
            hierarchy,
            rules,
            rays,
            open,
            coherent,
        } = self;
        open.sort_by_key(|&number| octant(rays[number as usize].path.ray.direction));
        let mut kept = Vec::with_capacity(open.len());
        let of = |number: u32| octant(rays[number as usize].path.ray.direction);
        let alike = open.chunk_by(|&a, &b| of(a) == of(b));
        let alike: Vec<&[u32]> = alike.flat_map(|numbers| numbers.chunks(LANES)).collect();
        for numbers in alike {
            coherent.fill(numbers.iter().map(|&number| rays[number as usize].path.ray));
            hierarchy.nearest_of_each(scene.facets(), coherent);
            scene.fetch_normals(&coherent.nearest);
            for (&number, nearest) in numbers.iter().zip(&coherent.nearest) {
                let OpenRay { path, direction } = &mut rays[number as usize];
                let event = scene.event(&path.ray, nearest);
                match path.pass(&event, scene.height(), rules, direction) {
                    Ok(()) => kept.push(number),
                    Err(fate) => {
                        let outcome = path.outcome(fate, scene, rules, direction);
                        end(number as usize, direction, &outcome);
                    }
                }
            }
        }
        *open = kept;
    }
}

/// Returns a number for the signs of the components of `direction`.
fn octant(direction: DVec3) -> u32 {
    direction.is_negative_bitmask()
}
