//! What the robot sees and knows at a tick.

use crate::geometry::{Pose, Twist};
use crate::localization::LostReason;
use crate::map::Scan;

/// One tick's worth of senses. The navigator knows nothing of the world beyond these and its map.
#[derive(Clone, Debug)]
pub struct Observation {
    /// Time of the tick, seconds; never less than at the tick before.
    pub time_s: f64,
    /// Where the robot is, as its localisation has it.
    pub pose: Pose,
    /// Why that is not to be believed, of a localisation that says so.
    pub lost: Option<LostReason>,
    /// How fast it moves, as its odometry has it.
    pub twist: Twist,
    /// The latest revolution of the lidar. The navigator stops when it has had none with a measurement for too long.
    pub scan: Scan,
    /// When it was measured, seconds by the clock of `time_s`; the same again where no newer has come.
    pub scan_s: f64,
}

impl Observation {
    /// Whether every number that a decision rests on is finite. Ranges may be infinite or NaN: that is how a lidar says
    /// "nothing there" and "no measurement".
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.time_s.is_finite()
            && self.scan_s.is_finite()
            && self.pose.is_finite()
            && self.twist.is_finite()
            && self.scan.is_valid()
    }
}
