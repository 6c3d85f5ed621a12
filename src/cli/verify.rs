//! `inbye verify`.

use anyhow::Context;
use clap::Args;
use inbye::bench::{GOLDEN_CASES, GOLDEN_DIGEST, verify, verify_golden};
use inbye::local::CpuEngines;
use serde_json::json;

use super::arguments::whole;
use super::machine::{self, Engines};
use super::output;

/// `inbye verify`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  inbye verify --cases 500 --seed 1 --json\n\n\
    Exit status: 0 all engines agree; 1 bits differ, or an adapter does not open (`skipped`); 2 an engine fails.")]
pub struct VerifyArguments {
    /// Number of random problems.
    #[arg(long, default_value_t = 200, allow_negative_numbers = true, value_parser = whole::<u64>(1, u64::MAX))]
    pub cases: u64,
    /// Seed of the problems.
    #[arg(long, default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<u64>(0, u64::MAX))]
    pub seed: u64,
}

/// Compares all engines and CPU instruction sets on random problems. Returns false if a bit differs, or an adapter does not
/// open.
pub fn run(arguments: &VerifyArguments) -> anyhow::Result<bool> {
    let Engines { open: mut all, skipped } = machine::engines(CpuEngines::InstructionSets)?;
    let bar = output::progress(arguments.cases, "verifying", "problems");
    let done = |done| bar.set_position(done);
    let result = verify(&mut all, arguments.cases, arguments.seed, done).context("verify")?;
    let golden = verify_golden(&mut all).context("verify")?;
    bar.finish_and_clear();
    let agree = result.agree() && golden.digests.iter().all(|digest| digest == GOLDEN_DIGEST);
    let names: Vec<String> = all.iter().map(|engine| engine.name()).collect();
    let named = || names.iter().zip(&result.digests).zip(&golden.digests);
    let mut lines = vec![format!("{} problems, {} samples", result.cases, result.samples)];
    lines.extend(named().map(|((name, digest), _)| format!("{digest}  {name}")));
    lines.push(format!(
        "{GOLDEN_DIGEST}  golden: of {GOLDEN_CASES} pinned problems, the same on every machine"
    ));
    let other = named().filter(|(_, golden)| *golden != GOLDEN_DIGEST);
    lines.extend(other.map(|((name, _), golden)| format!("{golden}  NOT golden: {name}")));
    if agree {
        let count = names.len();
        lines.push(format!("agree: {count} engines returned the same bits, and the golden digest"));
    } else {
        let count = result.difference_count + golden.difference_count;
        lines.push(format!("DIFFER in {count} quantities; the first:"));
        lines.extend(result.differences.iter().chain(&golden.differences).map(|one| {
            let (case, what, found, engine) = (one.case, &one.what, &one.found, &one.engine);
            format!("  case {case}, {what}: {found} on {engine}, {} on {}", one.expected, names[0])
        }));
    }
    lines.extend(skipped.iter().map(|reason| format!("NOT compared: {reason}")));
    let engines = named().map(|((name, digest), golden)| {
        json!({ "name": name, "digest": digest, "golden_digest": golden })
    });
    let object = json!({
        "cases": result.cases,
        "seed": arguments.seed,
        "samples": result.samples,
        "engines": engines.collect::<Vec<_>>(),
        "agree": agree,
        "skipped": skipped,
        "golden_digest": GOLDEN_DIGEST,
        "difference_count": result.difference_count,
        "differences": result.differences,
        "golden_differences": golden.differences,
    });
    output::result(&object, lines)?;
    Ok(agree && skipped.is_empty())
}
