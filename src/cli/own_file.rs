//! Which existing files an output may replace: only those that this program wrote, and none that another flag of this command
//! writes.

use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use anyhow::{Context, bail, ensure};

use super::refusal::refused;
use super::whole_file::{folder_of, replace};

/// Bytes of a file's start, or end, that are looked at.
const HEAD_BYTES: u64 = 4096;

/// Start of a Parquet file, which names its writer at its end.
const PARQUET: &[u8] = b"PAR1";

/// The writer in a Parquet file, and in the header of a recording.
const NAME: &[u8] = b"inbye";

/// Kinds of files that this program writes: how they begin, and what their first bytes contain.
const KINDS: [(&[u8], &[u8]); 12] = [
    // A report page.
    (
        b"<!DOCTYPE html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none';",
        b"<meta name=\"generator\" content=\"inbye\">",
    ),
    (b"<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" aria-label=", b""),
    // A tick of a drive.
    (b"{\"time_s\":", b",\"local_target\":"),
    (b"{\n  \"cells\":", b""),
    // A recording.
    (b"\x89MCAP0\r\n", NAME),
    // A picture.
    (b"\x89PNG\r\n\x1a\n", b"Software\0inbye"),
    // An animation, by its comment block.
    (b"GIF89a", b"!\xFE\x05inbye\0"),
    // A map and its image.
    (b"# Map written by inbye.\n", b""),
    (b"P5\n# inbye\n", b""),
    // Imported settings.
    (b"# Imported from ", b"`inbye config import-nav2`"),
    // Tuned settings.
    (TUNED_SETTINGS.as_bytes(), b""),
    // A manual page.
    (b".ie \\n(.g ", b"\n.TH inbye"),
];

/// Start of a file of tuned settings.
pub const TUNED_SETTINGS: &str = "# Found by `inbye tune`";

/// Leading columns by which rows are recognised. They stay the same from version to version.
pub const LEADING_COLUMNS: usize = 3;

/// The files of this command, each with its flag.
static OUTPUTS: Mutex<Vec<(String, PathBuf)>> = Mutex::new(Vec::new());

/// Reserves a file for a flag, before it is created.
///
/// # Errors
/// Another flag writes the same file.
pub fn reserve(flag: &str, name: &Path) -> anyhow::Result<()> {
    let file = identity(name);
    let mut outputs = OUTPUTS.lock().unwrap_or_else(PoisonError::into_inner);
    match outputs.iter().find(|(_, known)| *known == file) {
        Some((other, _)) if other != flag => {
            bail!("{flag} {}: {other} writes this file: choose another name", name.display())
        }
        Some(_) => {}
        None => outputs.push((flag.to_owned(), file)),
    }
    Ok(())
}

/// The path of a file without links; the file itself need not exist.
fn identity(name: &Path) -> PathBuf {
    let folder = || {
        let folder = fs::canonicalize(folder_of(name)).ok()?;
        Some(folder.join(name.file_name().unwrap_or(OsStr::new(""))))
    };
    fs::canonicalize(name).ok().or_else(folder).unwrap_or_else(|| name.to_owned())
}

/// The file of a flag that can be written. It keeps what an earlier command wrote until [`Self::begin`] or [`Self::write`], and a
/// new file does not exist before: a command that fails or is interrupted changes nothing.
#[derive(Debug)]
pub enum OutputFile {
    /// A file of an earlier command, a device or a pipe, with its name.
    Existing(File, PathBuf),
    /// The name of a file that does not exist yet.
    New(PathBuf),
}

impl OutputFile {
    /// Empties the file, or creates it, for content that is not known yet.
    pub fn begin(self) -> io::Result<File> {
        match self {
            // A file that another program created in the meantime is not ours.
            Self::New(name) => {
                let file = OpenOptions::new().write(true).create_new(true).open(name)?;
                lock(&file)?;
                Ok(file)
            }
            Self::Existing(mut file, _) => {
                if file.metadata()?.is_file() {
                    file.rewind()?;
                    file.set_len(0)?;
                }
                Ok(file)
            }
        }
    }

    /// Writes the whole content. What the file had before is lost only once all of the new content is on the disk. That needs a
    /// second file in the same folder. Devices, links and files in a folder that cannot be written are overwritten in place.
    pub fn write(self, content: &[u8]) -> io::Result<()> {
        match &self {
            Self::New(name) => {
                // The empty file holds the name and the lock meanwhile.
                let name = name.clone();
                let _locked = self.begin()?;
                let written = replace(&name, content, None);
                if written.is_err() {
                    // An empty file that stays may be overwritten.
                    let _ = fs::remove_file(&name);
                }
                written
            }
            Self::Existing(_, name) if fs::symlink_metadata(name)?.is_file() => {
                let permissions = fs::metadata(name)?.permissions();
                match replace(name, content, Some(permissions)) {
                    Err(error) if is_about_folder(&error) => {
                        io::Write::write_all(&mut self.begin()?, content)
                    }
                    written => written,
                }
            }
            Self::Existing(..) => io::Write::write_all(&mut self.begin()?, content),
        }
    }
}

/// Whether a file cannot be replaced because of its folder, or because it is the mount point of another file system.
fn is_about_folder(error: &io::Error) -> bool {
    use io::ErrorKind::{PermissionDenied, ReadOnlyFilesystem, ResourceBusy};
    matches!(error.kind(), PermissionDenied | ReadOnlyFilesystem | ResourceBusy)
}

/// Opens the file of a flag, which this program wrote or which is new. It stays as it is until its content is written. `columns`
/// are those of its rows, if it has rows.
///
/// # Errors
/// The file cannot be written, it exists and has other content, or another flag or process writes it.
pub fn open(flag: &str, name: &Path, columns: &[&str]) -> anyhow::Result<OutputFile> {
    reserve(flag, name)?;
    // Creating a file shows that its name can be used. It goes at once: an interrupted command does not clean up.
    if OpenOptions::new().write(true).create_new(true).open(name).is_ok()
        && fs::remove_file(name).is_ok()
    {
        return Ok(OutputFile::New(name.to_owned()));
    }
    Ok(OutputFile::Existing(existing(flag, name, columns)?, name.to_owned()))
}

/// Opens a file that exists, and checks that this program wrote it.
fn existing(flag: &str, name: &Path, columns: &[&str]) -> anyhow::Result<File> {
    let place = || format!("{flag} {}", name.display());
    let opened = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(name);
    let mut file = opened.map_err(|error| {
        let what = format!("{}: cannot be written", place());
        refused(what, error, "name a file in a folder that exists")
    })?;
    let metadata = file.metadata().with_context(place)?;
    if metadata.is_file() {
        lock(&file).with_context(place)?;
    }
    if metadata.is_file() && metadata.len() > 0 {
        let is_own = is_own(&mut file, columns).with_context(place)?;
        ensure!(
            is_own,
            "{}: the file exists and was not written by this command: choose another name, or remove it",
            place()
        );
    } else if metadata.is_dir() {
        bail!("{}: is a folder: name a file", place());
    }
    Ok(file)
}

/// Locks a file until it is closed: two processes that write one file would mix their bytes.
fn lock(file: &File) -> io::Result<()> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(io::Error::other(
            "another process writes this file: choose another name, or wait for its end",
        )),
        // Some file systems have no locks.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(()),
    }
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
    let is_kind = |(start, part): &(&[u8], &[u8])| head.starts_with(start) && contains(head, part);
    KINDS.iter().any(is_kind) || is_rows(head, columns)
}

