//! Files that a flag names, opened before the work is done that fills them.

use std::fs::File;
use std::io::Write;
use std::path::Path;

use anyhow::{Context, bail};

/// A file of a flag, emptied, to be written later.
pub struct Output<'a> {
    flag: &'static str,
    name: &'a Path,
    file: File,
    ending: &'static str,
}

impl<'a> Output<'a> {
    /// The file of a flag, none where the flag is not given. Its name must have one of these endings.
    pub fn create(
        flag: &'static str,
        name: Option<&'a Path>,
        endings: &[&'static str],
    ) -> anyhow::Result<Option<Self>> {
        let Some(name) = name else {
            return Ok(None);
        };
        let given = name.extension().and_then(|ending| ending.to_str());
        let Some(&ending) = endings.iter().find(|ending| given == Some(**ending)) else {
            let endings = endings.join(" or .");
            bail!("{flag} {}: the name must end in .{endings}", name.display());
        };
        let file = File::create(name).with_context(|| {
            let name = name.display();
            format!("{flag} {name}: cannot be written: name a file in a folder that exists")
        })?;
        Ok(Some(Self {
            flag,
            name,
            file,
            ending,
        }))
    }

    /// The ending of its name.
    pub const fn ending(&self) -> &'static str {
        self.ending
    }

    /// Writes it.
    pub fn write(mut self, content: impl AsRef<[u8]>) -> anyhow::Result<()> {
        self.file
            .write_all(content.as_ref())
            .with_context(|| format!("{} {}", self.flag, self.name.display()))
    }
}
