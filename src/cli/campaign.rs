//! Campaigns of many runs: their file, their threads and their progress bar.

use std::fs::{File, OpenOptions, rename};
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;
use inbye::experiment::campaign::{Ledger, Row, run_cells};

use super::output;

/// How the runs of a campaign are made.
pub struct Campaign<'a> {
    /// What stands beside the progress bar.
    pub what: &'a str,
    /// The file of `--record`, none to keep no file.
    pub record: Option<&'a Path>,
    /// Digest of all settings that the runs depend on.
    pub settings: &'a str,
    /// How many runs are made at a time.
    pub threads: usize,
}

impl Campaign<'_> {
    /// Makes the runs that the file does not have yet, each row written as its run finishes; at the end the file is in
    /// the order of the keys. The ledger holds all rows of the file, also of cells not asked for now.
    pub fn run<C: Sync, R: Row>(
        &self,
        cells: &[C],
        key: impl Fn(&C) -> R::Key,
        work: impl Fn(&C) -> anyhow::Result<R> + Sync,
    ) -> anyhow::Result<Ledger<R>> {
        let (mut ledger, mut file) = self.open()?;
        let open: Vec<&C> = cells
            .iter()
            .filter(|cell| !ledger.has(&key(cell)))
            .collect();
        let bar = output::progress(cells.len() as u64, self.what);
        bar.set_position((cells.len() - open.len()) as u64);
        let take = |row: R| {
            if let Some(record) = &mut file {
                record.append(&ledger.line(&row))?;
            }
            ledger.add(row);
            bar.inc(1);
            Ok(())
        };
        run_cells(&open, self.threads, |cell| work(cell), take)?;
        bar.finish_and_clear();
        if let Some(record) = &file {
            record.replace(&ledger.text())?;
        }
        Ok(ledger)
    }

    /// The ledger of the file, and the file with a torn line cut off, ready for more.
    fn open<R: Row>(&self) -> anyhow::Result<(Ledger<R>, Option<Record>)> {
        let Some(path) = self.record else {
            return Ok((Ledger::new(self.settings), None));
        };
        let place = || format!("--record {}", path.display());
        let (mut record, held) = Record::open(path).with_context(place)?;
        let (ledger, whole) = Ledger::read(&held, path, self.settings)?;
        record.file.set_len(whole as u64).with_context(place)?;
        if whole == 0 {
            record.append(&ledger.header())?;
        }
        Ok((ledger, Some(record)))
    }
}

/// The file of `--record`.
struct Record {
    path: PathBuf,
    file: File,
}

impl Record {
    /// Opens the file, which need not exist, and says what it holds.
    fn open(path: &Path) -> anyhow::Result<(Self, Vec<u8>)> {
        let mut options = OpenOptions::new();
        // What is appended goes behind what is there, also after it was cut.
        options.read(true).append(true).create(true);
        let opened = options.open(path);
        let mut file = match opened {
            Err(error) if error.kind() == ErrorKind::NotFound => {
                return Err(error)
                    .context("cannot be written: name a file in a folder that exists");
            }
            opened => opened.context("cannot be opened: check the path and its permissions")?,
        };
        let mut held = Vec::new();
        file.read_to_end(&mut held)?;
        let path = path.to_owned();
        Ok((Self { path, file }, held))
    }

    /// Adds a line at once.
    fn append(&mut self, line: &str) -> anyhow::Result<()> {
        self.file
            .write_all(line.as_bytes())
            .and_then(|()| self.file.flush())
            .with_context(|| format!("--record {}", self.path.display()))
    }

    /// Puts a text in place of the file, as a whole or not at all.
    fn replace(&self, text: &str) -> anyhow::Result<()> {
        let mut beside = self.path.clone().into_os_string();
        beside.push(".part");
        std::fs::write(&beside, text)
            .and_then(|()| rename(&beside, &self.path))
            .with_context(|| format!("--record {}", self.path.display()))
    }
}
