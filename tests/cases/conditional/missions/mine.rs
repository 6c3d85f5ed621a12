//! A real mine, if the development data are next to the repository: across it, among five pedestrians.

use std::path::Path;
use std::sync::Arc;

use inbye::experiment::{LocalizationCase, LocalizationSite, World};
use inbye::geometry::{Point, Pose};
use inbye::local::CpuEngine;
use inbye::map::{LoadOptions, UnknownPolicy, load};
use inbye::navigator::Goal;
use inbye::runtime::{Config, Mission, Observer};
use inbye::sim::{PedestrianSpawner, Simulation};
use libtest_mimic::{Failed, Trial};

use super::driving::{arrive, story};
use crate::support::trials::with_data;

const MAP: &str = "mine/niosh_sr_coal_mine.yaml";

/// More than 300 m, with wheel odometry that slips 5 % and scans alone.
pub fn trial_by_scans() -> Trial {
    with_data("robot tours the mine with scan matching", MAP, tours_by_scans)
}

fn tours_by_scans(map: &Path) -> Result<(), Failed> {
    let site = Arc::new(LocalizationSite {
        name: "mine".to_owned(),
        map: Arc::new(load(map, &LoadOptions::default())?),
        start: Pose::new(57.37, 93.86, 0.0),
        goal: Point::new(210.86, 169.48),
        tour_m: 300.0,
    });
    let world = World::localization(LocalizationCase::Tour, &site);
    for seed in 0..2 {
        let engine = Box::new(CpuEngine::single_threaded());
        let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
        let row = world.drive(seed, &world.settings, engine, &mut observer)?.row;
        assert!(row.reached() && row.travelled_m >= 300.0, "{row:#?}");
        assert!(row.pose_error_max_m.is_some_and(|error| error <= 0.05), "{row:#?}");
        assert!(row.pose_error_max_rad.is_some_and(|error| error <= 0.02), "{row:#?}");
        assert!(row.lost_ticks == Some(0), "{row:#?}");
        assert!(row.odometry_error_max_m > Some(1.0), "{row:#?}");
    }
    Ok(())
}

pub fn trial() -> Trial {
    with_data("robot crosses the mine among five pedestrians", MAP, crosses)
}

fn crosses(map: &Path) -> Result<(), Failed> {
    let map = load(map, &LoadOptions::default())?;
    let config = Config::default();
    let (start, goal) = (Pose::new(57.37, 93.86, 0.0), Point::new(210.86, 169.48));
    let obstacles = map.obstacles(UnknownPolicy::Blocked);
    let mut planner = config.route_planner(map.frame().resolution_m);
    let path = planner.plan(&obstacles, start.position(), goal, &mut || 0.0)?.smoothed;
    let ends = [start.position(), goal];
    for seed in 0..2 {
        let there = Goal::at(goal);
        let result = arrive(&Simulation {
            moving_obstacles: PedestrianSpawner::new(5, seed).spawn(
                &obstacles,
                path.points(),
                &ends,
                0.5,
            )?,
            seed,
            ..Simulation::new(Mission {
                time_limit_s: 900.0,
                ..Mission::new(Arc::new(map.clone()), start, there)
            })
        });
        assert!(result.travelled_m >= 150.0, "{}", story(&result));
    }
    Ok(())
}
