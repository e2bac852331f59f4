//! Files that appear whole or not at all: reserved before the work, renamed into place after it.

use std::io::Write;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// Why an output cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot be written ({source}); check the folder, its permissions and the space left", path.display())]
pub struct Error {
    /// The file.
    pub path: PathBuf,
    /// What the system said.
    pub source: std::io::Error,
}

/// A file to come. Dropped without a commit, it leaves what was there.
#[derive(Debug)]
pub struct Output {
    path: PathBuf,
    file: NamedTempFile,
}

impl Output {
    /// Opens a temporary file beside `path`, so that a folder that cannot be written fails before the work is done.
    ///
    /// # Errors
    /// The folder does not exist or cannot be written, or `path` is a folder.
    pub fn reserve(path: &Path) -> Result<Output, Error> {
        let error = |source| Error {
            path: path.to_owned(),
            source,
        };
        if path.is_dir() {
            return Err(error(std::io::ErrorKind::IsADirectory.into()));
        }
        let folder = path
            .parent()
            .filter(|f| !f.as_os_str().is_empty())
            .unwrap_or(Path::new("."));
        let mut builder = tempfile::Builder::new();
        builder.prefix(".airr-").suffix(".part");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // As any file the user makes; the umask takes its part.
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let file = builder.tempfile_in(folder).map_err(error)?;
        Ok(Output {
            path: path.to_owned(),
            file,
        })
    }

    /// Writes the contents and puts the file in place.
    ///
    /// # Errors
    /// The disk is full, or the rename fails; what was there before stays.
    pub fn commit(mut self, contents: &[u8]) -> Result<(), Error> {
        let path = self.path;
        let error = |source| Error {
            path: path.clone(),
            source,
        };
        self.file
            .write_all(contents)
            .and_then(|()| self.file.as_file().sync_all())
            .map_err(error)?;
        self.file.persist(&path).map_err(|e| error(e.error))?;
        Ok(())
    }
}
