//! Outputs that appear whole or not at all. Their places are checked before the work, and they are
//! written after it.

use crate::error::Error;
use crate::file::{limits, partial};
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

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
    /// A symbolic link stays, and the file that it names is replaced. Partial files that killed
    /// runs of this machine left in the folder are removed.
    ///
    /// # Errors
    /// Returns an [`Error`] for the name `-`, for a link that leads nowhere, if the path names a
    /// folder, a pipe or a device, if the file there is write-protected, or if its folder is not
    /// there or takes no file.
    pub fn reserve(path: &Path) -> Result<Output, Error> {
        let refused = |error: io::Error| {
            let fault = format!("cannot be written: its folder takes no file ({error})");
            Error::file(path, fault, "choose another output, or allow writing")
        };
        let irregular = || {
            let remedy = "name another file, or move it away";
            Error::file(path, "is not a regular file and cannot be replaced", remedy)
        };
        if path == Path::new("-") {
            let remedy = "name a file, such as result.json, or ./- for a file of this name";
            return Err(Error::file(path, "is no name of a file here", remedy));
        }
        // A name that is too long is told here. The trial below has a short one.
        match fs::symlink_metadata(path) {
            Ok(found) if found.is_symlink() && !path.exists() => {
                let remedy = "remove it, or choose another output";
                return Err(Error::file(path, "is a link that leads nowhere", remedy));
            }
            Err(error) if error.kind() == io::ErrorKind::InvalidFilename => {
                return Err(refused(error));
            }
            _ => {}
        }
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        if let Ok(metadata) = fs::metadata(&target) {
            if !metadata.is_file() {
                return Err(irregular());
            }
            if metadata.permissions().readonly() {
                let remedy = "choose another output or allow writing";
                return Err(Error::file(path, "is write-protected", remedy));
            }
        }
        if target.file_name().is_none() {
            return Err(irregular());
        }
        let folder = folder_of(&target);
        if fs::metadata(folder).is_err_and(|error| error.kind() == io::ErrorKind::NotFound) {
            let fault = format!("there is no folder {}", folder.display());
            let remedy = "make it, or choose another output";
            return Err(Error::file(path, fault, remedy));
        }
        partial::sweep(folder);
        // Only a trial can show that a folder takes a file. The trial file is removed at once.
        temporary(&target).map_err(refused)?;
        Ok(Output { target })
    }

    /// Returns the path of the file to be written.
    pub fn path(&self) -> &Path {
        &self.target
    }

    /// Writes a temporary file beside the place, to the disk, and puts it there in one step. A
    /// second call replaces what the first one wrote.
    ///
    /// # Errors
    /// Returns an [`Error`] if writing or replacing fails; the old file is then unchanged.
    pub fn commit(&self, bytes: &[u8]) -> Result<(), Error> {
        let put = || {
            room_for(bytes.len() as u64)?;
            let mut file = temporary(&self.target)?;
            // Errors of the temporary file itself name it, and nobody knows this name.
            file.as_file_mut().write_all(bytes)?;
            file.as_file().sync_all()?;
            file.persist(&self.target)?;
            io::Result::Ok(())
        };
        put().map_err(|error| {
            Error::file(
                &self.target,
                format!("cannot be written ({error}), what was there before is unchanged"),
                "free some space or choose another output",
            )
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

    /// Reserves the output for a table, whose name has the extension .h5 or .hdf5, or none.
    ///
    /// # Errors
    /// Returns an [`Error`] for another extension, and the errors of [`Outputs::reserve`].
    pub fn reserve_table(&mut self, path: &Path) -> Result<Output, Error> {
        let output = self.reserve(path)?;
        let extension = path.extension().map(|end| end.to_ascii_lowercase());
        if extension.is_some_and(|end| end != "h5" && end != "hdf5") {
            let fault = "is no name of a table";
            return Err(Error::file(path, fault, "let it end in .h5 or .hdf5"));
        }
        Ok(output)
    }

    /// Reserves one of the outputs.
    ///
    /// # Errors
    /// Returns an [`Error`] if the command reads the file, or if another output has the place, and
    /// the errors of [`Output::reserve`].
    pub fn reserve(&mut self, path: &Path) -> Result<Output, Error> {
        if let Some(place) = place(path) {
            if self.inputs.contains(&place) {
                let fault = "is an input of this command and would be overwritten";
                return Err(Error::file(path, fault, "write to another file"));
            }
            if self.reserved.contains(&place) {
                let fault = "is named for two outputs of this command";
                return Err(Error::file(path, fault, "give each a file of its own"));
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
    let prefix = partial::prefix();
    builder.prefix(&prefix).suffix(partial::SUFFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
        let file = builder.tempfile_in(folder_of(target)).map_err(unnamed)?;
        // The umask has no say in the rights of a file that was there before.
        if let Ok(metadata) = fs::metadata(target) {
            let mode = metadata.permissions().mode() & 0o777;
            file.as_file()
                .set_permissions(fs::Permissions::from_mode(mode))?;
        }
        Ok(file)
    }
    #[cfg(not(unix))]
    builder.tempfile_in(folder_of(target)).map_err(unnamed)
}

/// Returns an error of a temporary file or folder without the name of it, which tells a user
/// nothing.
pub(crate) fn unnamed(error: io::Error) -> io::Error {
    error.kind().into()
}

/// Checks the limit of the shell on the length of files, beyond which the system would end this
/// program.
fn room_for(bytes: u64) -> io::Result<()> {
    match limits::longest_file() {
        Some(most) if bytes > most => Err(io::Error::new(
            io::ErrorKind::FileTooLarge,
            format!("it has {bytes} bytes, and `ulimit -f` allows {most}"),
        )),
        _ => Ok(()),
    }
}

/// Returns the folder of a path.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}
