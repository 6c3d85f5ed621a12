//! A mission in a simulated world.

use super::process_robot::ProcessRobot;
use super::warped_map::warped;
use super::{FaultInjection, MovingObstacles, SimBase, SimError, SimulatedRobot, draw_plant};
use crate::map::ObstacleGrid;
use crate::runtime::{Config, Decider, Mission, MissionResult, Observer, Robot, run_mission};
use crate::settings::SettingError;

/// A mission and its world.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// The mission.
    pub mission: Mission,
    /// True static obstacles, where they differ from the map.
    pub truth: Option<ObstacleGrid>,
    /// The moving obstacles.
    pub moving_obstacles: MovingObstacles,
    /// Faults that happen to the robot. In the simulator of the settings they can only be wrong planners.
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

    /// The true static obstacles: those of [`Self::truth`] or of the map, with the error of the map.
    #[must_use]
    pub fn true_obstacles(&self, config: &Config) -> ObstacleGrid {
        let error_m = draw_plant(config, self.seed).map_error_m;
        let known = || self.mission.map.obstacles(config.unknown);
        let truth = self.truth.clone().unwrap_or_else(known);
        if error_m > 0.0 { warped(&truth, error_m, self.seed) } else { truth }
    }

    /// The simulated robot at the start of the mission: it can be run tick by tick by a
    /// [`MissionRun`](crate::runtime::MissionRun), or by a caller who decides everything.
    ///
    /// # Errors
    /// Names the first setting, or number of a fault, that is out of range.
    pub fn robot(&self, config: &Config) -> Result<SimulatedRobot, SimError> {
        config.validate()?;
        self.mission.validate()?;
        SimulatedRobot::new(self, config, SimBase::of(config, self.mission.start, self.seed)?)
    }

    /// Checks the faults; an error names the index of the first wrong one.
    pub(super) fn check_faults(&self) -> Result<(), SettingError> {
        for (index, fault) in self.faults.iter().enumerate() {
            fault.validate().map_err(|error| error.in_table(&format!("faults.{index}")))?;
        }
        Ok(())
    }

    /// Runs the mission with a simulated base, or in the simulator of the settings if they name a program.
    ///
    /// # Errors
    /// As [`run_mission`], for a number of a fault out of range, and when that program cannot be started or cannot inject a fault.
    pub fn run(
        &self,
        config: &Config,
        decider: impl Into<Decider>,
        observer: &mut Observer<'_>,
    ) -> Result<MissionResult, SimError> {
        let mut robot: Box<dyn Robot> = if config.simulator.is_set() {
            config.validate()?;
            Box::new(ProcessRobot::start(self, config)?)
        } else {
            Box::new(self.robot(config)?)
        };
        Ok(run_mission(&self.mission, config, decider, &mut *robot, observer)?)
    }

    /// Starts the simulator of the settings and ends it.
    ///
    /// # Errors
    /// When it cannot be started, or its first answers are wrong.
    #[cfg(feature = "experiment")]
    pub(crate) fn check_simulator(&self, config: &Config) -> Result<(), SimError> {
        ProcessRobot::start(self, config).map(drop)
    }

    /// Runs the mission with another base, real or simulated, which stands at the mission's start. Its own lidar and
    /// positioning are not used: both are simulated at its true pose. A base without a true pose counts as being at the pose
    /// of its odometry.
    ///
    /// # Errors
    /// As [`run_mission`], and for a number of a fault out of range.
    pub fn run_with(
        &self,
        base: &mut dyn Robot,
        config: &Config,
        decider: impl Into<Decider>,
        observer: &mut Observer<'_>,
    ) -> Result<MissionResult, SimError> {
        config.validate()?;
        let mut robot = SimulatedRobot::new(self, config, base)?;
        Ok(run_mission(&self.mission, config, decider, &mut robot, observer)?)
    }
}
