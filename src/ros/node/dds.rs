//! The wires: DDS by `ros2-client`. The only file that opens a socket for ROS.

use std::net::Ipv4Addr;

use ros2_client::dds::rustdds::{self, DomainParticipantBuilder};
use ros2_client::names::NameError;
use ros2_client::qos::{Durability, History, QosProfile, Reliability, WhenFull};
use ros2_client::{
    Context, MessageTypeName, Name, Node, NodeName, NodeOptions, Publisher, Subscription,
};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::published::{twist, twist_stamped};
use super::{Arrived, NodeError, Published, Topic};
use crate::ros::msg;

/// Most messages of a topic that are taken at a time.
const AT_ONCE: usize = 64;
/// Newest messages kept for a reader that is slow: sensor data as ROS has it.
const SENSOR_DEPTH: usize = 5;
/// The same of frames: a message tells of some only.
const FRAMES_DEPTH: usize = 100;

/// Where and how to talk.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WireSettings {
    /// Before the names of node and topics, beginning with a slash; empty for none.
    pub namespace: String,
    /// The DDS domain, 0 to 232: `ROS_DOMAIN_ID`.
    pub domain: u16,
    /// Whether to leave the other machines alone.
    pub localhost_only: bool,
    /// Whether `cmd_vel` is a `TwistStamped`.
    pub stamped: bool,
}

/// A node's subscriptions and publishers.
pub struct Wires {
    map: Subscription<msg::OccupancyGrid>,
    scan: Subscription<msg::LaserScan>,
    odometry: Subscription<msg::Odometry>,
    goal: Subscription<msg::PoseStamped>,
    transforms: Subscription<msg::TFMessage>,
    static_transforms: Subscription<msg::TFMessage>,
    command: CommandPublisher,
    path: Publisher<msg::Path>,
    markers: Publisher<msg::MarkerArray>,
    unsent: u64,
    /// Named to others as long as it lives.
    _node: Node,
}

enum CommandPublisher {
    Plain(Publisher<msg::Twist>),
    Stamped(Publisher<msg::TwistStamped>),
}

impl Wires {
    /// Joins a domain as the node `inbye`.
    ///
    /// # Errors
    /// When the namespace cannot be one, or the system gives no sockets.
    pub fn open(settings: &WireSettings) -> Result<Self, NodeError> {
        let namespace = match settings.namespace.as_str() {
            "" => "/",
            namespace => namespace,
        };
        let name =
            NodeName::new(namespace, "inbye").map_err(|error| bad_namespace(namespace, &error))?;
        topic_name(namespace, "map")?;
        let mut participant = DomainParticipantBuilder::new(settings.domain);
        if settings.localhost_only {
            participant = participant.with_only_networks([Ipv4Addr::LOCALHOST]);
        }
        let context = Context::from_domain_participant(participant.build().map_err(no_wire)?)
            .map_err(no_wire)?;
        // Nobody serves parameters or logs here.
        let options = NodeOptions::new()
            .enable_rosout(false)
            .start_parameter_services(false);
        let mut node = context.new_node(name, options).map_err(no_wire)?;
        let mut wiring = Wiring {
            node: &mut node,
            namespace,
        };
        Ok(Self {
            map: wiring.subscription(Topic::Map, latched(1))?,
            scan: wiring.subscription(Topic::Scan, sensor_data())?,
            odometry: wiring.subscription(Topic::Odometry, sensor_data())?,
            goal: wiring.subscription(Topic::Goal, reliable(1))?,
            transforms: wiring.subscription(Topic::Transforms, reliable(FRAMES_DEPTH))?,
            static_transforms: wiring
                .subscription(Topic::StaticTransforms, latched(FRAMES_DEPTH))?,
            command: wiring.command(settings.stamped)?,
            path: wiring.publisher("plan", ("nav_msgs", "Path"), latched(1))?,
            markers: wiring.publisher(
                "local_markers",
                ("visualization_msgs", "MarkerArray"),
                reliable(1),
            )?,
            unsent: 0,
            _node: node,
        })
    }

    /// What has come since the last time.
    pub fn arrived(&mut self) -> Vec<Arrived> {
        let mut all = Vec::new();
        let transforms = Topic::StaticTransforms;
        take(
            &self.static_transforms,
            transforms,
            Arrived::StaticTransforms,
            &mut all,
        );
        take(
            &self.transforms,
            Topic::Transforms,
            Arrived::Transforms,
            &mut all,
        );
        take(&self.map, Topic::Map, Arrived::Map, &mut all);
        let odometry = |message| Arrived::Odometry(Box::new(message));
        take(&self.odometry, Topic::Odometry, odometry, &mut all);
        take(&self.scan, Topic::Scan, Arrived::Scan, &mut all);
        take(&self.goal, Topic::Goal, Arrived::Goal, &mut all);
        all
    }