/// Whether rows of these columns begin so, of this or an earlier version: as CSV, as a list of objects, or as one object.
fn is_rows(head: &[u8], columns: &[&str]) -> bool {
    let columns = columns.get(..LEADING_COLUMNS.min(columns.len())).unwrap_or_default();
    let Some(first) = columns.first() else {
        return false;
    };
    let is_csv = || {
        let line = head.split(|byte| *byte == b'\n').next().unwrap_or_default();
        let names = line.split(|byte| *byte == b',').map(<[u8]>::trim_ascii);
        names.take(columns.len()).eq(columns.iter().map(|column| column.as_bytes()))
    };
    let is_json = |start: &str, indent: &str| {
        let key = |column: &str| format!("\n{indent}\"{column}\":");
        head.starts_with((start.to_owned() + &key(first)).as_bytes())
            && columns.iter().all(|column| contains(head, key(column).as_bytes()))
    };
    is_csv() || is_json("{", "  ") || is_json("[\n  {", "    ") || head == b"[]\n"
}

fn contains(bytes: &[u8], part: &[u8]) -> bool {
    part.is_empty() || bytes.windows(part.len()).any(|window| window == part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_of_this_program_are_own() {
        let columns = ["key", "world", "seed", "plan"];
        for own in [
            "key,world,seed\n",
            "key,world,seed,plan,new\r\n",
            "[\n  {\n    \"key\": \"a\",\n    \"world\": 1,\n    \"seed\": 1",
            "{\n  \"key\": \"a\",\n  \"world\": 1,\n  \"seed\": 1",
            "{\"time_s\":0.0,\"pose\":[0,0,0],\"local_target\":[1,1]}",
            "# Imported from a.yaml by `inbye config import-nav2`; all other",
            "# Found by `inbye tune`; all other",
        ] {
            assert!(is_own_head(own.as_bytes(), &columns), "{own}");
        }
        for other in [
            "name,key\n",
            "key,value\n",
            "key,world\n",
            "{\n  \"key\": \"a\",\n  \"place\": 1",
            "image: map.pgm\n",
            "{}",
            "P5\n",
            "keyboard,world,seed",
            // Files of others that name the program.
            "# Settings for inbye\n[navigator]\n",
            "<p>inbye</p>",
            "{\"time_s\":0.0,\"program\":\"inbye\"}",
        ] {
            assert!(!is_own_head(other.as_bytes(), &columns), "{other}");
        }
        assert!(!is_own_head(b"key,world,seed\n", &[]), "no rows are expected");
    }

    fn begun(file: OutputFile) -> anyhow::Result<File> {
        Ok(file.begin()?)
    }

    #[test]
    fn two_flags_cannot_write_one_file() {
        let folder = tempfile::tempdir().expect("a place for temporary files");
        let name = folder.path().join("a.svg");
        open("--svg", &name, &[]).and_then(begun).expect("a new file");
        open("--svg", &name, &[]).and_then(begun).expect("its own file");
        let same = folder.path().join(".").join("a.svg");
        let error = open("--chart", &same, &[]).expect_err("taken").to_string();
        assert!(error.contains("--chart") && error.contains("--svg writes this file"), "{error}");
        // A file that does not exist yet is known by its folder.
        reserve("--report", &folder.path().join("index.html")).expect("free");
        assert!(open("--record", &folder.path().join("index.html"), &[]).is_err());
        open("--record", &folder.path().join("other.html"), &[]).expect("free");
    }

    #[test]
    fn file_that_another_process_writes_is_refused() {
        let folder = tempfile::tempdir().expect("a place for temporary files");
        let name = folder.path().join("run.mcap");
        let first = open("--record", &name, &[]).and_then(begun).expect("a new file");
        // A lock belongs to an opened file, so that this process meets its own.
        let error = format!("{:#}", open("--record", &name, &[]).expect_err("locked"));
        assert!(error.contains("run.mcap: another process writes this file"), "{error}");
        drop(first);
        open("--record", &name, &[]).expect("its writer has ended");
        open("--record", Path::new("/dev/null"), &[]).expect("devices have no locks");
    }

    /// A written file has its whole content or none, under its old permissions, also through a link.
    #[cfg(unix)]
    #[test]
    fn written_file_is_replaced_as_a_whole() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().expect("a place for temporary files");
        let (name, link) = (folder.path().join("a.csv"), folder.path().join("b.csv"));
        let write = |name: &Path, text: &str| {
            open("--record", name, &["a"]).expect("own").write(text.as_bytes()).expect("written");
        };
        write(&name, "a\n1\n");
        fs::set_permissions(&name, fs::Permissions::from_mode(0o640)).expect("permissions");
        let before = File::open(&name).expect("the file");
        write(&name, "a\n2\n");
        assert_eq!(fs::read_to_string(&name).expect("the file"), "a\n2\n");
        assert_eq!(fs::metadata(&name).expect("the file").permissions().mode() & 0o777, 0o640);
        assert_eq!(io::read_to_string(before).expect("the old file"), "a\n1\n");
        symlink("a.csv", &link).expect("a link");
        open("--record", &link, &["a"]).expect("own").write(b"a\n3\n").expect("written");
        assert_eq!(fs::read_to_string(&name).expect("the file"), "a\n3\n");
        assert_eq!(fs::read_dir(folder.path()).expect("the folder").count(), 2, "no parts");
    }
}
