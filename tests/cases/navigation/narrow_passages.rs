//! Paths through passages in which the robot fits along its path, and cannot turn on the spot.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};
use core::ops::Range;
use std::sync::Arc;

use inbye::geometry::{Point, Pose, bearing, wrap_angle};
use inbye::global::{self, Plan, PlanError};
use inbye::local::CpuEngine;
use inbye::map::{Cell, GridFrame, MovingDisc, ObstacleGrid};
use inbye::navigator::{GlobalPlanner, Goal, NavigatorSettings, RoutePlanner};
use inbye::robot::{Footprint, Limits, Polygon};
use inbye::runtime::{Config, Mission, MissionResult, Observer};
use inbye::sim::{Simulation, World};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A room of 12 by 6 m with a wall at x = 6, which has a door around y = 3. The grid may be turned.
pub(super) fn room(door_m: f64, yaw: f64) -> ObstacleGrid {
    let rows = cells_of(door_m);
    room_with_door(60 - rows / 2..60 - rows / 2 + rows, yaw)
}

fn cells_of(length_m: f64) -> i32 {
    (length_m / 0.05).round() as i32
}

/// As [`room`], with a door in these rows.
fn room_with_door(door: Range<i32>, yaw: f64) -> ObstacleGrid {
    let frame =
        GridFrame { width: 240, height: 120, resolution_m: 0.05, origin: Pose::new(0.0, 0.0, yaw) };
    let mut obstacles = ObstacleGrid::filled(frame, false);
    for row in (0..120).filter(|row| !door.contains(row)) {
        (118..122).for_each(|column| obstacles.set(Cell::new(column, row), true));
    }
    add_border(&mut obstacles);
    obstacles
}

pub(super) fn add_border(obstacles: &mut ObstacleGrid) {
    let frame = *obstacles.frame();
    for cell in frame.cells() {
        let (last_column, last_row) = (frame.width - 1, frame.height - 1);
        let is_border =
            cell.column.min(cell.row) == 0 || cell.column == last_column || cell.row == last_row;
        obstacles.set(cell, is_border || obstacles.is_blocked(cell));
    }
}

fn footprint() -> Footprint {
    Config::default().robot.footprint
}

pub(super) fn planner(change: impl FnOnce(&mut NavigatorSettings)) -> RoutePlanner {
    let mut settings = NavigatorSettings::default();
    change(&mut settings);
    RoutePlanner::new(&footprint(), &settings, global::Settings::default(), 0.05)
}

fn plan(obstacles: &ObstacleGrid, transient: &[MovingDisc]) -> Result<Plan, PlanError> {
    let place = |x, y| obstacles.frame().origin.transform(&Point::new(x, y));
    let (start, goal) = (place(2.0, 4.5), place(10.0, 1.5));
    GlobalPlanner::plan(&mut planner(|_| {}), obstacles, transient, start, goal, &mut || 0.0)
}

/// Least gap of the body that heads along a path and turns at its corners, metres, by the exact gaps of the simulator. Where the
/// circle around the body is clear, it counts.
pub(super) fn least_gap_m(obstacles: &ObstacleGrid, points: &[Point]) -> f64 {
    let world = World::new(obstacles.clone());
    let (body, circle) =
        (footprint(), Footprint::round(footprint().body_radius_m()).expect("a radius"));
    let gap_m = |pose: &Pose| world.gap_m(&circle, pose).max(world.gap_m(&body, pose));
    let mut least_m = f64::INFINITY;
    let mut last: Option<f64> = None;
    for pair in points.windows(2) {
        let yaw = bearing(&pair[0], &pair[1]);
        let turn = wrap_angle(yaw - last.replace(yaw).unwrap_or(yaw));
        for step in 0..=20 {
            let yaw = yaw - turn * f64::from(step) / 20.0;
            least_m = least_m.min(gap_m(&Pose::new(pair[0].x, pair[0].y, yaw)));
        }
        let steps = ((pair[1] - pair[0]).norm() / 0.01).ceil() as u32;
        for step in 0..=steps {
            let at = pair[0] + (pair[1] - pair[0]) * (f64::from(step) / f64::from(steps.max(1)));
            least_m = least_m.min(gap_m(&Pose::new(at.x, at.y, yaw)));
        }
    }
    least_m
}

