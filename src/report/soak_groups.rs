//! The missions of a soak, all together and by map and people.

use std::collections::BTreeMap;

use super::row_chart::Row;
use crate::experiment::percentile;
use crate::experiment::{Group as Tally, RunRow, TrafficKind};

/// Some missions that have something in common.
pub(super) struct Group<'a> {
    part: usize,
    pub(super) label: String,
    pub(super) missions: Vec<&'a RunRow>,
    pub(super) tally: Tally,
}

/// All missions, those of each map by its name, those of each kind of people; none of no mission.
pub(super) fn groups(rows: &[RunRow]) -> Vec<Group<'_>> {
    let mut maps: BTreeMap<String, Vec<&RunRow>> = BTreeMap::new();
    let mut people: BTreeMap<TrafficKind, Vec<&RunRow>> = BTreeMap::new();
    for row in rows {
        maps.entry(row.world.clone()).or_default().push(row);
        if let Some(kind) = row.traffic {
            people.entry(kind).or_default().push(row);
        }
    }
    let all = (!rows.is_empty()).then(|| ("all missions".to_owned(), rows.iter().collect()));
    let people = people
        .into_iter()
        .map(|(people, rows)| (words(people).to_owned(), rows));
    let parts: [Vec<(String, Vec<&RunRow>)>; 3] = [
        all.into_iter().collect(),
        maps.into_iter().collect(),
        people.collect(),
    ];
    let group = |part, (label, missions): (String, Vec<_>)| Group {
        part,
        label,
        tally: Tally::of("", &missions),
        missions,
    };
    let parts = parts.into_iter().enumerate();
    parts
        .flat_map(|(part, groups)| groups.into_iter().map(move |one| group(part, one)))
        .collect()
}

const fn words(people: TrafficKind) -> &'static str {
    match people {
        TrafficKind::None => "nobody about",
        TrafficKind::Yielding => "people who mind the robot",
        TrafficKind::NonYielding => "people who mind nobody",
        TrafficKind::Appearing => "people who appear",
    }
}

impl Group<'_> {
    /// Its row in a chart.
    pub(super) fn row(&self, value: String) -> Row {
        Row {
            part: self.part,
            label: self.label.clone(),
            value,
        }
    }

    /// Least, 10th, 50th and 90th percentile, and greatest of a figure of the missions that arrived; none where none did,
    /// or a value cannot be shown.
    pub(super) fn spread(&self, figure: fn(&RunRow) -> Option<f64>) -> Option<[f64; 5]> {
        let arrived = self.missions.iter().filter(|row| row.reached());
        let values: Vec<f64> = arrived
            .filter_map(|row| figure(row))
            .filter(|value| value.is_finite() && *value > 0.0)
            .collect();
        let at = |share| percentile(values.clone(), share);
        Some([
            at(f64::MIN_POSITIVE)?,
            at(0.1)?,
            at(0.5)?,
            at(0.9)?,
            at(1.0)?,
        ])
    }
}
