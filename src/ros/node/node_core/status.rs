//! What the node waits for, and its statuses for `diagnostics`.

use super::NodeCore;
use crate::local::Engine;
use crate::ros::convert::key_value;
use crate::ros::msg::{DiagnosticArray, DiagnosticStatus, Header, Time};
use crate::ros::node::latest_inputs::{OdometryFrame, ReadyInputs};
use crate::ros::node::localization::NodeLocalization;
use crate::ros::node::notices::MissingInput;

/// The inputs of a decision, or the first that is missing.
pub type Inputs = Result<ReadyInputs, MissingInput>;

impl NodeCore {
    /// Looks for the inputs of a decision.
    pub(super) fn check_inputs(
        &self,
        now_s: f64,
        odometry_frame: Result<OdometryFrame, MissingInput>,
    ) -> Inputs {
        let ready = self.inputs.ready(now_s, &self.age_limits(), &odometry_frame?)?;
        if let Some(missing) = self.zones.missing() {
            return Err(missing.clone());
        }
        match ready.lost {
            // A navigator plans from a known pose; later it judges itself how long the pose may be unknown.
            Some(reason) if self.navigator.is_none() => Err(MissingInput::Pose(reason)),
            _ => Ok(ready),
        }
    }

    /// The statuses for `diagnostics`, when they change and once a second.
    pub(super) fn diagnose(&mut self, now_s: f64, inputs: &Inputs) -> Option<DiagnosticArray> {
        let timeout_s = self.settings.config.navigator.scan_timeout_s;
        let missing = match inputs {
            Err(missing) => Some(missing),
            Ok(_) if self.inputs.scan_age_s(now_s) <= timeout_s => None,
            Ok(_) if self.inputs.scan_delay.is_recent(now_s, timeout_s) => {
                Some(&MissingInput::OldScan)
            }
            Ok(_) => Some(&MissingInput::RecentScan),
        };
        let rejected = self.rejected_grids.keys().copied();
        let inputs_state = match missing {
            Some(_) => "waiting",
            None if self.rejected_grids.is_empty() => "complete",
            None => "rejected",
        };
        let states = [
            self.protection.state().name(),
            self.protection.action().name(),
            inputs_state,
            self.localization.as_ref().map_or("", NodeLocalization::state),
            self.engine.kind(),
        ];
        let states = states.into_iter().chain(self.conflicts.present(now_s)).chain(rejected);
        if !self.diagnostics.is_due(now_s, states) {
            return None;
        }
        let statuses = [
            Some(self.protection.status()),
            Some(self.inputs_status(missing, inputs_state)),
            Some(self.conflicts.status(now_s)),
            self.localization.as_ref().map(NodeLocalization::status),
            self.engine.status(),
        ];
        let header = Header { stamp: Time::from_seconds(now_s), ..Header::default() };
        Some(DiagnosticArray { header, status: statuses.into_iter().flatten().collect() })
    }

    /// The status of the inputs. It needs no goal.
    fn inputs_status(&self, missing: Option<&MissingInput>, state: &str) -> DiagnosticStatus {
        let names = &self.settings.names;
        let missing = missing.map(|missing| format!("waiting: {missing}"));
        let rejected = self.rejected_grids.iter().map(|(topic, error)| {
            format!(
                "the newest message on {} is rejected and not used: {error}",
                names.shown(topic)
            )
        });
        let faults: Vec<String> = missing.into_iter().chain(rejected).collect();
        let (level, message) = if faults.is_empty() {
            (DiagnosticStatus::OK, "all inputs are received".to_owned())
        } else {
            (DiagnosticStatus::WARN, faults.join("; "))
        };
        DiagnosticStatus {
            level,
            name: "inbye: inputs".to_owned(),
            message,
            hardware_id: String::new(),
            values: vec![key_value("status", state)],
        }
    }
}
