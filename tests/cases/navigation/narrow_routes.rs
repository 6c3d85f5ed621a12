//! Global plans through passages that only one heading of the body fits, against brute force.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use inbye::geometry::{Point, Pose, wrap_angle};
use inbye::global::{self, NarrowStretch, Plan, PlanError, Travel};
use inbye::map::{Cell, GridFrame, ObstacleGrid};
use inbye::navigator::{NavigatorSettings, RoutePlanner};
use inbye::robot::{Footprint, Polygon};

const RESOLUTION_M: f64 = 0.05;
const MARGIN_M: f64 = 0.05;
const LENGTH_M: f64 = 0.7;

fn planner(width_m: f64, may_reverse: bool) -> RoutePlanner {
    let body = Polygon::rectangle(LENGTH_M, width_m).expect("a rectangle");
    let mut navigator = NavigatorSettings::default();
    navigator.safety_margin_m = MARGIN_M;
    let settings = global::Settings::default();
    RoutePlanner::new(&Footprint::covering(body), &navigator, settings, RESOLUTION_M)
        .reversing(may_reverse)
}

/// Blocks the cells whose centre a rule selects, by the coordinates of the centre, metres.
fn ground(is_blocked: impl Fn(f64, f64) -> bool) -> ObstacleGrid {
    let origin = Pose::new(-4.0, -4.0, 0.0);
    let frame = GridFrame::new(160, 160, RESOLUTION_M, origin).expect("a sound size");
    let blocked = (0..frame.len()).map(|index| {
        let at = frame.center_of(frame.cell_at(index));
        is_blocked(at.x, at.y)
    });
    ObstacleGrid::new(frame, blocked.collect())
}

/// A wall, 0.2 m thick, through the origin at right angles to a direction, with a door at the origin.
fn wall_with_door(direction: f64, door_m: f64) -> ObstacleGrid {
    let (sin, cos) = libm::sincos(direction);
    ground(|x, y| {
        let (along, aside) = (cos * x + sin * y, cos * y - sin * x);
        along.abs() < 0.1 && aside.abs() > door_m / 2.0
    })
}

/// Start and goal in front of the door and behind it.
fn ends(direction: f64) -> [Point; 2] {
    let (sin, cos) = libm::sincos(direction);
    [Point::new(-2.0 * cos, -2.0 * sin), Point::new(2.0 * cos, 2.0 * sin)]
}

/// Width of the passage between the corners of the cells on both sides of a line through the origin, metres.
fn true_width_m(obstacles: &ObstacleGrid, direction: f64) -> f64 {
    let (sin, cos) = libm::sincos(direction);
    let frame = obstacles.frame();
    let (mut left, mut right) = (f64::INFINITY, f64::INFINITY);
    for index in (0..frame.len()).filter(|&index| obstacles.cells()[index]) {
        for corner in corners(frame, frame.cell_at(index)) {
            let aside = cos * corner.y - sin * corner.x;
            if aside > 0.0 {
                left = left.min(aside);
            } else {
                right = right.min(-aside);
            }
        }
    }
    left + right
}

fn corners(frame: &GridFrame, cell: Cell) -> [Point; 4] {
    let at = |dx: f64, dy: f64| {
        frame.from_cell_units(&Point::new(f64::from(cell.column) + dx, f64::from(cell.row) + dy))
    };
    [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)]
}

fn to_segment(point: &Point, from: &Point, to: &Point) -> f64 {
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    let along = ((point.x - from.x) * dx + (point.y - from.y) * dy) / (dx * dx + dy * dy);
    let along = along.clamp(0.0, 1.0);
    libm::hypot(point.x - from.x - along * dx, point.y - from.y - along * dy)
}

