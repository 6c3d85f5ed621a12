//! `inbye config import-nav2`.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use anyhow::{Context, bail, ensure};
use inbye::ros::nav2::{Import, import};

use super::config_command::ImportArguments;
use super::output;
use super::output_file::Output;

/// Longest file read, bytes: Nav2's own has fourteen thousand.
const MAX_BYTES: u64 = 1 << 20;

/// Takes over a Nav2 file.
pub fn run(arguments: &ImportArguments, json: bool) -> anyhow::Result<bool> {
    let file = &arguments.file;
    ensure!(
        arguments.output.is_none() || arguments.output != arguments.base_output,
        "--output and --base-output: they must be two files"
    );
    let place = || format!("{}", file.display());
    let text = read(file).with_context(place)?;
    let taken = import(&text, arguments.namespace.as_deref()).with_context(place)?;
    // Only now are files written over.
    let endings = ["toml"];
    let written = Output::create("--output", arguments.output.as_deref(), &endings)?;
    let base_written = Output::create("--base-output", arguments.base_output.as_deref(), &endings)?;
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let heading = heading(&name);
    if json {
        output::json(&taken)?;
    } else {
        if written.is_none() {
            output::line(heading.clone() + &taken.config);
        }
        if base_written.is_none() && !taken.base_config.is_empty() {
            tell_base(&taken.base_config);
        }
        tell(&taken);
    }
    if let Some(written) = written {
        written.write(heading.clone() + &taken.config)?;
    }
    if let Some(written) = base_written {
        written.write(heading + &taken.base_config)?;
    }
    Ok(true)
}

fn read(file: &Path) -> anyhow::Result<String> {
    let mut text = String::new();
    File::open(file)
        .and_then(|file| file.take(MAX_BYTES + 1).read_to_string(&mut text))
        .context("cannot be read as text: check the path")?;
    if text.len() as u64 > MAX_BYTES {
        bail!("it holds more than {MAX_BYTES} bytes, which no parameter file needs");
    }
    Ok(text)
}

/// What the file begins with. Its name must not end the comment.
fn heading(name: &str) -> String {
    let name: String = name.chars().filter(|letter| !letter.is_control()).collect();
    format!(
        "# Taken over from {name} by `inbye config import-nav2`; what is not here is at its default.\n\n"
    )
}

/// Settings of the base are of another file, and so no part of the result on standard output.
fn tell_base(text: &str) {
    output::note("for --base-config, which --base-output FILE.toml writes:");
    for line in text.lines().filter(|line| !line.is_empty()) {
        output::note(format!("  {line}"));
    }
}

fn tell(taken: &Import) {
    for left in &taken.not_mapped {
        output::note(format!(
            "not mapped: {}: {}: {}",
            left.key, left.why, left.reason
        ));
    }
    if !taken.ignored.is_empty() {
        output::note(format!("nodes not read: {}", taken.ignored.join(", ")));
    }
    output::note(format!(
        "{} parameters taken over, {} not",
        taken.mapped.len(),
        taken.not_mapped.len()
    ));
}
