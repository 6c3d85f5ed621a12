//! Random missions: a seed determines them, they can be solved, and every engine gives the same traces.

use std::sync::Arc;

use inbye::experiment::missions::{MissionSite, Rules};
use inbye::experiment::{
    ABLATION_VARIANTS, ExperimentError, Grid, RunOutcome, RunRow, Setup, SoakSummary, TrafficKind,
    World, WorldKind, ablation_groups, compare_digests, groups, run_cell, sampling_setups,
    spread_evenly,
};
use inbye::global::Searcher;
use inbye::local::{CpuEngine, Engine, EngineError, Failover, InstructionSet, Sampler};
use inbye::map::FreeSpace;
use inbye::robot::Footprint;
use inbye::runtime::{Config, Observer, PlantKind};
use inbye::sim::{crossing, draw_plant, roadway};

use crate::support::changed_engine::ChangedEngine;

fn site(config: &Config) -> MissionSite {
    MissionSite::new("crossing", crossing().map, config)
}

/// Missions short enough for a test.
fn short() -> Rules {
    Rules { longest_m: 9.0, ..Rules::default() }
}

#[test]
fn a_mission_belongs_to_its_seed() {
    let config = Config::default();
    let site = site(&config);
    let rules = Rules { unmapped_share: 0.5, ..Rules::default() };
    let draw = |seed| {
        let drawn = site.generate(seed, &rules, &config).expect("there is room");
        let simulation = drawn.simulation;
        let mission = simulation.mission;
        let goal = (mission.goal.position, mission.goal.yaw);
        (
            (mission.start, goal, drawn.path_m, drawn.traffic),
            (simulation.moving_obstacles, simulation.truth, drawn.unmapped),
        )
    };
    let mut kinds = Vec::new();
    for seed in 1..=40 {
        let first = draw(seed);
        assert_eq!(first, draw(seed), "seed {seed}");
        assert_ne!(first.0, draw(seed + 100).0, "seed {seed}");
        kinds.extend(first.0.3);
    }
    for kind in [
        TrafficKind::Yielding,
        TrafficKind::NonYielding,
        TrafficKind::Appearing,
        TrafficKind::Starting,
        TrafficKind::SteppingOut,
    ] {
        assert!(kinds.contains(&kind), "{kind:?} in {kinds:?}");
    }
}

#[test]
fn ends_are_free_and_connected_and_the_rules_kept() {
    let config = Config::default();
    let sites = [site(&config), MissionSite::new("roadway", roadway().map, &config)];
    let rules = Rules { unmapped_share: 1.0, ..Rules::default() };
    let mut searcher = Searcher::default();
    let mut stood = 0;
    for (seed, site) in (1..=12).flat_map(|seed| sites.iter().map(move |site| (seed, site))) {
        let drawn = site.generate(seed, &rules, &config).expect("there is room");
        let simulation = &drawn.simulation;
        let mission = &simulation.mission;
        let frame = site.map.frame();
        let ends = [mission.start.position(), mission.goal.position];
        let [start, goal] = ends.map(|end| frame.cell_of(&end).expect("on the map"));
        assert!(mission.goal.yaw.is_some());
        assert!((ends[1] - ends[0]).norm() >= rules.min_m);
        assert!((rules.min_m..=rules.longest_m).contains(&drawn.path_m.unwrap_or_default()));
        // The circle that the robot turns in fits at both ends, and the search finds a path.
        let radius_m = config.robot.footprint.circumscribed_radius_m();
        let space = FreeSpace::new(&site.obstacles, radius_m);
        assert!(space.is_free(start) && space.is_free(goal), "seed {seed}");
        assert!(searcher.jump_points(&space, start, goal).is_ok());
        assert!(simulation.moving_obstacles.len() <= rules.max_people);
        if let Some(truth) = &simulation.truth {
            stood += drawn.unmapped;
            let blocked = |cells: &[bool]| cells.iter().filter(|&&cell| cell).count();
            assert!(blocked(truth.cells()) > blocked(site.obstacles.cells()));
            // The obstacles on the path leave a path, and the ends stay free.
            let space = FreeSpace::new(truth, radius_m);
            assert!(searcher.jump_points(&space, start, goal).is_ok());
        }
    }
    assert!(stood >= 12, "{stood} unmapped things on 24 missions");
}

