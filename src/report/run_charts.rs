//! The ends of runs, and the chart of benchmark worlds from the easiest to the hardest.

use maud::html;

use super::chart::{Axis, Bar, Chart, Mark, Panel, RowMark, Tick, XAxis, range};
use super::figure::Table;
use super::number::{fixed, optional, significant};
use super::svg::LegendEntry;
use crate::bench::percentiles;
use crate::experiment::{Group, RunRow, by_world};

/// An end of runs, as the charts distinguish them.
pub(super) struct RunEnd {
    class: &'static str,
    pub(super) text: &'static str,
    count: fn(&Group) -> usize,
}

/// The end at the goal.
pub(super) const REACHED: RunEnd =
    RunEnd { class: "end-reached", text: "reached", count: |group| group.reached };

/// All other ends.
pub(super) const MISSED: [RunEnd; 5] = [
    RunEnd { class: "end-contact", text: "contact caused by the robot", count: robot_contacts },
    RunEnd {
        class: "end-avoidable",
        text: "avoidable contact caused by an obstacle",
        count: |group| group.contacts_avoidable,
    },
    RunEnd {
        class: "end-hit",
        text: "contact caused by an obstacle",
        count: |group| group.contacts_other,
    },
    RunEnd { class: "end-stopped", text: "gave up", count: |group| group.failed },
    RunEnd { class: "end-timeout", text: "timeout", count: |group| group.timeouts },
];

/// Contacts that the robot caused. A contact without a known cause counts against it.
pub(super) const fn robot_contacts(group: &Group) -> usize {
    group.contacts.saturating_sub(group.contacts_avoidable + group.contacts_other)
}

/// A number of runs of a group in percent.
pub(super) fn percent(count: usize, group: &Group) -> f64 {
    100.0 * count as f64 / group.runs.max(1) as f64
}

/// The runs that did not reach their goal, in percent.
pub(super) fn missed_percent(group: &Group) -> f64 {
    percent(group.runs - group.reached, group)
}

impl RunEnd {
    /// The bar of a row in percent.
    pub(super) fn stack<'e>(ends: impl IntoIterator<Item = &'e Self>, group: &Group) -> RowMark {
        let part = |end: &Self| (end.class, percent((end.count)(group), group));
        RowMark::Stack(ends.into_iter().map(part).collect())
    }

    /// The legend of the ends that occur.
    pub(super) fn legend<'e>(
        ends: impl IntoIterator<Item = &'e Self>,
        groups: &[&Group],
    ) -> Vec<LegendEntry> {
        let occurs = |end: &&Self| groups.iter().any(|group| (end.count)(group) > 0);
        let occurring = ends.into_iter().filter(occurs);
        occurring.map(|end| LegendEntry::area(end.class, end.text)).collect()
    }
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
struct World {
    counts: Group,
    /// Least, median and greatest time of the runs that reached the goal, s; NaN without any.
    times_s: [f64; 3],
    /// The same in the unit of the chart; none if no time can be charted.
    charted_times: Option<[f64; 3]>,
}

