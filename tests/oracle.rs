//! The engines' integers against an oracle in real numbers, and the ranges within which that holds.
//!
//! Measured by these tests (they print it: `cargo test --test oracle -- --nocapture`), largest errors of any engine
//! from the oracle, trajectories of 0.5 to 32 m, up to 200 steps, cells of 0.02 to 0.5 m:
//!
//! | quantity | allowed | worst |
//! |---|---|---|
//! | end position | 1 mm | TODO mm |
//!
//! The chosen sample's loss is bounded where the terms are well scaled ([`closeness::SCALES`]).

#[path = "support/closeness.rs"]
mod closeness;
#[path = "support/extremes.rs"]
mod extremes;
#[path = "support/naive.rs"]
mod naive;
#[path = "support/ranges.rs"]
mod ranges;
#[path = "support/scenes.rs"]
mod scenes;

use closeness::{Worst, compare};
use naive::Fault;
use scenes::Scene;

#[expect(
    clippy::print_stderr,
    reason = "the measured errors are for people to read"
)]
fn report(what: &str, worst: &Worst) {
    eprintln!("{what}:\n{worst}");
    worst.assert_within_bounds();
}

#[test]
fn random_problems_of_the_benchmark_are_close_to_the_oracle() {
    let mut worst = Worst::default();
    for case in 0..400 {
        let scene = Scene::of_bench(20, case);
        compare(&scene, &format!("bench {case}"), Fault::No, &mut worst);
    }
    report("random problems", &worst);
}

#[test]
fn trajectories_of_any_promised_length_are_close_to_the_oracle() {
    for reach_m in [0.5, 2.0, 4.0, 8.0, 16.0, 32.0] {
        let mut worst = Worst::default();
        for case in 0..150 {
            let scene = Scene::random(21, case, reach_m);
            compare(
                &scene,
                &format!("{reach_m} m {case}"),
                Fault::No,
                &mut worst,
            );
        }
        report(&format!("up to {reach_m} m"), &worst);
    }
}

/// Each test above must be able to fail: an oracle with a mistake must be told from the engine.
#[test]
fn an_oracle_with_one_mistake_is_caught() {
    for (fault, quantity) in [
        (Fault::TurnsFirst, "end off by"),
        (
            Fault::AddsPath,
            "winner below the best of its own terms, off by",
        ),
        (Fault::ObstaclesLate, "clearance"),
        (Fault::StiffFootprint, "where the oracle has"),
        (Fault::WrongBraking, "Ok, where the oracle has CannotStop"),
    ] {
        let mut worst = Worst::default();
        for case in 0..40 {
            let scene = Scene::random(22, case, 4.0);
            compare(&scene, &format!("case {case}"), fault, &mut worst);
        }
        let caught = worst
            .failures
            .iter()
            .any(|failure| failure.contains(quantity));
        assert!(caught, "{fault:?}: {:?}", worst.failures.first());
    }
}
