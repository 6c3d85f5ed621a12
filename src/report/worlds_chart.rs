//! Benchmark worlds from the easiest to the hardest: the runs that did not arrive, and the times of those that did.

use maud::{Markup, html};

use super::axis::{Axis, Tick};
use super::curves::Plot;
use super::figure::{Figure, Table, area_mark, nothing_to_show};
use super::number::{coordinate, fixed, significant};
use super::panel::{Panel, chart};
use super::world_runs::{End, World, Worlds};

const HEIGHT: f64 = 360.0;
/// Least distance of two worlds' numbers below the chart.
const LABEL_PITCH: f64 = 30.0;
/// Widest line of a world.
const WIDEST: f64 = 5.0;
/// Worlds that the text alternative names.
const NAMED: usize = 3;

const NOTHING: &str = "No world was driven.";

/// Ends of runs that did not arrive, from the axis on: class and meaning.
const MISSED: [(End, &str, &str); 4] = [
    (End::DroveInto, "end-robot", "contact: drove into something"),
    (
        End::Avoidable,
        "end-avoidable",
        "contact: run into, avoidable",
    ),
    (
        End::RunInto,
        "end-other",
        "contact: run into, not avoidable",
    ),
    (End::Stopped, "end-stopped", "gave up, or time up"),
];

pub(super) fn figure(worlds: &Worlds) -> Markup {
    let Some(plot) = plot(worlds) else {
        return nothing_to_show(worlds.title, NOTHING);
    };
    Figure {
        title: worlds.title,
        picture: chart(plot.height, &plot.alternative, &plot.content),
        legend: plot.legend(),
        caption: worlds.caption.clone(),
        table: table(worlds),
    }
    .markup()
}

/// The panels of failures and of times, one below the other; none where there is no world.
pub(super) fn plot(of: &Worlds) -> Option<Plot> {
    let count = of.ranked.len();
    if count == 0 {
        return None;
    }
    let ranks = Axis::exact(0.0, count as f64);
    let missed = Panel::across(32.0, 74.0, ranks, Axis::exact(0.0, 100.0));
    let time = Panel::across(148.0, 170.0, ranks, times_axis(of));
    let pitch = time.width / count as f64;
    let content = html! {
        (missed.axes_with(&[], None, "Runs that did not arrive, % of a world's"))
        (time.axes_with(&numbers(of, pitch), Some("Number of the world, the hardest to the right"), of.times))
        @if let Some((value, meaning)) = of.level { (level(&time, value, meaning)) }
        @for (rank, world) in of.ranked.iter().enumerate() {
            g {
                title { (said(world)) }
                (bars(&missed, rank, world, pitch))
                (spread(&time, rank, world, pitch))
            }
        }
    };
    Some(Plot {
        title: of.title,
        style: "",
        content,
        height: HEIGHT,
        keys: keys(of),
        alternative: alternative(of),
    })
}

/// From the fastest to the slowest, and to the level.
fn times_axis(of: &Worlds) -> Axis {
    let spreads = of.ranked.iter().filter_map(World::spread);
    let levels = of.level.map(|(value, _)| value);
    let values = spreads.flatten().chain(levels);
    let (least, most) = values.fold((f64::INFINITY, 0.0), |(least, most): (f64, f64), value| {
        (least.min(value), most.max(value))
    });
    if least < most {
        Axis::logarithmic(least, most)
    } else {
        Axis::logarithmic(1.0, 10.0)
    }
}

/// The numbers of as many worlds as there is room for, the hardest among them.
fn numbers(of: &Worlds, pitch: f64) -> Vec<Tick> {
    let every = libm::ceil(LABEL_PITCH / pitch).max(1.0) as usize;
    let worlds = of.ranked.iter().enumerate().rev().step_by(every);
    worlds
        .map(|(rank, world)| Tick {
            value: rank as f64 + 0.5,
            label: world.number.to_string(),
        })
        .collect()
}

/// A line over the whole width, with its meaning at the left, where the easy worlds leave room.
fn level(panel: &Panel, value: f64, meaning: &str) -> Markup {
    let y = coordinate(panel.y_at(value));
    html! {
        line class="limit" x1=(coordinate(panel.left)) x2=(coordinate(panel.right())) y1=(y) y2=(y) {}
        text class="halo" x=(coordinate(panel.left + 5.0)) y=(y) dy="-.5em" { (meaning) }
    }
}

