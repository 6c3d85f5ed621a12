//! `inbye base monitor`.

use std::thread;
use std::time::Duration;

use serde_json::json;

use super::base_arguments::MonitorArguments;
use super::base_line::BaseLine;
use super::{base_words, interrupt, output};

/// Time from one line to the next.
const EVERY: Duration = Duration::from_millis(100);

/// Tells what a base reports. False when it was not heard at the end.
pub fn run(arguments: &MonitorArguments, json: bool) -> anyhow::Result<bool> {
    let line = BaseLine::of(&arguments.line)?;
    let keeper = line.keeper(interrupt::flag()?)?;
    line.await_answer(&keeper)?;
    let began_s = keeper.now_s();
    loop {
        let time_s = keeper.now_s() - began_s;
        let status = keeper.status();
        let over = arguments.for_s.is_some_and(|for_s| time_s >= for_s);
        if over || !status.is_running {
            return Ok(status.feedback.is_some());
        }
        if json {
            let mut object = base_words::status(&status);
            object["time_s"] = json!(time_s);
            output::json(&object)?;
        } else {
            let said = match &status.feedback {
                Some(feedback) => base_words::line(feedback),
                None => base_words::condition(&status),
            };
            output::line(format!("{time_s:7.1} s  {said}"));
        }
        thread::sleep(EVERY);
    }
}
