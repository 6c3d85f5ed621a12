//! Simulated moving obstacles: timed paths, patrols, random waypoints and spawn triggers.

use inbye::geometry::{Point, Pose, Vector};
use inbye::map::{GridFrame, MovingDisc, ObstacleGrid};
use inbye::robot::Footprint;
use inbye::sim::{
    MovingObstacle, MovingObstacles, SimError, SpawnTrigger, TimedPath, World, YIELD_GAP_M,
};

/// A pose far from all obstacles.
const AWAY: Pose = Pose::new(-100.0, 0.0, 0.0);

const FRAME: GridFrame =
    GridFrame { width: 200, height: 100, resolution_m: 0.05, origin: Pose::new(0.0, 0.0, 0.0) };

fn robot() -> Footprint {
    Footprint::round(0.4).expect("a valid disc")
}

fn one(moving: MovingObstacle) -> MovingObstacles {
    MovingObstacles::new(vec![moving])
}

/// The only obstacle after this many seconds without the robot.
fn after(moving_obstacles: &mut MovingObstacles, time_s: f64) -> MovingDisc {
    moving_obstacles.step(time_s, &AWAY, &robot());
    moving_obstacles.discs()[0]
}

fn assert_at(disc: &MovingDisc, center: [f64; 2], velocity: [f64; 2]) {
    let apart = disc.center() - Point::from(center);
    let off = Vector::new(disc.vx, disc.vy) - Vector::from(velocity);
    assert!(apart.norm() < 1e-9 && off.norm() < 1e-9, "{disc:?}");
}

/// A world with a wall from the bottom to a gap 1.2 m wide at the top, 5 m from the left.
fn two_halves() -> ObstacleGrid {
    let mut ground = ObstacleGrid::filled(FRAME, false);
    for row in 0..76 {
        ground.set(inbye::map::Cell::new(100, row), true);
    }
    ground
}

const KEYS: [(f64, [f64; 2]); 3] = [(1.0, [1.0, 1.0]), (3.0, [5.0, 1.0]), (4.0, [5.0, 2.5])];

fn scripted_by(
    radius_m: f64,
    keys: &[(f64, Point)],
    loop_s: Option<f64>,
) -> Result<MovingObstacle, SimError> {
    MovingObstacle::timed_path(radius_m, TimedPath::new(keys, loop_s)?)
}

fn scripted(loop_s: Option<f64>) -> MovingObstacle {
    let keys = KEYS.map(|(time_s, place)| (time_s, Point::from(place)));
    scripted_by(0.3, &keys, loop_s).expect("a valid script")
}

#[test]
fn timed_path_interpolates_and_stands_at_its_end() {
    let mut moving_obstacles = one(scripted(None));
    assert_at(&moving_obstacles.discs()[0], [1.0, 1.0], [0.0, 0.0]);
    assert_at(&after(&mut moving_obstacles, 0.5), [1.0, 1.0], [0.0, 0.0]);
    assert_at(&after(&mut moving_obstacles, 1.0), [2.0, 1.0], [2.0, 0.0]);
    assert_at(&after(&mut moving_obstacles, 2.0), [5.0, 1.75], [0.0, 1.5]);
    assert_at(&after(&mut moving_obstacles, 0.7), [5.0, 2.5], [0.0, 0.0]);
    assert_at(&after(&mut moving_obstacles, 50.0), [5.0, 2.5], [0.0, 0.0]);
}

#[test]
fn looping_timed_path_jumps_from_its_end_to_its_begin() {
    let mut moving_obstacles = one(scripted(Some(4.0)));
    assert_at(&after(&mut moving_obstacles, 3.9), [5.0, 2.35], [0.0, 1.5]);
    assert_at(&after(&mut moving_obstacles, 0.2), [1.0, 1.0], [0.0, 0.0]);
    assert_at(&after(&mut moving_obstacles, 1.9), [3.0, 1.0], [2.0, 0.0]);
    assert_at(&after(&mut moving_obstacles, 40.0), [3.0, 1.0], [2.0, 0.0]);
}

#[test]
fn timed_path_waits_at_its_end_for_a_longer_period() {
    let mut moving_obstacles = one(scripted(Some(6.0)));
    assert_at(&after(&mut moving_obstacles, 5.9), [5.0, 2.5], [0.0, 0.0]);
    assert_at(&after(&mut moving_obstacles, 2.1), [3.0, 1.0], [2.0, 0.0]);
}