#[test]
fn ground_without_room_and_rules_out_of_range_are_refused() {
    let mut config = Config::default();
    let rules = short();
    config.robot.footprint = Footprint::round(3.0).expect("a sound radius");
    let error = site(&config).generate(1, &rules, &config).expect_err("no room");
    assert!(error.to_string().contains("crossing: no two free places"));
    let bad = Rules { unmapped_share: 1.5, ..rules };
    let error = site(&config).generate(1, &bad, &config).expect_err("a bad rule");
    assert!(error.to_string().contains("unmapped_share is 1.5"), "{error}");
}

#[test]
fn flipped_bit_changes_the_trace_digest() {
    let config = Config::default();
    let world = World::missions("crossing", Arc::new(crossing().map), short());
    let run = |engine: Box<dyn Engine>| -> RunRow {
        let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
        let run = world.drive(3, &config, engine, &mut observer);
        run.expect("a sound mission").row
    };
    let row = run(Box::new(CpuEngine::single_threaded()));
    let scalar = CpuEngine::with_instruction_set(InstructionSet::Scalar, 1).expect("always there");
    let mut decisions = 0;
    let flipped = ChangedEngine::new(move |_, answer| {
        if let Some(winner) = &mut answer.winner {
            winner.index ^= u32::from(decisions == 12);
            decisions += 1;
        }
    });
    let again = [run(Box::new(scalar)), run(Box::new(flipped))];
    let rows = [row];
    let compared = compare_digests(&rows, &again);
    let equal: Vec<bool> = compared.iter().map(|one| one.equal).collect();
    assert_eq!(equal, [true, false], "{compared:?}");
    let summary = SoakSummary::of(&rows, &compared);
    assert_eq!((summary.digests_compared, summary.digests_equal), (2, 1));
    assert!(!summary.is_sound());
    assert!(rows[0].reason.is_some() || SoakSummary::of(&rows, &compared[..1]).is_sound());
}

#[test]
fn row_of_a_disagreeing_plant_holds_what_was_drawn() {
    let mut config = Config::default();
    let world = World::missions("crossing", Arc::new(crossing().map), short());
    let run = |config: &Config| {
        let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
        let engine = Box::new(CpuEngine::single_threaded());
        let run = world.drive(5, config, engine, &mut observer);
        run.expect("a sound mission").row
    };
    let agreeing = run(&config);
    assert_eq!((agreeing.plant, agreeing.braking_ratio), (Some(PlantKind::Agreeing), None));
    config.simulation.plant = PlantKind::Disagreeing;
    let row = run(&config);
    assert_eq!(row, run(&config));
    let drawn = draw_plant(&config, 5);
    assert_eq!(row.command_delay_s, Some(drawn.dynamics.command_delay_s));
    assert_eq!(row.sensing_delay_s, Some(drawn.sensing_delay_s));
    assert_eq!(row.braking_ratio, Some(drawn.dynamics.braking_ratio));
    assert_eq!(row.leg_diameter_m, Some(drawn.pedestrians.leg_diameter_m));
    assert!(row.protected_ticks.is_some(), "{row:?}");
    // The drawn settings drive the same mission again: the row suffices to repeat it.
    config.simulation = drawn;
    let replay = run(&config);
    assert_eq!(replay.trace_digest, row.trace_digest);
    let summary = SoakSummary::of(&[row, agreeing], &[]);
    let plants: Vec<&str> = summary.plants.iter().map(|group| group.name.as_str()).collect();
    assert_eq!(plants, ["agreeing plant", "disagreeing plant"]);
    assert_eq!((summary.contacts_robot.count, summary.contacts_robot.of), (0, 2));
    let [low, high] = summary.contacts_robot.interval_95;
    assert!(low == 0.0 && (0.6..0.7).contains(&high), "{low} to {high}");
}

