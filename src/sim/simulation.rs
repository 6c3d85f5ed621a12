//! A mission in a simulated world, and the simulated robot that drives it.

use core::ops::ControlFlow;

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::fault_injection::{Kidnapping, degraded_range};
use super::fixes::SimulatedPositioning;
use super::{FaultInjection, MovingObstacles, SimBase, SimError};
use crate::geometry::{Pose, Twist};
use crate::local::Engine;
use crate::localization::PoseHistory;
use crate::map::{MovingDisc, ObstacleGrid};
use crate::robot::Footprint;
use crate::runtime::{
    Config, GroundTruth, LidarData, Mission, MissionResult, Observer, ObstacleGap, PoseSource,
    Robot, SensorData, run_mission,
};

/// A mission and its world.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// The mission.
    pub mission: Mission,
    /// True static obstacles, where they differ from the map.
    pub truth: Option<ObstacleGrid>,
    /// The moving obstacles.
    pub moving_obstacles: MovingObstacles,
    /// Faults that happen to the robot.
    pub faults: Vec<FaultInjection>,
    /// Seed of all noise.
    pub seed: u64,
}

impl Simulation {
    /// Creates a simulation in which the map is true and nothing else moves; its seed is zero.
    #[must_use]
    pub fn new(mission: Mission) -> Self {
        Self {
            mission,
            truth: None,
            moving_obstacles: MovingObstacles::default(),
            faults: Vec::new(),
            seed: 0,
        }
    }

    /// Runs the mission with a simulated base.
    ///
    /// # Errors
    /// As [`run_mission`].
    pub fn run(
        &self,
        config: &Config,
        engine: Box<dyn Engine>,
        observer: &mut Observer<'_>,
    ) -> Result<MissionResult, SimError> {
        let mut base = SimBase::of(config, self.mission.start, self.seed)?;
        self.run_with(&mut base, config, engine, observer)
    }

    /// Runs the mission with another base, real or simulated, which stands at the mission's start. Its own lidar and
    /// positioning are not used: both are simulated at its true pose. A base without a true pose counts as being at the pose
    /// of its odometry.
    ///
    /// # Errors
    /// As [`run_mission`].
    pub fn run_with(
        &self,
        base: &mut dyn Robot,
        config: &Config,
        engine: Box<dyn Engine>,
        observer: &mut Observer<'_>,
    ) -> Result<MissionResult, SimError> {
        config.validate()?;
        let mut robot = SimulatedRobot::new(self, config, base)?;
        let result = run_mission(&self.mission, config, engine, &mut robot, observer);
        Ok(result?)
    }
}

/// A base in a simulated world, with a simulated lidar and simulated positioning.
struct SimulatedRobot<'a> {
    simulation: &'a Simulation,
    config: &'a Config,
    base: &'a mut dyn Robot,
    world: World,
    moving_obstacles: MovingObstacles,
    kidnapping: Kidnapping,
    /// Time of the last sensing, seconds, and the truth then.
    time_s: f64,
    pose: Pose,
    twist: Twist,
    /// Recent true poses.
    true_poses: PoseHistory,
    lidar_rng: Pcg64Mcg,
    positioning: Option<SimulatedPositioning>,
}

impl<'a> SimulatedRobot<'a> {
    fn new(
        simulation: &'a Simulation,
        config: &'a Config,
        base: &'a mut dyn Robot,
    ) -> Result<Self, SimError> {
        let Simulation { mission, seed, .. } = simulation;
        let known = || mission.map.obstacles(config.unknown);
        let truth = simulation.truth.clone().unwrap_or_else(known);
        let positioning = match config.pose_source {
            PoseSource::Fixes => {
                Some(SimulatedPositioning::new(config.simulation.fixes, mission.start, *seed)?)
            }
            PoseSource::Scans => None,
        };
        Ok(Self {
            simulation,
            config,
            base,
            world: World::new(truth),
            moving_obstacles: simulation.moving_obstacles.clone(),
            kidnapping: Kidnapping::default(),
            time_s: 0.0,
            pose: mission.start,
            twist: Twist::STOP,
            true_poses: PoseHistory::new(),
            lidar_rng: Pcg64Mcg::seed_from_u64(*seed),
            positioning,
        })
    }

