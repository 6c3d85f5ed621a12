//! Arguments for programs that decide, plan or simulate in place of inbye.

use clap::Args;
use inbye::runtime::Config;

/// Programs in place of inbye's own controller, global planner and simulator.
#[derive(Debug, Args)]
pub struct ProgramArguments {
    #[arg(
        long,
        value_name = "COMMAND",
        value_parser = words,
        help = "Program that decides the velocities in place of inbye, with its arguments, such as \"python3 my_planner.py\": it gets a \
            line of JSON at each tick and answers with one [default: the configuration's]"
    )]
    pub controller: Option<Words>,
    /// Program that plans the global paths in place of inbye, likewise.
    #[arg(long, value_name = "COMMAND", value_parser = words)]
    pub global_planner: Option<Words>,
    /// Program that simulates the robot and its world in place of inbye, likewise.
    #[arg(long, value_name = "COMMAND", value_parser = words)]
    pub simulator: Option<Words>,
}

/// The words of a command, as a shell splits them.
#[derive(Clone, Debug)]
pub struct Words(Vec<String>);

fn words(text: &str) -> Result<Words, String> {
    match shlex::split(text) {
        None => Err("a quote is not closed".to_owned()),
        Some(words) if words.is_empty() => {
            Err("it must be a program and its arguments, such as \"python3 my_planner.py\""
                .to_owned())
        }
        Some(words) => Ok(Words(words)),
    }
}

impl ProgramArguments {
    /// Sets the programs that are given.
    pub fn set(&self, config: &mut Config) {
        let programs = [
            (&self.controller, &mut config.controller),
            (&self.global_planner, &mut config.global_planner),
            (&self.simulator, &mut config.simulator),
        ];
        for (given, program) in programs {
            if let Some(Words(command)) = given {
                program.command.clone_from(command);
            }
        }
    }
}
