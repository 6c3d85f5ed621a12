//! Whether a drive kept the zones of its map.

use serde::Serialize;

use super::{ObstacleGap, Trace};
use crate::map::Zones;
use crate::robot::Footprint;

/// How a drive kept the zones, by the true poses where these are known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ZoneCompliance {
    /// Smallest gap between the body and a closed cell or the border of the map, metres; zero or less is an intrusion. Infinite,
    /// null in JSON, without closed cells.
    pub min_gap_m: f64,
    /// Number of ticks in which the body was within a closed cell.
    pub intrusions: u64,
    /// Number of ticks with the robot's origin in a zone with a speed limit.
    pub limited_ticks: u64,
    /// Largest speed above the limit of the robot's place, m/s; zero where all limits were kept.
    pub max_excess: f64,
}

impl ZoneCompliance {
    /// Measures a drive of a robot with this body and largest speed, m/s.
    #[must_use]
    pub fn of(trace: &Trace, zones: &Zones, footprint: &Footprint, max_speed: f64) -> Self {
        let gap = (!zones.is_open()).then(|| ObstacleGap::new(zones.closed()));
        let mut result =
            Self { min_gap_m: f64::INFINITY, intrusions: 0, limited_ticks: 0, max_excess: 0.0 };
        for row in &trace.rows {
            if let Some(gap) = &gap {
                let gap_m = gap.gap_m(footprint, &row.pose);
                result.min_gap_m = result.min_gap_m.min(gap_m);
                result.intrusions += u64::from(gap_m <= 0.0);
            }
            if let Some(limit) = zones.speed_limit(&row.pose.position(), max_speed) {
                result.limited_ticks += 1;
                result.max_excess = result.max_excess.max(row.twist.linear.abs() - limit);
            }
        }
        result
    }
}
