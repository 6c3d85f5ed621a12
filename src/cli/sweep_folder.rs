//! The folder of a sweep's results. Whoever is killed leaves whole files only, and locks that the system takes back.
//!
//! `sweep.json` says which cells there are, `cells/KEY.json` holds the result of one. `claims/KEY.lock` is locked by whoever
//! runs that cell, `sweep.lock` by everybody at work here, `log.jsonl` tells who did what.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use std::{process, thread};

use anyhow::{Context, bail};
use inbye::experiment::sweep::{CellFile, Manifest};
use serde_json::json;

use super::output;

/// What lies in the folder.
const MANIFEST: &str = "sweep.json";
const CELLS: &str = "cells";
const CLAIMS: &str = "claims";
const IN_USE: &str = "sweep.lock";
const LOG: &str = "log.jsonl";

/// How often and after which pauses a new plan is tried that others begin at the same time.
const ATTEMPTS: u32 = 100;
const PAUSE: Duration = Duration::from_millis(10);

/// A folder of results, in use.
pub struct Folder {
    path: PathBuf,
    log: File,
    /// Shared with everybody at work here; whoever brings another plan must find nobody.
    _in_use: File,
}

/// A cell that is ours to run; let go when this is dropped.
pub struct Claim {
    path: PathBuf,
    _lock: File,
}

impl Folder {
    /// Opens a folder, made where it is missing, for the cells of a plan.
    pub fn open(path: &Path, manifest: &Manifest) -> anyhow::Result<Self> {
        let place = || format!("--out {}", path.display());
        for part in [CELLS, CLAIMS] {
            fs::create_dir_all(path.join(part))
                .context("cannot be a folder: choose another name")
                .with_context(place)?;
        }
        let opened = Self::prepared(path, manifest);
        let (in_use, log) = opened.with_context(place)?;
        Ok(Self {
            path: path.to_owned(),
            log,
            _in_use: in_use,
        })
    }

    fn prepared(path: &Path, manifest: &Manifest) -> anyhow::Result<(File, File)> {
        let in_use = lock_file(&path.join(IN_USE))?;
        let file = path.join(MANIFEST);
        let text = manifest.text();
        let mut attempts = 0;
        loop {
            in_use.lock_shared().context(LOCKS)?;
            let held = fs::read(&file);
            if held.as_ref().is_ok_and(|held| *held == text.as_bytes()) {
                break;
            }
            in_use.unlock()?;
            match in_use.try_lock() {
                Ok(()) => {}
                // Several that begin a new plan at once: one of them writes it.
                Err(TryLockError::WouldBlock) if attempts < ATTEMPTS => {
                    attempts += 1;
                    thread::sleep(PAUSE);
                    continue;
                }
                Err(TryLockError::WouldBlock) => {
                    bail!("another plan is being run in it: wait, or name another folder")
                }
                Err(TryLockError::Error(error)) => return Err(error).context(LOCKS),
            }
            if held.is_ok() {
                output::note(
                    "another plan was run in this folder: cells of both are not driven again",
                );
            }
            write_whole(&file, &text)?;
            in_use.unlock()?;
        }
        let log = OpenOptions::new()
            .append(true)
            .create(true)
            .open(path.join(LOG))?;
        Ok((in_use, log))
    }

    /// Whether a cell has its result. One that is damaged is an error.
    pub fn has(&self, key: &str) -> anyhow::Result<bool> {
        let file = self.cell(key);
        let bytes = match fs::read(&file) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(false),
            bytes => bytes.with_context(|| file.display().to_string())?,
        };
        CellFile::parse(&bytes, &file, key)?;
        Ok(true)
    }

    /// Takes a cell for this process: none where somebody else has it, unless we are to wait until it is let go.
    pub fn claim(&self, key: &str, wait: bool) -> anyhow::Result<Option<Claim>> {
        let path = self.path.join(CLAIMS).join(format!("{key}.lock"));
        let lock = lock_file(&path)?;
        if wait {
            lock.lock().context(LOCKS)?;
        } else {
            match lock.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Ok(None),
                Err(TryLockError::Error(error)) => return Err(error).context(LOCKS),
            }
        }
        Ok(Some(Claim { path, _lock: lock }))
    }

    /// Keeps the result of a cell that is ours: as a whole, or not at all.
    pub fn keep(&self, file: &CellFile) -> anyhow::Result<()> {
        write_whole(&self.cell(&file.key), &file.text())?;
        self.tell(&file.key, "finished");
        Ok(())
    }

    /// Adds a line to the log. It is for people, and nothing depends on it.
    pub fn tell(&self, key: &str, event: &str) {
        let since = SystemTime::now().duration_since(UNIX_EPOCH);
        let unix_s = since.map_or(0.0, |since| since.as_secs_f64());
        let line = json!({ "unix_s": unix_s, "pid": process::id(), "event": event, "key": key });
        if let Err(error) = (&self.log).write_all(format!("{line}\n").as_bytes()) {
            output::warn(format!("{}: {error}", self.path.join(LOG).display()));
        }
    }

    fn cell(&self, key: &str) -> PathBuf {
        self.path.join(CELLS).join(format!("{key}.json"))
    }
}

impl Claim {
    /// Lets go of a cell that has its result: whoever opened the lock before will see that.
    pub fn done(self) {
        // One that stays is empty, and in nobody's way.
        let _ = fs::remove_file(&self.path);
    }
}

/// The plan and the results of a folder, to be merged.
pub fn read(path: &Path) -> anyhow::Result<(Manifest, Vec<(PathBuf, CellFile)>)> {
    let file = path.join(MANIFEST);
    let held = fs::read(&file).with_context(|| {
        let file = file.display();
        format!("{file}: cannot be read: name a folder that `inbye sweep --out` made")
    });
    let manifest = Manifest::parse(&held?, &file)?;
    let mut cells = Vec::new();
    for key in manifest.keys() {
        let file = path.join(CELLS).join(format!("{key}.json"));
        let bytes = match fs::read(&file) {
            Err(error) if error.kind() == ErrorKind::NotFound => continue,
            bytes => bytes.with_context(|| file.display().to_string())?,
        };
        let cell = CellFile::parse(&bytes, &file, key)?;
        cells.push((file, cell));
    }
    Ok((manifest, cells))
}

/// What it means when a file cannot be locked.
pub const LOCKS: &str = "the file system does not lock files: name a folder on another one";

/// A file to be locked, made where it is missing.
fn lock_file(path: &Path) -> anyhow::Result<File> {
    let opened = OpenOptions::new().append(true).create(true).open(path);
    opened.with_context(|| format!("{}: cannot be opened", path.display()))
}

/// Writes a file as a whole or not at all, on the disk before its name is. Only one process at a time may write it.
fn write_whole(file: &Path, text: &str) -> anyhow::Result<()> {
    let mut beside = file.to_owned().into_os_string();
    beside.push(".part");
    let written = File::create(&beside).and_then(|mut part| {
        part.write_all(text.as_bytes())?;
        part.sync_all()?;
        fs::rename(&beside, file)?;
        // The name, too: a folder can be opened and synced where there is something to sync.
        match file.parent().map(File::open) {
            Some(Ok(folder)) => folder.sync_all(),
            _ => Ok(()),
        }
    });
    written.with_context(|| format!("{}: cannot be written", file.display()))
}
