//! Files that are written as a whole or not at all.

use std::fs::{self, File, Permissions};
use std::io::{self, Write};
use std::path::Path;
use std::process;

use anyhow::Context;

/// Writes a file; its content is on the disk before its name. Other processes may read or write it at the same time.
pub fn write_whole(file: &Path, text: &str) -> anyhow::Result<()> {
    let written = replace(file, text.as_bytes(), None);
    written.with_context(|| format!("{}: cannot be written", file.display()))
}

/// The folder of a file.
pub fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|parent| *parent != Path::new("")).unwrap_or(Path::new("."))
}

/// Replaces a file, or creates it, with these permissions. On an error the file stays as it was.
pub fn replace(file: &Path, content: &[u8], permissions: Option<Permissions>) -> io::Result<()> {
    let mut part_name = file.to_owned().into_os_string();
    part_name.push(format!(".{}.part", process::id()));
    let written = File::create(&part_name).and_then(|mut part| {
        part.write_all(content)?;
        if let Some(permissions) = permissions {
            part.set_permissions(permissions)?;
        }
        part.sync_all()?;
        fs::rename(&part_name, file)
    });
    if written.is_err() {
        // Nothing else can be done about a part that cannot be removed.
        let _ = fs::remove_file(&part_name);
        return written;
    }
    // The name as well, where folders can be opened and synced: the file has its new content by now.
    let _ = File::open(folder_of(file)).and_then(|folder| folder.sync_all());
    Ok(())
}
