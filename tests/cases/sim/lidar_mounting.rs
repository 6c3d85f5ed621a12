//! A lidar off the robot's origin, turned, and with a scan rate of its own.

use core::f64::consts::PI;
use std::collections::BTreeSet;
use std::sync::Arc;

use inbye::geometry::{Point, Pose, Twist, Vector};
use inbye::local::CpuEngine;
use inbye::map::{OccupancyGrid, TimedScan, UnknownPolicy};
use inbye::navigator::Goal;
use inbye::runtime::{
    Config, Mission, Observer, PlantKind, PoseSource, Robot, SensorData, TickEvent,
};
use inbye::sim::{Episode, Lidar, Simulation, World, draw_plant, scenes};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

/// A lidar ahead of the robot's origin and to its right, that looks to the left.
const MOUNT: Pose = Pose::new(0.25, -0.1, 1.0);
const THREE_QUARTERS: f64 = 1.5 * PI;

fn quiet() -> Lidar {
    Lidar::default().range_sigma_m(0.0).dropout(0.0)
}

fn mounted(lidar: Lidar, mount: &Pose) -> Lidar {
    lidar.mount_x_m(mount.x).mount_y_m(mount.y).mount_yaw_rad(mount.yaw)
}

/// A room of 8 by 6 m with the robot at a place in it. Its walls begin at 0.5 m.
fn room(lidar: Lidar, start: Pose) -> (Simulation, Config) {
    let wall = "#".repeat(90);
    let inner = ["#".repeat(5), ".".repeat(80), "#".repeat(5)].concat();
    let walls = vec![wall; 5];
    let rows = [walls.clone(), vec![inner; 60], walls].concat();
    let map = OccupancyGrid::from_rows(&rows, 0.1, Pose::default()).expect("a map");
    let goal = Goal::at(Point::new(7.9, start.y));
    let simulation = Simulation::new(Mission::new(Arc::new(map), start, goal));
    let mut config = Config::default();
    config.simulation.lidar = lidar;
    (simulation, config)
}

/// Distance of a point to the nearest wall of the room, metres.
fn to_wall_m(place: &Point) -> f64 {
    let sides = [place.x - 0.5, 8.5 - place.x, place.y - 0.5, 6.5 - place.y];
    sides.into_iter().map(f64::abs).fold(f64::INFINITY, f64::min)
}

fn timed(sensed: SensorData) -> TimedScan {
    sensed.lidar.expect("a scan").timed(0.0).into_owned()
}

fn hits<'a>(scan: &'a TimedScan, robot: &'a Pose) -> impl Iterator<Item = Point> + 'a {
    scan.beams.iter().filter(|beam| beam.range.is_finite()).map(|beam| {
        let (sin, cos) = libm::sincos(beam.angle);
        robot.transform(&(scan.origin + Vector::new(cos, sin) * beam.range))
    })
}

#[test]
fn scan_is_that_of_the_lidar_s_place_in_the_robot_s_frame() {
    let (start, lidar) = (Pose::new(3.0, 2.0, 0.4), mounted(quiet(), &MOUNT));
    let (simulation, config) = room(lidar, start);
    let scan = timed(simulation.robot(&config).expect("valid settings").sense(0.0));
    let world = World::new(simulation.mission.map.obstacles(UnknownPolicy::Blocked));
    let place = start.transform_pose(&MOUNT);
    let own = lidar.scan(&world, &place, &mut Pcg64Mcg::seed_from_u64(0)).scan;
    assert_eq!(scan, TimedScan::from_scan(&own.from_mount(&MOUNT), 0.0, 0.0));
    assert_eq!(hits(&scan, &start).count(), 360);
    assert!(hits(&scan, &start).all(|end| to_wall_m(&end) < 1e-6));
    // From the robot's origin it would be another one.
    let centred = lidar.scan(&world, &start, &mut Pcg64Mcg::seed_from_u64(0)).scan;
    let other = TimedScan::from_scan(&centred, 0.0, 0.0);
    assert!(hits(&other, &place).any(|end| to_wall_m(&end) > 0.1));
}

