//! The polygons of an exact table: ragged in memory, flat in the file.

use super::exact;
use super::place::Place;
use crate::error::Error;
use crate::table::{Exact, Path};

/// The group of polygons, if the file has one.
pub(super) fn load(root: &Place, directions: usize) -> Result<Option<Exact>, Error> {
    if !root.has(exact::GROUP) {
        return Ok(None);
    }
    let group = root
        .group
        .group(exact::GROUP)
        .map_err(root.hdf5("group", exact::GROUP))?;
    let place = Place::new(&group, root.file, "exact/")?;
    let (start, shape) = place.flat::<u64>(exact::POLYGON_START, &[None])?;
    let Some(count) = shape[0].checked_sub(1) else {
        let dataset = place.named(exact::POLYGON_START);
        return Err(Error::Shape {
            file: root.file.to_owned(),
            dataset,
            expected: "[paths + 1]".into(),
            found: shape,
        });
    };
    let (direction, _) = place.flat::<u64>(exact::PATH_DIRECTION, &[Some(count)])?;
    let (matrix, _) = place.flat::<f64>(exact::PATH_MATRIX, &[Some(count), Some(2), Some(2)])?;
    let (offset, _) = place.flat::<f64>(exact::PATH_OFFSET, &[Some(count), Some(2)])?;
    let (weight, _) = place.flat::<f64>(exact::PATH_WEIGHT, &[Some(count)])?;
    let (vertex, _) = place.flat::<f64>(exact::POLYGON_VERTEX, &[None, Some(2)])?;
    let (vertices, _) = vertex.as_chunks::<2>();
    let mut paths = vec![Vec::new(); directions];
    let wrong = |dataset: &'static str, index: usize, expected: String, found: u64| Error::Scale {
        file: root.file.to_owned(),
        dataset: place.named(dataset),
        index,
        expected,
        found: found.to_string(),
    };
    for k in 0..count {
        let lower = if k == 0 { 0 } else { direction[k - 1] };
        if direction[k] < lower || direction[k] >= directions as u64 {
            let expected = format!("{lower} to {}", directions - 1);
            return Err(wrong(exact::PATH_DIRECTION, k, expected, direction[k]));
        }
        let begin = if k == 0 { 0 } else { start[k] };
        let polygon = (start[k] == begin && start[k + 1] >= begin)
            .then(|| vertices.get(begin as usize..start[k + 1] as usize))
            .flatten();
        let Some(polygon) = polygon else {
            let expected = format!("{begin} to {}", vertices.len());
            return Err(wrong(exact::POLYGON_START, k + 1, expected, start[k + 1]));
        };
        let m = &matrix[4 * k..4 * k + 4];
        paths[direction[k] as usize].push(Path {
            polygon: polygon.to_vec(),
            matrix: [[m[0], m[1]], [m[2], m[3]]],
            offset: [offset[2 * k], offset[2 * k + 1]],
            weight: weight[k],
        });
    }
    if start[count] != vertices.len() as u64 || (count == 0 && start[0] != 0) {
        return Err(wrong(
            exact::POLYGON_START,
            count,
            vertices.len().to_string(),
            start[count],
        ));
    }
    Ok(Some(Exact {
        entrance_area: place.number(exact::ENTRANCE_AREA)?,
        paths,
    }))
}
