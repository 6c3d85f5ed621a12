//! The environment that graphics drivers read.

/// Starts this program again without Mesa's device selection layer where no display server can run. The layer looks for one, and
/// prints an error for each attempt. Does nothing on a desktop, or where the user set the variable.
#[cfg(unix)]
pub fn silence_device_selection() {
    use std::env;
    use std::os::unix::process::CommandExt;

    use super::invocation;

    const LAYER_OFF: &str = "NODEVICE_SELECT";
    if env::var_os("XDG_RUNTIME_DIR").is_some() || env::var_os(LAYER_OFF).is_some() {
        return;
    }
    // It returns only where the program cannot start; then the messages stay.
    let _ = invocation::program().args(invocation::arguments()).env(LAYER_OFF, "1").exec();
}

#[cfg(not(unix))]
pub fn silence_device_selection() {}
