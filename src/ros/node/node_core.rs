//! The node without its transport.

mod action;
mod ages;
mod display;
mod goal;
mod goal_end;
mod lifecycle;
mod localization;
mod map;
mod status;

use std::collections::BTreeMap;

use self::ages::{MAX_TICK_GAP_S, check_period};
use self::status::Inputs;
use super::action::{ActionUpdate, ActiveGoal};
use super::conflicts::Conflicts;
use super::diagnostics::Diagnostics;
use super::engine::NodeEngine;
use super::incoming::{self, GoalInput, IncomingMessage, MAP, MapInput, OdometryInput};
use super::latest_inputs::LatestInputs;
use super::lifecycle::LifecycleState;
use super::localization::NodeLocalization;
use super::names::NodeNames;
use super::notices::{MessageError, NodeStats, Notices};
use super::protection::Protection;
use super::zones::{KEEPOUT_MASK, SPEED_MASK, ZoneInputs};
use crate::base::{OperatorState, OperatorSwitch};
use crate::geometry::{Pose, Twist};
use crate::local::Engine;
use crate::navigator::{Decision, Fault, Goal, Navigator, Observation, PlannedGoals};
use crate::robot::TickClock;
use crate::ros::msg;
use crate::runtime::{Config, ContradictedMap, MapUpdate, PoseSource, Preparation};
use crate::settings::SettingError;

/// Time for which the robot stands after the return of the transport and of all inputs, seconds: a base that discovers the node
/// meanwhile gets zeros first.
const RESUME_HOLD_S: f64 = 2.0;
/// Time after the return of the transport for which an ended goal still publishes zero velocity, seconds: nodes discover each
/// other meanwhile.
const TRANSPORT_SETTLE_S: f64 = 5.0;

/// The topics of the map and the masks.
const GRIDS: [&str; 3] = [MAP, KEEPOUT_MASK, SPEED_MASK];

/// Settings of a node.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct NodeSettings {
    /// Robot, planners, navigator and localisation. Settings of the simulated world have no effect, and it runs in real time. With
    /// the pose source `scans` the node localises the robot on the map itself; otherwise `tf` gives the pose of the odometry's
    /// frame in the map.
    pub config: Config,
    /// Treats the odometry frame as the map frame, unless the pose source is `scans`.
    pub odom_is_map: bool,
    /// Starts unconfigured, and waits for the requests of a lifecycle manager; otherwise the node starts active.
    pub is_managed: bool,
    /// The names of topics and action, for notices and diagnostics.
    pub names: NodeNames,
}

/// The messages to publish at a tick.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Outgoing {
    /// For `cmd_vel`; none if the node does not control the robot.
    pub command: Option<Twist>,
    /// For `plan`: a new path.
    pub path: Option<msg::Path>,
    /// For `local_markers`.
    pub markers: Option<msg::MarkerArray>,
    /// For `tf`: the frame of the odometry in the map, while the node localises the robot and knows its pose.
    pub transforms: Option<msg::TFMessage>,
    /// For `inbye/updated_map`: the map with what the scans contradicted for minutes, when that changes.
    pub updated_map: Option<msg::OccupancyGrid>,
    /// For `diagnostics`: what the protective layer and the operator's switch do, the localisation, and a GPU with a
    /// CPU fallback.
    pub diagnostics: Option<msg::DiagnosticArray>,
    /// For the clients of the action `navigate_to_pose`.
    pub action: Vec<ActionUpdate>,
    /// For the services of a managed node: its state after each request.
    pub states: Vec<msg::LifecycleAnswer>,
    /// New notices for the user, a line each.
    pub notices: Vec<String>,
}

