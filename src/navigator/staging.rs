//! The staging pose of a goal: where a robot turns before it drives to a place where it cannot turn to the yaw of its goal.
//!
//! In a passage that the robot fits only lengthwise, the yaw with which it arrives follows from how it drives in: nose first or tail
//! first. It chooses that at the nearest place with room to turn, in front of the goal or beyond it. In front of a wall it turns to the
//! goal's yaw at some distance, and drives straight to the goal.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use super::exact_clearance::ExactClearance;
use super::narrow_passages::NarrowPassages;
use super::{Goal, NavigatorSettings, ObstacleModel, RobotModel};
use crate::geometry::{Point, Pose, bearing, wrap_angle};
use crate::global::{BodySpace, Path, Plan, PlanError};
use crate::map::{FreeSpace, ObstacleGrid};
use crate::robot::Footprint;

/// Angle between two checked yaws of a turn at the goal, radians, and distance between two checked places of a path, metres.
const STEP_RAD: f64 = 0.1;
const STEP_M: f64 = 0.1;
/// Most places that are tried, at least the radius of the body apart.
const MAX_PLACES: usize = 4;
/// Length of a path over which its direction is measured, metres.
const HEADING_M: f64 = 0.25;
/// Longest straight way to a goal, metres.
const MAX_STRAIGHT_M: f64 = 2.0;

/// The end of a robot that drives ahead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LeadingEnd {
    Nose,
    Tail,
}

/// The way to a goal by its staging pose.
#[derive(Clone, Debug)]
pub(super) struct Staging {
    /// The staging pose.
    pub pose: Goal,
    /// The plan to there.
    pub to_pose: Plan,
    /// The plan from there to the goal.
    pub to_goal: Plan,
    /// How the robot drives that plan.
    pub leading_end: LeadingEnd,
    direct: DirectWay,
}

/// How a robot arrives that drives to the goal directly. Where there is no such way it does not fit.
#[derive(Clone, Copy, Debug, Default)]
struct DirectWay {
    /// Direction in which it begins, radians.
    heading: f64,
    /// Whether the robot has room to turn somewhere on it. It then arrives nose first.
    has_room_to_turn: bool,
    /// Whether a robot that arrives nose first, or tail first, can turn to the yaw of the goal.
    fits_nose_first: bool,
    fits_tail_first: bool,
}

impl Staging {
    /// The plan to the goal by the staging pose, for a controller that does not stop there.
    pub fn whole(&self) -> Plan {
        let points = [self.to_pose.smoothed.points(), self.to_goal.smoothed.points()].concat();
        self.to_pose.clone().along(Path::new(points))
    }

    /// Whether a robot that starts with a yaw, radians, would arrive on the direct way so that it cannot turn to the yaw of the goal.
    pub fn is_needed(&self, yaw: f64) -> bool {
        let way = &self.direct;
        let faces_away = wrap_angle(way.heading - yaw).abs() > FRAC_PI_2;
        let arrives_tail_first = faces_away && !way.has_room_to_turn;
        !(if arrives_tail_first { way.fits_tail_first } else { way.fits_nose_first })
    }
}

/// Searches staging poses on a map.
pub(super) struct StagingSearch<'a> {
    pub obstacles: &'a ObstacleModel,
    /// Where no path leads: obstacles of the map and closed zones.
    pub closed: &'a ObstacleGrid,
    pub robot: &'a RobotModel,
    pub settings: &'a NavigatorSettings,
    /// The least distance of paths from obstacles, metres, but for narrow passages.
    pub least_radius_m: f64,
}

