//! `inbye base send`.

use std::thread;

use inbye::base::{Keeper, Status};
use inbye::geometry::Twist;
use serde_json::json;

use super::base_arguments::SendArguments;
use super::base_line::{BaseLine, LOOK};
use super::{base_words, interrupt, output};

/// Slower than this a base stands, m/s and rad/s.
const STILL: f64 = 0.01;

/// Time beyond that of the ramp in which a base comes to a standstill, seconds.
const SETTLING_S: f64 = 1.0;

/// Tells a base a motion. False when it was stopped before the time was over.
pub fn run(arguments: &SendArguments, json: bool) -> anyhow::Result<bool> {
    let line = BaseLine::of(&arguments.line)?;
    let keeper = line.keeper(interrupt::flag()?)?;
    if arguments.release {
        // Nothing has moved yet by this keeper's will, so that only a base that moves by itself refuses.
        keeper.release()?;
    }
    line.await_answer(&keeper)?;
    let twist = Twist::new(arguments.linear, arguments.angular);
    output::note(format!(
        "the base answers: {:.2} m/s and {:.2} rad/s for {} s",
        twist.linear, twist.angular, arguments.for_s
    ));
    let began_s = keeper.now_s();
    plan_while(&keeper, &twist, |keeper, _| {
        keeper.now_s() - began_s < arguments.for_s
    });
    let driven_s = keeper.now_s() - began_s;
    let tracks = line.settings.base.tracks;
    let latest_s = keeper.now_s() + tracks.max_stopping_time_s() + SETTLING_S;
    plan_while(&keeper, &Twist::STOP, |keeper, status| {
        keeper.now_s() < latest_s && !is_still(status)
    });
    let status = keeper.status();
    drop(keeper);
    let interrupted = !status.is_running;
    let stopped = base_words::stopped(&status);
    let done = stopped.is_none() && !interrupted;
    if json {
        let mut object = base_words::status(&status);
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
        output::line(base_words::line(feedback));
    }
    Ok(done)
}

/// Plans a motion as long as something holds, no stop is latched, and nobody asks for an end.
fn plan_while(keeper: &Keeper, twist: &Twist, holds: impl Fn(&Keeper, &Status) -> bool) {
    loop {
        let status = keeper.status();
        if status.stopped.is_some() || !status.is_running || !holds(keeper, &status) {
            return;
        }
        // A refusal is a stop that was latched just now, which the next look sees.
        let _ = keeper.want(twist, keeper.now_s());
        thread::sleep(LOOK);
    }
}

/// Whether the base stands, and is told to.
fn is_still(status: &Status) -> bool {
    let stands = |twist: &Twist| twist.linear.abs() < STILL && twist.angular.abs() < STILL;
    let reported = status.feedback.as_ref().map(|feedback| feedback.twist);
    stands(&status.sent) && reported.is_none_or(|twist| stands(&twist))
}
