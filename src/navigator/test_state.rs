//! States of a robot on its own ground, for the tests of behaviours.

use std::sync::Arc;

use super::inflated_bodies::InflatedBodies;
use super::oncoming::PathKind;
use super::predicted_state::PredictedState;
use super::scan_health::ScanHealth;
use super::staging::LeadingEnd;
use super::state::{RobotModel, State};
use super::visible_space::VisibleSpace;
use super::{Goal, Mode, NavigatorSettings, Route, RoutePlanner};
use crate::geometry::{Point, Pose, Twist};
use crate::global;
use crate::local::{ClearanceField, LocalSettings};
use crate::map::{ObstacleGrid, Scan};

/// Control period, seconds.
pub(super) const PERIOD_S: f64 = 0.1;

/// Calls a function with the state of a robot whose path leads 3 m along x from the origin, and whose lidar sees 9 m far. The
/// robot drives as measured, by its last command. The function may change the state.
pub(super) fn with_state<R>(
    settings: &NavigatorSettings,
    robot: &RobotModel,
    ground: &ObstacleGrid,
    now: &PredictedState,
    (measured, last_command): (Twist, Twist),
    call: impl FnOnce(&mut State<'_>) -> R,
) -> R {
    let field = ClearanceField::new(ground).expect("a field");
    let free = ObstacleGrid::filled(*ground.frame(), false);
    let goal = Goal::at(Point::new(3.0, 0.0));
    let (usual, searches) = (NavigatorSettings::default(), global::Settings::default());
    let mut planner = RoutePlanner::new(&robot.footprint, &usual, searches, 0.1);
    let plan = planner.plan(&free, Point::default(), goal.position, &mut || 0.0).expect("a path");
    let scan = Scan {
        angle_min: 0.0,
        angle_increment: 0.1,
        range_max: 10.0,
        ranges: vec![9.0; 63],
        ..Scan::default()
    };
    let local = LocalSettings::default();
    call(&mut State {
        settings,
        robot,
        tick: PERIOD_S.into(),
        now,
        measured: &measured,
        last_command: &last_command,
        is_narrow: false,
        to_narrow_m: None,
        path_kind: PathKind::Usual,
        blocked_s: None,
        leading_end: LeadingEnd::Nose,
        slim: &robot.footprint,
        inflated: InflatedBodies::new(
            &robot.footprint,
            &robot.limits,
            settings,
            &local,
            &field,
            now,
        ),
        field: &Arc::new(field),
        visible: VisibleSpace { pose: now.pose, scan: &scan, health: &ScanHealth::default() },
        standing_room: None,
        goal: &goal,
        route: &Route::new(&plan, settings),
        off_path_m: 0.0,
        local_target: goal.position,
        heading_error: 0.0,
        mode: Mode::Driving,
        is_at_goal: false,
        stuck_s: 0.0,
        since_nearer_s: f64::INFINITY,
        is_slowed: false,
        fastest: robot.limits.max_vel_x,
        speed_limit: f64::INFINITY,
    })
}

/// The prediction of a robot that stands at a pose, without moving obstacles.
pub(super) fn standing_at(pose: Pose) -> PredictedState {
    PredictedState {
        time_s: 0.0,
        pose,
        twist: Twist::STOP,
        moving: Vec::new(),
        may_come: Vec::new(),
        walkers: Vec::new(),
        near_turn: Vec::new(),
        may_start: Vec::new(),
        since_scan_s: 0.1,
    }
}
