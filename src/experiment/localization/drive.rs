//! One drive on matched scans, with its injected faults.

use core::f64::consts::PI;
use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::case::FAULT_S;
use super::error_monitor::ErrorMonitor;
use super::ground::{coarsened, smooth_roadway, twin_roadways};
use super::{LocalizationCase, LocalizationRow};
use crate::geometry::{Point, Pose};
use crate::local::CpuEngine;
use crate::map::{DistanceField, OccupancyGrid};
use crate::navigator::{Fault, Goal};
use crate::runtime::{Config, Mission, MissionError, Observer, PoseSource, TickEvent};
use crate::sim::{
    FaultInjection, PedestrianSpawner, SimError, Simulation, crossing, roadway as roadway_scene,
};

/// Length and width of the smooth roadways, metres.
const ROADWAY_M: (f64, f64) = (120.0, 3.0);

/// Search for a pose to move the robot to: free radius, metres, smallest distance from the start, metres, and attempts.
const FREE_RADIUS_M: f64 = 1.1;
const AWAY_M: f64 = 20.0;
const TRIES: usize = 100_000;

/// Longest time of a drive, seconds.
const LONGEST_S: f64 = 3600.0;

/// The map, ends and settings of the drives.
#[derive(Clone, Debug)]
pub struct LocalizationPlan {
    /// Name of the map.
    pub name: String,
    /// The map, which is the world.
    pub map: Arc<OccupancyGrid>,
    /// Start of the drives.
    pub start: Pose,
    /// Point at which the drives turn back.
    pub goal: Point,
    /// Settings of all drives; the pose always comes from scans.
    pub config: Config,
    /// Smallest length of a tour, metres.
    pub tour_m: f64,
}

impl LocalizationPlan {
    /// One drive.
    ///
    /// # Errors
    /// When a setting is out of range, or no path leads from the start to the goal.
    pub fn drive(&self, case: LocalizationCase, seed: u64) -> Result<LocalizationRow, SimError> {
        let config = Config { pose_source: PoseSource::Scans, ..self.config.clone() };
        let simulation = self.simulation(case, seed, &config)?;
        let mut monitor = ErrorMonitor::new(case.fault_s());
        let mut clock = || 0.0;
        let result = simulation.run(
            &config,
            Box::new(CpuEngine::single_threaded()),
            &mut Observer { clock: &mut clock, on_tick: &mut |moment| monitor.on_tick(moment) },
        )?;
        Ok(LocalizationRow {
            case: case.name().to_owned(),
            map: self.name.clone(),
            seed,
            slip: config.simulation.dynamics.slip.mean,
            reached: result.reached,
            collided: result.collided,
            travelled_m: result.travelled_m,
            time_s: result.time_s,
            fault: result.fault.as_ref().map(ToString::to_string),
            trace_digest: result.trace.digest(),
            ..monitor.row()
        })
    }

    fn simulation(
        &self,
        case: LocalizationCase,
        seed: u64,
        config: &Config,
    ) -> Result<Simulation, SimError> {
        let (length_m, width_m) = ROADWAY_M;
        let along = |x: f64| Point::new(x, 1.0 + width_m / 2.0);
        let seeded = |mission| Simulation { seed, ..Simulation::new(mission) };
        let roadway = |map: OccupancyGrid| {
            seeded(Mission::new(
                Arc::new(map),
                Pose::new(3.0, along(3.0).y, 0.0),
                stop(along(length_m - 2.0)),
            ))
        };
        let one_leg = seeded(Mission::new(Arc::clone(&self.map), self.start, stop(self.goal)));
        let (from_s, to_s) = (FAULT_S, f64::INFINITY);
        Ok(match case {
            LocalizationCase::Tour => self.back_and_forth(one_leg, config)?,
            LocalizationCase::People => self.among_people(one_leg, config)?,
            LocalizationCase::CoarseMap => {
                let mut tour = self.back_and_forth(one_leg, config)?;
                tour.mission.map = Arc::new(coarsened(&self.map));
                tour.truth = Some(self.map.obstacles(config.unknown));
                tour
            }
            LocalizationCase::Smooth => roadway(smooth_roadway(length_m, width_m)),
            LocalizationCase::Kidnapped => {
                let before = self.place_behind(config, &one_leg)?;
                Simulation {
                    faults: vec![FaultInjection::Kidnapped { at_s: FAULT_S, to: before }],
                    ..one_leg
                }
            }
            LocalizationCase::KidnappedFar => Simulation {
                faults: vec![FaultInjection::Kidnapped {
                    at_s: FAULT_S,
                    to: self.far_pose(seed, config),
                }],
                ..one_leg
            },
            LocalizationCase::KidnappedToTwin => Simulation {
                faults: vec![FaultInjection::Kidnapped {
                    at_s: FAULT_S,
                    to: Pose::new(20.0, along(20.0).y + 1.0 + width_m, 0.0),
                }],
                ..roadway(twin_roadways(length_m, width_m))
            },
            LocalizationCase::Occluded => Simulation {
                faults: vec![FaultInjection::LidarOccluded { from_s, to_s }],
                ..one_leg
            },
            LocalizationCase::BrieflyOccluded => Simulation {
                faults: vec![FaultInjection::LidarOccluded { from_s, to_s: FAULT_S + 3.0 }],
                ..one_leg
            },
            LocalizationCase::OtherMap => {
                let own = roadway_scene();
                Simulation {
                    truth: Some(crossing().map.obstacles(config.unknown)),
                    ..seeded(Mission::new(Arc::new(own.map), own.start, stop(own.goal)))
                }
            }
        })
    }

