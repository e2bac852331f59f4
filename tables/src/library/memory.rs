//! The HDF5 library started so that it loads no code, and files that it reads from memory.
//!
//! Asked for a filter that it lacks, or handed a file that it cannot open, the library searches
//! folders of plug-ins and loads what lies there. Nothing here needs a plug-in. So loading is
//! switched off before the first call, and the library is built with an empty list of folders
//! (`hdf5.cmake` beside this crate).

#![allow(unsafe_code, reason = "calls into the C library")]

use std::ffi::{CString, c_uint};
use std::sync::Once;
use std::sync::atomic::{AtomicU64, Ordering};

use hdf5::File;
use hdf5::plist::FileAccess;
use hdf5::sync::sync;
use hdf5_sys::h5f::{H5F_ACC_RDONLY, H5Fopen};
use hdf5_sys::h5i::hid_t;
use hdf5_sys::h5p::H5Pset_file_image;

// hdf5-metno-sys declares it with a pointer in the place of the flags.
unsafe extern "C" {
    fn H5PLset_loading_state(kinds: c_uint) -> i32;
}

/// Switches the loading of plug-ins off, once in this process.
pub(crate) fn load_no_code() {
    static DONE: Once = Once::new();
    DONE.call_once(|| {
        // SAFETY: the call takes a number. It fails only where no plug-in can be loaded anyway.
        sync(|| unsafe { H5PLset_loading_state(0) });
    });
}

/// Returns a name that no other open file of this process has, not even in memory.
pub(crate) fn unused_name() -> String {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    format!("table-in-memory-{}", NEXT.fetch_add(1, Ordering::Relaxed))
}

/// Opens the bytes of a file for reading. No file of the disk is touched.
pub(crate) fn open(bytes: Vec<u8>) -> hdf5::Result<File> {
    load_no_code();
    let access = FileAccess::build().core_filebacked(false).finish()?;
    let name = CString::new(unused_name()).map_err(|error| error.to_string())?;
    sync(|| {
        // SAFETY: the list is open. The library copies the bytes and does not write to them.
        let set = unsafe {
            H5Pset_file_image(access.id(), bytes.as_ptr().cast_mut().cast(), bytes.len())
        };
        if set < 0 {
            return Err(last_error());
        }
        drop(bytes);
        // SAFETY: the name ends in a zero byte, and the list is open.
        let file: hid_t = unsafe { H5Fopen(name.as_ptr(), H5F_ACC_RDONLY, access.id()) };
        if file < 0 {
            return Err(last_error());
        }
        // SAFETY: the handle is that of a file, was just made, and nothing else holds it.
        unsafe { hdf5::from_id(file) }
    })
}

/// Returns the last error of the library.
pub(crate) fn last_error() -> hdf5::Error {
    hdf5::Error::query().unwrap_or_else(|error| error)
}
