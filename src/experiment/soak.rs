//! A soak: many random missions, and what came of them all together.

use std::collections::BTreeMap;

use serde::Serialize;

use super::missions::{Comparison, Ending, MissionRow, Tally, mean};

/// Name of the settings in a soak's rows: it has no others.
pub const SOAK_SETUP: &str = "soak";

/// What came of a soak.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SoakSummary {
    /// All missions.
    #[serde(flatten)]
    pub all: Tally,
    /// Mean speed of the missions that reached their goal, m/s: all their ways by all their times.
    pub mean_speed_m_s: Option<f64>,
    /// How far from the goal they truly stood.
    pub final_error: Option<FinalError>,
    /// Way driven by all missions, metres.
    pub travelled_m: f64,
    /// Simulated time of all missions, seconds.
    pub time_s: f64,
    /// Each map, by name.
    pub maps: Vec<Part>,
    /// Each kind of moving obstacles.
    pub people: Vec<Part>,
    /// Missions driven again on another engine.
    pub digests_compared: usize,
    /// Those of them with the same trace, to the last bit.
    pub digests_equal: usize,
}

/// A part of the missions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Part {
    /// Which.
    pub name: String,
    /// What came of it.
    #[serde(flatten)]
    pub tally: Tally,
}

/// True distance from the goal where it was reached.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FinalError {
    /// Mean distance, metres.
    pub mean_m: f64,
    /// 95th percentile, metres.
    pub p95_m: f64,
    /// Mean of the yaw's error either way, radians.
    pub mean_yaw_rad: f64,
    /// Its 95th percentile, radians.
    pub p95_yaw_rad: f64,
}

impl SoakSummary {
    /// The summary of rows, some of which were compared.
    #[must_use]
    pub fn of(rows: &[&MissionRow], comparisons: &[Comparison]) -> Self {
        let reached = || rows.iter().filter(|row| row.result == Ending::Reached);
        let sum = |figure: fn(&MissionRow) -> f64| -> f64 {
            reached().map(|row| figure(row)).sum::<f64>()
        };
        let (way_m, time_s) = (sum(|row| row.travelled_m), sum(|row| row.time_s));
        Self {
            all: Tally::of(rows),
            mean_speed_m_s: (time_s > 0.0).then(|| way_m / time_s),
            final_error: final_error(reached().copied()),
            travelled_m: rows.iter().map(|row| row.travelled_m).sum::<f64>(),
            time_s: rows.iter().map(|row| row.time_s).sum::<f64>(),
            maps: parts(rows, |row| row.map.clone()),
            people: parts(rows, |row| {
                let word = serde_json::to_value(row.people).unwrap_or_default();
                word.as_str().unwrap_or_default().to_owned()
            }),
            digests_compared: comparisons.len(),
            digests_equal: comparisons.iter().filter(|one| one.equal).count(),
        }
    }

    /// Whether the robot caused no contact, every unreached goal has a reason, and every digest compared is the same.
    #[must_use]
    pub const fn is_sound(&self) -> bool {
        self.all.contacts_robot == 0
            && self.all.unexplained == 0
            && self.digests_equal == self.digests_compared
    }
}

fn parts(rows: &[&MissionRow], name: impl Fn(&MissionRow) -> String) -> Vec<Part> {
    let mut by_name: BTreeMap<String, Vec<&MissionRow>> = BTreeMap::new();
    for row in rows {
        by_name.entry(name(row)).or_default().push(row);
    }
    let part = |(name, rows): (String, Vec<&MissionRow>)| Part {
        name,
        tally: Tally::of(&rows),
    };
    by_name.into_iter().map(part).collect()
}

fn final_error<'a>(reached: impl Iterator<Item = &'a MissionRow> + Clone) -> Option<FinalError> {
    let far_m: Vec<f64> = reached.clone().map(|row| row.final_error_m).collect();
    let yaws: Vec<f64> = reached
        .filter_map(|row| row.final_yaw_error_rad)
        .map(f64::abs)
        .collect();
    Some(FinalError {
        mean_m: mean(far_m.iter().copied())?,
        p95_m: percentile(far_m, 0.95)?,
        mean_yaw_rad: mean(yaws.iter().copied())?,
        p95_yaw_rad: percentile(yaws, 0.95)?,
    })
}

/// The least value that at least this share, above 0 and up to 1, does not exceed.
pub(crate) fn percentile(mut values: Vec<f64>, share: f64) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let rank = libm::ceil(share * values.len() as f64) as usize;
    values.get(rank.max(1) - 1).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_values_that_occurred() {
        let values = || (1..=20).rev().map(f64::from).collect();
        assert_eq!(percentile(values(), 0.95), Some(19.0));
        assert_eq!(percentile(values(), 1.0), Some(20.0));
        assert_eq!(percentile(values(), 0.01), Some(1.0));
        assert_eq!(percentile(Vec::new(), 0.5), None);
    }
}
