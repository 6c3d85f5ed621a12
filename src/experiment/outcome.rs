//! The outcome of a run, its reason as text, and the attribution of a contact to the robot or to what it touched.

use super::{ContactCause, RunOutcome};
use crate::geometry::{Point, Pose};
use crate::navigator::Mode;
use crate::robot::Footprint;
use crate::runtime::{Config, MissionResult, TraceRow};
use crate::sim::{Simulation, World};

/// Closing speed above which the robot's own motion closed the gap, m/s.
const CLOSING_M_S: f64 = 0.02;
/// Time between two gap checks, seconds, and their largest number: as in the simulation.
const CONTACT_STEP_S: f64 = 0.01;
const MAX_STEPS: f64 = 1000.0;
/// A gap up to this counts as the contact of a run that had one, metres: the obstacles' motion between two rows is interpolated.
const CONTACT_TOLERANCE_M: f64 = 0.002;
/// Highest speed of a body that counts as standing, m/s.
const STANDING_M_S: f64 = 0.02;

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
    let before = earlier.iter().rev().find(|row| row.mode != Mode::Failed);
    let mode = before.map_or(last.mode, |row| row.mode);
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

/// The body that was touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum TouchedBody {
    /// A static obstacle.
    Static,
    /// A moving obstacle, by its index in the row's list.
    Moving(usize),
}

/// A contact and its cause.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Contact {
    /// The body that was touched; of several bodies, the one with the least gap.
    pub body: TouchedBody,
    /// Whose motion closed the gap: the robot's or only the other's.
    pub cause: ContactCause,
    /// Speed at which the robot's own motion closed the gap, m/s; below zero if it backed away. None for a static body,
    /// which never causes a contact.
    pub closing_m_s: Option<f64>,
    /// Speed of the body, m/s; none if it was not present in the row before.
    pub body_m_s: Option<f64>,
}

/// Returns the contact at a row of a trace or since the row before it, none if there is a gap. `before` is the previous row, `radii_m` are those of
/// the moving obstacles, `world` holds the static ones.
///
/// The robot causes the contact when the body stands, or when the true velocity of the touching part of its footprint
/// towards the body's centre is above 0.02 m/s, at the row or at the previous one: the gap closed between the two.
/// Otherwise only the body's motion can have closed it.
#[must_use]
pub fn contact(
    row: &TraceRow,
    before: Option<&TraceRow>,
    radii_m: &[f64],
    footprint: &Footprint,
    world: &World,
) -> Option<Contact> {
    let instant = nearest_instant(row, before, |pose, share| {
        let to_moving_m =
            moving_at(row, before, share).zip(radii_m).filter_map(|(center, &radius_m)| {
                Some(footprint.gap_to_disc_m(pose, &center?, radius_m))
            });
        to_moving_m.fold(world.gap_to_static_m(footprint, pose), f64::min)
    });
    let (pose, share) = instant;
    let nearest = moving_at(row, before, share)
        .zip(radii_m)
        .enumerate()
        .filter_map(|(index, (center, &radius_m))| {
            let center = center?;
            Some((footprint.gap_to_disc_m(&pose, &center, radius_m), index, center))
        })
        .min_by(|one, other| one.0.total_cmp(&other.0));
    let to_ground_m = world.gap_to_static_m(footprint, &pose);
    let (gap_m, touched) = match nearest {
        Some((gap_m, index, center)) if gap_m < to_ground_m => (gap_m, Some((index, center))),
        _ => (to_ground_m, None),
    };
    if gap_m > CONTACT_TOLERANCE_M {
        return None;
    }
    let Some((index, center)) = touched else {
        return Some(Contact {
            body: TouchedBody::Static,
            cause: ContactCause::Robot,
            closing_m_s: None,
            body_m_s: Some(0.0),
        });
    };
    let was = before.and_then(|before| Some((before, (*before.moving.get(index)?)?)));
    let at_end = row.moving.get(index).copied().flatten().unwrap_or(center);
    let body_m_s = was.map(|(before, place)| {
        (at_end - place).norm() / (row.time_s - before.time_s).max(f64::MIN_POSITIVE)
    });
    let closing = |row: &TraceRow, pose: &Pose, center: &Point| {
        footprint.closing_speed_m_s(pose, &row.twist, center)
    };
    let earlier = was.map(|(before, place)| closing(before, &before.pose, &place));
    let closing_m_s = closing(row, &pose, &center);
    let closing_m_s = earlier.map_or(closing_m_s, |earlier| closing_m_s.max(earlier));
    let stands = body_m_s.is_some_and(|body_m_s| body_m_s <= STANDING_M_S);
    let cause =
        if stands || closing_m_s > CLOSING_M_S { ContactCause::Robot } else { ContactCause::Other };
    Some(Contact {
        body: TouchedBody::Moving(index),
        cause,
        closing_m_s: Some(closing_m_s),
        body_m_s,
    })
}

/// The instant between two rows at which a gap is least, checked every 10 ms: the pose, and the share of the time between the
/// rows. Of equal gaps, the last one counts. Without an earlier row it is that of the row.
pub(super) fn nearest_instant(
    row: &TraceRow,
    before: Option<&TraceRow>,
    gap_m: impl Fn(&Pose, f64) -> f64,
) -> (Pose, f64) {
    let Some(before) = before else {
        return (row.pose, 1.0);
    };
    let steps = ((row.time_s - before.time_s) / CONTACT_STEP_S).ceil().clamp(1.0, MAX_STEPS);
    let at = |step: u32| {
        let share = f64::from(step) / steps;
        (before.pose.interpolate(&row.pose, share), share)
    };
    let mut least = (gap_m(&row.pose, 1.0), (row.pose, 1.0));
    for step in (1..steps as u32).rev() {
        let (pose, share) = at(step);
        let gap_m = gap_m(&pose, share);
        if gap_m < least.0 {
            least = (gap_m, (pose, share));
        }
    }
    least.1
}

/// The centres of the moving obstacles at a share of the time between two rows.
fn moving_at<'a>(
    row: &'a TraceRow,
    before: Option<&'a TraceRow>,
    share: f64,
) -> impl Iterator<Item = Option<Point>> + 'a {
    row.moving.iter().enumerate().map(move |(index, &end)| {
        let start = before.and_then(|before| *before.moving.get(index)?);
        match (start, end) {
            (Some(start), Some(end)) => Some(start + (end - start) * share),
            _ => end,
        }
    })
}
