//! When to plan a new global path, and whether to follow it.

use core::f64::consts::SQRT_2;

use super::async_planner::{AsyncPlanner, PlanRequest};
use super::condition_timer::ConditionTimer;
use super::no_path::NoPath;
use super::oncoming::{LONGEST_DETOUR_M, NO_ROOM_S, PathKind, ground_of_oncoming};
use super::retries::Retries;
use super::state::State;
use super::{Fault, GlobalPlanner, MapSource, Mode, ObstacleModel};
use crate::geometry::{Point, Pose};
use crate::global::{Plan, PlanError};
use crate::map::{MovingDisc, ObstacleGrid};
use crate::robot::Footprint;

/// Beyond this distance from its path the robot has strayed, metres.
const STRAYED_M: f64 = 2.5;
/// Within this distance the robot follows its path, whatever is between them, metres.
const ON_PATH_M: f64 = 0.3;
/// Distance between two checked points of the path, metres.
const PATH_STEP_M: f64 = 0.1;
/// Clearance is looked up by the cell: a path at the least distance can seem nearer by this share of a cell.
const LOOKUP_CELLS: f64 = 0.25;
/// The robot is near a narrow passage that begins within this distance along its path, metres.
const NARROW_AHEAD_M: f64 = 2.5;
/// The robot accepts a detour up to this length at once, metres.
const SMALL_DETOUR_M: f64 = 3.0;
/// A robot without progress for this many times the patience plans around moving obstacles.
const STUCK_PATIENCES: f64 = 2.0;
/// Replanning periods after a plan around moving obstacles: they move, and each plan would differ from the last.
const HELD_UP_PERIODS: f64 = 6.0;
/// Where no path remains, the obstacle model forgets marks that no scan hit for this long, seconds.
const FORGET_AFTER_S: f64 = 5.0;
/// Paths lead through no narrow passage as close as this to a moving obstacle, metres.
const MOVING_REACH_M: f64 = 3.0;
/// Replanning periods between two attempts to find a shortcut.
const SHORTCUT_PERIODS: f64 = 4.0;

/// Why a plan was requested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reason {
    /// An obstacle is on the path.
    Blocked,
    /// The robot is off its path.
    Strayed,
    /// The map has changed.
    NewMap,
    /// There is no path on the changed map: whether there is one without what the map does not show.
    MapAlone,
    /// Moving obstacles held the robot up for long.
    HeldUp,
    /// Changes of the obstacle model may have opened a shortcut.
    Shortcut,
    /// A person comes towards the robot along its path.
    Oncoming,
}

/// Requests plans from the planning thread and decides whether to follow them.
pub(super) struct Replanner {
    planner: AsyncPlanner<Reason>,
    next_s: f64,
    next_shortcut_s: f64,
    /// Why the last plan was requested.
    last: Option<Reason>,
    least_radius_m: f64,
    /// The plans to later goals are of the map before.
    is_map_replaced: bool,
    map_source: MapSource,
    /// The plan that is due because of the map: [`Reason::NewMap`] or [`Reason::MapAlone`].
    due_on_map: Option<Reason>,
    /// Why there is no path, whatever goes away, or that the planner of the user's own has failed.
    without_path: Option<PlanError>,
    /// Time since an obstacle has been on the path ahead, seconds; `None` without one.
    pub blocked_s: Option<f64>,
    pub path_kind: PathKind,
    /// Where there was no room beside such a person, the next attempt is due then, seconds.
    next_aside_s: f64,
    blocked: ConditionTimer,
    /// Why there is no path to the goal, if the last request found none.
    pub no_path: Option<NoPath>,
    retries: Retries,
    /// Number of answers received so far, plans and failures.
    pub received: u64,
    /// In a replay: whether the next tick receives the plan that is due.
    pub replayed_arrival: Option<bool>,
}

