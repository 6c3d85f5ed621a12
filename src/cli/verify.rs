//! `inbye verify`.

use anyhow::Context;
use inbye::bench::{GOLDEN_CASES, GOLDEN_DIGEST};
use serde_json::json;

use super::arguments::VerifyArguments;
use super::{engines, output};

/// Compares all engines on random problems. Returns false if a bit differs.
pub fn run(arguments: &VerifyArguments, json: bool) -> anyhow::Result<bool> {
    let mut all = engines::to_compare()?;
    let bar = output::progress(arguments.cases, "verifying");
    let result = inbye::bench::verify(&mut all, arguments.cases, arguments.seed, |done| {
        bar.set_position(done);
    })
    .context("verify")?;
    let golden = inbye::bench::verify_golden(&mut all).context("verify")?;
    bar.finish_and_clear();
    let is_golden = |digest: &String| digest == GOLDEN_DIGEST;
    let agree = result.agree() && golden.digests.iter().all(is_golden);
    if json {
        let engines: Vec<_> = all
            .iter()
            .zip(result.digests.iter().zip(&golden.digests))
            .map(|(engine, (digest, golden))| {
                json!({ "name": engine.name(), "digest": digest, "golden_digest": golden })
            })
            .collect();
        output::json(&json!({
            "cases": result.cases,
            "seed": arguments.seed,
            "samples": result.samples,
            "engines": engines,
            "agree": agree,
            "golden_digest": GOLDEN_DIGEST,
            "difference_count": result.difference_count,
            "differences": result.differences,
            "golden_differences": golden.differences,
        }))?;
        return Ok(agree);
    }
    output::line(format!("{} problems, {} samples", result.cases, result.samples));
    for (engine, digest) in all.iter().zip(&result.digests) {
        output::line(format!("{digest}  {}", engine.name()));
    }
    output::line(format!(
        "{GOLDEN_DIGEST}  golden: of {GOLDEN_CASES} pinned problems, the same on every machine"
    ));
    for (engine, digest) in all.iter().zip(&golden.digests) {
        if !is_golden(digest) {
            output::line(format!("{digest}  NOT golden: {}", engine.name()));
        }
    }
    if agree {
        output::line(format!(
            "agree: {} engines returned the same bits, and the golden digest",
            all.len()
        ));
    } else {
        output::line(format!(
            "DIFFER in {} quantities; the first:",
            result.difference_count + golden.difference_count
        ));
        for one in result.differences.iter().chain(&golden.differences) {
            output::line(format!(
                "  case {}, {}: {} on {}, {} on {}",
                one.case,
                one.what,
                one.found,
                one.engine,
                one.expected,
                all[0].name(),
            ));
        }
    }
    Ok(agree)
}
