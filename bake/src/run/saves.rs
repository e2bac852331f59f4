//! A long bake is saved now and then, so that it can go on after an interruption.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tables::{Output, Table};

/// Seconds between two saves where the user says nothing.
pub(crate) const EVERY_SECONDS: &str = "10";

/// Saving costs at most one part in so many of the time of a bake.
const SHARE: u32 = 20;

/// Where a bake starts and how it is saved.
pub(crate) struct Saves<'a> {
    /// What an interrupted bake had done.
    pub start: Option<Table>,
    /// Time between two saves, at least.
    pub every: Duration,
    save: &'a mut dyn FnMut(&Table),
    last: Instant,
    cost: Duration,
}

impl<'a> Saves<'a> {
    /// A bake that goes on from `start`, and whose table so far is given to `save` every so often.
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

    /// Whether it is time.
    pub(crate) fn are_due(&self) -> bool {
        self.last.elapsed() >= self.every.max(self.cost * SHARE)
    }

    /// Saves the table, if there is one here.
    pub(crate) fn save(&mut self, table: impl FnOnce() -> Option<Table>) {
        let begun = Instant::now();
        if let Some(table) = table() {
            (self.save)(&table);
        }
        self.cost = begun.elapsed();
        self.last = Instant::now();
    }
}

/// The file beside a table that holds what its bake has done so far; itself a table, of fewer rays.
pub(crate) struct SavedFile {
    path: PathBuf,
}

impl SavedFile {
    /// Of the bake that writes `table`.
    pub(crate) fn of(table: &Path) -> Self {
        let mut name = table.as_os_str().to_owned();
        name.push(".resume");
        SavedFile { path: name.into() }
    }

    /// Where it is.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Whether an interrupted bake left one.
    pub(crate) fn is_there(&self) -> bool {
        self.path.is_file()
    }

    /// What it holds; nothing if it is not there.
    ///
    /// # Errors
    /// It cannot be read.
    pub(crate) fn read(&self) -> Result<Option<Table>, tables::Error> {
        self.is_there()
            .then(|| tables::read(&self.path))
            .transpose()
    }

    /// Replaces it.
    ///
    /// # Errors
    /// It cannot be written; what was saved before stays.
    pub(crate) fn write(&self, table: &Table) -> Result<(), tables::Error> {
        tables::commit(table, Output::reserve(&self.path)?)
    }

    /// Removes it: the bake is done.
    pub(crate) fn remove(&self) {
        // One that stays is no harm: the next bake replaces it.
        let _ = std::fs::remove_file(&self.path);
    }
}