#[test]
fn body_passes_a_door_that_its_circle_does_not() {
    let safety_m = NavigatorSettings::default().safety_margin_m;
    let usual = planner(|settings| settings.features.narrow_passages = false);
    // The body is 0.5 m wide.
    for (door_m, yaw) in [(0.75, 0.0), (0.8, 0.0), (0.9, 0.0), (0.75, 0.3), (0.8, FRAC_PI_4)] {
        let obstacles = room(door_m, yaw);
        assert!(2.0 * usual.least_radius_m() > door_m);
        let place = |x, y| obstacles.frame().origin.transform(&Point::new(x, y));
        let ends = [place(2.0, 4.5), place(10.0, 1.5)];
        let error =
            usual.clone().plan(&obstacles, ends[0], ends[1], &mut || 0.0).expect_err("narrow");
        assert!(matches!(error, PlanError::NoValidPath { .. }), "{error}");
        let plan = plan(&obstacles, &[]).expect("the body fits");
        let gap_m = least_gap_m(&obstacles, plan.smoothed.points());
        assert!(gap_m >= safety_m, "{door_m} m: {gap_m} m");
        assert!(plan.radius_m < usual.least_radius_m() && plan.smoothed.length_m() < 9.5);
    }
    assert!(matches!(plan(&room(0.7, 0.0), &[]), Err(PlanError::NoValidPath { .. })));
}

/// The robot has to turn along the wall before the door, where its ends have little room.
#[test]
fn body_passes_a_door_beside_a_wall() {
    let safety_m = NavigatorSettings::default().safety_margin_m;
    for (door_m, from_wall) in [(0.75, 0), (0.75, 1), (0.8, 0), (0.9, 0)] {
        let first = 1 + from_wall;
        let obstacles = room_with_door(first..first + cells_of(door_m), 0.0);
        let what = format!("{door_m} m, {from_wall} cells from the wall");
        let plan = plan(&obstacles, &[]).unwrap_or_else(|error| panic!("{what}: {error}"));
        let gap_m = least_gap_m(&obstacles, plan.smoothed.points());
        assert!(gap_m >= safety_m && plan.smoothed.length_m() < 10.0, "{what}: {gap_m} m");
        let result = drive(&obstacles, Pose::new(2.0, 4.5, 0.0), Point::new(10.0, 1.5));
        assert_swift(&result, 0.04, &what);
    }
    assert!(matches!(plan(&room_with_door(1..15, 0.0), &[]), Err(PlanError::NoValidPath { .. })));
}

/// A box of 0.6 m that the map does not show leaves 0.8 m of a corridor, along its wall.
#[test]
fn robot_passes_an_unmapped_box_in_a_corridor() {
    let mut known = room_with_door(1..41, 0.0);
    (0..80).for_each(|column| known.set(Cell::new(column, 40), true));
    let mut truth = known.clone();
    for row in 12..24 {
        (50..62).for_each(|column| truth.set(Cell::new(column, row), true));
    }
    for yaw in [0.0, PI] {
        let start = Pose::new(1.2, 1.0, yaw);
        let goals = [Goal::at(Point::new(10.0, 4.5))];
        let truth = Some(truth.clone());
        let result = drive_among(&Config::default(), (&known, truth), start, &goals);
        let ended = (result.why(), result.time_s);
        assert!(result.reached && result.time_s < 60.0, "{yaw}: {ended:?}");
    }
}

/// The circle around the body is free at each of these places, and some are too near to the walls for a path.
#[test]
fn path_through_a_narrow_passage_begins_near_a_wall_too() {
    let (obstacles, mut planner) = (room(0.8, 0.0), planner(|_| {}));
    let from_wall_m =
        || (0..12).map(|step| 0.05 + footprint().body_radius_m() + 0.025 * f64::from(step));
    let corner = from_wall_m().flat_map(|x| from_wall_m().map(move |y| Point::new(x, y)));
    let side = from_wall_m().flat_map(|y| [1.3, 2.1, 4.4].map(|x| Point::new(x, y)));
    for start in corner.chain(side) {
        for goal in [Point::new(10.0, 1.5), Point::new(6.0, 3.0)] {
            let plan = planner.plan(&obstacles, start, goal, &mut || 0.0);
            let plan = plan.unwrap_or_else(|error| panic!("{start:?}: {error}"));
            assert!(least_gap_m(&obstacles, plan.smoothed.points()) >= 0.05, "{start:?}");
        }
    }
}

#[test]
fn passage_next_to_an_obstacle_that_may_leave_is_not_planned_through() {
    let obstacles = room(0.9, 0.0);
    let person = |x: f64| MovingDisc { x, y: 2.5, radius: 0.3, vx: 0.0, vy: 0.0 };
    assert!(plan(&obstacles, &[person(5.8)]).is_err());
    assert!(plan(&obstacles, &[person(9.0)]).is_ok(), "far from the door");
}

