//! Recordings: ROS 2 tools can read them, and their replay gives the same bits.
//!
//! Independent readers are the Python packages `mcap` and `mcap-ros2-support`: see `python.rs`. Without an adapter, tests are
//! skipped as in `support/adapters.rs`.

use libtest_mimic::Trial;

mod agreement;
mod disks;
mod drives;
mod late_loop;
mod metadata;
mod protection;
mod python;
mod rewritten;
mod stamps;

use crate::support::trials::{Test, plain};

pub fn trials() -> Vec<Trial> {
    let mut trials = plain([
        agreement::TESTS,
        disks::TESTS,
        late_loop::TESTS,
        metadata::TESTS,
        protection::TESTS,
        rewritten::TESTS,
        stamps::TESTS,
    ]);
    trials.extend(python::trials());
    trials.extend(crate::support::adapters::trials(&agreement::GPU_TESTS));
    trials
}
