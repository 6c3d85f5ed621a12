//! Files that are written as a whole or not at all.

use std::fs::{self, File};
use std::io::Write;
use std::path::Path;
use std::process;

use anyhow::Context;

/// Writes a file; its content is on the disk before its name. Other processes may read or write it at the same time.
pub fn write_whole(file: &Path, text: &str) -> anyhow::Result<()> {
    let mut part_name = file.to_owned().into_os_string();
    part_name.push(format!(".{}.part", process::id()));
    let written = File::create(&part_name).and_then(|mut part| {
        part.write_all(text.as_bytes())?;
        part.sync_all()?;
        fs::rename(&part_name, file)?;
        // The name as well, where folders can be opened and synced.
        match file.parent().map(File::open) {
            Some(Ok(folder)) => folder.sync_all(),
            _ => Ok(()),
        }
    });
    written.with_context(|| format!("{}: cannot be written", file.display()))
}
