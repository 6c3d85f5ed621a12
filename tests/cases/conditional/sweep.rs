//! Sweeps. A killed process or a parallel one loses no cell and repeats none. The merged table has the same bytes from one
//! process, several processes, shards, a Slurm array or a Ray cluster.

use libtest_mimic::Trial;

mod cluster;
mod interruptions;
mod latencies;
mod plan_folder;
mod plans;
mod tables;

use crate::support::trials::{Test, plain};

pub fn trials() -> Vec<Trial> {
    let mut trials = plain([interruptions::TESTS, latencies::TESTS, plans::TESTS, tables::TESTS]);
    trials.extend(cluster::trials());
    trials
}