impl Replanner {
    /// Starts the planning thread.
    ///
    /// # Errors
    /// When the operating system starts no thread.
    pub fn new(known: ObstacleGrid, planner: Box<dyn GlobalPlanner>) -> Result<Self, Fault> {
        Ok(Self {
            least_radius_m: planner.least_radius_m(),
            planner: AsyncPlanner::new(known, planner)?,
            next_s: f64::NEG_INFINITY,
            next_shortcut_s: f64::NEG_INFINITY,
            last: None,
            is_map_replaced: false,
            map_source: MapSource::Scans,
            due_on_map: None,
            without_path: None,
            blocked_s: None,
            path_kind: PathKind::Usual,
            next_aside_s: f64::NEG_INFINITY,
            blocked: ConditionTimer::default(),
            no_path: None,
            retries: Retries::default(),
            received: 0,
            replayed_arrival: None,
        })
    }

    /// The goal has changed, and with it the plan: drops the pending request. The plan was made before the robot moved; if the map was
    /// replaced since, a new one is due at once.
    pub fn start_leg(&mut self) {
        self.planner.cancel();
        self.due_on_map = self.is_map_replaced.then_some(Reason::NewMap);
        if self.is_map_replaced {
            self.next_s = f64::NEG_INFINITY;
        }
        (self.blocked, self.blocked_s) = (ConditionTimer::default(), None);
        self.path_kind = PathKind::Usual;
        self.forget_failures();
    }

    /// All plans are new, on the present map.
    pub const fn start_mission(&mut self) {
        self.is_map_replaced = false;
    }

    /// Ends the mission.
    ///
    /// # Errors
    /// As [`GlobalPlanner::finish`].
    pub fn finish(&mut self) -> Result<(), Fault> {
        self.planner.finish().map_err(Fault::Plan)
    }

    /// Plans on another map from now on, first of all at once.
    pub fn replace_map(&mut self, planner: AsyncPlanner<Reason>, source: MapSource) {
        self.planner = planner;
        (self.is_map_replaced, self.map_source) = (true, source);
        self.due_on_map = Some(Reason::NewMap);
        self.next_s = f64::NEG_INFINITY;
        self.forget_failures();
    }

    fn forget_failures(&mut self) {
        (self.no_path, self.without_path) = (None, None);
        self.retries = Retries::default();
    }

    /// # Errors
    /// When it is time to give up: the map has no path, or none remained at too many places, one after the other.
    pub fn check_paths(&self) -> Result<(), Fault> {
        let no_path = || match &self.no_path {
            Some(NoPath::Static(error)) if self.retries.are_used_up() => Some(error),
            _ => None,
        };
        let reason = self.without_path.as_ref().or_else(no_path);
        reason.map_or(Ok(()), |error| Err(Fault::Plan(error.clone())))
    }

    /// Receives the plan that is due and returns it if it is better than going on.
    pub fn receive(&mut self, state: &State<'_>, obstacles: &mut ObstacleModel) -> Option<Plan> {
        let now_s = state.now.time_s;
        let is_path_blocked = self.is_path_blocked(state);
        self.path_kind = self.path_kind.while_met(state);
        let blocked_s = self.blocked.update(now_s, is_path_blocked);
        self.blocked_s = is_path_blocked.then_some(blocked_s);
        self.retries.advance(state.route.left_m(), state.settings.required_movement_radius);
        let (reason, answer) = match self.replayed_arrival.take() {
            Some(false) => None,
            replayed => {
                self.planner.due(now_s, state.settings.wait_for_plans || replayed.is_some())
            }
        }?;
        if matches!(answer, Err(PlanError::Interrupted { .. })) {
            // The mission is to end. A replay waits for no program that was interrupted.
            return None;
        }
        self.received += 1;
        self.no_path = None;
        let is_oncoming = reason == Reason::Oncoming;
        match answer {
            Ok(plan) => {
                let plan = is_better(&plan, reason, blocked_s, state).then_some(plan);
                if plan.is_some() {
                    self.path_kind =
                        if is_oncoming { PathKind::PastPeople } else { PathKind::Usual };
                } else if is_oncoming {
                    self.next_aside_s = now_s + NO_ROOM_S;
                }
                plan
            }
            Err(error) => {
                let is_blocked =
                    matches!(error, PlanError::NoValidPath { .. } | PlanError::GoalOccupied { .. });
                if is_oncoming && (is_blocked || matches!(error, PlanError::StartOccupied { .. })) {
                    // Where there is no room beside the person, the path remains.
                    self.next_aside_s = now_s + NO_ROOM_S;
                    return None;
                }
                let is_outside = matches!(
                    error,
                    PlanError::StartOutsideMap { .. } | PlanError::GoalOutsideMap { .. }
                );
                let has_failed = matches!(error, PlanError::InvalidPlanner { .. });
                if is_outside || has_failed || is_blocked && reason == Reason::MapAlone {
                    self.without_path = Some(error);
                    return None;
                }
                if is_blocked && reason == Reason::NewMap && self.map_source == MapSource::Given {
                    self.due_on_map = Some(Reason::MapAlone);
                }
                // An obstacle too near to the robot says nothing about the path.
                self.no_path = (!matches!(error, PlanError::StartOccupied { .. }))
                    .then(|| NoPath::new(error, reason, state, obstacles));
                // The obstacles may have gone since: Nav2 clears its costmaps here.
                if is_blocked {
                    let robot = state.now.pose.position();
                    obstacles.forget(now_s - FORGET_AFTER_S, &robot);
                    // Moving obstacles, and the marks that they leave, go away. They end no mission.
                    let is_lasting =
                        reason != Reason::HeldUp && blocked_s > state.settings.detour_patience_s;
                    if is_lasting || state.now.moving.is_empty() {
                        self.retries.add(&robot);
                    }
                }
                None
            }
        }
    }

