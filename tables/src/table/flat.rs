//! Ragged lists as flat arrays, for the file and the content hash.

use crate::table::deviation::{Deviations, Entry};
use crate::table::exact::{Exact, Path};

/// Entries of all directions one after another, for the file and the content hash.
#[derive(Debug)]
pub(crate) struct FlatEntries {
    /// Bounds of the directions: direction k has the entries start[k] .. start[k + 1].
    pub start: Vec<u64>,
    /// Place of each entry.
    pub place: Vec<u64>,
    /// Number of rays of each entry.
    pub rays: Vec<u64>,
}

impl FlatEntries {
    /// Puts the entries of all directions one after another.
    pub(crate) fn new(deviations: &Deviations) -> FlatEntries {
        let mut start = vec![0];
        for entries in &deviations.entries {
            start.push(start[start.len() - 1] + entries.len() as u64);
        }
        let all = || deviations.entries.iter().flatten();
        FlatEntries {
            start,
            place: all().map(|entry| entry.place).collect(),
            rays: all().map(|entry| entry.rays).collect(),
        }
    }

    /// Returns the entries of each direction. `place` and `rays` must be equally long.
    ///
    /// # Errors
    /// Returns the index of the first value of `start` that does not fit the others.
    pub(crate) fn entries(&self) -> Result<Vec<Vec<Entry>>, usize> {
        let mut entries = Vec::new();
        let mut end = 0;
        for (k, pair) in self.start.windows(2).enumerate() {
            let range = pair[0] as usize..pair[1] as usize;
            if range.start != end {
                return Err(k);
            }
            end = range.end;
            let (Some(places), Some(rays)) = (self.place.get(range.clone()), self.rays.get(range))
            else {
                return Err(k + 1);
            };
            let pairs = places.iter().zip(rays);
            entries.push(pairs.map(|(&place, &rays)| Entry { place, rays }).collect());
        }
        match end == self.place.len() {
            true => Ok(entries),
            false => Err(self.start.len() - 1),
        }
    }
}

/// Paths of an exact table as flat arrays, for the file and the content hash.
#[derive(Debug, Default)]
pub(crate) struct FlatPaths {
    /// Direction of each path, incidence * azimuths + azimuth, ascending.
    pub direction: Vec<u64>,
    /// Linear parts of the shift maps, four numbers a path, row-major.
    pub matrix: Vec<f64>,
    /// Constant parts of the shift maps, two numbers a path.
    pub offset: Vec<f64>,
    /// Weights, one number a path.
    pub weight: Vec<f64>,
    /// Deviations, two numbers a path; empty if all are 0.
    pub deviation: Vec<f64>,
    /// Numbers of passes, one number a path; empty if all are 0.
    pub passes: Vec<u64>,
    /// Jones matrices, eight numbers a path; empty if a path has none.
    pub jones: Vec<f64>,
    /// Cubes, nine numbers a path, all 0 where a path has none; empty if none has one.
    pub cube: Vec<f64>,
    /// Bounds of the polygons: path k has the vertices start[k] .. start[k + 1].
    pub start: Vec<u64>,
    /// Vertices of the polygons, two numbers a vertex.
    pub vertex: Vec<f64>,
}

impl FlatPaths {
    /// Flattens the paths direction by direction, path by path, vertex by vertex.
    pub(crate) fn new(exact: &Exact) -> FlatPaths {
        let mut flat = FlatPaths {
            start: vec![0],
            ..FlatPaths::default()
        };
        for (direction, paths) in exact.paths.iter().enumerate() {
            for path in paths {
                flat.direction.push(direction as u64);
                flat.matrix.extend(path.matrix.as_flattened());
                flat.offset.extend(path.offset);
                flat.weight.push(path.weight);
                flat.deviation.extend(path.deviation);
                flat.passes.push(u64::from(path.passes));
                let jones = path.jones.iter().flatten().flatten().flatten();
                flat.jones.extend(jones);
                flat.cube
                    .extend(path.cube.unwrap_or_default().as_flattened());
                flat.vertex.extend(path.polygon.as_flattened());
                flat.start.push(flat.vertex.len() as u64 / 2);
            }
        }
        if flat.deviation.iter().all(|&tangent| tangent == 0.0) {
            flat.deviation.clear();
        }
        if flat.passes.iter().all(|&passes| passes == 0) {
            flat.passes.clear();
        }
        if flat.cube.iter().all(|&x| x == 0.0) {
            flat.cube.clear();
        }
        if flat.jones.len() < 8 * flat.weight.len() {
            flat.jones.clear();
        }
        flat
    }

