//! The bodies of all fuzz targets, without a fuzzer: on the committed corpora, and on a number of seeded mutations of them.
//!
//! Bodies and corpora are in `fuzz/`. Its README says how to run them for longer.

#[path = "../../../fuzz/src/lib.rs"]
mod bodies;
mod corpus;
mod fragile;
mod mutation;
mod search;

use bodies::{TARGETS, Target};
use libtest_mimic::Trial;
use std::env;

/// Mutations of each corpus, unless the variable `INBYE_MUTATIONS` says how many: some seconds in all.
const MUTATIONS: usize = 20_000;

/// Targets with an input time of some milliseconds, because a robot drives, and by what their mutations are fewer.
const SLOW: [(&str, usize); 2] = [("node_conversation", 50), ("short_drive", 10)];

pub fn trials() -> Vec<Trial> {
    let asked = env::var("INBYE_MUTATIONS").ok();
    let asked = asked.map(|count| count.parse().expect("INBYE_MUTATIONS is a number"));
    let mutations = asked.unwrap_or(MUTATIONS);
    let of_target = move |&(name, body): &Target| {
        let slow = SLOW.iter().find(|(slow, _)| *slow == name);
        let mutations = mutations / slow.map_or(1, |(_, fewer)| *fewer);
        Trial::test(name, move || {
            let seeds = corpus::read(name)?;
            search::holds(name, body, &seeds, mutations).map_err(|breach| breach.to_string())?;
            Ok(())
        })
    };
    let mut trials: Vec<Trial> = TARGETS.iter().map(of_target).collect();
    trials.extend(corpus::trials());
    trials.extend(fragile::trials());
    trials
}