impl StagingSearch<'_> {
    /// The staging pose of a goal to which this plan leads directly; `None` where the robot needs none, however it arrives, or
    /// there is none. `plan` plans from one place to another.
    pub fn find(
        &self,
        goal: &Goal,
        direct: &Plan,
        mut plan: impl FnMut(Point, Point) -> Result<Plan, PlanError>,
    ) -> Option<Staging> {
        let Self { closed, robot, least_radius_m, .. } = *self;
        let yaw = goal.yaw?;
        // A robot that is there already has the yaw that it starts with.
        let is_there = direct.smoothed.length_m() <= robot.footprint.body_radius_m();
        let (heading, arrival) = if is_there { (yaw, yaw) } else { headings(&direct.smoothed) };
        let reach_m = robot.footprint.body_radius_m() + self.settings.safety_margin_m;
        // A window that is too large is an error of the first decision.
        let field = self.obstacles.window(&goal.position, reach_m).ok()?;
        let clearance = ExactClearance::new(&field, &goal.position, reach_m);
        let fits = |arrival: f64| {
            let yaws = [arrival, yaw];
            can_turn(&robot.footprint, self.settings, &goal.position, &clearance, yaws)
        };
        let (fits_nose_first, fits_tail_first) = (fits(arrival), fits(arrival + PI));
        if fits_nose_first && fits_tail_first {
            return None;
        }
        let frame = *closed.frame();
        let wide = FreeSpace::new(closed, least_radius_m);
        let is_wide = |place: &Point| frame.cell_of(place).is_some_and(|cell| wide.is_free(cell));
        let has_room_to_turn =
            !is_there && direct.smoothed.samples(STEP_M).any(|place| is_wide(&place));
        if fits_nose_first && has_room_to_turn {
            return None;
        }
        let direct_way = DirectWay { heading, has_room_to_turn, fits_nose_first, fits_tail_first };
        let start = *direct.smoothed.points().first()?;
        let straight = self.straight((goal, direct_way), start, &wide, &mut plan);
        if straight.is_some() {
            return straight;
        }
        let passages = NarrowPassages::new(
            &robot.footprint,
            self.settings,
            frame.resolution_m,
            least_radius_m,
        )?;
        let [whole, narrow, partial] = &passages.spaces(closed, &[]);
        let turned: Vec<Point> = passages.discs.iter().map(|at| Point::new(-at.x, -at.y)).collect();
        let radius_m = passages.radius_m;
        let tail_first =
            BodySpace { discs: &turned, radius_m, whole, narrow, partial, wide: &wide };
        let from = frame.cell_of(&goal.position).filter(|&cell| narrow.is_free(cell))?;
        let mut tried: Vec<Point> = Vec::new();
        let mut is_seen = vec![false; frame.len()];
        let near = narrow.flood(from, &mut is_seen).map(|(cell, _)| cell);
        for place in near.filter(|&cell| wide.is_free(cell)).map(|cell| frame.center_of(cell)) {
            let apart_m = robot.footprint.body_radius_m();
            if tried.iter().any(|other| (place - other).norm() < apart_m) {
                continue;
            }
            let ways = plan(start, place).and_then(|to| Ok((to, plan(place, goal.position)?)));
            if let Ok((to_pose, to_goal)) = ways
                && let Some((leading_end, yaw)) = self.leaves(&to_goal.smoothed, fits, &tail_first)
            {
                let pose = Goal { position: place, yaw: Some(yaw) };
                return Some(Staging { pose, to_pose, to_goal, leading_end, direct: direct_way });
            }
            tried.push(place);
            if tried.len() == MAX_PLACES {
                break;
            }
        }
        None
    }

    /// The staging pose from which the robot drives straight to a goal, to which no plan leads directly; `None` where there is none.
    pub fn straight_to(
        &self,
        goal: &Goal,
        start: Point,
        plan: impl FnMut(Point, Point) -> Result<Plan, PlanError>,
    ) -> Option<Staging> {
        let wide = FreeSpace::new(self.closed, self.least_radius_m);
        self.straight((goal, DirectWay::default()), start, &wide, plan)
    }

    /// The staging pose with the yaw of a goal from which the robot drives straight to the goal, nose first or tail first: the nearest one
    /// in the space where it can turn. `None` where an obstacle is before it.
    fn straight(
        &self,
        (goal, direct): (&Goal, DirectWay),
        start: Point,
        wide: &FreeSpace,
        mut plan: impl FnMut(Point, Point) -> Result<Plan, PlanError>,
    ) -> Option<Staging> {
        let Self { robot, settings, .. } = *self;
        let yaw = goal.yaw?;
        let footprint = &robot.footprint;
        let reach_m = footprint.body_radius_m() + settings.safety_margin_m + MAX_STRAIGHT_M;
        let field = self.obstacles.window(&goal.position, reach_m).ok()?;
        let clearance = ExactClearance::new(&field, &goal.position, reach_m);
        let at_goal = Pose::new(goal.position.x, goal.position.y, yaw);
        let kept_m = settings.safety_margin_m.min(clearance.gap_m(footprint, &at_goal));
        if kept_m <= 0.0 {
            return None;
        }
        let is_wide =
            |place: &Point| wide.frame().cell_of(place).is_some_and(|cell| wide.is_free(cell));
        let staged = |leading_end: LeadingEnd| {
            let side = if leading_end == LeadingEnd::Nose { -1.0 } else { 1.0 };
            let steps = (MAX_STRAIGHT_M / STEP_M) as u32;
            (1..=steps)
                .map(|step| at_goal.transform(&Point::new(side * f64::from(step) * STEP_M, 0.0)))
                .take_while(|at| {
                    clearance.keeps_gap(footprint, &Pose::new(at.x, at.y, yaw), kept_m)
                })
                .find(is_wide)
                .map(|place| (leading_end, place))
        };
        let can_reverse = robot.limits.min_vel_x < 0.0;
        let ends = [LeadingEnd::Nose, LeadingEnd::Tail].into_iter();
        let ends = ends.filter(|end| *end == LeadingEnd::Nose || can_reverse);
        ends.filter_map(staged).find_map(|(leading_end, place)| {
            let to_pose = plan(start, place).ok()?;
            let way = Path::new(vec![place, goal.position]);
            let to_goal = Plan::of_path(way, to_pose.radius_m);
            let pose = Goal { position: place, yaw: Some(yaw) };
            Some(Staging { pose, to_pose, to_goal, leading_end, direct })
        })
    }

    /// How the robot leaves a place for its goal along a path, and with which yaw, radians; `None` where it then cannot turn at the goal.
    /// `fits` tells whether it can, for a yaw of arrival.
    fn leaves(
        &self,
        path: &Path,
        fits: impl Fn(f64) -> bool,
        tail_first: &BodySpace<'_>,
    ) -> Option<(LeadingEnd, f64)> {
        let (yaw, arrival) = headings(path);
        if fits(arrival) {
            return Some((LeadingEnd::Nose, yaw));
        }
        let can_reverse = self.robot.limits.min_vel_x < 0.0;
        let fits = can_reverse && fits(arrival + PI) && tail_first.fits_along(path.points());
        fits.then(|| (LeadingEnd::Tail, wrap_angle(yaw + PI)))
    }
}

