//! Building of a hierarchy: a binary tree of facets becomes nodes with eight children and blocks.
//!
//! This is the only file that names the BVH crate. The crate builds a binary tree in f32. Its wide
//! variant is not used, because it has an absolute epsilon near surfaces.

use crate::optics::Triangle;
use crate::rays::hierarchy::block::{Block, SIDE_BY_SIDE};
use glam::{DMat3, DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};
use std::time::Duration;

/// Eight boxes side by side, by axis; an empty place holds a point at infinity.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Boxes {
    /// Ends of the boxes: lower and upper, by axis.
    pub ends: [[[f32; 8]; 3]; 2],
}

/// Node of the hierarchy with eight children.
#[repr(align(64))]
pub(crate) struct WideNode {
    /// Boxes of the children, in the frame of the node.
    pub boxes: Boxes,
    /// Numbers of nodes, or of blocks marked with [`BLOCK`].
    pub children: [u32; 8],
    /// Number of the frame.
    pub frame: u32,
    /// Bits of the places that hold children.
    pub used: u32,
}

/// Bit that marks a child as a block.
pub(crate) const BLOCK: u32 = 1 << 31;

impl WideNode {
    const EMPTY: WideNode = WideNode {
        boxes: Boxes {
            ends: [[[f32::INFINITY; 8]; 3]; 2],
        },
        children: [0; 8],
        frame: 0,
        used: 0,
    };
}

/// Place of facets, as a tree over them needs it.
pub(crate) struct Space<'a> {
    /// The facets.
    pub facets: &'a [Triangle],
    /// Point that all positions are counted from, edge lengths.
    pub centre: DVec3,
    /// Padding of the boxes, edge lengths.
    pub padding: f64,
    /// Frames that nodes may have, as maps from the cell frame.
    pub frames: &'a [DMat3],
}

impl Space<'_> {
    /// Returns the box of a facet in `frame`.
    fn bounds(&self, facet: usize, frame: &DMat3) -> Aabb {
        let corners = self.facets[facet].corners;
        let corners = corners.map(|corner| (*frame * (corner - self.centre)).as_vec3a());
        let mut bounds = Aabb::from_points(&corners);
        bounds.min -= Vec3A::splat(self.padding as f32);
        bounds.max += Vec3A::splat(self.padding as f32);
        bounds
    }
}

/// Nodes and blocks of a hierarchy, and the largest number of children that wait while a ray goes
/// down.
pub(crate) struct Wide {
    /// Nodes, the root first.
    pub nodes: Vec<WideNode>,
    /// Blocks of facets.
    pub blocks: Vec<Block>,
    /// Largest number of children still to be looked at.
    pub waiting: usize,
}

/// Builds the hierarchy over the facets of `space`.
pub(crate) fn build(space: &Space) -> Wide {
    let bounds = |facet: usize| space.bounds(facet, &space.frames[0]);
    let boxes: Vec<Aabb> = (0..space.facets.len()).map(bounds).collect();
    let mut build_time = Duration::ZERO;
    let params = BvhBuildParams {
        max_prims_per_leaf: 1,
        ..BvhBuildParams::medium_build()
    };
    let tree = build_bvh2(&boxes, params, &mut build_time);
    drop(boxes);
    Binary::new(tree, space).widened(space)
}

/// Binary tree with one facet to a leaf, the number of facets under each node, and the boxes of
/// its nodes in the frames.
struct Binary {
    tree: Bvh2,
    under: Vec<u32>,
    /// Boxes by frame and node.
    boxes: Vec<Vec<Aabb>>,
}

impl Binary {
    fn new(tree: Bvh2, space: &Space) -> Self {
        let nodes = &tree.nodes;
        let mut order = vec![0];
        let mut looked_at = 0;
        while let Some(&node) = order.get(looked_at) {
            looked_at += 1;
            if !nodes[node].is_leaf() {
                let first = nodes[node].first_index as usize;
                order.extend([first, first + 1]);
            }
        }
        let mut under = vec![1; nodes.len()];
        let mut boxes = vec![vec![Aabb::empty(); nodes.len()]; space.frames.len()];
        for &node in order.iter().rev() {
            let first = nodes[node].first_index as usize;
            if !nodes[node].is_leaf() {
                under[node] = under[first] + under[first + 1];
            }
            for (boxes, frame) in boxes.iter_mut().zip(space.frames) {
                boxes[node] = if nodes[node].is_leaf() {
                    space.bounds(tree.primitive_indices[first] as usize, frame)
                } else {
                    boxes[first].union(&boxes[first + 1])
                };
            }
        }
        Binary { tree, under, boxes }
    }

