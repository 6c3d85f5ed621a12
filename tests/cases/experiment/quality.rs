//! Quality of commands from few samples: regret, and distances from the command of the densest sampling.

use std::ops::ControlFlow;

use inbye::bench::{
    QualityPlan, RegretBaseline, Roadway, grid_counts, measure_quality, percentile, roadway_field,
    usual_shape,
};
use inbye::local::internals::Header;
use inbye::local::{
    Counts, CpuEngine, Detail, Engine, Evaluation, QuantizedProblem, Sampler, Terms, Totals, Winner,
};

use crate::support::changed_engine::ChangedEngine;

/// Terms 0, 1, 2 and 5 of velocity, and 3, 3, 3 and 1 of the distance to the key node, by hand.
fn densest() -> Evaluation {
    Evaluation {
        counts: Counts { admissible: 4, collision: 9, ..Counts::default() },
        totals: Totals { sums: [0, 0, 8, 10], min: [0, 0, 0, 1], max: [0, 0, 5, 3] },
        winner: Some(Winner { index: 3, score: 0, terms: terms(5, 1) }),
        samples: None,
    }
}

fn terms(velocity: u32, path: u32) -> Terms {
    Terms { velocity, path, ..Terms::default() }
}

fn baseline(min_max: u32) -> RegretBaseline {
    let header = Header { weights: [0, 0, 3 << 28, 1 << 28], min_max, ..Header::default() };
    RegretBaseline::new(&header, &densest()).expect("it has a winner")
}

#[track_caller]
fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-7, "{found}, not {expected}");
}

#[test]
fn regret_of_the_best_is_zero_and_of_the_mean_one() {
    for min_max in [0, 1] {
        assert_near(baseline(min_max).regret(&terms(5, 1)), 0.0);
    }
    // The best score is 3/4 of 5/8 minus 1/4 of 1/10; the score of the means, 1/4 each, is 1/2 / 4.
    let best = 0.75 * 5.0 / 8.0 - 0.25 / 10.0;
    let gain = best - 0.5 / 4.0;
    let of_two = 0.75 * 2.0 / 8.0 - 0.25 * 3.0 / 10.0;
    assert_near(baseline(0).regret(&terms(2, 3)), (best - of_two) / gain);
    // 3/4 of 5/5 less a quarter of 0; the means are 2 of 5 and 1.5 above 1, of 2.
    let gain = 0.75 - (0.75 * 2.0 / 5.0 - 0.25 * 1.5 / 2.0);
    let of_two = 0.75 * 2.0 / 5.0 - 0.25;
    assert_near(baseline(1).regret(&terms(2, 3)), (0.75 - of_two) / gain);
}

#[test]
fn regret_of_a_sample_below_the_mean_exceeds_one() {
    assert!(baseline(0).regret(&terms(0, 3)) > 1.0);
}

#[test]
fn regret_of_a_better_sample_is_zero() {
    // Terms below the least and above the greatest of the densest sampling: the arithmetic must not overflow.
    for min_max in [0, 1] {
        assert_near(baseline(min_max).regret(&terms(6, 0)), 0.0);
        assert_near(baseline(min_max).regret(&terms((1 << 24) - 1, 0)), 0.0);
    }
}

#[test]
fn regret_is_zero_where_all_samples_are_equal() {
    let mut same = densest();
    (same.totals.sums, same.counts.admissible) = ([0, 0, 5, 1], 1);
    let header = Header { weights: [0, 0, 3 << 28, 1 << 28], ..Header::default() };
    let baseline = RegretBaseline::new(&header, &same).expect("it has a winner");
    assert_near(baseline.regret(&terms(1, 9)), 0.0);
}

#[test]
fn baseline_is_none_without_an_admissible_sample() {
    assert!(RegretBaseline::new(&Header::default(), &Evaluation::default()).is_none());
}

