//! `inbye man`.

use std::fs;
use std::path::PathBuf;

use anyhow::Context;
use clap::{Args, Command, CommandFactory};
use clap_mangen::Man;
use clap_mangen::roff::{Roff, roman};
use serde_json::json;

use super::arguments::Arguments;
use super::output;

/// `inbye man`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye man\n  inbye man --output man1\n\n\
    `inbye man | man -l -` shows the page; with --output every command has one of its own, as inbye-bench-density.1, to be \
    put into a folder man1 that `manpath` tells.\n\
    JSON fields: `page` (roff), or with --output `files`.")]
pub struct ManArguments {
    /// Write the pages of all commands into this folder.
    #[arg(long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Prints the program's page, or writes one for each command.
pub fn run(arguments: &ManArguments, json: bool) -> anyhow::Result<bool> {
    let mut program = without_help(Arguments::command());
    // Gives each command its whole name, and the flags that all have.
    program.build();
    let Some(folder) = &arguments.output else {
        let page = page(&program)?;
        if json {
            output::json(&json!({ "page": page }))?;
        } else {
            output::line(page.trim_end());
        }
        return Ok(true);
    };
    let mut pages = Vec::new();
    gather(&program, &mut pages)?;
    let named = || format!("--output {}", folder.display());
    fs::create_dir_all(folder).with_context(named)?;
    let mut files = Vec::new();
    for (name, page) in pages {
        let file = folder.join(name);
        fs::write(&file, page).with_context(named)?;
        files.push(file);
    }
    if json {
        output::json(&json!({ "files": files }))?;
    } else {
        files
            .iter()
            .for_each(|file| output::line(file.display().to_string()));
    }
    Ok(true)
}

/// Without the command `help`, whose page would say nothing.
fn without_help(command: Command) -> Command {
    command
        .disable_help_subcommand(true)
        .mut_subcommands(without_help)
}

/// The pages of a command and of all below it, with their names.
fn gather(command: &Command, pages: &mut Vec<(String, String)>) -> anyhow::Result<()> {
    pages.push((format!("{}.1", name(command)), page(command)?));
    command
        .get_subcommands()
        .try_for_each(|below| gather(below, pages))
}

/// A command's whole name, with hyphens.
fn name(command: &Command) -> &str {
    command.get_display_name().unwrap_or(command.get_name())
}

fn page(command: &Command) -> anyhow::Result<String> {
    let man = Man::new(command.clone())
        .title(name(command))
        .manual("inbye");
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
    String::from_utf8(page).context("the manual page is no text")
}

/// What stands after the help: a heading and its examples as they stand, as [`Man`] would not leave them, then sentences.
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
                for sentences in part.lines() {
                    roff.control("PP", []);
                    roff.text([roman(sentences)]);
                }
            }
        }
    }
    roff
}
