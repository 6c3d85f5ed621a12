//! Built-in scenes and their pedestrians, and files of moving obstacles.

use inbye::geometry::{Point, Pose};
use inbye::map::{Cell, FreeSpace, GridFrame, MovingDisc, ObstacleGrid, UnknownPolicy};
use inbye::robot::Footprint;
use inbye::sim::{
    MovingObstacles, PedestrianSettings, PedestrianSpawner, Scene, SimError, World, YIELD_GAP_M,
    dead_end, scenes,
};

/// Radius of the robot that must pass everywhere, metres.
const ROBOT_RADIUS_M: f64 = 0.45;

/// A pose of the robot far from all pedestrians.
const AWAY: Pose = Pose::new(-100.0, 0.0, 0.0);

fn robot(radius: f64) -> Footprint {
    Footprint::round(radius).expect("a valid disc")
}

fn ground(scene: &Scene) -> ObstacleGrid {
    scene.map.obstacles(UnknownPolicy::Blocked)
}

/// Returns a shortest path by breadth-first search over the cells that are free for a radius.
fn shortest_path(
    obstacles: &ObstacleGrid,
    radius: f64,
    from: &Point,
    to: &Point,
) -> Option<Vec<Point>> {
    let free = FreeSpace::new(obstacles, radius);
    let frame = *free.frame();
    let (start, goal) = (frame.cell_of(from)?, frame.cell_of(to)?);
    if !free.is_free(start) {
        return None;
    }
    let neighbours = |&Cell { column, row }: &Cell| {
        [(1, 0), (0, 1), (-1, 0), (0, -1)]
            .map(|(dx, dy)| Cell::new(column + dx, row + dy))
            .into_iter()
            .filter(|&cell| free.is_free(cell))
    };
    let cells = pathfinding::directed::bfs::bfs(&start, neighbours, |&cell| cell == goal)?;
    Some(cells.into_iter().map(|cell| frame.center_of(cell)).collect())
}

fn mission(scene: &Scene) -> Vec<Point> {
    shortest_path(&ground(scene), ROBOT_RADIUS_M, &scene.start.position(), &scene.goal)
        .expect("a passable scene")
}

fn spawned(scene: &Scene, spawner: &PedestrianSpawner) -> MovingObstacles {
    let ends = [scene.start.position(), scene.goal];
    spawner.spawn(&ground(scene), &mission(scene), &ends, ROBOT_RADIUS_M).expect("room for all")
}

fn gap(disc: &MovingDisc, pose: &Pose, radius: f64) -> f64 {
    libm::hypot(disc.x - pose.x, disc.y - pose.y) - disc.radius - radius
}

#[test]
fn scenes_are_passable_and_unchanged() {
    let free_cells: Vec<(&str, usize)> = scenes()
        .iter()
        .map(|scene| {
            for radius in [ROBOT_RADIUS_M, 0.6, 0.75] {
                let path =
                    shortest_path(&ground(scene), radius, &scene.start.position(), &scene.goal);
                assert!(path.is_some(), "{} for a radius of {radius} m", scene.name);
            }
            let free = scene.map.cells().iter().filter(|&&cell| cell == 0).count();
            (scene.name, free)
        })
        .collect();
    assert_eq!(free_cells, [("roadway", 123_095), ("crossing", 152_404), ("dead_end", 63_506)]);
}

#[test]
fn dead_end_blocks_the_straight_line() {
    let scene = dead_end();
    let mut obstacles = ground(&scene);
    let frame = *obstacles.frame();
    let inside = Point::new(12.0, 7.4);
    assert!(shortest_path(&obstacles, 0.1, &inside, &scene.goal).is_some());
    // The heading is closed after 8 m and has no other exit, even for the smallest robot.
    for row in 0..frame.height {
        let cell = Cell::new(160, row);
        let y = frame.center_of(cell).y;
        if (5.0..9.6).contains(&y) {
            obstacles.set(cell, true);
        }
    }
    assert!(shortest_path(&obstacles, 0.0, &inside, &scene.goal).is_none());
    assert!(
        shortest_path(&obstacles, ROBOT_RADIUS_M, &scene.start.position(), &scene.goal).is_some()
    );
}

