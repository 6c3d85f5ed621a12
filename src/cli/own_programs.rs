//! Arguments for programs that decide, plan or simulate in place of inbye.

use clap::Args;
use inbye::external::ProgramSettings;
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
    #[command(flatten)]
    pub global_planner: GlobalPlannerArgument,
    /// Program that simulates the robot and its world in place of inbye, with its arguments: it gets a line of JSON for each step
    /// and answers with one [default: the configuration's].
    #[arg(long, value_name = "COMMAND", value_parser = words)]
    pub simulator: Option<Words>,
}

/// A program in place of inbye's own global planner.
#[derive(Debug, Args)]
pub struct GlobalPlannerArgument {
    /// Program that plans the global paths in place of inbye, with its arguments: it gets a line of JSON for each path and answers
    /// with one [default: the configuration's].
    #[arg(long, value_name = "COMMAND", value_parser = words)]
    pub global_planner: Option<Words>,
}

impl GlobalPlannerArgument {
    /// Sets the program, if one is given.
    pub fn set(&self, config: &mut Config) {
        set(self.global_planner.as_ref(), &mut config.global_planner);
    }
}

/// The words of a command, as a shell splits them.
#[derive(Clone, Debug)]
pub struct Words(Vec<String>);

/// Splits a command.
pub fn words(text: &str) -> Result<Words, String> {
    match shlex::split(text) {
        None => Err("a quote is not closed".to_owned()),
        Some(words) if words.first().is_none_or(|program| program.trim().is_empty()) => {
            Err("it must be a program and its arguments, such as \"python3 my_planner.py\""
                .to_owned())
        }
        Some(words) => Ok(Words(words)),
    }
}

impl Words {
    /// The words.
    pub fn command(&self) -> &[String] {
        &self.0
    }

    /// The program with its arguments.
    pub fn program(&self) -> ProgramSettings {
        let mut program = ProgramSettings::default();
        set(Some(self), &mut program);
        program
    }
}

impl ProgramArguments {
    /// Sets the programs that are given.
    pub fn set(&self, config: &mut Config) {
        set(self.controller.as_ref(), &mut config.controller);
        self.global_planner.set(config);
        set(self.simulator.as_ref(), &mut config.simulator);
    }
}

fn set(given: Option<&Words>, program: &mut ProgramSettings) {
    if let Some(Words(command)) = given {
        program.command.clone_from(command);
    }
}
