//! What sampling density is worth with each of several settings: the share of runs that reached their goal, and their times.

use maud::{Markup, html};

use super::axis::Axis;
use super::curves::{Curve, Far, Plot};
use super::figure::{Figure, Table, nothing_to_show};
use super::number::{fixed, significant};
use super::panel::{Panel, chart};
use super::samples_axis::SAMPLES;
use crate::experiment::{Group as SweepGroup, WorldKind};

const HEIGHT: f64 = 380.0;

const NOTHING: &str = "No cell has a result.";

/// The groups through worlds of one kind.
pub(super) struct SweepOf<'a> {
    pub(super) kind: WorldKind,
    groups: Vec<&'a SweepGroup>,
}

/// Groups of the same settings, weights and engine, from the fewest samples to the most.
struct Series<'a> {
    name: String,
    groups: Vec<&'a SweepGroup>,
}

/// The groups of each kind of worlds that has any.
pub(super) fn by_kind(groups: &[SweepGroup]) -> Vec<SweepOf<'_>> {
    let mut all: Vec<SweepOf> = Vec::new();
    for group in groups {
        match all.iter_mut().find(|of| of.kind == group.kind) {
            Some(of) => of.groups.push(group),
            None => all.push(SweepOf {
                kind: group.kind,
                groups: vec![group],
            }),
        }
    }
    all
}

impl SweepOf<'_> {
    /// Name of its files.
    pub(super) const fn file(&self) -> &'static str {
        match self.kind {
            WorldKind::Scenes => "groups-scenes",
            WorldKind::Map => "groups-map",
            WorldKind::Missions => "groups-missions",
            WorldKind::Barn => "groups-barn",
            WorldKind::DynaBarn => "groups-dynabarn",
        }
    }

    const fn title(&self) -> &'static str {
        match self.kind {
            WorldKind::Scenes => "Built-in scenes",
            WorldKind::Map => "Routes on maps",
            WorldKind::Missions => "Random missions",
            WorldKind::Barn => "BARN",
            WorldKind::DynaBarn => "DynaBARN",
        }
    }

    /// The rows, for its files.
    pub(super) fn rows(&self) -> Vec<SweepGroup> {
        self.groups.iter().copied().cloned().collect()
    }

    pub(super) fn figure(&self) -> Markup {
        let Some(plot) = self.plot() else {
            return nothing_to_show(self.title(), NOTHING);
        };
        Figure {
            title: self.title(),
            picture: chart(plot.height, &plot.alternative, &plot.content),
            legend: plot.legend(),
            caption:
                "Times are means over the worlds and seeds that all reached: only these compare."
                    .to_owned(),
            table: self.table(),
        }
        .markup()
    }

    /// The panels of success and of time, one below the other; none where no group can be shown.
    pub(super) fn plot(&self) -> Option<Plot> {
        let usable = || {
            self.groups
                .iter()
                .filter(|group| group.samples > 0 && group.runs > 0)
        };
        let fewest = usable().map(|group| group.samples).min()?;
        let most = usable().map(|group| group.samples).max()?;
        let samples = Axis::logarithmic(fewest as f64, most as f64);
        let least = usable()
            .map(|group| reached_percent(group))
            .fold(100.0, f64::min);
        let times = || usable().filter_map(|group| shared_time_s(group));
        let slowest_s = times().fold(0.0, f64::max);
        let fastest_s = times().fold(slowest_s, f64::min);
        let success = Panel::across(32.0, 130.0, samples, Axis::rounded(least.min(90.0), 100.0));
        let time = Panel::across(204.0, 134.0, samples, Axis::rounded(fastest_s, slowest_s));
        let series = self.series();
        let curves = |value: fn(&SweepGroup) -> Option<f64>| -> Vec<Curve> {
            let series = series.iter().enumerate();
            series
                .map(|(index, series)| series.curve(index, value))
                .collect()
        };
        let (successes, times) = (
            curves(|group| Some(reached_percent(group))),
            curves(shared_time_s),
        );
        let (shared, runs) = usable().next().map(|group| (group.shared, group.runs))?;
        let success_title = format!("Goal reached, % of {runs} runs");
        let time_title = format!("Mean time of the {shared} runs that all reached, s");
        let content = html! {
            (success.axes(None, &success_title))
            @for curve in &successes { (curve.draw(&success)) }
            (time.axes(Some(SAMPLES), &time_title))
            @for curve in &times { (curve.draw(&time)) }
        };
        Some(Plot {
            style: "",
            title: self.title(),
            content,
            height: HEIGHT,
            keys: successes
                .into_iter()
                .map(|curve| (curve.piece(), curve.name))
                .collect(),
            alternative: alternative(self.title(), &series),
        })
    }

    fn series(&self) -> Vec<Series<'_>> {
        let differs = |of: fn(&SweepGroup) -> &str| {
            self.groups
                .iter()
                .any(|group| of(group) != of(self.groups[0]))
        };
        let has_engines = differs(|group| &group.engine);
        let name = |group: &SweepGroup| {
            let engine = has_engines.then(|| group.engine.clone());
            let parts = [group.config.clone(), group.weights.clone(), engine];
            let parts: Vec<String> = parts.into_iter().flatten().collect();
            if parts.is_empty() {
                "settings of the worlds".to_owned()
            } else {
                parts.join(", ")
            }
        };
        let mut all: Vec<Series> = Vec::new();
        for group in self
            .groups
            .iter()
            .filter(|group| group.samples > 0 && group.runs > 0)
        {
            let name = name(group);
            match all.iter_mut().find(|series| series.name == name) {
                Some(series) => series.groups.push(group),
                None => all.push(Series {
                    name,
                    groups: vec![group],
                }),
            }
        }
        for series in &mut all {
            series.groups.sort_by_key(|group| group.samples);
        }
        all
    }

    fn table(&self) -> Table<'static> {
        let number = |value: Option<f64>, decimals| fixed(value.unwrap_or(f64::NAN), decimals);
        let word = |word: &Option<String>| word.clone().unwrap_or_default();
        let row = |group: &&SweepGroup| {
            vec![
                word(&group.config),
                word(&group.weights),
                group.engine.clone(),
                format!("{} x {}", group.vx_samples, group.vtheta_samples),
                group.runs.to_string(),
                group.reached.to_string(),
                group.contacts.to_string(),
                group.timeouts.to_string(),
                group.failed.to_string(),
                number(group.mean_time_s, 2),
                number(group.mean_shared_time_s, 2),
                number(group.mean_score, 4),
                number(group.mean_clearance_m, 3),
            ]
        };
        Table {
            title: self.title().to_owned(),
            heads: &[
                "settings",
                "weights",
                "engine",
                "sampling",
                "runs",
                "reached",
                "contacts",
                "time up",
                "gave up",
                "mean time, s",
                "mean time of runs that all reached, s",
                "mean score",
                "mean smallest gap, m",
            ],
            rows: self.groups.iter().map(row).collect(),
        }
    }
}

