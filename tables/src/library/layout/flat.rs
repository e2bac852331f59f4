//! Flat arrays of a group, over dimensions with names but without coordinates.

use hdf5::{Dataset, Group, H5Type, Result};
use ndarray::ArrayViewD;

use crate::library::layout::names::Dimension;
use crate::library::layout::store::dataset;
use crate::library::scales::{attach_scale, set_scale};

/// Name by which netCDF knows a scale that has no coordinates.
///
/// The rest of the line is a length, which no reader needs.
const NO_COORDINATES: &std::ffi::CStr = c"This is a netCDF dimension but not a netCDF variable.";

/// Writer of the arrays of a group, with the dimensions that it has written.
pub(crate) struct Flat<'a> {
    group: &'a Group,
    dimensions: Vec<(Dimension, Dataset)>,
}

impl<'a> Flat<'a> {
    /// Starts with a group that has no arrays yet.
    pub(crate) fn new(group: &'a Group) -> Self {
        let dimensions = Vec::new();
        Flat { group, dimensions }
    }

    /// Writes numbers as an array over these dimensions, each with its length, in one chunk.
    pub(crate) fn array<T: H5Type + Clone>(
        &mut self,
        name: &str,
        values: &[T],
        dimensions: &[(Dimension, usize)],
    ) -> Result<()> {
        let shape: Vec<usize> = dimensions.iter().map(|(_, length)| *length).collect();
        let values = ArrayViewD::from_shape(&shape[..], values)
            .map_err(|error| hdf5::Error::Internal(error.to_string()))?;
        let array = dataset(self.group, name, values, &shape)?;
        for (axis, &(dimension, length)) in (0..).zip(dimensions) {
            attach_scale(&array, self.scale(dimension, length)?, axis)?;
        }
        Ok(())
    }

    /// Returns the scale of a dimension, which is written if it is new.
    fn scale(&mut self, dimension: Dimension, length: usize) -> Result<&Dataset> {
        let known = |(other, _): &(Dimension, Dataset)| *other == dimension;
        let place = match self.dimensions.iter().position(known) {
            Some(place) => place,
            None => {
                // Nothing is ever written into it, so it takes no room for numbers.
                let scale = (self.group.new_dataset::<u8>())
                    .obj_track_times(false)
                    .shape(length)
                    .create(dimension.0)?;
                set_scale(&scale, NO_COORDINATES)?;
                self.dimensions.push((dimension, scale));
                self.dimensions.len() - 1
            }
        };
        Ok(&self.dimensions[place].1)
    }
}
