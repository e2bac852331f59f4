//! Rays by shift and deviation: a list a direction in memory, flat in the file.

use hdf5::{File, Result};

use super::deviation;
use super::place::Place;
use super::store::{put, shaped};
use crate::deviation::{Deviations, Entry, Grid};
use crate::error::Error;

/// The lists of all directions one after another, the way they are stored and hashed.
#[derive(Debug)]
pub(crate) struct Flat {
    /// Direction k has the entries start[k] .. start[k + 1].
    pub start: Vec<u64>,
    pub place: Vec<u64>,
    pub rays: Vec<u64>,
}

impl Flat {
    pub fn new(deviations: &Deviations) -> Flat {
        let mut start = vec![0];
        for entries in &deviations.entries {
            start.push(start[start.len() - 1] + entries.len() as u64);
        }
        let all = || deviations.entries.iter().flatten();
        Flat {
            start,
            place: all().map(|entry| entry.place).collect(),
            rays: all().map(|entry| entry.rays).collect(),
        }
    }

    /// The lists again. The first start that does not fit, where one does not; `place` and `rays` are equally long.
    pub fn entries(&self) -> std::result::Result<Vec<Vec<Entry>>, usize> {
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

/// Writes the group.
pub(super) fn store(found: &Deviations, file: &File) -> Result<()> {
    let mut builder = file.create_group_builder();
    builder.gcpl().obj_track_times(false);
    let group = builder.create(deviation::GROUP)?;
    let Grid { cells, bins, range } = found.grid;
    put(&group, deviation::CELLS, &(cells as u64))?;
    put(&group, deviation::BINS, &(bins as u64))?;
    put(&group, deviation::RANGE, &range)?;
    let flat = Flat::new(found);
    let entries = flat.place.len();
    shaped(&group, deviation::START, &flat.start, &[flat.start.len()])?;
    shaped(&group, deviation::PLACE, &flat.place, &[entries])?;
    shaped(&group, deviation::RAYS, &flat.rays, &[entries])
}

/// The group, if the file has one.
pub(super) fn load(
    root: &Place,
    directions: usize,
) -> std::result::Result<Option<Deviations>, Error> {
    if !root.has(deviation::GROUP) {
        return Ok(None);
    }
    let group = root
        .group
        .group(deviation::GROUP)
        .map_err(root.hdf5("group", deviation::GROUP))?;
    let place = root.inside(&group, "deviation/")?;
    let number = |name| {
        place
            .integer(name)
            .map(|n| usize::try_from(n).unwrap_or(usize::MAX))
    };
    let grid = Grid {
        cells: number(deviation::CELLS)?,
        bins: number(deviation::BINS)?,
        range: place.number(deviation::RANGE)?,
    };
    let (start, _) = place.flat::<u64>(deviation::START, &[Some(directions + 1)])?;
    let (places, shape) = place.flat::<u64>(deviation::PLACE, &[None])?;
    let (rays, _) = place.flat::<u64>(deviation::RAYS, &[Some(shape[0])])?;
    let flat = Flat {
        start,
        place: places,
        rays,
    };
    let entries = flat.entries().map_err(|index| Error::Scale {
        file: root.file.to_owned(),
        dataset: place.named(deviation::START),
        index,
        expected: format!("ascending from 0 to {}", shape[0]),
        found: flat.start[index].to_string(),
    })?;
    Ok(Some(Deviations { grid, entries }))
}
