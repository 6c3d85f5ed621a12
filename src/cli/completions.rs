//! `inbye completions`.

use anyhow::Context;
use clap::{Args, CommandFactory};
use clap_complete::Shell;
use serde_json::json;

use super::arguments::Arguments;
use super::output;

/// `inbye completions`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye completions bash\n\n\
    To have them in every new shell, write them where it looks: for bash \
    ~/.local/share/bash-completion/completions/inbye, for zsh a file _inbye in a folder of $fpath, for fish \
    ~/.config/fish/completions/inbye.fish.\n\
    JSON fields: `shell`, `completions` (the script).")]
pub struct CompletionsArguments {
    /// The shell.
    pub shell: Shell,
}

/// Prints the script that completes commands, flags and the words that flags know.
pub fn run(arguments: &CompletionsArguments, json: bool) -> anyhow::Result<bool> {
    let shell = arguments.shell;
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "inbye", &mut script);
    let script = String::from_utf8(script).context("the completions are no text")?;
    if json {
        output::json(&json!({ "shell": shell.to_string(), "completions": script }))?;
    } else {
        output::line(script.trim_end());
    }
    Ok(true)
}
