//! `inbye-controller-host LIBRARY`: lets a controller in a shared library decide, as a program that speaks inbye's protocol.
//!
//! The library runs in a separate process: if it crashes, the run fails, but inbye continues.
//!
//! ```sh
//! inbye drive --scene mine --controller "inbye-controller-host ./libmy_controller.so"
//! ```

#[path = "../abi.rs"]
mod abi;
mod interface;
mod library;
mod messages;

use std::io::{self, BufRead, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use library::Library;
use messages::{Message, Ready};

const HELP: &str = "\
Usage: inbye-controller-host LIBRARY

Lets a controller in a shared library decide the velocities of a robot: inbye starts this program. inbye.h declares the functions
of the library.

  inbye drive --scene mine --controller \"inbye-controller-host ./libmy_controller.so\"

Options: --help, --version";
/// Number of the protocol.
const PROTOCOL: u32 = inbye::external::PROTOCOL;

fn main() -> ExitCode {
    match serve() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(io::stderr(), "inbye-controller-host: {error}");
            ExitCode::from(2)
        }
    }
}

/// Serves as the arguments say.
fn serve() -> Result<(), String> {
    let mut arguments = std::env::args_os().skip(1);
    let (Some(file), None) = (arguments.next(), arguments.next()) else {
        return Err(
            "name one shared library: inbye-controller-host ./libmy_controller.so".to_owned()
        );
    };
    let text = match file.to_str() {
        Some("--help" | "-h") => HELP,
        Some("--version" | "-V") => concat!("inbye-controller-host ", env!("CARGO_PKG_VERSION")),
        _ => return serve_library(&in_working_folder(file.into())),
    };
    print(&mut io::stdout(), text)
}

/// The path of a library. The system looks for a name without a slash in its own folders only: one that exists in the working folder gets
/// the path of it.
fn in_working_folder(file: PathBuf) -> PathBuf {
    if file.components().count() == 1 && file.is_file() { Path::new(".").join(file) } else { file }
}

/// The standard output for the answers. What the library prints there from now on goes to the standard error output.
#[cfg(unix)]
fn answer_stream() -> io::Result<impl Write> {
    use std::os::fd::AsFd;
    let stream = io::stdout().as_fd().try_clone_to_owned()?;
    nix::unistd::dup2_stdout(io::stderr())?;
    Ok(std::fs::File::from(stream))
}

#[cfg(not(unix))]
fn answer_stream() -> io::Result<impl Write> {
    Ok(io::stdout())
}

/// Answers messages by a controller of a library until the input ends.
fn serve_library(file: &Path) -> Result<(), String> {
    let mut out = answer_stream().map_err(|error| error.to_string())?;
    let library = Library::open(file)?;
    let mut controller = None;
    for line in io::stdin().lock().lines() {
        let line = line.map_err(|error| error.to_string())?;
        let message = serde_json::from_str(&line).map_err(|error| format!("message: {error}"))?;
        match message {
            Message::Start(start) => {
                controller = Some(library.controller(&start)?);
                answer(
                    &mut out,
                    &Ready {
                        protocol: PROTOCOL,
                        name: library.name(),
                        wants: ["moving_obstacles"],
                    },
                )?;
            }
            Message::Tick(tick) => {
                let controller = controller.as_mut().ok_or("a tick came before the start")?;
                answer(&mut out, &library.velocity(controller, &tick)?)?;
            }
        }
    }
    Ok(())
}

fn answer(out: &mut impl Write, answer: &impl serde::Serialize) -> Result<(), String> {
    print(out, &serde_json::to_string(answer).map_err(|error| error.to_string())?)
}

fn print(out: &mut impl Write, line: &str) -> Result<(), String> {
    writeln!(out, "{line}").and_then(|()| out.flush()).map_err(|error| error.to_string())
}
