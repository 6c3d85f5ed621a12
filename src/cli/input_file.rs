//! Reads text files of flags, each with a limit: a device or a pipe may never end.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use anyhow::{Context, ensure};

/// Longest text of settings, a plan or a problem, bytes.
pub const MAX_TEXT_BYTES: u64 = 16 << 20;

/// Reads a file of at most [`MAX_TEXT_BYTES`], without the byte order mark that some editors write. The message does not name
/// the file.
pub fn read_text(file: &Path) -> anyhow::Result<String> {
    let bytes = read_bytes(file, MAX_TEXT_BYTES).context("cannot be read as text")?;
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").map_or(&*bytes, |text| text);
    String::from_utf8(text.to_vec()).context("cannot be read as text: it is not UTF-8")
}

/// Reads a file of at most `limit` bytes. The message does not name the file.
pub fn read_bytes(file: &Path, limit: u64) -> anyhow::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(file)
        .and_then(|file| file.take(limit + 1).read_to_end(&mut bytes))
        .context("check the path")?;
    ensure!(
        bytes.len() as u64 <= limit,
        "holds more than {limit} bytes, which no file of this kind needs: check the path"
    );
    Ok(bytes)
}