#[test]
fn pedestrians_stay_on_free_space_away_from_path_ends() {
    for scene in scenes() {
        let world = World::new(ground(&scene));
        for seed in 0..5 {
            let spawner = PedestrianSpawner::new(scene.obstacles, seed);
            let mut moving_obstacles = spawned(&scene, &spawner);
            assert_eq!(moving_obstacles.len(), scene.obstacles);
            for _ in 0..400 {
                for disc in moving_obstacles.discs() {
                    let place = Pose::new(disc.x, disc.y, 0.0);
                    let to_wall = world.gap_to_static_m(&robot(disc.radius), &place);
                    assert!(to_wall >= -1e-9, "{} seed {seed}: {to_wall}", scene.name);
                    for end in [scene.start.position(), scene.goal] {
                        assert!((disc.center() - end).norm() > 4.9);
                    }
                    let speed = libm::hypot(disc.vx, disc.vy);
                    assert!((0.3..=0.8).contains(&(speed - 1e-12)) || speed == 0.0, "{speed}");
                }
                moving_obstacles.step(0.1, &AWAY, &robot(ROBOT_RADIUS_M));
            }
        }
    }
}

#[test]
fn walks_are_four_to_twelve_metres_and_meet_the_path() {
    for scene in scenes() {
        let path = mission(&scene);
        for seed in 0..5 {
            let mut moving_obstacles =
                spawned(&scene, &PedestrianSpawner::new(scene.obstacles, seed));
            let mut nearest = vec![f64::INFINITY; moving_obstacles.len()];
            let mut reach = vec![0.0; moving_obstacles.len()];
            let first = moving_obstacles.discs();
            for _ in 0..900 {
                for (index, disc) in moving_obstacles.discs().iter().enumerate() {
                    let to_path = path.iter().map(|point| (disc.center() - point).norm());
                    nearest[index] = to_path.fold(nearest[index], f64::min);
                    let from_first = (disc.center() - first[index].center()).norm();
                    reach[index] = from_first.max(reach[index]);
                }
                moving_obstacles.step(0.1, &AWAY, &robot(ROBOT_RADIUS_M));
            }
            assert!(nearest.iter().all(|&distance| distance < 0.1), "{nearest:?}");
            assert!(reach.iter().all(|reach| (1.5..=12.0).contains(reach)), "{reach:?}");
        }
    }
}

#[test]
fn pedestrians_depend_on_the_seed() {
    let scene = &scenes()[0];
    let run = |seed| {
        let mut moving_obstacles = spawned(scene, &PedestrianSpawner::new(4, seed));
        let mut states = Vec::new();
        for tick in 0..200 {
            let pose = Pose::new(0.1 * f64::from(tick), 4.0, 0.0);
            moving_obstacles.step(0.1, &pose, &robot(ROBOT_RADIUS_M));
            states.push(moving_obstacles.discs());
        }
        states
    };
    assert_eq!(run(5), run(5));
    assert_ne!(run(5), run(6));
}

/// Returns the smallest gap in two minutes to a robot that stands on a pedestrian's route, over many such positions.
fn smallest_gap_to_a_standing_robot(yields: bool) -> f64 {
    let mut smallest = f64::INFINITY;
    for scene in scenes() {
        for seed in 0..3 {
            let spawner =
                PedestrianSettings::default().yields(yields).spawner(scene.obstacles, seed);
            let start = spawned(&scene, &spawner);
            // The robot stands where a pedestrian walks in 5 s.
            let mut later = start.clone();
            later.step(5.0, &AWAY, &robot(ROBOT_RADIUS_M));
            for spot in later.discs() {
                let pose = Pose::new(spot.x, spot.y, 0.0);
                let mut moving_obstacles = start.clone();
                let clear = |disc: &MovingDisc| gap(disc, &pose, ROBOT_RADIUS_M) > YIELD_GAP_M;
                if !moving_obstacles.discs().iter().all(clear) {
                    continue;
                }
                for _ in 0..1200 {
                    moving_obstacles.step(0.1, &pose, &robot(ROBOT_RADIUS_M));
                    for disc in moving_obstacles.discs() {
                        smallest = smallest.min(gap(&disc, &pose, ROBOT_RADIUS_M));
                    }
                }
            }
        }
    }
    smallest
}

#[test]
fn yielding_pedestrians_never_touch_a_standing_robot() {
    let smallest = smallest_gap_to_a_standing_robot(true);
    assert!(smallest >= YIELD_GAP_M - 1e-9, "{smallest}");
    assert!(smallest < YIELD_GAP_M + 0.05, "no pedestrian came near: {smallest}");
    let careless = smallest_gap_to_a_standing_robot(false);
    assert!(careless < -0.3, "no pedestrian would have walked into the robot: {careless}");
}

const FRAME: GridFrame =
    GridFrame { width: 200, height: 100, resolution_m: 0.05, origin: Pose::new(0.0, 0.0, 0.0) };

/// Ten by five metres of free ground.
fn open_ground() -> ObstacleGrid {
    ObstacleGrid::filled(FRAME, false)
}

const ONE_WALKER: &str =
    r#"[{"x": 1.0, "y": 2.5, "radius": 0.3, "speed": 0.5, "route": [[9.0, 2.5]]}]"#;