#[test]
fn timed_path_yields_to_the_robot_only_when_set() {
    let pose = Pose::new(3.0, 1.0, 0.0);
    let smallest_gap = |moving| {
        let mut moving_obstacles = one(moving);
        let mut smallest = f64::INFINITY;
        for _ in 0..200 {
            moving_obstacles.step(0.05, &pose, &robot());
            let disc = moving_obstacles.discs()[0];
            smallest = smallest.min(robot().gap_to_disc_m(&pose, &disc.center(), disc.radius));
        }
        smallest
    };
    assert!(smallest_gap(scripted(None)) < -0.6);
    let yielding = smallest_gap(scripted(None).yielding(true));
    assert!((YIELD_GAP_M - 1e-9..YIELD_GAP_M + 0.05).contains(&yielding), "{yielding}");
}

#[test]
fn timed_path_resumes_where_it_yielded() {
    let mut moving_obstacles = one(scripted(None).yielding(true));
    moving_obstacles.step(10.0, &Pose::new(3.0, 1.0, 0.0), &robot());
    let held = moving_obstacles.discs()[0];
    assert!((1.9..2.0).contains(&held.x) && held.vx == 0.0, "{held:?}");
    let next = after(&mut moving_obstacles, 0.1);
    assert!((next.x - held.x - 0.2).abs() < 1e-9, "{next:?}");
}

fn walker() -> MovingObstacle {
    let route = vec![Point::new(2.0, 1.0), Point::new(8.0, 1.0)];
    MovingObstacle::patrol(0.3, 1.0, route).expect("a valid walk")
}

#[test]
fn spawn_at_a_time_begins_at_the_start() {
    let late = walker().spawned_by(SpawnTrigger::AtTime(2.0)).unwrap();
    let mut moving_obstacles = MovingObstacles::new(vec![late, walker()]);
    let mut seen_s = None;
    for tick in 0..60 {
        let time_s = 0.1 * f64::from(tick);
        let places = moving_obstacles.states();
        assert_eq!((places.len(), moving_obstacles.radii().len()), (2, 2));
        assert!(places[1].is_some(), "the other one is always there");
        assert_eq!(moving_obstacles.discs().len(), places.iter().flatten().count());
        if let Some(disc) = places[0] {
            let since = *seen_s.get_or_insert(time_s);
            assert!((disc.x - 2.0 - (time_s - since)).abs() < 1e-9, "{disc:?} at {time_s} s");
        }
        moving_obstacles.step(0.1, &AWAY, &robot());
    }
    let seen_s = seen_s.expect("it appeared");
    assert!((seen_s - 2.0).abs() < 1e-9, "{seen_s}");
}

#[test]
fn spawn_within_a_distance_waits_for_the_robot() {
    let hidden = walker().spawned_by(SpawnTrigger::WithinDistance(3.0)).unwrap();
    let mut moving_obstacles = one(hidden);
    moving_obstacles.step(20.0, &Pose::new(2.0, 4.1, 0.0), &robot());
    assert!(moving_obstacles.discs().is_empty());
    moving_obstacles.step(0.1, &Pose::new(2.0, 3.9, 0.0), &robot());
    assert_eq!(moving_obstacles.discs().len(), 1);
    // Once spawned it stays, wherever the robot goes.
    assert!(after(&mut moving_obstacles, 1.0).x > 2.9);
}

#[test]
fn yielding_obstacle_does_not_spawn_on_the_robot() {
    let on_top = Pose::new(2.2, 1.0, 0.0);
    let now = SpawnTrigger::AtTime(1.0);
    let mut polite = one(walker().spawned_by(now).unwrap());
    let mut rude = one(walker().yielding(false).spawned_by(now).unwrap());
    for moving_obstacles in [&mut polite, &mut rude] {
        moving_obstacles.step(5.0, &on_top, &robot());
    }
    assert!(polite.discs().is_empty());
    assert_eq!(rude.discs().len(), 1);
    polite.step(0.1, &AWAY, &robot());
    assert_eq!(polite.discs().len(), 1);
}

