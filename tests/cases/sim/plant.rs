//! A simulated robot that differs from the navigator's model: drawn values, delays, slopes, dust, and legs.

use core::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use inbye::bench::wilson_interval;
use inbye::geometry::{Point, Pose, Twist, wrap_angle};
use inbye::global::Path;
use inbye::local::CpuEngine;
use inbye::map::{GridFrame, MovingDisc, ObstacleGrid, UnknownPolicy};
use inbye::navigator::Goal;
use inbye::robot::{Footprint, Limits, TrackedDrive};
use inbye::runtime::{Config, Mission, Observer, PlantKind, Robot, SimulationSettings, TickEvent};
use inbye::sim::{
    DriveDynamics, Lidar, MovingObstacle, OdometryNoise, PedestrianSettings, SimBase, Simulation,
    Surprise, World, crossing, draw_plant,
};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

const DRIVE: TrackedDrive = TrackedDrive { track_width_m: 0.5 };
const AHEAD: Twist = Twist::new(0.5, 0.0);

fn base(dynamics: DriveDynamics, pose: Pose) -> SimBase {
    let limits = Limits::default();
    SimBase::new(DRIVE, limits, dynamics, OdometryNoise::none(), pose, 1).expect("valid settings")
}

fn drive(base: &mut SimBase, command: Twist, ticks: u32) {
    for _ in 0..ticks {
        base.send(&command).expect("a finite command");
        base.step(0.1);
    }
}

#[test]
fn disagreeing_plant_is_drawn_within_its_ranges_by_the_seed() {
    let mut config = Config::default();
    assert_eq!(draw_plant(&config, 7), config.simulation, "an agreeing plant is the settings");
    config.simulation.plant = PlantKind::Disagreeing;
    let settings = config.simulation;
    let ranges = settings.plant_ranges;
    let mut totals: Vec<f64> = Vec::new();
    let mut blind = 0;
    for seed in 0..500 {
        let drawn = draw_plant(&config, seed);
        assert_eq!(drawn, draw_plant(&config, seed));
        assert!(drawn.validate().is_ok(), "seed {seed}");
        let dynamics = drawn.dynamics;
        for (value, [least, largest]) in [
            (dynamics.command_delay_s, ranges.command_delay_s),
            (drawn.sensing_delay_s, ranges.sensing_delay_s),
            (dynamics.motor_lag_s, ranges.motor_lag_s),
            (dynamics.acceleration_ratio, ranges.acceleration_ratio),
            (dynamics.braking_ratio, ranges.braking_ratio),
            (dynamics.deadband_m_s, ranges.deadband_m_s),
            (dynamics.slip.width_ratio, ranges.width_ratio),
            (dynamics.slope_rad, ranges.slope_rad),
            (drawn.lidar.range_sigma_m / settings.lidar.range_sigma_m, ranges.noise_ratio),
            (drawn.pedestrians.leg_diameter_m, ranges.leg_diameter_m),
            (drawn.map_error_m, ranges.map_error_m),
        ] {
            assert!((least - 1e-9..=largest + 1e-9).contains(&value), "{value} of {least}");
        }
        assert_eq!(
            [drawn.pedestrians.min_speed, drawn.pedestrians.max_speed],
            ranges.pedestrian_speed_m_s
        );
        assert_eq!(dynamics.slip.calibrated_width_ratio, 1.455, "the controller keeps its value");
        let lidar = &drawn.lidar;
        if lidar.blind_time_s > 0.0 {
            blind += 1;
            for (value, [least, largest]) in [
                (lidar.blind_start_s, ranges.blind_start_s),
                (lidar.blind_time_s, ranges.blind_time_s),
                (lidar.blind_width_rad, ranges.blind_width_rad),
            ] {
                assert!((least..=largest).contains(&value), "{value} of {least}");
            }
        } else {
            assert_eq!(lidar.blind_width_rad, 0.0, "seed {seed}");
        }
        totals.push(dynamics.command_delay_s + drawn.sensing_delay_s);
    }
    assert!((100..150).contains(&blind), "{blind} of 500 lidars have a blind sector");
    totals.sort_by(f64::total_cmp);
    assert!(totals[0] < 0.08 && totals[499] > 0.27, "{} to {}", totals[0], totals[499]);
}