#[test]
fn summary_has_the_identified_response_and_the_protected_ticks() {
    let row = |delay_s: Option<f64>, high_s: f64, protected: u64| RunRow {
        command_delay_s: Some(0.1),
        identified_delay_s: delay_s,
        identified_delay_high_s: delay_s.map(|_| high_s),
        identified_braking_m_s2: delay_s.map(|delay_s| 10.0 * delay_s),
        protected_ticks: Some(protected),
        ticks: 100,
        ..RunRow::default()
    };
    let rows = [row(Some(0.1), 0.12, 0), row(Some(0.06), 0.08, 30), row(None, 0.0, 15)];
    let summary = SoakSummary::of(&rows, &[]);
    let identified = summary.identified.expect("two drives");
    assert_eq!((identified.missions, identified.underestimated_delays), (2, 1));
    let delay_s = identified.delay_s;
    assert_eq!((delay_s.least, delay_s.mean, delay_s.largest), (0.06, 0.08, 0.1));
    assert!((identified.braking_m_s2.mean - 0.8).abs() < 1e-12);
    assert_eq!(identified.turn_ratio, None);
    assert_eq!((summary.protected_missions, summary.protected_share), (2, 0.15));
    assert_eq!(SoakSummary::of(&rows[2..], &[]).identified, None);
}

#[test]
fn missions_of_a_grid_take_turns_on_the_maps() {
    let worlds = ["one", "two"].map(|name| {
        let map = Arc::new(crossing().map);
        World::missions(name, map, short())
    });
    let setups = ["a", "b"].map(|name| Setup::named(name, Config::default()));
    let grid = Grid::of_missions("turns", &worlds, &setups, 3, 7).expect("a sound grid");
    let cells = grid.cells.iter().map(|cell| {
        let id = &cell.row;
        (id.world.as_str(), id.seed, id.config.as_deref())
    });
    let expected = [("one", 7), ("two", 8), ("one", 9)];
    let expected = expected.map(|(world, seed)| ["a", "b"].map(|name| (world, seed, Some(name))));
    assert_eq!(cells.collect::<Vec<_>>(), expected.concat());
    // The setups differ only in their names, which have no effect.
    assert_eq!(grid.cells[0].row.key, grid.cells[1].row.key);
    assert_eq!(grid.distinct().len(), 3);
    // The ticks of a built-in experiment are timed; the rest does not depend on the clock.
    let mut now = 0.0;
    let mut clock = || {
        now += 0.001;
        now
    };
    let engine = || Box::new(CpuEngine::single_threaded());
    let timed = run_cell(&grid.cells[0], engine(), &mut clock, "a machine");
    let timed = timed.expect("the CPU does not fail").row;
    let untimed = run_cell(&grid.cells[0], engine(), &mut || 0.0, "");
    let untimed = untimed.expect("the CPU does not fail").row;
    assert!(timed.tick_p50_ms > Some(0.0) && timed.machine.is_none());
    assert_eq!(timed.without_clock(), untimed.without_clock());
    // Times of the CPU must not stand for those of a GPU that is lost or missing.
    let open = || Err(EngineError::NoAdapter);
    let no_gpu = Failover::new(open(), open, CpuEngine::single_threaded());
    let failed = run_cell(&grid.cells[0], Box::new(no_gpu), &mut || 0.0, "");
    let Err(ExperimentError::GpuFailed { on_cpu, decisions, reason }) = failed else {
        panic!("{failed:?}");
    };
    assert!(on_cpu > 0 && on_cpu == decisions && reason.contains("no GPU adapter"), "{reason}");
    let mut impure = setups[0].clone();
    impure.config.navigator.deadline_s = Some(0.1);
    let error = Grid::of_missions("", &worlds, &[impure], 1, 1).expect_err("a deadline");
    assert!(error.to_string().contains("wall clock"), "{error}");
}

