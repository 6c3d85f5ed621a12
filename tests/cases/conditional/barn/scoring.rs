//! The score of one run, and the means of many runs.

use inbye::experiment::barn::{BarnSummary, BarnWorld, Course, Published, score};
use inbye::experiment::{RunOutcome, RunRow, WorldKind};

use super::Test;

pub const TESTS: &[Test] = &[
    ("the score is OT over the time, within bounds", formula),
    ("each world has the same weight for any number of runs", means),
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

fn row(world: u32, seed: u64, outcome: RunOutcome, time_s: f64) -> RunRow {
    RunRow {
        kind: WorldKind::Barn,
        world: world.to_string(),
        seed,
        outcome,
        time_s,
        optimal_time_s: Some(5.0),
        score: Some(score(outcome == RunOutcome::Reached, time_s, 5.0)),
        ..RunRow::default()
    }
}

fn means() {
    let world = |number, published| BarnWorld {
        number,
        cylinders: Vec::new(),
        course: Course::BARN,
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
        row(1, 0, RunOutcome::Reached, 10.0),
        row(1, 1, RunOutcome::Contact, 3.0),
        row(1, 2, RunOutcome::Failed, 60.0),
        row(1, 3, RunOutcome::Timeout, 100.0),
        row(2, 0, RunOutcome::Reached, 20.0),
    ];
    let summary = BarnSummary::of(&rows, &worlds);
    let (all, means) = (&summary.all, summary.over_worlds);
    assert_eq!((all.worlds, all.runs), (2, 5));
    assert_eq!((all.contacts, all.timeouts, all.failed), (1, 1, 1));
    // World 1: a quarter of 1 and of 0.5; world 2: 1 and 0.25.
    assert_eq!(
        (means.success, means.score),
        (f64::midpoint(0.25, 1.0), f64::midpoint(0.125, 0.25))
    );
    assert_eq!(all.mean_time_s, Some(15.0));
    let official = summary.official.expect("world 1 has published figures");
    assert_eq!((official.worlds, official.success, official.score), (1, 0.25, 0.125));
    let published = summary.published.expect("as above");
    assert_eq!((published.worlds, published.success, published.score), (1, 0.9, 0.2));
    let nothing = BarnSummary::of(&[], &worlds);
    assert_eq!((nothing.all.runs, nothing.over_worlds.score), (0, 0.0));
    assert!(nothing.official.is_none() && nothing.published.is_none());
}
