//! Input of the program: problems, settings, words.

use std::sync::Arc;

use inbye::base::{BaseConfig, InjectedFault, Protocol, ScheduledFault};
use inbye::experiment::Plan;
use inbye::experiment::barn::barn_config;
use inbye::geometry::{Point, Pose};
use inbye::local::{CpuEngine, Detail, Engine, EngineChoice, Evaluation, QuantizedProblem};
use inbye::map::{MapError, OccupancyGrid, UnknownPolicy};
use inbye::navigator::Goal;
use inbye::runtime::{Config, Mission, Observer, parse_toml};
use inbye::sim::{MovingObstacles, Simulation};

use super::program::problem_file;
use super::wire;
use super::{one_line, room};

/// Problems with more samples times steps are quantized and not evaluated, to save time.
const MOST_WORK: usize = 20_000;

/// A problem of `inbye evaluate`. One that is read is quantized or rejected, and its command is one of its samples.
pub fn problem_json(data: &[u8]) {
    let Ok(text) = str::from_utf8(data) else {
        return;
    };
    // A random name opens no file.
    let load = |name: &str, resolution_m: f64| match name {
        "" => Err(MapError::Empty.into()),
        _ => Ok(OccupancyGrid::from_text("....\n.##.\n....\n", resolution_m)?),
    };
    let problem = match problem_file::parse(text, load) {
        Ok((problem, _)) => problem,
        Err(error) => return one_line(&format!("{error:#}")),
    };
    let quantized = match QuantizedProblem::new(&problem) {
        Ok(quantized) => quantized,
        Err(error) => return one_line(&error),
    };
    assert!(!quantized.is_empty());
    assert_eq!(quantized.len(), problem.window.len());
    if quantized.len() * problem.steps as usize <= MOST_WORK {
        let evaluated = evaluate(&quantized);
        let counts = &evaluated.counts;
        let rejected = counts.collision + counts.cannot_stop + counts.outside;
        assert_eq!((counts.admissible + rejected) as usize, quantized.len());
        assert_eq!(evaluated.winner.is_some(), counts.admissible > 0);
        if let Some(winner) = evaluated.winner {
            let command = problem.window.twist(winner.index);
            let (v, omega) = (&problem.window.vx, &problem.window.vtheta);
            let (fastest, sharpest) = (v.max_abs(), omega.max_abs());
            assert!(command.linear.abs() <= fastest, "{command:?}");
            assert!(command.angular.abs() <= sharpest, "{command:?}");
        }
    }
}

fn evaluate(quantized: &QuantizedProblem) -> Evaluation {
    thread_local! {
        static ENGINE: std::cell::RefCell<CpuEngine> = CpuEngine::single_threaded().into();
    }
    let evaluated = ENGINE.with_borrow_mut(|engine| engine.evaluate(quantized, Detail::Samples));
    evaluated.expect("the CPU answers")
}

/// A configuration of `--config`, and of a benchmark. A configuration that is read is valid, and the same when it is written
/// and read again; keys that the text does not name keep their values.
pub fn drive_config(data: &[u8]) {
    let Ok(text) = str::from_utf8(data) else {
        return;
    };
    for ours in [Config::default(), barn_config(2.0)] {
        match parse_toml(text, &ours, Config::validate) {
            Err(error) => one_line(&format!("{error:#}")),
            Ok(config) => {
                config.validate().expect("it was just checked");
                let written = toml::to_string(&config).expect("a configuration is a table");
                let again = parse_toml(&written, &ours, Config::validate);
                assert_eq!(again.expect("what is written is sound"), config);
                let table = |config: &Config| toml::Table::try_from(config).expect("a table");
                let named = toml::from_str(text).expect("it was just read");
                unnamed_stay(&table(&ours), &named, &table(&config));
            }
        }
    }
}

/// Checks that keys that a text does not name have the values of `ours`.
fn unnamed_stay(ours: &toml::Table, named: &toml::Table, read: &toml::Table) {
    for (name, value) in ours {
        match (value, named.get(name), read.get(name)) {
            (_, None, read) => assert_eq!(read, Some(value), "{name}"),
            (toml::Value::Table(ours), Some(toml::Value::Table(named)), Some(read)) => {
                // Another choice has other keys.
                let read = read.as_table().expect("a table stays one");
                if ours.keys().all(|key| read.contains_key(key)) {
                    unnamed_stay(ours, named, read);
                }
            }
            _ => {}
        }
    }
}

/// A file of `--base-config`. Settings that are read are valid, and the same when they are written and read again. A base with
/// these settings gets commands within its limits in every protocol.
pub fn base_config(data: &[u8]) {
    let Ok(text) = str::from_utf8(data) else {
        return;
    };
    match parse_toml(text, &BaseConfig::default(), BaseConfig::validate) {
        Err(error) => one_line(&format!("{error:#}")),
        Ok(file) => {
            let written = toml::to_string(&file).expect("settings are a table");
            let again = parse_toml(&written, &BaseConfig::default(), BaseConfig::validate);
            assert_eq!(again.expect("what is written is sound"), file);
            wire::short_conversations(file.base);
        }
    }
}

