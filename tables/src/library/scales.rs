//! Calls to the HDF5 library that its Rust crate does not offer.
//!
//! They are dimension scales (the H5DS calls of libhdf5_hl) and the image of a file that lives in
//! memory. Every call runs inside `hdf5::sync::sync`, because the library is not safe for several
//! threads. The borrowed objects keep their handles open for the duration of the call.

#![allow(unsafe_code, reason = "calls into the C library")]

use std::ffi::{CStr, c_char, c_int, c_uint};

use hdf5::sync::sync;
use hdf5_sys::h5f::H5Fget_file_image;
use hdf5_sys::h5i::hid_t;

use crate::library::memory::last_error;

// hdf5-metno-sys (feature `hl`) links the hl library but declares none of its functions.
unsafe extern "C" {
    fn H5DSset_scale(scale: hid_t, name: *const c_char) -> c_int;
    fn H5DSattach_scale(dataset: hid_t, scale: hid_t, dimension: c_uint) -> c_int;
}

/// Makes a dataset a dimension scale of this name.
pub(crate) fn set_scale(scale: &hdf5::Dataset, name: &CStr) -> Result<(), hdf5::Error> {
    // SAFETY: the handle is open and the name ends in a zero byte; both outlive the call.
    let status = sync(|| unsafe { H5DSset_scale(scale.id(), name.as_ptr()) });
    succeeded(status)
}

/// Attaches a scale to one dimension of a dataset.
pub(crate) fn attach_scale(
    dataset: &hdf5::Dataset,
    scale: &hdf5::Dataset,
    dimension: u32,
) -> Result<(), hdf5::Error> {
    // SAFETY: both handles are open for the call; the library checks the dimension.
    let status = sync(|| unsafe { H5DSattach_scale(dataset.id(), scale.id(), dimension) });
    succeeded(status)
}

/// Returns the bytes of a flushed file, as they would be on disk.
pub(crate) fn image(file: &hdf5::File) -> Result<Vec<u8>, hdf5::Error> {
    sync(|| {
        // SAFETY: a null buffer asks for the length.
        let length = unsafe { H5Fget_file_image(file.id(), std::ptr::null_mut(), 0) };
        let Ok(length) = usize::try_from(length) else {
            return Err(last_error());
        };
        let mut bytes = vec![0_u8; length];
        // SAFETY: the buffer holds `length` bytes, and the lock is held since the length was taken.
        let copied = unsafe { H5Fget_file_image(file.id(), bytes.as_mut_ptr().cast(), length) };
        if usize::try_from(copied) == Ok(length) {
            Ok(bytes)
        } else {
            Err(last_error())
        }
    })
}

/// Turns the status of a call into a result.
fn succeeded(status: c_int) -> Result<(), hdf5::Error> {
    if status < 0 {
        Err(last_error())
    } else {
        Ok(())
    }
}
