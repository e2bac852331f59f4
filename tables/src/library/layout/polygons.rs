//! Polygons of an exact table: ragged in memory, flat in the file.

use crate::error::Error;
use crate::library::layout::names::exact;
use crate::library::layout::place::{NumericElement, Place};
use crate::table::exact::Exact;
use crate::table::flat::FlatPaths;

/// Reads the group of polygons, if the file has one.
pub(crate) fn load(root: &Place, directions: usize) -> Result<Option<Exact>, Error> {
    if !root.has(exact::GROUP) {
        return Ok(None);
    }
    let group = root
        .group
        .group(exact::GROUP)
        .map_err(root.hdf5("group", exact::GROUP))?;
    let place = root.inside(&group, "exact/")?;
    let (start, shape) = place.flat::<u64>(exact::POLYGON_START, &[None])?;
    let Some(count) = shape[0].checked_sub(1) else {
        let fault = format!("has shape {shape:?}, expected [paths + 1]");
        return Err(place.wrong("dataset", exact::POLYGON_START, fault));
    };
    let (direction, _) = place.flat::<u64>(exact::PATH_DIRECTION, &[Some(count)])?;
    let (matrix, _) = place.flat::<f64>(exact::PATH_MATRIX, &[Some(count), Some(2), Some(2)])?;
    let (offset, _) = place.flat::<f64>(exact::PATH_OFFSET, &[Some(count), Some(2)])?;
    let (weight, _) = place.flat::<f64>(exact::PATH_WEIGHT, &[Some(count)])?;
    let pair = [Some(count), Some(2)];
    let deviation = optional::<f64>(&place, exact::PATH_DEVIATION, &pair)?;
    let passes = optional::<u64>(&place, exact::PATH_PASSES, &pair[..1])?;
    let complex = [Some(count), Some(2), Some(2), Some(2)];
    let jones = optional::<f64>(&place, exact::PATH_JONES, &complex)?;
    let cube = optional::<f64>(&place, exact::PATH_CUBE, &[Some(count), Some(3), Some(3)])?;
    let (vertex, _) = place.flat::<f64>(exact::POLYGON_VERTEX, &[None, Some(2)])?;
    let flat = FlatPaths {
        direction,
        matrix,
        offset,
        weight,
        deviation,
        passes,
        jones,
        cube,
        start,
        vertex,
    };
    let paths = flat.paths(directions).map_err(|misfit| {
        place.differs(misfit.array, misfit.index, misfit.expected, misfit.found)
    })?;
    Ok(Some(Exact {
        entrance_area: place.number(exact::ENTRANCE_AREA)?,
        paths,
    }))
}

/// Reads an array that some tables leave out. It is then empty.
fn optional<T: NumericElement>(
    place: &Place,
    name: &str,
    shape: &[Option<usize>],
) -> Result<Vec<T>, Error> {
    if !place.has(name) {
        return Ok(Vec::new());
    }
    Ok(place.flat::<T>(name, shape)?.0)
}
