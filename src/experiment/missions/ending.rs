//! How a mission ended, and why, in words.

use super::{Body, Contact, Ending, Touch};
use crate::experiment::missions::{Cause, contact};
use crate::runtime::{Config, MissionResult, TraceRow};
use crate::sim::{Simulation, World};

/// How a mission ended.
pub(in crate::experiment) struct Verdict {
    pub ending: Ending,
    pub touch: Touch,
    pub reason: Option<String>,
}

/// The verdict of a run. Contact comes first: a robot that touches something at its goal did not get there.
pub(in crate::experiment) fn verdict(
    simulation: &Simulation,
    config: &Config,
    result: &MissionResult,
) -> Verdict {
    let rows = &result.trace.rows;
    let world = || {
        let known = || simulation.mission.map.obstacles(config.unknown);
        World::new(simulation.truth.clone().unwrap_or_else(known))
    };
    let Some((last, earlier)) = rows.split_last() else {
        return Verdict {
            ending: Ending::Timeout,
            touch: Touch::None,
            reason: Some("there was no time for a tick".to_owned()),
        };
    };
    if result.collided {
        let (radii_m, footprint) = (&result.trace.moving_radii, &config.robot.footprint);
        let found = contact(last, earlier.last(), radii_m, footprint, &world());
        return Verdict {
            ending: Ending::Contact,
            touch: match found.map(|found| found.cause) {
                Some(Cause::Other) => Touch::Other,
                // A contact that cannot be found again is held against the robot.
                Some(Cause::Robot) | None => Touch::Robot,
            },
            reason: Some(format!("{} {}", touched(found), place(last))),
        };
    }
    if result.reached {
        return Verdict {
            ending: Ending::Reached,
            touch: Touch::None,
            reason: None,
        };
    }
    let beside = beside(last, result, config, &world());
    let (ending, why) = match &result.fault {
        Some(fault) => (Ending::Failed, fault.to_string()),
        None => (Ending::Timeout, "the time was up".to_owned()),
    };
    // The last mode of one that gave up says only that.
    let mode = earlier.last().map_or(last.mode, |row| row.mode);
    let mode = serde_json::to_value(mode).unwrap_or_default();
    let mode = mode.as_str().unwrap_or_default().replace('_', " ");
    Verdict {
        ending,
        touch: Touch::None,
        reason: Some(format!("{why}; {mode} {}, {beside}", place(last))),
    }
}

fn touched(found: Option<Contact>) -> String {
    let speed = |speed: Option<f64>| {
        speed.map_or_else(
            || "an unknown speed".to_owned(),
            |speed| format!("{speed:.2} m/s"),
        )
    };
    match found {
        Some(Contact {
            body: Body::Moving(number),
            closing_m_s,
            body_m_s,
            ..
        }) => format!(
            "touched moving obstacle {number}, closing in at {}, which moved at {},",
            speed(closing_m_s),
            speed(body_m_s)
        ),
        Some(_) => "touched the ground's obstacles".to_owned(),
        None => "touched something".to_owned(),
    }
}

fn place(row: &TraceRow) -> String {
    let pose = &row.pose;
    format!("at ({:.2}, {:.2}, {:.2})", pose.x, pose.y, pose.yaw)
}

/// The gaps to what stands and to what moves.
fn beside(row: &TraceRow, result: &MissionResult, config: &Config, world: &World) -> String {
    let footprint = &config.robot.footprint;
    let moving = row.moving.iter().zip(&result.trace.moving_radii);
    let to_moving_m = moving
        .filter_map(|(center, &radius_m)| {
            Some(footprint.gap_to_disc_m(&row.pose, &(*center)?, radius_m))
        })
        .fold(f64::INFINITY, f64::min);
    let to_ground_m = world.gap_to_static_m(footprint, &row.pose);
    let to_ground = format!("gap {to_ground_m:.2} m to the ground");
    if to_moving_m.is_finite() {
        format!("{to_ground} and {to_moving_m:.2} m to a moving obstacle")
    } else {
        to_ground
    }
}
