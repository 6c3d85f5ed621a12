//! The contributions of steps, reductions, and the sentences about them.

use inbye::bench::paper::{
    Breakdown, Measure, PUBLISHED_TABLE_1, PUBLISHED_TABLE_2, Reduced, Reduction, Search, Stage,
    StepRow, acceptance, literal, origin, published_reduction, targets,
};

#[test]
fn breakdown_steps_add_up_to_the_total() {
    let sums = [10.0, 11.0, 8.0, 7.5];
    let found = Breakdown::new("improved", "euclid", Measure::Length, sums);
    let found = found.expect("there was something before");
    assert!((found.search + found.pruning + found.spline - found.total).abs() < 1e-15);
    assert_eq!((found.total, found.main_step()), (0.25, Stage::Pruned));
    assert_eq!(Breakdown::new("", "", Measure::Turns, [0.0; 4]), None);
}

fn text(chain: &'static str, measure: Measure, sums: [f64; 4]) -> String {
    let found = Breakdown::new(chain, "euclid", measure, sums);
    origin(&found.expect("there was something before"))
}

#[test]
fn origin_names_the_heuristic() {
    assert_eq!(
        text("improved", Measure::Time, [10.0, 4.0, 4.5, 5.0]),
        "Time, the improved algorithm against Euclid: 50.0 % less in all (heuristic -60.0 %, pruning +5.0 %, spline \
         +5.0 %): it comes from the heuristic, as the paper has it."
    );
}

#[test]
fn origin_names_other_steps_than_the_paper() {
    let time = text("improved", Measure::Time, [10.0, 12.0, 13.0, 14.0]);
    assert!(
        time.ends_with(
            "40.0 % more in all (heuristic +20.0 %, pruning +10.0 %, spline +10.0 %): there is no reduction, and the \
             heuristic brings none, where the paper sees it."
        ),
        "{time}"
    );
    let spent = text("improved", Measure::Time, [10.0, 9.0, 10.0, 11.0]);
    assert!(spent.contains("what the heuristic saves, the other steps spend"), "{spent}");
    let jumps = text("jump_points", Measure::Time, [10.0, 2.0, 3.0, 3.5]);
    assert!(
        jumps.ends_with("it comes from searching by jump points, not from a heuristic."),
        "{jumps}"
    );
    let length = text("improved", Measure::Length, [100.0, 100.0, 96.0, 95.0]);
    assert!(
        length.contains("(heuristic 0.0 %, pruning -4.0 %, spline -1.0 %)")
            && length.ends_with("it comes from the pruning, as the paper has it."),
        "{length}"
    );
    let elsewhere = text("improved", Measure::Length, [100.0, 90.0, 89.0, 89.0]);
    assert!(
        elsewhere.ends_with(
            "it comes from the heuristic, not from the pruning, where the paper sees it."
        ),
        "{elsewhere}"
    );
}

#[test]
fn acceptance_lists_reached_and_missed_reductions() {
    let reduced = |share| Reduced { of_sums: Some(share), mean_of_rows: None };
    let of = |time, length| Reduction {
        variant: "improved",
        against: "traditional_euclid",
        time: reduced(time),
        length: reduced(length),
        turns: Reduced::default(),
        turns_smoothed: Reduced::default(),
    };
    let targets = [(Measure::Time, 0.56), (Measure::Length, 0.03), (Measure::Turns, 0.68)];
    let text = |time, length| acceptance(&of(time, length), &targets);
    assert_eq!(
        text(0.6, 0.04),
        "Improved against traditional, Euclid reaches all of the paper's reductions: time -60.0 % (paper -56.0 %), length \
         -4.00 % (paper -3.00 %)."
    );
    assert!(text(0.1, 0.04).contains("length -4.00 % (paper -3.00 %); it misses time -10.0 %"));
    assert!(text(-0.1, 0.0).contains("reaches none") && text(-0.1, 0.0).contains("time +10.0 %"));
}

#[test]
fn literal_finding_depends_on_speed_and_length() {
    let row = |search: Search, expanded, over_shortest| StepRow {
        search: search.name,
        label: String::new(),
        stage: Stage::Raw,
        time_ms: 1.0,
        length_m: 1.0,
        turns: 0,
        expanded,
        min_clearance_m: 1.0,
        over_shortest,
        worst_over_shortest: over_shortest,
    };
    let text = |large: (u64, f64), small: (u64, f64)| {
        literal(&[
            row(Search::THETA_45, 100, 0.0),
            row(Search::LITERAL, large.0, large.1),
            row(Search::LITERAL_SMALL, small.0, small.1),
        ])
        .expect("all rows are there")
    };
    let poor = text((50, 0.07), (300, 0.0));
    assert!(poor.contains("with k = 1 it expands 50.0 % fewer cells"), "{poor}");
    assert!(poor.contains("200.0 % more cells") && poor.contains("neither weight"), "{poor}");
    assert!(text((50, 0.0), (300, 0.0)).contains("one of the two weights is both"));
    assert_eq!(literal(&[]), None);
}

#[test]
fn published_reductions_agree_with_the_papers_text() {
    let near = |found: Option<f64>, printed: f64| {
        let found = found.expect("the table prints it");
        assert!((found - printed).abs() < 5.1e-5, "{found}, not {printed}");
    };
    let one = published_reduction(&PUBLISHED_TABLE_1);
    near(one.time.of_sums, 0.5608);
    near(one.length.of_sums, 0.0305);
    near(one.time.mean_of_rows, 0.5711);
    assert_eq!(one.turns, Reduced::default());
    let two = published_reduction(&PUBLISHED_TABLE_2);
    near(two.time.of_sums, 0.4960);
    near(two.turns.of_sums, 1.0 - 12.0 / 38.0);
    // Missing values come from the other table.
    let [_, (_, length), (_, turns), _] = targets(&PUBLISHED_TABLE_2);
    near(Some(length), 0.0305);
    near(Some(turns), 1.0 - 12.0 / 38.0);
}

#[test]
fn reduction_ignores_rows_of_zero() {
    let reduced = Reduced::of(&[0.0, 4.0], &[1.0, 1.0]);
    assert_eq!((reduced.of_sums, reduced.mean_of_rows), (Some(0.5), Some(0.75)));
    assert_eq!(Reduced::of(&[], &[]), Reduced::default());
}
