//! The BARN and DynaBARN benchmarks: their worlds, rules and records.

use libtest_mimic::Trial;

mod driving;
mod dynabarn;
mod files;
mod ground;
mod moving_drives;
mod public;
mod records;
mod scoring;

/// A test by its name.
type Test = (&'static str, fn());

pub fn trials() -> Vec<Trial> {
    let tests = [
        driving::TESTS,
        dynabarn::TESTS,
        files::TESTS,
        ground::TESTS,
        moving_drives::TESTS,
        records::TESTS,
        scoring::TESTS,
    ];
    let mut trials: Vec<Trial> = tests.into_iter().flatten().map(trial).collect();
    trials.push(public::trial());
    trials.push(dynabarn::trial());
    trials.push(moving_drives::trial());
    trials
}

fn trial(&(name, test): &Test) -> Trial {
    Trial::test(name, move || {
        test();
        Ok(())
    })
}
