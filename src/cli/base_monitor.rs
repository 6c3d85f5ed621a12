//! `inbye base monitor`.

use std::thread;
use std::time::Duration;

use serde_json::json;

use super::base_arguments::MonitorArguments;
use super::base_line::BaseLine;
use super::{base_text, interrupt, output};

/// Time from one line to the next.
const EVERY: Duration = Duration::from_millis(100);

/// Tells what a base reports. False when it was not heard at the end.
pub fn run(arguments: &MonitorArguments, json: bool) -> anyhow::Result<bool> {
    let line = BaseLine::of(&arguments.line)?;
    let supervisor = line.supervisor(interrupt::flag()?)?;
    line.await_answer(&supervisor)?;
    let began_s = supervisor.now_s();
    loop {
        let time_s = supervisor.now_s() - began_s;
        let status = supervisor.status();
        let over = arguments.for_s.is_some_and(|for_s| time_s >= for_s);
        if over || !status.is_running {
            return Ok(status.feedback.is_some());
        }
        if json {
            let mut object = base_text::status(&status);
            object["time_s"] = json!(time_s);
            output::json(&object)?;
        } else {
            let said = match &status.feedback {
                Some(feedback) => base_text::line(feedback),
                None => base_text::condition(&status),
            };
            output::line(format!("{time_s:7.1} s  {said}"));
        }
        thread::sleep(EVERY);
    }
}