    /// Sends what there is, with the time by the wall clock and the robot's own frame for what carries them. Nothing is
    /// waited for: what cannot be sent at once is dropped and counted.
    pub fn publish(&mut self, published: Published, stamp: msg::Time, base_frame: &str) {
        let mut is_sent = true;
        if let Some(command) = &published.command {
            is_sent &= match &self.command {
                CommandPublisher::Plain(publisher) => publisher.publish(twist(command)).is_ok(),
                CommandPublisher::Stamped(publisher) => publisher
                    .publish(twist_stamped(command, stamp, base_frame))
                    .is_ok(),
            };
        }
        if let Some(path) = published.path {
            is_sent &= self.path.publish(path).is_ok();
        }
        if let Some(markers) = published.markers {
            is_sent &= self.markers.publish(markers).is_ok();
        }
        self.unsent += u64::from(!is_sent);
    }

    /// Ticks at which something could not be sent.
    #[must_use]
    pub const fn unsent(&self) -> u64 {
        self.unsent
    }
}

struct Wiring<'a> {
    node: &'a mut Node,
    namespace: &'a str,
}

impl Wiring<'_> {
    fn topic(
        &self,
        name: &str,
        (package, kind): (&str, &str),
        qos: &QosProfile,
    ) -> Result<rustdds::Topic, NodeError> {
        let name = topic_name(self.namespace, name)?;
        let kind = MessageTypeName::new(package, kind);
        self.node.create_topic(&name, kind, qos).map_err(no_wire)
    }

    fn subscription<M: DeserializeOwned + 'static>(
        &mut self,
        topic: Topic,
        qos: QosProfile,
    ) -> Result<Subscription<M>, NodeError> {
        let topic = self.topic(topic.name(), topic.type_name(), &qos)?;
        let made = self.node.create_subscription(&topic, Some(qos));
        made.map_err(no_wire)
    }

    fn publisher<M: Serialize>(
        &mut self,
        name: &str,
        kind: (&str, &str),
        qos: QosProfile,
    ) -> Result<Publisher<M>, NodeError> {
        let topic = self.topic(name, kind, &qos)?;
        let made = self.node.create_publisher(&topic, Some(qos));
        made.map_err(no_wire)
    }

    fn command(&mut self, stamped: bool) -> Result<CommandPublisher, NodeError> {
        let package = "geometry_msgs";
        Ok(if stamped {
            let kind = (package, "TwistStamped");
            CommandPublisher::Stamped(self.publisher("cmd_vel", kind, reliable(1))?)
        } else {
            CommandPublisher::Plain(self.publisher("cmd_vel", (package, "Twist"), reliable(1))?)
        })
    }
}

fn topic_name(namespace: &str, name: &str) -> Result<Name, NodeError> {
    Name::new(namespace, name).map_err(|error| bad_namespace(namespace, &error))
}

fn bad_namespace(namespace: &str, error: &NameError) -> NodeError {
    NodeError::BadNamespace {
        namespace: namespace.to_owned(),
        reason: error.to_string(),
    }
}

#[expect(
    clippy::needless_pass_by_value,
    reason = "it is what `map_err` hands over"
)]
fn no_wire(error: impl ToString) -> NodeError {
    NodeError::NoWire {
        reason: error.to_string(),
    }
}

/// Takes all that has come on a topic.
fn take<M: DeserializeOwned + 'static>(
    subscription: &Subscription<M>,
    topic: Topic,
    arrived: impl Fn(M) -> Arrived,
    all: &mut Vec<Arrived>,
) {
    for _ in 0..AT_ONCE {
        match subscription.take() {
            Ok(Some((message, _))) => all.push(arrived(message)),
            Ok(None) => break,
            Err(error) => all.push(Arrived::Undecodable(topic, error.to_string())),
        }
    }
}

/// Each message arrives, the newest few wait for a reader that is slow. A writer never waits for a reader.
fn reliable(depth: usize) -> QosProfile {
    QosProfile::default()
        .reliability(Reliability::Reliable {
            when_full: WhenFull::Fail,
        })
        .history(History::KeepLast { depth })
}

/// The same, and who comes late gets the last ones.
fn latched(depth: usize) -> QosProfile {
    reliable(depth).durability(Durability::TransientLocal)
}

/// The newest counts; a publisher may be reliable or not.
fn sensor_data() -> QosProfile {
    QosProfile::default()
        .reliability_best_effort()
        .history(History::KeepLast {
            depth: SENSOR_DEPTH,
        })
}
