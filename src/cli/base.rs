//! `inbye base`: sends one motion to a base, or monitors it.

use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use anyhow::Context;
use clap::{Args, Subcommand};
use inbye::base::{
    BaseSupervisor, DriveStatus, Feedback, Protocol, ScheduledFault, SupervisorStatus,
};
use inbye::geometry::Twist;
use inbye::runtime::hardware::{SerialLine, stop_cause};
use serde_json::{Value, json};

use super::arguments::{Place, duration, protocol, real, whole};
use super::base_calibrate::CalibrateArguments;
use super::emulated_person::EmulatedPerson;
use super::machine::interrupt_flag;
use super::map_file::Resolution;
use super::{config, output};

/// Largest speed accepted, m/s and rad/s; the base's own limits apply in any case.
const MAX_SPEED: f64 = 100.0;

/// Time between polls of a supervisor.
const POLL_PERIOD: Duration = Duration::from_millis(20);

/// Time between lines of a monitor.
const LINE_PERIOD: Duration = Duration::from_millis(100);

/// Speed below which a base stands, m/s and rad/s.
const STANDSTILL: f64 = 0.01;

/// Warning about a pose and a distance that lack a motion.
pub const UNCERTAIN_ODOMETRY: &str = "the encoder counts jumped or were reset, or no speeds were reported for a time: the pose by \
    odometry and the distance lack the motion of that time";

/// `inbye base`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye base emulate --protocol native --for 1 --json\n\n\
    Run `inbye base emulate` in one terminal: it prints the path of a port. Then run `inbye base monitor --port PATH`, \
    `inbye base send --port PATH` or `inbye drive --port PATH` in another.")]
pub struct BaseArguments {
    /// The subcommand.
    #[command(subcommand)]
    pub command: BaseCommand,
}

impl BaseArguments {
    /// Whether the command opens the line of a base.
    pub const fn opens_line(&self) -> bool {
        !matches!(self.command, BaseCommand::Emulate(_))
    }
}

/// Subcommands of `inbye base`.
#[derive(Debug, Subcommand)]
pub enum BaseCommand {
    /// Emulate a base: a lower controller with its machine on a pseudo-terminal.
    Emulate(EmulateArguments),
    /// Command a motion for a time, then stop the base.
    Send(SendArguments),
    /// Hold a base still and print its reports.
    Monitor(MonitorArguments),
    /// Turn a base on the spot, drive it a metre, and print the settings that follow.
    Calibrate(CalibrateArguments),
}

/// Protocol and settings of a base.
#[derive(Debug, Args)]
pub struct KindArguments {
    /// Protocol.
    #[arg(long, value_name = "P", default_value = "native", value_parser = protocol())]
    pub protocol: Protocol,
    /// The base's settings, TOML with the tables [base], [supervisor] and [lidar].
    #[arg(long, value_name = "FILE.toml")]
    pub base_config: Option<PathBuf>,
}

