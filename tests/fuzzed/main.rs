//! The bodies of all fuzz targets, without a fuzzer: on the committed corpora, and on a number of seeded mutations of them.
//!
//! The bodies and the corpora are those of `fuzz/`, where it is told how to run them for longer.

#[path = "../../fuzz/src/lib.rs"]
mod bodies;
mod corpus;
mod fragile;
mod mutation;
mod search;

use std::process::ExitCode;

use bodies::TARGETS;
use libtest_mimic::{Arguments, Trial};

/// Mutations of each corpus: some seconds in all.
const MUTATIONS: usize = 3_000;

fn main() -> ExitCode {
    let of_target = |&(name, body): &(&'static str, fn(&[u8]))| {
        Trial::test(name, move || {
            let seeds = corpus::read(name)?;
            search::holds(body, &seeds, MUTATIONS).map_err(|breach| breach.to_string())?;
            Ok(())
        })
    };
    let mut trials: Vec<Trial> = TARGETS.iter().map(of_target).collect();
    trials.extend(corpus::trials());
    trials.extend(fragile::trials());
    libtest_mimic::run(&Arguments::from_args(), trials).exit_code()
}