#[test]
fn unspawned_obstacle_has_no_gap_to_the_robot() {
    let hidden = walker().spawned_by(SpawnTrigger::AtTime(1.0)).unwrap();
    let mut moving_obstacles = one(hidden);
    let mut world = World::new(two_halves());
    let touching = Pose::new(2.0, 1.0, 0.0);
    world.moving = moving_obstacles.discs();
    assert!(world.gap_m(&robot(), &touching) > 0.0);
    moving_obstacles.step(1.0, &AWAY, &robot());
    world.moving = moving_obstacles.discs();
    assert!(world.gap_m(&robot(), &touching) < 0.0);
}

fn wanderer(seed: u64) -> MovingObstacle {
    MovingObstacle::random_waypoint(0.3, 0.7, Point::new(4.0, 3.0), 4.5, &two_halves(), seed)
        .expect("free ground")
}

#[test]
fn random_waypoints_stay_on_free_ground_near_home() {
    let world = World::new(two_halves());
    let (mut left, mut right) = (0, 0);
    for seed in 0..20 {
        let mut moving_obstacles = one(wanderer(seed));
        let mut before = moving_obstacles.discs()[0];
        let (mut highest, mut lowest) = (f64::MIN, f64::MAX);
        for _ in 0..2400 {
            let disc = after(&mut moving_obstacles, 0.05);
            let place = Pose::new(disc.x, disc.y, 0.0);
            let body = Footprint::round(disc.radius).unwrap();
            let to_wall = world.gap_to_static_m(&body, &place);
            // The map's edge is no obstacle of its grid, so a body may lean over it.
            let to_edge = disc.x.min(10.0 - disc.x).min(disc.y).min(5.0 - disc.y);
            assert!(to_wall >= -1e-9 || to_edge < 0.3, "{seed}: {disc:?}");
            let from_home = (disc.center() - Point::new(4.0, 3.0)).norm();
            assert!(from_home <= 4.5 + 1e-9, "{seed}: {disc:?}");
            let stride = (disc.center() - before.center()).norm();
            assert!(stride <= 0.7 * 0.05 + 1e-9, "{seed}: it jumped {stride} m");
            let speed = libm::hypot(disc.vx, disc.vy);
            assert!((speed - 0.7).abs() < 1e-9, "{seed}: {disc:?}");
            before = disc;
            highest = disc.y.max(highest);
            lowest = disc.y.min(lowest);
            left += u32::from(disc.x < 4.0);
            right += u32::from(disc.x > 6.0);
        }
        assert!(highest - lowest > 2.0, "{seed}: it did not move enough");
    }
    // The ground behind the wall is reachable too.
    assert!(left > 2400 && right > 2400, "{left} {right}");
}

#[test]
fn random_waypoints_change_after_waiting_for_the_robot() {
    let mut moving_obstacles = one(wanderer(3));
    let mut held_s = 0.0;
    // The robot blocks every path of the obstacle.
    for _ in 0..2000 {
        let disc = moving_obstacles.discs()[0];
        let ahead = Vector::new(disc.vx, disc.vy);
        if ahead.norm() > 0.0 && held_s == 0.0 {
            let center = disc.center() + ahead / ahead.norm() * 1.1;
            let pose = Pose::new(center.x, center.y, 0.0);
            moving_obstacles.step(0.02, &pose, &robot());
            for _ in 0..200 {
                if moving_obstacles.discs()[0].vx == 0.0 {
                    held_s += 0.02;
                } else if held_s > 0.0 {
                    assert!((2.9..3.1).contains(&held_s), "{held_s}");
                    let now = moving_obstacles.discs()[0];
                    let turned = Vector::new(now.vx, now.vy).dot(&ahead) / ahead.norm_squared();
                    assert!(turned < 0.999, "the direction did not change");
                    return;
                }
                moving_obstacles.step(0.02, &pose, &robot());
            }
        }
        moving_obstacles.step(0.02, &AWAY, &robot());
    }
    panic!("it never waited");
}

