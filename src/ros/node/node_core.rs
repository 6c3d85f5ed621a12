//! The node without its transport.

use std::fmt::Display;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::incoming::{self, IncomingMessage, MapInput};
use super::latest_inputs::LatestInputs;
use super::notices::{MessageError, NodeStats, Notices};
use crate::geometry::{Pose, Twist};
use crate::local::{Detail, Engine, EngineError, Evaluation, QuantizedProblem};
use crate::map::GridFrame;
use crate::navigator::{Decision, Fault, Goal, Mode, Navigator, Waypoints};
use crate::ros::convert::{self, SAMPLING, markers};
use crate::ros::msg::{self, Duration, Header, Time};
use crate::runtime::Config;

/// Time for which zero velocity is published after a goal, seconds. Then the node is silent, and another may drive.
const STOP_S: f64 = 1.0;
/// Interval of the markers, seconds.
const MARKER_INTERVAL_S: f64 = 0.2;
/// Lifetime of a marker: markers disappear if the node stops.
const MARKER_LIFETIME: Duration = Duration { sec: 0, nanosec: 500_000_000 };

/// Settings of a node.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct NodeSettings {
    /// Robot, planners and navigator. Settings of the simulated world have no effect, and `wait_for_plans` is false.
    pub config: Config,
    /// Treats the odometry frame as the map frame.
    pub odom_is_map: bool,
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
    /// New notices for the user, a line each.
    pub notices: Vec<String>,
}

/// Takes messages at any time and returns at each tick the messages to publish.
///
/// Without a goal it publishes nothing. With a goal it publishes a velocity at each tick. It brakes to zero while an input is
/// missing or too old, and publishes zero for a second after the goal is reached or aborted. After a new goal or a new map,
/// it first stops and then plans. Times are seconds by the receiver's clock: stamps are compared only with one another.
pub struct NodeCore {
    settings: NodeSettings,
    engine: SharedEngine,
    inputs: LatestInputs,
    /// The goal and its frame.
    goal: Option<(String, Goal)>,
    navigator: Option<Navigator>,
    published_plans: usize,
    ended_s: Option<f64>,
    markers_s: f64,
    command: Twist,
    notices: Notices,
    stats: NodeStats,
}

impl NodeCore {
    /// A node without inputs.
    #[must_use]
    pub fn new(mut settings: NodeSettings, engine: Box<dyn Engine>) -> Self {
        // A driving robot must not wait for a plan.
        settings.config.navigator.wait_for_plans = false;
        Self {
            settings,
            engine: Arc::new(Mutex::new(engine)),
            inputs: LatestInputs::default(),
            goal: None,
            navigator: None,
            published_plans: 0,
            ended_s: None,
            markers_s: f64::NEG_INFINITY,
            command: Twist::STOP,
            notices: Notices::default(),
            stats: NodeStats::default(),
        }
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
        odometry.map_or("base_link", |(_, odometry)| &odometry.base_frame)
    }

    /// Takes a message that arrived at a time, seconds. A rejected message is counted, and is a notice once for each cause.
    pub fn receive(&mut self, now_s: f64, message: &IncomingMessage) {
        let topic = message.topic();
        let accepted = self.accept(now_s, message);
        self.stats.count_message(topic, accepted.is_ok());
        if let Err(error) = accepted {
            self.notices.rejected(topic, &error);
        }
    }

    fn accept(&mut self, now_s: f64, message: &IncomingMessage) -> Result<(), MessageError> {
        match message {
            IncomingMessage::Map(map) => self.set_map(now_s, MapInput::new(map)?),
            IncomingMessage::Scan(scan) => self.inputs.set_scan(now_s, scan)?,
            IncomingMessage::Odometry(odometry) => {
                self.inputs.set_odometry(now_s, odometry)?;
            }
            IncomingMessage::Goal(goal) => self.set_goal(incoming::goal(goal)?)?,
            IncomingMessage::Transforms(transforms)
            | IncomingMessage::StaticTransforms(transforms) => {
                self.inputs.frames.update(transforms)?;
            }
            IncomingMessage::Undecodable { expected, reason, .. } => {
                return Err(MessageError::Undecodable { reason: reason.clone(), expected });
            }
        }
        Ok(())
    }

    /// Sets the map. On a new map the node plans again.
    fn set_map(&mut self, now_s: f64, map: MapInput) {
        let GridFrame { width, height, resolution_m, .. } = map.grid.frame();
        let frame = map.frame.clone();
        let notice = format!(
            "received a map: {width} by {height} cells of {resolution_m} m in the frame `{frame}`"
        );
        if !self.inputs.set_map(map) {
            return;
        }
        self.notices.push(notice);
        if self.ended_s.is_some() {
            return;
        }
        self.navigator = None;
        if let Some((found, _)) = self.goal.clone().filter(|(found, _)| *found != frame) {
            let expected = frame;
            self.abort(now_s, &MessageError::WrongFrame { found, expected });
        }
    }

    fn set_goal(&mut self, (found, goal): (String, Goal)) -> Result<(), MessageError> {
        let map = self.inputs.map.as_ref().map(|map| &map.frame);
        if let Some(expected) = map.filter(|frame| **frame != found) {
            let expected = expected.clone();
            return Err(MessageError::WrongFrame { found, expected });
        }
        self.goal = Some((found, goal));
        self.navigator = None;
        self.ended_s = None;
        self.stats.goals += 1;
        Ok(())
    }

