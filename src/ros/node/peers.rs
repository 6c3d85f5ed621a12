//! The publishers and subscribers of other nodes on the topics of this one.

use ros2_client::dds::rustdds::GUID;

use super::incoming::{COMMAND, IncomingMessage};

/// Maximum number of publishers and subscribers of each kind to remember.
const MAX_PEERS: usize = 64;
/// Longest type of another node in a report, characters.
const MAX_TYPE: usize = 100;

/// What another node has on a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    Publisher,
    Subscriber,
}

/// A topic on which other nodes must have the type of this one.
struct TypedTopic {
    /// The name and the type in DDS.
    dds_name: String,
    dds_type: String,
    topic: &'static str,
}

/// The publishers of other nodes on the topics of this node alone, and those with another type on all topics.
pub struct Peers {
    /// The topics on which only this node should publish, by their names in DDS.
    own_topics: [(String, &'static str); 2],
    typed: Vec<TypedTopic>,
    publishers: Vec<(GUID, &'static str)>,
    /// Each with the index of its topic and its type in DDS.
    mismatches: Vec<(GUID, usize, String)>,
}

impl Peers {
    pub const fn new(own_topics: [(String, &'static str); 2]) -> Self {
        Self { own_topics, typed: Vec::new(), publishers: Vec::new(), mismatches: Vec::new() }
    }

    /// Adds a topic of this node, with its name and its type in DDS.
    pub fn add_topic(&mut self, topic: &'static str, dds_name: String, dds_type: String) {
        self.typed.push(TypedTopic { dds_name, dds_type, topic });
    }

    /// DDS detected a publisher or a subscriber of another node.
    pub fn detected(&mut self, role: Role, guid: GUID, dds_name: &str, dds_type: &str) {
        let own = self.own_topics.iter().find(|(name, _)| name == dds_name);
        if let Some((_, topic)) = own.filter(|_| role == Role::Publisher)
            && !self.publishers.contains(&(guid, topic))
            && self.publishers.len() < MAX_PEERS
        {
            self.publishers.push((guid, topic));
        }
        // The node publishes commands, and reads all other topics.
        let is_other_side = |topic| (topic == COMMAND) == (role == Role::Subscriber);
        let index = self.typed.iter().position(|typed| {
            typed.dds_name == dds_name && typed.dds_type != dds_type && is_other_side(typed.topic)
        });
        if let Some(index) = index
            && self.mismatches.iter().all(|(known, ..)| *known != guid)
            && self.mismatches.len() < MAX_PEERS
        {
            self.mismatches.push((guid, index, dds_type.chars().take(MAX_TYPE).collect()));
        }
    }

    /// Publishers and subscribers of other nodes are gone.
    pub fn lost(&mut self, is_lost: impl Fn(&GUID) -> bool) {
        self.publishers.retain(|(guid, _)| !is_lost(guid));
        self.mismatches.retain(|(guid, ..)| !is_lost(guid));
    }

    /// What the control process gets of each topic when it changes.
    pub fn reports(&self) -> Vec<IncomingMessage> {
        let publisher = |&(_, topic): &(String, &'static str)| {
            let is_present = self.publishers.iter().any(|(_, other)| *other == topic);
            IncomingMessage::OtherPublisher { topic, is_present }
        };
        let type_of = |(index, typed): (usize, &TypedTopic)| {
            let found = self.mismatches.iter().find(|(_, other, _)| *other == index);
            let found = found.map(|(.., found)| ros_type(found));
            let expected = ros_type(&typed.dds_type);
            IncomingMessage::OtherType { topic: typed.topic, expected, found }
        };
        let types = self.typed.iter().enumerate().map(type_of);
        self.own_topics.iter().map(publisher).chain(types).collect()
    }
}

/// The name in ROS of a type in DDS: `geometry_msgs/msg/Twist` for `geometry_msgs::msg::dds_::Twist_`.
fn ros_type(dds_type: &str) -> String {
    dds_type.replace("::dds_::", "::").replace("::", "/").trim_end_matches('_').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWIST: &str = "geometry_msgs::msg::dds_::Twist_";
    const STAMPED: &str = "geometry_msgs::msg::dds_::TwistStamped_";
    const SCAN: &str = "sensor_msgs::msg::dds_::LaserScan_";

    fn peers() -> Peers {
        let own = |name: &str, topic| (name.to_owned(), topic);
        let mut peers =
            Peers::new([own("rt/cmd_vel", "cmd_vel"), own("rt/goal", "navigate_to_pose")]);
        peers.add_topic("cmd_vel", "rt/cmd_vel".to_owned(), TWIST.to_owned());
        peers.add_topic("scan", "rt/front/scan".to_owned(), SCAN.to_owned());
        peers
    }

    fn guid(number: u8) -> GUID {
        GUID::from_bytes([number; 16])
    }

    /// The types that other nodes have on `cmd_vel` and `scan`, and whether one publishes on `cmd_vel`.
    fn found(peers: &Peers) -> (Vec<Option<String>>, bool) {
        let reports = peers.reports();
        let types = reports.iter().filter_map(|report| match report {
            IncomingMessage::OtherType { found, .. } => Some(found.clone()),
            _ => None,
        });
        let publisher = IncomingMessage::OtherPublisher { topic: "cmd_vel", is_present: true };
        (types.collect(), reports.contains(&publisher))
    }

    #[test]
    fn subscriber_of_commands_with_another_type_is_reported_until_it_is_lost() {
        let mut peers = peers();
        peers.detected(Role::Subscriber, guid(1), "rt/cmd_vel", TWIST);
        assert_eq!(found(&peers), (vec![None, None], false));
        peers.detected(Role::Subscriber, guid(2), "rt/cmd_vel", STAMPED);
        peers.detected(Role::Subscriber, guid(2), "rt/cmd_vel", STAMPED);
        let stamped = || Some("geometry_msgs/msg/TwistStamped".to_owned());
        assert_eq!(found(&peers), (vec![stamped(), None], false));
        peers.lost(|other| *other == guid(1));
        assert_eq!(found(&peers).0[0], stamped());
        peers.lost(|other| *other == guid(2));
        assert_eq!(found(&peers), (vec![None, None], false));
    }

    #[test]
    fn only_the_other_side_of_a_topic_needs_its_type() {
        let mut peers = peers();
        peers.detected(Role::Subscriber, guid(1), "rt/front/scan", "tools::msg::dds_::Any_");
        peers.detected(Role::Publisher, guid(2), "rt/scan", "tools::msg::dds_::Any_");
        assert_eq!(found(&peers), (vec![None, None], false));
        peers.detected(Role::Publisher, guid(3), "rt/front/scan", "tools::msg::dds_::Any_");
        assert_eq!(found(&peers).0[1].as_deref(), Some("tools/msg/Any"));
        // A second publisher of commands is another fault, of any type.
        peers.detected(Role::Publisher, guid(4), "rt/cmd_vel", STAMPED);
        assert_eq!(found(&peers).0[0], None);
        assert!(found(&peers).1);
    }

    #[test]
    fn number_and_length_of_types_are_bounded() {
        let mut peers = peers();
        for number in 0..=u8::MAX {
            peers.detected(Role::Publisher, guid(number), "rt/front/scan", &"x".repeat(10_000));
            peers.detected(Role::Publisher, guid(number), "rt/cmd_vel", TWIST);
        }
        assert_eq!((peers.mismatches.len(), peers.publishers.len()), (MAX_PEERS, MAX_PEERS));
        assert_eq!(found(&peers).0[1].as_ref().map(String::len), Some(MAX_TYPE));
    }
}
