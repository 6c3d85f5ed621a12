//! The sender of a simulated base: its protective layer and its ramp.

use super::FaultInjection;
use super::wrong_planner::WrongCommands;
use crate::base::{ProtectiveAction, ProtectiveLayer};
use crate::geometry::{Pose, Twist};
use crate::map::MovingDisc;
use crate::robot::TickClock;
use crate::runtime::{Config, LidarData};
use crate::settings::SettingError;

/// Limits commands as the sender of a real base does.
pub(super) struct ProtectedSender {
    layer: ProtectiveLayer,
    tick_clock: TickClock,
    wrong_commands: WrongCommands,
    /// The last command after protection.
    pub sent: Twist,
}

impl ProtectedSender {
    /// # Errors
    /// Names the first setting out of range.
    pub fn new(config: &Config, seed: u64) -> Result<Self, SettingError> {
        let period_s = config.local.control_period_s;
        let mut layer = config.protective_layer(period_s)?;
        // A simulated robot needs no operator.
        layer.arm();
        let tick_clock = TickClock::new(period_s);
        let planner = config.simulation.wrong_planner;
        let wrong_commands = WrongCommands::new(planner, config.robot.limits, seed);
        Ok(Self { layer, tick_clock, wrong_commands, sent: Twist::STOP })
    }

    /// The command that the sender lets through at a time, seconds. A wrong planner drives the robot at its true pose among people.
    pub fn protected(
        &mut self,
        command: &Twist,
        faults: &[FaultInjection],
        time_s: f64,
        (pose, people): (&Pose, &[MovingDisc]),
    ) -> Twist {
        let command = self.wrong_commands.instead(command, faults, time_s, pose, people);
        let (limited, _) = self.layer.limit(&command, &self.sent, time_s);
        let tick = self.tick_clock.tick(time_s);
        self.sent = self.layer.ramp(&limited, &self.sent, tick);
        self.sent
    }

    /// Takes the raw data of a tick at a time, seconds: the measured motion with its time, and the lidar's.
    pub fn update(
        &mut self,
        time_s: f64,
        (measured, measured_s): (&Twist, f64),
        lidar: &LidarData,
    ) {
        self.layer.update_motion(measured, measured_s);
        let end_s = lidar.end_s(measured_s).unwrap_or(time_s);
        self.layer.update_scan(&lidar.timed(measured_s), end_s);
    }

    /// What the layer does to the present command.
    pub fn action(&self) -> ProtectiveAction {
        self.layer.action().clone()
    }
}
