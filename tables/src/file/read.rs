//! Reading of a table from its file, checked to the last bit before it is used.

use crate::error::{BAKE_LESS, COPY_AGAIN, Error, NAME_A_TABLE};
use crate::file::seal::Seal;
use crate::file::{apart, heap, layout, library, limits, seal};
use crate::table::table::Table;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Reads a table and checks everything in it.
///
/// It checks signature, seal, format, version, types, shapes, sizes before allocation, finite
/// values, the rules of `crate::table::check`, counts against what is derived from them, and the
/// content hash. Links that leave the file, unknown filters and inflated chunks are refused. If
/// there are counts, all other numbers are computed from them, so that two readers hold the same
/// bits.
///
/// In a program that calls [`crate::file::apart::start`] first, the HDF5 library opens the file in
/// another program, and a crash of the library becomes an error here.
///
/// # Errors
/// Returns an [`Error`] if a check fails. It names the file, the dataset or attribute, and the
/// remedy.
///
/// ```
/// let error = tables::read(std::path::Path::new("Cargo.toml")).unwrap_err();
/// assert!(error.to_string().contains("is not an HDF5 file"));
/// ```
pub fn read(path: &Path) -> Result<Table, Error> {
    Ok(apart::read(path)?.table)
}

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

/// Longest file that is read, bytes: the largest table within the memory limit, incompressible.
pub(crate) const MOST_BYTES: u64 = (1 << 31) + (1 << 24);

/// First bytes of every HDF5 file, behind its user block.
const SIGNATURE: [u8; 8] = *b"\x89HDF\r\n\x1a\n";

/// Reads a table in this very process, without the program that reads for others.
///
/// # Errors
/// Returns the errors of [`opened`] and of [`table`].
pub(crate) fn in_this_process(path: &Path) -> Result<Table, Error> {
    let (file, bytes) = opened(path)?;
    table(content(file, bytes, path)?, path)
}

/// Reads a table from bytes in memory; `name` is for messages.
///
/// The HDF5 library reads them in this very process, so they must be no stranger's. They are
/// checked as [`crate::read()`] checks a file.
///
/// # Errors
/// Returns an [`Error`] if a check fails.
pub fn read_in_memory(bytes: &[u8], name: &Path) -> Result<Table, Error> {
    table(bytes.to_vec(), name)
}

/// Opens a file and returns it with its length in bytes.
///
/// Nothing else is opened: a pipe would wait for its writer, a device may do so.
///
/// # Errors
/// Returns an [`Error`] if the file cannot be opened, is no regular file, or is longer than any
/// table.
pub(crate) fn opened(path: &Path) -> Result<(File, u64), Error> {
    let failed = |error| unreadable(path, &error);
    let not_a_file = || {
        let remedy = "name a table such as table.h5";
        Error::file(path, "is not a regular file", remedy)
    };
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        return Err(not_a_file());
    }
    let file = File::open(path).map_err(failed)?;
    // The name may lead elsewhere by now.
    let metadata = file.metadata().map_err(failed)?;
    if !metadata.is_file() {
        return Err(not_a_file());
    }
    let bytes = metadata.len();
    if bytes > MOST_BYTES {
        let fault = format!("is {bytes} bytes, above the limit of {MOST_BYTES}");
        return Err(Error::file(path, fault, BAKE_LESS));
    }
    Ok((file, bytes))
}

/// Makes the error of a file that the system does not let this program read.
fn unreadable(path: &Path, error: &io::Error) -> Error {
    let fault = format!("cannot be read ({error})");
    Error::file(path, fault, "check the name and the permissions")
}

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
    limits::confine(content.len() as u64);
    let file = library::open(content).map_err(|error| Error::hdf5(name, "file", &error))?;
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
