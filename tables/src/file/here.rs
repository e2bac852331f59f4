//! Reading of a table from its file, in this very process.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use crate::error::error::Error;
use crate::file::seal::Seal;
use crate::file::{heap, layout, ledger, seal};
use crate::table::table::Table;

/// Longest file that is read, bytes: the largest table within the memory limit, incompressible.
const MOST_BYTES: u64 = (1 << 31) + (1 << 24);

/// First bytes of every HDF5 file.
const SIGNATURE: [u8; 8] = *b"\x89HDF\r\n\x1a\n";

/// Reads a table in this very process.
///
/// # Errors
/// Returns an [`Error`] if the file is no table, is damaged, breaks a rule, or has another content
/// hash than it states.
pub(crate) fn here(path: &Path) -> Result<Table, Error> {
    guard(path)?;
    ledger::confine();
    let failed = |source| Error::Hdf5 {
        file: path.to_owned(),
        place: "file".to_owned(),
        source,
    };
    let file = hdf5::File::open(path).map_err(failed)?;
    let (table, stored) = layout::load(&file, path)?;
    let computed = table.content_hash();
    if stored != computed {
        return Err(Error::ContentHash {
            file: path.to_owned(),
            stored,
            computed,
        });
    }
    Ok(table)
}

/// Checks all that can be checked without the HDF5 library, which is not made for damaged files.
fn guard(path: &Path) -> Result<(), Error> {
    let failed = |source| Error::Open {
        file: path.to_owned(),
        source,
    };
    // Opening a pipe would wait for its writer.
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        return Err(Error::NotAFile {
            file: path.to_owned(),
        });
    }
    let mut file = File::open(path).map_err(failed)?;
    let bytes = file.seek(SeekFrom::End(0)).map_err(failed)?;
    if bytes > MOST_BYTES {
        return Err(Error::FileSize {
            file: path.to_owned(),
            bytes,
            limit: MOST_BYTES,
        });
    }
    let mut start = Vec::new();
    file.rewind().map_err(failed)?;
    (&mut file)
        .take(SIGNATURE.len() as u64)
        .read_to_end(&mut start)
        .map_err(failed)?;
    if start != SIGNATURE {
        return Err(Error::NotHdf5 {
            file: path.to_owned(),
            bytes,
        });
    }
    let mut content = start;
    file.take(MOST_BYTES)
        .read_to_end(&mut content)
        .map_err(failed)?;
    if let Seal::Broken { stored, computed } = seal::check(&content) {
        return Err(Error::Damaged {
            file: path.to_owned(),
            stored,
            computed,
        });
    }
    match heap::first_broken(&content) {
        Some(offset) => Err(Error::Heap {
            file: path.to_owned(),
            offset,
        }),
        None => Ok(()),
    }
}