/// Takes messages at any time and returns at each tick the messages to publish.
///
/// Without a goal it publishes nothing. With a goal it publishes a velocity at each tick. It brakes to zero while an input is
/// missing or too old, and publishes zero for a second after the goal is reached or aborted. After a new goal or on a changed
/// map it drives on while it plans. Every velocity passes the protective layer, which gets the raw scans. The
/// robot moves only while [`NodeCore::operator`] is armed; a goal never arms it. Times are seconds since 1970 by the node's
/// clock. Ages are those of the stamps: the clocks of the senders must agree with it.
pub struct NodeCore {
    settings: NodeSettings,
    engine: NodeEngine,
    inputs: LatestInputs,
    /// `None` where others localise the robot.
    localization: Option<NodeLocalization>,
    zones: ZoneInputs,
    contradicted: ContradictedMap,
    /// The goal of a client of the action, if the present goal is one.
    action: Option<ActiveGoal>,
    /// What the clients get at the next tick.
    updates: Vec<ActionUpdate>,
    /// The answer to the last goal of a client that has ended, and its end.
    last_action: Vec<ActionUpdate>,
    /// The requests for the result of the present goal, and those that a lost network process has not answered.
    result_requests: Vec<msg::ActionResultRequest>,
    lost_requests: Vec<msg::ActionResultRequest>,
    lifecycle: LifecycleState,
    /// When it was finalized, seconds.
    finalized_s: Option<f64>,
    /// The answers to requests for another state, at the next tick.
    states: Vec<msg::LifecycleAnswer>,
    /// The newest pose in the map.
    pose: Pose,
    /// The goal and its frame.
    goal: Option<(String, Goal)>,
    /// When the present goal was accepted, on the topic or by the action, seconds.
    accepted_s: f64,
    navigator: Option<Navigator>,
    map_update: MapUpdate,
    /// The paths to the newest goal, while the robot drives to the one before.
    goal_update: Preparation<Result<PlannedGoals, Fault>>,
    protection: Protection,
    published_plans: usize,
    ended_s: Option<f64>,
    /// Since when the goal has waited for a first scan, seconds.
    without_scan_since_s: Option<f64>,
    hold: Hold,
    /// Until when an ended goal publishes zero velocity at least, seconds.
    zero_until_s: f64,
    markers_s: f64,
    tick_clock: TickClock,
    command: Twist,
    conflicts: Conflicts,
    /// Why the newest message with a map or a mask is rejected, by its topic. Senders publish these once.
    rejected_grids: BTreeMap<&'static str, String>,
    diagnostics: Diagnostics,
    notices: Notices,
    stats: NodeStats,
}

/// Whether the robot stands after a loss of the transport.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Hold {
    None,
    /// Until all inputs are there, and then for a while.
    UntilInputs,
    /// Until a time, seconds.
    Until(f64),
}

impl NodeCore {
    /// Checks settings of drives for the node.
    ///
    /// # Errors
    /// The control period is longer than the node keeps.
    pub fn check(config: &Config) -> Result<(), SettingError> {
        check_period(config.local.control_period_s)
    }

    /// A node without inputs, and a robot that is not armed.
    ///
    /// # Errors
    /// A setting of the protective layer or a limit out of range, or a control period that is too long for the node.
    pub fn new(mut settings: NodeSettings, engine: Box<dyn Engine>) -> Result<Self, SettingError> {
        settings.config = settings.config.in_real_time();
        let config = &settings.config;
        Self::check(config)?;
        let tick_clock = TickClock::new(config.local.control_period_s);
        let lifecycle =
            if settings.is_managed { LifecycleState::Unconfigured } else { LifecycleState::Active };
        Ok(Self {
            protection: Protection::new(config)?,
            localization: (config.pose_source == PoseSource::Scans)
                .then(|| NodeLocalization::new(config.localization, config.unknown)),
            zones: ZoneInputs::new(settings.names.clone()),
            conflicts: Conflicts::new(settings.names.clone()),
            notices: Notices::new(settings.names.clone()),
            settings,
            engine: NodeEngine::new(engine),
            inputs: LatestInputs::default(),
            contradicted: ContradictedMap::default(),
            action: None,
            updates: Vec::new(),
            last_action: Vec::new(),
            result_requests: Vec::new(),
            lost_requests: Vec::new(),
            lifecycle,
            finalized_s: None,
            states: Vec::new(),
            pose: Pose::default(),
            goal: None,
            accepted_s: f64::NEG_INFINITY,
            navigator: None,
            map_update: MapUpdate::default(),
            goal_update: Preparation::default(),
            published_plans: 0,
            ended_s: None,
            without_scan_since_s: None,
            hold: Hold::None,
            zero_until_s: f64::NEG_INFINITY,
            markers_s: f64::NEG_INFINITY,
            tick_clock,
            command: Twist::STOP,
            rejected_grids: BTreeMap::new(),
            diagnostics: Diagnostics::default(),
            stats: NodeStats::default(),
        })
    }

