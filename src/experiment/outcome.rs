//! The outcome of a run, and its reason as text.

use super::{ContactCause, RunOutcome};
use crate::geometry::Pose;
use crate::navigator::Mode;
use crate::robot::Footprint;
use crate::runtime::{Config, Contact, MissionResult, TouchedBody, TraceRow};
use crate::sim::{Simulation, World};

/// How a run ended, who caused a contact, and why the goal was not reached.
pub(super) type Ended = (RunOutcome, Option<ContactCause>, Option<String>);

/// Returns the outcome of a run. Contact comes first: a robot that touches something at its goal has not reached it.
pub(super) fn outcome(simulation: &Simulation, config: &Config, result: &MissionResult) -> Ended {
    if result.collided {
        // A contact of an unknown body counts against the robot.
        let is_by_other = result.contact.is_some_and(|contact| !contact.is_by_robot());
        let cause = if is_by_other { ContactCause::Other } else { ContactCause::Robot };
        let reason = touched(result.contact.as_ref());
        return (RunOutcome::Contact, Some(cause), Some(reason));
    }
    if result.reached {
        return (RunOutcome::Reached, None, None);
    }
    let Some((last, earlier)) = result.trace.rows.split_last() else {
        let reason = "there was no time for a tick".to_owned();
        return (RunOutcome::Timeout, None, Some(reason));
    };
    let (outcome, why) = match &result.fault {
        Some(fault) => (RunOutcome::Failed, fault.to_string()),
        None => (RunOutcome::Timeout, "the time was up".to_owned()),
    };
    // The last mode says only that the navigator gave up; the mode before is the reason.
    let before = earlier.iter().rev().find(|row| row.mode != Mode::Failed);
    let mode = before.map_or(last.mode, |row| row.mode);
    let mode = serde_json::to_value(mode).unwrap_or_default();
    let mode = mode.as_str().unwrap_or_default().replace('_', " ");
    let world = World::new(simulation.true_obstacles(config));
    let gaps = gaps(last, result, config, &world);
    let reason = format!("{why}; {mode} {}, {gaps}", place(&last.pose));
    (outcome, None, Some(reason))
}

fn touched(contact: Option<&Contact>) -> String {
    let Some(Contact { time_s, pose, body }) = contact else {
        return "touched something".to_owned();
    };
    let what = match body {
        TouchedBody::Moving { index, speed_m_s, closing_m_s } => format!(
            "moving obstacle {index}, closing in at {closing_m_s:.2} m/s, which moved at {speed_m_s:.2} m/s,"
        ),
        TouchedBody::Static => "a static obstacle".to_owned(),
    };
    format!("touched {what} {} after {time_s:.2} s", place(pose))
}

fn place(pose: &Pose) -> String {
    format!("at ({:.2}, {:.2}, {:.2})", pose.x, pose.y, pose.yaw)
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
