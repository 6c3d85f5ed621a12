//! Late decisions, by a scripted clock: what the navigator sends, how densely it samples next, and what it counts.

use std::cell::Cell;

use inbye::geometry::{Point, Pose, Twist};
use inbye::local::{CpuEngine, Sampling};
use inbye::map::{GridFrame, ObstacleGrid, Scan};
use inbye::navigator::{COMMAND_LIFETIME_S, Goal, Mode, Navigator, Observation, Waypoints};
use inbye::runtime::{Config, MissionResult, Observer, TickEvent, TraceRow};
use inbye::sim::{Simulation, dead_end};

const DEADLINE_S: f64 = 0.05;
const LATE_S: f64 = 0.08;
const QUICK_S: f64 = 0.01;

/// Drives out of the dead end for 20 s. `took_s` is the duration of the decision at each tick, seconds.
fn drive(deadline_s: Option<f64>, took_s: impl Fn(usize) -> f64) -> MissionResult {
    let mission = Simulation { seed: 4, ..Simulation::new(dead_end().mission(20.0)) };
    let mut config = Config::default();
    config.navigator.deadline_s = deadline_s;
    let (tick, now_s) = (Cell::new(0), Cell::new(0.0));
    // The clock advances by the duration between the two readings of a tick.
    let mut clock = || {
        now_s.set(now_s.get() + took_s(tick.get()));
        now_s.get()
    };
    let mut progress = |_: &TickEvent<'_>| tick.set(tick.get() + 1);
    let mut observer = Observer { clock: &mut clock, on_tick: &mut progress };
    let engine = Box::new(CpuEngine::single_threaded());
    mission.run(&config, engine, &mut observer).expect("a mission that can start")
}

/// Bursts of slow ticks: one alone, two apart, a long one.
fn bursts(tick: usize) -> f64 {
    if matches!(tick, 20 | 40 | 45 | 60..=66) { LATE_S } else { QUICK_S }
}

fn is_late(tick: usize) -> bool {
    bursts(tick) > DEADLINE_S
}

/// Violations of the decay of late commands in a drive.
fn violations(rows: &[TraceRow]) -> Vec<String> {
    let limits = Config::default().robot.limits;
    let period_s = Config::default().local.control_period_s;
    let mut violations = Vec::new();
    let (mut last, mut share) = ((0.0, Twist::STOP), 0.0);
    for (tick, row) in rows.iter().enumerate() {
        if !is_late(tick) {
            (last, share) = ((row.time_s, row.command), 1.0);
            continue;
        }
        let (decided_s, Twist { linear, angular }) = last;
        let (v, w) = (row.command.linear, row.command.angular);
        let size = libm::hypot(linear, angular);
        let sent = libm::hypot(v, w) / size.max(1e-9);
        let by_age = (1.0 - (row.time_s - decided_s) / COMMAND_LIFETIME_S).max(0.0);
        let fallen = |speed: f64, brake: f64| (share - sent) * speed.abs() / (-brake * period_s);
        let hardest =
            fallen(linear, limits.decel_lim_x).max(fallen(angular, limits.decel_lim_theta));
        let mut check = |good: bool, what: &str| {
            if !good {
                violations.push(format!("tick {tick}: {what}, {sent} of {last:?} after {share}"));
            }
        };
        check((v * angular - w * linear).abs() < 1e-9, "another arc");
        check(hardest < 1.0 + 1e-9, "braked too hard");
        check(sent >= by_age - 1e-9, "less than for its age");
        check(sent <= share + 1e-9, "grows");
        let is_at_limit = hardest > 1.0 - 1e-9;
        check(is_at_limit || sent < by_age.min(share) + 1e-9, "more than for its age");
        share = sent;
    }
    violations
}

