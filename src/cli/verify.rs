//! `inbye verify`.

use anyhow::Context;
use serde_json::json;

use super::arguments::VerifyArguments;
use super::{engines, output};

/// Compares all engines on random problems.
pub fn run(arguments: &VerifyArguments, json: bool) -> anyhow::Result<bool> {
    let mut all = engines::all()?;
    let bar = output::progress(arguments.cases, "verifying");
    let result = inbye::bench::verify(&mut all, arguments.cases, arguments.seed, |done| {
        bar.set_position(done);
    })
    .context("verify")?;
    bar.finish_and_clear();
    let agree = result.agree();
    if json {
        let engines: Vec<_> = all
            .iter()
            .zip(&result.digests)
            .map(|(engine, digest)| json!({ "name": engine.name(), "digest": digest }))
            .collect();
        output::json(&json!({
            "cases": result.cases,
            "seed": arguments.seed,
            "samples": result.samples,
            "engines": engines,
            "agree": agree,
            "difference_count": result.difference_count,
            "differences": result.differences,
        }))?;
        return Ok(agree);
    }
    output::line(format!(
        "{} problems, {} samples",
        result.cases, result.samples
    ));
    for (engine, digest) in all.iter().zip(&result.digests) {
        output::line(format!("{digest}  {}", engine.name()));
    }
    if agree {
        output::line(format!(
            "agree: {} engines returned the same bits",
            all.len()
        ));
    } else {
        output::line(format!(
            "DIFFER in {} quantities; the first:",
            result.difference_count
        ));
        for one in &result.differences {
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
