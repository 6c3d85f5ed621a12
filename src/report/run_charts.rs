//! The ends of runs, and the chart of benchmark worlds from the easiest to the hardest.

use std::collections::BTreeMap;

use maud::html;

use super::chart::{Axis, Bar, Chart, LabelSide, Mark, Panel, Plot, RowMark, Tick, XAxis, range};
use super::figure::{ChartFigure, Table};
use super::number::{fixed, significant};
use super::svg::LegendEntry;
use crate::experiment::{ContactCause, RunOutcome, RunRow};

/// How a run ended, as the charts distinguish it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RunEnd {
    Reached,
    /// A contact caused by the robot.
    RobotContact,
    /// A contact caused by an obstacle that the robot could have avoided.
    AvoidableContact,
    /// A contact caused by an obstacle.
    ObstacleContact,
    GaveUp,
    Timeout,
}

impl RunEnd {
    /// Every end but [`RunEnd::Reached`].
    pub(super) const MISSED: [Self; 5] = [
        Self::RobotContact,
        Self::AvoidableContact,
        Self::ObstacleContact,
        Self::GaveUp,
        Self::Timeout,
    ];

    pub(super) const fn new(row: &RunRow) -> Self {
        match (row.outcome, row.contact_cause) {
            (RunOutcome::Reached, _) => Self::Reached,
            (RunOutcome::Contact, Some(ContactCause::Avoidable)) => Self::AvoidableContact,
            (RunOutcome::Contact, Some(ContactCause::Other)) => Self::ObstacleContact,
            (RunOutcome::Contact, _) => Self::RobotContact,
            (RunOutcome::Failed | RunOutcome::Error, _) => Self::GaveUp,
            (RunOutcome::Timeout, _) => Self::Timeout,
        }
    }

    const fn class(self) -> &'static str {
        match self {
            Self::Reached => "end-reached",
            Self::RobotContact => "end-contact",
            Self::AvoidableContact => "end-avoidable",
            Self::ObstacleContact => "end-hit",
            Self::GaveUp => "end-stopped",
            Self::Timeout => "end-timeout",
        }
    }

    const fn text(self) -> &'static str {
        match self {
            Self::Reached => "reached",
            Self::RobotContact => "contact caused by the robot",
            Self::AvoidableContact => "avoidable contact caused by an obstacle",
            Self::ObstacleContact => "contact caused by an obstacle",
            Self::GaveUp => "gave up",
            Self::Timeout => "timeout",
        }
    }
}

/// The number of runs with each end.
#[derive(Clone, Copy, Default)]
pub(super) struct EndCounts([usize; 6]);

impl EndCounts {
    pub(super) fn new(counts: impl IntoIterator<Item = (RunEnd, usize)>) -> Self {
        let mut all = Self::default();
        for (end, count) in counts {
            all.0[end as usize] += count;
        }
        all
    }

    pub(super) const fn of(&self, end: RunEnd) -> usize {
        self.0[end as usize]
    }

    pub(super) fn total(&self) -> usize {
        self.0.iter().sum()
    }

    pub(super) fn missed(&self) -> usize {
        self.total() - self.of(RunEnd::Reached)
    }

    /// A count as a percentage of all.
    pub(super) fn percent(&self, count: usize) -> f64 {
        100.0 * count as f64 / self.total().max(1) as f64
    }

    /// The bar of a row in percent.
    pub(super) fn stack(&self, ends: &[RunEnd]) -> RowMark {
        let part = |end: &RunEnd| (end.class(), self.percent(self.of(*end)));
        RowMark::Stack(ends.iter().map(part).collect())
    }
}

/// The legend of the ends that occur.
pub(super) fn end_legend<'a>(
    ends: &[RunEnd],
    counts: &(impl Iterator<Item = &'a EndCounts> + Clone),
) -> Vec<LegendEntry> {
    let occurs = |end: &&RunEnd| counts.clone().any(|counts| counts.of(**end) > 0);
    let occurring = ends.iter().filter(occurs);
    occurring.map(|end| LegendEntry::area(end.class(), end.text())).collect()
}

