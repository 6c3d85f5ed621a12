//! Other nodes that publish or serve what only this node should.

use std::collections::{BTreeMap, BTreeSet};

use super::incoming::{COMMAND, NAVIGATE};
use crate::ros::msg::DiagnosticStatus;

/// The topic of transforms.
const TRANSFORMS: &str = "tf";
/// Time for which a transform of another node counts, seconds.
const TRANSFORM_S: f64 = 5.0;

/// Other publishers and servers, and those that are reported already.
#[derive(Debug, Default)]
pub struct Conflicts {
    /// Until when each counts, by its topic or action, seconds.
    present_until_s: BTreeMap<&'static str, f64>,
    reported: BTreeSet<&'static str>,
}

impl Conflicts {
    /// Another node publishes on a topic or serves an action, or no longer does.
    pub fn set_publisher(&mut self, topic: &'static str, is_present: bool) {
        if is_present {
            self.present_until_s.insert(topic, f64::INFINITY);
        } else {
            self.present_until_s.remove(topic);
        }
    }

    /// Another node published the transform that this node publishes, at a time, seconds.
    pub fn set_transform(&mut self, now_s: f64) {
        self.present_until_s.insert(TRANSFORMS, now_s + TRANSFORM_S);
    }

    /// The transport was lost: a new one finds the other nodes again.
    pub fn forget(&mut self) {
        self.present_until_s.clear();
    }

    /// The topics and actions that another node has too, at a time, seconds.
    pub fn present(&self, now_s: f64) -> impl Iterator<Item = &'static str> + Clone {
        self.present_until_s
            .iter()
            .filter(move |(_, until_s)| **until_s >= now_s)
            .map(|(it, _)| *it)
    }

    /// A notice of those that are not reported yet.
    pub fn notice(&mut self, now_s: f64) -> Option<String> {
        let new: Vec<_> = self.present(now_s).filter(|it| !self.reported.contains(it)).collect();
        self.reported.extend(&new);
        (!new.is_empty()).then(|| text(new.into_iter()))
    }

    /// The status for `diagnostics`.
    pub fn status(&self, now_s: f64) -> DiagnosticStatus {
        let message = text(self.present(now_s));
        let (level, message) = if message.is_empty() {
            (DiagnosticStatus::OK, "no other node controls this robot".to_owned())
        } else {
            (DiagnosticStatus::WARN, message)
        };
        let (name, hardware_id) = ("inbye: other nodes".to_owned(), String::new());
        DiagnosticStatus { level, name, message, hardware_id, values: Vec::new() }
    }
}

/// What is wrong, and what to do.
fn text(topics: impl Iterator<Item = &'static str>) -> String {
    let of_topic = |topic| match topic {
        COMMAND => {
            "another node publishes on cmd_vel too, and the base gets the commands of both: stop one of them, or put a multiplexer \
             such as twist_mux in between"
        }
        NAVIGATE => {
            "another node serves the action navigate_to_pose too, and both pursue each goal: stop one of them, or start them in \
             different namespaces"
        }
        _ => {
            "another node publishes the odometry's frame in the map on tf too: stop that localization node (AMCL, SLAM), or set \
             another pose_source than \"scans\""
        }
    };
    topics.map(of_topic).collect::<Vec<_>>().join("; ")
}
