//! The node without its wires.

use std::fmt::Display;

use super::arrived::{self, Chart};
use super::heard::Heard;
use super::markers::{SHOWN, markers};
use super::shared_engine::SharedEngine;
use super::told::Told;
use super::{Arrived, MessageError, Published, Tally, published};
use crate::geometry::{Pose, Twist};
use crate::local::{Engine, LocalPlanner};
use crate::navigator::{Decision, Fault, Goal, Mode, Navigator, Waypoints};
use crate::ros::msg::{Header, Time};
use crate::runtime::Config;

/// After a goal, zeros are published for this long, seconds; then the node is silent, and another may drive.
const FAREWELL_S: f64 = 1.0;
/// From one set of markers to the next, seconds.
const MARKERS_EVERY_S: f64 = 0.2;

/// How a node behaves.
#[derive(Clone, Debug, Default)]
pub struct NodeSettings {
    /// Robot, planners and navigator; what it says of the simulated world is not used, and `wait_for_plans` is false.
    pub config: Config,
    /// Whether odometry is taken to be in the map's frame, whatever it says.
    pub odom_is_map: bool,
}

/// Takes messages as they come and says at each tick what to publish.
///
/// Without a goal it publishes nothing. From a goal on it publishes a velocity at each tick: braking to zero while anything
/// is missing or old, and zeros for a second when the goal is reached or given up. Given another goal or another map on the
/// way, it stops first and plans then. Times are those of the receiver's clock, in seconds: stamps are compared with one
/// another only.
pub struct NodeCore {
    settings: NodeSettings,
    engine: SharedEngine,
    heard: Heard,
    /// And the frame it is given in.
    goal: Option<(String, Goal)>,
    navigator: Option<Navigator>,
    plans_told: usize,
    ended_s: Option<f64>,
    markers_s: f64,
    command: Twist,
    told: Told,
    tally: Tally,
}

impl NodeCore {
    /// A node that has heard nothing.
    #[must_use]
    pub fn new(mut settings: NodeSettings, engine: Box<dyn Engine>) -> Self {
        // A robot on the move does not wait for a plan.
        settings.config.navigator.wait_for_plans = false;
        Self {
            settings,
            engine: SharedEngine::new(engine),
            heard: Heard::default(),
            goal: None,
            navigator: None,
            plans_told: 0,
            ended_s: None,
            markers_s: f64::NEG_INFINITY,
            command: Twist::STOP,
            told: Told::default(),
            tally: Tally::default(),
        }
    }

    /// What it has met so far.
    #[must_use]
    pub const fn tally(&self) -> &Tally {
        &self.tally
    }

    /// Seconds from one tick to the next.
    #[must_use]
    pub const fn period_s(&self) -> f64 {
        self.settings.config.local.control_period_s
    }

    /// The robot's own frame by its odometry; ROS's usual name before that.
    #[must_use]
    pub fn base_frame(&self) -> &str {
        let motion = self.heard.motion.as_ref();
        motion.map_or("base_link", |(_, motion)| &motion.base_frame)
    }

    /// Takes in a message that came at a time. One that cannot be used is counted, and told of once for each reason.
    pub fn hear(&mut self, now_s: f64, message: &Arrived) {
        let topic = message.topic();
        match self.take_in(now_s, message) {
            Ok(()) => self.tally.took(topic),
            Err(error) => {
                self.tally.refused(topic);
                self.told.refused(topic, &error);
            }
        }
    }

    fn take_in(&mut self, now_s: f64, message: &Arrived) -> Result<(), MessageError> {
        match message {
            Arrived::Map(map) => self.take_map(now_s, Chart::of(map)?),
            Arrived::Scan(scan) => self.heard.take_scan(now_s, scan)?,
            Arrived::Odometry(odometry) => {
                self.heard.take_odometry(now_s, odometry)?;
            }
            Arrived::Goal(goal) => self.take_goal(arrived::goal(goal)?)?,
            Arrived::Transforms(said) | Arrived::StaticTransforms(said) => {
                self.heard.frames.hear(said)?;
            }
            Arrived::Undecodable(topic, reason) => {
                return Err(MessageError::Undecodable {
                    reason: reason.clone(),
                    expected: topic.type_name().1,
                });
            }
        }
        Ok(())
    }

    /// Another map is planned on anew.
    fn take_map(&mut self, now_s: f64, chart: Chart) {
        let told = format!("has a map: {chart}");
        let frame = chart.frame.clone();
        if !self.heard.take_map(chart) {
            return;
        }
        self.told.note(told);
        if self.ended_s.is_some() {
            return;
        }
        self.navigator = None;
        if let Some((found, _)) = self.goal.clone().filter(|(found, _)| *found != frame) {
            let expected = frame;
            self.give_up(now_s, &MessageError::WrongFrame { found, expected });
        }
    }

    fn take_goal(&mut self, (found, goal): (String, Goal)) -> Result<(), MessageError> {
        let map = self.heard.chart.as_ref().map(|chart| &chart.frame);
        if let Some(expected) = map.filter(|frame| **frame != found) {
            let expected = expected.clone();
            return Err(MessageError::WrongFrame { found, expected });
        }
        self.goal = Some((found, goal));
        self.navigator = None;
        self.ended_s = None;
        self.tally.goals += 1;
        Ok(())
    }

