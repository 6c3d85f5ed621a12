//! Compares the engines' integers with an oracle in real numbers, and tests the ranges in which they agree.
//!
//! Trajectories of 0.5 to 32 m, 1 to 200 steps, cells of 0.02 to 0.5 m, 1300 scenes with 197,265 samples. The tests
//! print the largest errors (`cargo test --test engine oracle -- --nocapture`):
//!
//! | quantity | allowed | measured |
//! |---|---|---|
//! | end position | 1 mm | 0.012 mm |
//! | clearance of moving obstacles | 1 mm | 0.66 mm |
//! | clearance of blocked cells | 1 mm and half a cell's diagonal | 0.993 half diagonals |
//! | heading term, 0.5 m or more from the target | 0.01 deg | 0.0023 deg |
//! | path term | 2 mm | 0.034 mm |
//! | velocity term | half of 2^-20 m/s | half of 2^-20 m/s |
//! | score of the winner, for its own terms | 1e-8 | 1.2e-9 |
//! | score of the winner below the best, on the oracle's terms | 1e-4 | 0 |
//!
//! A sample's status equals the oracle's unless it depends on a millimetre; 0.4 % of the samples do. A clearance is
//! compared twice: with the distance from the disc's centre, as above, and to 1 mm with the distance from the centre of
//! its cell, as the field is read. The last row uses the second distance, and only scenes in which every term has a
//! divisor large enough against rounding (`crate::support::closeness::SCALES`).

use crate::support::closeness::{Worst, compare};
use crate::support::naive::Fault;
use crate::support::scenes::Scene;

#[expect(clippy::print_stderr, reason = "prints the measured errors")]
fn report(what: &str, worst: &Worst) {
    eprintln!("{what}:\n{worst}");
    worst.assert_within_bounds();
}

#[test]
fn random_problems_are_close_to_the_oracle() {
    let mut worst = Worst::default();
    for case in 0..400 {
        let scene = Scene::of_bench(20, case);
        compare(&scene, &format!("bench {case}"), Fault::No, &mut worst);
    }
    report("random problems", &worst);
}

#[test]
fn trajectories_of_every_length_are_close_to_the_oracle() {
    for reach_m in [0.5, 2.0, 4.0, 8.0, 16.0, 32.0] {
        let mut worst = Worst::default();
        for case in 0..150 {
            let scene = Scene::random(21, case, reach_m);
            compare(&scene, &format!("{reach_m} m {case}"), Fault::No, &mut worst);
        }
        report(&format!("up to {reach_m} m"), &worst);
    }
}

/// Each test above must be able to fail: it must report an oracle with a fault.
#[test]
fn oracle_with_a_fault_is_reported() {
    for (fault, quantity) in [
        (Fault::TurnsFirst, "end off by"),
        (Fault::AddsPath, "winner below the best of its own terms, off by"),
        (Fault::ObstaclesLate, "clearance"),
        (Fault::StiffFootprint, "where the oracle has"),
        (Fault::WrongBraking, "Ok, where the oracle has CannotStop"),
        (Fault::KeepsFirstTurnRate, "end off by"),
        (Fault::KeepsFirstSpeed, "end off by"),
    ] {
        let mut worst = Worst::default();
        for case in 0..40 {
            let scene = Scene::random(22, case, 4.0);
            compare(&scene, &format!("case {case}"), fault, &mut worst);
        }
        let caught = worst.failures.iter().any(|failure| failure.contains(quantity));
        assert!(caught, "{fault:?}: {:?}", worst.failures.first());
    }
}
