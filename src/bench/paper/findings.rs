//! Findings: sentences about the figures measured on this machine.

use super::ablation::{Breakdown, StepRow};
use super::reduction::{Measure, Reduced, Reduction};
use super::search::{LITERAL_K, SMALL_K, Search, Stage, THETAS, label_of};
use super::tables::PathRow;

/// A share as a signed percentage of change: a reduction is negative.
fn change(reduction: f64) -> String {
    let percent = -100.0 * reduction;
    if percent.abs() < 0.05 { "0.0 %".to_owned() } else { format!("{percent:+.1} %") }
}

/// The same with the digits that the paper prints.
fn change_of(measure: Measure, reduction: f64) -> String {
    match measure.decimals() {
        1 => change(reduction),
        decimals => format!("{:+.decimals$} %", -100.0 * reduction),
    }
}

/// A reduction as "12.3 % less" or "12.3 % more".
fn less_or_more(reduction: f64) -> String {
    let percent = 100.0 * reduction.abs();
    if reduction.abs() < Reduced::LEAST {
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

/// The stages whose steps the paper credits with a reduction, and the names of these steps.
const fn credited(measure: Measure) -> (&'static [Stage], &'static str) {
    match measure {
        Measure::Time => (&[Stage::Raw], "the heuristic"),
        Measure::Length => (&[Stage::Pruned], "the pruning"),
        Measure::Turns | Measure::TurnsSmoothed => {
            (&[Stage::Pruned, Stage::Smoothed], "the pruning and the spline")
        }
    }
}

/// The step that causes a reduction, and whether the paper credits the same step.
#[must_use]
pub fn origin(found: &Breakdown) -> String {
    let by_jumps = found.chain == Search::JUMP_POINTS.name;
    let first = if by_jumps { "jump points" } else { "heuristic" };
    let total = match found.measure {
        Measure::Turns => fewer_or_more(found.total),
        _ => less_or_more(found.total),
    };
    let parts = format!(
        "{}, {} against {}: {total} in all ({first} {}, pruning {}, spline {})",
        capital(found.measure.word()),
        plain(found.chain),
        plain(found.against),
        change(found.search),
        change(found.pruning),
        change(found.spline),
    );
    let origin = if found.total < Reduced::LEAST && found.search >= Reduced::LEAST {
        let saves = if by_jumps { "jump points save" } else { "the heuristic saves" };
        format!("there is no reduction: what {saves}, the other steps spend")
    } else if found.total < Reduced::LEAST && found.measure == Measure::Time && !by_jumps {
        "there is no reduction, and the heuristic brings none, where the paper sees it".to_owned()
    } else if found.total < Reduced::LEAST {
        "there is no reduction".to_owned()
    } else {
        let main = found.main_step();
        let step = match main {
            Stage::Raw if by_jumps => "searching by jump points",
            Stage::Raw => "the heuristic",
            Stage::Pruned => "the pruning",
            Stage::Smoothed => "the spline",
        };
        let (credited, credited_name) = credited(found.measure);
        let opinion = if main == Stage::Raw && by_jumps {
            ", not from a heuristic".to_owned()
        } else if credited.contains(&main) {
            ", as the paper has it".to_owned()
        } else if by_jumps {
            String::new()
        } else {
            format!(", not from {credited_name}, where the paper sees it")
        };
        format!("it comes from {step}{opinion}")
    };
    format!("{parts}: {origin}.")
}

/// Whether the paper's reductions are reached, for one variant.
#[must_use]
pub fn acceptance(reduction: &Reduction, targets: &[(Measure, f64)]) -> String {
    let (mut reached, mut missed) = (Vec::new(), Vec::new());
    for &(measure, target) in targets {
        let reduced = reduction.of(measure);
        let (Some(found), Some(reaches)) = (reduced.of_sums, reduced.reaches(target)) else {
            continue;
        };
        let [text, paper] = [found, target].map(|reduction| change_of(measure, reduction));
        let list = if reaches { &mut reached } else { &mut missed };
        list.push(format!("{} {text} (paper {paper})", measure.word()));
    }
    let [variant, against] = [reduction.variant, reduction.against].map(label_of);
    let subject = format!("{} against {against}", capital(variant));
    let [met, not_met] = [&reached, &missed].map(|list| list.join(", "));
    match (reached.is_empty(), missed.is_empty()) {
        (_, true) => format!("{subject} reaches all of the paper's reductions: {met}."),
        (true, _) => format!("{subject} reaches none of the paper's reductions: {not_met}."),
        _ => format!("{subject} reaches the paper's {met}; it misses {not_met}."),
    }
}

/// The effect of eq. 19 as printed.
#[must_use]
pub fn literal(rows: &[StepRow]) -> Option<String> {
    let raw = |search: Search| {
        rows.iter().find(|row| row.search == search.name && row.stage == Stage::Raw)
    };
    let octile = raw(Search::THETA_45)?;
    let [large, small] = [raw(Search::LITERAL)?, raw(Search::LITERAL_SMALL)?];
    let text = |k: f64, row: &StepRow| {
        let expanded = 1.0 - row.expanded as f64 / octile.expanded.max(1) as f64;
        format!(
            "with k = {k} it expands {} cells than the octile distance alone, and its paths are {:.1} % longer than shortest \
             ones, the worst {:.1} %",
            fewer_or_more(expanded),
            100.0 * row.over_shortest,
            100.0 * row.worst_over_shortest,
        )
    };
    let is_good =
        |row: &StepRow| row.expanded < octile.expanded && row.over_shortest < Reduced::LEAST;
    let verdict = if is_good(large) || is_good(small) {
        "one of the two weights is both faster and as short."
    } else {
        "neither weight is both faster and as short."
    };
    let [large, small] = [text(LITERAL_K, large), text(SMALL_K, small)];
    Some(format!("Eq. 19 as printed: {large}; {small}: {verdict}"))
}

/// Reads a figure from a row.
type Figure = fn(&PathRow) -> f64;

/// The claim of fig. 5 about 45 degrees, and the measured result.
#[must_use]
pub fn theta(rows: &[PathRow]) -> String {
    let figures: [(&str, &str, usize, Figure); 3] = [
        ("least time", " ms", 2, |row| row.time_ms.p50_ms),
        ("fewest cells expanded", "", 0, |row| f64::from(row.expanded)),
        ("shortest", " m", 2, |row| row.length_m),
    ];
    let compared = figures.map(|(what, unit, digits, figure)| {
        let sums = THETAS.map(|theta| {
            let (name, label) = theta.variant;
            (label, rows.iter().filter(|row| row.variant == name).map(figure).sum::<f64>())
        });
        let least = sums.iter().map(|(_, sum)| *sum).fold(f64::INFINITY, f64::min);
        let best = sums.iter().filter(|(_, sum)| *sum <= least * (1.0 + 1e-9));
        let best: Vec<&str> = best.map(|(label, _)| *label).collect();
        let [_, (own_label, own), _] = sums;
        let is_own = best.contains(&own_label);
        let other =
            if is_own { String::new() } else { format!("; {own_label} {own:.digits$}{unit}") };
        (is_own, format!("{what}: {} ({least:.digits$}{unit}{other})", best.join(", ")))
    });
    let [(is_fastest, time), (_, cells), (is_shortest, length)] = compared;
    let verdict = match (is_fastest, is_shortest) {
        (true, true) => "so it is here",
        (false, true) => "here only in length",
        (true, false) => "here only in time",
        (false, false) => "here it is in neither",
    };
    let sentences = capital(&[time, cells, length].join("; "));
    format!("{sentences}. The paper finds 45 degrees best in both: {verdict}.")
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().collect::<String>() + letters.as_str()
    })
}
