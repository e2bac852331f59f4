//! Reading of a table from the bytes of its file, checked to the last bit before it is used.

use std::io::{self, Read};
use std::path::Path;

use crate::error::Error;
use crate::file::read::{opened, unreadable};
use crate::library::seal::Seal;
use crate::library::{COPY_AGAIN, NAME_A_TABLE, confine, heap, layout, memory, seal};
use crate::table::table::Table;

/// Returns whether the file still ends with the seal that [`crate::write()`] puts there.
///
/// A program that opens the table for writing removes the seal. Then only the content hash vouches
/// for the content.
///
/// # Errors
/// Returns an [`Error`] if the file cannot be read.
pub fn is_sealed(path: &Path) -> Result<bool, Error> {
    let (file, bytes) = opened(path)?;
    Ok(seal::check(&content(file, bytes, path)?) == Seal::Intact)
}

/// First bytes of every HDF5 file, behind its user block.
const SIGNATURE: [u8; 8] = *b"\x89HDF\r\n\x1a\n";

/// Reads at most `bytes` bytes of a file into memory; `name` is for messages.
///
/// # Errors
/// Returns an [`Error`] if the file cannot be read, or if there is no memory for it.
pub(crate) fn content(file: impl Read, bytes: u64, name: &Path) -> Result<Vec<u8>, Error> {
    let read = || {
        let mut content = Vec::new();
        content.try_reserve_exact(usize::try_from(bytes).unwrap_or(usize::MAX))?;
        file.take(bytes).read_to_end(&mut content)?;
        io::Result::Ok(content)
    };
    read().map_err(|error| unreadable(name, &error))
}

/// Makes a table from the bytes of a file; `name` is for messages.
///
/// # Errors
/// Returns an [`Error`] if the bytes are no table, are damaged, break a rule, or have another
/// content hash than they state.
pub(crate) fn table(content: Vec<u8>, name: &Path) -> Result<Table, Error> {
    guard(&content, name)?;
    confine::confine(content.len() as u64);
    let file = memory::open(content).map_err(|error| Error::hdf5(name, "file", &error))?;
    let (table, stored) = layout::load(&file, name)?;
    let computed = table.content_hash();
    if stored != computed {
        return Err(Error::file(
            name,
            format!("the content has hash {computed}, but attribute content_hash says {stored}"),
            "it was changed after the bake, copy it again or bake it again",
        ));
    }
    Ok(table)
}

/// Checks all that can be checked without the HDF5 library, which is not made for damaged files.
fn guard(content: &[u8], name: &Path) -> Result<(), Error> {
    let whole = content.len();
    let Some(content) = without_user_block(content) else {
        let fault = format!("is not an HDF5 file ({whole} bytes, without the HDF5 signature)");
        return Err(Error::file(name, fault, NAME_A_TABLE));
    };
    if let Seal::Broken { stored, computed } = seal::check(content) {
        let fault =
            format!("is damaged (its bytes have SHA-256 {computed}, its seal says {stored})");
        return Err(Error::file(name, fault, COPY_AGAIN));
    }
    match heap::first_broken(content) {
        Some(offset) => {
            let at = whole - content.len() + offset;
            let fault = format!("is damaged (the HDF5 global heap at byte {at} does not add up)");
            Err(Error::file(name, fault, COPY_AGAIN))
        }
        None => Ok(()),
    }
}

/// Returns the bytes from the HDF5 signature on; `None` without one.
///
/// A file may begin with a block of its user's own, of 512 bytes or twice as many any number of
/// times. The library passes over it.
fn without_user_block(content: &[u8]) -> Option<&[u8]> {
    let starts = std::iter::successors(Some(512_usize), |start| start.checked_mul(2));
    let mut starts = std::iter::once(0).chain(starts.take_while(|&start| start < content.len()));
    starts.find_map(|start| {
        let content = &content[start..];
        content.starts_with(&SIGNATURE).then_some(content)
    })
}
