//! The operator of a real drive: arms and stops it by the terminal and on localhost, and stops it by a signal.

use std::io::{self, IsTerminal};
use std::net::{Ipv4Addr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use anyhow::{Context, ensure};
use inbye::base::OperatorSwitch;

#[cfg(unix)]
use super::stop_signals::take_stop_signal;
use super::{operator_port, output};

/// Time before the prompt in which lines that were typed already are read and dropped.
const DISCARD_TIME: Duration = Duration::from_millis(300);

/// Time to the next attempt after the end of the terminal's input, or while the program is in the background.
const RETRY_TIME: Duration = Duration::from_millis(200);

/// Time between two looks for the stop signal: a fraction of the period of the commands.
#[cfg(unix)]
const SIGNAL_POLL: Duration = Duration::from_millis(5);

/// The note of a stop.
const STOPPED: &str = "stopped by the operator: type arm and press Enter to arm the robot again";

/// Refuses a drive without any means to arm the robot.
pub fn require_arming(armed: bool, port: Option<u16>) -> anyhow::Result<()> {
    ensure!(
        armed || port.is_some() || io::stdin().is_terminal(),
        "--port: nothing moves before an operator arms the robot: add --arm, or --operator-port N, or run it in a terminal"
    );
    Ok(())
}

/// Arms the robot if requested, and connects the operator to the switch. Enter in the terminal stops the robot, the word `arm`
/// arms it; a port of localhost takes requests; SIGUSR1 stops it.
pub fn serve(switch: &OperatorSwitch, armed: bool, port: Option<u16>) -> anyhow::Result<()> {
    if let Some(port) = port {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))
            .with_context(|| format!("--operator-port {port}"))?;
        let switch = switch.clone();
        thread::Builder::new().name("operator".to_owned()).spawn(move || {
            operator_port::serve(&listener, &switch);
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
    // A signal that came before is newer than the arming.
    #[cfg(unix)]
    {
        let switch = switch.clone();
        thread::Builder::new()
            .name("stop signal".to_owned())
            .spawn(move || obey_signals(&switch))?;
    }
    Ok(())
}

/// Stops the robot at each SIGUSR1.
#[cfg(unix)]
fn obey_signals(switch: &OperatorSwitch) -> ! {
    loop {
        if take_stop_signal() {
            switch.stop();
            output::note(STOPPED);
        }
        thread::sleep(SIGNAL_POLL);
    }
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
        STOPPED
    }
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