#[test]
fn random_waypoints_depend_on_the_seed_alone() {
    let json = r#"[{"x": 4, "y": 3, "radius": 0.3, "speed": 0.7, "wander_m": 4},
                   {"x": 4, "y": 3, "radius": 0.3, "speed": 0.7, "wander_m": 4}]"#;
    let run = |seed| {
        let mut moving_obstacles =
            MovingObstacles::parse(json, "people.json", &two_halves(), seed).unwrap();
        let mut seen = Vec::new();
        for tick in 0..400 {
            let pose = Pose::new(0.02 * f64::from(tick), 2.0, 0.0);
            moving_obstacles.step(0.1, &pose, &robot());
            seen.push(moving_obstacles.discs());
        }
        seen
    };
    assert_eq!(run(5), run(5));
    assert_ne!(run(5), run(6));
    assert_ne!(run(5)[399][0], run(5)[399][1], "each has its own seed");
}

#[test]
fn random_waypoints_need_free_ground() {
    let inside =
        MovingObstacle::random_waypoint(0.3, 0.7, Point::new(5.0, 1.0), 4.0, &two_halves(), 1);
    assert!(matches!(inside, Err(SimError::NoFreeSpace { .. })));
    let outside =
        MovingObstacle::random_waypoint(0.3, 0.7, Point::new(-5.0, 1.0), 4.0, &two_halves(), 1);
    assert!(matches!(outside, Err(SimError::NoFreeSpace { .. })));
}

#[test]
fn files_and_constructors_give_equal_obstacles() {
    let ground = two_halves();
    let parse = |text: &str, name: &str| MovingObstacles::parse(text, name, &ground, 1).unwrap();
    let json = r#"[{"radius": 0.3, "keyframes": [[1, 1, 1], [3, 5, 1], [4, 5, 2.5]], "loop_s": 4},
                   {"x": 2, "y": 1, "radius": 0.3, "speed": 1, "route": [[8, 1]], "appears_within_m": 3},
                   {"x": 2, "y": 1, "radius": 0.3, "speed": 1, "route": [[8, 1]], "appears_at_s": 7,
                    "yields": false}]"#;
    let toml = "[[obstacles]]\nradius = 0.3\nkeyframes = [[1.0, 1.0, 1.0], [3.0, 5.0, 1.0], [4.0, 5.0, 2.5]]\n\
                loop_s = 4.0\n\
                [[obstacles]]\nx = 2.0\ny = 1.0\nradius = 0.3\nspeed = 1.0\nroute = [[8.0, 1.0]]\n\
                appears_within_m = 3.0\n\
                [[obstacles]]\nx = 2.0\ny = 1.0\nradius = 0.3\nspeed = 1.0\nroute = [[8.0, 1.0]]\n\
                appears_at_s = 7.0\nyields = false";
    let built = MovingObstacles::new(vec![
        scripted(Some(4.0)),
        walker().spawned_by(SpawnTrigger::WithinDistance(3.0)).unwrap(),
        walker().yielding(false).spawned_by(SpawnTrigger::AtTime(7.0)).unwrap(),
    ]);
    assert_eq!(parse(json, "a.json"), built);
    assert_eq!(parse(toml, "a.toml"), built);
}

#[test]
fn constructors_reject_values_out_of_range_by_name() {
    let refusal = |moving: Result<MovingObstacle, SimError>| moving.unwrap_err().to_string();
    let place = Point::new(1.0, 1.0);
    let nowhere = Point::new(f64::NAN, 1.0);
    for (error, words) in [
        (refusal(scripted_by(0.0, &[(0.0, place)], None)), "radius is 0"),
        (refusal(scripted_by(0.3, &[(-1.0, place)], None)), "time of a keyframe is -1"),
        (
            // A path without duration has an infinite speed.
            refusal(scripted_by(0.3, &[(0.0, place), (1e-7, place)], None)),
            "time of a keyframe is 0.0000001",
        ),
        (refusal(scripted_by(0.3, &[(0.0, nowhere)], None)), "coordinate of a keyframe is NaN"),
        (refusal(scripted_by(0.3, &[(0.0, place)], Some(0.0))), "loop_s is 0"),
        (refusal(MovingObstacle::patrol(0.3, f64::INFINITY, vec![place])), "speed is inf"),
        (refusal(MovingObstacle::patrol(0.3, 1.0, Vec::new())), "number of points is 0"),
        (
            refusal(MovingObstacle::patrol(0.3, 1.0, vec![place, nowhere])),
            "point of a route is NaN",
        ),
        (
            refusal(walker().spawned_by(SpawnTrigger::WithinDistance(f64::NAN))),
            "appears_within_m is NaN",
        ),
    ] {
        assert!(error.starts_with(words), "{error}");
    }
}