#[test]
fn late_ticks_send_the_decayed_command_and_lower_the_density() {
    let result = drive(Some(DEADLINE_S), bursts);
    let rows = &result.trace.rows;
    assert!(rows.len() == 200 && !result.collided);
    assert_eq!(violations(rows), Vec::<String>::new());
    let stats = result.deadline_stats.expect("there is a deadline");
    let sampling = |vx_samples, vtheta_samples| Sampling { vx_samples, vtheta_samples };
    assert_eq!((stats.decisions, stats.misses), (200, 10));
    assert_eq!(stats.lowest, sampling(8, 8));
    // From the last miss at tick 66, two levels up at 116 and 166.
    assert_eq!(stats.last, sampling(10, 20));
    let expected = |tick| match tick {
        // The second miss within ten ticks is that of tick 45.
        0..=45 => 800,
        64..=116 => 64,
        62..=63 | 117..=166 => 80,
        46..=61 | 167.. => 200,
    };
    let mut sampled = 0;
    for (tick, row) in rows.iter().enumerate().filter(|(_, row)| row.samples > 0) {
        assert_eq!(row.samples, expected(tick), "tick {tick}");
        sampled += 1;
    }
    assert!(sampled > 150, "{sampled}");
}

#[test]
fn check_finds_a_late_command_that_does_not_decay() {
    let rows = drive(Some(DEADLINE_S), bursts).trace.rows;
    let plant = |tick: usize, change: fn(&mut Twist)| {
        let mut rows = rows.clone();
        change(&mut rows[tick].command);
        violations(&rows)
    };
    let held = rows[59].command;
    assert!(held.linear > 0.3, "{held:?}");
    for tick in [20, 61, 63] {
        assert!(!plant(tick, |command| command.linear += 0.11).is_empty());
        assert!(!plant(tick, |command| command.angular += 0.01).is_empty());
        assert!(!plant(tick, |command| *command = Twist::STOP).is_empty());
    }
    let late_sent = drive(None, bursts).trace.rows;
    assert!(!violations(&late_sent).is_empty());
}

#[test]
fn clock_changes_no_bit_without_a_missed_deadline() {
    let plain = drive(None, |_| 0.0);
    assert_eq!(plain.deadline_stats, None);
    let digest = plain.trace.digest();
    assert_eq!(drive(None, bursts).trace.digest(), digest);
    let on_time = drive(Some(DEADLINE_S), |_| DEADLINE_S / 2.0);
    assert_eq!(on_time.trace.digest(), digest);
    assert_eq!(on_time.deadline_stats.map(|one| one.misses), Some(0));
    assert_ne!(drive(Some(DEADLINE_S), bursts).trace.digest(), digest);
}

#[test]
fn robot_stands_when_all_decisions_are_late() {
    let result = drive(Some(DEADLINE_S), |_| LATE_S);
    let rows = &result.trace.rows;
    assert!(rows.iter().all(|row| row.command == Twist::STOP));
    assert!(rows.last().is_some_and(|row| row.pose == dead_end().start));
    let stats = result.deadline_stats.expect("there is a deadline");
    assert_eq!(stats.misses, stats.decisions);
}

/// A navigator with a deadline of a second. It has no scan and only brakes, so that its decisions are quick.
fn braking_navigator(vx_samples: u32, vtheta_samples: u32) -> Navigator {
    let mut config = Config::default();
    config.navigator.deadline_s = Some(1.0);
    (config.local.vx_samples, config.local.vtheta_samples) = (vx_samples, vtheta_samples);
    let frame = GridFrame::new(100, 100, 0.1, Pose::default()).expect("a small map");
    let (start, goal) = (Point::new(3.0, 5.0), Point::new(7.0, 5.0));
    let known = ObstacleGrid::filled(frame, false);
    let waypoints = Waypoints { start, goals: vec![Goal::at(goal)] };
    let engine = Box::new(CpuEngine::single_threaded());
    let navigator = config.new_navigator(known, &waypoints, engine, &mut || 0.0);
    navigator.expect("a path through free space")
}

/// All that a robot measures at a time, seconds; its lidar sees nothing within range.
fn observation(time_s: f64, pose: Pose, twist: Twist) -> Observation {
    let ranges = vec![f64::INFINITY; 63];
    Observation {
        time_s,
        pose,
        pose_s: time_s,
        lost: None,
        twist,
        odometry_s: time_s,
        scan: Scan { angle_increment: 0.1, range_max: 2.0, ranges, ..Scan::default() },
        scan_s: time_s,
        scan_changed_s: time_s,
        sent: None,
    }
}

