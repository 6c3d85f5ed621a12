//! The operator of a real drive: arms and stops it by the terminal and on localhost, and stops it by a signal.

use std::io::{self, IsTerminal};
use std::net::{Ipv4Addr, TcpListener};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use anyhow::ensure;
use inbye::base::OperatorSwitch;
use inbye::geometry::Pose;
use inbye::runtime::TickEvent;
use serde_json::{Value, json};

use super::refusal::refused;
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

/// Refuses a drive without any means to arm the robot.
pub fn require_arming(armed: bool, port: Option<u16>) -> anyhow::Result<()> {
    ensure!(
        armed || port.is_some() || io::stdin().is_terminal(),
        "--port: nothing moves before an operator arms the robot: add --arm, or --operator-port N, or run it in a terminal"
    );
    Ok(())
}

/// The operator's switch, with the means to use it.
#[derive(Clone, Debug, Default)]
pub struct Operator {
    pub switch: OperatorSwitch,
    has_terminal: bool,
    /// The port on localhost.
    port: Option<u16>,
    /// The state of the drive; none before its first tick.
    progress: Arc<Mutex<Option<Value>>>,
}

impl Operator {
    /// Keeps the state of the drive in a tick for requests. The distance to the goal is in metres, along a straight line.
    pub fn show(&self, tick: &TickEvent<'_>, goal_distance_m: f64) {
        if self.port.is_none() {
            return;
        }
        let Pose { x, y, yaw } = tick.row.belief;
        *self.progress.lock().unwrap_or_else(PoisonError::into_inner) = Some(json!({
            "time_s": tick.row.time_s,
            "pose": [x, y, yaw],
            "goal_distance_m": goal_distance_m,
            "mode": tick.row.mode.name(),
            "action": tick.protective_action.name(),
            "cause": tick.robot_fault,
        }));
    }

    /// The state of the switch and of the drive.
    pub fn status(&self) -> Value {
        let drive = self.progress.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let mut object = json!({ "state": self.switch.state().name() });
        if let Some(drive) = drive {
            object["drive"] = drive;
        }
        object
    }

    /// Arms the robot, and notes it.
    pub fn arm(&self) {
        self.switch.arm();
        output::note(format!(
            "armed{}",
            self.means(["press Enter", "POST /stop"], "stop the robot")
        ));
    }

    /// Stops the robot, and notes it.
    pub fn stop(&self) {
        self.switch.stop();
        output::note(format!(
            "stopped by the operator{}",
            self.means_to_arm("arm the robot again")
        ));
    }

    fn means_to_arm(&self, purpose: &str) -> String {
        let means = self.means(["type arm and press Enter", "POST /arm"], purpose);
        if means.is_empty() {
            return format!(": start with --operator-port N to {purpose}");
        }
        means
    }

    /// What to do in the terminal and on the port for a purpose; empty if there is neither.
    fn means(&self, [typed, posted]: [&str; 2], purpose: &str) -> String {
        let typed = self.has_terminal.then(|| typed.to_owned());
        let posted = self.port.map(|port| format!("{posted} to localhost:{port}"));
        let means: Vec<String> = typed.into_iter().chain(posted).collect();
        if means.is_empty() {
            return String::new();
        }
        format!(": {} to {purpose}", means.join(" or "))
    }
}

/// Arms the robot if requested, and connects the operator to the switch. Enter in the terminal stops the robot, the word `arm`
/// arms it; a port of localhost takes requests; SIGUSR1 stops it.
pub fn serve(switch: OperatorSwitch, armed: bool, port: Option<u16>) -> anyhow::Result<Operator> {
    let has_terminal = io::stdin().is_terminal();
    let operator = Operator { switch, has_terminal, port, progress: Arc::default() };
    if let Some(port) = port {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(|error| {
            let what = format!("--operator-port {port}: cannot be served");
            refused(what, error, "choose another port, or end the program that uses it")
        })?;
        let operator = operator.clone();
        thread::Builder::new().name("operator".to_owned()).spawn(move || {
            operator_port::serve(&listener, &operator);
        })?;
    }
    let listens = Arc::new(AtomicBool::new(false));
    if has_terminal {
        let terminal = Terminal { operator: operator.clone(), listens: Arc::clone(&listens) };
        thread::Builder::new().name("terminal".to_owned()).spawn(move || terminal.run())?;
        thread::sleep(DISCARD_TIME);
    }
    if armed {
        operator.arm();
    } else if has_terminal || port.is_some() {
        output::note(format!("not armed{}", operator.means_to_arm("arm the robot")));
    }
    listens.store(true, Ordering::Relaxed);
    // A signal that came before is newer than the arming.
    #[cfg(unix)]
    {
        let operator = operator.clone();
        let name = "stop signal".to_owned();
        thread::Builder::new().name(name).spawn(move || obey_signals(&operator))?;
    }
    Ok(operator)
}

/// Stops the robot at each SIGUSR1.
#[cfg(unix)]
fn obey_signals(operator: &Operator) -> ! {
    loop {
        if take_stop_signal() {
            operator.stop();
        }
        thread::sleep(SIGNAL_POLL);
    }
}

/// The terminal of the operator.
struct Terminal {
    operator: Operator,
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
                        obey(&line, &self.operator);
                    }
                }
                _ => thread::sleep(RETRY_TIME),
            }
            line.clear();
        }
    }
}

/// Obeys a line of the operator. Only the word `arm` arms; every other line stops, so that a typing error is safe.
fn obey(line: &str, operator: &Operator) {
    if line.trim() == "arm" {
        operator.arm();
    } else {
        operator.stop();
    }
}

#[cfg(test)]
mod tests {
    use inbye::base::OperatorState;

    use super::*;

    #[test]
    fn only_the_word_arms_and_every_other_line_stops() {
        let operator = Operator::default();
        let obey = |line| {
            obey(line, &operator);
            operator.switch.state()
        };
        assert_eq!(obey("arm\n"), OperatorState::Armed);
        // A double press stops and does not arm again.
        for line in ["\n", "\n", "\n", "stop\n", "ar\n", "arm arm\n", ""] {
            assert_eq!(obey(line), OperatorState::Stopped, "{line:?}");
        }
        obey(" arm \r\n");
        assert_eq!(obey("arm\n"), OperatorState::Armed);
        assert_eq!(obey("\n"), OperatorState::Stopped);
    }

    #[test]
    fn prompts_name_the_means_that_exist() {
        let prompt = |has_terminal, port| {
            Operator { has_terminal, port, ..Operator::default() }.means_to_arm("arm the robot")
        };
        assert_eq!(prompt(true, None), ": type arm and press Enter to arm the robot");
        assert_eq!(prompt(false, Some(8700)), ": POST /arm to localhost:8700 to arm the robot");
        assert_eq!(
            prompt(true, Some(8700)),
            ": type arm and press Enter or POST /arm to localhost:8700 to arm the robot"
        );
        assert!(prompt(false, None).contains("--operator-port"));
    }
}
