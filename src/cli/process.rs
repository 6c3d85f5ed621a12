//! The process: its clock, and the signals that end it.

use std::process::exit;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::Context;

/// Exit status after a second Ctrl-C, as shells define it.
const INTERRUPTED: i32 = 130;

/// Time for a base supervisor to send its zero commands: its thread sees the flag within 20 ms and takes at most 0.2 s.
const STOP_TIME: Duration = Duration::from_millis(250);

/// Returns a clock in seconds since this call. Library code gets it as a parameter.
pub fn wall_clock() -> impl FnMut() -> f64 {
    let started = Instant::now();
    move || started.elapsed().as_secs_f64()
}

/// Returns a flag that Ctrl-C, SIGTERM and SIGHUP set. A second signal ends the process once a base has been stopped.
pub fn interrupt_flag() -> anyhow::Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    let is_set = Arc::clone(&flag);
    let handler = move || {
        if is_set.swap(true, Ordering::Relaxed) {
            thread::sleep(STOP_TIME);
            exit(INTERRUPTED);
        }
    };
    ctrlc::set_handler(handler).context("cannot install the handler of Ctrl-C")?;
    Ok(flag)
}