/// The worlds of a benchmark.
pub(super) struct Worlds<'a> {
    pub(super) title: &'static str,
    /// Title of the time axis.
    pub(super) time_title: &'static str,
    /// A reference line of the time axis.
    pub(super) level: Option<(f64, &'static str)>,
    pub(super) caption: String,
    pub(super) runs: &'a [RunRow],
    /// The time of a run in the unit of the chart.
    pub(super) charted_time: fn(&RunRow) -> f64,
}

/// The runs of one world.
struct World<'a> {
    name: &'a str,
    runs: Vec<&'a RunRow>,
    charted_time: fn(&RunRow) -> f64,
    counts: EndCounts,
}

impl Worlds<'_> {
    /// The figure of the worlds.
    pub(super) fn figure(&self) -> ChartFigure {
        const READING: &str = "Worlds are sorted by their share of runs that did not reach the goal, then by their median \
            time. A dot is the median of the runs of a world that reached the goal; its line reaches from the fastest to \
            the slowest.";
        let worlds = self.sorted();
        let mut table = Table::new(
            format!("{}, from the easiest", self.title),
            &worlds,
            &[
                ("world", |world| world.name.to_owned()),
                ("runs", |world| world.runs.len().to_string()),
                ("reached", |world| world.counts.of(RunEnd::Reached).to_string()),
                ("contact caused by the robot", |world| {
                    world.counts.of(RunEnd::RobotContact).to_string()
                }),
                ("avoidable contact caused by an obstacle", |world| {
                    world.counts.of(RunEnd::AvoidableContact).to_string()
                }),
                ("contact caused by an obstacle", |world| {
                    world.counts.of(RunEnd::ObstacleContact).to_string()
                }),
                ("gave up", |world| world.counts.of(RunEnd::GaveUp).to_string()),
                ("timeout", |world| world.counts.of(RunEnd::Timeout).to_string()),
                ("fastest, s", |world| significant(world.times_s()[0])),
                ("median, s", |world| significant(world.times_s()[1])),
                ("slowest, s", |world| significant(world.times_s()[2])),
                ("mean score", |world| fixed(world.mean_score(), 4)),
            ],
        );
        if worlds.iter().all(|world| world.mean_score().is_nan()) {
            table.headers.pop();
            table.rows.iter_mut().for_each(|row| {
                row.pop();
            });
        }
        ChartFigure {
            chart: self.chart(&worlds),
            caption: format!("{} {READING}", self.caption),
            table,
        }
    }

    fn chart(&self, worlds: &[World]) -> Chart {
        if worlds.is_empty() {
            return Chart::empty(self.title, "No world was driven.");
        }
        let times = worlds.iter().filter_map(World::charted_times).flatten();
        let (least, most) =
            range(times.chain(self.level.map(|(value, _)| value))).unwrap_or((1.0, 10.0));
        let level = self
            .level
            .map(|(value, text)| Mark::Level(value, Some((LabelSide::Left, text.to_owned()))));
        let ticks = worlds
            .iter()
            .enumerate()
            .map(|(index, world)| Tick { value: index as f64 + 0.5, label: world.name.to_owned() });
        let missed = Panel {
            title: "Runs that did not reach the goal, % of each world".to_owned(),
            height: 74.0,
            y: Axis::exact(0.0, 100.0),
            marks: worlds
                .iter()
                .enumerate()
                .map(|(index, world)| Mark::Group(world.text(), world.bars(index)))
                .collect(),
        };
        let ranges = worlds.iter().enumerate().map(|(index, world)| {
            let times = world.charted_times();
            let range = times.map(|times| (index as f64 + 0.5, times));
            Mark::Group(world.text(), vec![Mark::Ranges(range.into_iter().collect())])
        });
        let time = Panel {
            title: self.time_title.to_owned(),
            height: 170.0,
            y: Axis::logarithmic(least, most),
            marks: level.into_iter().chain(ranges).collect(),
        };
        let mut legend = end_legend(&RunEnd::MISSED, &worlds.iter().map(|world| &world.counts));
        let mark = html! {
            line class="series-0 spread" stroke-width="3" x1="2" x2="26" y1="7" y2="7" {}
            circle class="series-0 middle-mark" cx="14" cy="7" r="3.5" {}
        };
        legend.push(LegendEntry::new(mark, "fastest, median, slowest run"));
        let reached = |world: &World| world.counts.of(RunEnd::Reached);
        let hardest: Vec<String> = worlds.iter().rev().take(3).map(World::text).collect();
        Chart {
            title: self.title.to_owned(),
            plot: Plot::Panels {
                x: XAxis {
                    axis: Axis::exact(0.0, worlds.len() as f64),
                    title: "World, the hardest at the right".to_owned(),
                    ticks: Some(ticks.collect()),
                },
                panels: vec![missed, time],
            },
            legend,
            alt_text: format!(
                "{}: {} of {} runs through {} worlds reached the goal. The hardest: {}.",
                self.title,
                worlds.iter().map(reached).sum::<usize>(),
                self.runs.len(),
                worlds.len(),
                hardest.join("; ")
            ),
        }
    }

    /// The worlds from the easiest to the hardest.
    fn sorted(&self) -> Vec<World<'_>> {
        let mut by_name: BTreeMap<(usize, &str), Vec<&RunRow>> = BTreeMap::new();
        for run in self.runs {
            // Numbers are sorted by their value.
            let key = (run.world.len(), run.world.as_str());
            by_name.entry(key).or_default().push(run);
        }
        let mut worlds: Vec<World> = by_name
            .into_iter()
            .map(|((_, name), runs)| World {
                name,
                counts: EndCounts::new(runs.iter().map(|run| (RunEnd::new(run), 1))),
                charted_time: self.charted_time,
                runs,
            })
            .collect();
        // A world without a run that reached the goal has no median.
        let median =
            |world: &World| world.charted_times().map_or(f64::INFINITY, |[_, median, _]| median);
        let missed = |world: &World| world.counts.percent(world.counts.missed());
        worlds.sort_by(|a, b| {
            let by_missed = missed(a).total_cmp(&missed(b));
            by_missed.then(median(a).total_cmp(&median(b)))
        });
        worlds
    }
}

