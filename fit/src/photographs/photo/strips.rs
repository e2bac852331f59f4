//! Whether the JPEGs within a TIFF are whole. If its compression is 7, each strip or tile is a JPEG
//! (TIFF Technical Note 2, 1995).
//!
//! The tables of all strips may stand apart, in the tag `JPEGTables`. They are put before each
//! strip, as the decoder does it.

use std::io::{Read, Seek, SeekFrom};

use tiff::decoder::Decoder;
use tiff::tags::{CompressionMethod, Tag};

use crate::photographs::photo::jpeg;
use crate::photographs::photo::jpeg::Whole;

/// Length of a marker of a JPEG, bytes.
const MARKER: usize = 2;

/// Checks that all strips or tiles of a TIFF are whole, if they are JPEGs.
///
/// # Errors
/// Returns the reason, in words, if something is missing or has no meaning.
pub(crate) fn check(reader: impl Read + Seek) -> Result<Whole, String> {
    // A directory that cannot be read is refused when the pixels are.
    let Ok(mut decoder) = Decoder::new(reader) else {
        return Ok(Whole::default());
    };
    let method = decoder.find_tag_unsigned::<u16>(Tag::Compression);
    if !matches!(method, Ok(Some(code)) if code == CompressionMethod::ModernJPEG.to_u16()) {
        return Ok(Whole::default());
    }
    let lists = || "its list of strips cannot be read".to_owned();
    let tables = decoder.find_tag(Tag::JPEGTables).map_err(|_| lists())?;
    let tables = tables.map(|value| value.into_u8_vec()).transpose();
    let tables = tables.map_err(|_| lists())?;
    let mut list = |names: [Tag; 2]| {
        names.into_iter().find_map(|name| {
            let found = decoder.find_tag_unsigned_vec::<u64>(name);
            found.ok().flatten()
        })
    };
    let starts = list([Tag::StripOffsets, Tag::TileOffsets]).ok_or_else(lists)?;
    let lengths = list([Tag::StripByteCounts, Tag::TileByteCounts]).ok_or_else(lists)?;
    strips(decoder.inner(), tables.as_deref(), &starts, &lengths)
}

/// Checks strips that start at these places of the file and have these lengths.
fn strips(
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
