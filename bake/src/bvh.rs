//! Nearest hit among many facets: a bounding volume hierarchy, two-wide for single rays, eight-wide for bundles. The
//! only file that names the BVH crate.
//!
//! The crate works in f32. Here it only chooses the candidates: its boxes are padded by more than the error of an f32
//! ray, and every candidate is tested in f64 by [`Facet::meet`], so the hit is the one that a loop over all facets
//! finds, bit for bit (tested). Its wide variant has an absolute epsilon near surfaces and is not used.

use crate::bundle::{Boxes, Bundle};
use crate::packet::Way;
use crate::ray::Ray;
use crate::scene::Nearest;
use crate::triangle::Facet;
use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};
use obvhs::ray::{Ray as RayF32, RayHit};
use std::time::Duration;

/// A hierarchy over a list of facets.
pub struct Hierarchy {
    tree: Bvh2,
    /// The same for bundles, wider.
    nodes: Vec<Node>,
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
        let tree = build_bvh2(
            &boxes,
            BvhBuildParams {
                max_prims_per_leaf: 1,
                ..BvhBuildParams::medium_build()
            },
            &mut build_time,
        );
        Hierarchy {
            nodes: widened(&tree),
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
    pub fn nearest_of(&self, way: &Way, bundle: &mut Bundle) {
        let Way {
            facets, direction, ..
        } = *way;
        let mut open = std::mem::take(&mut bundle.waiting);
        let bounds = bundle.bounds(direction, self.centre);
        // Whatever is in the ball of the facets is no further than this from an origin.
        let span = bounds.farthest() + 2.0 * self.radius;
        let mut limit = span;
        open.clear();
        open.push((0.0, 0));
        while let Some((from, at)) = open.pop() {
            if from > limit {
                continue;
            }
            if at & LEAF != 0 {
                let facet = (at & !LEAF) as usize;
                if Some(facet) != way.from
                    && let Some(aspect) = facets[facet].along(direction)
                    && bundle.offer(facet, &aspect)
                {
                    limit = (bundle.limit() * (1.0 + 1e-6) + self.padding).min(span);
                }
                continue;
            }
            let node = &self.nodes[at as usize];
            let from = bounds.reach(&node.boxes, limit);
            let bottom = open.len();
            for (&from, &child) in from.iter().zip(&node.children) {
                if from < f64::INFINITY {
                    // The nearest last: it is looked at first.
                    open.push((from, child));
                    let mut place = open.len() - 1;
                    while place > bottom && open[place - 1].0 < from {
                        open.swap(place, place - 1);
                        place -= 1;
                    }
                }
            }
        }
        bundle.waiting = open;
    }
}

/// A node of eight children.
struct Node {
    boxes: Boxes,
    /// Nodes, or facets marked [`LEAF`].
    children: [u32; 8],
}

/// Marks a child that is a facet.
const LEAF: u32 = 1 << 31;

/// `tree`, whose leaves hold one facet each, with eight children to a node.
fn widened(tree: &Bvh2) -> Vec<Node> {
    let mut nodes = Vec::new();
    // Node of `tree`, and its place among `nodes`.
    let mut open = vec![(0usize, 0usize)];
    nodes.push(Node::EMPTY);
    while let Some((root, place)) = open.pop() {
        let mut children = vec![root];
        // Opens the largest child as long as there is room.
        while children.len() < 8 {
            let inner = (0..children.len()).filter(|&i| !tree.nodes[children[i]].is_leaf());
            let area = |i: &usize| tree.nodes[children[*i]].aabb.half_area();
            let Some(largest) = inner.max_by(|a, b| area(a).total_cmp(&area(b))) else {
                break;
            };
            let first = tree.nodes[children[largest]].first_index as usize;
            children[largest] = first;
            children.push(first + 1);
        }
        for (i, child) in children.into_iter().enumerate() {
            let node = &tree.nodes[child];
            let (low, high) = (node.aabb.min, node.aabb.max);
            for axis in 0..3 {
                nodes[place].boxes.low[axis][i] = low[axis];
                nodes[place].boxes.high[axis][i] = high[axis];
            }
            nodes[place].children[i] = if node.is_leaf() {
                LEAF | tree.primitive_indices[node.first_index as usize]
            } else {
                open.push((child, nodes.len()));
                nodes.push(Node::EMPTY);
                nodes.len() as u32 - 1
            };
        }
    }
    nodes
}

impl Node {
    const EMPTY: Node = Node {
        boxes: Boxes {
            low: [[f32::INFINITY; 8]; 3],
            high: [[f32::INFINITY; 8]; 3],
        },
        children: [0; 8],
    };
}

fn single(v: DVec3) -> Vec3A {
    v.as_vec3a()
}