#[test]
fn scan_rate_is_its_own_and_each_scan_has_its_time_and_place() {
    let start = Pose::new(1.5, 3.5, 0.0);
    for (delay_s, sweep_s) in [(0.0, 0.0), (0.12, 0.1)] {
        let lidar = mounted(quiet(), &MOUNT).scan_rate_hz(Some(7.0)).sweep_s(sweep_s);
        let (simulation, mut config) = room(lidar, start);
        config.simulation.sensing_delay_s = delay_s;
        let mut robot = simulation.robot(&config).expect("valid settings");
        let (mut stamps, mut poses) = (BTreeSet::new(), Vec::new());
        for tick in 0..40 {
            let time_s = 0.1 * f64::from(tick);
            let scan = timed(robot.sense(time_s));
            poses.push((time_s, robot.ground_truth().expect("a simulated robot").pose));
            let end_s = scan.end_s().expect("beams");
            let age_s = time_s - delay_s - end_s;
            assert!((-1e-9..1.0 / 7.0).contains(&age_s) || end_s == 0.0, "{age_s} at {time_s}");
            let number = end_s * 7.0;
            assert!((number - number.round()).abs() < 1e-6, "{end_s}");
            stamps.insert(number.round() as u32);
            // The robot's pose at the time of a beam lies between those of two ticks.
            for beam in scan.beams.iter().filter(|beam| beam.time_s >= 0.0) {
                let tick = ((beam.time_s / 0.1 + 1e-9) as usize).min(poses.len() - 1);
                let next = (tick + 1).min(poses.len() - 1);
                let share = (beam.time_s - poses[tick].0) / 0.1;
                let then = poses[tick].1.interpolate(&poses[next].1, share);
                let one = TimedScan { beams: vec![*beam], ..scan.clone() };
                assert!(hits(&one, &then).all(|end| to_wall_m(&end) < 1e-3), "{beam:?}");
            }
            let _ = robot.drive(&Twist::new(1.0, 0.3), 0.1);
        }
        // 3.9 s, less the delay; all scans are delivered once or twice.
        assert_eq!(stamps.len(), if delay_s > 0.0 { 27 } else { 28 });
    }
}

/// The layer measures from the robot's body, wherever the lidar is.
#[test]
fn protective_layer_stops_at_the_same_gap_with_any_mounting() {
    let gap_m = |lidar: Lidar| {
        let (simulation, config) = room(lidar, Pose::new(4.0, 3.5, 0.0));
        let mut episode = Episode::new(&simulation, &config).expect("valid settings");
        for _ in 0..200 {
            episode.step(&Twist::new(0.3, 0.0)).expect("a finite command");
        }
        assert!(episode.twist().stands(), "{:?}", episode.twist());
        // What an agent is shown: the range ahead is that from the lidar.
        let ranges = lidar.ranges_in_fixed_directions(episode.scan());
        assert_eq!(ranges.len(), 360);
        let ahead_m = 8.5 - episode.pose().x - lidar.mount_x_m;
        let ahead = (180.0 - lidar.mount_yaw_rad.to_degrees()).round().rem_euclid(360.0) as usize;
        assert!((ranges[ahead] - ahead_m).abs() < 0.02, "{ahead_m}: {}", ranges[ahead]);
        episode.gap_m()
    };
    let centred_m = gap_m(quiet());
    assert!((0.02..0.3).contains(&centred_m), "{centred_m}");
    for mount in [MOUNT, Pose::new(-0.25, 0.0, PI), Pose::new(0.0, 0.3, 0.0)] {
        let mounted_m = gap_m(mounted(quiet(), &mount));
        assert!((mounted_m - centred_m).abs() < 0.05, "{mount:?}: {mounted_m} m, {centred_m} m");
    }
    let slow_m = gap_m(quiet().scan_rate_hz(Some(7.0)));
    assert!((slow_m - centred_m).abs() < 0.08, "{slow_m} m, {centred_m} m");
}