#[test]
fn walls_of_the_world_differ_from_the_map_by_its_error() {
    let mission = Simulation::new(Mission::new(
        Arc::new(crossing().map),
        crossing().start,
        Goal::at(crossing().goal),
    ));
    let mut config = Config::default();
    let map = mission.mission.map.obstacles(config.unknown);
    assert_eq!(mission.true_obstacles(&config), map);
    config.simulation.map_error_m = 0.1;
    let world = mission.true_obstacles(&config);
    assert_ne!(world, map);
    let other = Simulation { seed: 1, ..mission.clone() };
    assert_ne!(other.true_obstacles(&config), world, "another seed is another world");
}

#[test]
fn range_with_its_ends_exchanged_is_refused() {
    let mut settings = SimulationSettings::default();
    settings.plant_ranges.braking_ratio = [1.1, 0.7];
    let error = settings.validate().expect_err("the largest is below the least").to_string();
    assert!(error.contains("[plant_ranges] braking_ratio is 0.7"), "{error}");
}

#[test]
fn braking_distance_follows_the_braking_ratio() {
    let stopping_m = |braking_ratio: f64| {
        let dynamics = DriveDynamics::ideal().braking_ratio(braking_ratio);
        let mut base = base(dynamics, Pose::default());
        drive(&mut base, Twist::new(1.0, 0.0), 30);
        let from_m = base.pose().x;
        drive(&mut base, Twist::STOP, 30);
        base.pose().x - from_m
    };
    assert!((stopping_m(1.0) - 0.5).abs() < 0.01, "{}", stopping_m(1.0));
    assert!((stopping_m(0.7) - 0.5 / 0.7).abs() < 0.01, "{}", stopping_m(0.7));
}

#[test]
fn slope_shortens_the_drive_uphill_lengthens_it_downhill_and_slides_the_base_sideways() {
    let end = |yaw: f64, slope_rad: f64| {
        let dynamics = DriveDynamics::ideal().slope_rad(slope_rad).uphill_rad(0.0);
        let mut base = base(dynamics, Pose::new(0.0, 0.0, yaw));
        drive(&mut base, AHEAD, 100);
        *base.pose()
    };
    let (level, up, down) = (end(0.0, 0.0), end(0.0, 0.1), end(core::f64::consts::PI, 0.1));
    assert!(up.x < 0.97 * level.x, "{} of {}", up.x, level.x);
    assert!(-down.x > 1.03 * level.x, "{} of {}", down.x, level.x);
    for yaw in [FRAC_PI_2, -FRAC_PI_2] {
        let across = end(yaw, 0.1);
        assert!((-0.4..-0.1).contains(&across.x), "slides by {}", across.x);
    }
}

#[test]
fn motor_stands_still_within_its_deadband() {
    let dynamics = DriveDynamics::ideal().deadband_m_s(0.02);
    let mut slow = base(dynamics, Pose::default());
    drive(&mut slow, Twist::new(0.015, 0.0), 20);
    assert_eq!(slow.pose().x, 0.0);
    drive(&mut slow, Twist::new(0.03, 0.0), 20);
    assert!(slow.pose().x > 0.05);
}

#[test]
fn blind_sector_of_the_plant_returns_nothing_for_its_time() {
    let mut config = Config::default();
    let lidar = &mut config.simulation.lidar;
    (lidar.range_max_m, lidar.dropout) = (30.0, 0.0);
    (lidar.blind_start_s, lidar.blind_time_s) = (1.0, 2.0);
    (lidar.blind_direction_rad, lidar.blind_width_rad) = (FRAC_PI_2, 1.0);
    let simulation = Simulation::new(crossing().mission(5.0));
    // Shares of the beams without a return within the sector and outside it, by time.
    let mut shares: Vec<(f64, [f64; 2])> = Vec::new();
    let mut on_tick = |event: &TickEvent<'_>| {
        let (scan, mut counts) = (&event.observation.scan, [[0.0, 0.0]; 2]);
        for (beam, range) in scan.ranges.iter().enumerate() {
            let off = wrap_angle(scan.angle(beam) - FRAC_PI_2).abs();
            let count = &mut counts[usize::from(off >= 0.5)];
            count[0] += f64::from(!range.is_finite());
            count[1] += 1.0;
        }
        shares.push((event.row.time_s, counts.map(|[none, all]| none / all)));
    };
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut on_tick };
    let engine = Box::new(CpuEngine::single_threaded());
    simulation.run(&config, engine, &mut observer).expect("a mission that can start");
    assert!(shares.len() > 40, "{} ticks", shares.len());
    for (time_s, [within, outside]) in shares {
        // The times of ticks do not add up exactly.
        if (1.05..2.95).contains(&time_s) {
            assert_eq!(within, 1.0, "{time_s} s");
        } else if !(0.95..3.05).contains(&time_s) {
            assert!(within < 0.5, "{within} at {time_s} s");
        }
        assert!(outside < 0.5, "{outside} at {time_s} s");
    }
}