#[test]
fn pedestrian_yields_and_reverses_after_timeout() {
    let mut moving_obstacles =
        MovingObstacles::parse(ONE_WALKER, "obstacles.json", &open_ground(), 0).unwrap();
    let pose = Pose::new(5.0, 2.5, 0.0);
    let mut held_s = 0.0;
    for _ in 0..400 {
        moving_obstacles.step(0.05, &pose, &robot(0.4));
        let disc = moving_obstacles.discs()[0];
        assert!(gap(&disc, &pose, 0.4) >= YIELD_GAP_M - 1e-9);
        if disc.vx == 0.0 {
            held_s += 0.05;
        } else if disc.vx < 0.0 {
            assert!((2.9..3.1).contains(&held_s), "held for {held_s} s");
            return;
        }
    }
    panic!("it never reversed");
}

#[test]
fn patrol_moves_back_and_forth_at_its_speed() {
    let mut moving_obstacles =
        MovingObstacles::parse(ONE_WALKER, "obstacles.json", &open_ground(), 0).unwrap();
    let mut x_after = |time_s| {
        moving_obstacles.step(time_s, &AWAY, &robot(0.4));
        moving_obstacles.discs()[0].x
    };
    assert!((x_after(4.0) - 3.0).abs() < 1e-9);
    assert!((x_after(14.0) - 8.0).abs() < 1e-9, "turned at 9 m");
    assert!((x_after(16.0) - 2.0).abs() < 1e-9, "turned at 1 m");
}

#[test]
fn json_and_toml_obstacle_files_are_equivalent() {
    let toml = "[[obstacles]]\nx = 1.0\ny = 2.5\nradius = 0.3\nspeed = 0.5\nroute = [[9.0, 2.5]]";
    assert_eq!(
        MovingObstacles::parse(ONE_WALKER, "a.json", &open_ground(), 0),
        MovingObstacles::parse(toml, "a.toml", &open_ground(), 0)
    );
}

