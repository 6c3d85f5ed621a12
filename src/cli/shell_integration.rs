//! `inbye man` and `inbye completions`.

use std::fs;
use std::path::PathBuf;

use anyhow::Context;
use clap::{Args, Command, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;
use clap_mangen::roff::{Roff, roman};

use super::files::open_file;
use super::{Arguments, output};

/// `inbye man`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye man\n  inbye man --output man1\n\n\
    `inbye man | man -l -` shows the page. With --output each command has its own page, such as inbye-bench-density.1: install \
    them in a folder man1 of `manpath`.")]
pub struct ManArguments {
    /// Write the pages of all commands into this folder.
    #[arg(long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Prints the program's manual page, or writes one for each command.
pub fn man(arguments: &ManArguments) -> anyhow::Result<bool> {
    let mut program = without_help(Arguments::command());
    // Sets each command's full name and its global flags.
    program.build();
    let Some(folder) = &arguments.output else {
        output::line(page(&program)?.trim_end());
        return Ok(true);
    };
    let mut pages = Vec::new();
    collect_pages(&program, &mut pages)?;
    let place = || format!("--output {}", folder.display());
    fs::create_dir_all(folder).with_context(place)?;
    for (name, page) in &pages {
        let written = open_file("--output", &folder.join(name))?.write(page.as_bytes());
        written.with_context(place)?;
    }
    for (name, _) in &pages {
        output::line(folder.join(name).display().to_string());
    }
    Ok(true)
}

/// Removes the command `help`, whose page would be empty.
fn without_help(command: Command) -> Command {
    command.disable_help_subcommand(true).mut_subcommands(without_help)
}

/// Collects the pages of a command and its subcommands, with their file names.
fn collect_pages(command: &Command, pages: &mut Vec<(String, String)>) -> anyhow::Result<()> {
    pages.push((format!("{}.1", name(command)), page(command)?));
    command.get_subcommands().try_for_each(|subcommand| collect_pages(subcommand, pages))
}

/// A command's full name, with hyphens.
fn name(command: &Command) -> &str {
    command.get_display_name().unwrap_or(command.get_name())
}

fn page(command: &Command) -> anyhow::Result<String> {
    let man = Man::new(command.clone()).title(name(command)).manual("inbye");
    let mut page = Vec::new();
    man.render_title(&mut page)?;
    man.render_name_section(&mut page)?;
    man.render_synopsis_section(&mut page)?;
    man.render_description_section(&mut page)?;
    man.render_options_section(&mut page)?;
    if command.has_subcommands() {
        man.render_subcommands_section(&mut page)?;
    }
    after_help(command).to_writer(&mut page)?;
    String::from_utf8(page).context("the manual page is not UTF-8")
}

/// Renders the text after the help: examples verbatim under their heading, which [`Man`] would reflow, then paragraphs.
fn after_help(command: &Command) -> Roff {
    let mut roff = Roff::new();
    let text = command.get_after_help().map(ToString::to_string);
    for part in text.unwrap_or_default().split("\n\n") {
        match part.split_once(":\n") {
            Some((heading, lines)) => {
                roff.control("SH", [heading.to_uppercase().as_str()]);
                roff.control("nf", []);
                roff.text([roman(lines)]);
                roff.control("fi", []);
            }
            None => {
                for paragraph in part.lines() {
                    roff.control("PP", []);
                    roff.text([roman(paragraph)]);
                }
            }
        }
    }
    roff
}

/// `inbye completions`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye completions bash\n\n\
    To load them in every new shell, write them where it looks: for bash \
    ~/.local/share/bash-completion/completions/inbye, for zsh a file _inbye in a folder of $fpath, for fish \
    ~/.config/fish/completions/inbye.fish.")]
pub struct CompletionsArguments {
    /// The shell.
    pub shell: Shell,
}

/// Prints the script that completes commands, flags and keywords.
pub fn completions(arguments: &CompletionsArguments) -> anyhow::Result<bool> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Arguments::command(), "inbye", &mut script);
    let script = String::from_utf8(script).context("the completions are not UTF-8")?;
    output::line(script.trim_end());
    Ok(true)
}