impl Series<'_> {
    fn curve(&self, index: usize, value: fn(&SweepGroup) -> Option<f64>) -> Curve {
        let point = |group: &&SweepGroup| {
            let value = value(group)?;
            Some((group.samples as f64, value, value))
        };
        Curve {
            name: self.name.clone(),
            index,
            points: self.groups.iter().filter_map(point).collect(),
            far: Far::Nothing,
        }
    }
}

fn reached_percent(group: &SweepGroup) -> f64 {
    100.0 * group.reached as f64 / group.runs as f64
}

/// The time to compare, where there is one.
fn shared_time_s(group: &SweepGroup) -> Option<f64> {
    group.mean_shared_time_s.filter(|time_s| time_s.is_finite())
}

fn alternative(title: &str, series: &[Series]) -> String {
    let said = |group: &SweepGroup| {
        let time = shared_time_s(group).map_or_else(
            || "no time".to_owned(),
            |time_s| format!("{} s", significant(time_s)),
        );
        let reached = fixed(reached_percent(group), 1);
        format!("{reached} % and {time} with {} samples", group.samples)
    };
    let words = series.iter().filter_map(|series| {
        let (first, last) = (series.groups.first()?, series.groups.last()?);
        Some(format!(
            " {}: {}, {}.",
            series.name,
            said(first),
            said(last)
        ))
    });
    format!(
        "{title}: share of runs that reached their goal, and their mean time, against the number of samples.{}",
        words.collect::<String>()
    )
}