/// Whether the body of a robot at a place has room to turn from one yaw to another, or to within the tolerance of it, radians: one that is
/// within the safety margin must only come no nearer to an obstacle.
pub(super) fn can_turn(
    footprint: &Footprint,
    settings: &NavigatorSettings,
    place: &Point,
    clearance: &ExactClearance,
    [from, to]: [f64; 2],
) -> bool {
    let at = |yaw: f64| Pose::new(place.x, place.y, yaw);
    let kept_m = settings.safety_margin_m.min(clearance.gap_m(footprint, &at(from)));
    let shorter = wrap_angle(to - from);
    [shorter, shorter - TAU.copysign(shorter)].into_iter().any(|turn| {
        let needed = (turn.abs() - settings.yaw_goal_tolerance).max(0.0).copysign(turn);
        let steps = (needed.abs() / STEP_RAD).ceil().max(1.0);
        (1..=steps as u32).all(|step| {
            let yaw = from + needed * f64::from(step) / steps;
            clearance.keeps_gap(footprint, &at(yaw), kept_m)
        })
    })
}

/// The directions of a path at its start and at its end, radians. The very first and last points may lie beside its direction, where it
/// joins the centres of cells.
fn headings(path: &Path) -> (f64, f64) {
    let length_m = path.length_m();
    let between = |from_m: f64, to_m: f64| bearing(&path.point_at(from_m), &path.point_at(to_m));
    (between(0.0, HEADING_M), between(length_m - HEADING_M, length_m))
}