    /// Returns the messages to publish now. `stamp` is the time by the wall clock; `clock` measures the duration of a decision.
    pub fn tick(&mut self, now_s: f64, stamp: Time, clock: &mut dyn FnMut() -> f64) -> Outgoing {
        let mut outgoing = Outgoing::default();
        if self.goal.is_some() {
            let decision = self.decide(now_s, clock);
            self.command = match &decision {
                Some(decision) => decision.command,
                None => self.brake(),
            };
            self.stats.commands += 1;
            outgoing.command = Some(self.command);
            self.add_plan_and_markers(now_s, stamp, decision.as_ref(), &mut outgoing);
            self.drop_ended_goal(now_s);
        }
        outgoing.notices = self.notices.take();
        outgoing
    }

    /// The command with which the node must end: zero velocity, unless the node has never published a command.
    #[must_use]
    pub fn final_command(&self) -> Option<Twist> {
        (self.stats.commands > 0).then_some(Twist::STOP)
    }

    fn brake(&self) -> Twist {
        let limits = &self.settings.config.robot.limits;
        limits.brake(&self.command, self.period_s())
    }

    /// The navigator's decision; none if an input is missing, the robot must stop before planning, or there is no path.
    fn decide(&mut self, now_s: f64, clock: &mut dyn FnMut() -> f64) -> Option<Decision> {
        let timeout_s = self.settings.config.navigator.scan_timeout_s;
        let observation = self.inputs.observation(now_s, timeout_s, self.settings.odom_is_map);
        let observation = match observation {
            Ok(observation) => observation,
            Err(missing) => {
                self.notices.missing(Some(missing));
                return None;
            }
        };
        self.notices.missing(None);
        if self.navigator.is_none() && self.ended_s.is_none() {
            // Planning takes time, during which a moving robot would not look ahead.
            if self.command != Twist::STOP {
                return None;
            }
            match self.new_navigator(&observation.pose, clock)? {
                Ok(navigator) => self.start(navigator),
                Err(fault) => self.abort(now_s, &fault),
            }
        }
        let navigator = self.navigator.as_mut()?;
        let (decision, _) = navigator.step_by(&observation, clock);
        self.notices.sensor_fault(decision.mode, navigator);
        self.check_end(now_s, decision.mode);
        Some(decision)
    }

    /// A navigator from the robot's pose to the goal; none without a map or a goal.
    fn new_navigator(
        &self,
        pose: &Pose,
        clock: &mut dyn FnMut() -> f64,
    ) -> Option<Result<Navigator, Fault>> {
        let map = self.inputs.map.as_ref()?;
        let (_, goal) = self.goal.as_ref()?;
        let config = &self.settings.config;
        let known = map.grid.obstacles(config.unknown);
        let waypoints = Waypoints { start: pose.position(), goals: vec![*goal] };
        let engine = Box::new(self.engine.clone());
        Some(config.new_navigator(known, &waypoints, engine, clock))
    }

    fn start(&mut self, navigator: Navigator) {
        let to = navigator.goal().position;
        self.notices.push(format!("driving to ({:.2}, {:.2})", to.x, to.y));
        if self.inputs.lidar_mount().is_none() {
            let base_frame = self.base_frame().to_owned();
            self.notices.no_lidar_mount(&base_frame);
        }
        self.notices.reset_sensor_fault();
        self.navigator = Some(navigator);
        self.published_plans = 0;
    }

    fn check_end(&mut self, now_s: f64, mode: Mode) {
        if self.ended_s.is_some() {
            return;
        }
        if mode == Mode::Arrived {
            self.stats.reached += 1;
            self.ended_s = Some(now_s);
            self.notices.push("reached the goal");
        }
        let fault = self.navigator.as_ref().and_then(Navigator::fault).cloned();
        if let Some(fault) = fault {
            self.abort(now_s, &fault);
        }
    }

    fn abort(&mut self, now_s: f64, cause: &dyn Display) {
        self.stats.aborted += 1;
        self.ended_s = Some(now_s);
        self.notices.push(format!("aborted the goal: {cause}"));
    }

    /// Drops an ended goal after the robot has stood for a while.
    fn drop_ended_goal(&mut self, now_s: f64) {
        let is_over = |ended_s: f64| now_s - ended_s >= STOP_S;
        if self.ended_s.is_some_and(is_over) && self.command == Twist::STOP {
            self.goal = None;
            self.navigator = None;
            self.ended_s = None;
        }
    }

    /// Adds a new plan, and markers at their interval.
    fn add_plan_and_markers(
        &mut self,
        now_s: f64,
        stamp: Time,
        decision: Option<&Decision>,
        outgoing: &mut Outgoing,
    ) {
        let (Some(navigator), Some(map), Some(decision)) =
            (&self.navigator, &self.inputs.map, decision)
        else {
            return;
        };
        let header = Header { stamp, frame_id: map.frame.clone() };
        let plans = navigator.plans();
        let new_plan = plans.get(self.published_plans..).and_then(<[_]>::last);
        outgoing.path = new_plan.map(|plan| convert::path(plan.smoothed.points(), &header));
        self.published_plans = plans.len();
        if now_s - self.markers_s >= MARKER_INTERVAL_S {
            self.markers_s = now_s;
            let counts = decision.counts.as_ref();
            let fan = counts.and_then(|_| navigator.planner().trajectory_fan(SAMPLING));
            let moving = navigator.obstacle_model().moving();
            let markers = markers(fan.as_ref(), moving, &header, MARKER_LIFETIME);
            outgoing.markers = Some(markers);
        }
    }
}

/// An engine for successive navigators: opening one can take seconds, and a navigator owns its engine.
type SharedEngine = Arc<Mutex<Box<dyn Engine>>>;

fn lock(engine: &SharedEngine) -> MutexGuard<'_, Box<dyn Engine>> {
    // An engine is usable after a panic.
    engine.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Engine for SharedEngine {
    fn name(&self) -> String {
        lock(self).name()
    }

    fn threads(&self) -> usize {
        lock(self).threads()
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        lock(self).evaluate(problem, detail)
    }
}
