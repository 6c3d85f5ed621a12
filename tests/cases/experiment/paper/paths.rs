//! Independent checks of the paths: clearance, exactness where promised, shorter lengths and fewer turns.

use std::sync::OnceLock;

use crate::support::gap::{STEP, is_on_grid, smallest_gap_m};
use inbye::bench::paper::{
    MINE_SEARCHES, SEARCHES, Search, Site, Stage, TaskRuns, made_mine, measure,
};
use inbye::global::Heuristic;
use inbye::map::FreeSpace;
use inbye::runtime::Config;

/// Tolerance for rounding, metres.
const ROUNDING_M: f64 = 1e-9;

/// The three scenes and the generated mine, each with its runs, without times.
fn measured() -> &'static [(Site, Vec<TaskRuns>)] {
    static MEASURED: OnceLock<Vec<(Site, Vec<TaskRuns>)>> = OnceLock::new();
    MEASURED.get_or_init(|| {
        let config = Config::default();
        let mut sites = Site::roadways(&config);
        sites.push(Site::mine("made", made_mine(1), 5, 1, &config).expect("the mine has room"));
        sites
            .into_iter()
            .map(|site| {
                let runs = runs(&site);
                (site, runs)
            })
            .collect()
    })
}

fn runs(site: &Site) -> Vec<TaskRuns> {
    let searches: &[Search] = if site.name == "mine" { &MINE_SEARCHES } else { &SEARCHES };
    measure(site, searches, 0, &mut || 0.0, || ()).expect("every task has a path")
}

/// A figure of a search at a stage, summed over all tasks.
fn sum(search: Search, stage: Stage, figure: fn(&inbye::global::Path) -> f64) -> f64 {
    let tasks = measured().iter().flat_map(|(_, tasks)| tasks);
    tasks.map(|task| figure(&task.of(search).expect("it was run").at(stage).path)).sum()
}

#[test]
fn every_path_of_every_variant_keeps_its_distance() {
    let mut checked = 0;
    for (site, tasks) in measured() {
        let kept_m = [&site.search, &site.search, &site.proof].map(FreeSpace::radius_m);
        for task in tasks {
            let ends = [task.task.start, task.task.goal].map(|end| site.map.frame().center_of(end));
            for run in &task.runs {
                for (worked, kept_m) in run.stages.iter().zip(kept_m) {
                    let points = worked.path.points();
                    let gap_m = smallest_gap_m(points, &site.obstacles, 1.2, STEP);
                    let what = format!("{}, {}", task.task.name, run.search.label);
                    assert!(gap_m >= kept_m - ROUNDING_M, "{what}: {gap_m} m");
                    assert!(worked.min_clearance_m <= gap_m + ROUNDING_M, "{what}");
                    assert!(is_on_grid(points, &site.obstacles), "{what}");
                    assert_eq!([points[0], points[points.len() - 1]], ends, "{what}");
                    checked += 1;
                }
            }
            assert_eq!(task.faults(site), [""; 0]);
        }
    }
    assert_eq!(checked, 3 * 15 + 5 * 13);
}

#[test]
fn exact_searches_agree_and_no_search_beats_them() {
    for (_, tasks) in measured() {
        for task in tasks {
            for run in &task.runs {
                let (name, task_name) = (run.search.label, &task.task.name);
                let beyond = run.cost.checked_sub(task.shortest);
                let beyond = beyond.unwrap_or_else(|| panic!("{task_name}, {name}: too short"));
                assert!(beyond == 0 || !run.search.is_exact(), "{task_name}, {name}: {beyond}");
            }
            let exact = task.runs.iter().filter(|run| run.search.is_exact());
            assert!(exact.count() >= 3);
        }
    }
}