/// Drives the scenes with the pose from scans; their people are there if the lidar sees ahead. A robot that does not see ahead may
/// give up. Checks what the navigator gets.
fn drive_all_scenes(lidar: Lidar, sees_ahead: bool) {
    for scene in scenes() {
        let mut config = Config::default().pose_source(PoseSource::Scans);
        config.simulation.lidar = lidar;
        let limit_s = if sees_ahead { 900.0 } else { 1500.0 };
        let mut simulation = Simulation::new(scene.mission(limit_s));
        simulation.seed = scene.seed;
        if sees_ahead {
            let spawner = config.simulation.pedestrians.spawner(scene.obstacles, scene.seed);
            let people = spawner.spawn_on_route(&simulation.mission, &config);
            simulation.moving_obstacles = people.expect("room for all");
        }
        let world = World::new(scene.map.obstacles(config.unknown));
        let dot = inbye::robot::Footprint::round(0.01).expect("a radius");
        let (mut ends, mut near_walls) = (0, 0);
        let mut on_tick = |event: &TickEvent<'_>| {
            let people: Vec<_> = event.row.moving.iter().zip(event.moving_radii).collect();
            let is_of_person = |end: &Point| {
                people.iter().any(|(center, radius_m)| {
                    center.is_some_and(|center| (center - *end).norm() < **radius_m + 0.08)
                })
            };
            for end in event.observation.scan.hits(&event.row.pose) {
                if is_of_person(&end) {
                    continue;
                }
                let gap_m = world.gap_to_static_m(&dot, &Pose::new(end.x, end.y, 0.0));
                ends += 1;
                near_walls += usize::from(gap_m < 0.08);
            }
        };
        let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut on_tick };
        let engine = Box::new(CpuEngine::single_threaded());
        let result = simulation.run(&config, engine, &mut observer).expect("a drive");
        let (name, why) = (scene.name, result.why());
        assert!(result.reached && !result.collided, "{name}: {why:?} at {} s", result.time_s);
        // What a near person hides from the lidar's place is no fault of the lidar.
        assert!(result.observation_faults.is_empty(), "{name}: {:?}", result.observation_faults);
        // The rest are beams that end between two surfaces.
        let share = near_walls as f64 / ends as f64;
        assert!(share > if sees_ahead { 0.85 } else { 0.97 }, "{name}: {share}");
        let error_m =
            |row: &inbye::runtime::TraceRow| (row.pose.position() - row.belief.position()).norm();
        let worst_m = result.trace.rows.iter().map(error_m).fold(0.0, f64::max);
        assert!(worst_m < 0.08, "{name}: {worst_m} m");
    }
}

#[test]
fn robot_with_a_lidar_ahead_of_its_origin_arrives() {
    drive_all_scenes(Lidar::default().mount_x_m(0.25), true);
}

#[test]
fn robot_with_a_lidar_at_its_corner_arrives() {
    let lidar = Lidar::default().field_of_view_rad(THREE_QUARTERS);
    drive_all_scenes(mounted(lidar, &Pose::new(0.3, 0.2, 0.25 * PI)), true);
}

#[test]
fn robot_with_a_lidar_behind_its_origin_arrives() {
    let lidar = Lidar::default().field_of_view_rad(THREE_QUARTERS);
    drive_all_scenes(mounted(lidar, &Pose::new(-0.25, 0.0, 0.0)), true);
}

/// It drives slowly where it does not see, and cannot see a person there.
#[test]
fn robot_with_a_lidar_that_looks_back_arrives() {
    let lidar = Lidar::default().field_of_view_rad(THREE_QUARTERS);
    drive_all_scenes(mounted(lidar, &Pose::new(-0.25, 0.0, PI)), false);
}

#[test]
fn robot_with_a_lidar_of_another_rate_arrives() {
    drive_all_scenes(Lidar::default().scan_rate_hz(Some(7.0)), true);
    let turning = mounted(Lidar::turning(), &MOUNT).scan_rate_hz(Some(7.0));
    drive_all_scenes(turning, true);
}

#[test]
fn fixed_directions_are_those_of_the_lidar() {
    let lidar = quiet().beams(181).field_of_view_rad(THREE_QUARTERS);
    let ranges = |lidar: Lidar| {
        let (simulation, config) = room(lidar, Pose::new(4.5, 3.5, 0.0));
        let episode = Episode::new(&simulation, &config).expect("valid settings");
        lidar.ranges_in_fixed_directions(episode.scan())
    };
    // The middle beam looks back.
    let rear = mounted(lidar, &Pose::new(-0.25, 0.0, PI));
    for (lidar, middle_m) in [(lidar, 4.0), (rear, 3.75)] {
        let seen = ranges(lidar);
        assert!((seen[90] - middle_m).abs() < 0.01, "{seen:?}");
        assert!(seen.iter().all(|range| range.is_finite()), "{seen:?}");
    }
}

