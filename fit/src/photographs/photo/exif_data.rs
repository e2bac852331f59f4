//! Exif data of a file, read as far as they can be.

use std::fs::File;
use std::io::BufReader;

use exif::Exif;

/// Reads the Exif data of a JPEG, TIFF or PNG. Returns `None` if there are none.
pub(crate) fn read(file: File) -> Option<Exif> {
    // A damaged entry must not hide the others.
    let read = exif::Reader::new()
        .continue_on_error(true)
        .read_from_container(&mut BufReader::new(file));
    let exif = read.or_else(|error| error.distill_partial_result(|_| ()));
    exif.ok().filter(|exif| exif.fields().len() > 0)
}
