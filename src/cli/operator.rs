//! The operator of a real drive: arms and stops it by the terminal, and on localhost.

use std::io::{self, IsTerminal, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, ensure};
use inbye::base::OperatorSwitch;
use serde_json::json;

use super::output;

/// Longest head of a request, bytes, and its longest time.
const MAX_HEAD: usize = 4096;
const REQUEST_TIME: Duration = Duration::from_millis(500);

/// Time before the prompt in which lines that were typed already are read and dropped.
const DISCARD_TIME: Duration = Duration::from_millis(300);

/// Time to the next attempt after the end of the terminal's input, or while the program is in the background.
const RETRY_TIME: Duration = Duration::from_millis(200);

/// Refuses a drive without any means to arm the robot.
pub fn require_arming(armed: bool, port: Option<u16>) -> anyhow::Result<()> {
    ensure!(
        armed || port.is_some() || io::stdin().is_terminal(),
        "--port: nothing moves before an operator arms the robot: add --arm, or --operator-port N, or run it in a terminal"
    );
    Ok(())
}

/// Arms the robot if requested, and connects the operator to the switch. Enter in the terminal stops the robot, the word `arm`
/// arms it; a port of localhost takes requests.
pub fn serve(switch: &OperatorSwitch, armed: bool, port: Option<u16>) -> anyhow::Result<()> {
    if let Some(port) = port {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))
            .with_context(|| format!("--operator-port {port}"))?;
        let switch = switch.clone();
        thread::Builder::new().name("operator".to_owned()).spawn(move || {
            listener.incoming().flatten().for_each(|stream| answer(&stream, &switch));
        })?;
    }
    if io::stdin().is_terminal() {
        let listens = Arc::new(AtomicBool::new(false));
        let terminal = Terminal { switch: switch.clone(), listens: Arc::clone(&listens) };
        thread::Builder::new().name("terminal".to_owned()).spawn(move || terminal.run())?;
        thread::sleep(DISCARD_TIME);
        output::note(if armed {
            "armed: press Enter to stop the robot"
        } else {
            "not armed: type arm and press Enter to arm the robot; Enter alone stops it"
        });
        listens.store(true, Ordering::Relaxed);
    }
    if armed {
        switch.arm();
    }
    Ok(())
}

/// The terminal of the operator.
struct Terminal {
    switch: OperatorSwitch,
    /// Whether the prompt has been shown: a line typed before it is no command.
    listens: Arc<AtomicBool>,
}

impl Terminal {
    /// Reads lines as long as the program runs. The end of the input is not an order: the terminal may give more lines.
    fn run(self) {
        // With the signal blocked, a read in the background is an error; else it would suspend the program, and the base with it.
        #[cfg(unix)]
        {
            use nix::sys::signal::{SigSet, Signal};
            if (SigSet::empty() | Signal::SIGTTIN).thread_block().is_err() {
                return;
            }
        }
        let mut line = String::new();
        loop {
            match io::stdin().read_line(&mut line) {
                Ok(count) if count > 0 => {
                    if self.listens.load(Ordering::Relaxed) {
                        output::note(obey(&line, &self.switch));
                    }
                }
                _ => thread::sleep(RETRY_TIME),
            }
            line.clear();
        }
    }
}

/// Obeys a line of the operator, and returns the answer. Only the word `arm` arms; every other line stops, so that a typing
/// error is safe.
fn obey(line: &str, switch: &OperatorSwitch) -> &'static str {
    if line.trim() == "arm" {
        switch.arm();
        "armed: press Enter to stop the robot"
    } else {
        switch.stop();
        "stopped by the operator: type arm and press Enter to arm the robot again"
    }
}

/// Answers one request. A client that is slow or sends too much is dropped.
fn answer(stream: &TcpStream, switch: &OperatorSwitch) {
    let Some(head) = read_head(stream) else {
        return;
    };
    // A page of another site in a browser must not arm a robot.
    let is_foreign = head.to_ascii_lowercase().contains("\norigin:");
    let mut words = head.split_whitespace();
    let status = match (words.next(), words.next()) {
        (Some("POST"), Some("/stop")) => {
            switch.stop();
            "200 OK"
        }
        (Some("POST"), Some("/arm")) if is_foreign => "403 Forbidden",
        (Some("POST"), Some("/arm")) => {
            switch.arm();
            "200 OK"
        }
        (Some("GET"), Some("/status")) => "200 OK",
        _ => "404 Not Found",
    };
    let body = json!({ "state": switch.state().name() }).to_string();
    let length = body.len();
    let mut stream = stream;
    // A client that has gone needs no answer.
    let _ = write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: application/json\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n{body}"
    );
}

/// Reads the head of a request; none if it does not come whole in time.
fn read_head(mut stream: &TcpStream) -> Option<String> {
    let end = Instant::now() + REQUEST_TIME;
    let mut head = Vec::new();
    let mut bytes = [0; 512];
    while !head.windows(4).any(|end| end == b"\r\n\r\n") {
        let left = end.checked_duration_since(Instant::now()).filter(|left| !left.is_zero())?;
        stream.set_read_timeout(Some(left)).ok()?;
        let count = stream.read(&mut bytes).ok().filter(|count| *count > 0)?;
        head.extend_from_slice(bytes.get(..count)?);
        if head.len() > MAX_HEAD {
            return None;
        }
    }
    stream.set_write_timeout(Some(REQUEST_TIME)).ok()?;
    String::from_utf8(head).ok()
}

#[cfg(test)]
mod tests {
    use inbye::base::{OperatorState, OperatorSwitch};

    use super::obey;

    #[test]
    fn only_the_word_arms_and_every_other_line_stops() {
        let switch = OperatorSwitch::default();
        obey("arm\n", &switch);
        assert_eq!(switch.state(), OperatorState::Armed);
        // A double press stops and does not arm again.
        for line in ["\n", "\n", "\n", "stop\n", "ar\n", "arm arm\n", ""] {
            obey(line, &switch);
            assert_eq!(switch.state(), OperatorState::Stopped, "{line:?}");
        }
        obey(" arm \r\n", &switch);
        obey("arm\n", &switch);
        assert_eq!(switch.state(), OperatorState::Armed);
        obey("\n", &switch);
        assert_eq!(switch.state(), OperatorState::Stopped);
    }
}
