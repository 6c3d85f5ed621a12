//! Takes the decisions of many robots in one submission to the GPU, or on the CPU with the same bits.
//!
//! Run with `cargo run --release --no-default-features --features gpu --example batch`.

#![expect(clippy::print_stdout, reason = "an example prints its result")]

use std::sync::Arc;

use inbye::geometry::{Point, Pose, Twist};
use inbye::local::{ClearanceField, Detail, EngineChoice, Problem, QuantizedProblem, open_engine};
use inbye::map::{OccupancyGrid, UnknownPolicy};
use inbye::robot::Footprint;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let rows = [".....#......", "............", ".....#......"];
    let grid = OccupancyGrid::from_rows(&rows, 1.0, Pose::default())?;
    let field = Arc::new(ClearanceField::new(&grid.obstacles(UnknownPolicy::Blocked))?);
    let footprint = Footprint::round(0.3)?;
    // Robots that share a map share its field on the device.
    let problems: Vec<Problem> = (0..64)
        .map(|robot| {
            let pose = Pose::new(0.5 + 0.05 * f64::from(robot), 1.5, 0.0);
            let field = Arc::clone(&field);
            Problem::new(field, &footprint, pose, Twist::new(0.5, 0.0), Point::new(9.0, 1.5))
        })
        .collect();
    let quantized: Vec<_> = problems.iter().map(QuantizedProblem::new).collect::<Result<_, _>>()?;

    let mut selected = open_engine(&EngineChoice::Cpu, 1)?;
    let answers = selected.engine.evaluate_batch(&quantized, Detail::Answer)?;
    println!("{}", selected.description);
    for (problem, answer) in problems.iter().zip(answers) {
        match answer.winner {
            Some(winner) => println!("{:?}", problem.command(winner.index)),
            None => println!("no admissible sample: brake"),
        }
    }
    Ok(())
}
