//! The server of the action `navigate_to_pose` over DDS.
//!
//! The control process decides about goals. This server keeps the answers, statuses and results for which clients still wait.

use std::collections::VecDeque;

use ros2_client::action::{
    ActionServer, ActionServerQosPolicies, GetResultResponse, GoalId, GoalInfo, GoalStatusEnum,
    SendGoalResponse,
};
use ros2_client::action_msgs::{
    CancelGoalRequest, CancelGoalResponse, CancelGoalResponseEnum, GoalStatus, GoalStatusArray,
};
use ros2_client::builtin_interfaces::Time;
use ros2_client::dds::rustdds::GUID;
use ros2_client::qos::QosProfile;
use ros2_client::{ActionTypeName, Gid, Name, Node, RmwRequestId, ServiceMapping};

use super::action::ActionUpdate;
use super::incoming::{IncomingMessage, NAVIGATE};
use super::pending_requests::{PendingRequests, arrived};
use crate::ros::msg::{
    self, ActionCancel, ActionEnd, ActionGoal, ActionResultRequest, NavigateToPoseFeedback,
    NavigateToPoseGoal, NavigateToPoseResult,
};

impl ros2_client::Message for NavigateToPoseGoal {}
impl ros2_client::Message for NavigateToPoseResult {}
impl ros2_client::Message for NavigateToPoseFeedback {}

/// What a request is for errors.
const REQUEST: (&str, &str) = (NAVIGATE, "NavigateToPose");
/// Number of ended goals whose results can still be asked for, and of requests that wait for a result or an answer.
const MAX_ENDED: usize = 16;
const MAX_WAITING: usize = 64;

/// Quality of service of the services, the feedback and the statuses.
pub struct ActionQos {
    pub service: QosProfile,
    pub feedback: QosProfile,
    pub status: QosProfile,
}

/// The server, and the goals of its clients.
pub struct NavigateServer {
    server: ActionServer<NavigateToPoseGoal, NavigateToPoseResult, NavigateToPoseFeedback>,
    /// In the order of their arrival.
    goals: VecDeque<Goal>,
    /// Requests to cancel that have no answer yet.
    cancels: PendingRequests,
}

struct Goal {
    id: GoalId,
    /// The request that has no answer yet.
    request: Option<RmwRequestId>,
    stamp: Time,
    status: GoalStatusEnum,
    /// Set at its end.
    result: Option<NavigateToPoseResult>,
    /// Requests for the result.
    waiting: Vec<RmwRequestId>,
}

impl Goal {
    const fn new(id: GoalId, request: Option<RmwRequestId>) -> Self {
        let status = GoalStatusEnum::Unknown;
        Self { id, request, stamp: Time::ZERO, status, result: None, waiting: Vec::new() }
    }

    fn info(&self) -> GoalInfo {
        GoalInfo { goal_id: self.id, stamp: self.stamp }
    }
}

impl NavigateServer {
    /// Creates the server as a part of a node.
    pub fn new(
        node: &mut Node,
        mapping: ServiceMapping,
        name: &Name,
        qos: ActionQos,
    ) -> Result<Self, ros2_client::CreateError> {
        let ActionQos { service, feedback, status } = qos;
        let policies = ActionServerQosPolicies {
            goal_service: service.clone(),
            result_service: service.clone(),
            cancel_service: service,
            feedback_publisher: feedback,
            status_publisher: status,
        };
        let action_type = ActionTypeName::new("nav2_msgs", "NavigateToPose");
        let server = node.create_action_server(mapping, name, &action_type, policies)?;
        Ok(Self { server, goals: VecDeque::new(), cancels: PendingRequests::default() })
    }