    /// Returns the paths of each direction.
    ///
    /// The caller must check before that each array has its number of elements for every path.
    ///
    /// # Errors
    /// Returns the first entry that does not fit the others.
    pub(crate) fn paths(&self, directions: usize) -> Result<Vec<Vec<Path>>, Misfit> {
        let (vertices, _) = self.vertex.as_chunks::<2>();
        let (matrices, _) = self.matrix.as_chunks::<4>();
        let (offsets, _) = self.offset.as_chunks::<2>();
        let (deviations, _) = self.deviation.as_chunks::<2>();
        let (jones, _) = self.jones.as_chunks::<8>();
        let (cubes, _) = self.cube.as_chunks::<9>();
        let mut paths = vec![Vec::new(); directions];
        let mut lowest = 0;
        for (k, &direction) in self.direction.iter().enumerate() {
            if direction < lowest || direction >= directions as u64 {
                return Err(Misfit {
                    array: "path_direction",
                    index: k,
                    expected: format!("{lowest} to {}", directions - 1),
                    found: direction,
                });
            }
            lowest = direction;
            let begin = if k == 0 { 0 } else { self.start[k] };
            let polygon = (self.start[k] == begin && self.start[k + 1] >= begin)
                .then(|| vertices.get(begin as usize..self.start[k + 1] as usize))
                .flatten();
            let Some(polygon) = polygon else {
                return Err(Misfit {
                    array: "polygon_start",
                    index: k + 1,
                    expected: format!("{begin} to {}", vertices.len()),
                    found: self.start[k + 1],
                });
            };
            let passes = self.passes.get(k).copied().unwrap_or_default();
            let Ok(passes) = u32::try_from(passes) else {
                return Err(Misfit {
                    array: "path_passes",
                    index: k,
                    expected: format!("0 to {}", u32::MAX),
                    found: passes,
                });
            };
            let [uu, uv, vu, vv] = matrices[k];
            paths[direction as usize].push(Path {
                polygon: polygon.to_vec(),
                matrix: [[uu, uv], [vu, vv]],
                offset: offsets[k],
                weight: self.weight[k],
                deviation: deviations.get(k).copied().unwrap_or_default(),
                passes,
                jones: jones
                    .get(k)
                    .map(|&[a, b, c, d, e, f, g, h]| [[[a, b], [c, d]], [[e, f], [g, h]]]),
                cube: cubes
                    .get(k)
                    .map(|&[a, b, c, d, e, f, g, h, i]| [[a, b, c], [d, e, f], [g, h, i]])
                    .filter(|cube| *cube != [[0.0; 3]; 3]),
            });
        }
        let count = self.direction.len();
        if self.start[0] != 0 || self.start[count] != vertices.len() as u64 {
            return Err(Misfit {
                array: "polygon_start",
                index: count,
                expected: vertices.len().to_string(),
                found: self.start[count],
            });
        }
        Ok(paths)
    }
}

/// Entry of the flat arrays that does not fit the others.
#[derive(Debug)]
pub(crate) struct Misfit {
    /// Name of the array.
    pub array: &'static str,
    /// Index of the entry.
    pub index: usize,
    /// Values that would fit, in words.
    pub expected: String,
    /// Value that is there.
    pub found: u64,
}
