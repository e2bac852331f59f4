//! What the page is made of.

use std::path::Path;

use crate::photographs::Campaign;
use crate::report::page::evidence::Evidence;
use crate::result::ResultFile;
use crate::simulate::Truth;

/// What is shown.
pub(crate) struct Page<'a> {
    /// The estimate.
    pub result: &'a ResultFile,
    /// The photographs and where they lie; those that are warned about are read again for their
    /// crops.
    pub campaign: &'a Campaign,
    /// The planted answer, where there is one.
    pub truth: Option<&'a Truth>,
    /// What the result does not hold.
    pub evidence: &'a Evidence,
    /// The command line.
    pub command: &'a str,
}

/// A file's name without its folder.
pub(crate) fn name(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}
