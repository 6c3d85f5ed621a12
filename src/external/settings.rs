//! Settings of a program of the user's own.

use core::fmt::{self, Display};
use std::path::Path;
use std::process::Command;

use serde::{Deserialize, Serialize};

use crate::settings::{require, settings};

settings! {
    /// A program that decides or plans in place of inbye.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct ProgramSettings {
        /// The program and its arguments, such as `["python3", "my_planner.py"]`. Empty: inbye's own.
        pub command: Vec<String> = Vec::new();
        /// Longest time without an answer, by the wall clock. Then the mission fails.
        pub timeout_s: f64 = 10.0, ["s", above 0 to 3600];
    }
    rule |settings| {
        let program = settings.command.first().map(|word| word.trim().len());
        require(
            program != Some(0),
            "length of the program in command",
            0.0,
            "above zero; an empty list means inbye's own",
        )
    }
}

/// The words of the command, separated by spaces.
impl Display for ProgramSettings {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.command.join(" "))
    }
}

impl ProgramSettings {
    /// Whether a program is set.
    #[must_use]
    pub const fn is_set(&self) -> bool {
        !self.command.is_empty()
    }

    /// The words of the command that name files: the program itself where it has a path, and its scripts and settings.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.command.iter().map(Path::new).filter(|path| path.is_file())
    }

    /// The command as text; none where no program is set.
    #[must_use]
    pub fn name(&self) -> Option<String> {
        self.is_set().then(|| self.to_string())
    }

    /// The program with its arguments, not started.
    #[must_use]
    pub fn to_command(&self) -> Command {
        let mut words = self.command.iter();
        let mut command = Command::new(words.next().map_or("", String::as_str));
        command.args(words);
        command
    }
}
