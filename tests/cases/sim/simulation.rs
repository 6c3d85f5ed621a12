//! Simulated lidar and gaps against brute force.

use core::f64::consts::PI;

use std::sync::Arc;

use inbye::geometry::{Point, Pose};
use inbye::local::CpuEngine;
use inbye::map::{GridFrame, MovingDisc, ObstacleGrid, OccupancyGrid};
use inbye::navigator::Goal;
use inbye::robot::{Disc, Footprint, Polygon};
use inbye::runtime::{Config, Mission, Observer};
use inbye::sim::{Lidar, MovingObstacle, MovingObstacles, Simulation, TimedPath, World};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const RESOLUTION_M: f64 = 0.1;

/// A small world of scattered cells and discs, on a shifted and rotated grid.
fn random_world(rng: &mut Pcg64Mcg) -> World {
    let frame = GridFrame {
        width: rng.random_range(1..60),
        height: rng.random_range(1..60),
        resolution_m: RESOLUTION_M,
        origin: Pose::new(
            rng.random_range(-5.0..5.0),
            rng.random_range(-5.0..5.0),
            rng.random_range(-PI..PI),
        ),
    };
    let density = [0.0, 0.002, 0.02, 0.3][rng.random_range(0..4)];
    let blocked = (0..frame.len()).map(|_| rng.random_bool(density)).collect();
    let mut world = World::new(ObstacleGrid::new(frame, blocked));
    for _ in 0..rng.random_range(0..4) {
        let center = random_place(&world, rng).position();
        world.moving.push(MovingDisc {
            x: center.x,
            y: center.y,
            radius: rng.random_range(0.05..0.6),
            vx: 0.0,
            vy: 0.0,
        });
    }
    world
}

/// A pose in the world's grid or a little outside it.
fn random_place(world: &World, rng: &mut Pcg64Mcg) -> Pose {
    let frame = world.obstacles().frame();
    let along = |cells: i32, rng: &mut Pcg64Mcg| f64::from(cells) * rng.random_range(-0.05..1.05);
    let units = Point::new(along(frame.width, rng), along(frame.height, rng));
    let point = frame.from_cell_units(&units);
    Pose::new(point.x, point.y, rng.random_range(-PI..PI))
}

/// Returns the distance to the nearest solid square by a test of every cell; everything outside the grid is solid.
fn distance_by_brute_force(world: &World, point: &Point) -> f64 {
    let frame = world.obstacles().frame();
    let p = frame.to_cell_units(point);
    let (width, height) = (f64::from(frame.width), f64::from(frame.height));
    if frame.cell_of(point).is_none() {
        return 0.0;
    }
    let mut nearest = p.x.min(width - p.x).min(p.y).min(height - p.y);
    for index in (0..frame.len()).filter(|&index| world.obstacles().cells()[index]) {
        let cell = frame.cell_at(index);
        let (column, row) = (f64::from(cell.column), f64::from(cell.row));
        let touch = Point::new(p.x.clamp(column, column + 1.0), p.y.clamp(row, row + 1.0));
        nearest = nearest.min((p - touch).norm());
    }
    nearest * frame.resolution_m
}

fn is_solid(world: &World, point: &Point) -> bool {
    let cell = world.obstacles().frame().cell_of(point);
    cell.is_none_or(|cell| world.obstacles().is_blocked(cell))
}

fn quiet_lidar(beams: usize) -> Lidar {
    Lidar::default().beams(beams).range_min_m(0.0).range_max_m(4.0).range_sigma_m(0.0).dropout(0.0)
}

fn robot(radius: f64) -> Footprint {
    Footprint::round(radius).expect("a valid disc")
}

#[test]
fn gaps_equal_brute_force_over_all_cells_and_discs() {
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    for case in 0..400 {
        let world = random_world(&mut rng);
        for _ in 0..20 {
            let pose = random_place(&world, &mut rng);
            let discs: Vec<Disc> = (0..rng.random_range(1..4))
                .map(|_| Disc {
                    x: rng.random_range(-0.4..0.4),
                    y: rng.random_range(-0.4..0.4),
                    radius: rng.random_range(0.01..0.5),
                })
                .collect();
            let footprint = Footprint::new(discs).unwrap();
            let mut to_static = f64::INFINITY;
            let mut to_moving = f64::INFINITY;
            for (center, radius) in footprint.at(&pose) {
                to_static = to_static.min(distance_by_brute_force(&world, &center) - radius);
                for disc in &world.moving {
                    let centers = libm::hypot(disc.x - center.x, disc.y - center.y);
                    to_moving = to_moving.min(centers - disc.radius - radius);
                }
            }
            let found = world.gap_to_static_m(&footprint, &pose);
            assert!((found - to_static).abs() < 1e-9, "case {case}: {found} for {to_static}");
            let found = world.gap_to_moving_m(&footprint, &pose);
            assert!(
                (found - to_moving).abs() < 1e-9 || found.min(to_moving) > 1e9,
                "case {case}: {found} for {to_moving}"
            );
            let both = to_static.min(to_moving);
            assert!((world.gap_m(&footprint, &pose) - both).abs() < 1e-9);
        }
    }
}