/// Returns a hand-made row.
fn row(config: &str, seed: u64, outcome: RunOutcome, time_s: f64) -> RunRow {
    RunRow {
        kind: WorldKind::Missions,
        world: "somewhere".to_owned(),
        config: Some(config.to_owned()),
        engine: "cpu".to_owned(),
        seed,
        outcome,
        time_s,
        reason: (outcome != RunOutcome::Reached).then(|| "why".to_owned()),
        tick_p50_ms: Some(seed as f64),
        ..RunRow::default()
    }
}

#[test]
fn times_are_compared_over_shared_successes() {
    let [first, second, third] = [0, 1, 2].map(|index: usize| ABLATION_VARIANTS[index].name);
    let rows = [
        row(first, 1, RunOutcome::Reached, 30.0),
        row(first, 2, RunOutcome::Failed, 90.0),
        row(second, 1, RunOutcome::Reached, 20.0),
        row(second, 2, RunOutcome::Reached, 50.0),
        row(third, 1, RunOutcome::Timeout, 99.0),
    ];
    let table = ablation_groups(&rows);
    // A variant without a success does not reduce the shared missions.
    let figures = |row: usize| (table[row].mean_time_s, table[row].mean_shared_time_s);
    assert_eq!(figures(0), (Some(30.0), Some(30.0)));
    assert_eq!(figures(1), (Some(35.0), Some(20.0)));
    assert_eq!(figures(2), (None, None));
    assert_eq!((table[0].shared, table[0].failed), (1, 1));
    assert_eq!(table[0].name, ABLATION_VARIANTS[0].title);
}

#[test]
fn closed_loop_times_are_relative_to_the_densest_sampling() {
    let setups = sampling_setups(
        &Config::default(),
        &[4, 16, 64],
        &[(Sampler::Arcs, 1.0), (Sampler::Arcs, 0.25)],
    );
    let samplings = setups.iter().map(|setup| {
        let local = &setup.config.local;
        (local.vx_samples, local.vtheta_samples)
    });
    let expected = [(2, 2), (1, 4), (4, 4), (2, 8), (8, 8), (4, 16)];
    assert_eq!(samplings.collect::<Vec<_>>(), expected);
    let row = |samples: (u32, u32), seed, outcome, time_s| RunRow {
        config: None,
        vx_samples: samples.0,
        vtheta_samples: samples.1,
        ..row("", seed, outcome, time_s)
    };
    let rows = [
        row((2, 2), 1, RunOutcome::Reached, 30.0),
        row((2, 2), 2, RunOutcome::Reached, 99.0),
        row((2, 2), 3, RunOutcome::Timeout, 99.0),
        row((8, 8), 1, RunOutcome::Reached, 20.0),
        row((8, 8), 2, RunOutcome::Timeout, 99.0),
        row((8, 8), 3, RunOutcome::Reached, 20.0),
        row((4, 16), 1, RunOutcome::Timeout, 99.0),
    ];
    let table = groups(&rows);
    let ratios: Vec<Option<f64>> = table.iter().map(|group| group.mean_time_ratio).collect();
    assert_eq!(ratios, [Some(1.5), Some(1.0), None]);
    assert_eq!((table[0].runs, table[0].reached), (3, 2));
    // Both reached only the first mission.
    let times = |index: usize| {
        let group = &table[index];
        (group.shared, group.shared_time_p50_s, group.shared_time_p90_s)
    };
    assert_eq!(times(0), (1, Some(30.0), Some(30.0)));
    assert_eq!(times(1), (1, Some(20.0), Some(20.0)));
    assert_eq!(times(2), (1, None, None));
    assert_eq!(table[0].tick_p50_ms, Some(2.0));
    assert_eq!((table[1].samples, table[2].samples), (64, 64));
}

#[test]
fn spread_evenly_returns_at_most_all_elements() {
    let all: Vec<u32> = (0..10).collect();
    assert_eq!(spread_evenly(&all, 5), [0, 2, 4, 6, 8]);
    assert_eq!(spread_evenly(&all, 3), [0, 3, 6]);
    assert_eq!(spread_evenly(&all, 99), all);
    assert!(spread_evenly(&all, 0).is_empty());
}