impl Worlds<'_> {
    /// The chart of the worlds.
    pub(super) fn chart(&self) -> Chart {
        const READING: &str = "Worlds are sorted by their share of runs that did not reach the goal, then by their median \
            time. A dot is the median of the runs of a world that reached the goal; its line reaches from the fastest to \
            the slowest.";
        let worlds = self.sorted();
        let times = worlds.iter().filter_map(|world| world.charted_times).flatten();
        let level_value = self.level.map(|(value, _)| value);
        let (least, most) = range(times.chain(level_value)).unwrap_or((1.0, 10.0));
        // The runs leave no space for a label on the line, so the legend has it.
        let level = self.level.map(|(value, _)| Mark::Level(value, None));
        let positions = || (0_u32..).map(|index| f64::from(index) + 0.5).zip(&worlds);
        let bars = positions().map(|(x, world)| Mark::Group(world.text(), world.bars(x)));
        let ranges = positions().map(|(x, world)| {
            let range = world.charted_times.map(|times| (x, times));
            Mark::Group(world.text(), vec![Mark::Ranges(range.into_iter().collect())])
        });
        let panels = vec![
            Panel::new(
                "Runs that did not reach the goal, % of each world",
                74.0,
                Axis::exact(0.0, 100.0),
                bars,
            ),
            Panel::new(
                self.time_title,
                170.0,
                Axis::logarithmic(least, most),
                level.into_iter().chain(ranges),
            ),
        ];
        let ticks =
            positions().map(|(value, world)| Tick { value, label: world.counts.name.clone() });
        let x = XAxis {
            axis: Axis::exact(0.0, worlds.len() as f64),
            title: "World, the hardest at the right",
            ticks: Some(ticks.collect()),
        };
        let counts: Vec<&Group> = worlds.iter().map(|world| &world.counts).collect();
        let hardest: Vec<String> = worlds.iter().rev().take(3).map(World::text).collect();
        let alt_text = format!(
            "{}: {} of {} runs through {} worlds reached the goal. The hardest: {}.",
            self.title,
            counts.iter().map(|counts| counts.reached).sum::<usize>(),
            self.runs.len(),
            worlds.len(),
            hardest.join("; ")
        );
        let mut legend = RunEnd::legend(&MISSED, &counts);
        let mark = html! {
            line class="series-0 spread" stroke-width="3" x1="2" x2="26" y1="7" y2="7" {}
            circle class="series-0 middle-mark" cx="14" cy="7" r="3.5" {}
        };
        legend.push(LegendEntry::new(mark, "fastest, median, slowest run"));
        legend.extend(self.level.map(|(_, text)| LegendEntry::line("limit", text)));
        Chart {
            legend,
            caption: format!("{} {READING}", self.caption),
            table: Some(self.table(&worlds)),
            ..Chart::of_panels(self.title, x, panels, alt_text)
        }
    }

    fn table(&self, worlds: &[World]) -> Table {
        let mut table = Table::new(
            format!("{}, from the easiest", self.title),
            worlds,
            &[
                ("world", |world| world.counts.name.clone()),
                ("runs", |world| world.counts.runs.to_string()),
                ("reached", |world| world.counts.reached.to_string()),
                (MISSED[0].text, |world| robot_contacts(&world.counts).to_string()),
                (MISSED[1].text, |world| world.counts.contacts_avoidable.to_string()),
                (MISSED[2].text, |world| world.counts.contacts_other.to_string()),
                (MISSED[3].text, |world| world.counts.failed.to_string()),
                (MISSED[4].text, |world| world.counts.timeouts.to_string()),
                ("fastest, s", |world| significant(world.times_s[0])),
                ("median, s", |world| significant(world.times_s[1])),
                ("slowest, s", |world| significant(world.times_s[2])),
                ("mean score", |world| optional(world.counts.mean_score, 4)),
            ],
        );
        if worlds.iter().all(|world| world.counts.mean_score.is_none()) {
            table.headers.pop();
            table.rows.iter_mut().for_each(|row| drop(row.pop()));
        }
        table
    }

    /// The worlds from the easiest to the hardest.
    fn sorted(&self) -> Vec<World> {
        let world = |(name, runs): (&str, Vec<&RunRow>)| {
            let reached = || runs.iter().filter(|run| run.reached());
            World {
                counts: Group::of(name, runs.iter().copied()),
                times_s: spread(reached().map(|run| run.time_s)).unwrap_or([f64::NAN; 3]),
                charted_times: spread(reached().map(|run| (self.charted_time)(run))),
            }
        };
        let mut worlds: Vec<World> = by_world(self.runs).into_iter().map(world).collect();
        // A world without a run that reached the goal has no median.
        let median =
            |world: &World| world.charted_times.map_or(f64::INFINITY, |[_, median, _]| median);
        worlds.sort_by(|a, b| {
            let by_missed = missed_percent(&a.counts).total_cmp(&missed_percent(&b.counts));
            by_missed.then(median(a).total_cmp(&median(b)))
        });
        worlds
    }
}

impl World {
    /// The bars of the runs that did not reach the goal, in percent, one on top of the other.
    fn bars(&self, x: f64) -> Vec<Mark> {
        let (left, mut below) = (x - 0.5, 0);
        let mut bars = Vec::new();
        for end in &MISSED {
            let count = (end.count)(&self.counts);
            if count > 0 {
                let bar = Bar {
                    x: [left + 0.1, left + 0.9],
                    y: [below, below + count].map(|count| percent(count, &self.counts)),
                };
                bars.push(Mark::Bars(end.class.to_owned(), vec![bar]));
            }
            below += count;
        }
        bars
    }

    fn text(&self) -> String {
        let Group { name, reached, runs, .. } = &self.counts;
        let [fastest, _, slowest] = self.times_s;
        let times = if fastest.is_finite() {
            format!(", in {} to {} s", fixed(fastest, 1), fixed(slowest, 1))
        } else {
            String::new()
        };
        format!("world {name}: {reached} of {runs} runs reached the goal{times}")
    }
}

/// Least, median and greatest of the positive finite values; none without any.
fn spread(values: impl Iterator<Item = f64>) -> Option<[f64; 3]> {
    let values = values.filter(|value| value.is_finite() && *value > 0.0).collect();
    let [least, median, greatest] = percentiles(values, [0.0, 0.5, 1.0]);
    Some([least?, median?, greatest?])
}