    /// Returns the children of `node`, which has some.
    fn children(&self, node: usize) -> [usize; 2] {
        let first = self.tree.nodes[node].first_index as usize;
        [first, first + 1]
    }

    fn is_block(&self, node: usize) -> bool {
        self.under[node] as usize <= SIDE_BY_SIDE
    }

    /// Returns the numbers of the facets under `node`.
    fn facets(&self, node: usize) -> Vec<u32> {
        let (mut open, mut facets) = (vec![node], Vec::new());
        while let Some(node) = open.pop() {
            if self.tree.nodes[node].is_leaf() {
                let first = self.tree.nodes[node].first_index as usize;
                facets.push(self.tree.primitive_indices[first]);
            } else {
                open.extend(self.children(node));
            }
        }
        facets.sort_unstable();
        facets
    }

    /// Returns the nodes that become the children of `root`, eight at most.
    ///
    /// The largest child is replaced by its two children as long as there is room.
    fn eight_under(&self, root: usize) -> Vec<usize> {
        let area = |node: usize| {
            let areas = self.boxes.iter().map(|boxes| boxes[node].half_area());
            areas.fold(f32::INFINITY, f32::min)
        };
        let mut children = vec![root];
        while children.len() < 8 {
            let inner = (0..children.len()).filter(|&i| !self.is_block(children[i]));
            let larger = |a: &usize, b: &usize| area(children[*a]).total_cmp(&area(children[*b]));
            let Some(largest) = inner.max_by(larger) else {
                break;
            };
            let [one, other] = self.children(children[largest]);
            children[largest] = one;
            children.push(other);
        }
        children
    }

    /// Returns the nodes of this tree with eight children to a node.
    fn widened(&self, space: &Space) -> Wide {
        let (mut nodes, mut blocks) = (vec![WideNode::EMPTY], Vec::new());
        let mut deepest = 0;
        // Each entry is a node of the tree, its place among `nodes`, and its depth.
        let mut open = vec![(0_usize, 0_usize, 0_usize)];
        while let Some((root, place, depth)) = open.pop() {
            deepest = deepest.max(depth);
            let children = self.eight_under(root);
            // Its frame is the one in which the children are smallest.
            let sum = |frame: &usize| -> f32 {
                let areas = children.iter().map(|&c| self.boxes[*frame][c].half_area());
                areas.sum()
            };
            let smaller = |a: &usize, b: &usize| sum(a).total_cmp(&sum(b));
            let frame = (0..space.frames.len()).min_by(smaller).unwrap_or(0);
            nodes[place].frame = frame as u32;
            nodes[place].used = (1 << children.len()) - 1;
            for (i, child) in children.into_iter().enumerate() {
                let bounds = &self.boxes[frame][child];
                for axis in 0..3 {
                    nodes[place].boxes.ends[0][axis][i] = bounds.min[axis];
                    nodes[place].boxes.ends[1][axis][i] = bounds.max[axis];
                }
                nodes[place].children[i] = if self.is_block(child) {
                    let facets = self.facets(child);
                    blocks.push(Block::new(
                        space.facets,
                        &facets,
                        space.centre,
                        space.padding,
                    ));
                    BLOCK | (blocks.len() as u32 - 1)
                } else {
                    open.push((child, nodes.len(), depth + 1));
                    nodes.push(WideNode::EMPTY);
                    nodes.len() as u32 - 1
                };
            }
        }
        // Each level leaves seven children waiting when it takes the eighth.
        Wide {
            nodes,
            blocks,
            waiting: 7 * deepest + 8,
        }
    }
}
