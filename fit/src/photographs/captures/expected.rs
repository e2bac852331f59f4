//! The table that a manifest asks for, by the hash of its content.

use crate::document::{FileLine, Section};
use crate::photographs::captures::error::Error;

/// Name of the key of `[setup]`.
pub(super) const KEY: &str = "expect_table";

/// Content hash that the table of a campaign must have.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ExpectedTable {
    /// The hash: 64 hex digits, lower-case.
    pub(crate) hash: String,
    /// Line of the manifest that states it.
    pub(crate) place: FileLine,
}

/// Reads the key from `[setup]`; returns `None` if it is not there.
///
/// # Errors
/// Returns [`Error::NotAHash`] if the text is no SHA-256 in hex.
pub(super) fn read(keys: &Section<'_>) -> Result<Option<ExpectedTable>, Error> {
    let Some(text) = keys.text(KEY)? else {
        return Ok(None);
    };
    let place = keys.place_of(KEY);
    if text.len() != 64 || !text.bytes().all(|byte| byte.is_ascii_hexdigit()) {
        return Err(Error::NotAHash {
            place,
            text: text.to_owned(),
        });
    }
    Ok(Some(ExpectedTable {
        hash: text.to_ascii_lowercase(),
        place,
    }))
}
