//! A controller of one's own drives through a built-in scene: pure pursuit of a point on the path.

#![expect(clippy::print_stdout, reason = "an example prints its result")]

use std::sync::Arc;

use inbye::geometry::Twist;
use inbye::global::Path;
use inbye::navigator::{Controller, ControllerInput, ControllerReply, Goal};
use inbye::runtime::{Config, Mission, Observer};
use inbye::sim::{Simulation, dead_end};

struct PurePursuit;

impl Controller for PurePursuit {
    fn name(&self) -> &'static str {
        "pure pursuit"
    }

    fn set_plan(&mut self, _: &Path) {}

    fn compute_velocity(&mut self, input: &ControllerInput<'_>) -> ControllerReply {
        let ahead = input.path.point_at(input.path_progress_m + 0.6);
        let target = input.pose.inverse_transform(&ahead);
        let speed = if target.x > 0.3 { 0.5 } else { 0.0 };
        let curvature = 2.0 * target.y / target.to_vector().norm_squared().max(0.01);
        Ok(Twist::new(speed, curvature * speed.max(0.2)))
    }

    fn reset(&mut self) {}
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = dead_end();
    let mission = Mission::new(Arc::new(scene.map), scene.start, Goal::at(scene.goal));
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
    let controller: Box<dyn Controller> = Box::new(PurePursuit);
    let result = Simulation::new(mission).run(&Config::default(), controller, &mut observer)?;
    println!("{:.1} m in {:.1} s: {:?}", result.travelled_m, result.time_s, result.why());
    Ok(())
}
