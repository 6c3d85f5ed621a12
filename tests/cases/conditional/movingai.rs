//! Grid search by the rules of the `MovingAI` benchmark. An independent search measures the shortest paths of generated
//! maps. Public maps are used where the development data are next to the repository.

use libtest_mimic::Trial;

mod exact;
mod ground;
mod legality;
mod public;
mod sample;

/// A test by its name.
type Test = (&'static str, fn());

pub fn trials() -> Vec<Trial> {
    let tests = exact::TESTS.iter().chain(&legality::TESTS);
    let mut trials: Vec<Trial> = tests.map(trial).collect();
    trials.extend(public::trials());
    trials
}

fn trial(&(name, test): &Test) -> Trial {
    Trial::test(name, move || {
        test();
        Ok(())
    })
}
