//! Recordings: what ROS 2 tools read from them, and whether they are decided again with the same bits.
//!
//! Other readers are the Python packages `mcap` and `mcap-ros2-support`: see `python.rs`. See `support/adapters.rs` for what
//! happens where there is no adapter.

use libtest_mimic::Trial;

mod agreement;
mod disks;
mod drives;
mod python;

/// A test by its name.
type Test = (&'static str, fn());

pub fn trials() -> Vec<Trial> {
    let trial = |&(name, test): &Test| {
        Trial::test(name, move || {
            test();
            Ok(())
        })
    };
    let tests = [agreement::TESTS, disks::TESTS];
    let mut trials: Vec<Trial> = tests.into_iter().flatten().map(trial).collect();
    trials.extend(python::trials());
    trials.extend(crate::support::adapters::trials(&agreement::GPU_TESTS));
    trials
}