    /// Takes the requests that arrived, and answers those for results that are known.
    pub fn receive(&mut self, all: &mut Vec<IncomingMessage>) {
        for (request, goal) in arrived(|| self.server.receive_goal(), REQUEST, all) {
            self.take_goal(request, goal.goal_id, goal.goal, all);
        }
        for (request, cancel) in arrived(|| self.server.receive_cancel_request(), REQUEST, all) {
            self.take_cancel(request, &cancel, all);
        }
        for (request, wanted) in arrived(|| self.server.receive_result_request(), REQUEST, all) {
            let is_open =
                self.goals.iter().any(|goal| goal.id == wanted.goal_id && goal.result.is_none());
            if is_open {
                let (client, number) = (request.writer_gid.to_bytes16(), request.sequence_number);
                let id = *wanted.goal_id.uuid.as_bytes();
                let request = ActionResultRequest { client, number, id };
                all.push(IncomingMessage::ResultRequest(request));
            }
            // The client asks again if this answer is lost.
            self.answer_result(request, wanted.goal_id);
        }
    }

    fn take_goal(
        &mut self,
        request: RmwRequestId,
        id: GoalId,
        goal: NavigateToPoseGoal,
        all: &mut Vec<IncomingMessage>,
    ) {
        if self.goals.iter().any(|known| known.id == id) || self.goals.len() >= MAX_WAITING {
            let refusal = SendGoalResponse { accepted: false, stamp: Time::ZERO };
            // The client asks again if this answer is lost.
            let _ = self.server.send_goal_response(request, refusal);
            return;
        }
        self.goals.push_back(Goal::new(id, Some(request)));
        let message = ActionGoal { id: *id.uuid.as_bytes(), goal };
        all.push(IncomingMessage::Navigate(Box::new(message)));
    }

    fn take_cancel(
        &mut self,
        request: RmwRequestId,
        cancel: &CancelGoalRequest,
        all: &mut Vec<IncomingMessage>,
    ) {
        let Some((id, stamp)) = id_and_stamp_of(cancel) else {
            return;
        };
        let request = self.cancels.add(request, MAX_WAITING);
        all.push(IncomingMessage::Cancel(ActionCancel { request, id, stamp }));
    }

    /// Answers a request for a result, or keeps it until the goal ends. Returns whether the answer was sent.
    fn answer_result(&mut self, request: RmwRequestId, id: GoalId) -> bool {
        let known = self.goals.iter_mut().find(|goal| goal.id == id);
        let response = match known {
            Some(Goal { result: None, waiting, .. }) => {
                if waiting.len() < MAX_WAITING {
                    waiting.push(request);
                }
                return true;
            }
            Some(Goal { result: Some(result), status, .. }) => {
                GetResultResponse { status: *status, result: result.clone() }
            }
            None => GetResultResponse {
                status: GoalStatusEnum::Unknown,
                result: NavigateToPoseResult::default(),
            },
        };
        self.server.send_result(request, response).is_ok()
    }

