//! What the node waits for, and its statuses for `diagnostics`.

use super::NodeCore;
use crate::ros::convert::key_value;
use crate::ros::msg::{DiagnosticArray, DiagnosticStatus};
use crate::ros::node::latest_inputs::OdometryFrame;
use crate::ros::node::localization::NodeLocalization;
use crate::ros::node::notices::MissingInput;

/// The pose of the odometry's frame in the map, where all inputs are there; or the first that is missing.
pub type Inputs = Result<OdometryFrame, MissingInput>;

impl NodeCore {
    /// Looks for the inputs of a decision.
    pub(super) fn check_inputs(&self, now_s: f64, odometry_frame: Inputs) -> Inputs {
        let frame = odometry_frame?;
        self.inputs.check(now_s, &self.age_limits(), &frame)?;
        if let Some(missing) = self.missing_zones() {
            return Err(missing);
        }
        match frame {
            // A navigator plans from a known pose; later it judges itself how long the pose may be unknown.
            OdometryFrame::Measured { lost: Some(reason), .. } if self.navigator.is_none() => {
                Err(MissingInput::Pose(reason))
            }
            _ => Ok(frame),
        }
    }

    /// The statuses for `diagnostics`, when they change and once a second.
    pub(super) fn diagnose(&mut self, now_s: f64, inputs: &Inputs) -> Option<DiagnosticArray> {
        let localization = self.localization.as_ref().map(NodeLocalization::status);
        let of_inputs = Some(self.inputs_status(now_s, inputs));
        let protection = Some(self.protection.status());
        let statuses = [protection, of_inputs, localization, self.engine.status()];
        self.diagnostics.message(now_s, statuses.into_iter().flatten().collect())
    }

    /// The status of the inputs, with the name of its state. It needs no goal.
    fn inputs_status(&self, now_s: f64, inputs: &Inputs) -> (DiagnosticStatus, Vec<&'static str>) {
        let timeout_s = self.settings.config.navigator.scan_timeout_s;
        let missing = match inputs {
            Err(missing) => Some(missing.to_string()),
            Ok(_) if self.inputs.scan_age_s(now_s) > timeout_s => {
                Some(MissingInput::RecentScan.to_string())
            }
            Ok(_) => None,
        };
        let (level, name) = match missing {
            Some(_) => (DiagnosticStatus::WARN, "waiting"),
            None => (DiagnosticStatus::OK, "complete"),
        };
        let message = missing.map_or_else(
            || "all inputs are received".to_owned(),
            |missing| format!("waiting: {missing}"),
        );
        let status = DiagnosticStatus {
            level,
            name: "inbye: inputs".to_owned(),
            message,
            hardware_id: String::new(),
            values: vec![key_value("status", name)],
        };
        (status, vec![name])
    }
}
