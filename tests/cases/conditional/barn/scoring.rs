//! The score of a run, and of many.

use inbye::experiment::barn::{BarnRow, BarnWorld, Published, Summary, score};
use inbye::experiment::worlds::Verdict;

use super::Test;

pub const TESTS: &[Test] = &[
    ("the score is OT over the time, within bounds", formula),
    ("worlds count alike, however many runs each has", means),
];

fn formula() {
    // OT is 5 s: the bounds are 10 s and 40 s.
    for (time_s, expected) in [
        (0.0, 0.5),
        (9.9, 0.5),
        (10.0, 0.5),
        (10.1, 5.0 / 10.1),
        (20.0, 0.25),
        (39.9, 5.0 / 39.9),
        (40.0, 0.125),
        (40.1, 0.125),
        (99.9, 0.125),
    ] {
        assert_eq!(score(true, time_s, 5.0), expected, "{time_s} s");
        assert_eq!(score(false, time_s, 5.0), 0.0, "{time_s} s");
    }
}

fn row(world: u32, seed: u64, result: Verdict, time_s: f64) -> BarnRow {
    BarnRow {
        world,
        seed,
        result,
        time_s,
        travelled_m: 10.0,
        min_clearance_m: Some(0.1),
        optimal_time_s: 5.0,
        score: score(result == Verdict::Succeeded, time_s, 5.0),
        fault: None,
        decision_p50_ms: None,
        decision_p99_ms: None,
    }
}

fn means() {
    let world = |number, published| BarnWorld {
        number,
        cylinders: Vec::new(),
        optimal_time_s: 5.0,
        official: published,
        published: published.then_some(Published {
            success: 0.9,
            collided: 0.1,
            timeout: 0.0,
            score: 0.2,
        }),
    };
    let worlds = [world(1, true), world(2, false)];
    let rows = [
        row(1, 0, Verdict::Succeeded, 10.0),
        row(1, 1, Verdict::Collided, 3.0),
        row(1, 2, Verdict::Failed, 60.0),
        row(1, 3, Verdict::Timeout, 100.0),
        row(2, 0, Verdict::Succeeded, 20.0),
    ];
    let summary = Summary::of(&rows.iter().collect::<Vec<_>>(), &worlds);
    let all = summary.all;
    assert_eq!((all.worlds, all.runs), (2, 5));
    assert_eq!((all.collided, all.timeout, all.failed), (1, 1, 1));
    // World 1: a quarter of 1 and of 0.5; world 2: 1 and 0.25.
    assert_eq!(
        (all.success, all.score),
        (f64::midpoint(0.25, 1.0), f64::midpoint(0.125, 0.25))
    );
    assert_eq!(all.mean_time_s, Some(15.0));
    let official = summary.official.expect("world 1 has published figures");
    assert_eq!(
        (official.worlds, official.success, official.score),
        (1, 0.25, 0.125)
    );
    let published = summary.published.expect("as above");
    assert_eq!(
        (published.worlds, published.success, published.score),
        (1, 0.9, 0.2)
    );
    let nothing = Summary::of(&[], &worlds);
    assert_eq!((nothing.all.runs, nothing.all.score), (0, 0.0));
    assert!(nothing.official.is_none() && nothing.published.is_none());
}