/// `inbye base emulate`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye base emulate --protocol roboclaw --fault stuck-left@0.5 --for 1 --json\n\n\
    The first line is the path of the port for the host, or with --json an object with `port` and `protocol`. The last line, after \
    Ctrl-C, SIGTERM or --for, is a summary: `commands` (accepted), `final_zero_commands` (consecutive zero commands at \
    the end), `watchdog_stops`, `zero_commands_after_watchdog`, `travelled_m`, `pose`, `linear`, `angular`, `last_motion_s`, \
    `standstills` (begin and end of each standstill of 0.2 s or more, seconds), `bytes_after_replacement`, `time_s`.\n\
    With --lidar-map and --start the second line is the port of the lidar, `lidar` in the object. The summary then has `map_pose`, \
    `min_gap_m`, `robot_touched`, `person_touched` (whose motion closed a gap) and `parking_from_s`.\n\
    Faults of the base: stuck-left, stuck-right, runaway, reversed, ignored-commands, ignored-turns, late-motors, button, \
    stop-glitch, bumper, cliff, tilt, bogged, encoder-stuck, gyro-biased, low-battery, wedge, reboot. Of the line: silence, \
    slow-reads, garbage, bit-flips, corrupt-reports, line-cut, port-replaced. Of the lidar: lidar-frozen, lidar-blind, \
    lidar-sector-blind, lidar-late, lidar-corrupt, lidar-bit-flips, lidar-stalled, lidar-silent. With --carry-to: carried. \
    NAME@2 begins after 2 s; NAME@2..3.5 also ends after 3.5 s. Unix only."
)]
pub struct EmulateArguments {
    #[command(flatten)]
    pub kind: KindArguments,
    /// A fault with its times in seconds; repeat --fault for each.
    #[arg(long, value_name = "NAME[@S[..S]]")]
    pub fault: Vec<ScheduledFault>,
    /// Also emulate an LD19 lidar, on its own port, in the world of this map.
    #[arg(long, value_name = "MAP")]
    pub lidar_map: Option<PathBuf>,
    #[command(flatten)]
    pub resolution: Resolution,
    /// Start pose on that map.
    #[arg(long, value_name = "X,Y[,YAW]", allow_hyphen_values = true, requires = "lidar_map")]
    pub start: Option<Place>,
    /// A person of 0.3 m radius who appears S seconds after power-on, GAP metres ahead of the robot and LEFT of its axis. With a
    /// SPEED the person walks across once, after WAIT seconds. Repeat --person for each.
    #[arg(
        long,
        value_name = "GAP[,LEFT[,SPEED[,WAIT]]]@S",
        allow_hyphen_values = true,
        requires = "lidar_map"
    )]
    pub person: Vec<EmulatedPerson>,
    /// Place on that map to which the fault `carried` moves the robot.
    #[arg(long, value_name = "X,Y[,YAW]", allow_hyphen_values = true, requires = "lidar_map")]
    pub carry_to: Option<Place>,
    /// The drive's goal on that map: `parking_from_s` is the time at which the robot is first within 0.25 m of it.
    #[arg(long, value_name = "X,Y[,YAW]", allow_hyphen_values = true, requires = "lidar_map")]
    pub goal: Option<Place>,
    /// Unplug the lidar after this time, seconds.
    #[arg(long, value_name = "S", allow_negative_numbers = true, requires = "lidar_map", value_parser = duration)]
    pub lidar_until: Option<f64>,
    /// Further lag of the motors, a time constant in seconds.
    #[arg(long, default_value_t = 0.0, value_name = "S", allow_negative_numbers = true, value_parser = real(0.0..=10.0, "seconds, 0 to 10"))]
    pub motor_lag: f64,
    /// True effective track width divided by that of the settings: above 1 the base turns less than its tracks indicate.
    #[arg(long, default_value_t = 1.0, value_name = "RATIO", allow_negative_numbers = true, value_parser = real(0.5..=5.0, "0.5 to 5"))]
    pub width_ratio: f64,
    /// Mean share of the travel of each track that is lost on the ground. It varies by the seed.
    #[arg(long, default_value_t = 0.0, value_name = "SHARE", allow_negative_numbers = true, value_parser = real(0.0..=0.5, "0 to 0.5"))]
    pub slip: f64,
    /// Set speed of a track below which its motor stands, m/s.
    #[arg(long, default_value_t = 0.0, value_name = "V", allow_negative_numbers = true, value_parser = real(0.0..=1.0, "m/s, 0 to 1"))]
    pub deadband: f64,
    /// Seed of noise and faults.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true, value_parser = whole::<u64>(0, u64::MAX))]
    pub seed: u64,
    /// End after this time, seconds [default: at Ctrl-C].
    #[arg(long = "for", value_name = "S", allow_negative_numbers = true, value_parser = duration)]
    pub for_s: Option<f64>,
}

/// Port, protocol and settings of a base.
#[derive(Debug, Args)]
pub struct LineArguments {
    /// The port, such as /dev/ttyUSB0 or COM3.
    #[arg(long, value_name = "P")]
    pub port: String,
    #[command(flatten)]
    pub kind: KindArguments,
}

