//! Sweeps. A killed process or a parallel one loses no cell and repeats none. The merged table has the same bytes from one
//! process, several processes, shards, a Slurm array or a Ray cluster.

use libtest_mimic::Trial;

mod cluster;
mod interruptions;
mod latencies;
mod plan_folder;
mod plans;
mod tables;

/// A test by its name.
type Test = (&'static str, fn());

pub fn trials() -> Vec<Trial> {
    let trial = |&(name, test): &Test| {
        Trial::test(name, move || {
            test();
            Ok(())
        })
    };
    let tests = [interruptions::TESTS, latencies::TESTS, plans::TESTS, tables::TESTS];
    let mut trials: Vec<Trial> = tests.into_iter().flatten().map(trial).collect();
    trials.extend(cluster::trials());
    trials
}
