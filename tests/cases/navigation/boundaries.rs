//! What the navigator refuses before the robot moves: settings, limits and goals out of range, and paths of wrong planners.

use std::sync::Arc;

use inbye::geometry::{Point, Pose, Twist, bearing};
use inbye::global::{self, Path, Plan, PlanError};
use inbye::local::{ClearanceField, CpuEngine, LocalPlanner, LocalSettings};
use inbye::map::{GridFrame, MovingDisc, ObstacleGrid, OccupancyGrid, Scan};
use inbye::navigator::{
    Controller, ControllerInput, ControllerReply, Fault, GlobalPlanner, Goal, Navigator,
    NavigatorSettings, RobotModel, RoutePlanner, Waypoints,
};
use inbye::robot::{Footprint, Limits};
use inbye::runtime::{Config, Decider, Mission, Observer};
use inbye::sim::{Episode, Simulation};

const START: Point = Point { x: 2.0, y: 2.0 };
const GOAL: Point = Point { x: 6.0, y: 2.0 };

fn ground() -> ObstacleGrid {
    let frame = GridFrame::new(80, 40, 0.1, Pose::default()).expect("a valid size");
    ObstacleGrid::new(frame, vec![false; frame.len()])
}

fn planner(settings: &NavigatorSettings) -> Box<dyn GlobalPlanner> {
    let footprint = Footprint::round(0.3).expect("a radius");
    Box::new(RoutePlanner::new(&footprint, settings, global::Settings::default(), 0.1))
}

/// The error of a new navigator.
fn refused(
    limits: Limits,
    local: LocalSettings,
    settings: NavigatorSettings,
    goal: Goal,
    global_planner: Box<dyn GlobalPlanner>,
) -> Option<String> {
    let footprint = Footprint::round(0.3).expect("a radius");
    let waypoints = Waypoints { start: START, goals: vec![goal] };
    let local_planner = LocalPlanner::new(Box::new(CpuEngine::single_threaded()), local);
    let navigator = Navigator::new(
        ground(),
        &waypoints,
        RobotModel { limits, footprint },
        local_planner,
        global_planner,
        settings,
        &mut || 0.0,
    );
    navigator.err().map(|fault| fault.to_string())
}

fn refused_settings(limits: Limits, local: LocalSettings, settings: NavigatorSettings) -> String {
    let own = planner(&NavigatorSettings::default());
    refused(limits, local, settings, Goal::at(GOAL), own).unwrap_or_default()
}

#[test]
fn navigator_refuses_settings_and_limits_out_of_range() {
    let (limits, local, settings) =
        (Limits::default(), LocalSettings::default(), NavigatorSettings::default());
    for (limits, key) in [
        (limits.max_vel_x(f64::NAN), "[robot.limits] max_vel_x is NaN"),
        (limits.max_vel_x(-1.0), "[robot.limits] max_vel_x is -1"),
        (limits.max_vel_theta(-1.0), "[robot.limits] max_vel_theta is -1"),
        (limits.decel_lim_x(f64::INFINITY), "[robot.limits] decel_lim_x is inf"),
    ] {
        let error = refused_settings(limits, local.clone(), settings.clone());
        assert!(error.starts_with(key), "{key}: {error}");
    }
    for (local, key) in [
        (local.clone().control_period_s(f64::INFINITY), "[local] control_period_s is inf"),
        (local.clone().sim_time_s(-1.0), "[local] sim_time_s is -1"),
        (local.clone().max_clearance_m(10.9), "NO_DECISION: the sum of max_clearance_m of"),
    ] {
        let error = refused_settings(limits, local, settings.clone());
        assert!(error.starts_with(key), "{key}: {error}");
    }
    for (settings, key) in [
        (settings.clone().key_node_spacing_m(0.0), "[navigator] key_node_spacing_m is 0"),
        (settings.clone().moving_margin_m(f64::NAN), "[navigator] moving_margin_m is NaN"),
        (
            settings.clone().safety_margin_m(9.5),
            "NO_DECISION: the sum of max_clearance_m of [local], safety_margin_m of [navigator]",
        ),
    ] {
        let error = refused_settings(limits, local.clone(), settings);
        assert!(error.starts_with(key), "{key}: {error}");
    }
    assert_eq!(refused_settings(limits, local, settings), "");
}