#[test]
fn revolution_fits_into_the_time_between_two_scans() {
    let lidar = Lidar::turning().scan_rate_hz(Some(20.0));
    let error = lidar.validate().expect_err("0.1 s are longer than 0.05 s").to_string();
    assert!(error.contains("sweep_s is 0.1: it must be at most 1 / scan_rate_hz, 0.05"), "{error}");
    assert!(lidar.sweep_s(0.05).validate().is_ok());
    assert!(Lidar::default().scan_rate_hz(Some(0.0)).validate().is_err());
}

/// A range of a file is refused; the default one is cut, since a lidar of 5 Hz is no mistake.
#[test]
fn scans_of_a_drawn_plant_are_fresh_until_the_next_one() {
    let mut config = Config::default();
    config.simulation.plant = PlantKind::Disagreeing;
    config.simulation.lidar = Lidar::default().scan_rate_hz(Some(5.0));
    assert_eq!(config.validate(), Ok(()));
    let delays_s: Vec<f64> =
        (0..50).map(|seed| draw_plant(&config, seed).sensing_delay_s).collect();
    assert!(delays_s.iter().all(|delay_s| (0.03..=0.1).contains(delay_s)), "{delays_s:?}");
    assert!(delays_s.iter().any(|delay_s| *delay_s > 0.09), "{delays_s:?}");
    config.simulation.plant_ranges.sensing_delay_s = [0.0, 0.1];
    assert_eq!(config.validate(), Ok(()));
    config.simulation.plant_ranges.sensing_delay_s = [0.0, 0.12];
    let error = config.validate().expect_err("0.12 s and 0.2 s").to_string();
    let place = "[simulation.plant_ranges] sensing_delay_s is 0.12: it must be at most";
    assert!(error.starts_with(place) && error.ends_with(", 0.1"), "{error}");
}

#[test]
fn scan_is_fresh_until_the_next_one() {
    let mut config = Config::default();
    config.simulation.lidar = Lidar::default().scan_rate_hz(Some(5.0));
    config.simulation.sensing_delay_s = 0.1;
    assert_eq!(config.validate(), Ok(()));
    config.simulation.sensing_delay_s = 0.15;
    let error = config.validate().expect_err("0.15 s and 0.2 s").to_string();
    assert!(
        error.starts_with("[simulation] sensing_delay_s is 0.15: it must be at most"),
        "{error}"
    );
    assert!(error.ends_with(", 0.1"), "{error}");
    config.navigator.scan_timeout_s = 0.5;
    assert!(config.validate().is_err(), "the layer's");
    let expected = "it must be at least 1 / scan_rate_hz in [simulation.lidar] plus sensing_delay_s in [simulation], 0.35";
    for (navigator_s, layer_s, place) in [
        (0.1, 0.1, "[navigator] scan_timeout_s is 0.1"),
        (0.5, 0.1, "[collision_monitor] source_timeout is 0.1"),
    ] {
        (config.navigator.scan_timeout_s, config.collision_monitor.source_timeout) =
            (navigator_s, layer_s);
        let error = config.validate().expect_err("no delay is possible").to_string();
        assert_eq!(error, format!("{place}: {expected}"));
    }
    (config.navigator.scan_timeout_s, config.collision_monitor.source_timeout) = (0.5, 0.3);
    config.collision_monitor.source_timeout = 0.5;
    assert_eq!(config.validate(), Ok(()));
    config = Config::default();
    config.local.control_period_s = 0.31;
    let error = config.validate().expect_err("the sender's time").to_string();
    assert!(error.contains("control_period_s is 0.31: it must be at most 0.3"), "{error}");
}

/// One of a hundred beams returns from dust.
#[test]
fn robot_drives_through_dust() {
    let roadway = scenes().into_iter().find(|scene| scene.name == "roadway");
    let mut simulation = Simulation::new(roadway.expect("a scene").mission(400.0));
    simulation.seed = 1;
    let mut config = Config::default();
    config.simulation.lidar.ghosts = 0.01;
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
    let engine = Box::new(CpuEngine::single_threaded());
    let result = simulation.run(&config, engine, &mut observer).expect("a drive");
    assert!(result.reached, "{:?} at {} s", result.why(), result.time_s);
}
