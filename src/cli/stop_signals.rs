//! Signals of a command that has a base: none of them ends or suspends the program before the base has been stopped.
//!
//! Handlers, not blocked signals: the serial ports wait with `ppoll` and an empty signal mask, so that a blocked signal would reach
//! their threads and end the program.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use nix::sys::signal::{SaFlags, SigAction, SigHandler, SigSet, Signal, raise, sigaction};

/// Signals that end or suspend a program by default, and that end it here as SIGTERM does: Ctrl-\ and Ctrl-Z in a terminal, timers and
/// limits of the process. Not among them are errors of the program itself, after which its code cannot go on.
const ENDING: [Signal; 8] = [
    Signal::SIGQUIT,
    Signal::SIGTSTP,
    Signal::SIGUSR2,
    Signal::SIGALRM,
    Signal::SIGVTALRM,
    Signal::SIGPROF,
    Signal::SIGXCPU,
    Signal::SIGABRT,
];

/// Further ones of Linux.
#[cfg(target_os = "linux")]
const ENDING_ON_LINUX: [Signal; 3] = [Signal::SIGIO, Signal::SIGPWR, Signal::SIGSTKFLT];
#[cfg(not(target_os = "linux"))]
const ENDING_ON_LINUX: [Signal; 0] = [];

/// Reading from or writing to the terminal in the background: an error or possible, but no reason to suspend the program. A file
/// at the limit of its size: the write fails, which ends a recording and not the drive.
const IGNORED: [Signal; 3] = [Signal::SIGTTIN, Signal::SIGTTOU, Signal::SIGXFSZ];

/// Whether SIGUSR1 has come and the robot was not yet stopped for it.
static STOP_SIGNAL: AtomicBool = AtomicBool::new(false);

/// Whether SIGUSR1 came since the last call.
pub fn take_stop_signal() -> bool {
    STOP_SIGNAL.swap(false, Ordering::SeqCst)
}

/// What SIGUSR1 does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnStopSignal {
    /// It stops the robot of a command with an operator, who may arm it again.
    StopRobot,
    /// It ends every other command.
    EndProgram,
}

/// Catches every signal that would end or suspend the program.
pub fn catch(on_stop_signal: OnStopSignal) -> anyhow::Result<()> {
    extern "C" fn stop(_: core::ffi::c_int) {
        STOP_SIGNAL.store(true, Ordering::SeqCst);
    }
    extern "C" fn end(_: core::ffi::c_int) {
        // It cannot fail for a signal that exists.
        let _ = raise(Signal::SIGTERM);
    }
    for signal in ENDING.into_iter().chain(ENDING_ON_LINUX) {
        set(signal, SigHandler::Handler(end))?;
    }
    for signal in IGNORED {
        set(signal, SigHandler::SigIgn)?;
    }
    let on_stop = match on_stop_signal {
        OnStopSignal::StopRobot => stop,
        OnStopSignal::EndProgram => end,
    };
    set(Signal::SIGUSR1, SigHandler::Handler(on_stop))?;
    Ok(())
}

/// Installs handlers. SIGHUP stays ignored if it was when the program started, as `nohup` does.
pub fn install_but_keep_nohup<T>(install: impl FnOnce() -> T) -> anyhow::Result<T> {
    let inherited = set(Signal::SIGHUP, SigHandler::SigIgn)?;
    let installed = install();
    if matches!(inherited, SigHandler::SigIgn) {
        set(Signal::SIGHUP, SigHandler::SigIgn)?;
    }
    Ok(installed)
}

/// Sets what a signal does, and returns what it did.
fn set(signal: Signal, handler: SigHandler) -> anyhow::Result<SigHandler> {
    let action = SigAction::new(handler, SaFlags::SA_RESTART, SigSet::empty());
    // SAFETY: the handlers of this module only store an atomic value or raise a signal, which is safe in a signal handler.
    #[expect(unsafe_code, reason = "a handler of a signal")]
    let before = unsafe { sigaction(signal, &action) };
    Ok(before.with_context(|| format!("cannot catch {signal}"))?.handler())
}
