//! A contact of the robot, as the simulation sees it at the instant when it begins.

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
