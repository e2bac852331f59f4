//! The table that a user asks for by its content hash, and the refusal of any other.

use std::path::Path;

use tables::Table;

use crate::cli::failure::{Asked, Failure};
use crate::photographs::Campaign;
use crate::photographs::captures::ExpectedTable;
use crate::photographs::captures::{self, Manifest};

/// Hash that a table must have, if the user named one.
#[derive(Debug)]
pub(crate) struct Expected(Option<(String, Asked)>);

/// Reads a manifest, and returns its campaign and the table that it and the option
/// `--expect-table` ask for.
///
/// # Errors
/// Returns [`Failure::Captures`] if the manifest cannot be used, and [`Failure::TwoTables`] if it
/// and the option name different hashes.
pub(crate) fn campaign(file: &Path, option: Option<&str>) -> Result<(Campaign, Expected), Failure> {
    of(captures::read(file)?, option)
}

/// Returns the campaign of a manifest, and the table that it and the option ask for.
///
/// # Errors
/// Returns [`Failure::TwoTables`] if they name different hashes.
pub(super) fn of(
    manifest: Manifest,
    option: Option<&str>,
) -> Result<(Campaign, Expected), Failure> {
    let expected = Expected::new(option, manifest.expected_table)?;
    Ok((manifest.campaign, expected))
}

impl Expected {
    /// Returns what the option `--expect-table` and the key of the manifest ask for together.
    ///
    /// # Errors
    /// Returns [`Failure::TwoTables`] if they name different hashes.
    fn new(option: Option<&str>, key: Option<ExpectedTable>) -> Result<Self, Failure> {
        let Some(key) = key else {
            let hash = option.map(|hash| (hash.to_ascii_lowercase(), Asked::Option));
            return Ok(Expected(hash));
        };
        match option {
            Some(option) if !option.eq_ignore_ascii_case(&key.hash) => Err(Failure::TwoTables {
                place: key.place,
                key: key.hash,
                option: option.to_owned(),
            }),
            _ => Ok(Expected(Some((key.hash, Asked::Key(key.place))))),
        }
    }

    /// Reads a table and refuses one of another hash.
    ///
    /// # Errors
    /// Returns [`Failure::Table`] if the table cannot be read, and [`Failure::OtherTable`] if it
    /// has another content hash.
    pub(crate) fn read(&self, path: &Path) -> Result<Table, Failure> {
        let table = tables::read(path)?;
        self.check(&table, path)?;
        Ok(table)
    }

    /// Refuses a table of another hash; `path` is its name for messages.
    ///
    /// # Errors
    /// Returns [`Failure::OtherTable`] if the table has another content hash.
    pub(super) fn check(&self, table: &Table, path: &Path) -> Result<(), Failure> {
        let Some((hash, asked)) = &self.0 else {
            return Ok(());
        };
        let found = table.content_hash();
        if *hash == found {
            return Ok(());
        }
        Err(Failure::OtherTable {
            table: path.to_owned(),
            found,
            asked: asked.clone(),
        })
    }
}
