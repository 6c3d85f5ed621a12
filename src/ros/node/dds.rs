//! The transport of the node: DDS by `ros2-client`.

use std::iter;
use std::net::Ipv4Addr;

use ros2_client::dds::rustdds::{
    self, DomainParticipantBuilder, DomainParticipantStatusEvent, DomainParticipantStatusListener,
    RTPSEntity, StatusEvented, TopicDescription, policy,
};
use ros2_client::qos::{Durability, History, QosProfile, Reliability, WhenFull};
use ros2_client::{
    Context, MessageInfo, MessageTypeName, Name, Node, NodeName, NodeOptions, Publisher,
    ServiceMapping,
};
use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

use super::action_server::{ActionQos, NavigateServer};
use super::incoming::{COMMAND, IncomingMessage, MAP, NAVIGATE};
use super::lifecycle_server::LifecycleServer;
use super::names::NodeNames;
use super::network::ToNetwork;
use super::peers::{Peers, Role};
use super::zones::{FILTER_INFO, KEEPOUT_MASK, SPEED_MASK};
use crate::ros::msg::{self, Message};

/// Maximum number of messages that one call of [`DdsNode::receive`] takes from a topic.
const MAX_MESSAGES: usize = 64;
/// Number of queued messages of sensor data, as in ROS.
const SENSOR_DEPTH: usize = 5;
/// Number of queued messages of transforms: each message has only some of the frames.
const TRANSFORM_DEPTH: usize = 100;

/// Number of queued requests, answers and feedback messages of the action.
const SERVICE_DEPTH: usize = 10;
/// Number of queued descriptions of filters.
const FILTERS_DEPTH: usize = 5;

/// The middleware of ROS whose services the node speaks: they number requests differently.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Rmw {
    /// `rmw_fastrtps_cpp`.
    #[default]
    FastRtps,
    /// `rmw_cyclonedds_cpp`.
    CycloneDds,
}

/// Settings of the DDS transport.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct DdsSettings {
    /// The names of node, topics, services and action.
    pub names: NodeNames,
    /// The DDS domain, 0 to 232: `ROS_DOMAIN_ID`.
    pub domain: u16,
    /// Restricts discovery to this machine.
    pub localhost_only: bool,
    /// Publishes `cmd_vel` as `TwistStamped` instead of `Twist`.
    pub stamped: bool,
    /// How services are spoken.
    pub rmw: Rmw,
    /// Starts unconfigured, and waits for the requests of a lifecycle manager.
    pub is_managed: bool,
}

/// Why a node cannot start.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum NodeError {
    /// DDS cannot start.
    #[error(
        "DDS cannot start ({reason}): check that a network interface is up and the domain's ports are free"
    )]
    Dds {
        /// Message of `ros2-client`.
        reason: String,
    },
}

