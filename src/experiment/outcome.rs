//! The outcome of a run and its reason as text.

use super::contact::{Contact, TouchedBody, contact};
use super::{ContactCause, RunOutcome};
use crate::runtime::{Config, MissionResult, TraceRow};
use crate::sim::{Simulation, World};

/// How a run ended, who caused a contact, and why the goal was not reached.
pub(super) type Ended = (RunOutcome, Option<ContactCause>, Option<String>);

/// Returns the outcome of a run. Contact comes first: a robot that touches something at its goal has not reached it.
pub(super) fn outcome(simulation: &Simulation, config: &Config, result: &MissionResult) -> Ended {
    let rows = &result.trace.rows;
    let world = || {
        let known = || simulation.mission.map.obstacles(config.unknown);
        World::new(simulation.truth.clone().unwrap_or_else(known))
    };
    if result.collided {
        let (found, place) = match rows.split_last() {
            Some((last, earlier)) => {
                let (radii_m, footprint) = (&result.trace.moving_radii, &config.robot.footprint);
                let found = contact(last, earlier.last(), radii_m, footprint, &world());
                (found, place(last))
            }
            None => (None, "at the start".to_owned()),
        };
        // A contact that is not found again counts against the robot.
        let cause = found.map_or(ContactCause::Robot, |found| found.cause);
        let reason = format!("{} {place}", touched(found));
        return (RunOutcome::Contact, Some(cause), Some(reason));
    }
    if result.reached {
        return (RunOutcome::Reached, None, None);
    }
    let Some((last, earlier)) = rows.split_last() else {
        let reason = "there was no time for a tick".to_owned();
        return (RunOutcome::Timeout, None, Some(reason));
    };
    let (outcome, why) = match &result.fault {
        Some(fault) => (RunOutcome::Failed, fault.to_string()),
        None => (RunOutcome::Timeout, "the time was up".to_owned()),
    };
    // The last mode says only that the navigator gave up; the mode before is the reason.
    let mode = earlier.last().map_or(last.mode, |row| row.mode);
    let mode = serde_json::to_value(mode).unwrap_or_default();
    let mode = mode.as_str().unwrap_or_default().replace('_', " ");
    let gaps = gaps(last, result, config, &world());
    let reason = format!("{why}; {mode} {}, {gaps}", place(last));
    (outcome, None, Some(reason))
}

fn touched(found: Option<Contact>) -> String {
    let speed = |speed: Option<f64>| {
        speed.map_or_else(|| "an unknown speed".to_owned(), |speed| format!("{speed:.2} m/s"))
    };
    match found {
        Some(Contact { body: TouchedBody::Moving(number), closing_m_s, body_m_s, .. }) => format!(
            "touched moving obstacle {number}, closing in at {}, which moved at {},",
            speed(closing_m_s),
            speed(body_m_s)
        ),
        Some(_) => "touched a static obstacle".to_owned(),
        None => "touched something".to_owned(),
    }
}

fn place(row: &TraceRow) -> String {
    let pose = &row.pose;
    format!("at ({:.2}, {:.2}, {:.2})", pose.x, pose.y, pose.yaw)
}

/// The gaps to static and to moving obstacles, as text.
fn gaps(row: &TraceRow, result: &MissionResult, config: &Config, world: &World) -> String {
    let footprint = &config.robot.footprint;
    let moving = row.moving.iter().zip(&result.trace.moving_radii);
    let to_moving_m = moving
        .filter_map(|(center, &radius_m)| {
            Some(footprint.gap_to_disc_m(&row.pose, &(*center)?, radius_m))
        })
        .fold(f64::INFINITY, f64::min);
    let to_static_m = world.gap_to_static_m(footprint, &row.pose);
    let to_static = format!("gap {to_static_m:.2} m to a static obstacle");
    if to_moving_m.is_finite() {
        format!("{to_static} and {to_moving_m:.2} m to a moving one")
    } else {
        to_static
    }
}
