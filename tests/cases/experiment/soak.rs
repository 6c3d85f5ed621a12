//! Random missions: the same from the same seed, fair, and the same traces on every engine.

use inbye::experiment::missions::{
    Ending, MissionRow, MissionSite, People, Rules, Setup, Touch, compare_digests, drive,
};
use inbye::experiment::{
    ABLATION_VARIANTS, SoakSummary, ablation_rows, closed_loop_rows, closed_loop_setups,
};
use inbye::global::Searcher;
use inbye::local::{
    CpuEngine, Detail, Engine, EngineError, Evaluation, InstructionSet, QuantizedProblem,
};
use inbye::map::FreeSpace;
use inbye::robot::Footprint;
use inbye::runtime::{Config, Observer};
use inbye::sim::{crossing, roadway};

fn site(config: &Config) -> MissionSite {
    MissionSite::new("crossing", crossing().map, config)
}

/// Missions short enough for a test.
fn short() -> Rules {
    Rules {
        longest_m: 9.0,
        ..Rules::default()
    }
}

#[test]
fn a_mission_belongs_to_its_seed() {
    let config = Config::default();
    let site = site(&config);
    let rules = Rules {
        unmapped_share: 0.5,
        ..Rules::default()
    };
    let draw = |seed| {
        let drawn = site.draw(seed, &rules, &config).expect("there is room");
        let simulation = drawn.simulation;
        let mission = simulation.mission;
        let goal = (mission.goal.position, mission.goal.yaw);
        (
            (mission.start, goal, drawn.path_m, drawn.people),
            (
                simulation.moving_obstacles,
                simulation.truth,
                drawn.unmapped,
            ),
        )
    };
    let mut kinds = Vec::new();
    for seed in 1..=20 {
        let first = draw(seed);
        assert_eq!(first, draw(seed), "seed {seed}");
        assert_ne!(first.0, draw(seed + 100).0, "seed {seed}");
        kinds.push(first.0.3);
    }
    for kind in [People::Minding, People::Heedless, People::Appearing] {
        assert!(kinds.contains(&kind), "{kind:?} in {kinds:?}");
    }
}

