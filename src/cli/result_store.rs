//! The folder of an experiment's results. A killed process leaves only whole files, and locks that the system releases.
//!
//! `sweep.json` lists the cells, `cells/KEY.json` has the result of one. A process locks `claims/KEY.lock` while it runs that
//! cell and `sweep.lock`, shared, while it works here. `log.jsonl` lists what each process did.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use std::{process, thread};

use anyhow::{Context, ensure};
use inbye::experiment::{CellFile, Manifest, RunRow};
use serde_json::json;

use super::output;
use super::refusal::refused;
use super::whole_file::write_whole;

/// Names in the folder.
const MANIFEST: &str = "sweep.json";
const CELLS: &str = "cells";
const CLAIMS: &str = "claims";
const IN_USE: &str = "sweep.lock";
const LOG: &str = "log.jsonl";

/// Number of attempts and pause between them when several processes start a new plan at the same time.
const ATTEMPTS: u32 = 100;
const PAUSE: Duration = Duration::from_millis(10);

/// A folder of results, in use.
pub struct ResultStore {
    path: PathBuf,
    log_file: File,
    /// Shared by all processes that work here; another plan needs it exclusively.
    _in_use: File,
}

/// What to do about a cell that another process runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IfBusy {
    Skip,
    Wait,
}

/// The kind of a lock on a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lock {
    Exclusive,
    Shared,
}

/// The right to run a cell; released when this is dropped.
pub struct Claim {
    path: PathBuf,
    _lock: File,
}

impl ResultStore {
    /// Opens a folder for the cells of a plan; creates it if it is missing.
    pub fn open(path: &Path, manifest: &Manifest) -> anyhow::Result<Self> {
        let place = || format!("--out {}", path.display());
        for part in [CELLS, CLAIMS] {
            fs::create_dir_all(path.join(part)).map_err(|error| {
                refused(format!("{}: cannot be a folder", place()), error, "choose another name")
            })?;
        }
        let opened = Self::prepared(path, manifest);
        let (in_use, log) = opened.with_context(place)?;
        Ok(Self { path: path.to_owned(), log_file: log, _in_use: in_use })
    }

    fn prepared(path: &Path, manifest: &Manifest) -> anyhow::Result<(File, File)> {
        let in_use = lock_file(&path.join(IN_USE))?;
        let file = path.join(MANIFEST);
        let text = manifest.text();
        let mut attempts = 0;
        loop {
            in_use.lock_shared().context(NO_LOCKS)?;
            let held = fs::read(&file);
            if held.as_ref().is_ok_and(|held| *held == text.as_bytes()) {
                break;
            }
            in_use.unlock()?;
            if !try_lock(&in_use, Lock::Exclusive)? {
                // Of several processes that start a new plan at the same time one writes it.
                attempts += 1;
                ensure!(
                    attempts <= ATTEMPTS,
                    "another plan is being run in it: wait, or name another folder"
                );
                thread::sleep(PAUSE);
                continue;
            }
            if held.is_ok() {
                output::note(
                    "another plan was run in this folder: cells of both plans are not run again",
                );
            }
            write_whole(&file, &text)?;
            in_use.unlock()?;
        }
        let log = OpenOptions::new().append(true).create(true).open(path.join(LOG))?;
        Ok((in_use, log))
    }

    /// The result of a cell, if it has one. A damaged result is an error.
    pub fn row(&self, key: &str) -> anyhow::Result<Option<RunRow>> {
        Ok(read_cell(&self.path, key)?.map(|(_, file)| file.row))
    }

    /// Claims a cell for this process; none where another process has it and this one does not wait.
    pub fn claim(&self, key: &str, if_busy: IfBusy) -> anyhow::Result<Option<Claim>> {
        let path = self.path.join(CLAIMS).join(format!("{key}.lock"));
        let lock = lock_file(&path)?;
        match if_busy {
            IfBusy::Wait => lock.lock().context(NO_LOCKS)?,
            IfBusy::Skip if try_lock(&lock, Lock::Exclusive)? => {}
            IfBusy::Skip => return Ok(None),
        }
        Ok(Some(Claim { path, _lock: lock }))
    }

    /// Keeps the result of a claimed cell: as a whole, or not at all.
    pub fn keep(&self, file: &CellFile) -> anyhow::Result<()> {
        write_whole(&cell_path(&self.path, &file.row.key), &file.text())?;
        self.log(&file.row.key, "finished");
        Ok(())
    }

    /// Adds a line to the log. Nothing depends on it.
    pub fn log(&self, key: &str, event: &str) {
        let since = SystemTime::now().duration_since(UNIX_EPOCH);
        let unix_s = since.map_or(0.0, |since| since.as_secs_f64());
        let line = json!({ "unix_s": unix_s, "pid": process::id(), "event": event, "key": key });
        if let Err(error) = (&self.log_file).write_all(format!("{line}\n").as_bytes()) {
            output::warn(format!("{}: {error}", self.path.join(LOG).display()));
        }
    }
}

impl Claim {
    /// Releases a cell that has its result: a process that opened the lock before finds the result.
    pub fn done(self) {
        // A file that stays is empty and harmless.
        let _ = fs::remove_file(&self.path);
    }
}

/// The manifest and the results of a folder.
pub fn read(path: &Path) -> anyhow::Result<(Manifest, Vec<(PathBuf, CellFile)>)> {
    let file = path.join(MANIFEST);
    let held = fs::read(&file).map_err(|error| {
        let remedy = "name a folder that --out of an experiment made";
        refused(format!("{}: cannot be read", file.display()), error, remedy)
    });
    let manifest = Manifest::parse(&held?, &file)?;
    let cells = manifest.keys().into_iter().filter_map(|key| read_cell(path, key).transpose());
    let cells = cells.collect::<Result<_, _>>()?;
    Ok((manifest, cells))
}

/// The result of a cell and its file; none if the cell has no result yet.
fn read_cell(folder: &Path, key: &str) -> anyhow::Result<Option<(PathBuf, CellFile)>> {
    let file = cell_path(folder, key);
    let bytes = match fs::read(&file) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        bytes => bytes.with_context(|| file.display().to_string())?,
    };
    let cell = CellFile::parse(&bytes, &file, key)?;
    Ok(Some((file, cell)))
}

fn cell_path(folder: &Path, key: &str) -> PathBuf {
    folder.join(CELLS).join(format!("{key}.json"))
}

/// Why a file cannot be locked.
pub const NO_LOCKS: &str = "the file system does not lock files: name a folder on another one";

/// Opens a lock file; creates it if it is missing.
pub fn lock_file(path: &Path) -> anyhow::Result<File> {
    let opened = OpenOptions::new().append(true).create(true).open(path);
    opened.with_context(|| format!("{}: cannot be opened", path.display()))
}

/// Locks a file; returns false if a lock of another process prevents it.
pub fn try_lock(file: &File, kind: Lock) -> anyhow::Result<bool> {
    let locked = match kind {
        Lock::Exclusive => file.try_lock(),
        Lock::Shared => file.try_lock_shared(),
    };
    match locked {
        Ok(()) => Ok(true),
        Err(TryLockError::WouldBlock) => Ok(false),
        Err(TryLockError::Error(error)) => Err(error).context(NO_LOCKS),
    }
}