/// The subscriptions and publishers of the node.
pub struct DdsNode {
    inputs: Vec<Input>,
    command: CommandPublisher,
    path: Publisher<msg::Path>,
    markers: Publisher<msg::MarkerArray>,
    diagnostics: Publisher<msg::DiagnosticArray>,
    own_transforms: Publisher<msg::TFMessage>,
    updated_map: Publisher<msg::OccupancyGrid>,
    navigate: NavigateServer,
    lifecycle: Option<LifecycleServer>,
    /// What DDS reports of other participants.
    events: DomainParticipantStatusListener,
    /// This node in DDS.
    own: rustdds::GUID,
    /// The topics of the subscriptions.
    topics: Vec<(rustdds::GUID, &'static str)>,
    peers: Peers,
    unsent: u64,
    /// Other nodes discover the node during its lifetime.
    _node: Node,
}

/// A subscription. Adds the received messages to a list.
type Input = Box<dyn Fn(&mut Vec<IncomingMessage>)>;

enum CommandPublisher {
    Plain(Publisher<msg::Twist>),
    Stamped(Publisher<msg::TwistStamped>),
}

impl DdsNode {
    /// Joins a domain as a node.
    ///
    /// # Errors
    /// When the system provides no sockets.
    pub fn open(settings: &DdsSettings) -> Result<Self, NodeError> {
        let names = &settings.names;
        let node_name = NodeName::new(names.namespace(), names.node()).map_err(dds_error)?;
        let mut participant = DomainParticipantBuilder::new(settings.domain);
        if settings.localhost_only {
            participant = participant.with_only_networks([Ipv4Addr::LOCALHOST]);
        }
        let participant = participant.build().map_err(dds_error)?;
        let (events, own) = (participant.status_listener(), participant.guid());
        let context = Context::from_domain_participant(participant).map_err(dds_error)?;
        // The node has no ROS parameters and no ROS log.
        let options = NodeOptions::new().enable_rosout(false).start_parameter_services(false);
        let mut node = context.new_node(node_name.clone(), options).map_err(dds_error)?;
        let mapping = match settings.rmw {
            Rmw::FastRtps => ServiceMapping::Enhanced,
            Rmw::CycloneDds => ServiceMapping::Cyclone,
        };
        let qos = ActionQos {
            service: reliable(SERVICE_DEPTH),
            feedback: reliable(SERVICE_DEPTH),
            status: latched(1),
        };
        let full_name = |name: &str| dds_name(names, name);
        let name = full_name(NAVIGATE)?;
        let navigate = NavigateServer::new(&mut node, mapping, &name, qos).map_err(dds_error)?;
        let qos = reliable(SERVICE_DEPTH);
        let lifecycle =
            settings.is_managed.then(|| LifecycleServer::new(&mut node, mapping, full_name, &qos));
        let lifecycle = lifecycle.transpose()?;
        let own_topic = |topic, suffix| {
            let name = full_name(topic)?.to_dds_name("rt", &node_name, suffix);
            Ok::<_, NodeError>((name, topic))
        };
        let own_topics = [own_topic(COMMAND, "")?, own_topic(NAVIGATE, "/_action/status")?];
        let peers = Peers::new(own_topics);
        let mut builder = EndpointBuilder {
            node: &mut node,
            names,
            peers,
            inputs: Vec::new(),
            topics: Vec::new(),
        };
        builder.all_inputs()?;
        Ok(Self {
            command: if settings.stamped {
                CommandPublisher::Stamped(builder.command_publisher()?)
            } else {
                CommandPublisher::Plain(builder.command_publisher()?)
            },
            path: builder.publisher("plan", latched(1))?,
            markers: builder.publisher("local_markers", reliable(1))?,
            diagnostics: builder.publisher("diagnostics", reliable(1))?,
            updated_map: builder.publisher("inbye/updated_map", latched(1))?,
            own_transforms: builder.publisher("tf", reliable(TRANSFORM_DEPTH))?,
            navigate,
            lifecycle,
            events,
            own,
            inputs: builder.inputs,
            topics: builder.topics,
            peers: builder.peers,
            unsent: 0,
            _node: node,
        })
    }

    /// Returns the messages received since the last call.
    pub fn receive(&mut self) -> Vec<IncomingMessage> {
        let mut all = Vec::new();
        self.inputs.iter().for_each(|take| take(&mut all));
        self.navigate.receive(&mut all);
        if let Some(lifecycle) = &mut self.lifecycle {
            lifecycle.receive(&mut all);
        }
        self.take_events(&mut all);
        all
    }

    /// Takes what DDS reports. Of interest are publishers whose messages do not arrive, those that should not be there, and other
    /// types.
    fn take_events(&mut self, all: &mut Vec<IncomingMessage>) {
        use DomainParticipantStatusEvent as Event;
        let events = iter::from_fn(|| self.events.try_recv_status());
        let mut events = events.take(MAX_MESSAGES).peekable();
        if events.peek().is_none() {
            return;
        }
        let before = self.peers.reports();
        let is_other = |guid: &rustdds::GUID| guid.prefix != self.own.prefix;
        for event in events {
            match event {
                Event::RemoteWriterQosIncompatible { local_reader, requested_qos, .. } => {
                    let topic = self.topics.iter().find(|(reader, _)| *reader == local_reader);
                    all.extend(topic.map(|&(_, topic)| {
                        let expected = needed(&requested_qos);
                        IncomingMessage::Unmatched { topic, expected }
                    }));
                }
                Event::WriterDetected { writer: peer } if is_other(&peer.guid) => {
                    self.peers.detected(
                        Role::Publisher,
                        peer.guid,
                        &peer.topic_name,
                        &peer.type_name,
                    );
                }
                Event::ReaderDetected { reader: peer } if is_other(&peer.guid) => {
                    self.peers.detected(
                        Role::Subscriber,
                        peer.guid,
                        &peer.topic_name,
                        &peer.type_name,
                    );
                }
                Event::WriterLost { guid, .. } | Event::ReaderLost { guid, .. } => {
                    self.peers.lost(|peer| *peer == guid);
                }
                Event::ParticipantLost { id, .. } => self.peers.lost(|peer| peer.prefix == id),
                _ => {}
            }
        }
        let reports = self.peers.reports().into_iter().zip(before);
        all.extend(reports.filter(|(report, before)| report != before).map(|(report, _)| report));
    }

