//! The program as processes: an emulated base and its hosts.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStderr, ChildStdout, Command, ExitStatus, Stdio};

use serde_json::Value;

pub const PROGRAM: &str = env!("CARGO_BIN_EXE_inbye");

/// A run of the program; dropping it kills the process.
pub struct Process {
    child: Child,
    stdout: BufReader<ChildStdout>,
    stderr: BufReader<ChildStderr>,
}

/// The result of a run.
#[derive(Debug)]
pub struct Ended {
    pub status: ExitStatus,
    pub stdout: String,
    pub stderr: String,
}

impl Ended {
    /// The JSON object on standard output.
    pub fn object(&self) -> Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|_| panic!("no object: {self:?}"))
    }
}

/// A number of an object by its name.
#[track_caller]
pub fn number(object: &Value, name: &str) -> f64 {
    object[name].as_f64().unwrap_or_else(|| panic!("{name} in {object}"))
}

impl Process {
    /// Starts the program with arguments separated by spaces.
    pub fn start(arguments: &str) -> Self {
        let mut command = Command::new(PROGRAM);
        command.args(arguments.split_whitespace());
        Self::of(command)
    }

    pub fn of(mut command: Command) -> Self {
        let mut child = command
            .env("VK_DRIVER_FILES", "/nonexistent")
            .env("VK_ICD_FILENAMES", "/nonexistent")
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let stdout = BufReader::new(child.stdout.take().expect("piped"));
        let stderr = BufReader::new(child.stderr.take().expect("piped"));
        Self { child, stdout, stderr }
    }

    /// The next line of standard output.
    pub fn line(&mut self) -> String {
        let mut line = String::new();
        self.stdout.read_line(&mut line).expect("text");
        line.trim().to_owned()
    }

    /// Waits for a line on standard error that contains words.
    #[track_caller]
    pub fn await_note(&mut self, words: &str) {
        let mut all = String::new();
        while !all.contains(words) {
            let read = self.stderr.read_line(&mut all).expect("text");
            assert!(read > 0, "no {words:?} in: {all}");
        }
    }

    /// Sends a signal by its name, such as INT.
    pub fn signal(&self, name: &str) {
        let sent = Command::new("kill").args(["-s", name, &self.child.id().to_string()]).status();
        assert!(sent.expect("`kill` is installed").success());
    }

    /// Waits for the end of the process.
    pub fn wait(mut self) -> Ended {
        let (mut stdout, mut stderr) = (String::new(), String::new());
        self.stdout.read_to_string(&mut stdout).expect("text");
        self.stderr.read_to_string(&mut stderr).expect("text");
        let status = self.child.wait().expect("it ends");
        Ended { status, stdout, stderr }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// An emulated base in its own process.
pub struct Emulated {
    process: Process,
    pub port: String,
    /// Port of its lidar, if it has one.
    pub lidar: Option<String>,
    pub protocol: &'static str,
}

impl Emulated {
    pub fn start(protocol: &'static str, more: &str) -> Self {
        let mut process =
            Process::start(&format!("base emulate --protocol {protocol} --for 600 --json {more}"));
        let ports: Value = serde_json::from_str(&process.line()).expect("an object");
        Self {
            process,
            port: ports["port"].as_str().expect("a path").to_owned(),
            lidar: ports["lidar"].as_str().map(str::to_owned),
            protocol,
        }
    }

    /// Starts the program with arguments, on this base's port.
    pub fn host(&self, arguments: &str) -> Process {
        Process::start(&self.on_line(arguments))
    }

    pub fn on_line(&self, arguments: &str) -> String {
        format!("{arguments} --port {} --protocol {} --json", self.port, self.protocol)
    }

    /// Ends the base and returns its summary.
    pub fn end(self) -> Value {
        self.process.signal("TERM");
        let ended = self.process.wait();
        assert!(ended.status.success(), "{ended:?}");
        ended.object()
    }
}
