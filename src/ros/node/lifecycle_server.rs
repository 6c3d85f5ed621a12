//! The services of a managed node over DDS.

use ros2_client::dds::Server;
use ros2_client::qos::QosProfile;
use ros2_client::{
    MessageTypeName, Name, Node, Publisher, RmwRequestId, ServiceMapping, ServiceTypeName,
};

use super::dds::{NodeError, dds_error};
use super::incoming::{CHANGE_STATE, IncomingMessage};
use super::lifecycle::{LifecycleState, Step, TRANSITIONS};
use super::pending_requests::{MAX_REQUESTS, PendingRequests, arrived};
use crate::ros::msg::{
    ChangeStateRequest, ChangeStateResponse, EmptyRequest, GetAvailableTransitionsResponse,
    GetStateResponse, LifecycleAnswer, LifecycleRequest, Transition, TransitionDescription,
    TransitionEvent,
};

impl ros2_client::Message for ChangeStateRequest {}
impl ros2_client::Message for ChangeStateResponse {}
impl ros2_client::Message for EmptyRequest {}
impl ros2_client::Message for GetStateResponse {}
impl ros2_client::Message for GetAvailableTransitionsResponse {}

/// What a request is for errors.
const REQUEST: (&str, &str) = (CHANGE_STATE, "ChangeState");

/// The services `change_state`, `get_state` and `get_available_transitions`, and the topic `transition_event`.
pub struct LifecycleServer {
    change: Server<ChangeStateRequest, ChangeStateResponse>,
    state: Server<EmptyRequest, GetStateResponse>,
    transitions: Server<EmptyRequest, GetAvailableTransitionsResponse>,
    events: Publisher<TransitionEvent>,
    current: LifecycleState,
    waiting: PendingRequests,
}

impl LifecycleServer {
    /// Creates the services of a managed node. `name` gives the full name of each.
    pub fn new(
        node: &mut Node,
        mapping: ServiceMapping,
        name: impl Fn(&str) -> Result<Name, NodeError>,
        qos: &QosProfile,
    ) -> Result<Self, NodeError> {
        let event = MessageTypeName::new("lifecycle_msgs", "TransitionEvent");
        let events = name("inbye/transition_event")?;
        let events = node.create_topic(&events, event, qos).map_err(dds_error)?;
        let transitions = name("inbye/get_available_transitions")?;
        Ok(Self {
            change: server(node, mapping, &name(CHANGE_STATE)?, "ChangeState", qos)?,
            state: server(node, mapping, &name("inbye/get_state")?, "GetState", qos)?,
            transitions: server(node, mapping, &transitions, "GetAvailableTransitions", qos)?,
            events: node.create_publisher(&events, Some(qos.clone())).map_err(dds_error)?,
            current: LifecycleState::Unconfigured,
            waiting: PendingRequests::default(),
        })
    }

    /// Takes the requests that arrived, and answers those for the present state.
    pub fn receive(&mut self, all: &mut Vec<IncomingMessage>) {
        for (request, change) in arrived(|| self.change.receive_request(), REQUEST, all) {
            self.take_change(request, &change, all);
        }
        let current = self.current;
        answer(&self.state, || GetStateResponse { current_state: current.message() }, all);
        let available = || GetAvailableTransitionsResponse {
            available_transitions: TRANSITIONS
                .iter()
                .filter(|(_, _, from, _)| *from == current)
                .map(|step| TransitionDescription {
                    transition: transition_message(step),
                    start_state: step.2.message(),
                    goal_state: step.3.message(),
                })
                .collect(),
        };
        answer(&self.transitions, available, all);
    }

    fn take_change(
        &mut self,
        request: RmwRequestId,
        change: &ChangeStateRequest,
        all: &mut Vec<IncomingMessage>,
    ) {
        let wanted = &change.transition;
        let by_label = TRANSITIONS
            .iter()
            .find(|(_, label, from, _)| *label == wanted.label && *from == self.current);
        let transition = match wanted.id {
            0 => by_label.map_or(0, |step| step.0),
            id => id,
        };
        let request = self.waiting.add(request, MAX_REQUESTS);
        let request = LifecycleRequest { request, transition };
        all.push(IncomingMessage::ChangeState(request));
    }

    /// Takes over the state of the control process. Returns whether everything was sent.
    pub fn publish(&mut self, answer: LifecycleAnswer) -> bool {
        let before = self.current;
        self.current = LifecycleState::from_id(answer.state).unwrap_or(before);
        let success = answer.transition != 0;
        let request = self.waiting.take(answer.request);
        let sent = request
            .map(|request| self.change.send_response(request, ChangeStateResponse { success }));
        let step = TRANSITIONS.iter().find(|(id, ..)| success && *id == answer.transition);
        let event = step.map(|step| TransitionEvent {
            timestamp: answer.nanoseconds,
            transition: transition_message(step),
            start_state: step.2.message(),
            goal_state: step.3.message(),
        });
        let is_published = event.is_none_or(|event| self.events.publish(event).is_ok());
        sent.is_none_or(|sent| sent.is_ok()) & is_published
    }
}

/// Creates a service of a type of `lifecycle_msgs`.
fn server<Q: ros2_client::Message + Clone + 'static, R: ros2_client::Message + 'static>(
    node: &mut Node,
    mapping: ServiceMapping,
    name: &Name,
    kind: &str,
    qos: &QosProfile,
) -> Result<Server<Q, R>, NodeError> {
    let kind = ServiceTypeName::new("lifecycle_msgs", kind);
    node.create_server(mapping, name, &kind, qos.clone(), qos.clone()).map_err(dds_error)
}

/// Answers all requests of a service.
fn answer<R: ros2_client::Message + Clone + 'static>(
    server: &Server<EmptyRequest, R>,
    response: impl Fn() -> R,
    all: &mut Vec<IncomingMessage>,
) {
    for (request, _) in arrived(|| server.receive_request(), REQUEST, all) {
        // The client asks again if this answer is lost.
        let _ = server.send_response(request, response());
    }
}

/// A transition as a message.
fn transition_message(step: &Step) -> Transition {
    Transition { id: step.0, label: step.1.to_owned() }
}