/// `inbye base send`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye base send --port /dev/ttyUSB0 --protocol wheeltec --linear 0.2 --for 2\n\n\
    The motion is ramped up, sent 50 times per second, and ramped down at the end. The base is stopped, with the reason, when it \
    does not follow its commands: a track that is stuck, runs away or runs in reverse, slip, delayed commands, an emergency \
    stop, a fault. An error and every signal that ends or suspends a program, such as Ctrl-C and Ctrl-Z, end with zero commands until \
    the base stands; after a second at most, a base that still moves is an error. After a SIGKILL or with a cut cable only the base's own watchdog acts, which WHEELTEC's published firmware does not have.\n\
    Exit status 1: the base was stopped, the connection was lost, or a signal came."
)]
pub struct SendArguments {
    #[command(flatten)]
    pub line: LineArguments,
    /// Forward speed, m/s.
    #[arg(long, default_value_t = 0.0, value_name = "V", allow_negative_numbers = true, value_parser = real(-MAX_SPEED..=MAX_SPEED, "m/s or rad/s, -100 to 100"))]
    pub linear: f64,
    /// Turn rate, rad/s, counter-clockwise.
    #[arg(long, default_value_t = 0.0, value_name = "W", allow_negative_numbers = true, value_parser = real(-MAX_SPEED..=MAX_SPEED, "m/s or rad/s, -100 to 100"))]
    pub angular: f64,
    /// Duration, seconds.
    #[arg(long = "for", value_name = "S", default_value_t = 1.0, allow_negative_numbers = true, value_parser = duration)]
    pub for_s: f64,
    /// Release a stop that is latched in the base first.
    #[arg(long)]
    pub release: bool,
}

/// `inbye base monitor`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye base monitor --port /dev/ttyUSB0 --protocol roboclaw --json\n\n\
    Prints ten lines per second; with --json each is an object. The base gets zero commands throughout: queries alone keep the \
    watchdog of some controllers from acting, so that they would follow their last command.\n\
    Exit status 1: the base is silent at the end. A signal, such as Ctrl-C, is its normal end."
)]
pub struct MonitorArguments {
    #[command(flatten)]
    pub line: LineArguments,
    /// End after this time, seconds [default: at Ctrl-C].
    #[arg(long = "for", value_name = "S", allow_negative_numbers = true, value_parser = duration)]
    pub for_s: Option<f64>,
}

/// Returns a base with the settings of a file, or with the default ones.
pub fn load_line(
    port: &str,
    protocol: Protocol,
    file: Option<&Path>,
) -> anyhow::Result<SerialLine> {
    Ok(SerialLine {
        port: port.to_owned(),
        protocol,
        config: config::load_base("--base-config", file)?,
    })
}

/// Opens a base's line and waits for its first report.
pub fn open(arguments: &LineArguments) -> anyhow::Result<(SerialLine, BaseSupervisor)> {
    let (line, supervisor) = connect(arguments)?;
    line.await_report(&supervisor).context("--port")?;
    Ok((line, supervisor))
}

/// Opens a base's line, without a report yet.
fn connect(arguments: &LineArguments) -> anyhow::Result<(SerialLine, BaseSupervisor)> {
    let kind = &arguments.kind;
    let line = load_line(&arguments.port, kind.protocol, kind.base_config.as_deref())?;
    line.warning().iter().for_each(output::warn);
    let supervisor = line.supervise(interrupt_flag()?).context("--port")?;
    Ok((line, supervisor))
}