/// A polygon with corners at random distances from the robot's origin.
fn random_body(rng: &mut Pcg64Mcg) -> Polygon {
    let count = rng.random_range(3..7);
    let corner = |index: i32| {
        let (sin, cos) = libm::sincos(2.0 * PI * f64::from(index) / f64::from(count));
        let reach = rng.random_range(0.05..0.6);
        Point::new(reach * cos, reach * sin)
    };
    Polygon::new((0..count).map(corner).collect()).expect("a polygon with an area")
}

/// The oracle samples the outline densely, and the squares for a body around one: it finds at most 3 mm too much.
#[test]
fn gap_of_a_polygon_equals_dense_samples_of_its_outline() {
    const SPACING_M: f64 = 0.004;
    let mut rng = Pcg64Mcg::seed_from_u64(4);
    let (mut touching, mut clear) = (0, 0);
    for case in 0..150 {
        let world = random_world(&mut rng);
        for _ in 0..4 {
            let pose = random_place(&world, &mut rng);
            let body = random_body(&mut rng);
            let footprint = Footprint::covering(body.clone());
            let frame = world.obstacles().frame();
            let (mut to_static, mut to_moving) = (f64::INFINITY, f64::INFINITY);
            let corners = body.corners();
            for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
                let pieces = ((to - from).norm() / SPACING_M).ceil().max(1.0);
                for piece in 0..=pieces as u32 {
                    let local = *from + (to - from) * (f64::from(piece) / pieces);
                    let point = pose.transform(&local);
                    to_static = to_static.min(distance_by_brute_force(&world, &point));
                    for disc in &world.moving {
                        let centers = libm::hypot(disc.x - point.x, disc.y - point.y);
                        to_moving = to_moving.min(centers - disc.radius);
                    }
                }
            }
            let is_inside = |point: &Point| body.contains(&pose.inverse_transform(point));
            let mut cells = (0..frame.len()).filter(|&index| world.obstacles().cells()[index]);
            if cells.any(|index| is_inside(&frame.center_of(frame.cell_at(index)))) {
                to_static = 0.0;
            }
            for disc in world.moving.iter().filter(|disc| is_inside(&disc.center())) {
                to_moving = to_moving.min(-disc.radius);
            }
            let found = world.gap_to_static_m(&footprint, &pose);
            let off = to_static - found;
            assert!(
                (-1e-9..0.003).contains(&off) || found == to_static,
                "{case}: {found}, {to_static}"
            );
            let found = world.gap_to_moving_m(&footprint, &pose);
            let off = to_moving - found;
            assert!(
                (-1e-9..0.003).contains(&off) || found == to_moving,
                "{case}: {found}, {to_moving}"
            );
            // The discs cover the body, so their gap is never larger.
            let discs = footprint.without_body();
            assert!(world.gap_m(&discs, &pose) <= world.gap_m(&footprint, &pose) + 1e-9);
            *(if to_static > 0.0 { &mut clear } else { &mut touching }) += 1;
        }
    }
    assert!(touching > 50 && clear > 50, "{touching} touching, {clear} clear");
}

/// A ray march never finds a hit before the exact one. It may step over the tip of a corner that the exact ray hits. So an
/// exact hit that is nearer must touch something.
#[test]
fn lidar_equals_dense_ray_march() {
    const STRIDE_M: f64 = 1e-3;
    let mut rng = Pcg64Mcg::seed_from_u64(5);
    let lidar = quiet_lidar(31);
    let (mut beams, mut tips) = (0, 0);
    for case in 0..150 {
        let world = random_world(&mut rng);
        let pose = random_place(&world, &mut rng);
        let found = lidar.scan(&world, &pose, &mut rng);
        let mut visible = vec![false; world.moving.len()];
        for (beam, &range) in found.scan.ranges.iter().enumerate() {
            let direction = pose.yaw + found.scan.angle(beam);
            let (sin, cos) = libm::sincos(direction);
            let at = |distance: f64| Point::new(pose.x + distance * cos, pose.y + distance * sin);
            let covering = |point: &Point| {
                world.moving.iter().position(|disc| (disc.center() - point).norm() <= disc.radius)
            };
            let steps = (lidar.range_max_m / STRIDE_M) as usize;
            let marched = (0..=steps).map(|step| step as f64 * STRIDE_M).find(|&distance| {
                is_solid(&world, &at(distance)) || covering(&at(distance)).is_some()
            });
            beams += 1;
            let marched_m = marched.unwrap_or(f64::INFINITY);
            assert!(range <= marched_m + 1e-9, "case {case} beam {beam}: {range} {marched_m}");
            if range < marched_m - STRIDE_M - 1e-9 {
                tips += 1;
                let touch = at(range);
                let to_disc = world
                    .moving
                    .iter()
                    .map(|disc| (disc.center() - touch).norm() - disc.radius)
                    .fold(f64::INFINITY, f64::min);
                let gap = distance_by_brute_force(&world, &touch).min(to_disc);
                assert!(gap < 1e-9, "case {case} beam {beam}: touches nothing at {range}");
            }
            let beyond = at(range + 1e-9);
            if range.is_finite()
                && !is_solid(&world, &beyond)
                && let Some(disc) = covering(&beyond)
            {
                visible[disc] = true;
            }
        }
        let visible: Vec<usize> = (0..visible.len()).filter(|&disc| visible[disc]).collect();
        // Where two discs cover the point, the lidar may report either of them.
        if world.moving.len() < 2 {
            assert_eq!(found.visible, visible, "case {case}");
        }
    }
    assert!(tips * 50 < beams, "{tips} of {beams} beams hit only the tip of a corner");
}

