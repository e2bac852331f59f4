//! Nearest hit among many facets: a two-wide bounding volume hierarchy. The only file that names the BVH crate.
//!
//! The crate works in f32. Here it only chooses the candidates: its boxes are padded by more than the error of an f32
//! ray, and every candidate is tested in f64 by [`Facet::meet`], so the hit is the one that a loop over all facets
//! finds, bit for bit (tested). Its wide variant has an absolute epsilon near surfaces and is not used.

use crate::bundle::Bundle;
use crate::ray::Ray;
use crate::scene::Nearest;
use crate::triangle::Facet;
use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};
use obvhs::ray::{Ray as RayF32, RayHit};
use std::time::Duration;

/// Nodes on the way down at most, for bundles.
const DEPTH: usize = 64;

/// A hierarchy over a list of facets.
pub struct Hierarchy {
    tree: Bvh2,
    depth: usize,
    centre: DVec3,
    /// Radius of a ball about `centre` that holds every facet, edge lengths.
    radius: f64,
    /// Padding of the boxes, edge lengths.
    padding: f64,
}

impl Hierarchy {
    /// Builds the hierarchy over `facets` (at least one).
    pub fn new(facets: &[Facet]) -> Self {
        let corners = || facets.iter().flat_map(|facet| facet.corners);
        let low = corners().fold(DVec3::INFINITY, DVec3::min);
        let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
        let centre = (low + high) / 2.0;
        let radius = corners()
            .map(|corner| corner.distance(centre))
            .fold(0.0, f64::max);
        // An f32 position within 2 radii of the centre is off by at most 2^-23 radii, its ray at the far side by
        // 2^-23 x 2 radii more, and the box test rounds thrice: 2^-19 radii hold all of it four times over.
        let padding = radius * (-19f64).exp2();
        let boxes: Vec<Aabb> = facets
            .iter()
            .map(|facet| {
                let corners = facet.corners.map(|corner| single(corner - centre));
                let mut bounds = Aabb::from_points(&corners);
                bounds.min -= Vec3A::splat(padding as f32);
                bounds.max += Vec3A::splat(padding as f32);
                bounds
            })
            .collect();
        let mut build_time = Duration::ZERO;
        let tree = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut build_time);
        Hierarchy {
            depth: depth(&tree),
            tree,
            centre,
            radius,
            padding,
        }
    }

    /// The nearest of `facets` (those it was built over) along `ray`, up to `limit` edge lengths.
    pub fn nearest(&self, facets: &[Facet], ray: &Ray, limit: f64) -> Nearest {
        // A ray from afar starts, for the f32 boxes, where it comes near: f32 digits are for the cell, not for the way.
        let origin = ray.origin - self.centre;
        let skipped = (-origin.dot(ray.direction) - 2.0 * self.radius).max(0.0);
        let start = origin + ray.direction * skipped;
        let far = |distance: f64| ((distance - skipped) * (1.0 + 1e-6) + self.padding) as f32;
        let mut nearest = Nearest::within(limit);
        let single_ray = RayF32::new(
            single(start),
            single(ray.direction),
            0.0,
            far(limit).min(f32::MAX),
        );
        self.tree
            .ray_traverse(single_ray, &mut RayHit::none(), |_, slot| {
                let facet = self.tree.primitive_indices[slot] as usize;
                nearest.offer(facet, &facets[facet], ray);
                far(nearest.distance)
            });
        nearest
    }

    /// The same for all rays of `bundle`. They start where facets are, so no digits are lost on the way.
    #[inline(always)]
    pub fn nearest_of(&self, facets: &[Facet], bundle: &mut Bundle) {
        let bounds = bundle.bounds(self.centre);
        // Whatever is in the ball of the facets is no further than this from an origin.
        let span = bounds.farthest() + 2.0 * self.radius;
        let mut limit = span;
        let mut stack = [(0.0f64, 0usize); DEPTH];
        let mut open = 1;
        while open > 0 {
            open -= 1;
            let (from, at) = stack[open];
            if from > limit {
                continue;
            }
            let node = &self.tree.nodes[at];
            let first = node.first_index as usize;
            if node.prim_count > 0 {
                for &facet in &self.tree.primitive_indices[first..][..node.prim_count as usize] {
                    bundle.offer(facet as usize, &facets[facet as usize]);
                }
                limit = (bundle.limit() * (1.0 + 1e-6) + self.padding).min(span);
                continue;
            }
            let reach = |child: usize| {
                let bounds_of_child = &self.tree.nodes[child].aabb;
                bounds.reach(
                    double(bounds_of_child.min),
                    double(bounds_of_child.max),
                    limit,
                )
            };
            let near = [first, first + 1].map(|child| (reach(child), child));
            let mut push = |(from, child): (Option<f64>, usize)| {
                if let Some(from) = from {
                    stack[open] = (from, child);
                    open += 1;
                }
            };
            // The nearer child last: it is looked at first.
            let [one, two] = near;
            if one.0 < two.0 {
                push(two);
                push(one);
            } else {
                push(one);
                push(two);
            }
        }
    }

    /// Whether the stack of [`Hierarchy::nearest_of`] is deep enough for it.
    pub fn takes_bundles(&self) -> bool {
        self.depth + 2 < DEPTH
    }
}

/// Nodes on the longest way down.
fn depth(tree: &Bvh2) -> usize {
    let mut deepest = 0;
    let mut open = vec![(0usize, 0usize)];
    while let Some((at, depth)) = open.pop() {
        let node = &tree.nodes[at];
        deepest = deepest.max(depth);
        if node.prim_count == 0 {
            let first = node.first_index as usize;
            open.extend([first, first + 1].map(|child| (child, depth + 1)));
        }
    }
    deepest
}

fn double(v: Vec3A) -> [f64; 3] {
    v.to_array().map(f64::from)
}

fn single(v: DVec3) -> Vec3A {
    v.as_vec3a()
}