    /// Publishes a message without waiting. A message that cannot be sent immediately is dropped and counted.
    pub fn publish(&mut self, message: ToNetwork) {
        let is_sent = match message {
            ToNetwork::Alive => true,
            ToNetwork::Command(command) => match &self.command {
                CommandPublisher::Plain(publisher) => publisher.publish(command.twist).is_ok(),
                CommandPublisher::Stamped(publisher) => publisher.publish(command).is_ok(),
            },
            ToNetwork::Path(path) => self.path.publish(path).is_ok(),
            ToNetwork::Markers(markers) => self.markers.publish(markers).is_ok(),
            ToNetwork::Diagnostics(diagnostics) => self.diagnostics.publish(diagnostics).is_ok(),
            ToNetwork::State(state) => {
                self.lifecycle.as_mut().is_none_or(|lifecycle| lifecycle.publish(state))
            }
            ToNetwork::Action(update) => self.navigate.publish(update),
            ToNetwork::UpdatedMap(map) => self.updated_map.publish(map).is_ok(),
            ToNetwork::Transforms(transforms) => self.own_transforms.publish(transforms).is_ok(),
        };
        self.unsent += u64::from(!is_sent);
    }

    /// Number of messages that could not be sent.
    #[must_use]
    pub const fn unsent(&self) -> u64 {
        self.unsent
    }
}

/// Creates subscriptions and publishers.
struct EndpointBuilder<'a> {
    node: &'a mut Node,
    names: &'a NodeNames,
    peers: Peers,
    inputs: Vec<Input>,
    topics: Vec<(rustdds::GUID, &'static str)>,
}

impl EndpointBuilder<'_> {
    fn topic<M: Message>(&self, name: &str, qos: &QosProfile) -> Result<rustdds::Topic, NodeError> {
        let name = dds_name(self.names, name)?;
        let message_type = MessageTypeName::new(M::PACKAGE, M::NAME);
        self.node.create_topic(&name, message_type, qos).map_err(dds_error)
    }

    /// Creates all subscriptions, in the order in which their messages are taken.
    fn all_inputs(&mut self) -> Result<(), NodeError> {
        use IncomingMessage as Incoming;
        self.input("tf_static", latched(TRANSFORM_DEPTH), Incoming::StaticTransforms)?;
        self.input("tf", reliable(TRANSFORM_DEPTH), Incoming::Transforms)?;
        self.input(MAP, latched(1), Incoming::Map)?;
        self.input(KEEPOUT_MASK, latched(1), Incoming::KeepoutMask)?;
        self.input(SPEED_MASK, latched(1), Incoming::SpeedMask)?;
        // Of each filter.
        self.input(FILTER_INFO, latched(FILTERS_DEPTH), Incoming::FilterInfo)?;
        self.input("speed_limit", reliable(1), Incoming::SpeedLimit)?;
        self.input("odom", sensor_data(), |message| Incoming::Odometry(Box::new(message)))?;
        self.input("scan", sensor_data(), Incoming::Scan)?;
        self.input("goal_pose", reliable(1), Incoming::Goal)?;
        let initial_pose = |message| Incoming::InitialPose(Box::new(message));
        self.input("initialpose", reliable(1), initial_pose)?;
        // Not latched: a message from before the start of the node must not arm the robot. Of both at once, the stop counts.
        self.input("inbye/arm", reliable(1), Incoming::Arm)?;
        self.input("inbye/stop", reliable(1), Incoming::Stop)
    }