/// Distance between two convex polygons; zero where no edge separates them.
fn convex_gap(one: &[Point], other: &[Point]) -> f64 {
    let edges = |shape: &[Point]| -> Vec<(Point, Point)> {
        (0..shape.len()).map(|index| (shape[index], shape[(index + 1) % shape.len()])).collect()
    };
    let is_separated = edges(one).iter().chain(&edges(other)).any(|(from, to)| {
        let normal = (to.y - from.y, from.x - to.x);
        let span = |shape: &[Point]| {
            let at = shape.iter().map(|point| normal.0 * point.x + normal.1 * point.y);
            at.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
                (low.min(at), high.max(at))
            })
        };
        let (first, second) = (span(one), span(other));
        first.1 < second.0 || second.1 < first.0
    });
    if !is_separated {
        return 0.0;
    }
    let mut least = f64::INFINITY;
    for (shape, edges) in [(one, edges(other)), (other, edges(one))] {
        for point in shape {
            for (from, to) in &edges {
                least = least.min(to_segment(point, from, to));
            }
        }
    }
    least
}

/// The least distance between a body at any of these poses and the square of any obstacle cell, metres; at most half a metre.
fn least_gap_m(obstacles: &ObstacleGrid, width_m: f64, poses: &[Pose]) -> f64 {
    let frame = obstacles.frame();
    let (x, y) = (LENGTH_M / 2.0, width_m / 2.0);
    let body = [(x, y), (-x, y), (-x, -y), (x, -y)].map(|(x, y)| Point::new(x, y));
    let mut least: f64 = 0.5;
    for index in (0..frame.len()).filter(|&index| obstacles.cells()[index]) {
        let square = corners(frame, frame.cell_at(index));
        for pose in poses {
            if libm::hypot(square[0].x - pose.x, square[0].y - pose.y) < 1.2 {
                let body = body.map(|corner| pose.transform(&corner));
                least = least.min(convex_gap(&body, &square));
            }
        }
    }
    least
}

fn heading(plan: &Plan, stretch: &NarrowStretch) -> f64 {
    let from = plan.smoothed.point_at(stretch.from_m);
    let to = plan.smoothed.point_at(stretch.to_m);
    let along = libm::atan2(to.y - from.y, to.x - from.x);
    if stretch.travel == Travel::Backward { wrap_angle(along + PI) } else { along }
}

/// The poses of a robot that drives the narrow stretches, and turns between two that follow each other.
fn narrow_poses(plan: &Plan) -> Vec<Pose> {
    let mut poses = Vec::new();
    let mut last: Option<(f64, f64)> = None;
    for stretch in &plan.narrow {
        let yaw = heading(plan, stretch);
        let from = plan.smoothed.point_at(stretch.from_m);
        if let Some((end_m, before)) = last
            && end_m == stretch.from_m
        {
            let turn = wrap_angle(yaw - before);
            poses.extend(
                (0..=40)
                    .map(|step| Pose::new(from.x, from.y, before + turn * f64::from(step) / 40.0)),
            );
        }
        let steps = ((stretch.to_m - stretch.from_m) / 0.01).ceil();
        for step in 0..=steps as u32 {
            let arc_m =
                stretch.from_m + (stretch.to_m - stretch.from_m) * f64::from(step) / steps.max(1.0);
            let place = plan.smoothed.point_at(arc_m);
            let ends =
                [plan.smoothed.point_at(stretch.from_m), plan.smoothed.point_at(stretch.to_m)];
            assert!(to_segment(&place, &ends[0], &ends[1]) < 1e-9, "a narrow stretch is straight");
            poses.push(Pose::new(place.x, place.y, yaw));
        }
        last = Some((stretch.to_m, yaw));
    }
    poses
}

fn plan_through(obstacles: &ObstacleGrid, direction: f64, width_m: f64) -> Result<Plan, PlanError> {
    let [start, goal] = ends(direction);
    planner(width_m, true).plan(obstacles, start, goal, &mut || 0.0)
}

#[test]
fn search_finds_door_as_wide_as_the_body_with_margins_and_refuses_a_narrower_one() {
    for direction in [0.0, FRAC_PI_2, PI] {
        for door_m in [0.6, 0.65, 0.75] {
            let obstacles = wall_with_door(direction, door_m);
            let door_m = true_width_m(&obstacles, direction);
            let fits_m = door_m - 2.0 * MARGIN_M;
            let plan = plan_through(&obstacles, direction, fits_m).expect("the body fits");
            assert!(!plan.narrow.is_empty(), "{direction} {door_m}");
            let error = plan_through(&obstacles, direction, fits_m + 0.02).expect_err("too wide");
            assert_eq!(error.code(), "NO_VALID_PATH");
        }
    }
}