#[test]
fn obstacle_file_errors_are_one_line_with_place() {
    let cases = [
        ("{", "a.json: not a list of moving obstacles"),
        (r#"[{"x": 1, "y": 1, "speed": 0.3}]"#, "a.json: not a list"),
        (r#"[{"x": 1, "y": 1, "radius": 0.3}]"#, "a.json: line 1: obstacle 0: speed is missing"),
        (
            r#"[{"radius": 0.3, "keyframes": [[0, 1, 1]], "speed": 1}]"#,
            "a.json: line 1: obstacle 0: keyframes and speed exclude each other",
        ),
        (
            r#"[{"x": 1, "y": 1, "radius": 0.3, "speed": 1, "loop_s": 4}]"#,
            "a.json: line 1: obstacle 0: keyframes is missing",
        ),
        (
            r#"[{"radius": 0.3, "keyframes": []}]"#,
            "a.json: line 1: obstacle 0: number of keyframes is 0",
        ),
        (
            r#"[{"radius": 0.3, "keyframes": [[0, 1, 1], [2, 3, 1], [2, 4, 1]]}]"#,
            "a.json: line 1: obstacle 0: time of a keyframe is 2",
        ),
        (
            r#"[{"radius": 0.3, "keyframes": [[0, 1, 1], [2, 3, 1]], "loop_s": 1.5}]"#,
            "a.json: line 1: obstacle 0: loop_s is 1.5",
        ),
        (
            r#"[{"radius": 0.3, "keyframes": [[0, 1, 1], [2, 3, 9]]}]"#,
            "a.json: line 1: obstacle 0: (3, 9) lies outside the map",
        ),
        (
            r#"[{"x": 1, "y": 1, "radius": 0.3, "speed": 1, "wander_m": 2, "route": []}]"#,
            "a.json: line 1: obstacle 0: wander_m and route exclude each other",
        ),
        (
            r#"[{"x": 1, "y": 1, "radius": 0.3, "speed": 0, "wander_m": 2}]"#,
            "a.json: line 1: obstacle 0: speed is 0",
        ),
        (
            r#"[{"x": 1, "y": 1, "radius": 0.3, "speed": 1, "wander_m": 0.01}]"#,
            "a.json: line 1: obstacle 0: (1, 1) has no free space",
        ),
        (
            r#"[{"x": 1, "y": 1, "radius": 0.3, "speed": 1, "appears_at_s": -1}]"#,
            "a.json: line 1: obstacle 0: appears_at_s is -1",
        ),
        (
            r#"[{"x": 1, "y": 1, "radius": 0.3, "speed": 1, "appears_at_s": 1, "appears_within_m": 2}]"#,
            "a.json: line 1: obstacle 0: appears_at_s and appears_within_m exclude each other",
        ),
        (r#"[{"x": 1, "y": 1, "radius": 0.3, "speed": 1, "colour": 3}]"#, "a.json: not a list"),
        (
            r#"[{"x": 1, "y": 1, "radius": 0.0, "speed": 1}]"#,
            "a.json: line 1: obstacle 0: radius is 0",
        ),
        (
            r#"[{"x": 1, "y": 1, "radius": 0.3, "speed": -1}]"#,
            "a.json: line 1: obstacle 0: speed is -1",
        ),
        (
            r#"[{"x": 1, "y": 1, "radius": 0.3, "speed": 1, "route": [[10.5, 1]]}]"#,
            "a.json: line 1: obstacle 0: (10.5, 1) lies outside the map",
        ),
    ];
    for (text, expected) in cases {
        let message =
            MovingObstacles::parse(text, "a.json", &open_ground(), 0).unwrap_err().to_string();
        assert!(message.starts_with(expected) && !message.contains('\n'), "{message}");
    }
    let toml = "[[obstacles]]\nx = nan\ny = 1\nradius = 0.3\nspeed = inf";
    let message =
        MovingObstacles::parse(toml, "a.toml", &open_ground(), 0).unwrap_err().to_string();
    assert!(message.starts_with("a.toml: line 5: obstacle 0: speed is inf"), "{message}");
    let toml = "[[obstacles]]\nx = nan\ny = 1.0\nradius = 0.3\nspeed = 1.0\nwho = 1";
    let message =
        MovingObstacles::parse(toml, "a.toml", &open_ground(), 0).unwrap_err().to_string();
    assert!(message.contains("who") && !message.contains('\n'), "{message}");
    let missing =
        MovingObstacles::read("no/such/file.json".as_ref(), &open_ground(), 0).unwrap_err();
    assert!(matches!(missing, SimError::UnreadableFile { .. }), "{missing}");
    let words = "no/such/file.json: cannot be read (";
    assert!(missing.to_string().starts_with(words), "{missing}");
}

/// Editors of Windows begin a text with a byte order mark.
#[test]
fn obstacle_file_may_begin_with_a_byte_order_mark() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("people.json");
    std::fs::write(&file, format!("\u{feff}{ONE_WALKER}")).unwrap();
    assert_eq!(
        MovingObstacles::read(&file, &open_ground(), 0),
        MovingObstacles::parse(ONE_WALKER, "a.json", &open_ground(), 0)
    );
}

/// The second obstacle is wrong: its key is in another line than the first one of that name.
#[test]
fn error_of_an_obstacle_names_the_line_of_its_key() {
    let toml = "[[obstacles]]\nx = 1.0\ny = 2.5\nradius = 0.3\nspeed = 0.5\n\
                [[obstacles]]\nx = 1.0\ny = 2.5\nradius = -1.0\nspeed = 0.5\n";
    let json = "[{\"x\": 1, \"y\": 2, \"radius\": 0.3, \"speed\": 1},\n\
                {\"x\": 1, \"y\": 2,\n\"radius\": 0, \"speed\": 1}]";
    let route = "[[obstacles]]\nx = 1.0\ny = 2.5\nradius = 0.3\nspeed = 0.5\nroute = [[2.0, 2.5],\n[99.0, 2.5]]\n";
    let start =
        "[[obstacles]]\nradius = 0.3\nspeed = 0.5\nx = 99.0\ny = 2.5\nroute = [[2.0, 2.5]]\n";
    let keys = "[[obstacles]]\nradius = 0.3\nkeyframes = [[1.0, 2.0, 2.5], [0.5, 2.0, 2.5]]\n";
    for (file, text, expected) in [
        ("a.toml", route, "a.toml: line 6: obstacle 0: (99, 2.5) lies outside"),
        ("a.toml", start, "a.toml: line 4: obstacle 0: (99, 2.5) lies outside"),
        ("a.toml", keys, "a.toml: line 3: obstacle 0: time of a keyframe is 0.5"),
        ("a.toml", toml, "a.toml: line 9: obstacle 1: radius is -1"),
        ("a.json", json, "a.json: line 3: obstacle 1: radius is 0"),
    ] {
        let error = MovingObstacles::parse(text, file, &open_ground(), 0).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}");
    }
}

#[test]
fn spawner_without_space_is_an_error() {
    let narrow = ObstacleGrid::filled(FRAME, true);
    let path = [Point::new(1.0, 1.0), Point::new(9.0, 1.0)];
    let spawn = |count| PedestrianSpawner::new(count, 1).spawn(&narrow, &path, &[], 0.0);
    assert!(matches!(spawn(2), Err(SimError::NoRoom { placed: 0, asked: 2, .. })));
    assert!(spawn(0).unwrap().is_empty());
}
