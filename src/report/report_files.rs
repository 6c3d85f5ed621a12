//! Files of a report's folder: pages, and the rows behind their charts.

use serde::Serialize;

/// A file of a report's folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReportFile {
    /// Its name, without a folder.
    pub name: String,
    /// What it holds.
    pub text: String,
}

impl ReportFile {
    pub(super) fn new(name: impl Into<String>, text: String) -> Self {
        let name = name.into();
        Self { name, text }
    }
}

/// Rows as JSON for people and programs.
pub(super) fn json_text<T: Serialize + ?Sized>(rows: &T) -> String {
    // Rows are made of numbers and texts, which JSON has no trouble with.
    serde_json::to_string_pretty(rows).unwrap_or_default() + "\n"
}