/// The goal is in a chamber without a door, beyond a door that only the body fits through. Each search reads the clock.
#[test]
fn failed_request_names_the_nearest_point_beyond_a_door_without_another_usual_search() {
    let mut obstacles = room(0.9, 0.0);
    (180..184).for_each(|column| {
        (0..120).for_each(|row| obstacles.set(Cell::new(column, row), true));
    });
    let readings = core::cell::Cell::new(0);
    let mut clock = || {
        readings.set(readings.get() + 1);
        0.0
    };
    let (start, goal) = (Point::new(2.0, 4.5), Point::new(10.5, 1.5));
    let error = planner(|_| {}).plan(&obstacles, start, goal, &mut clock).expect_err("no door");
    let PlanError::NoValidPath { nearest: Some(nearest), .. } = error else { panic!("{error}") };
    assert!(nearest.x > 8.0 && nearest.x < 9.0, "{nearest:?}");
    // One reading for each of four searches without a path, four for the search that confirms the nearest point.
    assert_eq!(readings.get(), 8);
}

/// Next to a wall the body fits only in some directions. The goal is at fault, not the way to it.
#[test]
fn goal_without_room_to_turn_is_occupied_and_the_message_says_what_is_missing() {
    let (obstacles, mut planner) = (room(0.8, 0.0), planner(|_| {}));
    let start = Point::new(2.0, 4.5);
    let mut named = 0;
    // From the wall on, and into the corner.
    for step in 0..20 {
        let off_m = 0.3 + 0.01 * f64::from(step);
        for goal in [Point::new(4.0, off_m), Point::new(off_m, off_m + 0.05)] {
            let Err(error) = planner.plan(&obstacles, start, goal, &mut || 0.0) else { continue };
            let PlanError::GoalOccupied { why, .. } = &error else { panic!("{error}") };
            if why.contains("the robot cannot turn there") {
                let distance =
                    format!("less than {:.3} m from an obstacle", planner.least_radius_m());
                assert!(why.contains(&distance), "{why}");
                assert!(why.contains("; the reachable point nearest to it is ("), "{why}");
                named += 1;
            }
        }
    }
    assert!(named > 0, "the body fits in some directions at one of the goals");
}

/// The circle around this robot fits nowhere in its corridor, which a wall ends.
#[test]
fn missing_path_of_a_long_robot_is_that_of_its_body() {
    let frame = GridFrame { width: 300, height: 60, resolution_m: 0.05, origin: Pose::default() };
    let mut obstacles = ObstacleGrid::filled(frame, false);
    add_border(&mut obstacles);
    (0..60).for_each(|row| obstacles.set(Cell::new(150, row), true));
    let body = Polygon::rectangle(3.2, 0.8).expect("a rectangle");
    let settings = NavigatorSettings::default();
    let (body, global) = (Footprint::covering(body), global::Settings::default());
    let mut planner = RoutePlanner::new(&body, &settings, global, 0.05);
    let mut plan =
        |x| planner.plan(&obstacles, Point::new(2.5, 1.5), Point::new(x, 1.5), &mut || 0.0);
    plan(5.0).expect("the way along the corridor is free");
    let error = plan(12.0).expect_err("a wall");
    assert_eq!(error.code(), "NO_VALID_PATH");
    let message = error.to_string();
    assert!(
        message.contains("has room for the robot, 0.")
            && message.contains(" around it where it turns"),
        "{message}"
    );
    assert!(
        !message.contains("smaller radius") && !message.contains("cells searched"),
        "{message}"
    );
    assert_eq!(plan(14.9).expect_err("in the wall").code(), "GOAL_OCCUPIED");
}

#[test]
fn usual_path_is_kept_unless_it_is_much_longer() {
    let with_gap = |gap: i32| {
        let mut obstacles = room(0.9, 0.0);
        // A wide door at the end of the wall.
        (118..122).for_each(|column| {
            (gap..gap + 30).for_each(|row| obstacles.set(Cell::new(column, row), false));
        });
        plan(&obstacles, &[]).expect("a path").radius_m
    };
    let least_m = planner(|_| {}).least_radius_m();
    assert!(with_gap(85) >= least_m, "the wide door is near the narrow one");
    // Beyond a wall that leads around the wide door.
    let mut obstacles = room(0.9, 0.0);
    for row in 1..30 {
        (118..122).for_each(|column| obstacles.set(Cell::new(column, row), false));
    }
    for column in 20..118 {
        obstacles.set(Cell::new(column, 34), true);
    }
    assert!(plan(&obstacles, &[]).expect("a path").radius_m < least_m);
}

