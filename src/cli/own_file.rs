//! Which existing files an output may replace: only those that this program wrote.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use anyhow::{Context, bail, ensure};

/// The name of this program in its files.
const NAME: &[u8] = b"inbye";

/// Bytes of a file's start, or end, that are looked at.
const HEAD_BYTES: u64 = 4096;

/// Start of a Parquet file, which names its writer at its end.
const PARQUET: &[u8] = b"PAR1";

/// Starts of the files that this program writes and that do not name it.
const STARTS: [&[u8]; 4] = [
    // A report page.
    b"<!DOCTYPE html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none';",
    b"<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" aria-label=",
    // A tick of a drive.
    b"{\"time_s\":",
    b"{\n  \"cells\":",
];

/// Creates the file of a flag, or empties one that this program wrote. `columns` are those of its rows, if it has rows.
///
/// # Errors
/// The file cannot be written, or it exists and has other content.
pub fn create(flag: &str, name: &Path, columns: &[&str]) -> anyhow::Result<File> {
    let place = || format!("{flag} {}", name.display());
    let opened = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(name);
    let mut file = opened.with_context(|| {
        format!("{}: cannot be written: name a file in a folder that exists", place())
    })?;
    let metadata = file.metadata().with_context(place)?;
    if metadata.is_file() && metadata.len() > 0 {
        let is_own = is_own(&mut file, columns).with_context(place)?;
        ensure!(
            is_own,
            "{}: the file exists and was not written by this command: choose another name, or remove it",
            place()
        );
        let emptied = file.rewind().and_then(|()| file.set_len(0));
        emptied.with_context(place)?;
    } else if metadata.is_dir() {
        bail!("{}: is a folder: name a file", place());
    }
    Ok(file)
}

fn is_own(file: &mut File, columns: &[&str]) -> io::Result<bool> {
    let mut head = Vec::new();
    file.by_ref().take(HEAD_BYTES).read_to_end(&mut head)?;
    let is_own = is_own_head(&head, columns);
    if is_own || !head.starts_with(PARQUET) {
        return Ok(is_own);
    }
    let end = file.seek(SeekFrom::End(0))?;
    file.seek(SeekFrom::Start(end.saturating_sub(HEAD_BYTES)))?;
    let mut tail = Vec::new();
    file.by_ref().take(HEAD_BYTES).read_to_end(&mut tail)?;
    Ok(contains(&tail, NAME))
}

/// Whether a file of this program begins so.
fn is_own_head(head: &[u8], columns: &[&str]) -> bool {
    if STARTS.iter().any(|start| head.starts_with(start)) || contains(head, NAME) {
        return true;
    }
    // Rows of this or an earlier version: the first columns stay the same.
    columns.first().is_some_and(|first| {
        let rows = format!("[\n  {{\n    \"{first}\":");
        let starts = [format!("{first},"), format!("{{\n  \"{first}\":"), rows];
        starts.iter().any(|start| head.starts_with(start.as_bytes())) || head == b"[]\n"
    })
}

fn contains(bytes: &[u8], part: &[u8]) -> bool {
    bytes.windows(part.len()).any(|window| window == part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_of_this_program_are_own() {
        let columns = ["key", "world"];
        for own in
            ["key,world,seed\n", "[\n  {\n    \"key\": \"a\"", "{\"time_s\":0.0}", "# by inbye"]
        {
            assert!(is_own_head(own.as_bytes(), &columns), "{own}");
        }
        for other in ["name,key\n", "image: map.pgm\n", "{}", "P5\n", "keyboard,x"] {
            assert!(!is_own_head(other.as_bytes(), &columns), "{other}");
        }
    }
}
