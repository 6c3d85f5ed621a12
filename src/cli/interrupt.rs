//! Ctrl-C and the signals that ask a program to end.

use std::process::exit;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;

/// Exit status of a program that Ctrl-C ended at once, as shells have it.
const AT_ONCE: i32 = 130;

/// A flag that is set by Ctrl-C, SIGTERM and SIGHUP. The second of them ends the program at once, and then a base is left to
/// its own watchdog.
pub fn flag() -> anyhow::Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&flag);
    let ask = move || {
        if asked.swap(true, Ordering::Relaxed) {
            exit(AT_ONCE);
        }
    };
    ctrlc::set_handler(ask).context("Ctrl-C cannot be listened to")?;
    Ok(flag)
}
