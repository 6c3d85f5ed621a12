//! Reads text files of flags, each with a limit: a device or a pipe may never end.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use anyhow::ensure;

use super::refusal::refused;

/// Longest text of settings, a plan or a problem, bytes.
pub const MAX_TEXT_BYTES: u64 = 16 << 20;

/// Reads a file of at most [`MAX_TEXT_BYTES`], without the byte order mark that some editors write. The message does not name
/// the file.
pub fn read_text(file: &Path) -> anyhow::Result<String> {
    let bytes = read_bytes(file, MAX_TEXT_BYTES, "check the path")?;
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").map_or(&*bytes, |text| text);
    String::from_utf8(text.to_vec())
        .map_err(|error| refused("cannot be read as text", error, "save it as UTF-8"))
}

/// Reads a file of at most `limit` bytes. The message does not name the file; it ends with the remedy.
pub fn read_bytes(file: &Path, limit: u64, remedy: &str) -> anyhow::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(file)
        .and_then(|file| file.take(limit + 1).read_to_end(&mut bytes))
        .map_err(|error| refused("cannot be read", error, remedy))?;
    ensure!(
        bytes.len() as u64 <= limit,
        "holds more than {limit} bytes, which no file of this kind needs: {remedy}"
    );
    Ok(bytes)
}
