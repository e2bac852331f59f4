//! Ragged lists as flat arrays, the way they are stored and hashed.

use crate::table::deviation::{Deviations, Entry};
use crate::table::exact::{Exact, Path};

/// The lists of all directions one after another, the way they are stored and hashed.
#[derive(Debug)]
pub(crate) struct FlatEntries {
    /// Direction k has the entries start[k] .. start[k + 1].
    pub start: Vec<u64>,
    pub place: Vec<u64>,
    pub rays: Vec<u64>,
}

impl FlatEntries {
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

    /// The lists again. The first start that does not fit, where one does not; `place` and `rays`
    /// are equally long.
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

/// The ragged paths of an exact table as flat arrays, the way they are stored and hashed.
#[derive(Debug, Default)]
pub(crate) struct FlatPaths {
    /// Direction of each path, incidence * azimuths + azimuth, ascending.
    pub direction: Vec<u64>,
    /// Four numbers a path, row-major.
    pub matrix: Vec<f64>,
    /// Two numbers a path.
    pub offset: Vec<f64>,
    /// One number a path.
    pub weight: Vec<f64>,
    /// Two numbers a path; none at all where every one is 0.
    pub deviation: Vec<f64>,
    /// Path k has the vertices start[k] .. start[k + 1].
    pub start: Vec<u64>,
    /// Two numbers a vertex.
    pub vertex: Vec<f64>,
}

impl FlatPaths {
    /// FlatPathstens direction by direction, path by path, vertex by vertex.
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
                flat.vertex.extend(path.polygon.as_flattened());
                flat.start.push(flat.vertex.len() as u64 / 2);
            }
        }
        if flat.deviation.iter().all(|&tangent| tangent == 0.0) {
            flat.deviation.clear();
        }
        flat
    }

    /// The paths again, by direction.
    ///
    /// # Errors
    /// The first entry that does not fit the others. The arrays of a path have its numbers of
    /// elements: callers see to that.
    pub(crate) fn paths(&self, directions: usize) -> Result<Vec<Vec<Path>>, Misfit> {
        let (vertices, _) = self.vertex.as_chunks::<2>();
        let (matrices, _) = self.matrix.as_chunks::<4>();
        let (offsets, _) = self.offset.as_chunks::<2>();
        let (deviations, _) = self.deviation.as_chunks::<2>();
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
            let [uu, uv, vu, vv] = matrices[k];
            paths[direction as usize].push(Path {
                polygon: polygon.to_vec(),
                matrix: [[uu, uv], [vu, vv]],
                offset: offsets[k],
                weight: self.weight[k],
                deviation: deviations.get(k).copied().unwrap_or_default(),
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

/// An entry of the flat arrays that does not fit the others.
#[derive(Debug)]
pub(crate) struct Misfit {
    /// Name of the array.
    pub array: &'static str,
    /// Index of the entry.
    pub index: usize,
    /// What would fit.
    pub expected: String,
    /// What is there.
    pub found: u64,
}