/// Nav2 parameter files. The imported settings are valid, and each parameter is in exactly one list.
pub fn nav2_params(data: &[u8]) {
    let Ok(text) = str::from_utf8(data) else {
        return;
    };
    for namespace in [None, Some("robot")] {
        match inbye::ros::nav2::import(text, namespace) {
            Err(error) => one_line(&error),
            Ok(import) => {
                let read = toml::from_str::<Config>(&import.config).expect("settings are TOML");
                read.validate().expect("valid settings");
                let base = toml::from_str::<BaseConfig>(&import.base_config).expect("TOML");
                base.validate().expect("valid settings");
                let mapped = import.mapped.iter().map(|mapped| &mapped.parameter);
                let unmapped = import.unmapped.iter().map(|unmapped| &unmapped.parameter);
                let mut keys: Vec<&String> = mapped.chain(unmapped).collect();
                let all = keys.len();
                keys.sort();
                keys.dedup();
                assert_eq!(keys.len(), all, "a parameter in two lists");
            }
        }
    }
}

/// Words of the command line: scheduled faults, protocols, engines.
pub fn words(data: &[u8]) {
    let Ok(text) = str::from_utf8(data) else {
        return;
    };
    match text.parse::<ScheduledFault>() {
        Err(error) => one_line(&error),
        Ok(planned) => {
            let ScheduledFault { fault, from_s, to_s } = planned;
            assert!(InjectedFault::ALL.contains(&fault));
            assert!(from_s.is_finite() && from_s >= 0.0 && to_s > from_s, "{planned:?}");
            let written = if to_s.is_finite() {
                format!("{fault}@{from_s}..{to_s}")
            } else {
                format!("{fault}@{from_s}")
            };
            assert_eq!(written.parse(), Ok(planned), "{written}");
        }
    }
    match text.parse::<Protocol>() {
        Err(error) => one_line(&error),
        Ok(protocol) => assert_eq!(protocol.name(), text),
    }
    if let Err(error) = text.parse::<EngineChoice>() {
        one_line(&error);
    }
}

/// Largest number of beams and longest control period of a drive, seconds: others take too long.
const MOST_BEAMS: usize = 1000;
const LONGEST_PERIOD_S: f64 = 2.0;

/// A configuration of `--config` with which a robot drives for a few ticks. With valid settings it does not panic, its pose is
/// finite, and its commands are within its limits.
pub fn short_drive(data: &[u8]) {
    let text = str::from_utf8(data).unwrap_or_default();
    let Ok(config) = parse_toml(text, &Config::default(), Config::validate) else {
        return;
    };
    let local = &config.local;
    let samples = local.vx_samples as usize * local.vtheta_samples as usize;
    let is_much = samples * local.steps() as usize > MOST_WORK
        || config.simulation.lidar.beams > MOST_BEAMS
        || local.control_period_s > LONGEST_PERIOD_S;
    if is_much {
        return;
    }
    let goal = Goal { position: Point::new(4.5, 3.0), yaw: Some(1.0) };
    let start = Pose::new(1.0, 1.0, 0.0);
    let mut mission = Mission::new(Arc::new(room().clone()), start, goal);
    mission.time_limit_s = 6.0 * local.control_period_s;
    let people = r#"[{"x": 2, "y": 2, "radius": 0.2, "speed": 0.5, "route": [[4, 2]]}]"#;
    let ground = room().obstacles(UnknownPolicy::Blocked);
    let people = MovingObstacles::parse(people, "people.json", &ground, 1);
    let simulation =
        Simulation { moving_obstacles: people.expect("a pedestrian"), ..Simulation::new(mission) };
    let engine = Box::new(CpuEngine::single_threaded());
    let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
    match simulation.run(&config, engine, &mut observer) {
        Err(error) => one_line(&error),
        Ok(result) => {
            let limits = &config.robot.limits;
            let fastest = limits.max_vel_x.abs().max(limits.min_vel_x.abs());
            for row in &result.trace.rows {
                assert!(row.pose.is_finite(), "{row:?}");
                let command = &row.command;
                assert!(command.is_finite(), "{row:?}");
                assert!(command.linear.abs() <= fastest, "{row:?}");
                assert!(command.angular.abs() <= limits.max_vel_theta, "{row:?}");
            }
        }
    }
}

/// A plan of `inbye sweep`. A plan that is read is valid, and the same when it is written and read again.
pub fn sweep_plan(data: &[u8]) {
    let Ok(text) = str::from_utf8(data) else {
        return;
    };
    match parse_toml(text, &Plan::default(), Plan::check) {
        Err(error) => one_line(&format!("{error:#}")),
        Ok(plan) => {
            assert!(!plan.seeds.is_empty() && !plan.worlds.is_empty());
            let text = |plan: &Plan| toml::to_string(plan).expect("a plan is a table");
            let again: Plan = toml::from_str(&text(&plan)).expect("what is written is a plan");
            assert_eq!(text(&again), text(&plan));
        }
    }
}
