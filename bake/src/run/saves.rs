//! Saves of a long bake, from which it can go on after an interruption.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tables::{Output, Table};

/// Default time between two saves, seconds.
pub(crate) const EVERY_SECONDS: &str = "10";

/// Smallest ratio of the time between two saves to the time that one save takes.
const SHARE: u32 = 20;

/// Start and saves of a bake.
pub(crate) struct Saves<'a> {
    /// Saved state of an interrupted bake, to go on from.
    pub start: Option<Table>,
    /// Least time between two saves.
    pub every: Duration,
    save: &'a mut dyn FnMut(&Table),
    last: Instant,
    cost: Duration,
}

impl<'a> Saves<'a> {
    /// Makes the saves of a bake that goes on from `start`.
    ///
    /// `save` is called with the table so far, at most once in the time `every`.
    pub(crate) fn new(
        start: Option<Table>,
        every: Duration,
        save: &'a mut dyn FnMut(&Table),
    ) -> Self {
        Saves {
            start,
            every,
            save,
            last: Instant::now(),
            cost: Duration::ZERO,
        }
    }

    /// Returns whether it is time for the next save.
    pub(crate) fn are_due(&self) -> bool {
        self.last.elapsed() >= self.every.max(self.cost * SHARE)
    }

    /// Saves the table, if this process has one.
    pub(crate) fn save(&mut self, table: impl FnOnce() -> Option<Table>) {
        let begun = Instant::now();
        if let Some(table) = table() {
            (self.save)(&table);
        }
        self.cost = begun.elapsed();
        self.last = Instant::now();
    }
}

/// File beside a table with the work done so far by its bake: a table of fewer rays.
pub(crate) struct SavedFile {
    path: PathBuf,
}

impl SavedFile {
    /// Returns the file of the bake that writes `table`.
    pub(crate) fn of(table: &Path) -> Self {
        let mut name = table.as_os_str().to_owned();
        name.push(".resume");
        SavedFile { path: name.into() }
    }

    /// Returns the path of the file.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Returns whether an interrupted bake left the file.
    ///
    /// # Errors
    /// Returns an error if something else has the name. A link is not followed: it would lead the
    /// save to another file.
    pub(crate) fn is_there(&self) -> Result<bool, tables::Error> {
        match std::fs::symlink_metadata(&self.path) {
            Ok(found) if !found.is_file() => {
                let fault = "is not a regular file and cannot be replaced";
                let remedy = "name another file, or move it away";
                Err(tables::Error::file(&self.path, fault, remedy))
            }
            found => Ok(found.is_ok()),
        }
    }

    /// Reads the file; returns `None` if there is none.
    ///
    /// # Errors
    /// Returns [`tables::Error`] if the file cannot be read.
    pub(crate) fn read(&self) -> Result<Option<Table>, tables::Error> {
        self.is_there()?
            .then(|| tables::read(&self.path))
            .transpose()
    }

    /// Replaces the file.
    ///
    /// # Errors
    /// Returns [`tables::Error`] if the file cannot be written; the older file then stays.
    pub(crate) fn write(&self, table: &Table) -> Result<(), tables::Error> {
        self.is_there()?;
        tables::commit(table, Output::reserve(&self.path)?)
    }

    /// Removes the file after the bake is done.
    pub(crate) fn remove(&self) {
        // A file that cannot be removed does no harm, because the next bake replaces it. Something
        // else that took the name meanwhile is not a save, and stays.
        if self.is_there().is_ok() {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}
