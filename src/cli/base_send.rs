//! `inbye base send`.

use std::thread;

use anyhow::Context;
use inbye::base::{BaseSupervisor, SupervisorStatus};
use inbye::geometry::Twist;
use inbye::runtime::hardware::stop_cause;
use serde_json::json;

use super::base_arguments::POLL_PERIOD;
use super::base_arguments::SendArguments;
use super::{base_arguments, base_text, output, process};

/// Speed below which a base stands, m/s and rad/s.
const STANDSTILL: f64 = 0.01;

/// Time beyond the ramp for a base to come to a standstill, seconds.
const SETTLING_S: f64 = 1.0;

/// Commands a motion. Returns false if the base was stopped before the time was over.
pub fn run(arguments: &SendArguments, json: bool) -> anyhow::Result<bool> {
    let line = base_arguments::line_of(&arguments.line)?;
    let supervisor = line.supervise(process::interrupt_flag()?).context("--port")?;
    if arguments.release {
        // No motion was commanded yet, so this fails only for a base that moves by itself.
        supervisor.release()?;
    }
    line.await_report(&supervisor).context("--port")?;
    let twist = Twist::new(arguments.linear, arguments.angular);
    output::note(format!(
        "the base answers: {:.2} m/s and {:.2} rad/s for {} s",
        twist.linear, twist.angular, arguments.for_s
    ));
    let start_s = supervisor.now_s();
    drive_while(&supervisor, &twist, |supervisor, _| {
        supervisor.now_s() - start_s < arguments.for_s
    });
    let driven_s = supervisor.now_s() - start_s;
    let tracks = line.config.base.tracks;
    let latest_s = supervisor.now_s() + tracks.max_stopping_time_s() + SETTLING_S;
    drive_while(&supervisor, &Twist::STOP, |supervisor, status| {
        supervisor.now_s() < latest_s && !is_still(status)
    });
    let status = supervisor.status();
    drop(supervisor);
    let interrupted = !status.is_running;
    let stopped = stop_cause(&status);
    let done = stopped.is_none() && !interrupted;
    if json {
        let mut object = base_text::status(&status);
        object["port"] = json!(line.port);
        object["protocol"] = json!(line.protocol.name());
        object["time_s"] = json!(driven_s);
        object["interrupted"] = json!(interrupted);
        output::json(&object)?;
        return Ok(done);
    }
    let outcome = match (&stopped, interrupted) {
        (Some(why), _) => format!("stopped: {why}"),
        (None, true) => "stopped by a signal".to_owned(),
        (None, false) => "done".to_owned(),
    };
    output::line(format!(
        "{outcome}; {:.2} m in {driven_s:.1} s, {} commands",
        status.travelled_m, status.counters.commands
    ));
    if let Some(feedback) = &status.feedback {
        output::line(base_text::line(feedback));
    }
    Ok(done)
}

/// Commands a motion while a condition holds, no stop is latched and the supervisor runs.
fn drive_while(
    supervisor: &BaseSupervisor,
    twist: &Twist,
    holds: impl Fn(&BaseSupervisor, &SupervisorStatus) -> bool,
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
fn is_still(status: &SupervisorStatus) -> bool {
    let stands =
        |twist: &Twist| twist.linear.abs() < STANDSTILL && twist.angular.abs() < STANDSTILL;
    let reported = status.feedback.as_ref().map(|feedback| feedback.twist);
    stands(&status.sent) && reported.is_none_or(|twist| stands(&twist))
}