    /// What to publish now. `stamp` is the time by the wall clock, `clock` measures what a decision takes.
    pub fn tick(&mut self, now_s: f64, stamp: Time, clock: &mut dyn FnMut() -> f64) -> Published {
        let mut published = Published::default();
        if self.goal.is_some() {
            let decided = self.decide(now_s, clock);
            self.command = match &decided {
                Some(decision) => decision.command,
                None => self.braked(),
            };
            self.tally.commands += 1;
            published.command = Some(self.command);
            self.show(now_s, stamp, decided.as_ref(), &mut published);
            self.leave_goal(now_s);
        }
        published.notes = self.told.take();
        published
    }

    /// The last word: zero, where this node has said anything.
    #[must_use]
    pub fn farewell(&self) -> Option<Twist> {
        (self.tally.commands > 0).then_some(Twist::STOP)
    }

    fn braked(&self) -> Twist {
        let limits = &self.settings.config.robot.limits;
        limits.brake(&self.command, self.period_s())
    }

    /// The navigator's decision; none where something is missing, or there is no way.
    fn decide(&mut self, now_s: f64, clock: &mut dyn FnMut() -> f64) -> Option<Decision> {
        let timeout_s = self.settings.config.navigator.scan_timeout_s;
        let observed = self
            .heard
            .observation(now_s, timeout_s, self.settings.odom_is_map);
        let observation = match observed {
            Ok(observation) => observation,
            Err(missing) => {
                self.told.missing(Some(missing));
                return None;
            }
        };
        self.told.missing(None);
        if self.navigator.is_none() && self.ended_s.is_none() {
            // Planning takes its time, and nobody would look ahead meanwhile.
            if self.command != Twist::STOP {
                return None;
            }
            match self.set_out(&observation.pose, clock)? {
                Ok(navigator) => self.begin(navigator),
                Err(fault) => self.give_up(now_s, &fault),
            }
        }
        let navigator = self.navigator.as_mut()?;
        let (decision, _) = navigator.step_by(&observation, clock);
        self.told.sensor_fault(decision.mode, navigator);
        self.note_end(now_s, decision.mode);
        Some(decision)
    }

    /// A navigator to the goal from where the robot is; none without a map or a goal.
    fn set_out(
        &self,
        pose: &Pose,
        clock: &mut dyn FnMut() -> f64,
    ) -> Option<Result<Navigator, Fault>> {
        let chart = self.heard.chart.as_ref()?;
        let (_, goal) = self.goal.as_ref()?;
        let config = &self.settings.config;
        let known = chart.grid.obstacles(config.unknown);
        let route_planner = config.route_planner(known.frame().resolution_m);
        let journey = Waypoints {
            start: pose.position(),
            stops: vec![*goal],
        };
        let engine = Box::new(self.engine.clone());
        Some(Navigator::new(
            known,
            &journey,
            config.robot.model(),
            LocalPlanner::new(engine, config.local.clone()),
            route_planner,
            config.navigator.clone(),
            clock,
        ))
    }

    fn begin(&mut self, navigator: Navigator) {
        let to = navigator.stop().0.position;
        self.told
            .note(format!("sets out for ({:.2}, {:.2})", to.x, to.y));
        if self.heard.mount().is_none() {
            let base_frame = self.base_frame().to_owned();
            self.told.no_mount(&base_frame);
        }
        self.told.set_out();
        self.navigator = Some(navigator);
        self.plans_told = 0;
    }

    fn note_end(&mut self, now_s: f64, mode: Mode) {
        if self.ended_s.is_some() {
            return;
        }
        if mode == Mode::Arrived {
            self.tally.reached += 1;
            self.ended_s = Some(now_s);
            self.told.note("reached the goal");
        }
        let fault = self.navigator.as_ref().and_then(Navigator::fault).cloned();
        if let Some(fault) = fault {
            self.give_up(now_s, &fault);
        }
    }

    fn give_up(&mut self, now_s: f64, why: &dyn Display) {
        self.tally.given_up += 1;
        self.ended_s = Some(now_s);
        self.told.note(format!("gave the goal up: {why}"));
    }

    /// Leaves a goal that has ended, when the robot was told to stand for a while.
    fn leave_goal(&mut self, now_s: f64) {
        let is_over = |ended_s: f64| now_s - ended_s >= FAREWELL_S;
        if self.ended_s.is_some_and(is_over) && self.command == Twist::STOP {
            self.goal = None;
            self.navigator = None;
            self.ended_s = None;
        }
    }

    /// A new plan, and markers now and then.
    fn show(
        &mut self,
        now_s: f64,
        stamp: Time,
        decided: Option<&Decision>,
        published: &mut Published,
    ) {
        let (Some(navigator), Some(chart), Some(decision)) =
            (&self.navigator, &self.heard.chart, decided)
        else {
            return;
        };
        let header = Header {
            stamp,
            frame_id: chart.frame.clone(),
        };
        if let Some(plan) = navigator
            .plans()
            .get(self.plans_told..)
            .and_then(<[_]>::last)
        {
            published.path = Some(published::path(plan.smoothed.points(), &header));
            self.plans_told = navigator.plans().len();
        }
        if now_s - self.markers_s >= MARKERS_EVERY_S {
            self.markers_s = now_s;
            let counts = decision.counts.as_ref();
            let fan = counts.and_then(|_| navigator.planner().trajectory_fan(SHOWN));
            let moving = navigator.obstacle_model().moving();
            published.markers = Some(markers(fan.as_ref(), moving, &header));
        }
    }
}