#[test]
fn search_finds_oblique_doors_within_three_centimetres_and_refuses_narrower_ones() {
    for direction in [FRAC_PI_4, libm::atan(0.5), libm::atan(1.0 / 3.0), -FRAC_PI_4] {
        let obstacles = wall_with_door(direction, 0.75);
        let fits_m = true_width_m(&obstacles, direction) - 2.0 * MARGIN_M;
        let plan = plan_through(&obstacles, direction, fits_m - 0.03).expect("the body fits");
        assert!(!plan.narrow.is_empty(), "{direction}");
        assert!(plan_through(&obstacles, direction, fits_m + 0.02).is_err(), "{direction}");
    }
    for direction in [0.1, 0.2, 0.6] {
        let obstacles = wall_with_door(direction, 0.8);
        let fits_m = true_width_m(&obstacles, direction) - 2.0 * MARGIN_M;
        plan_through(&obstacles, direction, fits_m - 0.06).expect("the body fits");
    }
}

#[test]
fn narrow_stretches_keep_the_margin_by_brute_force_and_a_turned_or_wider_body_does_not() {
    for direction in [0.0, 0.2, FRAC_PI_4, 1.2, 2.0, -2.6] {
        let obstacles = wall_with_door(direction, 0.75);
        let width_m = true_width_m(&obstacles, direction) - 2.0 * MARGIN_M - 0.06;
        let plan = plan_through(&obstacles, direction, width_m).expect("the body fits");
        let poses = narrow_poses(&plan);
        let kept_m = least_gap_m(&obstacles, width_m, &poses);
        assert!(kept_m >= MARGIN_M - 1e-5, "{direction}: {kept_m} m");
        let turned: Vec<Pose> =
            poses.iter().map(|pose| Pose { yaw: pose.yaw + 0.3, ..*pose }).collect();
        assert!(least_gap_m(&obstacles, width_m, &turned) < MARGIN_M, "{direction}");
        assert!(least_gap_m(&obstacles, width_m + 0.1, &poses) < MARGIN_M, "{direction}");
    }
}

/// A corridor 0.65 m wide that ends at x = -2.5 and opens at x = 0 into a room.
fn dead_end() -> ObstacleGrid {
    ground(|x, y| (x < 0.0 && y.abs() > 0.325) || x < -2.5)
}

#[test]
fn robot_in_a_dead_end_backs_out_if_it_may_reverse() {
    let obstacles = dead_end();
    let (start, goal) = (Point::new(-2.0, 0.01), Point::new(2.0, 1.5));
    let plan = |yaw: f64, may_reverse: bool| {
        planner(0.5, may_reverse).plan_from(&obstacles, (start, Some(yaw)), goal, &mut || 0.0)
    };
    let backs = plan(PI - 0.05, true).expect("a path out");
    let first = backs.narrow.first().expect("a narrow stretch");
    assert_eq!((first.travel, first.from_m), (Travel::Backward, 0.0));
    assert!(least_gap_m(&obstacles, 0.5, &narrow_poses(&backs)) >= MARGIN_M - 1e-5);
    let drives = plan(0.05, false).expect("a path out");
    assert_eq!(drives.narrow.first().expect("a narrow stretch").travel, Travel::Forward);
    assert!(plan(PI, false).is_err(), "it has no room to turn");
    assert!(plan(1.2, true).is_err(), "no pose with this yaw is free");
}

#[test]
fn narrow_door_is_taken_instead_of_a_big_detour_only() {
    // A wall with a narrow door in the middle and a wide one near the border.
    let obstacles =
        |wide_at: f64| ground(|x, y| x.abs() < 0.1 && y.abs() > 0.325 && (y - wide_at).abs() > 0.6);
    for (wide_at, is_narrow) in [(3.2, true), (1.2, false)] {
        let [start, goal] = ends(0.0);
        let obstacles = obstacles(wide_at);
        let plan = planner(0.5, true).plan(&obstacles, start, goal, &mut || 0.0);
        let plan = plan.expect("two doors");
        assert_eq!(!plan.narrow.is_empty(), is_narrow, "{}", plan.smoothed.length_m());
    }
}
