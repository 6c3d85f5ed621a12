//! A real mine, where the development data lie beside the repository: across it, among five people.

use std::path::Path;
use std::sync::Arc;

use inbye::geometry::{Point, Pose};
use inbye::map::{LoadOptions, UnknownPolicy, load};
use inbye::navigator::Goal;
use inbye::sim::{Config, Crowd, Mission, Walkers};
use libtest_mimic::{Completion, Failed, Trial};

use crate::driving::{arrive, story};

const MAP: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../shared/data/mine/niosh_sr_coal_mine.yaml"
);

pub fn trial() -> Trial {
    Trial::ignorable_test("the mine is crossed among five people", || {
        if !Path::new(MAP).exists() {
            return Ok(Completion::ignored_with(
                "the development data are not beside the repository",
            ));
        }
        crosses()?;
        Ok(Completion::Completed)
    })
}

fn crosses() -> Result<(), Failed> {
    let map = load(Path::new(MAP), &LoadOptions::default())?;
    let config = Config::default();
    let (start, goal) = (Pose::new(57.37, 93.86, 0.0), Point::new(210.86, 169.48));
    let obstacles = map.obstacles(UnknownPolicy::Blocked);
    let mut planner = config.route_planner(map.frame().resolution_m);
    let path = planner
        .plan(&obstacles, start.position(), goal, &mut || 0.0)?
        .smoothed;
    let ends = [start.position(), goal];
    for seed in 0..2 {
        let result = arrive(&Mission {
            map: Arc::new(map.clone()),
            truth: None,
            start,
            goal: Goal {
                position: goal,
                yaw: None,
            },
            walkers: Walkers::seeded(&Crowd::new(5, seed), &obstacles, path.points(), &ends)?,
            seed,
            time_limit_s: 900.0,
            done_within_m: None,
        });
        assert!(result.travelled_m >= 150.0, "{}", story(&result));
    }
    Ok(())
}
