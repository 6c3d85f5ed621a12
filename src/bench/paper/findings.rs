//! Findings: sentences about the figures measured on this machine.

use super::ablation::{Breakdown, Step, StepRow};
use super::reduction::{Measure, Reduction};
use super::search::{LITERAL_K, SMALL_K, Search};
use super::variants::{PathRow, THETAS, label_of};

/// Smallest reduction that counts: half of the last digit shown.
const NONE: f64 = 0.000_5;

/// A share as a signed percentage of change: a reduction is negative.
fn change(reduction: f64) -> String {
    let percent = -100.0 * reduction;
    if percent.abs() < 0.05 { "0.0 %".to_owned() } else { format!("{percent:+.1} %") }
}

/// The same with the digits that the paper prints: lengths differ by little.
fn change_of(measure: Measure, reduction: f64) -> String {
    if measure == Measure::Length {
        format!("{:+.2} %", -100.0 * reduction)
    } else {
        change(reduction)
    }
}

/// A reduction as "12.3 % less" or "12.3 % more".
fn less_or_more(reduction: f64) -> String {
    let percent = 100.0 * reduction.abs();
    if reduction.abs() < NONE {
        "as much".to_owned()
    } else if reduction > 0.0 {
        format!("{percent:.1} % less")
    } else {
        format!("{percent:.1} % more")
    }
}

/// The same for counts.
fn fewer_or_more(reduction: f64) -> String {
    less_or_more(reduction).replace("less", "fewer").replace("as much", "as many")
}

fn plain(name: &str) -> &str {
    match name {
        "manhattan" => "Manhattan",
        "euclid" => "Euclid",
        "improved" => "the improved algorithm",
        "jump_points" => "jump points, pruned and smoothed",
        other => other,
    }
}

/// The steps that the paper credits with a reduction, and their names.
const fn credited(measure: Measure) -> (&'static [Step], &'static str) {
    match measure {
        Measure::Time => (&[Step::Search], "the heuristic"),
        Measure::Length => (&[Step::Pruning], "the pruning"),
        Measure::Turns | Measure::TurnsSmoothed => {
            (&[Step::Pruning, Step::Spline], "the pruning and the spline")
        }
    }
}

/// The step that causes a reduction, and whether the paper credits the same step.
#[must_use]
pub fn origin(found: &Breakdown) -> String {
    let by_jumps = found.chain.starts_with("jump");
    let first = if by_jumps { "jump points" } else { "heuristic" };
    let name = |step: Step| match step {
        Step::Search => first,
        Step::Pruning => "pruning",
        Step::Spline => "spline",
    };
    let measure = found.measure.word();
    let parts = format!(
        "{}, {} against {}: {} in all ({first} {}, pruning {}, spline {})",
        capital(measure),
        plain(&found.chain),
        plain(&found.against),
        if found.measure == Measure::Turns {
            fewer_or_more(found.total)
        } else {
            less_or_more(found.total)
        },
        change(found.search),
        change(found.pruning),
        change(found.spline),
    );
    let main = found.main_step();
    let (credited, credited_name) = credited(found.measure);
    let the = |step: Step| match step {
        Step::Search if by_jumps => "searching by jump points".to_owned(),
        step => format!("the {}", name(step)),
    };
    let origin = if found.total < NONE && found.search >= NONE {
        let saves = if by_jumps { "jump points save" } else { "the heuristic saves" };
        format!("there is no reduction: what {saves}, the other steps spend")
    } else if found.total < NONE && found.measure == Measure::Time && !by_jumps {
        "there is no reduction, and the heuristic brings none, where the paper sees it".to_owned()
    } else if found.total < NONE {
        "there is no reduction".to_owned()
    } else if main == Step::Search && by_jumps {
        format!("it comes from {}, not from a heuristic", the(main))
    } else if credited.contains(&main) {
        format!("it comes from {}, as the paper has it", the(main))
    } else if by_jumps {
        format!("it comes from {}", the(main))
    } else {
        format!("it comes from {}, not from {credited_name}, where the paper sees it", the(main))
    };
    format!("{parts}: {origin}.")
}

/// Whether the paper's reductions are reached, for one variant.
#[must_use]
pub fn acceptance(reduction: &Reduction, targets: &[(Measure, f64)]) -> String {
    let (mut reached, mut missed) = (Vec::new(), Vec::new());
    for &(measure, target) in targets {
        let Some(found) = reduction.of(measure).of_sums else {
            continue;
        };
        let text = format!(
            "{} {} (paper {})",
            measure.word(),
            change_of(measure, found),
            change_of(measure, target)
        );
        let list = if found >= target - NONE { &mut reached } else { &mut missed };
        list.push(text);
    }
    let (variant, against) = (label_of(&reduction.variant), label_of(&reduction.against));
    let variant = capital(variant);
    match (reached.is_empty(), missed.is_empty()) {
        (_, true) => format!(
            "{variant} against {against} reaches all of the paper's reductions: {}.",
            reached.join(", ")
        ),
        (true, false) => format!(
            "{variant} against {against} reaches none of the paper's reductions: {}.",
            missed.join(", ")
        ),
        (false, false) => format!(
            "{variant} against {against} reaches the paper's {}; it misses {}.",
            reached.join(", "),
            missed.join(", ")
        ),
    }
}

