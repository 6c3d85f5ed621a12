//! Output files of flags, created before the work starts, so that a wrong name fails early.

use std::fs::File;
use std::io::Write;
use std::path::Path;

use anyhow::{Context, bail};
use inbye::bench::{Columns, csv_text};

/// An output file of a flag.
pub struct Output<'a> {
    flag: &'static str,
    name: &'a Path,
    file: File,
    extension: &'static str,
}

impl<'a> Output<'a> {
    /// Creates the file of a flag; returns none without the flag. The name must have one of these extensions.
    pub fn create(
        flag: &'static str,
        name: Option<&'a Path>,
        extensions: &[&'static str],
    ) -> anyhow::Result<Option<Self>> {
        let Some(name) = name else {
            return Ok(None);
        };
        let given = name.extension().and_then(|extension| extension.to_str());
        let known = extensions.iter().find(|extension| given == Some(**extension));
        let Some(&extension) = known else {
            let extensions = extensions.join(" or .");
            bail!("{flag} {}: the name must end in .{extensions}", name.display());
        };
        let file = File::create(name).with_context(|| {
            let name = name.display();
            format!("{flag} {name}: cannot be written: name a file in a folder that exists")
        })?;
        Ok(Some(Self { flag, name, file, extension }))
    }

    /// The extension of its name.
    pub const fn extension(&self) -> &'static str {
        self.extension
    }

    /// Writes the content.
    pub fn write(mut self, content: impl AsRef<[u8]>) -> anyhow::Result<()> {
        self.file
            .write_all(content.as_ref())
            .with_context(|| format!("{} {}", self.flag, self.name.display()))
    }
}

/// Writes rows to a file, as JSON or CSV by the file's ending.
pub fn write_rows<R: Columns>(file: Output, rows: &[R]) -> anyhow::Result<()> {
    let text = if file.extension() == "json" {
        serde_json::to_string_pretty(rows)? + "\n"
    } else {
        csv_text(rows)
    };
    file.write(text)
}
