//! How this program was started, so that it can start itself again.

use std::env;
use std::ffi::OsString;
use std::process::Command;
use std::sync::OnceLock;

static INVOCATION: OnceLock<Invocation> = OnceLock::new();

/// The words of a command line.
#[derive(Clone, Debug, Default)]
pub struct Invocation {
    /// The program with its own first arguments, such as `python3 -m inbye`; empty for the file of this process.
    pub program: Vec<OsString>,
    /// The arguments.
    pub arguments: Vec<OsString>,
}

impl Invocation {
    /// The command line of this process.
    #[must_use]
    pub fn of_process() -> Self {
        Self { program: Vec::new(), arguments: env::args_os().skip(1).collect() }
    }

    /// Makes this the invocation of the process; the first one stays.
    pub(super) fn set(self) {
        INVOCATION.get_or_init(|| self);
    }
}

fn invocation() -> &'static Invocation {
    INVOCATION.get_or_init(Invocation::of_process)
}

/// The arguments of this program.
pub fn arguments() -> &'static [OsString] {
    &invocation().arguments
}

/// A command that starts this program.
pub fn program() -> Command {
    let Some((program, first)) = invocation().program.split_first() else {
        return Command::new(env::current_exe().unwrap_or_else(|_| "inbye".into()));
    };
    let mut command = Command::new(program);
    command.args(first);
    command
}

/// Whether this process is the program's own file.
#[cfg(feature = "ros2")]
pub fn is_own_file() -> bool {
    invocation().program.is_empty()
}
