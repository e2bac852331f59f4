//! Frames in which boxes fit the facets closely.
//!
//! The faces of a corner cube are planes at right angles. In a frame along their normals the box
//! around a piece of a face is as thin as the piece; in another frame it is a thick box that many
//! rays cross in vain. Cubes that are turned against each other have a frame each.

use crate::optics::Triangle;
use glam::{DMat3, DVec3};

/// Largest number of frames.
pub(crate) const MOST_FRAMES: usize = 4;

/// Number of facets that are looked at, and number of directions that are told apart.
const SAMPLE: usize = 4096;
const GROUPS: usize = 64;

/// Least cosine between directions that count as one: about 6 degrees.
const ALIKE: f64 = 0.995;

/// Least part of the area for which a frame is worth its cost.
const WORTHWHILE: f64 = 0.1;

/// Normals that are alike, whatever their sign.
struct AlikeNormals {
    axis: DVec3,
    area: f64,
}

/// Returns from one to [`MOST_FRAMES`] frames for `facets`, as maps from the cell frame.
///
/// Every frame is a rotation. If most facets lie in no such frame, the last one is the cell frame.
pub(crate) fn frames(facets: &[Triangle]) -> Vec<DMat3> {
    let mut groups: Vec<AlikeNormals> = Vec::new();
    let mut whole = 0.0;
    for facet in facets.iter().step_by(facets.len().div_ceil(SAMPLE)) {
        let [a, b, c] = facet.corners;
        let area = (b - a).cross(c - a).length() / 2.0;
        whole += area;
        let alike = |group: &AlikeNormals| group.axis.dot(facet.normal).abs() > ALIKE;
        match groups.iter().position(alike) {
            Some(known) => groups[known].area += area,
            None if groups.len() < GROUPS => groups.push(AlikeNormals {
                axis: facet.normal,
                area,
            }),
            None => {}
        }
    }
    groups.sort_by(|a, b| b.area.total_cmp(&a.area));
    let mut frames = Vec::new();
    let mut covered = 0.0;
    while frames.len() + 1 < MOST_FRAMES && covered < (1.0 - WORTHWHILE) * whole {
        let Some(first) = groups.first().map(|group| group.axis) else {
            break;
        };
        let across = groups
            .iter()
            .find(|group| group.axis.dot(first).abs() < 0.1);
        let second = across.map_or(first.any_orthonormal_vector(), |group| group.axis);
        let third = first.cross(second).normalize();
        let frame = DMat3::from_cols(first, third.cross(first), third).transpose();
        let fits = |group: &AlikeNormals| (frame * group.axis).abs().max_element() > ALIKE;
        let part: f64 = groups.iter().filter(|g| fits(g)).map(|g| g.area).sum();
        if part < WORTHWHILE * whole {
            break;
        }
        covered += part;
        groups.retain(|group| !fits(group));
        frames.push(frame);
    }
    if covered < (1.0 - WORTHWHILE) * whole || frames.is_empty() {
        frames.push(DMat3::IDENTITY);
    }
    frames
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the faces of a cube corner with the edges `edges`.
    fn corner([a, b, c]: [DVec3; 3]) -> Vec<Triangle> {
        let faces = [[a, b], [b, c], [c, a]];
        let facet = |[p, q]: [DVec3; 2]| Triangle::new([DVec3::ZERO, p, q]);
        faces.into_iter().filter_map(facet).collect()
    }

    /// A cube has one frame, in which its normals are axes; two cubes that are turned have two;
    /// facets all around have the cell frame last. All frames are rotations.
    #[test]
    fn frames_follow_the_cubes() {
        let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
        let cube = corner([DVec3::X, DVec3::Y, DVec3::Z].map(|edge| turn * edge));
        let other = corner([DVec3::X, DVec3::Y, DVec3::Z]);
        let around = (0..500).filter_map(|k| {
            let turn = DMat3::from_euler(
                glam::EulerRot::XYZ,
                1.3 * f64::from(k),
                0.37 * f64::from(k),
                0.0,
            );
            Triangle::new([DVec3::ZERO, turn * DVec3::X, turn * DVec3::Y])
        });
        let cases = [
            (cube.clone(), 1),
            ([cube, other].concat(), 2),
            (around.collect(), 1),
        ];
        for (facets, count) in &cases {
            let frames = frames(facets);
            assert_eq!(frames.len(), *count);
            for frame in &frames {
                let off = *frame * frame.transpose() - DMat3::IDENTITY;
                let worst = off
                    .to_cols_array()
                    .into_iter()
                    .fold(0.0, |w, x| x.abs().max(w));
                assert!(worst < 1e-14 && frame.determinant() > 0.0, "{frame}");
            }
        }
        let [frame] = frames(&cases[0].0)[..] else {
            panic!("one frame")
        };
        for facet in &cases[0].0 {
            assert!((frame * facet.normal).abs().max_element() > 1.0 - 1e-14);
        }
        assert_eq!(frames(&cases[2].0), [DMat3::IDENTITY]);
    }
}
