//! Worlds of the benchmark itself, where the development data are next to the repository.

use std::path::Path;

use inbye::experiment::barn::{barn_config, read_worlds};
use inbye::experiment::{RunOutcome, World};
use inbye::local::CpuEngine;
use inbye::runtime::Observer;
use libtest_mimic::{Failed, Trial};

use crate::support::trials::with_data;

pub fn trial() -> Trial {
    with_data("two worlds of the benchmark are crossed", "barn", crosses)
}

fn crosses(worlds: &Path) -> Result<(), Failed> {
    assert_eq!(read_worlds(worlds, None)?.len(), 150);
    for world in read_worlds(worlds, Some(&[0, 12]))? {
        let mut observer = Observer { clock: &mut || 0.0, on_tick: &mut |_| {} };
        let engine = Box::new(CpuEngine::single_threaded());
        let run = World::barn(world, 2.0).drive(0, &barn_config(2.0), engine, &mut observer)?;
        assert_eq!(run.row.outcome, RunOutcome::Reached, "{:?}", run.row);
        assert!(run.row.score > Some(0.2), "{:?}", run.row);
    }
    Ok(())
}
