//! Group of rays by shift and deviation: one list for each direction in memory, flat in the file.

use hdf5::{File, Result};

use crate::error::Error;
use crate::library::layout::flat::Flat;
use crate::library::layout::names::deviation;
use crate::library::layout::place::Place;
use crate::library::layout::store::put;
use crate::table::deviation::{Deviations, Grid};
use crate::table::flat::FlatEntries;

/// Writes the group.
pub(crate) fn store(found: &Deviations, file: &File) -> Result<()> {
    let mut builder = file.create_group_builder();
    builder.gcpl().obj_track_times(false);
    let group = builder.create(deviation::GROUP)?;
    let Grid { cells, bins, range } = found.grid;
    put(&group, deviation::CELLS, &(cells as u64))?;
    put(&group, deviation::BINS, &(bins as u64))?;
    put(&group, deviation::RANGE, &range)?;
    let flat = FlatEntries::new(found);
    let entries = [(deviation::ENTRY, flat.place.len())];
    let bounds = [(deviation::BOUND, flat.start.len())];
    let mut group = Flat::new(&group);
    group.array(deviation::START, &flat.start, &bounds)?;
    group.array(deviation::PLACE, &flat.place, &entries)?;
    group.array(deviation::RAYS, &flat.rays, &entries)
}

/// Reads the group, if the file has one.
pub(crate) fn load(
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
    let flat = FlatEntries {
        start,
        place: places,
        rays,
    };
    let entries = flat.entries().map_err(|index| {
        let expected = format!("ascending from 0 to {}", shape[0]);
        place.differs(deviation::START, index, expected, flat.start[index])
    })?;
    Ok(Some(Deviations { grid, entries }))
}
