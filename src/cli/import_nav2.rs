//! `inbye config import-nav2`.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use anyhow::{Context, anyhow, bail, ensure};
use inbye::ros::nav2::{Import, Nav2Error, import};

use super::config_command::ImportArguments;
use super::output;
use super::output_file::Output;

/// Largest file, bytes: Nav2's own file has fourteen thousand.
const MAX_BYTES: u64 = 1 << 20;

/// Imports a Nav2 file.
pub fn run(arguments: &ImportArguments, json: bool) -> anyhow::Result<bool> {
    let file = &arguments.file;
    ensure!(
        arguments.output.is_none() || arguments.output != arguments.base_output,
        "--output and --base-output: they must be two files"
    );
    let place = || format!("{}", file.display());
    let text = read(file).with_context(place)?;
    let imported = import(&text, arguments.namespace.as_deref());
    let imported = imported.map_err(with_flag).with_context(place)?;
    // Files are overwritten only after a successful import.
    let endings = ["toml"];
    let written = Output::create("--output", arguments.output.as_deref(), &endings)?;
    let base_written = Output::create("--base-output", arguments.base_output.as_deref(), &endings)?;
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let heading = heading(&name);
    if json {
        output::json(&imported)?;
    } else {
        if written.is_none() {
            output::line(heading.clone() + &imported.config);
        }
        if base_written.is_none() && !imported.base_config.is_empty() {
            note_base_config(&imported.base_config);
        }
        note_unmapped(&imported);
    }
    if let Some(written) = written {
        written.write(heading.clone() + &imported.config)?;
    }
    if let Some(written) = base_written {
        written.write(heading + &imported.base_config)?;
    }
    Ok(true)
}

/// Adds the flag that selects a namespace.
fn with_flag(error: Nav2Error) -> anyhow::Error {
    match error {
        Nav2Error::SeveralNamespaces { .. } => anyhow!("{error} with --namespace"),
        other => other.into(),
    }
}

fn read(file: &Path) -> anyhow::Result<String> {
    let mut text = String::new();
    File::open(file)
        .and_then(|file| file.take(MAX_BYTES + 1).read_to_string(&mut text))
        .context("cannot be read as text: check the path")?;
    if text.len() as u64 > MAX_BYTES {
        bail!("the file has more than {MAX_BYTES} bytes: no parameter file needs more");
    }
    Ok(text)
}

/// The first lines of the file. A control character in the name would end the comment.
fn heading(name: &str) -> String {
    let name: String = name.chars().filter(|letter| !letter.is_control()).collect();
    format!(
        "# Imported from {name} by `inbye config import-nav2`; all other settings have their defaults.\n\n"
    )
}

/// Settings of the base belong to another file, so they are not on standard output.
fn note_base_config(text: &str) {
    output::note("for --base-config, which --base-output FILE.toml writes:");
    for line in text.lines().filter(|line| !line.is_empty()) {
        output::note(format!("  {line}"));
    }
}

fn note_unmapped(imported: &Import) {
    for unmapped in &imported.unmapped {
        output::note(format!(
            "not mapped: {}: {}: {}",
            unmapped.parameter, unmapped.reason, unmapped.explanation
        ));
    }
    if !imported.ignored_nodes.is_empty() {
        output::note(format!("ignored nodes: {}", imported.ignored_nodes.join(", ")));
    }
    output::note(format!(
        "{} parameters mapped, {} not mapped",
        imported.mapped.len(),
        imported.unmapped.len()
    ));
}
