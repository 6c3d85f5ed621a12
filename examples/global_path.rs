//! Plans a global path on a grid: `cargo run --release --no-default-features --example global_path`

#![expect(clippy::print_stdout, reason = "an example prints its result")]

use inbye::geometry::{Point, Pose};
use inbye::global::Settings;
use inbye::map::{OccupancyGrid, UnknownPolicy};
use inbye::navigator::{NavigatorSettings, RoutePlanner};
use inbye::robot::Footprint;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A pillar in a room, 0.5 m per character; the origin is the lower left corner.
    let rows = ["............", "............", ".....##.....", "............", "............"];
    let resolution_m = 0.5;
    let grid = OccupancyGrid::from_rows(&rows, resolution_m, Pose::default())?;
    let (footprint, navigator) = (Footprint::round(0.3)?, NavigatorSettings::default());
    let mut planner = RoutePlanner::new(&footprint, &navigator, Settings::default(), resolution_m);

    let (start, goal) = (Point::new(0.7, 1.3), Point::new(5.2, 1.3));
    let obstacles = grid.obstacles(UnknownPolicy::Blocked);
    let plan = planner.plan(&obstacles, start, goal, &mut || 0.0)?;
    println!("searched {:.2} m, smoothed {:.2} m", plan.raw.length_m(), plan.smoothed.length_m());
    for point in plan.smoothed.points() {
        println!("{:.3} {:.3}", point.x, point.y);
    }
    Ok(())
}