/// Three walls with doors at random places, and posts next to them.
fn doors(random: &mut Pcg64Mcg) -> ObstacleGrid {
    let frame = GridFrame { width: 240, height: 120, resolution_m: 0.05, origin: Pose::default() };
    let mut obstacles = ObstacleGrid::filled(frame, false);
    for column in [80, 120, 160] {
        let first = random.random_range(10..90);
        let door = first..first + random.random_range(16..22);
        for row in (0..120).filter(|row| !door.contains(row)) {
            (column..column + 2).for_each(|column| obstacles.set(Cell::new(column, row), true));
        }
        let off = random.random_range(-1.2..1.2);
        let post = Point::new(0.05 * f64::from(column) + off, random.random_range(0.0..6.0));
        obstacles.fill_disc(&post, 0.1);
    }
    add_border(&mut obstacles);
    obstacles
}

#[test]
fn body_fits_on_every_path_through_narrow_passages() {
    let safety_m = NavigatorSettings::default().safety_margin_m;
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let (mut narrow, mut unfit, mut with_headings) = (0, 0, 0);
    for case in 0..120 {
        let obstacles = doors(&mut random);
        let ends = [Point::new(1.5, random.random_range(1.0..5.0)), Point::new(10.5, 3.0)];
        let mut planner = planner(|_| {});
        let least_m = planner.least_radius_m();
        let found = planner.plan(&obstacles, ends[0], ends[1], &mut || 0.0);
        let Some(plan) = found.ok().filter(|plan| plan.radius_m < least_m) else {
            continue;
        };
        narrow += 1;
        with_headings += u32::from(plan.raw == plan.smoothed);
        let gap_m = least_gap_m(&obstacles, plan.smoothed.points());
        assert!(gap_m >= safety_m, "{case}: {gap_m} m");
        // The check can fail: two decimetres to the side of the path there is too little room.
        let beside = plan.smoothed.points().iter().map(|point| Point::new(point.x, point.y + 0.2));
        let beside: Vec<Point> = beside.collect();
        unfit += u32::from(least_gap_m(&obstacles, &beside) < safety_m);
    }
    assert!(narrow >= 20 && 2 * unfit >= narrow, "{narrow} narrow, {unfit} unfit");
    assert!(with_headings >= 3, "{with_headings} by the search with headings");
}

fn drive(obstacles: &ObstacleGrid, start: Pose, goal: Point) -> MissionResult {
    drive_with(&Config::default(), obstacles, start, goal)
}

pub(super) fn drive_with(
    config: &Config,
    obstacles: &ObstacleGrid,
    start: Pose,
    goal: Point,
) -> MissionResult {
    drive_to(config, obstacles, start, &[Goal::at(goal)])
}

/// A drive to the last goal, by the others as stops.
pub(super) fn drive_to(
    config: &Config,
    obstacles: &ObstacleGrid,
    start: Pose,
    goals: &[Goal],
) -> MissionResult {
    drive_among(config, (obstacles, None), start, goals)
}

/// As [`drive_to`], with a map and with the true obstacles, if they differ.
pub(super) fn drive_among(
    config: &Config,
    (known, truth): (&ObstacleGrid, Option<ObstacleGrid>),
    start: Pose,
    goals: &[Goal],
) -> MissionResult {
    let map = Arc::new(known.map(|&blocked| if blocked { 100 } else { 0 }));
    let (goal, stops) = goals.split_last().expect("a goal");
    let mission = Mission::new(map, start, *goal);
    let mission = Mission { time_limit_s: 150.0, via: stops.to_vec(), ..mission };
    let simulation = Simulation { truth, ..Simulation::new(mission) };
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
    let engine = Box::new(CpuEngine::single_threaded());
    simulation.run(config, engine, &mut observer).expect("a drive")
}

#[test]
fn robot_drives_through_doors() {
    for (door_m, gap_m) in [(0.8, 0.07), (0.9, 0.09)] {
        for turns in 0..4 {
            let start = Pose::new(2.0, 4.5, f64::from(turns) * TAU / 4.0);
            let result = drive(&room(door_m, 0.0), start, Point::new(10.0, 1.5));
            assert_swift(&result, gap_m, &format!("{door_m} m, {turns}"));
        }
    }
}

fn assert_swift(result: &MissionResult, gap_m: f64, what: &str) {
    let MissionResult { reached, time_s, min_clearance_m, .. } = *result;
    let is_swift = reached && time_s < 40.0 && min_clearance_m > gap_m;
    assert!(is_swift, "{what}: {reached}, {time_s} s, {min_clearance_m} m");
}

