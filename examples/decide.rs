//! Takes one decision on a grid: the best velocity for the next control period.
//!
//! Run with `cargo run --release --no-default-features --features gpu --example decide`. Without a GPU adapter the CPU
//! engine decides, with the same bits.

#![expect(clippy::print_stdout, reason = "an example prints its result")]

use inbye::geometry::{Point, Pose, Twist};
use inbye::local::{ClearanceField, EngineChoice, Problem, open_engine};
use inbye::map::{OccupancyGrid, UnknownPolicy};
use inbye::robot::Footprint;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A gap in a wall, 1 m per character; the origin is the lower left corner.
    let rows = [".....#......", "............", ".....#......"];
    let grid = OccupancyGrid::from_rows(&rows, 1.0, Pose::default())?;
    let field = ClearanceField::new(&grid.obstacles(UnknownPolicy::Blocked))?;
    let (pose, twist) = (Pose::new(3.0, 1.2, 0.2), Twist::new(0.5, 0.0));
    let target = Point::new(9.0, 1.5);
    let problem = Problem::new(field, &Footprint::round(0.3)?, pose, twist, target);

    let mut selected = open_engine(&EngineChoice::Cpu, 1)?;
    let decision = selected.engine.decide(&problem)?;
    println!("{}: {:?}", selected.description, decision.command());
    Ok(())
}