    /// The operator's switch. It arms and stops the robot from any thread.
    #[must_use]
    pub fn operator(&self) -> OperatorSwitch {
        self.protection.operator()
    }

    /// The counters.
    #[must_use]
    pub const fn stats(&self) -> &NodeStats {
        &self.stats
    }

    /// The interval of the ticks, seconds.
    #[must_use]
    pub const fn period_s(&self) -> f64 {
        self.settings.config.local.control_period_s
    }

    /// The robot's base frame by its odometry, or `base_link` before the first odometry.
    #[must_use]
    pub fn base_frame(&self) -> &str {
        let odometry = self.inputs.odometry.as_ref();
        odometry.map_or("base_link", |odometry| &odometry.base_frame)
    }

    /// Takes a message that arrived at a time, seconds. A rejected message is counted, and is a notice once for each cause;
    /// a rejected goal is always one.
    pub fn receive(&mut self, now_s: f64, message: &IncomingMessage) {
        let topic = message.topic();
        let accepted = self.accept(now_s, message);
        if message.is_published() {
            self.stats.count_message(topic, accepted.is_ok());
            self.rejected_grids.remove(topic);
        }
        if let Err(error) = accepted {
            self.notices.rejected(topic, message.is_goal(), &error);
            if GRIDS.contains(&topic) {
                self.rejected_grids.insert(topic, error.to_string());
            }
        }
    }

    /// The transport was lost: no command reaches the robot, and no input the node. The node commands zero until it has new
    /// inputs, and a while longer.
    pub fn transport_lost(&mut self) {
        self.command = Twist::STOP;
        self.inputs.forget_motion();
        if let Some(localization) = &mut self.localization {
            localization.forget_scans();
        }
        self.conflicts.forget();
        self.lost_requests.append(&mut self.result_requests);
        self.hold = Hold::UntilInputs;
        if self.goal.is_some() {
            self.zero_until_s = f64::INFINITY;
        }
    }

    /// The transport is back at a time, seconds. A goal of the action is aborted; one of the topic continues. A goal that ended
    /// publishes zeros until the nodes know each other.
    pub fn transport_restored(&mut self, now_s: f64) {
        // The new process does not know it.
        let state = self.lifecycle.id();
        self.states.push(msg::LifecycleAnswer { request: 0, transition: 0, state, nanoseconds: 0 });
        self.restore_action(now_s);
        self.zero_until_s = self.zero_until_s.min(now_s + TRANSPORT_SETTLE_S);
    }

