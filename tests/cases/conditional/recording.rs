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

/// A test and its name.
type Test = (&'static str, fn());

pub fn trials() -> Vec<Trial> {
    let trial = |&(name, test): &Test| {
        Trial::test(name, move || {
            test();
            Ok(())
        })
    };
    let tests = [
        agreement::TESTS,
        disks::TESTS,
        late_loop::TESTS,
        metadata::TESTS,
        protection::TESTS,
        rewritten::TESTS,
    ];
    let mut trials: Vec<Trial> = tests.into_iter().flatten().map(trial).collect();
    trials.extend(python::trials());
    trials.extend(crate::support::adapters::trials(&agreement::GPU_TESTS));
    trials
}
