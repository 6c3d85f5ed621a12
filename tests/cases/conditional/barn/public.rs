//! Worlds of the benchmark itself, where the development data lie beside the repository.

use std::path::Path;

use inbye::experiment::barn::{Task, barn_config, read_worlds};
use inbye::experiment::worlds::{Verdict, drive};
use libtest_mimic::{Completion, Failed, Trial};

const WORLDS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/barn");

pub fn trial() -> Trial {
    Trial::ignorable_test("two worlds of the benchmark are crossed", || {
        if !Path::new(WORLDS).exists() {
            return Ok(Completion::ignored_with(
                "the development data are not beside the repository",
            ));
        }
        crosses()?;
        Ok(Completion::Completed)
    })
}

fn crosses() -> Result<(), Failed> {
    assert_eq!(read_worlds(Path::new(WORLDS), None)?.len(), 150);
    for world in read_worlds(Path::new(WORLDS), Some(&[0, 12]))? {
        let (row, _) = drive(&Task::barn(&world, 0), &barn_config(2.0), &mut || 0.0)?;
        assert_eq!(row.result, Verdict::Succeeded, "{row:?}");
        assert!(row.score > 0.2, "{row:?}");
    }
    Ok(())
}