/// Odometry of a base that drives for a second, tick by tick: forward position and stamp.
fn sensed(delay_s: f64, is_stamped: bool) -> Vec<(f64, f64)> {
    let mut config = Config::default();
    config.simulation.dynamics = DriveDynamics::ideal();
    config.simulation.odometry = OdometryNoise::none();
    config.simulation.sensing_delay_s = delay_s;
    config.simulation.stamps_sensing_delay = is_stamped;
    let mut base = SimBase::of(&config, Pose::default(), 1).expect("valid settings");
    let tick = |tick: u32| {
        let data = base.sense(f64::from(tick) * 0.1);
        let _ = base.drive(&AHEAD, 0.1);
        (data.odometry.pose.x, data.odometry_s)
    };
    (0..10).map(tick).collect()
}

#[test]
fn delayed_odometry_is_that_of_its_stamp() {
    let fresh = sensed(0.0, true);
    let late = sensed(0.2, true);
    for (tick, (x_m, stamp_s)) in late.iter().enumerate() {
        let then = tick.saturating_sub(2);
        assert!((x_m - fresh[then].0).abs() < 1e-9, "tick {tick}");
        assert!((stamp_s - fresh[then].1).abs() < 1e-9, "tick {tick}");
    }
    let unstamped = sensed(0.2, false);
    for (tick, (x_m, stamp_s)) in unstamped.iter().enumerate() {
        assert_eq!((*x_m, *stamp_s), (late[tick].0, fresh[tick].1));
    }
}

fn hall() -> World {
    let frame = GridFrame {
        width: 200,
        height: 200,
        resolution_m: 0.1,
        origin: Pose::new(-10.0, -10.0, 0.0),
    };
    World::new(ObstacleGrid::filled(frame, false))
}

#[test]
fn ghosts_and_mixed_pixels_occur_at_their_rates() {
    let mut world = hall();
    let disc = |x, radius| MovingDisc { x, y: 0.0, radius, vx: 0.0, vy: 0.0 };
    world.moving = vec![disc(3.0, 0.2), disc(9.0, 4.0)];
    let clean = Lidar::default().beams(3600).range_sigma_m(0.0).dropout(0.0);
    let scan = |lidar: &Lidar| {
        let mut rng = Pcg64Mcg::seed_from_u64(1);
        lidar.scan(&world, &Pose::default(), &mut rng).scan.ranges
    };
    let truth = scan(&clean);
    let dusty = scan(&clean.ghosts(0.02));
    let short = dusty.iter().zip(&truth).filter(|(one, truth)| one < truth).count();
    assert!((40..110).contains(&short), "{short} ghosts of 3600 beams");
    assert!(dusty.iter().zip(&truth).all(|(one, truth)| one <= truth));
    let mixed = scan(&clean.mixed_pixels(1.0));
    let between: Vec<f64> =
        mixed.iter().filter(|range| (3.0..4.9).contains(*range)).copied().collect();
    assert!((1..=4).contains(&between.len()), "{between:?}");
}

#[test]
fn walking_person_shows_two_legs_within_its_body() {
    let route = vec![Point::new(0.0, 0.0), Point::new(20.0, 0.0)];
    let person = MovingObstacle::patrol(0.3, 1.2, route).expect("a route");
    let mut people = inbye::sim::MovingObstacles::new(vec![
        person.clone().with_legs(0.07, 0.0).expect("legs that fit"),
    ]);
    assert!(person.with_legs(0.7, 0.0).is_err());
    let robot = Footprint::round(0.3).expect("a radius");
    let away = Pose::new(0.0, -50.0, 0.0);
    let mut before: Option<[MovingDisc; 2]> = None;
    let mut stood = [false; 2];
    for step in 0..300 {
        people.step(0.02, &away, &robot);
        let body = people.discs()[0];
        let legs = people.iter().next().and_then(MovingObstacle::legs).expect("two legs");
        // The first steps are shorter.
        if step < 30 {
            continue;
        }
        for (index, leg) in legs.iter().enumerate() {
            let apart = (leg.center() - body.center()).norm();
            assert!(apart + leg.radius <= body.radius + 1e-9, "{apart}");
            let moved = before.map_or(0.0, |before| (leg.center() - before[index].center()).norm());
            // A foot stands, or swings forward at twice the speed.
            assert!(moved <= 2.0 * 1.2 * 0.02 + 1e-6, "{moved}");
            stood[index] |= before.is_some() && moved < 1e-9;
        }
        before = Some(legs);
    }
    assert_eq!(stood, [true, true]);
}

