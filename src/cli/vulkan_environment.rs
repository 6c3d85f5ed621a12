//! The environment that graphics drivers read.

/// Starts this program again without Mesa's device selection layer where no display server can run. The layer looks for one, and
/// prints an error for each attempt. Does nothing on a desktop, or where the user set the variable.
#[cfg(unix)]
pub fn silence_device_selection() {
    use std::env;
    use std::os::unix::process::CommandExt;
    use std::process::Command;

    const LAYER_OFF: &str = "NODEVICE_SELECT";
    if env::var_os("XDG_RUNTIME_DIR").is_some() || env::var_os(LAYER_OFF).is_some() {
        return;
    }
    if let Ok(program) = env::current_exe() {
        // It returns only where the program cannot start; then the messages stay.
        let mut arguments = env::args_os();
        let mut again = Command::new(program);
        arguments.next().iter().for_each(|name| {
            again.arg0(name);
        });
        let _ = again.args(arguments).env(LAYER_OFF, "1").exec();
    }
}

#[cfg(not(unix))]
pub fn silence_device_selection() {}