    /// Requests a plan where there is a reason for one, at most once per replanning period.
    pub fn request(&mut self, state: &State<'_>, obstacles: &ObstacleModel) {
        let (now, settings) = (state.now, state.settings);
        let turns_to_path = self.last == Some(Reason::HeldUp) && state.mode == Mode::Rotating;
        if turns_to_path && state.limits_in_sight() != state.robot.limits {
            // The robot does not see what held it up any more, since the lidar shows nothing behind it. The next plan would lead back
            // there, and it would turn to and fro.
            self.next_s += state.tick.elapsed_s();
        }
        if self.planner.is_busy() || now.time_s < self.next_s {
            return;
        }
        let Some((reason, discs)) = self.reason(state, obstacles) else {
            return;
        };
        let period_s = match reason {
            Reason::HeldUp => HELD_UP_PERIODS * settings.replan_period_s,
            _ => settings.replan_period_s,
        };
        self.due_on_map = self.due_on_map.filter(|due| *due != reason);
        self.last = Some(reason);
        self.next_s = now.time_s + period_s;
        self.next_shortcut_s = now.time_s + SHORTCUT_PERIODS * period_s;
        let transient = obstacles.recent_marks(now.time_s - settings.detour_patience_s);
        // Beside a person who comes, the robot also passes where it has little room.
        let avoided = if reason == Reason::Oncoming { &[][..] } else { &now.near_turn[..] };
        let mut request = PlanRequest {
            start: now.pose.position(),
            goal: state.goal.position,
            marks: obstacles.marks().collect(),
            discs,
            transient: transient.chain(avoided.iter().map(with_reach)).collect(),
        };
        if reason == Reason::MapAlone {
            (request.marks, request.transient) = (Vec::new(), Vec::new());
        }
        let due_s = now.time_s + settings.planning_budget_s;
        self.planner.request(request, reason, due_s);
    }

    /// Why to plan now, and what else the path keeps clear of.
    fn reason(
        &self,
        state: &State<'_>,
        obstacles: &ObstacleModel,
    ) -> Option<(Reason, Vec<MovingDisc>)> {
        let now = state.now;
        let among_static = |reason| Some((reason, Vec::new()));
        // An escaping robot leaves its path on purpose. The place from which it will continue is not known yet.
        let escapes = state.mode == Mode::Escaping;
        if !escapes && has_strayed(state) {
            return among_static(Reason::Strayed);
        }
        if let Some(due) = self.due_on_map {
            return among_static(due);
        }
        if !escapes && now.time_s >= self.next_aside_s {
            let ground = ground_of_oncoming(state, self.least_radius_m);
            if !ground.is_empty() {
                return Some((Reason::Oncoming, ground));
            }
        }
        if self.blocked_s.is_some() {
            return among_static(Reason::Blocked);
        }
        // Moving obstacles block a path only after the robot has waited for them without success.
        if escapes || state.stuck_s > STUCK_PATIENCES * state.stuck_patience_s() {
            return Some((Reason::HeldUp, now.moving.clone()));
        }
        let may_be_shorter =
            now.time_s >= self.next_shortcut_s && obstacles.marks().next().is_some();
        may_be_shorter.then_some((Reason::Shortcut, Vec::new()))
    }

