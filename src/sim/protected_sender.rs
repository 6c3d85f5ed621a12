//! The sender of a simulated base: its protective layer and its ramp.

use crate::base::{ProtectiveAction, ProtectiveLayer};
use crate::geometry::Twist;
use crate::robot::TickClock;
use crate::runtime::{Config, LidarData};
use crate::settings::SettingError;

/// Limits commands as the sender of a real base does.
pub(super) struct ProtectedSender {
    layer: ProtectiveLayer,
    tick_clock: TickClock,
    /// The last command after protection.
    pub sent: Twist,
}

impl ProtectedSender {
    /// # Errors
    /// Names the first setting out of range.
    pub fn new(config: &Config) -> Result<Self, SettingError> {
        let period_s = config.local.control_period_s;
        let mut layer = config.protective_layer(period_s)?;
        // A simulated robot needs no operator.
        layer.arm();
        let tick_clock = TickClock::new(period_s);
        Ok(Self { layer, tick_clock, sent: Twist::STOP })
    }

    /// The command that the sender lets through at a time, seconds.
    pub fn protected(&mut self, command: &Twist, time_s: f64) -> Twist {
        let (limited, _) = self.layer.limit(command, &self.sent, time_s);
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