    fn scan(&mut self) -> LidarData {
        let lidar = &self.config.simulation.lidar;
        let (faults, time_s) = (&self.simulation.faults, self.time_s);
        let true_poses = &self.true_poses;
        let pose_at = |time_s: f64| true_poses.at(time_s).unwrap_or_default();
        if lidar.sweep_s > 0.0 {
            let mut sweep = lidar.sweep(&self.world, pose_at, time_s, &mut self.lidar_rng);
            for beam in &mut sweep.beams {
                beam.range = degraded_range(faults, beam.time_s, beam.range);
            }
            return LidarData::TimedScan(sweep);
        }
        let pose = pose_at(time_s);
        let mut scan = lidar.scan(&self.world, &pose, &mut self.lidar_rng).scan;
        for range in &mut scan.ranges {
            *range = degraded_range(faults, time_s, *range);
        }
        LidarData::Scan(scan)
    }
}

impl Robot for SimulatedRobot<'_> {
    fn sense(&mut self, time_s: f64) -> SensorData {
        self.time_s = time_s;
        self.world.moving = self.moving_obstacles.discs();
        let odometry = self.base.sense(time_s).odometry;
        let (own, twist) = match self.base.ground_truth() {
            Some(truth) => (truth.pose, truth.twist),
            None => (odometry.pose, odometry.twist),
        };
        self.pose = self.kidnapping.pose(&self.simulation.faults, time_s, &own);
        self.twist = twist;
        self.true_poses.record(time_s, &self.pose);
        let lidar = self.scan();
        let true_pose = &self.pose;
        let positioning = self.positioning.as_mut();
        SensorData {
            odometry,
            lidar: Some(lidar),
            pose: positioning.map(|it| it.pose(time_s, &odometry.pose, true_pose)),
        }
    }

    fn ground_truth(&self) -> Option<GroundTruth> {
        let footprint = &self.config.robot.footprint;
        let places = self.moving_obstacles.states();
        Some(GroundTruth {
            pose: self.pose,
            twist: self.twist,
            gap_m: Some(self.world.gap_m(footprint, &self.pose)),
            moving: places.iter().map(|place| place.as_ref().map(MovingDisc::center)).collect(),
        })
    }

    fn moving_radii_m(&self) -> Vec<f64> {
        self.moving_obstacles.radii()
    }

    fn drive(&mut self, command: &Twist, period_s: f64) -> ControlFlow<()> {
        let flow = self.base.drive(command, period_s);
        let own = match self.base.ground_truth() {
            Some(truth) => truth.pose,
            None => self.base.sense(self.time_s + period_s).odometry.pose,
        };
        let pose = self.kidnapping.pose_in_map(&own);
        self.moving_obstacles.step(period_s, &pose, &self.config.robot.footprint);
        flow
    }

    fn fault(&self) -> Option<String> {
        self.base.fault()
    }
}

/// Everything that the robot can touch. All gaps are in metres, exact to rounding; at or below zero there is contact.
#[derive(Clone, Debug)]
pub struct World {
    obstacles: ObstacleGap,
    /// Moving obstacles at their present positions.
    pub moving: Vec<MovingDisc>,
}

impl World {
    /// Creates a world without moving obstacles.
    #[must_use]
    pub fn new(obstacles: ObstacleGrid) -> Self {
        Self { obstacles: ObstacleGap::new(obstacles), moving: Vec::new() }
    }

    /// The static obstacles.
    #[must_use]
    pub const fn obstacles(&self) -> &ObstacleGrid {
        self.obstacles.obstacles()
    }

    /// The smallest gap between the footprint and anything solid.
    #[must_use]
    pub fn gap_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        self.gap_to_static_m(footprint, pose).min(self.gap_to_moving_m(footprint, pose))
    }

    /// The smallest gap between the footprint and the static obstacles: see [`ObstacleGap::gap_m`].
    #[must_use]
    pub fn gap_to_static_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        self.obstacles.gap_m(footprint, pose)
    }

    /// The smallest gap between the footprint and the moving obstacles; infinite without any.
    #[must_use]
    pub fn gap_to_moving_m(&self, footprint: &Footprint, pose: &Pose) -> f64 {
        self.moving
            .iter()
            .map(|disc| footprint.gap_to_disc_m(pose, &disc.center(), disc.radius))
            .fold(f64::INFINITY, f64::min)
    }
}
