//! Global planning at two distances from walls, and the local window around the robot.

use inbye::geometry::{Point, Pose};
use inbye::global::{self, Path, PathClearance};
use inbye::map::{Cell, GridFrame, ObstacleGrid, Scan};
use inbye::navigator::{NavigatorSettings, ObstacleModel, RoutePlanner};
use inbye::robot::Footprint;

#[test]
fn path_from_a_start_near_a_wall_keeps_the_comfort_margin() {
    let frame = GridFrame { width: 400, height: 80, resolution_m: 0.05, origin: Pose::default() };
    let mut obstacles = ObstacleGrid::filled(frame, false);
    for column in 0..400 {
        // A roadway 3 m wide with a pillar in the middle.
        let is_pillar = (190..210).contains(&column);
        for row in (0..10).chain(70..80).chain(if is_pillar { 10..36 } else { 0..0 }) {
            obstacles.set(Cell::new(column, row), true);
        }
    }
    let mut navigator = NavigatorSettings::default();
    (navigator.safety_margin_m, navigator.comfort_margin_m) = (0.05, 0.25);
    let footprint = Footprint::round(0.3).expect("a sound radius");
    let mut planner = RoutePlanner::new(&footprint, &navigator, global::Settings::default(), 0.05);
    let close_m = 0.5 + planner.least_radius_m() + 0.06;
    let ends = [Point::new(2.0, close_m), Point::new(18.0, close_m)];
    let plan = planner.plan(&obstacles, ends[0], ends[1], &mut || 0.0);
    let smoothed = plan.expect("a path past the pillar").smoothed;
    let middle = (0..100).map(|step| smoothed.point_at(5.0 + f64::from(step) / 10.0));
    let kept_m = PathClearance::new(&obstacles).min_m(&Path::new(middle.collect()));
    assert!(kept_m > planner.least_radius_m() + 0.1, "{kept_m} m");
    assert!(PathClearance::new(&obstacles).min_m(&smoothed) >= planner.least_radius_m() - 1e-9);
}

#[test]
fn comfort_margin_is_worth_a_limited_detour() {
    let frame = GridFrame::new(200, 100, 0.1, Pose::default()).expect("a sound size");
    let mut obstacles = ObstacleGrid::filled(frame, false);
    // A wall with a narrow door near both ends, and a wide one far away.
    for row in (0..100).filter(|row| !(10..23).contains(row) && *row < 80) {
        obstacles.set(Cell::new(100, row), true);
    }
    let length_m = |comfort_detour| {
        let mut navigator = NavigatorSettings::default();
        navigator.comfort_detour = comfort_detour;
        let footprint = Footprint::round(0.3).expect("a sound radius");
        let settings = global::Settings::default();
        let mut planner = RoutePlanner::new(&footprint, &navigator, settings, 0.1);
        let ends = [Point::new(7.0, 1.6), Point::new(13.0, 1.6)];
        let plan = planner.plan(&obstacles, ends[0], ends[1], &mut || 0.0);
        plan.expect("there are two doors").smoothed.length_m()
    };
    assert!(length_m(1.5) < 6.5 && length_m(10.0) > 12.0);
}

#[test]
fn used_planner_plans_as_a_new_one() {
    let frame = GridFrame::new(100, 60, 0.1, Pose::default()).expect("a sound size");
    let walled = |column: i32| {
        let mut obstacles = ObstacleGrid::filled(frame, false);
        (0..40).for_each(|row| obstacles.set(Cell::new(column, row), true));
        obstacles
    };
    let footprint = Footprint::round(0.3).expect("a sound radius");
    let new = || {
        let settings = global::Settings::default();
        RoutePlanner::new(&footprint, &NavigatorSettings::default(), settings, 0.1)
    };
    let mut used = new();
    for (column, goal_x) in [(40, 8.0), (40, 7.0), (60, 7.0), (60, 2.0), (40, 8.0)] {
        let obstacles = walled(column);
        let ends = [Point::new(2.0, 2.0), Point::new(goal_x, 2.0)];
        let [by_used, by_new] = [&mut used, &mut new()]
            .map(|planner| planner.plan(&obstacles, ends[0], ends[1], &mut || 0.0));
        assert_eq!(by_used, by_new);
        assert!(by_used.is_ok());
    }
}

#[test]
fn window_rejects_an_excessive_size_and_accepts_a_place_outside_the_map() {
    let frame = GridFrame::new(10, 10, 0.1, Pose::default()).expect("a small map");
    let model = ObstacleModel::new(ObstacleGrid::new(frame, vec![false; 100]));
    for half_m in [300.0, 1e9, f64::INFINITY] {
        let error = model.window(&Point::default(), half_m).expect_err("too large");
        assert!(error.to_string().starts_with("side of the local window"));
    }
    for far in [-1e300, -50.0, 50.0, 1e300] {
        let window = model.window(&Point::new(far, 0.0), 1.0).expect("small");
        assert_eq!(window.frame().width, 42, "{far}");
    }
}

/// Numbers of marks after 2.9 s and after 3.2 s, of returns at 130 degrees of a lidar that sees up to 135 degrees to each side. After
/// them the robot looks 17 degrees away.
fn marks_at_the_edge_of_view(returns_m: &[&[f64]]) -> [usize; 2] {
    let frame = GridFrame::new(100, 100, 0.1, Pose::default()).expect("a small map");
    let mut model = ObstacleModel::new(ObstacleGrid::filled(frame, false));
    let mut marks = [0; 2];
    for tick in 0..=32 {
        let mut scan = Scan {
            angle_min: -0.75 * core::f64::consts::PI,
            angle_increment: core::f64::consts::PI / 180.0,
            range_max: 20.0,
            ranges: vec![9.0; 271],
            ..Scan::default()
        };
        for (beam, range_m) in returns_m.get(tick).into_iter().copied().flatten().enumerate() {
            scan.ranges[265 + beam] = *range_m;
        }
        let yaw =
            if returns_m.get(tick).is_some_and(|returns| !returns.is_empty()) { 0.0 } else { -0.3 };
        model.update(0.1 * tick as f64, &Pose::new(5.03, 5.03, yaw), &scan);
        marks[usize::from(tick > 29)] = model.marks().count();
    }
    marks
}

/// A grain of dust, against a post that two scans show, or two beams of one scan.
#[test]
fn mark_of_one_return_that_no_later_scan_can_show_goes() {
    assert_eq!(marks_at_the_edge_of_view(&[&[0.6]]), [1, 0]);
    assert_eq!(marks_at_the_edge_of_view(&[&[0.6], &[0.6]]), [1, 1]);
    assert_eq!(marks_at_the_edge_of_view(&[&[0.6, 0.6]]), [1, 1]);
    assert_eq!(marks_at_the_edge_of_view(&[&[0.6], &[], &[0.66]]), [2, 2], "next to each other");
}
