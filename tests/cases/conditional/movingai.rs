//! Grid search by the rules of the `MovingAI` benchmark. An independent search measures the shortest paths of generated
//! maps. Public maps are used where the development data are next to the repository.

use libtest_mimic::Trial;

mod exact;
mod ground;
mod legality;
mod public;
mod sample;

use crate::support::trials::{Test, plain};

pub fn trials() -> Vec<Trial> {
    let mut trials = plain([&exact::TESTS[..], &legality::TESTS[..]]);
    trials.extend(public::trials());
    trials
}
