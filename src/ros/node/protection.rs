//! The protective layer between the navigator and `cmd_vel`, and its status for diagnostics.

use crate::base::{OperatorState, OperatorSwitch, ProtectiveAction, ProtectiveLayer};
use crate::geometry::Twist;
use crate::map::TimedScan;
use crate::robot::TickTime;
use crate::ros::convert::key_value;
use crate::ros::msg::DiagnosticStatus;
use crate::runtime::Config;
use crate::settings::SettingError;

/// The protective layer of a node. Times are seconds by the node's clock.
#[derive(Debug)]
pub struct Protection {
    layer: ProtectiveLayer,
    /// What the layer does to the present command; nothing without one.
    action: ProtectiveAction,
}

impl Protection {
    /// The layer of a robot that is not armed.
    ///
    /// # Errors
    /// A setting or a limit out of range.
    pub fn new(config: &Config) -> Result<Self, SettingError> {
        Ok(Self {
            layer: config.protective_layer(config.local.control_period_s)?,
            action: ProtectiveAction::Pass,
        })
    }

    /// The operator's switch.
    pub fn operator(&self) -> OperatorSwitch {
        self.layer.operator()
    }

    /// State of the operator's switch.
    pub fn state(&self) -> OperatorState {
        self.layer.operator().state()
    }

    /// Takes a new scan as measured, in the robot's frame. The same scan must not come again.
    pub fn update_scan(&mut self, scan: &TimedScan) {
        if let Some(end_s) = scan.end_s() {
            self.layer.update_scan(scan, end_s);
        }
    }

    /// Takes the measured motion and its time.
    pub fn update_motion(&mut self, measured: &Twist, stamp_s: f64) {
        self.layer.update_motion(measured, stamp_s);
    }

    /// The command to publish instead of a wanted one, at a tick after the last command. Without the operator's permission it is
    /// zero at once.
    pub fn command(&mut self, wanted: &Twist, sent: &Twist, now_s: f64, tick: TickTime) -> Twist {
        let (limited, action) = self.layer.limit(wanted, sent, now_s);
        self.action = action;
        match self.action {
            ProtectiveAction::NotArmed | ProtectiveAction::OperatorStop => Twist::STOP,
            _ => self.layer.ramp(&limited, sent, tick),
        }
    }

    /// The node publishes no command.
    pub fn idle(&mut self) {
        self.action = ProtectiveAction::Pass;
    }

    /// What the layer does to the present command.
    pub const fn action(&self) -> &ProtectiveAction {
        &self.action
    }

    /// The status for `diagnostics`.
    pub fn status(&self) -> DiagnosticStatus {
        let state = self.state();
        let (level, message) = match (state, &self.action) {
            (OperatorState::NotArmed, _) => {
                (DiagnosticStatus::WARN, ProtectiveAction::NotArmed.to_string())
            }
            (OperatorState::Stopped, _) => {
                (DiagnosticStatus::WARN, ProtectiveAction::OperatorStop.to_string())
            }
            (OperatorState::Armed, action) if action.passes() => {
                (DiagnosticStatus::OK, state.name().to_owned())
            }
            (OperatorState::Armed, action) => (DiagnosticStatus::WARN, action.to_string()),
        };
        let (delay_s, braking_m_s2) = self.layer.stopping();
        DiagnosticStatus {
            level,
            name: "inbye: protection".to_owned(),
            message,
            hardware_id: String::new(),
            values: vec![
                key_value("operator", state.name()),
                key_value("action", self.action.name()),
                key_value("delay_s", delay_s),
                key_value("braking_m_s2", braking_m_s2),
            ],
        }
    }
}
