//! Whether the JPEGs within a TIFF are whole. If its compression is 7, each strip or tile is a JPEG
//! (TIFF Technical Note 2, 1995).
//!
//! The tables of all strips may stand apart, in the tag `JPEGTables`. They are put before each
//! strip, as the decoder does it.

use std::io::{Read, Seek, SeekFrom};

use crate::photographs::photo::jpeg;
use crate::photographs::photo::jpeg::Whole;

/// Length of a marker of a JPEG, bytes.
const MARKER: usize = 2;

/// Checks strips or tiles that are JPEGs, start at these places of the file and have these lengths.
///
/// # Errors
/// Returns the reason, in words, if something is missing or has no meaning.
pub(crate) fn check(
    file: &mut (impl Read + Seek),
    tables: Option<&[u8]>,
    starts: &[u64],
    lengths: &[u64],
) -> Result<Whole, String> {
    let size = file.seek(SeekFrom::End(0)).unwrap_or(0);
    // More would take memory and time that the file does not account for.
    let claimed = lengths.iter().fold(0_u64, |sum, &l| sum.saturating_add(l));
    if claimed > size || starts.len() != lengths.len() {
        return Err("its strips claim more bytes than it has".into());
    }
    let mut whole = Whole::default();
    for (i, (&start, &length)) in starts.iter().zip(lengths).enumerate() {
        let mut bytes = Vec::new();
        let read = file.seek(SeekFrom::Start(start));
        let read = read.and_then(|_| file.take(length).read_to_end(&mut bytes));
        let here = |reason: String| {
            let count = starts.len();
            format!("in part {} of {count}: {reason}", i + 1)
        };
        if read.is_err() || (bytes.len() as u64) < length {
            return Err(here("its bytes are missing".into()));
        }
        if let Some(tables) = tables {
            // The end of the tables and the start of the strip would end the picture.
            let head = &tables[..tables.len().saturating_sub(MARKER)];
            bytes = [head, &bytes[MARKER.min(bytes.len())..]].concat();
        }
        let strip = jpeg::check(&bytes).map_err(here)?;
        whole.warning = whole.warning.or(strip.warning);
    }
    Ok(whole)
}