/// The runs that did not arrive, one kind upon the other.
fn bars(panel: &Panel, rank: usize, world: &World, pitch: f64) -> Markup {
    let percent = |count: usize| 100.0 * count as f64 / world.runs.len() as f64;
    let counts = MISSED.map(|(end, ..)| world.count(end));
    // At least as wide as the eye needs where there are many worlds.
    let width = (0.8 * pitch).max(2.0);
    let left = panel.x_at(rank as f64 + 0.5) - width / 2.0;
    html! {
        @for (part, (_, class, _)) in MISSED.iter().enumerate() {
            @if counts[part] > 0 {
                @let before: usize = counts[..part].iter().sum();
                @let (bottom, top) = (panel.y_at(percent(before)), panel.y_at(percent(before + counts[part])));
                rect class=(class) x=(coordinate(left)) y=(coordinate(top)) width=(coordinate(width))
                    height=(coordinate(bottom - top)) {}
            }
        }
    }
}

/// From the fastest to the slowest run that arrived, and their median.
fn spread(panel: &Panel, rank: usize, world: &World, pitch: f64) -> Markup {
    let width = (0.45 * pitch).clamp(1.0, WIDEST);
    let x = coordinate(panel.x_at(rank as f64 + 0.5));
    html! {
        @if let Some([fastest, middle, slowest]) = world.spread() {
            line class="engine-0 spread" stroke-width=(coordinate(width)) x1=(x) x2=(x)
                y1=(coordinate(panel.y_at(fastest))) y2=(coordinate(panel.y_at(slowest))) {}
            circle class="engine-0 middle-mark" cx=(x) cy=(coordinate(panel.y_at(middle)))
                r=(coordinate((width * 0.8).max(1.4))) {}
        }
    }
}

/// Kinds of ends that occur, and the mark of times.
fn keys(of: &Worlds) -> Vec<(Markup, String)> {
    let occurs = |end| of.ranked.iter().any(|world| world.count(end) > 0);
    let missed = MISSED.iter().filter(|(end, ..)| occurs(*end));
    let mut keys: Vec<(Markup, String)> = missed
        .map(|(_, class, meaning)| (area_mark(class), (*meaning).to_owned()))
        .collect();
    let mark = html! {
        g class="engine-0" {
            line class="spread" stroke-width="3" x1="2" x2="26" y1="7" y2="7" {}
            circle class="middle-mark" cx="14" cy="7" r="3.5" {}
        }
    };
    keys.push((mark, "fastest, median, slowest run".to_owned()));
    keys
}

/// A world in a line.
fn said(world: &World) -> String {
    let (arrived, runs) = (world.count(End::Arrived), world.runs.len());
    let times = world
        .spread_s()
        .map_or_else(String::new, |[fastest, _, slowest]| {
            format!(", in {} to {} s", fixed(fastest, 1), fixed(slowest, 1))
        });
    format!(
        "world {}: {arrived} of {runs} runs arrived{times}",
        world.number
    )
}

fn alternative(of: &Worlds) -> String {
    let runs: usize = of.ranked.iter().map(|world| world.runs.len()).sum();
    let arrived: usize = of
        .ranked
        .iter()
        .map(|world| world.count(End::Arrived))
        .sum();
    let hardest: Vec<String> = of.ranked.iter().rev().take(NAMED).map(said).collect();
    format!(
        "{}: {arrived} of {runs} runs through {} worlds arrived. The hardest: {}.",
        of.title,
        of.ranked.len(),
        hardest.join("; ")
    )
}

const HEADS: [&str; 10] = [
    "world",
    "runs",
    "arrived",
    "drove into something",
    "run into, avoidable",
    "run into, not avoidable",
    "gave up, or time up",
    "fastest, s",
    "median, s",
    "slowest, s",
];
const HEADS_WITH_SCORE: [&str; 11] = {
    let [a, b, c, d, e, f, g, h, i, j] = HEADS;
    [a, b, c, d, e, f, g, h, i, j, "mean score"]
};

fn table(of: &Worlds) -> Table<'static> {
    let row = |world: &World| {
        let counts = MISSED.map(|(end, ..)| world.count(end).to_string());
        let times = world.spread_s().unwrap_or([f64::NAN; 3]).map(significant);
        let mut row = vec![
            world.number.to_string(),
            world.runs.len().to_string(),
            world.count(End::Arrived).to_string(),
        ];
        row.extend(counts);
        row.extend(times);
        if of.has_scores {
            row.push(fixed(world.mean_score(), 4));
        }
        row
    };
    Table {
        title: format!("{}, from the easiest", of.title),
        heads: if of.has_scores {
            &HEADS_WITH_SCORE
        } else {
            &HEADS
        },
        rows: of.ranked.iter().map(row).collect(),
    }
}
