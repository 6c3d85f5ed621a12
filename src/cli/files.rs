//! Output files of flags, and the folder of `--report`. They are opened before the work starts, so that a wrong name fails
//! early, and written after it, so that a command that fails leaves them as they were.

use std::ffi::OsStr;
use std::fs;
use std::path::Path;

use anyhow::{Context, bail};
use inbye::bench::{Columns, csv_text};
use inbye::report::{BenchReport, ReportFile, bench_files};

use super::own_file::{LEADING_COLUMNS, OutputFile};
use super::refusal::refused;
use super::{invocation, machine, output, own_file, runs};

/// Extensions of a file of rows.
const ROWS: [&str; 2] = ["csv", "json"];

/// The page of a report.
pub const PAGE: &str = "index.html";

/// The output file of a flag; nothing is written without the flag.
pub struct Output<'a> {
    flag: &'static str,
    file: Option<(&'a Path, OutputFile)>,
}

impl<'a> Output<'a> {
    /// Opens the file. The name must have one of these extensions. The file stays as it is until [`Self::write`].
    pub fn create(
        flag: &'static str,
        name: Option<&'a Path>,
        extensions: &[&str],
    ) -> anyhow::Result<Self> {
        Self::create_with(flag, name, extensions, &[])
    }

    fn create_with(
        flag: &'static str,
        name: Option<&'a Path>,
        extensions: &[&str],
        columns: &[&str],
    ) -> anyhow::Result<Self> {
        let Some(name) = name else {
            return Ok(Self { flag, file: None });
        };
        if !extensions.iter().any(|extension| has_extension(name, extension)) {
            let extensions = extensions.join(" or .");
            bail!("{flag} {}: the name must end in .{extensions}", name.display());
        }
        Ok(Self { flag, file: Some((name, own_file::open(flag, name, columns)?)) })
    }

    /// Creates a file of rows of this type, CSV or JSON.
    pub fn of_rows<R: Columns>(flag: &'static str, name: Option<&'a Path>) -> anyhow::Result<Self> {
        let columns: Vec<&str> = R::COLUMNS.iter().map(|column| column.name).collect();
        Self::create_with(flag, name, &ROWS, &columns)
    }

    /// Whether the flag was given.
    pub const fn is_requested(&self) -> bool {
        self.file.is_some()
    }

    /// Writes the content.
    pub fn write<C: AsRef<[u8]>>(self, content: impl FnOnce() -> C) -> anyhow::Result<()> {
        let Some((name, file)) = self.file else {
            return Ok(());
        };
        let written = file.write(content().as_ref());
        written.with_context(|| format!("{} {}", self.flag, name.display()))?;
        // A report names its page.
        if self.flag != "--report" {
            output::note(format!("{}: {}", self.flag.trim_start_matches('-'), name.display()));
        }
        Ok(())
    }

    /// Writes rows, as JSON or CSV by the file's extension.
    pub fn write_rows<R: Columns>(self, rows: &[R]) -> anyhow::Result<()> {
        let name = self.file.as_ref().map(|(name, _)| *name);
        if name.is_some_and(|name| has_extension(name, "json")) {
            let text = serde_json::to_string_pretty(rows)? + "\n";
            return self.write(|| text);
        }
        self.write(|| csv_text(rows))
    }
}

/// Returns the first error of several files. The caller has tried to write each of them: a full disk for one file must not prevent the
/// others. Further errors are printed as warnings.
pub fn all_written(files: impl IntoIterator<Item = anyhow::Result<()>>) -> anyhow::Result<()> {
    let mut errors = files.into_iter().filter_map(Result::err);
    let Some(first) = errors.next() else { return Ok(()) };
    errors.for_each(|error| output::warn(format!("{error:#}")));
    Err(first)
}

/// Whether a name ends in an extension, in capitals or not.
pub fn has_extension(name: &Path, wanted: &str) -> bool {
    name.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(wanted))
}

/// Opens the file of a flag, which has no rows of a table. The file stays as it is until its content is written.
pub fn open_file(flag: &str, name: &Path) -> anyhow::Result<OutputFile> {
    own_file::open(flag, name, &[])
}

/// The folder of a report; nothing is written without one.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct ReportFolder<'a> {
    folder: Option<&'a Path>,
    /// The flag or argument that names it.
    flag: &'static str,
}

