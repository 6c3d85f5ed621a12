//! Ctrl-C and the signals that ask a program to end.

use std::process::exit;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use anyhow::Context;

/// Exit status of a program that Ctrl-C ended at once, as shells have it.
const AT_ONCE: i32 = 130;

/// Time for whoever keeps a base to leave it with zeros: its thread sees the flag within 20 ms, and takes 0.2 s at worst.
const FAREWELL: Duration = Duration::from_millis(250);

/// A flag that is set by Ctrl-C, SIGTERM and SIGHUP. The second of them ends the program, whatever it is at, as soon as a base
/// has been left with zeros.
pub fn flag() -> anyhow::Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&flag);
    let ask = move || {
        if asked.swap(true, Ordering::Relaxed) {
            thread::sleep(FAREWELL);
            exit(AT_ONCE);
        }
    };
    ctrlc::set_handler(ask).context("Ctrl-C cannot be listened to")?;
    Ok(flag)
}
