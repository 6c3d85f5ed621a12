//! The committed corpora: small, and one for each target.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use libtest_mimic::{Failed, Trial};

use super::bodies::TARGETS;

/// The most that a corpus may hold, bytes.
const MOST_BYTES: usize = 64 << 10;

/// An input, and the name of its file.
pub struct Seed {
    pub name: String,
    pub bytes: Vec<u8>,
}

fn fuzz() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz")
}

/// The corpus of a target, in the order of its names.
pub fn read(target: &str) -> Result<Vec<Seed>, Failed> {
    let folder = fuzz().join("corpus").join(target);
    let mut seeds = Vec::new();
    for name in names(&folder)? {
        let bytes = fs::read(folder.join(&name))?;
        seeds.push(Seed { name, bytes });
    }
    let bytes: usize = seeds.iter().map(|seed| seed.bytes.len()).sum();
    if seeds.is_empty() || bytes > MOST_BYTES {
        let inputs = seeds.len();
        return Err(format!("{inputs} inputs of {bytes} bytes in all").into());
    }
    Ok(seeds)
}

/// Names in a folder, those left out that begin with a dot.
fn names(folder: &Path) -> Result<BTreeSet<String>, Failed> {
    let named = |error: io::Error| format!("{}: {error}", folder.display());
    let mut names = BTreeSet::new();
    for entry in fs::read_dir(folder).map_err(named)? {
        let name = entry.map_err(named)?.file_name();
        let name = name.to_string_lossy().into_owned();
        if !name.starts_with('.') {
            names.insert(name);
        }
    }
    Ok(names)
}

pub fn trials() -> Vec<Trial> {
    let test = Trial::test("every target has its body, corpus and binary", each_has_all);
    vec![test]
}

fn each_has_all() -> Result<(), Failed> {
    let targets = TARGETS.map(|(name, _)| name.to_owned()).into();
    if names(&fuzz().join("corpus"))? != targets {
        return Err("fuzz/corpus has not a folder for each target".into());
    }
    let files = targets.iter().map(|name| format!("{name}.rs")).collect();
    if names(&fuzz().join("fuzz_targets"))? != files {
        return Err("fuzz/fuzz_targets has not a file for each target".into());
    }
    let manifest = fs::read_to_string(fuzz().join("Cargo.toml"))?;
    let manifest: toml::Table = manifest.parse()?;
    let bins = manifest["bin"].as_array().expect("[[bin]] tables");
    let bins = bins.iter().map(|bin| {
        let name = bin["name"].as_str().expect("a name");
        name.to_owned()
    });
    if bins.collect::<BTreeSet<_>>() != targets {
        return Err("fuzz/Cargo.toml has not a [[bin]] for each target".into());
    }
    Ok(())
}
