//! `inbye base send`.

use std::thread;

use inbye::base::{BaseSupervisor, SupervisorStatus};
use inbye::geometry::Twist;
use serde_json::json;

use super::base_arguments::SendArguments;
use super::base_line::{BaseLine, LOOK};
use super::{base_text, interrupt, output};

/// Slower than this a base stands, m/s and rad/s.
const STILL: f64 = 0.01;

/// Time beyond that of the ramp in which a base comes to a standstill, seconds.
const SETTLING_S: f64 = 1.0;

/// Tells a base a motion. False when it was stopped before the time was over.
pub fn run(arguments: &SendArguments, json: bool) -> anyhow::Result<bool> {
    let line = BaseLine::of(&arguments.line)?;
    let supervisor = line.supervisor(interrupt::flag()?)?;
    if arguments.release {
        // Nothing has moved yet by this supervisor's will, so that only a base that moves by itself refuses.
        supervisor.release()?;
    }
    line.await_answer(&supervisor)?;
    let twist = Twist::new(arguments.linear, arguments.angular);
    output::note(format!(
        "the base answers: {:.2} m/s and {:.2} rad/s for {} s",
        twist.linear, twist.angular, arguments.for_s
    ));
    let began_s = supervisor.now_s();
    plan_while(&supervisor, &twist, |supervisor, _| {
        supervisor.now_s() - began_s < arguments.for_s
    });
    let driven_s = supervisor.now_s() - began_s;
    let tracks = line.settings.base.tracks;
    let latest_s = supervisor.now_s() + tracks.max_stopping_time_s() + SETTLING_S;
    plan_while(&supervisor, &Twist::STOP, |supervisor, status| {
        supervisor.now_s() < latest_s && !is_still(status)
    });
    let status = supervisor.status();
    drop(supervisor);
    let interrupted = !status.is_running;
    let stopped = base_text::stopped(&status);
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
    let ending = match (&stopped, interrupted) {
        (Some(why), _) => format!("stopped: {why}"),
        (None, true) => "stopped by a signal".to_owned(),
        (None, false) => "done".to_owned(),
    };
    output::line(format!(
        "{ending}; {:.2} m in {driven_s:.1} s, {} commands",
        status.travelled_m, status.counters.commands
    ));
    if let Some(feedback) = &status.feedback {
        output::line(base_text::line(feedback));
    }
    Ok(done)
}

/// Plans a motion as long as something holds, no stop is latched, and nobody asks for an end.
fn plan_while(
    supervisor: &BaseSupervisor,
    twist: &Twist,
    holds: impl Fn(&BaseSupervisor, &SupervisorStatus) -> bool,
) {
    loop {
        let status = supervisor.status();
        if status.stop_cause.is_some() || !status.is_running || !holds(supervisor, &status) {
            return;
        }
        // A refusal is a stop that was latched just now, which the next look sees.
        let _ = supervisor.set_target(twist, supervisor.now_s());
        thread::sleep(LOOK);
    }
}

/// Whether the base stands, and is told to.
fn is_still(status: &SupervisorStatus) -> bool {
    let stands = |twist: &Twist| twist.linear.abs() < STILL && twist.angular.abs() < STILL;
    let reported = status.feedback.as_ref().map(|feedback| feedback.twist);
    stands(&status.sent) && reported.is_none_or(|twist| stands(&twist))
}
