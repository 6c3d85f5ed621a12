//! A mission whose velocities the caller chooses, tick by tick.

use super::{SimError, SimulatedRobot, Simulation};
use crate::base::{BaseError, ProtectiveAction, require_finite};
use crate::geometry::{Pose, Twist, wrap_angle};
use crate::map::Scan;
use crate::robot::Limits;
use crate::runtime::{CompensatedScan, Config, Mission, MissionEnd, Robot, SensorData};
use crate::settings::require;

/// A simulated robot on a mission without a navigator: it does what the caller commands, within the limits of its base and below
/// its protective layer.
pub struct Episode {
    robot: SimulatedRobot,
    mission: Mission,
    tolerances: (f64, f64),
    limits: Limits,
    period_s: f64,
    ticks: u64,
    sensed: SensorData,
    compensated: CompensatedScan,
    scan: Scan,
    command: Twist,
    end: Option<MissionEnd>,
}

crate::settings::opaque_debug!(Episode);

impl Episode {
    /// Puts the robot at the start of the mission.
    ///
    /// # Errors
    /// Names the first setting that is out of range.
    pub fn new(simulation: &Simulation, config: &Config) -> Result<Self, SimError> {
        let mut robot = simulation.robot(config)?;
        let goal = simulation.mission.goal.position;
        for (name, value) in [("x of the goal", goal.x), ("y of the goal", goal.y)] {
            require(value.is_finite(), name, value, "finite")?;
        }
        let (mission, period_s) = (&simulation.mission, config.local.control_period_s);
        let sensed = robot.sense(0.0);
        let mut episode = Self {
            robot,
            mission: mission.clone(),
            tolerances: (config.navigator.xy_goal_tolerance, config.navigator.yaw_goal_tolerance),
            limits: config.robot.limits,
            period_s,
            ticks: 0,
            sensed,
            compensated: CompensatedScan::new(),
            scan: Scan::default(),
            command: Twist::STOP,
            end: None,
        };
        episode.update_scan();
        episode.end = episode.find_end();
        Ok(episode)
    }

    /// Drives with a velocity, clamped to the limits of the base, for one control period, and senses. Does nothing once the
    /// episode has ended.
    ///
    /// # Errors
    /// [`BaseError::NotFinite`].
    pub fn step(&mut self, command: &Twist) -> Result<Option<MissionEnd>, BaseError> {
        let command = self.limits.clamp(require_finite(command)?);
        if self.end.is_none() {
            // A simulated base never stops for good.
            let _ = self.robot.drive(&command, self.period_s);
            self.command = command;
            self.ticks += 1;
            self.sensed = self.robot.sense(self.time_s());
            self.update_scan();
            self.end = self.find_end();
        }
        Ok(self.end)
    }

    fn update_scan(&mut self) {
        let SensorData { odometry, odometry_s, lidar, .. } = &self.sensed;
        self.scan = self.compensated.update((*odometry_s, &odometry.pose), lidar.clone());
    }

    /// The goal is reached by the mission's rule. Without one the robot must stand within the goal's tolerances.
    fn find_end(&self) -> Option<MissionEnd> {
        let (pose, twist) = (self.pose(), self.twist());
        if self.robot.touches() {
            return Some(MissionEnd::Contact);
        }
        let is_reached = if self.mission.done_within_m.is_some() {
            self.mission.is_done(pose)
        } else {
            let goal = &self.mission.goal;
            let away_m = (pose.position() - goal.position).norm();
            let turn = goal.yaw.map_or(0.0, |yaw| wrap_angle(pose.yaw - yaw));
            twist.stands() && away_m <= self.tolerances.0 && turn.abs() <= self.tolerances.1
        };
        if is_reached {
            return Some(MissionEnd::Reached);
        }
        (self.ticks >= self.mission.ticks(self.period_s)).then_some(MissionEnd::Timeout)
    }

    /// Time since the start, seconds.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.ticks as f64 * self.period_s
    }

    /// What the robot senses now.
    #[must_use]
    pub const fn sensed(&self) -> &SensorData {
        &self.sensed
    }

    /// The lidar's scan in the robot's frame now, as a navigator gets it.
    #[must_use]
    pub const fn scan(&self) -> &Scan {
        &self.scan
    }

    /// True pose now.
    #[must_use]
    pub const fn pose(&self) -> &Pose {
        self.robot.pose()
    }

    /// True motion now.
    #[must_use]
    pub const fn twist(&self) -> &Twist {
        self.robot.twist()
    }

    /// The command of the last step within the limits of the base, before the protective layer; zero before the first step.
    #[must_use]
    pub const fn command(&self) -> &Twist {
        &self.command
    }

    /// What the protective layer did with it.
    #[must_use]
    pub fn protective_action(&self) -> ProtectiveAction {
        self.robot.protective_action()
    }

    /// Smallest gap between the robot and anything solid since the last step, metres.
    #[must_use]
    pub fn gap_m(&self) -> f64 {
        self.robot.gap_m()
    }

    /// How the episode ended; none while it runs.
    #[must_use]
    pub const fn end(&self) -> Option<MissionEnd> {
        self.end
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::geometry::Point;
    use crate::map::OccupancyGrid;
    use crate::navigator::Goal;

    fn episode(goal: Point, time_limit_s: f64) -> Episode {
        let rows = vec![".".repeat(80); 40];
        let map = OccupancyGrid::from_rows(&rows, 0.1, Pose::default());
        let start = Pose::new(2.0, 2.0, 0.0);
        let mission = Mission::new(Arc::new(map.expect("a map")), start, Goal::at(goal));
        let simulation = Simulation::new(Mission { time_limit_s, ..mission });
        Episode::new(&simulation, &Config::default()).expect("valid settings")
    }

    fn drive(mut episode: Episode, command: Twist) -> Episode {
        while episode.step(&command).expect("a finite command").is_none() {}
        episode
    }

    #[test]
    fn episode_ends_at_a_wall_at_the_time_limit_and_where_the_robot_stands_at_the_goal() {
        let forward = Twist::new(0.3, 0.0);
        let away = drive(episode(Point::new(7.5, 3.5), 60.0), forward);
        // The protective layer below the caller stops the robot before the wall.
        assert!(!away.protective_action().passes());
        assert_eq!(away.command(), &forward);
        assert_eq!(away.end(), Some(MissionEnd::Timeout));
        assert!(away.pose().x > 6.0 && away.gap_m() > 0.0);
        assert!((away.time_s() - 60.0).abs() < 1e-9);

        let mut fast = episode(Point::new(7.5, 3.5), 60.0);
        assert_eq!(fast.step(&Twist::new(9.0, -9.0)), Ok(None));
        assert_eq!(fast.command(), &Twist::new(1.0, -1.0));

        let mut passing = episode(Point::new(3.0, 2.0), 60.0);
        while passing.pose().x < 2.9 {
            assert_eq!(passing.step(&forward), Ok(None));
        }
        assert_eq!(drive(passing, Twist::STOP).end(), Some(MissionEnd::Reached));
    }

    #[test]
    fn episode_rejects_a_velocity_that_is_not_finite() {
        let mut episode = episode(Point::new(7.5, 3.5), 60.0);
        assert!(episode.step(&Twist::new(f64::NAN, 0.0)).is_err());
        assert_eq!(episode.time_s(), 0.0);
    }
}
