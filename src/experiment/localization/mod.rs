//! Accuracy of localization: closed-loop drives on matched scans alone, compared with the simulator's truth.

mod maps;
mod monitor;

use core::f64::consts::PI;
use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use crate::geometry::{Point, Pose};
use crate::local::CpuEngine;
use crate::map::{DistanceField, OccupancyGrid};
use crate::navigator::Goal;
use crate::runtime::{Config, Mission, Observer, PoseSource};
use crate::settings::words;
use crate::sim::{
    FaultInjection, Lidar, PedestrianSpawner, Scene, SimError, Simulation, crossing, first_path,
    roadway as roadway_scene,
};
use maps::{coarsened, roadways};
pub(super) use monitor::LocalizationMonitor;

/// Time of the injected fault, seconds: the robot is driving.
const FAULT_S: f64 = 12.0;
/// Length and width of the smooth roadways, metres.
const ROADWAY_M: (f64, f64) = (120.0, 3.0);
/// Search for a pose to move the robot to: free radius, metres, smallest distance from the start, metres, attempts, and largest
/// number of free poses from which a path to the goal is searched.
const FREE_RADIUS_M: f64 = 1.1;
const AWAY_M: f64 = 20.0;
const TRIES: usize = 100_000;
const MAX_PLANS: usize = 100;
/// Longest time of a tour, seconds.
const LONGEST_S: f64 = 3600.0;

words! {
    /// A case of the localization experiment.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
    #[non_exhaustive]
    pub enum LocalizationCase {
        /// Back and forth between start and goal, for the length of the tour.
        Tour = "tour",
        /// A tour among five people that the map does not show.
        People = "people",
        /// A tour with a map of twice the world's cell size.
        CoarseMap = "coarse_map",
        /// Along a straight smooth roadway of 120 m. Its walls do not show the position along it.
        Smooth = "smooth",
        /// The robot is moved two metres back while it drives.
        Kidnapped = "kidnapped",
        /// The robot is moved to a random free place, at least 20 m from the start.
        KidnappedFar = "kidnapped_far",
        /// The robot is moved into an identical parallel roadway.
        KidnappedToTwin = "kidnapped_to_twin",
        /// Its lidar returns nothing from some time on.
        Occluded = "occluded",
        /// Its lidar returns nothing for three seconds.
        BrieflyOccluded = "briefly_occluded",
        /// The map is of another built-in scene.
        OtherMap = "other_map",
    }
}

/// The map and the ends of the drives.
#[derive(Clone, Debug)]
pub struct LocalizationSite {
    /// Name of the map.
    pub name: String,
    /// The map, which is the world.
    pub map: Arc<OccupancyGrid>,
    /// Start of the drives.
    pub start: Pose,
    /// Point at which the drives turn back.
    pub goal: Point,
    /// Smallest length of a tour, metres.
    pub tour_m: f64,
}

/// The settings of the drives: a lidar of 450 beams, 5 % slip, and the pose from scans.
#[must_use]
pub fn localization_config() -> Config {
    let mut config = Config { pose_source: PoseSource::Scans, ..Config::default() };
    config.simulation.lidar = Lidar::turning();
    config.simulation.dynamics.slip.mean = 0.05;
    config
}

impl LocalizationSite {
    /// A built-in scene.
    #[must_use]
    pub fn of_scene(scene: Scene, tour_m: f64) -> Self {
        let Scene { name, map, start, goal, .. } = scene;
        Self { name: name.to_owned(), map: Arc::new(map), start, goal, tour_m }
    }

    /// Name of the world of a case: three cases have worlds of their own, which are built-in roadways.
    pub(super) fn world_name(&self, case: LocalizationCase) -> &str {
        use LocalizationCase::{KidnappedToTwin, OtherMap, Smooth};
        if matches!(case, Smooth | KidnappedToTwin | OtherMap) { "roadway" } else { &self.name }
    }

    pub(super) fn simulation(
        &self,
        case: LocalizationCase,
        seed: u64,
        config: &Config,
    ) -> Result<Simulation, SimError> {
        let (length_m, width_m) = ROADWAY_M;
        let along = |x: f64| Point::new(x, 1.0 + width_m / 2.0);
        let seeded = |mission| Simulation { seed, ..Simulation::new(mission) };
        let roadway = |map: OccupancyGrid| {
            let start = Pose::new(3.0, along(3.0).y, 0.0);
            seeded(Mission::new(Arc::new(map), start, Goal::at(along(length_m - 2.0))))
        };
        let one_leg = seeded(Mission::new(Arc::clone(&self.map), self.start, Goal::at(self.goal)));
        let kidnapped = |to, drive| Simulation {
            faults: vec![FaultInjection::Kidnapped { at_s: FAULT_S, to }],
            ..drive
        };
        let occluded = |to_s, drive| Simulation {
            faults: vec![FaultInjection::LidarOccluded { from_s: FAULT_S, to_s }],
            ..drive
        };
        Ok(match case {
            LocalizationCase::Tour => self.back_and_forth(one_leg, config)?,
            LocalizationCase::People => self.among_people(one_leg, config)?,
            LocalizationCase::CoarseMap => {
                let mut tour = self.back_and_forth(one_leg, config)?;
                tour.mission.map = Arc::new(coarsened(&self.map));
                tour.truth = Some(self.map.obstacles(config.unknown));
                tour
            }
            LocalizationCase::Smooth => roadway(roadways(length_m, &[1.0], width_m)),
            LocalizationCase::Kidnapped => kidnapped(self.place_behind(config, &one_leg)?, one_leg),
            LocalizationCase::KidnappedFar => kidnapped(self.far_pose(&one_leg, config), one_leg),
            LocalizationCase::KidnappedToTwin => {
                let twin = Pose::new(20.0, along(20.0).y + 1.0 + width_m, 0.0);
                kidnapped(twin, roadway(roadways(length_m, &[1.0, 2.0 + width_m], width_m)))
            }
            LocalizationCase::Occluded => occluded(f64::INFINITY, one_leg),
            LocalizationCase::BrieflyOccluded => occluded(FAULT_S + 3.0, one_leg),
            LocalizationCase::OtherMap => {
                let own = roadway_scene();
                Simulation {
                    truth: Some(crossing().map.obstacles(config.unknown)),
                    ..seeded(Mission::new(Arc::new(own.map), own.start, Goal::at(own.goal)))
                }
            }
        })
    }