#[test]
fn route_planner_refuses_settings_and_resolutions_out_of_range() {
    let footprint = Footprint::round(0.3).expect("a radius");
    let planned =
        |margin_m: f64, resolution_m: f64| {
            let settings = NavigatorSettings::default().safety_margin_m(margin_m);
            RoutePlanner::new(&footprint, &settings, global::Settings::default(), resolution_m)
                .plan(&ground(), START, GOAL, &mut || 0.0)
        };
    assert!(planned(0.05, 0.1).is_ok());
    for (margin_m, resolution_m) in
        [(f64::INFINITY, 0.1), (-1.0, 0.1), (0.05, f64::NAN), (0.05, 0.0), (0.05, -1.0)]
    {
        let error = planned(margin_m, resolution_m);
        assert!(matches!(error, Err(PlanError::Setting(_))), "{margin_m}, {resolution_m}");
    }
}

#[test]
fn yaw_of_a_goal_must_be_finite() {
    for yaw in [f64::NAN, f64::INFINITY] {
        let settings = NavigatorSettings::default();
        let (limits, local, own) =
            (Limits::default(), LocalSettings::default(), planner(&settings));
        let goal = Goal { position: GOAL, yaw: Some(yaw) };
        let error = refused(limits, local, settings, goal, own).unwrap_or_default();
        assert!(error.starts_with("yaw of a goal is "), "{error}");
    }
}

#[test]
fn mission_and_episode_check_their_numbers() {
    let map = OccupancyGrid::new(*ground().frame(), vec![0; ground().frame().len()]);
    let mission = Mission::new(Arc::new(map), Pose::new(START.x, START.y, 0.0), Goal::at(GOAL));
    assert_eq!(mission.validate(), Ok(()));
    let episode = |mission: Mission| Episode::new(&Simulation::new(mission), &Config::default());
    assert!(episode(mission.clone()).is_ok());
    let turned = Goal { yaw: Some(f64::NAN), ..mission.goal };
    for (mission, name) in [
        (Mission { goal: turned, ..mission.clone() }, "yaw of a goal is NaN"),
        (Mission { start: Pose::new(2.0, 2.0, f64::NAN), ..mission.clone() }, "yaw of the start"),
        (Mission { time_limit_s: f64::NAN, ..mission.clone() }, "time_limit_s is NaN"),
        (Mission { done_within_m: Some(f64::INFINITY), ..mission.clone() }, "done_within_m is inf"),
    ] {
        let error = mission.validate().expect_err(name).to_string();
        assert!(error.starts_with(name), "{error}");
        assert!(episode(mission).is_err(), "{name}");
    }
    let nowhere = Goal::at(Point::new(f64::NAN, 2.0));
    assert!(episode(Mission { goal: nowhere, ..mission }).is_err());
}

/// A global planner that always returns the same points.
struct Fixed(Vec<Point>);

impl GlobalPlanner for Fixed {
    fn plan(
        &mut self,
        _obstacles: &ObstacleGrid,
        _transient: &[MovingDisc],
        _start: Point,
        _goal: Point,
        _clock: &mut dyn FnMut() -> f64,
    ) -> Result<Plan, PlanError> {
        Ok(Plan::of_path(Path::new(self.0.clone()), 0.4))
    }

    fn least_radius_m(&self) -> f64 {
        0.4
    }
}

#[test]
fn path_of_a_planner_of_ones_own_is_checked() {
    let planned = |points: &[Point]| {
        let (limits, local) = (Limits::default(), LocalSettings::default());
        let wrong = Box::new(Fixed(points.to_vec()));
        refused(limits, local, NavigatorSettings::default(), Goal::at(GOAL), wrong)
    };
    assert_eq!(planned(&[START, GOAL]), None);
    for middle in [Point::new(f64::NAN, 1.0), Point::new(4.0, 50.0)] {
        let error = planned(&[START, middle, GOAL]).unwrap_or_default();
        assert!(error.starts_with("INVALID_PLANNER: "), "{error}");
    }
    let error = planned(&[Point::new(1.0, 1.0), Point::new(1.0, 2.0)]).unwrap_or_default();
    assert!(error.starts_with("INVALID_PLANNER: "), "{error}");
}

#[test]
fn configuration_makes_no_navigator_with_settings_out_of_range() {
    let mut config = Config::default();
    config.navigator.moving_margin_m = f64::NAN;
    let waypoints = Waypoints { start: START, goals: vec![Goal::at(GOAL)] };
    let engine = Box::new(CpuEngine::single_threaded());
    let navigator = config.new_navigator(ground(), &waypoints, engine, &mut || 0.0);
    assert!(matches!(navigator.err(), Some(Fault::Setting(_) | Fault::Plan(_))));
}

