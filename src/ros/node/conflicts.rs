//! Other nodes that publish or serve what only this node should, or that use its topics with other types.

use std::collections::{BTreeMap, BTreeSet};

use super::incoming::{COMMAND, NAVIGATE};
use super::names::NodeNames;
use crate::ros::msg::DiagnosticStatus;

/// The topic of transforms.
const TRANSFORMS: &str = "tf";
/// Time for which a transform of another node counts, seconds.
const TRANSFORM_S: f64 = 5.0;

/// What is wrong with another node on a topic or an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Conflict {
    /// It publishes or serves what this node does.
    Publisher,
    /// It has another type.
    Type,
}

/// The types of a topic, of this node and of another.
#[derive(Debug)]
struct Types {
    expected: String,
    found: String,
}

/// Other publishers, servers and types, and those that are reported already.
#[derive(Debug, Default)]
pub struct Conflicts {
    names: NodeNames,
    /// Until when each publisher or server counts, by its topic or action, seconds.
    present_until_s: BTreeMap<&'static str, f64>,
    types: BTreeMap<&'static str, Types>,
    reported: BTreeSet<(Conflict, &'static str)>,
}

impl Conflicts {
    /// No other nodes, for a node with these names.
    pub fn new(names: NodeNames) -> Self {
        Self { names, ..Self::default() }
    }

    /// Another node publishes on a topic or serves an action, or no longer does.
    pub fn set_publisher(&mut self, topic: &'static str, is_present: bool) {
        if is_present {
            self.present_until_s.insert(topic, f64::INFINITY);
        } else {
            self.present_until_s.remove(topic);
        }
    }

    /// Another node uses a topic with another type than this one, or no longer does.
    pub fn set_type(&mut self, topic: &'static str, expected: &str, found: Option<&str>) {
        if let Some(found) = found {
            let types = Types { expected: expected.to_owned(), found: found.to_owned() };
            self.types.insert(topic, types);
        } else {
            self.types.remove(topic);
        }
    }

    /// Another node published the transform that this node publishes, at a time, seconds.
    pub fn set_transform(&mut self, now_s: f64) {
        self.present_until_s.insert(TRANSFORMS, now_s + TRANSFORM_S);
    }

    /// The transport was lost: a new one finds the other nodes again.
    pub fn forget(&mut self) {
        self.present_until_s.clear();
        self.types.clear();
    }

    /// The conflicts at a time, seconds.
    fn all(&self, now_s: f64) -> impl Iterator<Item = (Conflict, &'static str)> + Clone {
        let present = self.present_until_s.iter().filter(move |(_, until_s)| **until_s >= now_s);
        let present = present.map(|(topic, _)| (Conflict::Publisher, *topic));
        present.chain(self.types.keys().map(|topic| (Conflict::Type, *topic)))
    }

    /// The topics and actions with a conflict at a time, seconds.
    pub fn present(&self, now_s: f64) -> impl Iterator<Item = &'static str> + Clone {
        self.all(now_s).map(|(_, topic)| topic)
    }

    /// A notice of the conflicts that are not reported yet.
    pub fn notice(&mut self, now_s: f64) -> Option<String> {
        let new: Vec<_> = self.all(now_s).filter(|it| !self.reported.contains(it)).collect();
        self.reported.extend(&new);
        (!new.is_empty()).then(|| self.text(new.into_iter()))
    }

    /// The status for `diagnostics`.
    pub fn status(&self, now_s: f64) -> DiagnosticStatus {
        let message = self.text(self.all(now_s));
        let (level, message) = if message.is_empty() {
            (DiagnosticStatus::OK, "no other node controls this robot".to_owned())
        } else {
            (DiagnosticStatus::WARN, message)
        };
        let (name, hardware_id) = ("inbye: other nodes".to_owned(), String::new());
        DiagnosticStatus { level, name, message, hardware_id, values: Vec::new() }
    }

    /// What is wrong, and what to do.
    fn text(&self, conflicts: impl Iterator<Item = (Conflict, &'static str)>) -> String {
        let of_one = |(conflict, topic)| match conflict {
            Conflict::Publisher => self.publisher_text(topic),
            Conflict::Type => self.type_text(topic),
        };
        conflicts.map(of_one).collect::<Vec<_>>().join("; ")
    }

    fn publisher_text(&self, topic: &'static str) -> String {
        let shown = self.names.shown(topic);
        match topic {
            COMMAND => format!(
                "another node publishes on {shown} too, and the base gets the commands of both: stop one of them, or put a \
                 multiplexer such as twist_mux in between"
            ),
            NAVIGATE => format!(
                "another node serves the action {shown} too, and both pursue each goal: stop one of them, or start them in \
                 different namespaces"
            ),
            _ => format!(
                "another node publishes the odometry's frame in the map on {shown} too: stop that localization node (AMCL, SLAM), or \
                 set another pose_source than \"scans\""
            ),
        }
    }

    fn type_text(&self, topic: &'static str) -> String {
        let shown = self.names.shown(topic);
        let Some(Types { expected, found }) = self.types.get(topic) else {
            return String::new();
        };
        if topic == COMMAND {
            let option = if expected.ends_with("Stamped") { "without" } else { "with" };
            format!(
                "another node reads {shown} as {found}, but this node publishes {expected}, and that node gets no commands: start this \
                 node {option} --stamped"
            )
        } else {
            format!(
                "another node publishes {shown} as {found}, but this node reads {expected} and cannot use it: publish that type, or \
                 remap {topic} with --remap"
            )
        }
    }
}
