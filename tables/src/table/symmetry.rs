//! Symmetry of a distribution about the normal, by which a sector of azimuths stands for all.

use ndarray::{Array2, s};

use crate::table::exact::Path;

/// Most rotations that a table may claim; a hexagonal lattice has 6.
pub(crate) const MOST_ROTATIONS: u32 = 360;

/// Symmetry of a sheet about its normal, as far as ray shifts see it.
///
/// In the incidence frame a rotated direction has an equal distribution, and a mirrored one has it
/// with v turned over. So no value is computed: it is looked up at another azimuth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Symmetry {
    /// Number of rotations: azimuths that differ by 360 / `rotations` degrees have one
    /// distribution; 1 without rotations.
    pub rotations: u32,
    /// Azimuth of a mirror plane, degrees.
    ///
    /// Azimuths at equal angles on both sides of it have mirrored distributions.
    pub mirror_deg: Option<f64>,
}

impl Symmetry {
    /// No symmetry: no two azimuths have one distribution.
    pub const NONE: Symmetry = Symmetry {
        rotations: 1,
        mirror_deg: None,
    };

    /// Returns the smallest sector that stands for all azimuths: its first azimuth and its width,
    /// degrees.
    ///
    /// With a mirror plane, both ends of the sector are mirror planes. Without one, its end is
    /// equal to its beginning.
    ///
    /// ```
    /// let six = tables::Symmetry { rotations: 6, mirror_deg: Some(0.0) };
    /// assert_eq!(six.sector_deg(), (0.0, 30.0));
    /// ```
    pub fn sector_deg(&self) -> (f64, f64) {
        let turn = 360.0 / f64::from(self.rotations);
        match self.mirror_deg {
            Some(mirror) => (mirror, turn / 2.0),
            None => (0.0, turn),
        }
    }

    /// Returns the azimuths in [0, 360) that have the distribution of `azimuth_deg`, each with
    /// whether it is mirrored there.
    pub fn images(&self, azimuth_deg: f64) -> impl Iterator<Item = (f64, bool)> + use<> {
        let turn = 360.0 / f64::from(self.rotations);
        let mirrored = self.mirror_deg.map(|mirror| 2.0 * mirror - azimuth_deg);
        let starts = [Some((azimuth_deg, false)), mirrored.map(|x| (x, true))];
        let rotations = 0..self.rotations;
        starts.into_iter().flatten().flat_map(move |(x, mirrored)| {
            rotations
                .clone()
                .map(move |k| ((x + f64::from(k) * turn).rem_euclid(360.0), mirrored))
        })
    }
}

/// Returns a histogram `[v, u]` seen in a mirror that holds the plane of incidence.
pub(crate) fn mirrored(probability: Array2<f64>) -> Array2<f64> {
    probability.slice_move(s![..;-1, ..])
}

/// Returns paths seen in a mirror that holds the plane of incidence.
///
/// v changes its sign. The corners of a polygon are reversed, so that it stays counter-clockwise.
pub(crate) fn mirrored_paths(paths: &[Path]) -> Vec<Path> {
    let mirrored = |path: &Path| {
        let ([[uu, uv], [vu, vv]], [u, v]) = (path.matrix, path.offset);
        let [across, along_v] = path.deviation;
        Path {
            polygon: path.polygon.iter().rev().map(|&[u, v]| [u, -v]).collect(),
            matrix: [[uu, -uv], [-vu, vv]],
            offset: [u, -v],
            weight: path.weight,
            deviation: [across, -along_v],
            passes: path.passes,
            // The field along v changes its sign, before and behind the sheet.
            jones: path
                .jones
                .map(|[[ss, sp], [ps, pp]]| [[ss, sp.map(|x| -x)], [ps.map(|x| -x), pp]]),
            cube: path.cube.map(|cube| cube.map(|[u, v, n]| [u, -v, n])),
        }
    };
    paths.iter().map(mirrored).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares a mirrored path with the mirror itself: v changes its sign in the entry point, in
    /// the shift, in the deviation and in the field, and nothing else changes.
    #[test]
    fn a_mirrored_path_does_what_its_mirror_image_does() {
        let path = Path {
            polygon: vec![[0.0, 0.0], [0.5, 0.125], [0.25, 0.75]],
            matrix: [[-2.0, 0.25], [0.5, -1.5]],
            offset: [0.125, -0.375],
            weight: 0.75,
            deviation: [3e-3, -2e-3],
            passes: 2,
            jones: Some([[[0.5, 0.25], [0.125, -0.5]], [[0.75, 0.0], [-0.25, 1.0]]]),
            cube: Some([[1.0, 0.0, 0.0], [0.0, 0.75, 0.5], [0.0, -0.5, 0.75]]),
        };
        let mirrored = &mirrored_paths(std::slice::from_ref(&path))[0];
        assert_eq!(mirrored.deviation, [3e-3, 2e-3]);
        assert_eq!((mirrored.weight, mirrored.passes), (0.75, 2));
        let jones = [[[0.5, 0.25], [-0.125, 0.5]], [[-0.75, 0.0], [-0.25, 1.0]]];
        assert_eq!(mirrored.jones, Some(jones));
        let cube = [[1.0, 0.0, 0.0], [0.0, -0.75, 0.5], [0.0, 0.5, 0.75]];
        assert_eq!(mirrored.cube, Some(cube));
        // A positive area means that the corners still run counter-clockwise.
        assert!(path.area() > 0.0);
        assert_eq!(mirrored.area(), path.area());
        for &[u, v] in &path.polygon {
            assert!(mirrored.polygon.contains(&[u, -v]));
            // All numbers are short binary fractions, so the products and sums are exact.
            let [along_u, along_v] = path.shift([u, v]);
            assert_eq!(mirrored.shift([u, -v]), [along_u, -along_v]);
        }
        let twice = mirrored_paths(std::slice::from_ref(mirrored));
        assert_eq!(twice, [path]);
    }

    /// Checks the sector by the images: of every azimuth exactly one image lies within it, and it
    /// begins at a mirror if there is one. The azimuths are odd tenths of a degree, so none lies on
    /// the ends, which are whole or half degrees.
    #[test]
    fn every_azimuth_has_one_image_in_the_sector() {
        let mut cases = 0;
        for (rotations, mirror_deg, sector) in [
            (1, None, (0.0, 360.0)),
            (3, None, (0.0, 120.0)),
            (1, Some(25.0), (25.0, 180.0)),
            (3, Some(10.0), (10.0, 60.0)),
            (6, Some(15.0), (15.0, 30.0)),
        ] {
            let symmetry = Symmetry {
                rotations,
                mirror_deg,
            };
            assert_eq!(symmetry.sector_deg(), sector);
            let (first, width) = sector;
            for tenth in (1..3600).step_by(34) {
                let azimuth = 0.1 * f64::from(tenth);
                let images = symmetry.images(azimuth);
                let inside = images.filter(|(image, _)| (image - first).rem_euclid(360.0) < width);
                assert_eq!(inside.count(), 1, "{symmetry:?} {azimuth}");
                cases += 1;
            }
        }
        assert_eq!(cases, 5 * 106);
    }
}
