//! Content of the page.

use std::path::Path;

use tables::Table;

use crate::report::page::evidence::Evidence;
use edges::photographs::Campaign;
use estimator::result::ResultFile;
use estimator::result::Truth;

/// Content of the page.
pub struct Page<'a> {
    /// The estimate.
    pub result: &'a ResultFile,
    /// Table of the fitted cell.
    pub table: &'a Table,
    /// The photographs and their files.
    ///
    /// Those with a warning are read again for their crops.
    pub campaign: &'a Campaign,
    /// Known values of the parameters, if there are any (`--truth`).
    pub truth: Option<&'a Truth>,
    /// Profiles and quality of the fit, which the result does not hold.
    pub evidence: &'a Evidence,
    /// Command line.
    pub command: &'a str,
}

/// Returns the name of a file without its folder.
pub(crate) fn name(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}
