//! A contact of the robot, as the simulation sees it at the instant when it begins.

use core::fmt::{Display, Formatter, Result};

use crate::geometry::Pose;

/// Closing speed above which the robot's own motion closed the gap, m/s.
const CLOSING_M_S: f64 = 0.02;
/// Highest speed of a body that counts as standing, m/s.
const STANDING_M_S: f64 = 0.02;

/// The body that was touched.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum TouchedBody {
    /// A static obstacle.
    Static,
    /// A moving obstacle.
    Moving {
        /// Its index in [`GroundTruth::moving`](super::GroundTruth::moving).
        index: usize,
        /// Its speed, m/s.
        speed_m_s: f64,
        /// Highest speed at which the robot's own motion closed the gap in this control period, m/s; below zero if it backed
        /// away.
        closing_m_s: f64,
    },
}

/// The first contact of a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Time of the contact, seconds.
    pub time_s: f64,
    /// Pose of the robot at the contact.
    pub pose: Pose,
    /// The body that was touched; of several bodies, the one with the least gap.
    pub body: TouchedBody,
}

impl Display for Contact {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> Result {
        match self.body {
            TouchedBody::Moving { index, speed_m_s, closing_m_s } => {
                // A robot that stands has a speed of zero without a sign.
                let closing_m_s = (100.0 * closing_m_s).round() / 100.0 + 0.0;
                write!(
                    formatter,
                    "touched moving obstacle {index}, which moved at {speed_m_s:.2} m/s, while the robot closed in at {closing_m_s:.2} m/s,"
                )
            }
            TouchedBody::Static => write!(formatter, "touched a static obstacle"),
        }?;
        let (Pose { x, y, yaw }, time_s) = (self.pose, self.time_s);
        write!(formatter, " at ({x:.2}, {y:.2}, {yaw:.2}) after {time_s:.2} s")
    }
}

impl Contact {
    /// Whether the robot caused the contact: the body stands, or the touching part of the robot moves towards it. Otherwise only
    /// the motion of the body closed the gap.
    #[must_use]
    pub fn is_by_robot(&self) -> bool {
        match self.body {
            TouchedBody::Static => true,
            TouchedBody::Moving { speed_m_s, closing_m_s, .. } => {
                speed_m_s <= STANDING_M_S || closing_m_s > CLOSING_M_S
            }
        }
    }
}
