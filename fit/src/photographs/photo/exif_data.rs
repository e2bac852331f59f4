//! Exif data of a file, read as far as they can be.

use std::fs::File;
use std::io::BufReader;

use exif::Exif;

use crate::photographs::photo::caught::caught;

/// Reads the Exif data of a JPEG, TIFF or PNG. Returns `None` if there are none.
pub(crate) fn read(file: File) -> Option<Exif> {
    // A damaged entry must not hide the others.
    let read = caught(|| {
        let mut reader = exif::Reader::new();
        let read = reader
            .continue_on_error(true)
            .read_from_container(&mut BufReader::new(file));
        read.or_else(|error| error.distill_partial_result(|_| ()))
    });
    read.ok()?.ok().filter(|exif| exif.fields().len() > 0)
}