impl<'a> ReportFolder<'a> {
    /// The folder of `--report`, as [`Self::of_argument`].
    pub(super) fn create(name: Option<&'a Path>) -> anyhow::Result<Self> {
        Self::of_argument("--report", name)
    }

    /// Creates the folder if it is missing. A page of another program is refused before the work, not after it.
    ///
    /// # Errors
    /// The folder cannot be created or written, or it has such a page.
    pub fn of_argument(flag: &'static str, folder: Option<&'a Path>) -> anyhow::Result<Self> {
        if let Some(name) = folder {
            own_file::reserve(flag, name)?;
            fs::create_dir_all(name).map_err(|error| {
                let what = format!("{flag} {}: cannot be a folder", name.display());
                refused(what, error, "choose another name")
            })?;
            open_file(flag, &name.join(PAGE))?;
        }
        Ok(Self { folder, flag })
    }

    /// Writes the files of a report.
    ///
    /// # Errors
    /// A file cannot be written, or is one of another program.
    pub fn write_files(&self, files: &[ReportFile]) -> anyhow::Result<()> {
        let Some(folder) = self.folder else {
            return Ok(());
        };
        for file in files {
            let columns = leading_columns(file);
            let name = folder.join(&file.name);
            let written = own_file::open(self.flag, &name, &columns)?.write(file.text.as_bytes());
            written.with_context(|| format!("{} {}", self.flag, name.display()))?;
        }
        Ok(())
    }

    /// Writes the files of a report and prints the name of the first, its page.
    pub(super) fn write(self, files: impl FnOnce() -> Vec<ReportFile>) -> anyhow::Result<()> {
        let Some(folder) = self.folder else {
            return Ok(());
        };
        let files = files();
        self.write_files(&files)?;
        if let Some(page) = files.first() {
            output::note(format!("report: {}", folder.join(&page.name).display()));
        }
        Ok(())
    }

    /// Writes a page as `index.html`.
    pub(super) fn write_page(self, page: impl FnOnce() -> String) -> anyhow::Result<()> {
        self.write(|| vec![ReportFile { name: PAGE.to_owned(), text: page() }])
    }

    /// Writes the report of a benchmark that this command ran on this machine.
    pub(super) fn write_bench(self, report: BenchReport) -> anyhow::Result<()> {
        self.write(|| {
            let (machine, command) = (&machine::description(), &command_line());
            let intro = &format!("{}\n\n{}", runs::interruption(), report.intro);
            bench_files(&BenchReport { intro, machine, command, ..report })
        })
    }
}

/// The leading columns of a file of rows, or keys of an object; none of a page or a picture.
fn leading_columns(file: &ReportFile) -> Vec<&str> {
    let extension = Path::new(&file.name).extension().and_then(OsStr::to_str);
    let lines = || file.text.lines();
    match extension {
        Some("csv") => lines().flat_map(|line| line.split(',')).take(LEADING_COLUMNS).collect(),
        Some("json") => {
            let indent = |line: &str| line.len() - line.trim_start().len();
            let is_key = |line: &&str| line.trim_start().starts_with('"');
            let of_first = lines().find(is_key).map(indent);
            let keys = lines().filter(is_key).filter(|line| Some(indent(line)) == of_first);
            keys.filter_map(|line| line.split('"').nth(1)).take(LEADING_COLUMNS).collect()
        }
        _ => Vec::new(),
    }
}

/// The command line for a shell, with the program's name without its folder.
pub fn command_line() -> String {
    let words = invocation::arguments().iter().map(|word| quoted(&word.to_string_lossy()));
    let words: Vec<String> = ["inbye".to_owned()].into_iter().chain(words).collect();
    words.join(" ")
}

/// Flags with their values as a shell reads them, each after a space.
#[cfg(feature = "playground")]
pub fn shell_arguments(given: impl Iterator<Item = (&'static str, String)>) -> String {
    given.flat_map(|(flag, value)| [format!(" {flag} "), quoted(&value)]).collect()
}

/// A word as a shell reads it.
pub fn quoted(word: &str) -> String {
    let is_plain = |letter: char| letter.is_alphanumeric() || "_./,:=@%+-".contains(letter);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}