#[test]
fn lidar_sees_the_front_obstacle_only() {
    let frame =
        GridFrame { width: 100, height: 100, resolution_m: RESOLUTION_M, origin: Pose::default() };
    let mut blocked = vec![false; frame.len()];
    // A wall along x = 7.0..7.1 m from y = 0 to 6 m.
    for row in 0..60 {
        blocked[row * 100 + 70] = true;
    }
    let mut world = World::new(ObstacleGrid::new(frame, blocked));
    let disc = |x, y| MovingDisc { x, y, radius: 0.3, vx: 0.0, vy: 0.0 };
    let in_the_open = disc(4.0, 5.0);
    let behind_it = disc(5.0, 5.0);
    let behind_the_wall = disc(9.0, 2.0);
    let out_of_range = disc(2.0, 9.9);
    world.moving = vec![behind_it, in_the_open, behind_the_wall, out_of_range];
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    let seen = quiet_lidar(360).scan(&world, &Pose::new(2.0, 5.0, 0.0), &mut rng);
    assert_eq!(seen.visible, [1]);
    assert!((seen.scan.ranges[180] - 1.7).abs() < 1e-12, "straight ahead");
    assert!((seen.scan.ranges[0] - 2.0).abs() < 1e-12, "the edge of the map, behind");
}

#[test]
fn range_noise_has_configured_deviation_and_zero_draws_nothing() {
    let frame =
        GridFrame { width: 60, height: 60, resolution_m: RESOLUTION_M, origin: Pose::default() };
    let world = World::new(ObstacleGrid::filled(frame, false));
    let pose = Pose::new(3.0, 3.0, 0.3);
    let seeded = || Pcg64Mcg::seed_from_u64(9);
    let exact = quiet_lidar(20_000);
    let noisy = exact.range_sigma_m(0.02).range_max_m(10.0);
    let mut rng = seeded();
    let truth = exact.range_max_m(10.0).scan(&world, &pose, &mut rng).scan.ranges;
    assert_eq!(rng, seeded(), "a lidar without noise draws no random numbers");
    let measured = noisy.scan(&world, &pose, &mut rng).scan.ranges;
    assert_eq!(measured, noisy.scan(&world, &pose, &mut seeded()).scan.ranges);
    let errors: Vec<f64> = measured.iter().zip(&truth).map(|(m, t)| m - t).collect();
    let count = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / count;
    let spread = (errors.iter().map(|error| error * error).sum::<f64>() / count).sqrt();
    assert!(mean.abs() < 5e-4 && (spread - 0.02).abs() < 5e-4, "{mean} {spread}");
    let beyond_two = errors.iter().filter(|error| error.abs() > 0.04).count() as f64 / count;
    assert!((beyond_two - 0.0455).abs() < 0.006, "{beyond_two}");
}

/// An empty room of 6 by 6 m.
fn room() -> World {
    let frame =
        GridFrame { width: 60, height: 60, resolution_m: RESOLUTION_M, origin: Pose::default() };
    World::new(ObstacleGrid::filled(frame, false))
}

#[test]
fn dropout_omits_configured_fraction_of_beams() {
    let world = room();
    let pose = Pose::new(3.0, 3.0, 0.0);
    let mut rng = Pcg64Mcg::seed_from_u64(4);
    let whole = quiet_lidar(20_000);
    let truth = whole.scan(&world, &pose, &mut rng).scan.ranges;
    let dropping = whole.dropout(0.2);
    let seen = dropping.scan(&world, &pose, &mut rng).scan.ranges;
    let (dropped, kept): (Vec<_>, Vec<_>) =
        (seen.iter().zip(&truth)).partition(|(range, _)| range.is_nan());
    let share = dropped.len() as f64 / seen.len() as f64;
    assert!((share - 0.2).abs() < 0.01, "{share}");
    assert!(kept.iter().all(|(range, truth)| range == truth));
    let blind = whole.dropout(1.0);
    let mut world = world;
    world.moving = vec![MovingDisc { x: 4.0, y: 3.0, radius: 0.3, vx: 0.0, vy: 0.0 }];
    assert_eq!(whole.scan(&world, &pose, &mut rng).visible, [0]);
    assert!(blind.scan(&world, &pose, &mut rng).visible.is_empty());
}