#[test]
fn values_for_no_measurement_make_and_hide_no_obstacle() {
    for nothing in [-1.0, 0.0, f64::NEG_INFINITY, f64::NAN] {
        let scan = Scan::from_measurements(360, 10.0, [(0.0, 1.2), (0.001, nothing)].into_iter());
        assert_eq!(scan.ranges[180].to_bits(), 1.2_f64.to_bits(), "{nothing}");
        let scan = Scan { ranges: vec![nothing; 360], ..scan };
        assert_eq!(scan.hits(&Pose::default()).count(), 0, "{nothing}");
    }
    for direction in [f64::NAN, f64::INFINITY] {
        let scan = Scan::from_measurements(360, 10.0, [(direction, 0.5)].into_iter());
        assert!(scan.ranges.iter().all(|range| range.is_nan()));
    }
}

/// Drives straight on.
struct Straight;

impl Controller for Straight {
    fn name(&self) -> &'static str {
        "straight"
    }

    fn set_plan(&mut self, _path: &Path) {}

    fn compute_velocity(&mut self, input: &ControllerInput<'_>) -> ControllerReply {
        Ok(Twist::new(input.limits.max_vel_x.min(input.local_target.x), 0.0))
    }

    fn reset(&mut self) {}
}

/// It passes the goal within the tolerance, and brakes there.
#[test]
fn robot_that_stands_beyond_the_tolerance_has_not_reached_its_goal() {
    let map = OccupancyGrid::new(*ground().frame(), vec![0; ground().frame().len()]);
    let start = Pose::new(START.x, START.y, bearing(&START, &GOAL));
    let mission =
        Mission { time_limit_s: 6.0, ..Mission::new(Arc::new(map), start, Goal::at(GOAL)) };
    for (braking, expected) in [(-0.6, false), (-3.0, true)] {
        let mut config = Config::default();
        config.robot.limits.decel_lim_x = braking;
        let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
        let decider = Decider::Controller(Box::new(Straight));
        let result = Simulation::new(mission.clone()).run(&config, decider, &mut observer);
        assert_eq!(result.expect("a drive").reached, expected, "braking with {braking} m/s^2");
    }
}

#[test]
fn controller_can_be_tested_without_a_navigator() {
    let (limits, footprint) = (Limits::default(), Footprint::round(0.3).expect("a radius"));
    let (field, scan) = (ClearanceField::new(&ground()).expect("a field"), Scan::default());
    let (path, goal) = (Path::new(vec![START, GOAL]), Goal::at(GOAL));
    let robot = (&limits, &footprint);
    let mut input = ControllerInput::new(Pose::default(), robot, &scan, &field, &path, &goal);
    input.local_target = Point::new(0.4, 0.0);
    assert_eq!(Straight.compute_velocity(&input), Ok(Twist::new(0.4, 0.0)));
}

/// Without the name a replay would run inbye's own behaviours.
#[cfg(feature = "mcap")]
#[test]
fn recording_of_a_controller_needs_its_name() {
    use inbye::recording::{BackpressurePolicy, DriveMetadata, Recorder};

    let map = OccupancyGrid::new(*ground().frame(), vec![0; ground().frame().len()]);
    let start = Pose::new(START.x, START.y, 0.0);
    let mission =
        Mission { time_limit_s: 0.5, ..Mission::new(Arc::new(map), start, Goal::at(GOAL)) };
    let config = Config::default();
    for name in [None, Some("straight".to_owned())] {
        let is_named = name.is_some();
        let mut metadata = DriveMetadata::new(&mission, &config, "controller".to_owned());
        metadata.controller = name;
        let recorder = Recorder::new(Vec::new(), &metadata, BackpressurePolicy::Block);
        let mut recorder = recorder.expect("a recorder");
        let mut observer = Observer {
            clock: &mut || 0.0,
            on_tick: &mut |event| {
                recorder.record(event);
            },
        };
        let decider = Decider::Controller(Box::new(Straight));
        let result = Simulation::new(mission.clone()).run(&config, decider, &mut observer);
        let digest = result.expect("a drive").trace.digest();
        let stopped = recorder.finish(digest).stopped;
        assert_eq!(stopped.is_none(), is_named, "{stopped:?}");
    }
}