#[test]
fn ends_are_free_and_connected_and_the_rules_kept() {
    let config = Config::default();
    let sites = [
        site(&config),
        MissionSite::new("roadway", roadway().map, &config),
    ];
    let rules = Rules {
        unmapped_share: 1.0,
        ..Rules::default()
    };
    let mut searcher = Searcher::default();
    let mut stood = 0;
    for (seed, site) in (1..=12).flat_map(|seed| sites.iter().map(move |site| (seed, site))) {
        let drawn = site.draw(seed, &rules, &config).expect("there is room");
        let simulation = &drawn.simulation;
        let mission = &simulation.mission;
        let frame = site.map.frame();
        let ends = [mission.start.position(), mission.goal.position];
        let [start, goal] = ends.map(|end| frame.cell_of(&end).expect("on the map"));
        assert!(mission.goal.yaw.is_some());
        assert!((ends[1] - ends[0]).norm() >= rules.least_m);
        assert!((rules.least_m..=rules.longest_m).contains(&drawn.path_m));
        // The circle that the robot turns in fits at either end, and the search itself finds the way.
        let radius_m = config.robot.footprint.circumscribed_radius_m();
        let space = FreeSpace::new(&site.obstacles, radius_m);
        assert!(space.is_free(start) && space.is_free(goal), "seed {seed}");
        assert!(searcher.jump_points(&space, start, goal).is_ok());
        assert!(simulation.moving_obstacles.len() <= rules.most_people);
        if let Some(truth) = &simulation.truth {
            stood += drawn.unmapped;
            let blocked = |cells: &[bool]| cells.iter().filter(|&&cell| cell).count();
            assert!(blocked(truth.cells()) > blocked(site.obstacles.cells()));
            // What stands on the way leaves one, and the ends are left alone.
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
    let error = site(&config).draw(1, &rules, &config).expect_err("no room");
    assert!(error.to_string().contains("crossing: no two free places"));
    let bad = Rules {
        unmapped_share: 1.5,
        ..rules
    };
    let error = site(&config)
        .draw(1, &bad, &config)
        .expect_err("a bad rule");
    assert!(
        error.to_string().contains("unmapped_share is 1.5"),
        "{error}"
    );
}

/// Answers like the CPU but for one bit of one answer.
struct Flipped {
    engine: CpuEngine,
    decisions_left: u32,
}

impl Engine for Flipped {
    fn name(&self) -> String {
        "flipped".to_owned()
    }

    fn kind(&self) -> &'static str {
        "cpu"
    }

    fn threads(&self) -> usize {
        1
    }

    fn evaluate(
        &mut self,
        problem: &QuantizedProblem,
        detail: Detail,
    ) -> Result<Evaluation, EngineError> {
        let mut answer = self.engine.evaluate(problem, detail)?;
        if let Some(winner) = &mut answer.winner {
            if self.decisions_left == 0 {
                winner.index ^= 1;
            }
            self.decisions_left = self.decisions_left.wrapping_sub(1);
        }
        Ok(answer)
    }
}

#[test]
fn one_flipped_bit_is_another_trace() {
    let setup = Setup {
        name: "soak".to_owned(),
        config: Config::default(),
    };
    let site = site(&setup.config);
    let run = |engine: Box<dyn Engine>| -> MissionRow {
        let mut observer = Observer {
            clock: &mut || 0.0,
            on_tick: &mut |_| {},
        };
        let driven = drive(&site, 3, &short(), &setup, engine, &mut observer);
        driven.expect("a sound mission").0
    };
    let row = run(Box::new(CpuEngine::single_threaded()));
    let scalar = CpuEngine::with_instruction_set(InstructionSet::Scalar, 1).expect("always there");
    let flipped = Flipped {
        engine: CpuEngine::single_threaded(),
        decisions_left: 12,
    };
    let again = [run(Box::new(scalar)), run(Box::new(flipped))];
    let compared = compare_digests(&[&row], &again);
    let equal: Vec<bool> = compared.iter().map(|one| one.equal).collect();
    assert_eq!(equal, [true, false], "{compared:?}");
    let summary = SoakSummary::of(&[&row], &compared);
    assert_eq!((summary.digests_compared, summary.digests_equal), (2, 1));
    assert!(!summary.is_sound());
    assert!(row.reason.is_some() || SoakSummary::of(&[&row], &compared[..1]).is_sound());
}

/// A row made up by hand.
fn row(setup: &str, seed: u64, result: Ending, time_s: f64) -> MissionRow {
    MissionRow {
        setup: setup.to_owned(),
        map: "somewhere".to_owned(),
        seed,
        people: People::Nobody,
        moving: 0,
        unmapped: 0,
        result,
        time_s,
        path_m: 10.0,
        travelled_m: 10.0,
        min_clearance_m: Some(0.1),
        contact: Touch::None,
        fault: None,
        reason: (result != Ending::Reached).then(|| "why".to_owned()),
        final_error_m: 0.01,
        final_yaw_error_rad: Some(-0.02),
        plans: 1,
        ticks: 100,
        trace_digest: None,
        engine: "CPU".to_owned(),
        tick_p50_ms: Some(seed as f64),
        tick_p99_ms: None,
    }
}

#[test]
fn times_are_compared_over_shared_successes() {
    let [first, second] = [ABLATION_VARIANTS[0].name, ABLATION_VARIANTS[1].name];
    let rows = [
        row(first, 1, Ending::Reached, 30.0),
        row(first, 2, Ending::Failed, 90.0),
        row(second, 1, Ending::Reached, 20.0),
        row(second, 2, Ending::Reached, 50.0),
    ];
    let table = ablation_rows(&rows.iter().collect::<Vec<_>>());
    assert_eq!(table.len(), ABLATION_VARIANTS.len());
    // The variants without a success do not take the shared missions away.
    let figures = |row: usize| (table[row].tally.mean_time_s, table[row].mean_shared_time_s);
    assert_eq!(figures(0), (Some(30.0), Some(30.0)));
    assert_eq!(figures(1), (Some(35.0), Some(20.0)));
    assert_eq!(figures(2), (None, None));
    assert_eq!((table[0].shared, table[0].tally.failed), (1, 1));
}

#[test]
fn closed_loops_are_measured_by_the_densest_sampling() {
    let setups = closed_loop_setups(&Config::default(), &[4, 16, 64], &[1.0, 0.25]);
    let names: Vec<&str> = setups.iter().map(|setup| setup.name.as_str()).collect();
    assert_eq!(names, ["2x2", "1x4", "4x4", "2x8", "8x8", "4x16"]);
    let rows = [
        row("2x2", 1, Ending::Reached, 30.0),
        row("2x2", 2, Ending::Reached, 99.0),
        row("2x2", 3, Ending::Timeout, 99.0),
        row("8x8", 1, Ending::Reached, 20.0),
        row("8x8", 2, Ending::Timeout, 99.0),
        row("8x8", 3, Ending::Reached, 20.0),
    ];
    let table = closed_loop_rows(&setups, &rows.iter().collect::<Vec<_>>());
    let ratios: Vec<Option<f64>> = table.iter().map(|row| row.mean_time_ratio).collect();
    assert_eq!(ratios, [Some(1.5), None, None, None, Some(1.0), None]);
    assert_eq!((table[0].missions, table[0].reached), (3, 2));
    // Only the first mission was reached by both.
    let times = |row: usize| {
        (
            table[row].shared,
            table[row].time_p50_s,
            table[row].time_p90_s,
        )
    };
    assert_eq!(times(0), (1, Some(30.0), Some(30.0)));
    assert_eq!(times(4), (1, Some(20.0), Some(20.0)));
    assert_eq!(times(1), (1, None, None));
    assert_eq!(table[0].tick_p50_ms, Some(2.0));
    assert_eq!((table[4].samples, table[5].samples), (64, 64));
}
