//! Missions in closed loop: from start to goal, or to a reason why not.
//!
//! Everything runs in simulated time. `support/adapters.rs` describes what happens without a GPU adapter, and `mine.rs` what
//! happens without the development data.

use libtest_mimic::Trial;

use crate::support::adapters;
use crate::support::trials::{Test, plain};

mod audit;
mod changed_walls;
mod doors;
mod driving;
mod ground;
mod mine;
mod observation_faults;
mod people;
mod places;
mod scene_drives;
mod script;
mod traces;
mod zones;

pub fn trials() -> Vec<Trial> {
    let mut trials = plain([
        audit::TESTS,
        changed_walls::TESTS,
        doors::TESTS,
        people::TESTS,
        places::TESTS,
        scene_drives::TESTS,
        script::TESTS,
        observation_faults::TESTS,
        traces::TESTS,
        zones::TESTS,
    ]);
    trials.push(mine::trial());
    trials.push(mine::trial_by_scans());
    trials.extend(adapters::trials(&traces::GPU_TESTS));
    trials
}