/// A Husky of 0.99 by 0.67 m, which brakes hard: between poses 0.1 s apart its engine may overlook 2 cm.
#[test]
fn fast_robot_drives_through_a_door_with_little_room() {
    let mut config = Config::default();
    let body = Polygon::rectangle(0.99, 0.67).expect("a rectangle");
    config.robot.footprint = Footprint::covering(body);
    let speeds = Limits::default().min_vel_x(-1.0).max_vel_x(1.0).max_vel_theta(2.0);
    let braking = speeds.acc_lim_x(3.0).decel_lim_x(-3.0);
    config.robot.limits = braking.acc_lim_theta(6.0).decel_lim_theta(-6.0);
    for (x, yaw) in [(2.0, 0.0), (4.5, 0.0), (4.5, FRAC_PI_2)] {
        let start = Pose::new(x, 4.5, yaw);
        let result = drive_with(&config, &room(0.85, 0.0), start, Point::new(10.0, 1.5));
        assert_swift(&result, 0.03, &format!("from {x}, {yaw}"));
    }
}

/// Two rooms, and a passage between them that leads 1.5 m along x, turns by an angle and leads on for 1.5 m.
fn bend(width_m: f64, turn: f64) -> ObstacleGrid {
    let frame = GridFrame { width: 240, height: 200, resolution_m: 0.05, origin: Pose::default() };
    let corner = Point::new(5.0, 5.0);
    let along = Pose::new(corner.x, corner.y, turn);
    let is_free = |cell: Cell| {
        let at = frame.center_of(cell);
        let (first, second) = (at - corner, along.inverse_transform(&at));
        let is_first = first.x <= 0.0 && first.x > -1.7 && first.y.abs() <= width_m / 2.0;
        let is_second = second.x >= 0.0 && second.x < 1.7 && second.y.abs() <= width_m / 2.0;
        let is_room = first.x < -1.5 || second.x > 1.5 && first.x > -1.2;
        is_first || is_second || is_room || first.norm() <= width_m / 2.0
    };
    let mut obstacles = ObstacleGrid::from_fn(frame, |cell| !is_free(cell));
    add_border(&mut obstacles);
    obstacles
}

#[test]
fn robot_drives_through_bends_in_which_it_cannot_turn_on_the_spot() {
    for turn in [0.3, 0.8, FRAC_PI_2] {
        let obstacles = bend(0.9, turn);
        let goal = Pose::new(5.0, 5.0, turn).transform(&Point::new(2.4, 0.0));
        let result = drive(&obstacles, Pose::new(2.0, 5.5, 0.0), goal);
        assert_swift(&result, 0.07, &format!("{turn} rad"));
    }
}

/// A passage that ends at x = 10, and a room before it.
pub(super) fn dead_end(width_m: f64) -> ObstacleGrid {
    let frame = GridFrame { width: 240, height: 120, resolution_m: 0.05, origin: Pose::default() };
    let is_free = |at: Point| at.x < 6.0 || at.x < 10.0 && (at.y - 3.0).abs() < width_m / 2.0;
    let mut obstacles = ObstacleGrid::from_fn(frame, |cell| !is_free(frame.center_of(cell)));
    add_border(&mut obstacles);
    obstacles
}

#[test]
fn robot_starts_and_ends_in_a_passage_and_leaves_a_dead_end_backwards() {
    for width_m in [0.8, 0.9] {
        let obstacles = dead_end(width_m);
        let (inside, outside) = (Point::new(8.0, 3.0), Point::new(3.0, 3.0));
        let into = drive(&obstacles, Pose::new(3.0, 3.0, 0.0), inside);
        assert_swift(&into, 0.07, &format!("into {width_m} m"));
        for yaw in [0.0, PI] {
            let out = drive(&obstacles, Pose::new(8.0, 3.0, yaw), outside);
            assert_swift(&out, 0.03, &format!("out of {width_m} m, {yaw} rad"));
            let backwards = out.trace.rows.iter().filter(|row| row.twist.linear < -0.1).count();
            assert_eq!(backwards > 20, yaw == 0.0, "{width_m} m: {backwards} ticks");
        }
    }
}

/// The usual discs have no room beside the wall.
#[test]
fn robot_parked_beside_a_wall_drives_away() {
    let obstacles = room(3.0, 0.0);
    for gap_m in [0.08, 0.09, 0.1] {
        let start = Pose::new(2.0, 0.05 + 0.25 + gap_m, 0.0);
        let result = drive(&obstacles, start, Point::new(10.0, 3.0));
        assert_swift(&result, 0.03, &format!("{gap_m} m from the wall"));
    }
}
