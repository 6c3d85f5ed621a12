//! Some scenarios of every public map, where the development data are next to the repository.

use std::path::Path;

use inbye::bench::movingai::{ALGORITHMS, Algorithm, Bench, Files, find};
use libtest_mimic::{Failed, Trial};

use crate::support::trials::{DATA, with_data};

/// Number of scenarios of each map, spread over its file.
const SOME: usize = 20;

/// One trial for each map, or one ignored trial where the data are absent.
pub fn trials() -> Vec<Trial> {
    let folders = ["movingai", "mine"].map(|folder| Path::new(DATA).join(folder));
    if let Some(absent) = folders.iter().find(|folder| !folder.exists()) {
        return vec![with_data("public maps", absent, |_| Ok(()))];
    }
    let mut trials = Vec::new();
    for folder in folders {
        match find(&folder) {
            Ok(found) => trials.extend(found.files.into_iter().map(trial)),
            Err(error) => trials.push(Trial::test("public maps", move || Err(error.into()))),
        }
    }
    trials
}

fn trial(files: Files) -> Trial {
    Trial::test(format!("public: {}", files.name), move || solves(&files))
}

fn solves(files: &Files) -> Result<(), Failed> {
    let mut queries = files.read()?;
    let every = queries.scenarios.len().div_ceil(SOME);
    queries.scenarios = queries.scenarios.into_iter().step_by(every).collect();
    let usual: Vec<Algorithm> = ALGORITHMS.into_iter().filter(|it| it.usual).collect();
    let rows = Bench::new(&usual, 1).measure(&queries, &mut || 0.0, || ())?;
    for row in rows.algorithms {
        if !row.passed() {
            return Err(format!("{row:?}").into());
        }
    }
    Ok(())
}