impl World<'_> {
    /// Least, median and greatest charted time of the runs that reached the goal; none if no value can be charted.
    fn charted_times(&self) -> Option<[f64; 3]> {
        spread(self.reached().map(self.charted_time))
    }

    /// Least, median and greatest time, s; NaN without a run that reached the goal.
    fn times_s(&self) -> [f64; 3] {
        spread(self.reached().map(|run| run.time_s)).unwrap_or([f64::NAN; 3])
    }

    fn reached(&self) -> impl Iterator<Item = &RunRow> {
        let runs = self.runs.iter().copied();
        runs.filter(|run| run.reached())
    }

    /// NaN for a benchmark without scores.
    fn mean_score(&self) -> f64 {
        let scores = self.runs.iter().map(|run| run.score.unwrap_or(f64::NAN));
        scores.sum::<f64>() / self.runs.len() as f64
    }

    /// The bars of the runs that did not reach the goal, in percent, one on top of the other.
    fn bars(&self, index: usize) -> Vec<Mark> {
        let mut below = 0;
        let mut bars = Vec::new();
        for end in RunEnd::MISSED {
            let count = self.counts.of(end);
            if count > 0 {
                let bar = Bar {
                    x: [0.1, 0.9].map(|edge| index as f64 + edge),
                    y: [below, below + count].map(|count| self.counts.percent(count)),
                };
                bars.push(Mark::Bars(end.class().to_owned(), vec![bar]));
            }
            below += count;
        }
        bars
    }

    fn text(&self) -> String {
        let [fastest, _, slowest] = self.times_s();
        let times = if fastest.is_finite() {
            format!(", in {} to {} s", fixed(fastest, 1), fixed(slowest, 1))
        } else {
            String::new()
        };
        let (reached, runs) = (self.counts.of(RunEnd::Reached), self.runs.len());
        format!("world {}: {reached} of {runs} runs reached the goal{times}", self.name)
    }
}

/// Least, median and greatest of the positive finite values; none without any.
fn spread(values: impl Iterator<Item = f64>) -> Option<[f64; 3]> {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite() && *value > 0.0).collect();
    values.sort_by(f64::total_cmp);
    let (first, last) = (values.first()?, values.last()?);
    let median = f64::midpoint(values[(values.len() - 1) / 2], values[values.len() / 2]);
    Some([*first, median, *last])
}
