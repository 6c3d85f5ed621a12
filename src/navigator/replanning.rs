//! When to plan anew, and which of two paths to follow.

use super::async_planner::{AsyncPlanner, PlanRequest};
use super::navigator::Navigator;
use super::predicted_state::PredictedState;
use super::progress_checker::Since;
use super::{Fault, Mode, RoutePlanner};
use crate::geometry::{Point, Pose};
use crate::global::{Plan, PlanError};
use crate::local::ClearanceField;
use crate::map::ObstacleGrid;
use crate::robot::Footprint;

/// Beyond this distance from its path the robot plans anew, metres.
const OFF_PATH_M: f64 = 2.5;
/// Within this distance it follows its path, whatever stands about, metres.
const BESIDE_PATH_M: f64 = 0.3;
/// The path is looked over at points so far apart, metres.
const LOOKS_EVERY_M: f64 = 0.1;
/// Clearance is looked up by the cell: a path at the least distance can seem nearer than it is by this share of a cell.
const LOOKUP_CELLS: f64 = 0.25;
/// A way round that is longer by no more than this is taken at once, metres.
const SMALL_DETOUR_M: f64 = 3.0;
/// No progress for so many patiences counts as waiting in vain.
const STUCK_PATIENCES: f64 = 2.0;
/// A way round people is given so many replanning periods: they move, and each plan would be another one.
const WAITED_PERIODS: f64 = 6.0;
/// What leaves no way is forgotten when it was not seen for so long, seconds, unless it is so near, metres.
const REMEMBERED_S: f64 = 5.0;
const REMEMBERED_M: f64 = 1.0;
/// A path that is clear is left for a shorter one at most once in so many replanning periods.
const SHORTER_PERIODS: f64 = 4.0;

/// Why a plan was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reason {
    /// Something stands on the path.
    Blocked,
    /// The robot is off its path.
    Strayed,
    /// It waited for somebody in vain.
    Waited,
    /// What was seen since may have opened a shorter way.
    Shorter,
}

/// Planning beside the control loop.
pub(super) struct Replanning {
    background: AsyncPlanner<Reason>,
    next_s: f64,
    next_shorter_s: f64,
    least_radius_m: f64,
    blocked: Since,
    /// Why the last attempt found no way.
    no_way: Option<PlanError>,
    /// Answers taken so far.
    taken: u64,
    /// Whether the next tick takes the answer that is due, where that is told.
    told: Option<bool>,
}

impl Replanning {
    pub fn new(known: ObstacleGrid, planner: RoutePlanner) -> Result<Self, Fault> {
        Ok(Self {
            least_radius_m: planner.least_radius_m(),
            background: AsyncPlanner::new(known, planner)?,
            next_s: f64::NEG_INFINITY,
            next_shorter_s: f64::NEG_INFINITY,
            blocked: Since::default(),
            no_way: None,
            taken: 0,
            told: None,
        })
    }

    /// The answer that this tick takes.
    fn answer(&mut self, now_s: f64, waits: bool) -> Option<(Reason, Result<Plan, PlanError>)> {
        let answer = match self.told.take() {
            Some(false) => None,
            told => self.background.due(now_s, waits || told.is_some()),
        };
        self.taken += u64::from(answer.is_some());
        answer
    }

    /// Why there is no way on, if the last plan that was asked for found none.
    pub fn no_way(&self) -> Option<PlanError> {
        self.no_way.clone()
    }

    /// Drops what is on its way: the goal is another one.
    pub fn forget(&mut self) {
        self.background.forget();
        self.blocked = Since::default();
        self.no_way = None;
    }
}

impl Navigator {
    /// How many answers of the planning thread it has taken, plans or that there is none.
    #[must_use]
    pub const fn plans_received(&self) -> u64 {
        self.replanning.taken
    }

    /// Tells whether the next step takes the answer that is due. Without `wait_for_plans` that is a matter of how busy the
    /// machine is: who repeats a run tells what it was.
    pub const fn replay_plan_arrival(&mut self, is_taken: bool) {
        self.replanning.told = Some(is_taken);
    }