    /// Enough legs for the tour's length.
    fn back_and_forth(
        &self,
        mut drive: Simulation,
        config: &Config,
    ) -> Result<Simulation, SimError> {
        let path = first_path(&drive.mission, config)?;
        let lengths = path.points().windows(2).map(|leg| (leg[1] - leg[0]).norm());
        let length_m = lengths.sum::<f64>().max(1.0);
        // The robot cuts corners, so one leg more.
        let legs = (self.tour_m / length_m).ceil() as usize + 1;
        let ends = [self.goal, self.start.position()];
        let mut stops: Vec<Goal> = (0..legs).map(|leg| Goal::at(ends[leg % 2])).collect();
        let goal = stops.pop().unwrap_or_else(|| Goal::at(self.goal));
        drive.mission = Mission { via: stops, goal, time_limit_s: LONGEST_S, ..drive.mission };
        Ok(drive)
    }

    fn among_people(&self, one_leg: Simulation, config: &Config) -> Result<Simulation, SimError> {
        let spawner = PedestrianSpawner::new(5, one_leg.seed);
        let moving_obstacles = spawner.spawn_on_route(&one_leg.mission, config)?;
        let tour = self.back_and_forth(one_leg, config)?;
        Ok(Simulation { moving_obstacles, ..tour })
    }

    /// The pose two metres behind the robot at the time of the fault, from a drive without it.
    fn place_behind(&self, config: &Config, one_leg: &Simulation) -> Result<Pose, SimError> {
        let mut simulation = one_leg.clone();
        simulation.mission.time_limit_s = FAULT_S;
        let result = simulation.run(
            config,
            Box::new(CpuEngine::single_threaded()),
            &mut Observer { clock: &mut || 0.0, on_tick: &mut |_| {} },
        )?;
        let rows = &result.trace.rows;
        let last = rows.last().map_or(self.start, |row| row.pose);
        let behind =
            rows.iter().rev().find(|row| (row.pose.position() - last.position()).norm() >= 2.0);
        Ok(behind.map_or(self.start, |row| row.pose))
    }

    /// A random free pose with room for the robot and a path to the goal, far from the start.
    fn far_pose(&self, one_leg: &Simulation, config: &Config) -> Pose {
        let mut rng = Pcg64Mcg::seed_from_u64(one_leg.seed);
        let field = DistanceField::new(&self.map.obstacles(config.unknown));
        let frame = field.frame();
        let is_good = |pose: &Pose| {
            let cell = frame.cell_of(&pose.position());
            cell.is_some_and(|cell| field.distance_m(cell) > FREE_RADIUS_M)
                && (pose.position() - self.start.position()).norm() > AWAY_M
        };
        let mut any = || {
            let cell = frame.cell_at(rng.random_range(0..frame.len()));
            let place = frame.center_of(cell);
            Pose::new(place.x, place.y, rng.random_range(-PI..PI))
        };
        // A robot in a part of the map without a path would say nothing about its localization.
        let has_path = |&start: &Pose| {
            first_path(&Mission { start, ..one_leg.mission.clone() }, config).is_ok()
        };
        let mut good = (0..TRIES).map(|_| any()).filter(is_good).take(MAX_PLANS);
        let found = good.find(has_path);
        found.unwrap_or_else(|| Pose::new(self.goal.x, self.goal.y, 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robot_is_moved_to_a_place_with_a_path_to_the_goal() {
        // A room of 40 x 20 m, and one of the same size without a door.
        let inner = ["#", &".".repeat(80), "#", &".".repeat(80), "#"].concat();
        let wall = "#".repeat(inner.len());
        let rows: Vec<&str> = [vec![&*wall], vec![&*inner; 40], vec![&*wall]].concat();
        let map = OccupancyGrid::from_rows(&rows, 0.5, Pose::default()).expect("a map");
        let (map, start) = (Arc::new(map), Pose::new(2.0, 10.0, 0.0));
        let site = LocalizationSite {
            name: "rooms".to_owned(),
            map,
            start,
            goal: Point::new(10.0, 10.0),
            tour_m: 1.0,
        };
        let config = localization_config();
        for seed in 0..8 {
            let made = site.simulation(LocalizationCase::KidnappedFar, seed, &config);
            let faults = made.expect("a drive").faults;
            let &[FaultInjection::Kidnapped { to, .. }] = &faults[..] else {
                panic!("{faults:?}");
            };
            assert!(to.x < 40.0, "seed {seed}: {to:?}");
        }
    }

    #[test]
    fn case_in_a_built_in_world_has_the_name_of_that_world() {
        let scene = LocalizationSite::of_scene(crossing(), 1.0);
        assert_eq!(scene.world_name(LocalizationCase::Tour), "crossing");
        for case in [
            LocalizationCase::Smooth,
            LocalizationCase::KidnappedToTwin,
            LocalizationCase::OtherMap,
        ] {
            assert_eq!(scene.world_name(case), "roadway");
        }
    }
}