    /// Whether the path leads through narrow passages somewhere.
    fn has_narrow_path(&self, state: &State<'_>) -> bool {
        state.route.radius_m < self.least_radius_m
    }

    /// Distance along the path to a narrow passage on it that is near, metres; 0 in the passage.
    pub fn to_narrow_m(&self, state: &State<'_>) -> Option<f64> {
        if !self.has_narrow_path(state) {
            return None;
        }
        let circle = self.circle(state)?;
        let place = core::iter::once(state.now.pose.position());
        let mut places = place.chain(state.route.ahead(NARROW_AHEAD_M, PATH_STEP_M));
        let is_narrow = |at: Point| touches(state, &circle, &Pose::new(at.x, at.y, 0.0));
        let first = places.position(is_narrow)?;
        Some(first.saturating_sub(1) as f64 * PATH_STEP_M)
    }

    /// The circle for which a usual path has room. Its centre is at points of the path, not in whole cells.
    fn circle(&self, state: &State<'_>) -> Option<Footprint> {
        let slack_m = LOOKUP_CELLS * state.field.frame().resolution_m;
        Footprint::round(self.least_radius_m - slack_m).ok()
    }

    /// Whether an obstacle is too near to the path ahead, as far as the local window shows.
    fn is_path_blocked(&self, state: &State<'_>) -> bool {
        let Some(circle) = self.circle(state) else {
            return false;
        };
        // A path through narrow passages has room for the circle, or for the body that heads along it.
        let body = self.has_narrow_path(state).then(|| {
            let slack_m = SQRT_2 * state.field.frame().resolution_m;
            let margin_m = state.route.radius_m - state.slim.max_disc_radius_m() - slack_m;
            state.slim.padded(margin_m)
        });
        let touches = |pose: &Pose| {
            touches(state, &circle, pose)
                && body.as_ref().is_none_or(|body| touches(state, body, pose))
        };
        let ahead_m = state.settings.path_check_distance_m;
        state.route.poses_ahead(ahead_m, PATH_STEP_M).any(|pose| touches(&pose))
    }
}

/// Whether a body at a pose touches an obstacle of the local window.
fn touches(state: &State<'_>, body: &Footprint, pose: &Pose) -> bool {
    state.field.clearance_m(body, pose).is_some_and(|clearance_m| clearance_m < 0.0)
}

/// The places that a moving obstacle may reach while the robot is in a narrow passage, in which passive safety would hold it.
fn with_reach(disc: &MovingDisc) -> MovingDisc {
    MovingDisc { radius: disc.radius + MOVING_REACH_M, ..*disc }
}

/// Whether the robot is far off its path, or near it with an obstacle between them.
fn has_strayed(state: &State<'_>) -> bool {
    let nearest = state.route.path.point_at(state.route.progress_m);
    state.off_path_m > STRAYED_M
        || state.off_path_m > ON_PATH_M && !state.is_straight_clear_to(&nearest)
}

