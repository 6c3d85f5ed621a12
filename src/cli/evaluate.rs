//! `inbye evaluate`.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use inbye::bench::{DecisionSize, EngineRequest, EvaluationDigest};
use inbye::local::{
    Counts, Detail, Explainer, QuantizedProblem, SampleSi, Sampling, TrajectoryFan, WinnerSi,
};
use inbye::report::{DecisionView, decision_svg};
use serde_json::{Value, json};

use super::arguments::engine;
use super::files::Output;
use super::{engine_selection, machine, map_file, output, problem_file};

/// `inbye evaluate`.
#[derive(Debug, Args)]
#[command(after_help = problem_file::HELP)]
pub struct EvaluateArguments {
    /// The problem, JSON.
    #[arg(long, value_name = "FILE.json")]
    pub problem: PathBuf,
    /// Engine: `auto` measures once which is fastest; gpu:NAME is the adapter NAME, or else the first whose name contains it.
    #[arg(long, default_value = "auto", value_parser = engine())]
    pub engine: EngineRequest,
    /// Also return every sample, in SI units.
    #[arg(long)]
    pub samples: bool,
    /// Draw the map with the sampled trajectories and the chosen one into this file.
    #[arg(long, value_name = "FILE.svg")]
    pub svg: Option<PathBuf>,
}

/// Trajectories of a picture along each axis, at most.
const DRAWN: Sampling = Sampling { vx_samples: 9, vtheta_samples: 33 };

/// Takes one decision. Returns false if no sample is admissible.
pub fn run(arguments: &EvaluateArguments) -> anyhow::Result<bool> {
    let svg = Output::create("--svg", arguments.svg.as_deref(), &["svg"])?;
    let (problem, map) = problem_file::read(&arguments.problem, map_file::load)?;
    let quantized =
        QuantizedProblem::new(&problem).with_context(|| arguments.problem.display().to_string())?;
    let size = DecisionSize {
        vx_samples: problem.window.vx.count,
        vtheta_samples: problem.window.vtheta.count,
        steps: problem.steps,
        discs: problem.footprint.discs().len(),
        sampler: problem.sampler,
    };
    let mut engine = engine_selection::open(&arguments.engine, &size, machine::cores())?;
    let evaluation = engine.evaluate(&quantized, Detail::Samples)?;
    let mut digest = EvaluationDigest::default();
    digest.add(&evaluation);
    let digest = digest.hex();
    let explainer = Explainer::new(&problem, &quantized, &evaluation);
    let winner = explainer.winner(&evaluation);
    let samples = arguments.samples.then(|| explainer.samples(&evaluation));
    let object = json!({
        "winner": winner,
        "admissible": evaluation.counts.admissible,
        "rejected": {
            "collision": evaluation.counts.collision,
            "cannot_stop": evaluation.counts.cannot_stop,
            "outside": evaluation.counts.outside,
        },
        "sums": explainer.sums(),
        "digest": digest,
        "engine": engine.name(),
    });
    print(object, winner.as_ref(), &evaluation.counts, &digest, samples.as_deref())?;
    // The result comes first: a picture that cannot be written must not cost it.
    svg.write(|| {
        let fan = TrajectoryFan::new(&problem, &quantized, &evaluation, DRAWN);
        let caption = winner.as_ref().map_or_else(
            || "no sample is admissible".to_owned(),
            |winner| format!("chosen: {:.2} m/s, {:+.2} rad/s", winner.vx, winner.vtheta),
        );
        let counts = &evaluation.counts;
        let title = format!(
            "{}: {} of {} samples are admissible",
            arguments.problem.display(),
            counts.admissible,
            counts.to_array().iter().sum::<u32>()
        );
        decision_svg(&DecisionView {
            title: &title,
            caption: &caption,
            map: &map,
            footprint: &problem.footprint,
            target: problem.target,
            fan: &fan,
        })
    })?;
    Ok(winner.is_some())
}

/// Prints the decision: the object as JSON, or text.
fn print(
    mut object: Value,
    winner: Option<&WinnerSi>,
    counts: &Counts,
    digest: &str,
    samples: Option<&[SampleSi]>,
) -> anyhow::Result<()> {
    if output::is_json() {
        if let Some(samples) = samples {
            object["samples"] = json!(samples);
        }
        return output::print_json(&object);
    }
    match winner {
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
    if let Some(samples) = samples {
        output::line("index     vx vtheta  status        heading  clear    path    score");
        for sample in samples {
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
    Ok(())
}
