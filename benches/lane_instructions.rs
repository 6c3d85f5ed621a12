//! Evaluates one decision several times, for a program that counts instructions: `benches/aarch64.sh`.
//!
//!     lane_instructions LANES SAMPLER SAMPLES STEPS WINDOW_S TIMES

use std::env::args;
use std::error::Error;
use std::hint::black_box;

use inbye::bench::{Roadway, grid_counts, roadway_field, usual_shape};
use inbye::local::{CpuEngine, Detail, Engine, InstructionSet, QuantizedProblem, Sampler};

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = args().skip(1).collect();
    let [lanes, sampler, samples, steps, window_s, times] = words.as_slice() else {
        // `cargo bench` runs all benches.
        return Ok(());
    };
    let instructions = InstructionSet::ALL.into_iter().find(|one| one.name() == lanes);
    let sampler = Sampler::ALL.into_iter().find(|one| one.name() == sampler);
    let (instructions, sampler) = instructions.zip(sampler).ok_or("unknown lanes or sampler")?;
    let (vx_samples, vtheta_samples) = grid_counts(samples.parse()?, usual_shape(sampler));
    let roadway = Roadway {
        vx_samples,
        vtheta_samples,
        steps: steps.parse()?,
        window_s: window_s.parse()?,
        sampler,
        ..Roadway::default()
    };
    let problem = QuantizedProblem::new(&roadway.problem(&roadway_field(), 0))?;
    let mut engine = CpuEngine::with_instruction_set(instructions, 1)?;
    for _ in 0..times.parse::<u32>()? {
        black_box(engine.evaluate(&problem, Detail::Answer)?);
    }
    Ok(())
}
