//! Rays with directions of their own that are traced beside their neighbours, for scenes with a
//! hierarchy.
//!
//! Rays diverge on curved or rough faces, and each photon is absorbed at random. But neighbours still
//! travel alike for some reflections. A **swarm** holds rays that enter side by side. In each step
//! they are grouped by the signs of their directions, and every group goes down the hierarchy as a
//! cluster. Then each ray passes its own facet as [`crate::rays::path::trace`] lets it pass.

use crate::optics::{Incidence, Rules};
use crate::rays::bvh::Hierarchy;
use crate::rays::cluster::Cluster;
use crate::rays::lane::LANES;
use crate::rays::path::{Luck, Outcome, RayPath};
use crate::rays::scene::Scene;
use glam::{DVec2, DVec3};

/// Largest number of rays in a swarm.
pub(crate) const SWARM: usize = LANES;

/// Rays under way in one scene.
pub(crate) struct Swarm<'a> {
    scene: &'a Scene,
    hierarchy: &'a Hierarchy,
    rules: &'a Rules,
    rays: Vec<Member>,
    /// Numbers of the rays that are still under way.
    open: Vec<u32>,
    cluster: Box<Cluster>,
}

/// Ray of a swarm.
struct Member {
    path: RayPath,
    /// Direction of launch.
    direction: Incidence,
}

impl<'a> Swarm<'a> {
    /// Makes a swarm without rays in `scene`, whose facets `hierarchy` holds.
    pub(crate) fn new(scene: &'a Scene, hierarchy: &'a Hierarchy, rules: &'a Rules) -> Self {
        Swarm {
            scene,
            hierarchy,
            rules,
            rays: Vec::new(),
            open: Vec::new(),
            cluster: Box::new(Cluster::new()),
        }
    }

    /// Traces the rays of `starts` and hands the number of each, its direction of launch and its
    /// outcome to `end`.
    ///
    /// A start is a direction, a point of the entrance plane (edge lengths), and luck.
    pub(crate) fn trace(
        &mut self,
        starts: impl Iterator<Item = (Incidence, DVec2, Luck)>,
        mut end: impl FnMut(usize, &Incidence, &Outcome),
    ) {
        let (scene, rules) = (self.scene, self.rules);
        self.rays.clear();
        self.open.clear();
        for (number, (direction, point, luck)) in starts.enumerate() {
            let path = RayPath::new(scene, rules, &direction, point, luck);
            match path.enter() {
                Ok(()) => self.open.push(number as u32),
                Err(fate) => {
                    let outcome = path.outcome(fate, scene, rules, &direction);
                    end(number, &direction, &outcome);
                }
            }
            self.rays.push(Member { path, direction });
        }
        while !self.open.is_empty() {
            self.step(&mut end);
        }
    }

    /// Takes every open ray to its next facet and past it.
    fn step(&mut self, end: &mut impl FnMut(usize, &Incidence, &Outcome)) {
        let Swarm {
            scene,
            hierarchy,
            rules,
            rays,
            open,
            cluster,
        } = self;
        open.sort_by_key(|&number| octant(rays[number as usize].path.ray.direction));
        let mut kept = Vec::with_capacity(open.len());
        let of = |number: u32| octant(rays[number as usize].path.ray.direction);
        let groups = open.chunk_by(|&a, &b| of(a) == of(b));
        let groups: Vec<&[u32]> = groups.flat_map(|group| group.chunks(LANES)).collect();
        for group in groups {
            cluster.fill(group.iter().map(|&number| rays[number as usize].path.ray));
            hierarchy.nearest_of_cluster(scene.facets(), cluster);
            scene.fetch_normals(&cluster.nearest);
            for (&number, nearest) in group.iter().zip(&cluster.nearest) {
                let Member { path, direction } = &mut rays[number as usize];
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
