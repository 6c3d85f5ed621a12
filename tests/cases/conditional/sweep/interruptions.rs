//! Killed processes, parallel processes, and shards.

use std::fs::File;
use std::thread::sleep;
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::Test;
use super::plan_folder::{CELLS, PLAN, PlanFolder};

pub const TESTS: &[Test] = &[
    ("repeated kills lose no cell and repeat none", killed),
    ("two processes share the cells of one folder", side_by_side),
    ("another process runs the cell of a killed process", taken_over),
    ("another plan waits until the folder is free", another_plan),
    ("merged shards equal the whole sweep", shards),
    ("merged tasks of a Slurm array equal the whole sweep", slurm),
];

/// Longer than any run takes on an overloaded machine.
const TIMEOUT: Duration = Duration::from_secs(300);

fn killed() {
    let place = PlanFolder::new();
    let mut rng = Pcg64Mcg::seed_from_u64(7);
    let (mut kills, mut killed_midway) = (0, 0);
    for from in [1, 5, 9, 14, 19] {
        let before = place.begun("out");
        let had = place.finished("out");
        let mut process = place.start("sweep plan.toml --out out --jobs 2");
        let began = Instant::now();
        while place.finished("out").len() < from && began.elapsed() < TIMEOUT {
            sleep(Duration::from_millis(2));
        }
        sleep(Duration::from_millis(rng.random_range(0..120)));
        // The process cannot handle SIGKILL.
        process.kill().expect("it can be killed");
        process.wait().expect("it ends");
        kills += 1;
        killed_midway += usize::from(place.finished("out").len() < CELLS);
        let after = place.begun("out");
        for key in &had {
            assert_eq!(before.get(key), after.get(key), "{key} was finished, and begun again");
        }
    }
    assert!(killed_midway > 2, "only {killed_midway} kills came in time");
    let had = place.finished("out");
    let report = place.json("sweep plan.toml --out out --jobs 2");
    assert_eq!(report["found"], had.len(), "{report}");
    assert_eq!(report["driven"], CELLS - had.len(), "{report}");
    let begun = place.begun("out");
    assert_eq!(begun.len(), CELLS);
    // A kill loses at most the two cells in progress.
    let extra: usize = begun.values().map(|times| times - 1).sum();
    assert!(extra <= 2 * kills, "{extra} cells were begun again after {kills} kills");
    place.assert_same_table("out");
    let again = place.json("sweep plan.toml --out out");
    assert_eq!((&again["found"], &again["driven"]), (&CELLS.into(), &0.into()));
}

fn side_by_side() {
    let place = PlanFolder::new();
    let mut processes = [
        place.start("sweep plan.toml --out out --jobs 2"),
        place.start("sweep plan.toml --out out --jobs 2"),
    ];
    for process in &mut processes {
        assert!(process.wait().expect("it ends").success());
    }
    let begun = place.begun("out");
    assert_eq!(begun.len(), CELLS);
    assert!(begun.values().all(|&times| times == 1), "{begun:?}");
    let log = place.log("out");
    let mut who: Vec<u64> = log.iter().filter_map(|line| line["pid"].as_u64()).collect();
    who.sort_unstable();
    who.dedup();
    assert_eq!(who.len(), 2, "both had a part in it");
    place.assert_same_table("out");
}

fn taken_over() {
    let place = PlanFolder::new();
    let mut first = place.start("sweep plan.toml --out out --jobs 2");
    let mut second = place.start("sweep plan.toml --out out --jobs 1");
    let began = Instant::now();
    while place.finished("out").len() < 4 && began.elapsed() < TIMEOUT {
        sleep(Duration::from_millis(2));
    }
    first.kill().expect("it can be killed");
    first.wait().expect("it ends");
    assert!(second.wait().expect("it ends").success());
    assert_eq!(place.finished("out").len(), CELLS);
    place.assert_same_table("out");
}

fn another_plan() {
    let place = PlanFolder::new();
    place.json("sweep plan.toml --out out --list");
    place.write("other.toml", PLAN.replace("[0, 1, 2]", "[0]"));
    let in_use = File::open(place.path("out/sweep.lock")).expect("a folder in use has it");
    in_use.lock_shared().expect("the lock is free");
    let message = place.refusal("sweep other.toml --out out");
    assert!(message.contains("another plan is being run in it"), "{message}");
    // The same plan may run at the same time.
    place.json("sweep plan.toml --out out --shard 1/24");
    in_use.unlock().expect("we have it");
    let report = place.json("sweep other.toml --out out");
    assert_eq!(report["cells"], CELLS / 3, "{report}");
}

fn shards() {
    let place = PlanFolder::new();
    let mut counts = Vec::new();
    for shard in 1..=5 {
        let report = place.json(&format!("sweep plan.toml --out s{shard} --shard {shard}/5"));
        counts.push(report["driven"].as_u64().expect("a count"));
    }
    assert_eq!(counts.iter().sum::<u64>(), CELLS as u64, "{counts:?}");
    assert!(counts.iter().all(|&count| (4..=5).contains(&count)), "{counts:?}");
    place.assert_same_table("s3 s1 s5 s2 s4");
    let ran = place.run("sweep merge s1 s3 --report some --json");
    assert_eq!(ran.status, 1, "{ran:?}");
}

fn slurm() {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/sweep_slurm.sbatch");
    let place = PlanFolder::new();
    let run = |task: usize, count: &str| {
        place
            .command("bash")
            .args([script, "plan.toml", "out"])
            .env("INBYE", super::plan_folder::INBYE)
            .env("SLURM_ARRAY_TASK_ID", task.to_string())
            .env("SLURM_ARRAY_TASK_MIN", "4")
            .env("SLURM_ARRAY_TASK_MAX", "6")
            .env("SLURM_ARRAY_TASK_COUNT", count)
            .env("SLURM_CPUS_PER_TASK", "2")
            .output()
            .expect("a shell")
    };
    // A list of indices, 4 and 6.
    let refused = run(6, "2");
    let message = String::from_utf8_lossy(&refused.stderr);
    assert!(!refused.status.success() && message.contains("must be a range"), "{refused:?}");
    // The indices of an array need not begin at 1: here they are 4 to 6.
    for task in 4..=6 {
        let ran = run(task, "3");
        assert!(ran.status.success(), "{ran:?}");
        assert_eq!(place.finished("out").len(), 8 * (task - 3));
    }
    place.assert_same_table("out");
}
