//! The table that a user asks for by its content hash, and the refusal of any other.

use std::path::Path;

use tables::Table;

use crate::cli::failure::Failure;
use edges::photographs::Campaign;
use edges::photographs::manifest::captures::{self, Manifest};

/// Hash that a table must have, if the user named one, and the option or key that names it.
#[derive(Debug)]
pub(crate) struct Expected(Option<(String, String)>);

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
pub(in crate::cli) fn of(
    manifest: Manifest,
    option: Option<&str>,
) -> Result<(Campaign, Expected), Failure> {
    let expected = match (option, manifest.expected_table) {
        (Some(option), Some(key)) if !option.eq_ignore_ascii_case(&key.hash) => {
            return Err(Failure::TwoTables {
                place: key.place,
                key: key.hash,
                option: option.to_owned(),
            });
        }
        (_, Some(key)) => Some((key.hash, format!("`expect_table` in {}", key.place))),
        (option, None) => option.map(|hash| (hash.to_ascii_lowercase(), "--expect-table".into())),
    };
    Ok((manifest.campaign, Expected(expected)))
}

impl Expected {
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
    pub(in crate::cli) fn check(&self, table: &Table, path: &Path) -> Result<(), Failure> {
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