/// Commands a motion. Returns false if the base was stopped before the time was over.
pub fn send(arguments: &SendArguments) -> anyhow::Result<bool> {
    let (line, supervisor) = connect(&arguments.line)?;
    if arguments.release {
        // No motion was commanded yet, so this fails only for a base that moves by itself.
        supervisor.release()?;
    }
    line.await_report(&supervisor).context("--port")?;
    let asked = Twist::new(arguments.linear, arguments.angular);
    // The supervisor limits every target likewise.
    let base = line.base();
    let twist = base.limit(&asked)?;
    if twist != asked {
        let (linear, angular) = (arguments.linear, arguments.angular);
        let max_track_speed = base.tracks.max_track_speed;
        output::warn(format!(
            "a track drives at most {max_track_speed} m/s (max_track_speed in [base.tracks]): the base drives {:.2} m/s and {:.2} rad/s, \
            not {linear:.2} m/s and {angular:.2} rad/s",
            twist.linear, twist.angular
        ));
    }
    let tracks = line.config.base.drive().tracks(&twist);
    let moving = line.config.base.tracks.apply_deadband(&tracks);
    if moving != tracks {
        let deadband = line.config.base.tracks.deadband;
        let moving = line.config.base.drive().twist(&moving);
        output::warn(format!(
            "a track slower than {deadband} m/s stands (deadband in [base.tracks]): the base drives {:.2} m/s and {:.2} rad/s",
            moving.linear, moving.angular
        ));
    }
    output::note(format!(
        "the base answers: {:.2} m/s and {:.2} rad/s for {} s",
        twist.linear, twist.angular, arguments.for_s
    ));
    let start_s = supervisor.now_s();
    drive_while(&supervisor, &twist, |supervisor, _| {
        supervisor.now_s() - start_s < arguments.for_s
    });
    let driven_s = supervisor.now_s() - start_s;
    // The ramp first: the end of the supervisor commands zero at once.
    drive_while(&supervisor, &Twist::STOP, |_, status| !status.sent.is_below(STANDSTILL));
    let status = supervisor.end();
    if status.is_odometry_uncertain {
        output::warn(UNCERTAIN_ODOMETRY);
    }
    let interrupted = !status.is_running;
    let stopped = stop_cause(&status);
    let done = stopped.is_none() && !interrupted;
    let mut object = line_object(&line, &status);
    object["time_s"] = json!(driven_s);
    object["interrupted"] = json!(interrupted);
    let outcome = match (&stopped, interrupted) {
        (Some(why), _) => format!("stopped: {why}"),
        (None, true) => "stopped by a signal".to_owned(),
        (None, false) => "done".to_owned(),
    };
    let (travelled_m, commands) = (status.travelled_m, status.counters.commands);
    let summary = format!("{outcome}; {travelled_m:.2} m in {driven_s:.1} s, {commands} commands");
    let feedback = status.feedback.as_ref().map(feedback_line);
    output::result(&object, [summary].into_iter().chain(feedback))?;
    Ok(done)
}

/// Commands a motion while a condition holds, no stop is latched and the supervisor runs.
pub fn drive_while(
    supervisor: &BaseSupervisor,
    twist: &Twist,
    mut holds: impl FnMut(&BaseSupervisor, &SupervisorStatus) -> bool,
) {
    loop {
        let status = supervisor.status();
        if status.stop_cause.is_some() || !status.is_running || !holds(supervisor, &status) {
            return;
        }
        // A rejection means that a stop was just latched: the next poll sees it.
        let _ = supervisor.set_target(twist, supervisor.now_s());
        thread::sleep(POLL_PERIOD);
    }
}

/// Whether the base stands and is commanded to.
pub fn is_still(status: &SupervisorStatus) -> bool {
    let reported = status.feedback.as_ref().map(|feedback| feedback.twist);
    status.sent.is_below(STANDSTILL) && reported.is_none_or(|twist| twist.is_below(STANDSTILL))
}

/// Prints a base's reports. Returns false if the base is silent at the end.
pub fn monitor(arguments: &MonitorArguments) -> anyhow::Result<bool> {
    let (_, supervisor) = open(&arguments.line)?;
    let start_s = supervisor.now_s();
    loop {
        let time_s = supervisor.now_s() - start_s;
        let status = supervisor.status();
        let over = arguments.for_s.is_some_and(|for_s| time_s >= for_s);
        if over || !status.is_running {
            return Ok(status.feedback.is_some());
        }
        let mut object = status_object(&status);
        object["time_s"] = json!(time_s);
        let text = status.feedback.as_ref().map_or_else(|| drive_status(&status), feedback_line);
        output::result(&object, [format!("{time_s:7.1} s  {text}")])?;
        thread::sleep(LINE_PERIOD);
    }
}