    fn accept(&mut self, now_s: f64, message: &IncomingMessage) -> Result<(), MessageError> {
        match message {
            IncomingMessage::Map(map) => self.set_map(now_s, MapInput::new(map)?),
            IncomingMessage::Scan(scan) => {
                let limits = self.age_limits();
                self.inputs.set_scan(now_s, scan, &limits)?;
                if let Some(scan) = self.inputs.raw_scan(now_s, &limits) {
                    self.protection.update_scan(&scan);
                    if let Some(localization) = &mut self.localization {
                        localization.update_scan(scan);
                    }
                }
            }
            IncomingMessage::Odometry(odometry) => {
                self.inputs.set_odometry(now_s, odometry, &self.age_limits())?;
                if let Some((measured, stamp_s)) = self.inputs.motion() {
                    self.protection.update_motion(&measured, stamp_s);
                    if let (Some(localization), Some(OdometryInput { frame, pose, .. })) =
                        (&mut self.localization, &self.inputs.odometry)
                    {
                        localization.update_odometry(frame, stamp_s, pose);
                    }
                }
            }
            IncomingMessage::InitialPose(hint) => self.set_hint(incoming::pose_hint(hint)?)?,
            IncomingMessage::ChangeState(request) => self.change_state(now_s, *request),
            IncomingMessage::Navigate(goal) => self.navigate(now_s, goal)?,
            IncomingMessage::Cancel(request) => self.cancel(now_s, *request),
            IncomingMessage::ResultRequest(request) => self.keep_result_request(*request),
            IncomingMessage::Goal(goal) => self.set_goal(now_s, &GoalInput::new(goal)?)?,
            IncomingMessage::KeepoutMask(mask) => {
                let is_new = self.zones.set_keepout(MapInput::new(mask)?);
                self.use_masks(is_new);
            }
            IncomingMessage::SpeedMask(mask) => {
                let is_new = self.zones.set_speed(MapInput::new(mask)?);
                self.use_masks(is_new);
            }
            IncomingMessage::FilterInfo(info) => {
                let is_new = self.zones.set_info(info)?;
                self.use_masks(is_new);
            }
            IncomingMessage::SpeedLimit(limit) => self.zones.set_limit(limit)?,
            IncomingMessage::Arm(msg::Bool { data: true }) => self.operator().arm(),
            IncomingMessage::Arm(msg::Bool { data: false }) => self.operator().disarm(),
            IncomingMessage::Stop(msg::Bool { data: true }) => self.operator().stop(),
            IncomingMessage::Stop(msg::Bool { data: false }) => {}
            IncomingMessage::Transforms(transforms) => {
                self.check_own_transform(now_s, transforms);
                self.inputs.frames.update(now_s, transforms, false)?;
            }
            IncomingMessage::StaticTransforms(transforms) => {
                self.inputs.frames.update(now_s, transforms, true)?;
            }
            IncomingMessage::Undecodable { expected, reason, .. } => {
                return Err(MessageError::Undecodable { reason: reason.clone(), expected });
            }
            IncomingMessage::Unmatched { topic, expected } => {
                self.notices.unmatched(topic, expected);
            }
            IncomingMessage::OtherPublisher { topic, is_present } => {
                self.conflicts.set_publisher(topic, *is_present);
            }
            IncomingMessage::OtherType { topic, expected, found } => {
                self.conflicts.set_type(topic, expected, found.as_deref());
            }
        }
        Ok(())
    }

    /// Rejects what is not in the frame of the map.
    fn check_map_frame(&self, found: &str) -> Result<(), MessageError> {
        match self.inputs.map.as_ref().map(|map| &map.frame) {
            Some(expected) if expected != found => Err(MessageError::WrongFrame {
                found: found.to_owned(),
                expected: expected.clone(),
            }),
            _ => Ok(()),
        }
    }