/// Whether to follow a plan.
///
/// The permitted length of a detour grows with time. Around an obstacle it may be longer by the distance that the robot could have
/// driven since it saw the obstacle; around moving obstacles, by the distance that it could have driven while it waited for them.
/// So waiting and detour together never cost more than twice the better of the two. An obstacle that blocks the path for long
/// counts as permanent.
fn is_better(plan: &Plan, reason: Reason, blocked_s: f64, state: &State<'_>) -> bool {
    let settings = state.settings;
    let (length_m, left_m) = (plan.smoothed.length_m(), state.route.left_m());
    let driven_m = |time_s: f64| time_s * state.robot.limits.max_vel_x;
    match reason {
        Reason::Strayed | Reason::NewMap => true,
        Reason::MapAlone => false,
        Reason::Blocked => {
            blocked_s > settings.detour_patience_s
                || length_m - left_m <= SMALL_DETOUR_M + driven_m(blocked_s)
        }
        Reason::HeldUp => length_m - left_m <= driven_m(state.stuck_s),
        Reason::Oncoming => length_m - left_m <= LONGEST_DETOUR_M,
        Reason::Shortcut => length_m < left_m * (1.0 - settings.min_shortcut_share),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{NavigatorSettings, RoutePlanner};
    use super::*;
    use crate::global;
    use crate::map::GridFrame;

    /// The robot finds no path at places apart by this, metres.
    fn after(places: u32, apart_m: f64) -> Replanner {
        let frame = GridFrame::new(20, 20, 0.1, Pose::default()).expect("a size");
        let known = ObstacleGrid::filled(frame, false);
        let footprint = Footprint::round(0.3).expect("a radius");
        let settings = NavigatorSettings::default();
        let planner = RoutePlanner::new(&footprint, &settings, global::Settings::default(), 0.1);
        let mut replanner = Replanner::new(known, Box::new(planner)).expect("a thread");
        (0..places).for_each(|place| fail(&mut replanner, apart_m * f64::from(place)));
        replanner
    }

    fn fail(replanner: &mut Replanner, x: f64) {
        let (start, goal) = (Point::new(x, 0.0), Point::new(0.0, 50.0));
        replanner.retries.add(&start);
        replanner.no_path = Some(NoPath::Static(PlanError::NoValidPath {
            start,
            goal,
            radius_m: 0.3,
            turning_radius_m: None,
            expanded: 0,
            nearest: None,
            reason: None,
        }));
    }

    fn has_given_up(replanner: &Replanner) -> bool {
        replanner.check_paths().is_err()
    }

    #[test]
    fn robot_gives_up_after_no_path_remained_at_seven_places() {
        assert!(!has_given_up(&after(6, 3.1)) && has_given_up(&after(7, 3.1)));
        // People are in the way now.
        let mut replanner = after(7, 3.1);
        replanner.no_path = Some(NoPath::Moving(Point::default()));
        assert!(!has_given_up(&replanner));
        // A plan was found since.
        let mut replanner = after(7, 3.1);
        replanner.no_path = None;
        assert!(!has_given_up(&replanner));
    }

    #[test]
    fn places_less_than_three_metres_apart_are_one() {
        assert!(!has_given_up(&after(100, 0.0)));
        // Every second place is 3.8 m from the last one that counts.
        assert!(!has_given_up(&after(12, 1.9)) && has_given_up(&after(13, 1.9)));
        // Two places, one after the other.
        let mut replanner = after(0, 0.0);
        (0..7).for_each(|place| fail(&mut replanner, f64::from(place % 2) * 4.0));
        assert!(has_given_up(&replanner));
    }

    #[test]
    fn robot_begins_anew_nearer_to_its_goal_or_with_another_one() {
        let after_left = |left_m: f64| {
            let mut replanner = after(0, 0.0);
            replanner.retries.advance(20.0, 0.5);
            (0..6).for_each(|place| fail(&mut replanner, 4.0 * f64::from(place)));
            replanner.retries.advance(left_m, 0.5);
            fail(&mut replanner, 40.0);
            has_given_up(&replanner)
        };
        assert!(after_left(19.6) && after_left(30.0) && !after_left(19.4));
        let mut replanner = after(7, 4.0);
        replanner.start_leg();
        assert!(!has_given_up(&replanner));
        fail(&mut replanner, 40.0);
        assert!(!has_given_up(&replanner), "another goal");
        let mut replanner = after(7, 4.0);
        replanner.replace_map(after(0, 0.0).planner, MapSource::Given);
        fail(&mut replanner, 40.0);
        assert!(!has_given_up(&replanner), "another map");
    }
}