#[test]
fn lidar_does_not_measure_below_shortest_range() {
    let mut world = room();
    let disc = |x| MovingDisc { x, y: 3.0, radius: 0.3, vx: 0.0, vy: 0.0 };
    world.moving = vec![disc(3.4), disc(2.0)];
    let lidar = quiet_lidar(360).range_min_m(0.2).range_sigma_m(0.05);
    let mut rng = Pcg64Mcg::seed_from_u64(4);
    let seen = lidar.scan(&world, &Pose::new(3.0, 3.0, 0.0), &mut rng);
    assert!(seen.scan.ranges[180].is_nan(), "0.1 m ahead");
    assert!((seen.scan.ranges[0] - 0.7).abs() < 0.25, "behind");
    assert_eq!(seen.visible, [0, 1], "the flanks of the near one are far");
    let measured = seen.scan.ranges.iter().filter(|range| !range.is_nan());
    assert!(measured.into_iter().all(|&range| range >= 0.2));
}

#[test]
fn partial_field_of_view_has_beams_at_both_edges() {
    let lidar = quiet_lidar(271).field_of_view_rad(1.5 * PI);
    let mut rng = Pcg64Mcg::seed_from_u64(4);
    let scan = lidar.scan(&room(), &Pose::new(3.0, 3.0, 0.0), &mut rng).scan;
    assert!((scan.angle(0) + 0.75 * PI).abs() < 1e-12);
    assert!((scan.angle(270) - 0.75 * PI).abs() < 1e-12);
    assert!((scan.ranges[135] - 3.0).abs() < 1e-12, "straight ahead");
}

#[test]
fn lidar_rejects_bad_settings_by_name() {
    let plain = Lidar::default();
    for (lidar, words) in [
        (plain.beams(0), "beams is 0"),
        (plain.range_min_m(11.0), "range_max_m is 10"),
        (plain.dropout(-0.1), "dropout is -0.1"),
    ] {
        let error = lidar.validate().unwrap_err();
        assert!(error.to_string().starts_with(words), "{error}");
    }
    assert_eq!(Lidar::default().validate(), Ok(()));
}

/// A small fast obstacle crosses right before the robot's nose between two ticks: at each tick it is 0.2 m away or more.
#[test]
fn contact_between_two_ticks_is_found() {
    let frame = GridFrame::new(100, 100, RESOLUTION_M, Pose::default()).expect("a valid size");
    let map = Arc::new(OccupancyGrid::filled(frame, 0));
    let start = Pose::new(5.0, 5.0, 0.0);
    let least_gap_m = |x: f64| {
        let keys = [(0.0, Point::new(x, 3.5)), (0.3, Point::new(x, 6.5))];
        let path = TimedPath::new(&keys, None);
        let crossing = MovingObstacle::timed_path(0.02, path.expect("a path"));
        let goal = Goal::at(Point::new(8.0, 5.0));
        let simulation = Simulation {
            moving_obstacles: MovingObstacles::new(vec![crossing.expect("an obstacle")]),
            ..Simulation::new(Mission {
                time_limit_s: 0.35,
                ..Mission::new(map.clone(), start, goal)
            })
        };
        let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
        let engine = Box::new(CpuEngine::single_threaded());
        let result = simulation.run(&Config::default(), engine, &mut observer).expect("a drive");
        (result.min_clearance_m, result.collided)
    };
    let (gap_m, collided) = least_gap_m(5.34);
    assert!(collided && gap_m <= 0.0, "{gap_m} m");
    let (gap_m, collided) = least_gap_m(5.42);
    assert!(!collided && (0.03..0.06).contains(&gap_m), "{gap_m} m");
}

#[test]
fn contact_is_a_gap_at_or_below_zero() {
    let frame =
        GridFrame { width: 20, height: 20, resolution_m: RESOLUTION_M, origin: Pose::default() };
    let world = World::new(ObstacleGrid::filled(frame, false));
    let gap = |x| world.gap_m(&robot(0.25), &Pose::new(x, 1.0, 0.0));
    assert!((gap(0.5) - 0.25).abs() < 1e-12, "the ground outside the map is solid");
    assert!(gap(0.2) < 0.0);
    assert!((gap(-3.0) + 0.25).abs() < 1e-12);
}
