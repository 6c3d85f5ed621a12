//! `inbye base monitor`.

use std::thread;
use std::time::Duration;

use anyhow::Context;
use serde_json::json;

use super::base_arguments::MonitorArguments;
use super::{base_arguments, base_text, output, process};

/// Time between lines.
const PERIOD: Duration = Duration::from_millis(100);

/// Prints a base's reports. Returns false if the base is silent at the end.
pub fn run(arguments: &MonitorArguments, json: bool) -> anyhow::Result<bool> {
    let line = base_arguments::line_of(&arguments.line)?;
    let supervisor = line.supervise(process::interrupt_flag()?).context("--port")?;
    line.await_report(&supervisor).context("--port")?;
    let start_s = supervisor.now_s();
    loop {
        let time_s = supervisor.now_s() - start_s;
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
            let text = match &status.feedback {
                Some(feedback) => base_text::line(feedback),
                None => base_text::drive_status(&status),
            };
            output::line(format!("{time_s:7.1} s  {text}"));
        }
        thread::sleep(PERIOD);
    }
}