    /// Returns the messages to publish now. `clock` measures the duration of a decision, seconds.
    pub fn tick(&mut self, now_s: f64, clock: &mut dyn FnMut() -> f64) -> Outgoing {
        let mut outgoing = Outgoing::default();
        self.check_delays();
        let tick = self.measure_tick(now_s);
        if !(0.0..=MAX_TICK_GAP_S).contains(&tick.elapsed_s()) {
            // The node was suspended or its clock was set. The base has stopped by itself, and what was measured before is old.
            self.command = Twist::STOP;
            self.inputs.forget_motion();
            if let Some(navigator) = &mut self.navigator {
                navigator.forget_commands();
            }
        }
        if let Some(localization) = &mut self.localization {
            localization.tick();
        }
        outgoing.updated_map = self.look_for_changes(now_s);
        let odometry_frame = self.odometry_frame();
        outgoing.transforms = self.transforms(now_s, &odometry_frame);
        let inputs = self.check_inputs(now_s, odometry_frame);
        self.send_lost_requests(now_s);
        if self.goal.is_some() {
            let decision = self.decide(now_s, &inputs, clock);
            let wanted =
                decision.as_ref().map_or_else(|| self.brake(), |decision| decision.command);
            self.command = self.protection.command(&wanted, &self.command, now_s, tick);
            let action = self.protection.action();
            self.stats.count_command(action);
            if let Some(navigator) = self.navigator.as_mut().filter(|_| !action.passes()) {
                navigator.count_protection(action.name());
            }
            outgoing.command = Some(self.command);
            self.add_plan_and_markers(now_s, decision.as_ref(), &mut outgoing);
            self.add_feedback(now_s, decision.as_ref());
            self.wait_for_scan(now_s);
            self.end_cancelled(self.command == Twist::STOP);
            self.drop_ended_goal(now_s);
        } else {
            self.protection.idle();
        }
        self.notices.operator(self.protection.state());
        self.notices.protective_action(now_s, self.protection.action());
        self.notices.silence(now_s, self.stats.has_message());
        if let Some(notice) = self.conflicts.notice(now_s) {
            self.notices.push(notice);
        }
        outgoing.diagnostics = self.diagnose(now_s, &inputs);
        outgoing.action = std::mem::take(&mut self.updates);
        outgoing.states = std::mem::take(&mut self.states);
        outgoing.notices = self.notices.take();
        outgoing
    }

    /// The velocity with which the node must end: zero, unless the node has never published a command.
    #[must_use]
    pub fn final_command(&self) -> Option<Twist> {
        (self.stats.commands > 0).then_some(Twist::STOP)
    }

    fn brake(&self) -> Twist {
        let limits = &self.settings.config.robot.limits;
        limits.brake(&self.command, *self.tick_clock.last())
    }

    /// The navigator's decision; none if an input is missing, the robot must stop before planning, or there is no path.
    fn decide(
        &mut self,
        now_s: f64,
        inputs: &Inputs,
        clock: &mut dyn FnMut() -> f64,
    ) -> Option<Decision> {
        self.notices.missing(inputs.as_ref().err());
        let observation = self.inputs.observation(now_s, inputs.as_ref().ok()?)?;
        let observation = Observation { sent: Some(self.command), ..observation };
        self.pose = observation.pose;
        if self.is_held(now_s) {
            return None;
        }
        if self.protection.state() != OperatorState::Armed {
            // Until it is armed, the robot may be carried away: a new navigator plans from there.
            self.navigator = None;
            return None;
        }
        self.update_map();
        self.update_goal(now_s);
        if self.navigator.is_none() && self.ended_s.is_none() {
            // Planning takes time, during which a moving robot would not look ahead.
            if self.command != Twist::STOP {
                return None;
            }
            match self.new_navigator(&observation.pose, clock)? {
                Ok(navigator) => self.start(navigator),
                Err(fault) => self.abort_by(now_s, &fault),
            }
        }
        let navigator = self.navigator.as_mut()?;
        navigator.set_speed_limit(self.zones.limit(self.settings.config.robot.limits.max_vel_x));
        let (decision, _) = navigator.step_by(&observation, clock);
        self.notices.sensor_fault(decision.mode, navigator);
        if self.goal_update.is_running() {
            self.check_end_of_last_goal(decision.mode);
        } else {
            self.check_end(now_s, decision.mode);
        }
        Some(decision)
    }

    /// Whether the robot stands because the transport is only just back. All inputs are there.
    fn is_held(&mut self, now_s: f64) -> bool {
        if self.hold == Hold::UntilInputs {
            self.hold = Hold::Until(now_s + RESUME_HOLD_S);
        }
        let is_held = matches!(self.hold, Hold::Until(end_s) if now_s < end_s);
        if !is_held {
            self.hold = Hold::None;
        }
        is_held
    }
}