    /// Enough legs for the tour's length.
    fn back_and_forth(
        &self,
        mut simulation: Simulation,
        config: &Config,
    ) -> Result<Simulation, SimError> {
        let length_m = self.leg_m(config)?;
        // The robot cuts corners, so one leg more.
        let legs = (self.tour_m / length_m).ceil() as usize + 1;
        let ends = [self.goal, self.start.position()];
        let mut stops: Vec<Goal> = (0..legs).map(|leg| stop(ends[leg % 2])).collect();
        let goal = stops.pop().unwrap_or_else(|| stop(self.goal));
        simulation.mission =
            Mission { via: stops, goal, time_limit_s: LONGEST_S, ..simulation.mission };
        Ok(simulation)
    }

    fn among_people(&self, one_leg: Simulation, config: &Config) -> Result<Simulation, SimError> {
        let ground = self.map.obstacles(config.unknown);
        let path = self.path(config)?;
        let ends = [self.start.position(), self.goal];
        let spawner = PedestrianSpawner::new(5, one_leg.seed);
        let moving_obstacles = spawner.spawn(&ground, &path, &ends)?;
        let tour = self.back_and_forth(one_leg, config)?;
        Ok(Simulation { moving_obstacles, ..tour })
    }

    /// The pose two metres behind the robot at the time of the fault, from a drive without it.
    fn place_behind(&self, config: &Config, one_leg: &Simulation) -> Result<Pose, SimError> {
        let mut simulation = one_leg.clone();
        simulation.mission.time_limit_s = FAULT_S;
        let mut clock = || 0.0;
        let mut no_action = |_: &TickEvent<'_>| {};
        let result = simulation.run(
            config,
            Box::new(CpuEngine::single_threaded()),
            &mut Observer { clock: &mut clock, on_tick: &mut no_action },
        )?;
        let rows = &result.trace.rows;
        let last = rows.last().map_or(self.start, |row| row.pose);
        let behind =
            rows.iter().rev().find(|row| (row.pose.position() - last.position()).norm() >= 2.0);
        Ok(behind.map_or(self.start, |row| row.pose))
    }

    /// A random free pose with room for the robot, far from the start.
    fn far_pose(&self, seed: u64, config: &Config) -> Pose {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
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
        let found = (0..TRIES).map(|_| any()).find(is_good);
        found.unwrap_or_else(|| Pose::new(self.goal.x, self.goal.y, 0.0))
    }

    fn path(&self, config: &Config) -> Result<Vec<Point>, SimError> {
        let ground = self.map.obstacles(config.unknown);
        let mut planner = config.route_planner(self.map.frame().resolution_m);
        let plan = planner
            .plan(&ground, self.start.position(), self.goal, &mut || 0.0)
            .map_err(|error| MissionError::from(Fault::Plan(error)))?;
        Ok(plan.smoothed.points().to_vec())
    }

    fn leg_m(&self, config: &Config) -> Result<f64, SimError> {
        let path = self.path(config)?;
        let lengths = path.windows(2).map(|leg| (leg[1] - leg[0]).norm());
        Ok(lengths.sum::<f64>().max(1.0))
    }
}

const fn stop(position: Point) -> Goal {
    Goal { position, yaw: None }
}
