//! The closed loop: a robot that knows its map, sees its world and drives in it, from start to goal or to a reason why
//! not.
//!
//! Everything runs in simulated time. See `support/adapters.rs` for what happens where there is no adapter, and
//! `mine.rs` for what happens without the development data.

use std::process::ExitCode;

use libtest_mimic::{Arguments, Trial};

#[cfg(feature = "gpu")]
#[path = "../support/adapters.rs"]
mod adapters;
mod audit;
mod doors;
mod driving;
mod ground;
mod mine;
mod people;
mod places;
#[cfg(feature = "gpu")]
#[path = "../support/requirements.rs"]
mod requirements;
mod scene_drives;
mod script;
mod script_senses;
mod traces;

/// A test by its name.
type Test = (&'static str, fn());

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let tests = [
        audit::TESTS,
        doors::TESTS,
        people::TESTS,
        places::TESTS,
        scene_drives::TESTS,
        script::TESTS,
        script_senses::TESTS,
        traces::TESTS,
    ];
    let mut trials: Vec<Trial> = tests.into_iter().flatten().map(trial).collect();
    trials.push(mine::trial());
    trials.push(mine::trial_by_scans());
    trials.extend(gpu_trials());
    libtest_mimic::run(&arguments, trials).exit_code()
}

fn trial(&(name, test): &Test) -> Trial {
    Trial::test(name, move || {
        test();
        Ok(())
    })
}

#[cfg(feature = "gpu")]
fn gpu_trials() -> Vec<Trial> {
    adapters::trials(&traces::GPU_TESTS)
}

#[cfg(not(feature = "gpu"))]
fn gpu_trials() -> Vec<Trial> {
    let ignored = || {
        Ok(libtest_mimic::Completion::ignored_with(
            "built without the feature `gpu`",
        ))
    };
    vec![Trial::ignorable_test("gpu", ignored)]
}