    /// Sends an update to the clients. Returns whether everything was sent.
    pub fn publish(&mut self, update: ActionUpdate) -> bool {
        match update {
            ActionUpdate::Answer(answer) => {
                // A process before this one received the goal.
                if answer.accepted && find(&mut self.goals, &answer.id).is_none() {
                    self.goals.extend(goal_id(&answer.id).map(|id| Goal::new(id, None)));
                }
                let Some(goal) = find(&mut self.goals, &answer.id) else {
                    return true;
                };
                goal.stamp = time(&answer.stamp);
                goal.status = GoalStatusEnum::Executing;
                let response = SendGoalResponse { accepted: answer.accepted, stamp: goal.stamp };
                let request = goal.request.take();
                let sent = request.map(|request| self.server.send_goal_response(request, response));
                if !answer.accepted {
                    self.goals.retain(|goal| *goal.id.uuid.as_bytes() != answer.id);
                }
                sent.is_none_or(|sent| sent.is_ok()) & self.publish_statuses()
            }
            ActionUpdate::CancelAnswer(answer) => {
                let goal = find(&mut self.goals, &answer.id);
                let return_code = match &goal {
                    _ if answer.accepted => CancelGoalResponseEnum::None,
                    Some(_) => CancelGoalResponseEnum::GoalTerminated,
                    None if answer.id == [0; 16] => CancelGoalResponseEnum::Rejected,
                    None => CancelGoalResponseEnum::UnknownGoal,
                };
                let canceling = goal.filter(|_| answer.accepted);
                let goals_canceling = canceling.map(|goal| {
                    goal.status = GoalStatusEnum::Canceling;
                    goal.info()
                });
                let response = CancelGoalResponse {
                    return_code,
                    goals_canceling: goals_canceling.into_iter().collect(),
                };
                let request = self.cancels.take(answer.request);
                let sent =
                    request.map(|request| self.server.send_cancel_response(request, response));
                sent.is_none_or(|sent| sent.is_ok()) & self.publish_statuses()
            }
            ActionUpdate::Feedback(message) => {
                let goal = find(&mut self.goals, &message.id).map(|goal| goal.id);
                goal.is_none_or(|id| self.server.send_feedback(id, message.feedback).is_ok())
            }
            ActionUpdate::End(end) => self.end(&end),
            ActionUpdate::Result(ActionResultRequest { client, number, id }) => {
                let writer_gid = Gid::from(GUID::from_bytes(client));
                let request = RmwRequestId { writer_gid, sequence_number: number };
                goal_id(&id).is_none_or(|id| self.answer_result(request, id))
            }
        }
    }

    fn end(&mut self, end: &ActionEnd) -> bool {
        let Some(goal) = find(&mut self.goals, &end.id) else {
            return true;
        };
        goal.status = match end.status {
            ActionEnd::SUCCEEDED => GoalStatusEnum::Succeeded,
            ActionEnd::CANCELED => GoalStatusEnum::Canceled,
            _ => GoalStatusEnum::Aborted,
        };
        let (status, waiting) = (goal.status, std::mem::take(&mut goal.waiting));
        goal.result = Some(end.result.clone());
        let mut is_sent = true;
        for request in waiting {
            let response = GetResultResponse { status, result: end.result.clone() };
            is_sent &= self.server.send_result(request, response).is_ok();
        }
        is_sent &= self.publish_statuses();
        let ended = |goal: &Goal| goal.result.is_some();
        while self.goals.iter().filter(|goal| ended(goal)).count() > MAX_ENDED {
            let oldest = self.goals.iter().position(ended);
            oldest.and_then(|oldest| self.goals.remove(oldest));
        }
        is_sent
    }

    fn publish_statuses(&self) -> bool {
        let status = |goal: &Goal| GoalStatus { goal_info: goal.info(), status: goal.status };
        let status_list = self.goals.iter().filter(|goal| goal.request.is_none()).map(status);
        let statuses = GoalStatusArray { status_list: status_list.collect() };
        self.server.send_goal_statuses(statuses).is_ok()
    }
}

fn find<'a>(goals: &'a mut VecDeque<Goal>, id: &[u8; 16]) -> Option<&'a mut Goal> {
    goals.iter_mut().find(|goal| goal.id.uuid.as_bytes() == id)
}

fn time(stamp: &msg::Time) -> Time {
    Time::from_nanos(i64::from(stamp.sec) * 1_000_000_000 + i64::from(stamp.nanosec))
}

/// The type of the library is that of a crate that this one does not use, but has a serialized form.
fn goal_id(id: &[u8; 16]) -> Option<GoalId> {
    serde_json::from_value(serde_json::json!({ "uuid": id })).ok()
}

/// The goal and the time that a request names. Their field is private in the crate, but not in its serialized form.
fn id_and_stamp_of(cancel: &CancelGoalRequest) -> Option<([u8; 16], msg::Time)> {
    let value = serde_json::to_value(cancel).ok()?;
    let info = &value["goal_info"];
    let id = serde_json::from_value(info["goal_id"]["uuid"].clone()).ok()?;
    Some((id, serde_json::from_value(info["stamp"].clone()).ok()?))
}
