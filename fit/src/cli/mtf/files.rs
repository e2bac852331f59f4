//! Files that `fit mtf` measures: photographs that were named, and those of folders.

use std::path::{Path, PathBuf};

use crate::cli::failure::Failure;
use edges::photographs::photo::format::{Format, extension, is_raw};

/// Returns all photographs: those that were named, and in place of a folder its pictures in the
/// order of their names. Other files of a folder, and folders in it, are left out.
///
/// # Errors
/// Returns [`Failure::Folder`] if a folder cannot be read or holds no picture.
pub(crate) fn photographs(named: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut all = Vec::new();
    for path in named {
        if path.is_dir() {
            all.extend(pictures(path)?);
        } else {
            all.push(path.clone());
        }
    }
    Ok(all)
}

fn pictures(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let failure = |message: String| Failure::Folder {
        folder: folder.to_owned(),
        message,
    };
    let unreadable =
        |error: std::io::Error| failure(format!("the folder cannot be read ({error})"));
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if is_picture(&path) && path.is_file() {
            found.push(path);
        }
    }
    if found.is_empty() {
        let message = "the folder holds no picture (EXR, PNG, TIFF or JPEG)";
        return Err(failure(message.into()));
    }
    found.sort();
    Ok(found)
}

/// Returns whether the name is that of a picture. Hidden files are none.
fn is_picture(path: &Path) -> bool {
    let hidden = path
        .file_name()
        .is_some_and(|name| name.to_string_lossy().starts_with('.'));
    let extension = extension(path);
    let formats = [Format::Exr, Format::Png, Format::Tiff, Format::Jpeg];
    let read = |format: &Format| format.extensions().contains(&extension.as_str());
    let raw = cfg!(feature = "raw") && is_raw(&extension, &[]);
    !hidden && (formats.iter().any(read) || raw)
}
