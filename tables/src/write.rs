//! A table to its file, whole or not at all.
//!
//! The HDF5 image is made in memory, so that the library never meets a full disk; it goes to a temporary file
//! in the same folder, to the disk, and then takes the place of the old table in one step.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::error::Error;
use crate::table::Table;
use crate::{check, layout, scales, seal};

/// A place for a table, held before the long run that makes it.
///
/// Dropping it removes the temporary file and leaves the old table as it was.
#[derive(Debug)]
pub struct Reservation {
    target: PathBuf,
    temporary: NamedTempFile,
}

/// Makes sure that a table can be written there, before it is made.
///
/// # Errors
/// [`Error::NotAFile`] where the path names a folder, [`Error::Protected`] where the file there is read-only,
/// [`Error::Folder`] where no file can be created beside it.
pub fn reserve(path: &Path) -> Result<Reservation, Error> {
    // A symbolic link stays and the file that it names is replaced.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    if let Ok(metadata) = fs::metadata(&target) {
        if !metadata.is_file() {
            return Err(Error::NotAFile {
                file: path.to_owned(),
            });
        }
        if metadata.permissions().readonly() {
            return Err(Error::Protected {
                file: path.to_owned(),
            });
        }
    }
    if target.file_name().is_none() {
        return Err(Error::NotAFile {
            file: path.to_owned(),
        });
    }
    let folder = folder_of(&target);
    let mut builder = tempfile::Builder::new();
    builder.prefix(".table-").suffix(".partial");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // The permissions of any new file (the umask applies), not the private ones of a temporary file.
        let mode =
            fs::metadata(&target).map_or(0o666, |metadata| metadata.permissions().mode() & 0o777);
        builder.permissions(fs::Permissions::from_mode(mode));
    }
    let temporary = builder
        .tempfile_in(folder)
        .map_err(|source| Error::Folder {
            folder: folder.to_owned(),
            source,
        })?;
    Ok(Reservation { target, temporary })
}

impl Reservation {
    /// Where the table will be.
    pub fn path(&self) -> &Path {
        &self.target
    }

    /// Writes the table and puts it in place; the same table always gives the same bytes.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the table breaks a rule, [`Error::Write`] where the disk is full or the file
    /// cannot be replaced. What was there before is unchanged then.
    pub fn commit(mut self, table: &Table) -> Result<(), Error> {
        let bytes = image(table, &self.target)?;
        let failed = |source| Error::Write {
            file: self.target.clone(),
            source,
        };
        self.temporary.write_all(&bytes).map_err(failed)?;
        self.temporary.as_file().sync_all().map_err(failed)?;
        self.temporary
            .persist(&self.target)
            .map_err(|error| failed(error.error))?;
        // The rename itself must survive a power cut; a folder that cannot be opened is no reason to fail now.
        if let Ok(folder) = File::open(folder_of(&self.target)) {
            let _ = folder.sync_all();
        }
        Ok(())
    }
}

/// Writes a table: [`reserve`], then [`Reservation::commit`].
///
/// # Errors
/// As those two. An error leaves what was there before unchanged.
pub fn write(table: &Table, path: &Path) -> Result<(), Error> {
    reserve(path)?.commit(table)
}

/// The bytes of a table's file; `name` is for messages.
pub(crate) fn image(table: &Table, name: &Path) -> Result<Vec<u8>, Error> {
    check::check(table).map_err(|source| Error::Invalid {
        file: name.to_owned(),
        source,
    })?;
    let place = |place: &str| {
        let place = place.to_owned();
        move |source| Error::Hdf5 {
            file: name.to_owned(),
            place,
            source,
        }
    };
    let file = layout::create().map_err(place("file"))?;
    layout::store(table, &file).map_err(place("table"))?;
    file.flush().map_err(place("file"))?;
    let mut bytes = scales::image(&file).map_err(place("file"))?;
    seal::append(&mut bytes);
    Ok(bytes)
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}