#[test]
fn person_who_stops_brings_the_feet_together() {
    let route = vec![Point::new(0.0, 0.0), Point::new(20.0, 0.0)];
    let person = MovingObstacle::patrol(0.3, 1.2, route).expect("a route").yielding(true);
    let mut people =
        inbye::sim::MovingObstacles::new(vec![person.with_legs(0.07, 0.0).expect("legs that fit")]);
    let robot = Footprint::round(0.3).expect("a radius");
    let mut widest_m: f64 = 0.0;
    let mut last_m = 0.0;
    // The person walks up to the robot within 4 s and stands for 3 s.
    for _ in 0..275 {
        people.step(0.02, &Pose::new(5.0, 0.0, 0.0), &robot);
        let [one, other] = people.iter().next().and_then(MovingObstacle::legs).expect("two legs");
        last_m = (one.center() - other.center()).norm();
        widest_m = widest_m.max(last_m);
    }
    assert!(widest_m > 0.4 && (last_m - 0.2).abs() < 1e-9, "{widest_m} {last_m}");
}

#[test]
fn lidar_sees_legs_and_contact_is_that_of_the_body() {
    let mut world = hall();
    let disc = |y, radius| MovingDisc { x: 2.0, y, radius, vx: 0.0, vy: 0.0 };
    world.moving = vec![disc(0.0, 0.3)];
    world.seen = Some(vec![(0, disc(0.1, 0.035)), (0, disc(-0.1, 0.035))]);
    let lidar = Lidar::default().beams(3600).range_sigma_m(0.0).dropout(0.0);
    let found = lidar.scan(&world, &Pose::default(), &mut Pcg64Mcg::seed_from_u64(1));
    assert_eq!(found.visible, [0]);
    assert!(found.scan.ranges[1800] > 5.0, "the beam passes between the legs");
    let hits = found.scan.ranges.iter().filter(|&&range| range < 5.0).count();
    assert!((30..50).contains(&hits), "{hits} beams");
    let robot = Footprint::round(0.3).expect("a radius");
    let gap_m = world.gap_to_moving_m(&robot, &Pose::default());
    assert!((gap_m - 1.4).abs() < 1e-9, "{gap_m}");
}

#[test]
fn sudden_pedestrians_stand_until_the_robot_is_near() {
    let scene = crossing();
    let ground = scene.map.obstacles(UnknownPolicy::Blocked);
    let path = Path::new(vec![scene.start.position(), scene.goal]);
    let config = Config::default();
    let mut planner = config.route_planner(scene.map.frame().resolution_m);
    let plan = planner.plan(&ground, path.point_at(0.0), scene.goal, &mut || 0.0);
    let path = plan.expect("a path").smoothed;
    let settings = PedestrianSettings::default();
    let robot = Footprint::round(0.3).expect("a radius");
    for surprise in [Surprise::Start, Surprise::StepOut] {
        let mut placed = 0;
        let mut moved = 0;
        for seed in 0..8 {
            let spawner = settings.spawner(3, seed);
            let mut people =
                spawner.spawn_sudden(&ground, &path, surprise).expect("valid settings");
            assert_eq!(Ok(people.clone()), spawner.spawn_sudden(&ground, &path, surprise));
            placed += people.len();
            let start = people.discs();
            let away = Pose::new(-100.0, 0.0, 0.0);
            people.step(5.0, &away, &robot);
            assert_eq!(people.discs(), start, "they stand while the robot is far");
            let mut arc_m = 0.0;
            while arc_m < path.length_m() {
                let place = path.point_at(arc_m);
                people.step(0.1, &Pose::new(place.x, place.y, 0.0), &robot);
                arc_m += 0.1;
            }
            let ends = people.discs();
            moved += start
                .iter()
                .zip(&ends)
                .filter(|(one, other)| one.center() != other.center())
                .count();
        }
        assert!(placed >= 8, "{surprise:?}: {placed} people");
        assert!(2 * moved >= placed, "{surprise:?}: {moved} of {placed} walked");
    }
}

#[test]
fn wilson_interval_matches_published_values() {
    // R's binom::binom.wilson(0, 60), (45, 60) and (60, 60).
    for (count, expected) in [(0, [0.0, 0.0602]), (45, [0.6277, 0.8422]), (60, [0.9398, 1.0])] {
        let found = wilson_interval(count, 60);
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-4, "{count}: {found} for {expected}");
        }
    }
    assert_eq!(wilson_interval(0, 0), [0.0, 1.0]);
}
