//! `inbye evaluate`.

use anyhow::Context;
use inbye::bench::EvaluationDigest;
use inbye::local::{Detail, Explainer, QuantizedProblem};
use serde_json::json;

use super::arguments::EvaluateArguments;
use super::{engines, map_file, output, problem_file};

/// Takes one decision. Returns false if no sample is admissible.
pub fn run(arguments: &EvaluateArguments, json: bool) -> anyhow::Result<bool> {
    let problem = problem_file::read(&arguments.problem, map_file::load)?;
    let quantized = QuantizedProblem::new(&problem)
        .with_context(|| format!("{}", arguments.problem.display()))?;
    let mut engine = engines::choose(&arguments.engine, None)?;
    let evaluation = engine.evaluate(&quantized, Detail::Samples)?;
    let mut digest = EvaluationDigest::default();
    digest.add(&evaluation);
    let explainer = Explainer::new(&problem, &quantized, &evaluation);
    let winner = explainer.winner(&evaluation);
    let counts = &evaluation.counts;
    let (sums, digest) = (explainer.sums(), digest.hex());
    if json {
        let mut object = json!({
            "winner": winner,
            "admissible": counts.admissible,
            "rejected": {
                "collision": counts.collision,
                "cannot_stop": counts.cannot_stop,
                "outside": counts.outside,
            },
            "sums": sums,
            "digest": digest,
            "engine": engine.name(),
        });
        if arguments.samples {
            object["samples"] = json!(explainer.samples(&evaluation));
        }
        output::json(&object)?;
        return Ok(winner.is_some());
    }
    match &winner {
        None => output::line("no sample is admissible: stop"),
        Some(winner) => {
            output::line(format!(
                "command      vx {:.3} m/s, vtheta {:+.3} rad/s (sample {})",
                winner.vx, winner.vtheta, winner.index
            ));
            output::line(format!("score        {:.6}", winner.score));
            let terms = &winner.terms;
            output::line(format!("heading      {:.4} rad; pi faces the target", terms.heading));
            output::line(format!("clearance    {:.3} m", terms.clearance));
            output::line(format!("path         {:.3} m from the key node", terms.path));
        }
    }
    output::line(format!(
        "samples      {} admissible; rejected: {} collision, {} cannot stop, {} outside",
        counts.admissible, counts.collision, counts.cannot_stop, counts.outside,
    ));
    output::line(format!("digest       {digest}"));
    if arguments.samples {
        output::line("index     vx vtheta  status        heading  clear    path    score");
        for sample in explainer.samples(&evaluation) {
            let score = sample.score.map_or_else(String::new, |score| format!("{score:.6}"));
            output::line(format!(
                "{:5} {:6.3} {:+6.3}  {:12} {:8.4} {:6.3} {:7.3} {score:>8}",
                sample.index,
                sample.vx,
                sample.vtheta,
                sample.status,
                sample.terms.heading,
                sample.terms.clearance,
                sample.terms.path,
            ));
        }
    }
    Ok(winner.is_some())
}
