//! Skipping steps of a rollout changes no sample.

use inbye::bench::random_problem;
use inbye::local::internals::rollout::{
    classify, clearance_rate, evaluate_sample, skippable_steps, step_clearance, table_words,
    tabulate,
};
use inbye::local::{QuantizedProblem, SampleStatus};

/// Calls `check` with each problem, row, column and table.
fn each_sample(cases: u64, mut check: impl FnMut(&QuantizedProblem, usize, usize, &[i32])) {
    for case in 0..cases {
        let problem = QuantizedProblem::new(&random_problem(23, case)).expect("a problem in range");
        let mut table = vec![0; table_words(&problem.header)];
        for row in 0..problem.profiles.len() {
            tabulate(&problem, row, &mut table);
            for column in 0..problem.vx_samples.len() {
                check(&problem, row, column, &table);
            }
        }
    }
}

#[test]
fn skipping_steps_changes_no_sample() {
    each_sample(200, |problem, row, column, table| {
        let (header, profile) = (&problem.header, &problem.profiles[row]);
        let vx = &problem.vx_samples[column];
        let (mut min_clearance, mut free_steps) = (header.max_clearance as i32, 0);
        let mut ended_by = SampleStatus::Ok;
        for step in 0..header.steps {
            let step_result = step_clearance(problem, vx, table, step);
            if step_result.clearance <= 0 {
                ended_by = SampleStatus::Collision;
                break;
            }
            if step_result.outside {
                ended_by = SampleStatus::Outside;
                if header.stop_by_arc == 1 {
                    break;
                }
            }
            min_clearance = min_clearance.min(step_result.clearance);
            free_steps += 1;
        }
        let status = classify(header, vx, profile, ended_by, free_steps, min_clearance);
        let clearance = if status == SampleStatus::Ok { min_clearance } else { 0 };
        let outcome = evaluate_sample(problem, vx, profile, table);
        assert_eq!(outcome, (status, clearance as u32), "{row} {column}");
    });
}

#[test]
fn skippable_steps_neither_lower_the_clearance_nor_leave_the_field() {
    let (mut steps, mut skippable) = (0_u64, 0_u64);
    each_sample(60, |problem, row, column, table| {
        let (vx, profile) = (&problem.vx_samples[column], &problem.profiles[row]);
        let rate = clearance_rate(problem, vx, profile);
        let step_result = |step| step_clearance(problem, vx, table, step);
        for step in 0..problem.header.steps {
            let here = step_result(step);
            for min_clearance in [1, here.clearance / 2] {
                let count = if here.clearance > 0 && min_clearance > 0 {
                    skippable_steps(&rate, &here, min_clearance)
                } else {
                    0
                };
                steps += 1;
                skippable += u64::from(count > 0);
                let last = (step + count).min(problem.header.steps - 1);
                for other in step.saturating_sub(count)..=last {
                    let there = step_result(other);
                    let matters = there.clearance < min_clearance || there.outside && !here.outside;
                    assert!(count == 0 || !matters, "{step} {other}");
                }
            }
        }
    });
    assert!(skippable > steps / 20, "{skippable} of {steps}");
}