#[test]
fn grid_counts_have_the_samples_and_shape() {
    for (samples, shape, counts) in [
        (256, 1.0, (16, 16)),
        (1024, 0.25, (16, 64)),
        (1024, 4.0, (64, 16)),
        (800, 0.5, (20, 40)),
        (10, 1.0, (3, 4)),
        (1, 1.0, (1, 1)),
        (4, 1e9, (4, 1)),
        (4, 1e-9, (1, 4)),
    ] {
        assert_eq!(grid_counts(samples, shape), counts, "{samples} at {shape}");
    }
}

#[test]
fn densest_sampling_has_no_regret() {
    let plan = QualityPlan {
        steps: 10,
        densest: 64,
        samples: vec![4, 64],
        samplers: vec![(Sampler::TwoSegments, usual_shape(Sampler::TwoSegments))],
        windows_s: vec![0.1, 1.0],
        ticks: 3,
    };
    let mut ticks = 0;
    let done = || {
        ticks += 1;
        ControlFlow::Continue(())
    };
    let rows =
        measure_quality(&mut CpuEngine::single_threaded(), &plan, done).expect("a sound plan");
    assert_eq!((rows.len(), ticks), (4, 6));
    for row in &rows {
        assert_eq!(row.decisions, 3, "{row:?}");
        if row.samples == 64 {
            assert_eq!((row.regret_max, row.v_off_max_m_s), (Some(0.0), Some(0.0)));
        } else {
            assert!(row.regret_max > Some(0.0), "{row:?}");
        }
    }
}

#[test]
fn losses_are_distances_from_the_best_command() {
    let (steps, window_s, ticks) = (10, 0.1, 3);
    let plan = QualityPlan {
        steps,
        densest: 64,
        samples: vec![4],
        samplers: vec![(Sampler::TwoSegments, usual_shape(Sampler::TwoSegments))],
        windows_s: vec![window_s],
        ticks,
    };
    // It finds no command of four samples in the second decision.
    let mut decisions = 0;
    let mut engine = ChangedEngine::new(move |problem, answer| {
        if problem.len() == 4 {
            answer.winner = answer.winner.take().filter(|_| decisions != 1);
            decisions += 1;
        }
    });
    let rows =
        measure_quality(&mut engine, &plan, || ControlFlow::Continue(())).expect("a sound plan");
    let row = &rows[0];
    let field = roadway_field();
    let mut command = |samples, tick| {
        let sampler = Sampler::TwoSegments;
        let (vx_samples, vtheta_samples) = grid_counts(samples, usual_shape(sampler));
        let people = Roadway { discs: 2, people: 3, sampler, ..Roadway::default() };
        let roadway = Roadway { vx_samples, vtheta_samples, steps, window_s, ..people };
        let problem = roadway.problem(&field, tick);
        let quantized = QuantizedProblem::new(&problem).expect("within the ranges");
        let answer = engine.evaluate(&quantized, Detail::Answer).expect("the CPU answers");
        Some(problem.command(answer.winner?.index))
    };
    let (mut linear, mut angular, mut without_command) = (Vec::new(), Vec::new(), 0);
    for (number, tick) in [0, 33, 66].into_iter().enumerate() {
        let best = command(64, tick).expect("64 samples have a command");
        // The engine found none in the second decision.
        match command(4, tick).filter(|_| number != 1) {
            Some(found) => {
                linear.push((found.linear - best.linear).abs());
                angular.push((found.angular - best.angular).abs());
            }
            None => without_command += 1,
        }
    }
    assert_eq!((row.samples, row.densest), (4, 64));
    assert_eq!((row.decisions, row.without_command), (ticks, without_command));
    assert_eq!(row.v_off_p50_m_s, percentile(linear.clone(), 0.5));
    assert_eq!(row.v_off_max_m_s, percentile(linear, 1.0));
    assert_eq!(row.omega_off_p50_rad_s, percentile(angular.clone(), 0.5));
    assert_eq!(row.omega_off_max_rad_s, percentile(angular, 1.0));
    assert!(row.regret_p50 <= row.regret_max && row.regret_max >= Some(0.0), "{row:?}");
}
