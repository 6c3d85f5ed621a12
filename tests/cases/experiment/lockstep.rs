//! How many steps the invocations of a wave visit together: those that are done wait for the slowest of their wave.
//!
//! The table of the book comes from `cargo test --test experiment lockstep -- --nocapture`.

use std::sync::Arc;

use inbye::bench::{Roadway, roadway_field};
use inbye::local::internals::rollout;
use inbye::local::{ClearanceField, QuantizedProblem};

/// `BAND` of `shaders/evaluate.wgsl`.
const BAND: usize = 8;
/// Ticks of the drive that are counted.
const TICKS: [usize; 10] = [0, 10, 20, 30, 40, 50, 60, 70, 80, 90];
/// Invocations of a workgroup. A wave does not reach beyond it.
const GROUP: usize = 256;

/// Speed and row of an invocation.
type Order = fn(usize, usize, usize) -> (usize, usize);

/// `sample_of` of `shaders/evaluate.wgsl`.
fn in_bands(invocation: usize, speeds: usize, rows: usize) -> (usize, usize) {
    let per_band = speeds * BAND;
    let (band, rest) = (invocation / per_band, invocation % per_band);
    let width = BAND.min(rows - band * BAND);
    (rest / width, band * BAND + rest % width)
}

fn speeds_fastest(invocation: usize, speeds: usize, _: usize) -> (usize, usize) {
    (invocation % speeds, invocation / speeds)
}

/// Number of steps that a sample visits: the loop of `evaluate_sample`.
fn visited(problem: &QuantizedProblem, speed: usize, row: usize, table: &[i32]) -> u32 {
    let header = &problem.header;
    let (vx, profile) = (&problem.vx_samples[speed], &problem.profiles[row]);
    let rate = rollout::clearance_rate(problem, vx, profile);
    let mut min_clearance = header.max_clearance as i32;
    let (mut done, mut visited) = (0, 0);
    while done < header.steps {
        let result = rollout::step_clearance(problem, vx, table, header.steps - 1 - done);
        visited += 1;
        if result.clearance <= 0 {
            break;
        }
        min_clearance = min_clearance.min(result.clearance);
        done += 1 + rollout::skippable_steps(&rate, &result, min_clearance);
    }
    visited
}

/// Share of all steps that waves of this size visit, where each takes as long as its slowest invocation.
fn lockstep_share(
    roadway: &Roadway,
    field: &Arc<ClearanceField>,
    wave: usize,
    order: Order,
) -> f64 {
    let (mut occupied, mut all) = (0_u64, 0_u64);
    for tick in TICKS {
        let problem = QuantizedProblem::new(&roadway.problem(field, tick)).expect("within ranges");
        assert_eq!(problem.header.stop_by_arc, 0, "the loop above starts at the last step");
        let (speeds, rows) = (problem.vx_samples.len(), problem.profiles.len());
        let counts: Vec<u32> = (0..rows)
            .flat_map(|row| {
                let mut table = vec![0; rollout::table_words(&problem.header)];
                rollout::tabulate(&problem, row, &mut table);
                let problem = &problem;
                (0..speeds).map(move |speed| visited(problem, speed, row, &table))
            })
            .collect();
        let in_order: Vec<u32> = (0..counts.len())
            .map(|invocation| {
                let (speed, row) = order(invocation, speeds, rows);
                counts[row * speeds + speed]
            })
            .collect();
        for group in in_order.chunks(GROUP) {
            for wave in group.chunks(wave) {
                let slowest = wave.iter().max().copied().unwrap_or_default();
                occupied += u64::from(slowest) * wave.len() as u64;
            }
        }
        all += u64::from(problem.header.steps) * counts.len() as u64;
    }
    occupied as f64 / all as f64
}

#[test]
fn order_is_a_bijection() {
    for (speeds, rows) in [(1, 1), (3, 5), (20, 8), (16, 64), (7, 33)] {
        let mut samples: Vec<_> =
            (0..speeds * rows).map(|invocation| in_bands(invocation, speeds, rows)).collect();
        samples.sort_unstable();
        samples.dedup();
        assert_eq!(samples.len(), speeds * rows);
        assert_eq!(samples.last(), Some(&(speeds - 1, rows - 1)));
    }
}

#[test]
#[expect(clippy::print_stdout, reason = "the table of the book")]
fn bands_keep_more_of_a_wave_busy() {
    let field = roadway_field();
    println!("| samples | window, s | alone | wave of 32 | of 64 | speeds fastest: 32 | 64 |");
    println!("|---|---|---|---|---|---|---|");
    for (speeds, rows, steps, window_s) in [
        (32, 32, 40, 0.1),
        (32, 32, 40, 1.0),
        (16, 64, 40, 0.1),
        (16, 64, 40, 1.0),
        (128, 128, 100, 0.1),
        (128, 128, 100, 1.0),
    ] {
        let roadway = Roadway {
            vx_samples: speeds,
            vtheta_samples: rows,
            steps,
            window_s,
            ..Roadway::default()
        };
        let share = |wave, order| lockstep_share(&roadway, &field, wave, order);
        let bands = [1, 32, 64].map(|wave| share(wave, in_bands));
        let before = [32, 64].map(|wave| share(wave, speeds_fastest));
        println!(
            "| {speeds} x {rows} x {steps} | {window_s} | {:.3} | {:.3} | {:.3} | {:.3} | {:.3} |",
            bands[0], bands[1], bands[2], before[0], before[1]
        );
        if window_s == 1.0 {
            assert!(bands[1] <= 0.6, "waves of 32 visit {:.3} of the steps", bands[1]);
            assert!(bands[1] < before[0] && bands[2] < before[1], "bands do not help");
        }
    }
}
