//! The lock that keeps a latency measurement apart from all other cells of its user.

use std::fs::{self, File};
use std::path::PathBuf;
use std::sync::Once;

use anyhow::Context;
use inbye::experiment::Cell;

use super::result_store::{Lock, NO_LOCKS, lock_file, try_lock};
use super::{machine, output};

/// Name of the lock file.
const NAME: &str = "inbye-latency.lock";

/// Whether this process has printed that it waits.
static HAS_NOTED_WAIT: Once = Once::new();

/// Waits until a cell may run, and prints that it waits. A latency cell waits for all other cells of this user, and they for it. The
/// lock ends when the file is dropped.
pub fn of(cell: &Cell) -> anyhow::Result<File> {
    let folder = folder();
    let path = folder.join(NAME);
    let place = || path.display().to_string();
    fs::create_dir_all(&folder).with_context(place)?;
    let file = lock_file(&path)?;
    let kind = if cell.row.latency { Lock::Exclusive } else { Lock::Shared };
    if !try_lock(&file, kind).with_context(place)? {
        HAS_NOTED_WAIT.call_once(|| {
            let other = if cell.row.latency { "runs cells" } else { "measures latency" };
            output::note(format!("waiting: another process {other} ({})", place()));
        });
        let locked = match kind {
            Lock::Exclusive => file.lock(),
            Lock::Shared => file.lock_shared(),
        };
        locked.context(NO_LOCKS).with_context(place)?;
    }
    Ok(file)
}

/// A folder of this user: no other user can hold or block its locks.
fn folder() -> PathBuf {
    let variable = |name: &str| std::env::var_os(name).map(PathBuf::from);
    let runtime = variable("XDG_RUNTIME_DIR").filter(|folder| folder.is_dir());
    runtime.or_else(machine::cache_folder).unwrap_or_else(std::env::temp_dir)
}