    /// Creates a subscription, without the messages of this node itself.
    fn input<M: Message + DeserializeOwned + 'static>(
        &mut self,
        topic: &'static str,
        qos: QosProfile,
        convert: impl Fn(M) -> IncomingMessage + 'static,
    ) -> Result<(), NodeError> {
        let dds_topic = self.topic::<M>(topic, &qos)?;
        self.add_typed(topic, &dds_topic);
        let subscription = self.node.create_subscription::<M>(&dds_topic, Some(qos));
        let subscription = subscription.map_err(dds_error)?;
        let guid = subscription.guid();
        let is_own = move |info: &MessageInfo| {
            rustdds::GUID::from(info.publisher_gid()).prefix == guid.prefix
        };
        let take = move |all: &mut Vec<IncomingMessage>| {
            for _ in 0..MAX_MESSAGES {
                match subscription.take() {
                    Ok(Some((_, info))) if is_own(&info) => {}
                    Ok(Some((message, _))) => all.push(convert(message)),
                    Ok(None) => break,
                    Err(error) => {
                        let reason = error.to_string();
                        all.push(IncomingMessage::Undecodable { topic, expected: M::NAME, reason });
                    }
                }
            }
        };
        self.topics.push((guid, topic));
        self.inputs.push(Box::new(take));
        Ok(())
    }

    fn command_publisher<M: Message + Serialize>(&mut self) -> Result<Publisher<M>, NodeError> {
        let qos = reliable(1);
        let topic = self.topic::<M>(COMMAND, &qos)?;
        self.add_typed(COMMAND, &topic);
        self.publisher_on(&topic, qos)
    }

    fn publisher<M: Message + Serialize>(
        &mut self,
        name: &str,
        qos: QosProfile,
    ) -> Result<Publisher<M>, NodeError> {
        let topic = self.topic::<M>(name, &qos)?;
        self.publisher_on(&topic, qos)
    }

    fn publisher_on<M: Message + Serialize>(
        &mut self,
        topic: &rustdds::Topic,
        qos: QosProfile,
    ) -> Result<Publisher<M>, NodeError> {
        self.node.create_publisher(topic, Some(qos)).map_err(dds_error)
    }

    /// Other nodes must have the type of this topic.
    fn add_typed(&mut self, topic: &'static str, dds: &rustdds::Topic) {
        self.peers.add_topic(topic, dds.name(), dds.get_type().name().to_owned());
    }
}

/// The quality of service that a subscription needs, in words.
fn needed(qos: &rustdds::QosPolicies) -> String {
    let is_reliable = matches!(qos.reliability(), Some(policy::Reliability::Reliable { .. }));
    let reliability = if is_reliable { "reliable" } else { "best effort or reliable" };
    match qos.durability() {
        None | Some(policy::Durability::Volatile) => reliability.to_owned(),
        Some(_) => format!("{reliability} and transient local (latched)"),
    }
}

/// The full name of a topic, a service or the action.
fn dds_name(names: &NodeNames, name: &str) -> Result<Name, NodeError> {
    Name::parse(&names.full(name)).map_err(dds_error)
}

#[expect(clippy::needless_pass_by_value, reason = "`map_err` passes the error by value")]
pub(super) fn dds_error(error: impl ToString) -> NodeError {
    NodeError::Dds { reason: error.to_string() }
}

/// Reliable delivery of the newest messages. A writer never waits for a reader.
fn reliable(depth: usize) -> QosProfile {
    QosProfile::default()
        .reliability(Reliability::Reliable { when_full: WhenFull::Fail })
        .history(History::KeepLast { depth })
}

/// Reliable delivery, also to late subscribers.
fn latched(depth: usize) -> QosProfile {
    reliable(depth).durability(Durability::TransientLocal)
}

/// Delivery of the newest messages. A subscription with it accepts reliable and best-effort publishers.
fn sensor_data() -> QosProfile {
    QosProfile::default()
        .reliability_best_effort()
        .history(History::KeepLast { depth: SENSOR_DEPTH })
}
