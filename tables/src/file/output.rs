//! Outputs that appear whole or not at all: their places are checked before the work, and they are
//! written after it.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::error::output::OutputError;

/// Output file whose place is reserved.
///
/// Nothing of it is on the disk until [`Output::commit`], so an interruption leaves nothing behind.
#[derive(Debug)]
#[must_use]
pub struct Output {
    target: PathBuf,
}

impl Output {
    /// Checks that a file can be written at `path`, and reserves the place.
    ///
    /// A symbolic link stays, and the file that it names is replaced.
    ///
    /// # Errors
    /// Returns [`OutputError::NotAFile`] if the path names a folder, a pipe or a device,
    /// [`OutputError::Protected`] if the file there is write-protected, and [`OutputError::Folder`]
    /// if its folder takes no file.
    pub fn reserve(path: &Path) -> Result<Output, OutputError> {
        let file = || path.to_owned();
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        if let Ok(metadata) = fs::metadata(&target) {
            if !metadata.is_file() {
                return Err(OutputError::NotAFile { file: file() });
            }
            if metadata.permissions().readonly() {
                return Err(OutputError::Protected { file: file() });
            }
        }
        if target.file_name().is_none() {
            return Err(OutputError::NotAFile { file: file() });
        }
        // Only a trial can show that a folder takes a file. The trial file is removed at once.
        match temporary(&target) {
            Ok(_) => Ok(Output { target }),
            Err(source) => Err(OutputError::Folder {
                file: file(),
                source,
            }),
        }
    }

    /// Returns the path of the file to be written.
    pub fn path(&self) -> &Path {
        &self.target
    }

    /// Writes a temporary file beside the place, to the disk, and puts it there in one step.
    ///
    /// # Errors
    /// Returns [`OutputError::Write`] if writing or replacing fails; the old file is then
    /// unchanged.
    pub fn commit(self, bytes: &[u8]) -> Result<(), OutputError> {
        let put = || {
            let mut file = temporary(&self.target)?;
            file.write_all(bytes)?;
            file.as_file().sync_all()?;
            file.persist(&self.target)?;
            io::Result::Ok(())
        };
        put().map_err(|source| OutputError::Write {
            file: self.target.clone(),
            source,
        })?;
        // The rename itself must survive a power cut. A folder that cannot be opened is no reason
        // to fail now.
        if let Ok(folder) = File::open(folder_of(&self.target)) {
            let _ = folder.sync_all();
        }
        Ok(())
    }
}

/// Outputs of one command: none is one of its inputs, and no two are the same file.
#[derive(Debug)]
pub struct Outputs {
    inputs: Vec<PathBuf>,
    reserved: Vec<PathBuf>,
}

impl Outputs {
    /// Starts the list of outputs of a command that reads `inputs`.
    pub fn beside<'a>(inputs: impl IntoIterator<Item = &'a Path>) -> Outputs {
        Outputs {
            inputs: inputs.into_iter().filter_map(place).collect(),
            reserved: Vec::new(),
        }
    }

    /// Reserves one of the outputs.
    ///
    /// # Errors
    /// Returns [`OutputError::Input`] if the command reads the file, [`OutputError::Twice`] if
    /// another output has the place, and the errors of [`Output::reserve`].
    pub fn reserve(&mut self, path: &Path) -> Result<Output, OutputError> {
        let file = path.to_owned();
        if let Some(place) = place(path) {
            if self.inputs.contains(&place) {
                return Err(OutputError::Input { file });
            }
            if self.reserved.contains(&place) {
                return Err(OutputError::Twice { file });
            }
            self.reserved.push(place);
        }
        Output::reserve(path)
    }
}

/// Returns the one absolute name of a file that exists or could exist.
fn place(path: &Path) -> Option<PathBuf> {
    fs::canonicalize(path).ok().or_else(|| {
        let folder = fs::canonicalize(folder_of(path)).ok()?;
        Some(folder.join(path.file_name()?))
    })
}

/// Makes an empty file beside `target`.
///
/// It has the permissions of the file that it replaces, or of any new file (the umask applies).
fn temporary(target: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".airr-").suffix(".partial");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode =
            fs::metadata(target).map_or(0o666, |metadata| metadata.permissions().mode() & 0o777);
        builder.permissions(fs::Permissions::from_mode(mode));
    }
    builder.tempfile_in(folder_of(target))
}

/// Returns the folder of a path.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}