/// A report of a base as JSON.
fn feedback_object(feedback: &Feedback) -> Value {
    json!({
        "linear": feedback.twist.linear,
        "angular": feedback.twist.angular,
        "encoder_counts": feedback.encoder_counts,
        "yaw_rate": feedback.yaw_rate,
        "battery_v": feedback.battery_v,
        "emergency_stop": feedback.emergency_stop,
        "faults": feedback.faults.to_string(),
        "command_delay_s": feedback.command_delay_s,
        "tilt": feedback.tilt.map(|tilt| [tilt.roll, tilt.pitch]),
        "bumper": feedback.bumper.is_pressed(),
        "cliff": feedback.cliff,
    })
}

/// The status of a base on a serial line as JSON.
pub fn line_object(line: &SerialLine, status: &SupervisorStatus) -> Value {
    let mut object = status_object(status);
    object["port"] = json!(line.port);
    object["protocol"] = json!(line.protocol.name());
    object
}

/// The supervisor's status as JSON.
fn status_object(status: &SupervisorStatus) -> Value {
    json!({
        "drive_status": drive_status(status),
        "stop_cause": stop_cause(status),
        "feedback": status.feedback.as_ref().map(feedback_object),
        "pose": status.pose,
        "travelled_m": status.travelled_m,
        "odometry_uncertain": status.is_odometry_uncertain,
        "counters": status.counters,
        "last_failure": status.last_failure.as_ref().map(ToString::to_string),
    })
}

/// What the base is commanded to do, and why.
fn drive_status(status: &SupervisorStatus) -> String {
    // The status may be older than the stop.
    if let Some(reason) = &status.stop_cause {
        return format!("stopped: {reason}");
    }
    match &status.drive_status {
        DriveStatus::NoTarget => "stands".to_owned(),
        DriveStatus::Driving => {
            format!("drives {:.2} m/s, {:.2} rad/s", status.sent.linear, status.sent.angular)
        }
        DriveStatus::TargetExpired { age_s } => {
            format!("stands: the target is {age_s:.2} s old")
        }
        DriveStatus::Restarting => "stands: it waits for a new target after a gap".to_owned(),
        DriveStatus::ReportsLate { age_s } => {
            format!("stands: the last report is {age_s:.2} s old")
        }
        DriveStatus::AwaitingFeedback => "stands: it has not answered yet".to_owned(),
        DriveStatus::Disconnected(why) => why.to_string(),
        DriveStatus::Protected(action) => format!("protected: {action}"),
        DriveStatus::Stopped(reason) => format!("stopped: {reason}"),
    }
}

/// A report of a base as a line of text.
fn feedback_line(feedback: &Feedback) -> String {
    let mut parts =
        vec![format!("{:6.3} m/s  {:6.3} rad/s", feedback.twist.linear, feedback.twist.angular)];
    if let Some(counts) = feedback.encoder_counts {
        parts.push(format!("encoders {} {}", counts.left, counts.right));
    }
    if let Some(rate) = feedback.yaw_rate {
        parts.push(format!("gyro {rate:6.3} rad/s"));
    }
    if let Some(volts) = feedback.battery_v {
        parts.push(format!("{volts:.1} V"));
    }
    if let Some(tilt) = feedback.tilt {
        parts.push(format!("roll {:5.2} pitch {:5.2} rad", tilt.roll, tilt.pitch));
    }
    for (shows, text) in [
        (feedback.emergency_stop, "EMERGENCY STOP"),
        (feedback.bumper.is_pressed(), "BUMPER"),
        (feedback.cliff, "CLIFF"),
    ] {
        if shows {
            parts.push(text.to_owned());
        }
    }
    if !feedback.faults.is_empty() {
        parts.push(format!("faults: {}", feedback.faults));
    }
    parts.join("  ")
}