    /// Takes the plan that is due, and asks for one when the way ahead is blocked, the robot strayed, it has stood for
    /// long behind something moving, or from time to time for a shorter way.
    pub(super) fn replan(
        &mut self,
        now: &PredictedState,
        field: &ClearanceField,
        off_path_m: f64,
        stuck_s: f64,
    ) {
        if !self.settings.features.replanning {
            return;
        }
        let is_blocked = self.is_blocked(field);
        let blocked_s = self.replanning.blocked.update(now.time_s, is_blocked);
        let waits = self.settings.wait_for_plans;
        if let Some((reason, plan)) = self.replanning.answer(now.time_s, waits) {
            if matches!(plan, Err(PlanError::NoValidPath { .. })) {
                // What stood there may have gone since: Nav2 clears its costmaps then.
                let since_s = now.time_s - REMEMBERED_S;
                let robot = now.pose.position();
                self.surroundings.forget(since_s, &robot, REMEMBERED_M);
            }
            self.take(reason, plan, stuck_s, blocked_s);
        }
        if self.replanning.background.is_busy() || now.time_s < self.replanning.next_s {
            return;
        }
        let Some(reason) = self.reason(now, field, is_blocked, off_path_m, stuck_s) else {
            return;
        };
        let period_s = match reason {
            Reason::Waited => WAITED_PERIODS * self.settings.replan_period_s,
            _ => self.settings.replan_period_s,
        };
        self.replanning.next_s = now.time_s + period_s;
        self.replanning.next_shorter_s = now.time_s + SHORTER_PERIODS * period_s;
        // Moving things count as obstacles only for a robot that waited for them in vain.
        let discs = if reason == Reason::Waited {
            let moving = now.moving.iter();
            moving.map(|disc| (disc.center(), disc.radius)).collect()
        } else {
            Vec::new()
        };
        let order = PlanRequest {
            start: now.pose.position(),
            goal: self.tour.goal().position,
            marks: self.surroundings.marks().collect(),
            discs,
        };
        let due_s = now.time_s + self.settings.planning_budget_s;
        self.replanning.background.ask(order, reason, due_s);
    }

    fn reason(
        &self,
        now: &PredictedState,
        field: &ClearanceField,
        is_blocked: bool,
        off_path_m: f64,
        stuck_s: f64,
    ) -> Option<Reason> {
        // A robot that backs out leaves its path on purpose; where it goes on from is known when it has done so.
        let backs = self.mode == Mode::Escaping;
        if !backs && self.has_strayed(now, field, off_path_m) {
            Some(Reason::Strayed)
        } else if is_blocked {
            Some(Reason::Blocked)
        } else if backs || stuck_s > STUCK_PATIENCES * self.settings.stuck_patience_s {
            Some(Reason::Waited)
        } else {
            let may_be_shorter = now.time_s >= self.replanning.next_shorter_s
                && self.surroundings.marks().next().is_some();
            may_be_shorter.then_some(Reason::Shorter)
        }
    }

    /// Whether the robot is far off its path, or near it with something between them.
    fn has_strayed(&self, now: &PredictedState, field: &ClearanceField, off_path_m: f64) -> bool {
        let back = self.route.path().point_at(self.route.progress_m());
        off_path_m > OFF_PATH_M
            || off_path_m > BESIDE_PATH_M
                && !self.is_straight_clear(&now.pose.position(), &back, field)
    }

    /// Whether an obstacle stands too near to the path ahead, as far as the window shows it.
    fn is_blocked(&self, field: &ClearanceField) -> bool {
        let slack_m = LOOKUP_CELLS * field.frame().resolution_m;
        let Ok(circle) = Footprint::round(self.replanning.least_radius_m - slack_m) else {
            return false;
        };
        let is_near = |point: Point| {
            let there = Pose::new(point.x, point.y, 0.0);
            field
                .clearance_m(&circle, &there)
                .is_some_and(|clearance_m| clearance_m < 0.0)
        };
        self.route
            .ahead(self.settings.path_check_distance_m, LOOKS_EVERY_M)
            .any(is_near)
    }

    /// Follows a plan that came, if it is better than going on.
    ///
    /// A way round what blocks the path may be as much longer as the robot could have driven since it saw that, and a way
    /// round people as it could have driven while it waited for them: so waiting and the detour together never cost more
    /// than twice the better of the two. What stands for long stays.
    fn take(
        &mut self,
        reason: Reason,
        plan: Result<Plan, PlanError>,
        stuck_s: f64,
        blocked_s: f64,
    ) {
        let plan = match plan {
            Ok(plan) => plan,
            Err(error) => {
                // That it stands too near to something to begin a path tells nothing of the way.
                let is_no_way = matches!(error, PlanError::NoValidPath { .. });
                self.replanning.no_way = is_no_way.then_some(error);
                return;
            }
        };
        self.replanning.no_way = None;
        let (length_m, left_m) = (plan.smoothed.length_m(), self.route.left_m());
        let driven_m = |time_s: f64| time_s * self.robot.limits.max_vel_x;
        let is_better = match reason {
            Reason::Strayed => true,
            Reason::Blocked => {
                blocked_s > self.settings.detour_patience_s
                    || length_m - left_m <= SMALL_DETOUR_M + driven_m(blocked_s)
            }
            Reason::Waited => length_m - left_m <= driven_m(stuck_s),
            Reason::Shorter => length_m < left_m * (1.0 - self.settings.min_shortcut_share),
        };
        if is_better {
            self.follow(plan);
            self.watch.rebase(self.route.left_m());
        }
    }
}