#[test]
fn paths_are_shorter_and_have_fewer_turns_than_the_traditional_ones() {
    let length = |search, stage| sum(search, stage, inbye::global::Path::length_m);
    let turns = |search, stage| sum(search, stage, |path| path.turns() as f64);
    for search in [Search::IMPROVED, Search::JUMP_POINTS] {
        for traditional in [Search::MANHATTAN, Search::EUCLID] {
            let shorter = length(search, Stage::Smoothed) / length(traditional, Stage::Raw);
            assert!(shorter <= 0.97, "{search:?} against {traditional:?}: {shorter}");
            let fewer = turns(search, Stage::Pruned) / turns(traditional, Stage::Raw);
            assert!(fewer <= 1.0 / 3.0, "{search:?} against {traditional:?}: {fewer}");
        }
        assert_eq!(turns(search, Stage::Smoothed), 0.0);
    }
}

#[test]
fn nothing_but_times_differs_from_run_to_run() {
    let (site, first) = &measured()[2];
    assert_eq!(&runs(site), first);
}

#[test]
fn the_five_ways_are_spread_over_the_mine() {
    let (site, tasks) = &measured()[3];
    let frame = site.map.frame();
    let ends: Vec<_> = tasks
        .iter()
        .flat_map(|task| [task.task.start, task.task.goal])
        .map(|cell| frame.center_of(cell))
        .collect();
    assert_eq!(ends.len(), 10);
    for (index, one) in ends.iter().enumerate() {
        for other in &ends[index + 1..] {
            assert!((one - other).norm() > 30.0, "{one:?} and {other:?}");
        }
    }
}

#[test]
fn roadways_have_the_size_of_the_papers_scenes() {
    let sites = Site::roadways(&Config::default());
    for site in &sites {
        let [task] = &site.tasks[..] else {
            panic!("one task each");
        };
        let frame = site.map.frame();
        let apart_m = (frame.center_of(task.goal) - frame.center_of(task.start)).norm();
        assert!((19.0..26.0).contains(&apart_m), "{}: {apart_m} m", site.name);
        assert!(site.search.is_free(task.start) && site.search.is_free(task.goal));
    }
    assert_eq!(sites.len(), 3);
}

#[test]
fn made_mine_depends_on_its_seed_and_has_open_area() {
    let mine = made_mine(1);
    assert!(made_mine(1) == mine && made_mine(2) != mine);
    let open = mine.cells().iter().filter(|&&cell| cell == 0).count();
    let share = open as f64 / mine.cells().len() as f64;
    assert!((0.25..0.6).contains(&share), "{share} of the ground is open");
}

/// A clock that advances with each reading counts the stages.
#[test]
fn stages_are_timed_from_the_start_and_alone() {
    let site = &Site::roadways(&Config::default())[0];
    let searches = [Search::MANHATTAN, Search::JUMP_POINTS];
    let mut ticks = 0.0;
    let mut clock = || {
        ticks += 1.0;
        ticks
    };
    let mut passes = 0;
    let measured = measure(site, &searches, 3, &mut clock, || passes += 1);
    let measured = measured.expect("the scene has a path");
    let [raw] = &measured[0].runs[0].stages[..] else {
        panic!("a baseline is only searched");
    };
    assert_eq!((raw.time.p50_ms, raw.own_ms), (1e3, 1e3));
    let smoothed = measured[0].runs[1].at(Stage::Smoothed);
    assert_eq!((smoothed.time.p50_ms, smoothed.own_ms), (3e3, 1e3));
    assert_eq!(passes, 3);
    assert_eq!(measured[0].faults(site), [""; 0]);
}

#[test]
fn faults_report_long_and_close_paths() {
    let site = &Site::roadways(&Config::default())[0];
    let mut clock = || 0.0;
    let measured = measure(site, &[Search::JUMP_POINTS], 0, &mut clock, || ());
    let mut task = measured.expect("the scene has a path").remove(0);
    task.shortest -= 1;
    task.runs[0].stages[2].min_clearance_m = 0.1;
    let faults = task.faults(site);
    assert_eq!(faults.len(), 2, "{faults:?}");
    assert!(faults[0].contains("shortest") && faults[1].contains("Smoothed: 0.1000 m"));
}

#[test]
fn improved_search_has_the_default_heuristic() {
    assert_eq!(Search::IMPROVED.heuristic, Some(Heuristic::default()));
}
