//! Outputs that appear whole or not at all: their places are checked before the work, and they are
//! written after it.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::error::output::OutputError;
use crate::file::{limits, partial};

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
    /// Returns [`OutputError::Dash`] for the name `-`, [`OutputError::DeadLink`] for a link that
    /// leads nowhere, [`OutputError::NotAFile`] if the path names a folder, a pipe or a device,
    /// [`OutputError::Protected`] if the file there is write-protected, and [`OutputError::Folder`]
    /// if its folder takes no file.
    pub fn reserve(path: &Path) -> Result<Output, OutputError> {
        let file = || path.to_owned();
        if path == Path::new("-") {
            return Err(OutputError::Dash);
        }
        // A name that is too long is told here. The trial below has a short one.
        match fs::symlink_metadata(path) {
            Ok(found) if found.is_symlink() && !path.exists() => {
                return Err(OutputError::DeadLink { file: file() });
            }
            Err(source) if source.kind() == io::ErrorKind::InvalidFilename => {
                return Err(OutputError::Folder {
                    file: file(),
                    source,
                });
            }
            _ => {}
        }
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
        partial::sweep(folder_of(&target));
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
            room_for(bytes.len() as u64)?;
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

    /// Reserves the output for a table, whose name must not promise another kind of file.
    ///
    /// # Errors
    /// Returns [`OutputError::NotATable`] if the name ends as that of a mesh, a picture, a text or
    /// a page, and the errors of [`Outputs::reserve`].
    pub fn reserve_table(&mut self, path: &Path) -> Result<Output, OutputError> {
        const OTHERS: [&str; 20] = [
            "obj", "gltf", "glb", "stl", "ply", "bin", "png", "svg", "exr", "tif", "tiff", "jpg",
            "jpeg", "json", "csv", "toml", "html", "txt", "md", "pdf",
        ];
        let output = self.reserve(path)?;
        let extension = path.extension().map(|end| end.to_ascii_lowercase());
        if extension.is_some_and(|end| OTHERS.iter().any(|other| end == *other)) {
            let file = path.to_owned();
            return Err(OutputError::NotATable { file });
        }
        Ok(output)
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
    let prefix = partial::prefix();
    builder.prefix(&prefix).suffix(partial::SUFFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
        let file = builder.tempfile_in(folder_of(target))?;
        // The umask has no say in the rights of a file that was there before.
        if let Ok(metadata) = fs::metadata(target) {
            let mode = metadata.permissions().mode() & 0o777;
            file.as_file()
                .set_permissions(fs::Permissions::from_mode(mode))?;
        }
        Ok(file)
    }
    #[cfg(not(unix))]
    builder.tempfile_in(folder_of(target))
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