/// Lets decisions take these shares of the deadline and returns the sampling density for the next one.
fn after(navigator: &mut Navigator, shares: impl IntoIterator<Item = f64>) -> (u32, u32) {
    let scan = Scan::default();
    let observation = observation(0.0, Pose::new(3.0, 5.0, 0.0), Twist::STOP);
    let observation = Observation { scan, ..observation };
    for share in shares {
        let mut readings_s = [0.0, share].into_iter();
        navigator.step_by(&observation, &mut || readings_s.next().unwrap_or(share));
    }
    let stats = navigator.deadline_stats().expect("there is a deadline");
    (stats.last.vx_samples, stats.last.vtheta_samples)
}

#[test]
fn sampling_levels_halve_down_to_eight_by_eight() {
    let mut navigator = braking_navigator(20, 40);
    let mut seen = vec![after(&mut navigator, [])];
    for _ in 0..5 {
        seen.push(after(&mut navigator, [1.5, 1.5]));
    }
    assert_eq!(seen, [(20, 40), (10, 20), (8, 10), (8, 8), (8, 8), (8, 8)]);
    let stats = navigator.deadline_stats().expect("there is a deadline");
    assert_eq!(stats.lowest, stats.last);
    assert_eq!(after(&mut braking_navigator(3, 5), [2.0; 9]), (3, 5));
}

#[test]
fn two_misses_within_ten_decisions_lower_the_level_and_one_does_not() {
    let on_time = |count| std::iter::repeat_n(1.0, count);
    let mut navigator = braking_navigator(20, 40);
    after(&mut navigator, [1.01]);
    after(&mut navigator, on_time(9));
    assert_eq!(after(&mut navigator, [1.01]), (20, 40));
    after(&mut navigator, on_time(8));
    assert_eq!(after(&mut navigator, [1.01]), (10, 20));
    // The two misses that lowered the level no longer count.
    assert_eq!(after(&mut navigator, [1.01]), (10, 20));
    assert_eq!(after(&mut navigator, [f64::NAN]), (8, 10));
}

#[test]
fn long_slack_raises_the_level_by_one() {
    let slack: f64 = 0.25;
    let mut navigator = braking_navigator(20, 40);
    after(&mut navigator, [2.0; 4]);
    assert_eq!(after(&mut navigator, [slack; 49]), (8, 10));
    assert_eq!(after(&mut navigator, [slack.next_up()]), (8, 10));
    assert_eq!(after(&mut navigator, [slack; 49]), (8, 10));
    assert_eq!(after(&mut navigator, [0.0]), (10, 20));
    assert_eq!(after(&mut navigator, [0.1; 49]), (10, 20));
    assert_eq!(after(&mut navigator, [0.1]), (20, 40));
    assert_eq!(after(&mut navigator, [0.1; 200]), (20, 40));
    let stats = navigator.deadline_stats().expect("there is a deadline");
    assert_eq!(stats.lowest.vtheta_samples, 10);
}

/// A loop that is slower than its period keeps each command for longer. The robot must not drive to and fro at its goal.
#[test]
fn robot_of_a_slow_loop_parks() {
    for loop_s in [0.1, 0.2, 0.3] {
        let mut navigator = braking_navigator(20, 40);
        let (mut pose, mut twist, mut time_s) = (Pose::new(3.0, 5.0, 0.0), Twist::STOP, 0.0);
        loop {
            let decision = navigator.step(&observation(time_s, pose, twist));
            if decision.mode == Mode::Arrived {
                break;
            }
            twist = decision.command;
            pose = pose.after(&twist, loop_s);
            time_s += loop_s;
            assert!(time_s < 12.0, "{loop_s} s: {:?} at {pose:?}", decision.mode);
        }
        assert!((pose.x - 7.0).abs() < 0.02, "{loop_s} s: {pose:?}");
    }
}