/// The effect of eq. 19 as printed.
#[must_use]
pub fn literal(rows: &[StepRow]) -> Option<String> {
    let raw = |search: Search| {
        let name = search.name();
        rows.iter().find(|row| row.search == name && row.stage == "raw")
    };
    let octile = raw(Search::Theta(45.0))?;
    let weights = [LITERAL_K, SMALL_K].map(|k| raw(Search::Literal(k)).map(|row| (k, row)));
    let [large, small] = weights;
    let text = |(k, row): (f64, &StepRow)| {
        let expanded = 1.0 - row.expanded as f64 / octile.expanded.max(1) as f64;
        format!(
            "with k = {k} it expands {} cells than the octile distance alone, and its paths are {:.1} % longer than shortest \
             ones, the worst {:.1} %",
            fewer_or_more(expanded),
            100.0 * row.over_shortest,
            100.0 * row.worst_over_shortest,
        )
    };
    let (large, small) = (large?, small?);
    let is_good = |row: &StepRow| row.expanded < octile.expanded && row.over_shortest < NONE;
    let verdict = if is_good(large.1) || is_good(small.1) {
        "one of the two weights is both faster and as short."
    } else {
        "neither weight is both faster and as short."
    };
    Some(format!("Eq. 19 as printed: {}; {}: {verdict}", text(large), text(small)))
}

/// Reads a figure from a row.
type Figure = fn(&PathRow) -> f64;

/// The claim of fig. 5 about 45 degrees, and the measured result.
#[must_use]
pub fn theta(rows: &[PathRow]) -> String {
    let sum = |name: &str, figure: fn(&PathRow) -> f64| -> f64 {
        rows.iter().filter(|row| row.variant == name).map(figure).sum()
    };
    let best = |figure: fn(&PathRow) -> f64| -> (Vec<&str>, f64) {
        let sums = THETAS.map(|theta| (theta, sum(theta.name, figure)));
        let least = sums.iter().map(|(_, sum)| *sum).fold(f64::INFINITY, f64::min);
        let is_best = |(_, sum): &&_| *sum <= least * (1.0 + 1e-9);
        let names = sums.iter().filter(is_best).map(|(theta, _)| theta.label);
        (names.collect(), least)
    };
    let mut sentences = Vec::new();
    let mut is_confirmed = Vec::new();
    let figures: [(&str, &str, Figure); 3] = [
        ("least time", " ms", |row| row.time_ms.p50_ms),
        ("fewest cells expanded", "", |row| f64::from(row.expanded)),
        ("shortest", " m", |row| row.length_m),
    ];
    for (what, unit, figure) in figures {
        let (names, least) = best(figure);
        let own = sum("theta_45", figure);
        let digits = if unit.is_empty() { 0 } else { 2 };
        let is_own = names.contains(&"45 degrees");
        let other =
            if is_own { String::new() } else { format!("; 45 degrees {own:.digits$}{unit}") };
        sentences.push(format!("{what}: {} ({least:.digits$}{unit}{other})", names.join(", ")));
        if !unit.is_empty() {
            is_confirmed.push(is_own);
        }
    }
    let verdict = match is_confirmed[..] {
        [true, true] => "The paper finds 45 degrees best in both: so it is here.",
        [false, true] => "The paper finds 45 degrees best in both: here only in length.",
        [true, false] => "The paper finds 45 degrees best in both: here only in time.",
        _ => "The paper finds 45 degrees best in both: here it is in neither.",
    };
    format!("{}. {verdict}", capital(&sentences.join("; ")))
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().collect::<String>() + letters.as_str()
    })
}

#[cfg(test)]
mod tests {
    use super::super::reduction::Reduced;
    use super::*;

    fn text(chain: &str, measure: Measure, sums: [f64; 4]) -> String {
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
            variant: "improved".to_owned(),
            against: "traditional_euclid".to_owned(),
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
        assert!(
            text(-0.1, 0.0).contains("reaches none") && text(-0.1, 0.0).contains("time +10.0 %")
        );
    }

    #[test]
    fn literal_finding_depends_on_speed_and_length() {
        let row = |search: Search, expanded, over_shortest| StepRow {
            search: search.name(),
            label: String::new(),
            stage: "raw",
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
                row(Search::Theta(45.0), 100, 0.0),
                row(Search::Literal(LITERAL_K), large.0, large.1),
                row(Search::Literal(SMALL_K), small.0, small.1),
            ])
            .expect("all rows are there")
        };
        let poor = text((50, 0.07), (300, 0.0));
        assert!(poor.contains("with k = 1 it expands 50.0 % fewer cells"), "{poor}");
        assert!(poor.contains("200.0 % more cells") && poor.contains("neither weight"), "{poor}");
        assert!(text((50, 0.0), (300, 0.0)).contains("one of the two weights is both"));
        assert_eq!(literal(&[]), None);
    }
}
