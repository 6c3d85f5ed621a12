//! The outcome of a run, and its reason as text.

use serde::{Deserialize, Serialize};

use crate::robot::Footprint;
use crate::runtime::{Config, MissionEnd, MissionResult, TraceRow};
use crate::settings::words;
use crate::sim::{Simulation, World};

words! {
    /// How a run ended.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
    #[non_exhaustive]
    pub enum RunOutcome {
        /// The robot reached its goal.
        Reached = "reached",
        /// The robot and something touched.
        Contact = "contact",
        /// The time was up.
        Timeout = "timeout",
        /// The navigator gave up.
        Failed = "failed",
        /// The run did not start: a start in a wall, a map without room.
        #[default]
        Error = "error",
    }
}

impl RunOutcome {
    /// As people read it.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Reached => "reached its goal",
            Self::Contact => "touched something",
            Self::Timeout => "ran out of time",
            Self::Failed => "gave up",
            Self::Error => "did not start",
        }
    }
}

impl From<MissionEnd> for RunOutcome {
    fn from(end: MissionEnd) -> Self {
        match end {
            MissionEnd::Reached => Self::Reached,
            MissionEnd::Contact => Self::Contact,
            MissionEnd::Timeout => Self::Timeout,
            MissionEnd::Failed => Self::Failed,
        }
    }
}

/// The body whose motion caused a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ContactCause {
    /// The robot closed the gap by its own motion, or touched what does not move.
    Robot,
    /// An obstacle closed the gap, and in hindsight the robot had a command that keeps clear.
    Avoidable,
    /// An obstacle closed the gap, and no command tried keeps clear.
    Other,
}

/// How a run ended, who caused a contact, and why the goal was not reached.
pub(super) type Ended = (RunOutcome, Option<ContactCause>, Option<String>);

/// Returns the outcome of a run.
pub(super) fn outcome(simulation: &Simulation, config: &Config, result: &MissionResult) -> Ended {
    let (end, why) = (result.end(), result.why());
    if end == MissionEnd::Contact {
        // A contact of an unknown body counts against the robot.
        let is_by_other = result.contact.is_some_and(|contact| !contact.is_by_robot());
        let cause = if is_by_other { ContactCause::Other } else { ContactCause::Robot };
        return (end.into(), Some(cause), why);
    }
    if end == MissionEnd::Reached {
        return (end.into(), None, None);
    }
    let gaps = result.trace.rows.last().map_or_else(String::new, |last| {
        let world = World::new(simulation.true_obstacles(config));
        format!(", {}", gaps(last, result, config, &world))
    });
    (end.into(), None, why.map(|why| why + &gaps))
}

/// The gaps to static and to moving obstacles, as text.
fn gaps(row: &TraceRow, result: &MissionResult, config: &Config, world: &World) -> String {
    let footprint = &config.robot.footprint;
    let to_static_m = world.gap_to_static_m(footprint, &row.pose);
    let to_static = format!("gap {to_static_m:.2} m to a static obstacle");
    match gap_to_moving_m(row, &result.trace.moving_radii, footprint) {
        Some(to_moving_m) => format!("{to_static} and {to_moving_m:.2} m to a moving one"),
        None => to_static,
    }
}

/// The gap to the nearest moving obstacle, metres; none if there is none.
pub(super) fn gap_to_moving_m(
    row: &TraceRow,
    radii_m: &[f64],
    footprint: &Footprint,
) -> Option<f64> {
    let moving = row.moving.iter().zip(radii_m);
    let gaps = moving.filter_map(|(center, &radius_m)| {
        Some(footprint.gap_to_disc_m(&row.pose, center.as_ref()?, radius_m))
    });
    gaps.reduce(f64::min)
}
