//! The interface between the control loop and a robot, simulated or real.

use core::ops::ControlFlow;

use super::{Contact, LidarData};
use crate::base::ProtectiveAction;
use crate::geometry::{Point, Pose, Twist};
use crate::navigator::Observation;

/// Motion of the base as its own sensors measure it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometryReading {
    /// Pose in REP-105's `odom` frame, which is placed so that the pose is true at the start. It never jumps, and its error
    /// grows without bound.
    pub pose: Pose,
    /// Measured motion: mean speed of the belts and turn rate of the gyro.
    pub twist: Twist,
}

/// Sensor data of one tick.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorData {
    /// The motion that the base measures.
    pub odometry: OdometryReading,
    /// Time of that measurement, seconds, by the clock of the mission.
    pub odometry_s: f64,
    /// The newest lidar data; none for a robot without a lidar.
    pub lidar: Option<LidarData>,
    /// Pose in the map by the robot's own positioning; none for a robot without one.
    pub pose: Option<Pose>,
    /// Time of the last measurement that corrected that pose, seconds, by the clock of the mission. None where it is unknown: the
    /// pose is then as old as the odometry.
    pub pose_s: Option<f64>,
    /// The command that the sender sent last, after its protective layer; none where that is unknown.
    pub sent: Option<Twist>,
}

/// True state of a robot and its surroundings, for a robot in a known world.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct GroundTruth {
    /// True pose in the map.
    pub pose: Pose,
    /// True motion.
    pub twist: Twist,
    /// Smallest gap between the footprint and anything solid, metres. None: the control loop measures the gap on the map.
    pub gap_m: Option<f64>,
    /// The contact since the last sensing, or at this one.
    pub contact: Option<Contact>,
    /// Centre of each moving obstacle; none for one that has not yet appeared.
    pub moving: Vec<Option<Point>>,
}

impl GroundTruth {
    /// The state of a robot as it observes it, with a measured motion. The pose of a lost robot is no place on the map: it has no gap
    /// there.
    pub(crate) fn of(observation: &Observation, twist: Twist) -> Self {
        let Observation { pose, lost, .. } = *observation;
        let gap_m = lost.map(|_| f64::INFINITY);
        Self { pose, twist, gap_m, contact: None, moving: Vec::new() }
    }
}

/// A robot as the control loop drives it.
///
/// The loop calls [`Robot::sense`], [`Robot::ground_truth`], [`Robot::drive`] and [`Robot::fault`] once in each tick, in this
/// order.
pub trait Robot {
    /// Returns the sensor data at a time of the mission, seconds.
    fn sense(&mut self, time_s: f64) -> SensorData;

    /// Returns the truth at the time of the last [`Robot::sense`]. None: the loop uses its own estimate of the pose, the
    /// measured motion and the map instead.
    fn ground_truth(&self) -> Option<GroundTruth> {
        None
    }

    /// Radius of each moving obstacle, metres, in the order of [`GroundTruth::moving`].
    fn moving_radii_m(&self) -> Vec<f64> {
        Vec::new()
    }

    /// The present time by the robot's clock, seconds from any origin, where time passes by itself, as for every real robot. The
    /// mission's time, its time limit and every age are then measured by this clock. The loop waits for no plan, and a decision
    /// has a deadline: see [`Config::in_real_time`](super::Config::in_real_time). None: each tick takes one control period.
    fn now_s(&self) -> Option<f64> {
        None
    }

    /// Executes a finite command for one control period, seconds, of simulated time, or until the next tick is due. Returns a
    /// break where the robot has stopped for good, which ends the mission.
    fn drive(&mut self, command: &Twist, period_s: f64) -> ControlFlow<()>;

    /// What the protective layer of the robot's sender does to the present command.
    fn protective_action(&self) -> ProtectiveAction {
        ProtectiveAction::Pass
    }

    /// Describes the robot's present fault in one sentence.
    fn fault(&self) -> Option<String> {
        None
    }

    /// Ends the mission: nothing is sensed or driven after it. Returns a break if the drive turns out not to be valid, for the reason
    /// of [`Robot::fault`].
    fn finish(&mut self) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

impl<R: Robot + ?Sized> Robot for &mut R {
    fn sense(&mut self, time_s: f64) -> SensorData {
        (**self).sense(time_s)
    }

    fn ground_truth(&self) -> Option<GroundTruth> {
        (**self).ground_truth()
    }

    fn moving_radii_m(&self) -> Vec<f64> {
        (**self).moving_radii_m()
    }

    fn now_s(&self) -> Option<f64> {
        (**self).now_s()
    }

    fn drive(&mut self, command: &Twist, period_s: f64) -> ControlFlow<()> {
        (**self).drive(command, period_s)
    }

    fn protective_action(&self) -> ProtectiveAction {
        (**self).protective_action()
    }

    fn fault(&self) -> Option<String> {
        (**self).fault()
    }

    fn finish(&mut self) -> ControlFlow<()> {
        (**self).finish()
    }
}
