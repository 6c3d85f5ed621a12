//! Can what the robot senses be believed?
//!
//! A robot that is not sure where it is, or what is about it, brakes; it goes on by itself when its senses are sound again,
//! and gives up with a reason when that takes too long.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;

use serde::{Serialize, Serializer};

use super::{NavigatorSettings, Observation};
use crate::geometry::{Pose, Twist, Vector};
use crate::localization::LostReason;
use crate::robot::Limits;

/// A localisation may correct itself by this much at once, metres, beyond what the robot can have driven since.
const CORRECTION_M: f64 = 0.5;
/// And this share of what it can drive at its limits may be exceeded by slip and noise.
const FASTER: f64 = 2.0;
/// So many poses in a row that agree about another place are believed: the robot was localised anew, or carried.
const AGREEING: u32 = 5;
/// A time this much after the one before, seconds, is a jump of the clock: scans and motion before it tell nothing of now. And
/// a robot that doubts its pose stands after so long: it does not get farther.
const CLOCK_JUMP_S: f64 = 1.0;
/// A scan may be stamped this much after its tick, seconds: two clocks are never quite equal.
const CLOCKS_DIFFER_S: f64 = 0.05;
/// A pose that stays the same to the bit for so long, seconds, while the robot is told to drive at this speed at least, m/s,
/// or to turn at this rate, rad/s, is no measurement.
const FROZEN_S: f64 = 0.5;
const DRIVES: f64 = 0.1;
const TURNS: f64 = 0.2;
/// Pose and speed are compared over so long, seconds, when the way by the speeds is at least this, metres.
const COMPARED_S: f64 = 1.0;
const COMPARED_M: f64 = 0.2;
/// So large a share of that way goes the other way by the poses where one of the two has the wrong sign.
const AGAINST: f64 = 0.5;

/// Why the senses are not believed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ObservationFault {
    /// A time, pose, speed or angle of the scan is not a finite number.
    NotFinite,
    /// The clock ran backwards or jumped, or the scan is from the future.
    Clock,
    /// No scan, none with a measurement, or an old one.
    NoScan,
    /// The localisation says that it does not know the pose, and why.
    Lost(LostReason),
    /// The pose jumped farther than the robot can drive.
    Jump,
    /// The pose does not change though the robot drives.
    Frozen,
    /// The pose moves against the speed that odometry reports.
    Reversed,
}

impl ObservationFault {
    /// Its word in JSON.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::NotFinite => "not_finite",
            Self::Clock => "clock",
            Self::NoScan => "no_scan",
            Self::Lost(LostReason::NoReturns) => "lost_blind",
            Self::Lost(LostReason::BeamsThroughWalls) => "lost_through_walls",
            Self::Lost(LostReason::PoorMatch) => "lost_unexplained",
            Self::Lost(LostReason::PoseJump) => "lost_jumped",
            Self::Lost(LostReason::HighUncertainty) => "lost_unsure",
            Self::Jump => "jump",
            Self::Frozen => "frozen",
            Self::Reversed => "reversed",
        }
    }
}

/// As one word, which may be the key of an object.
impl Serialize for ObservationFault {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

impl fmt::Display for ObservationFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Lost(why) => return write!(f, "the robot is lost: {why}"),
            Self::NotFinite => "time, pose, speed or the scan's angles are not finite",
            Self::Clock => "the clock jumped, or the scan is from the future",
            Self::NoScan => "there is no fresh scan with a measurement",
            Self::Jump => "the pose jumps farther than the robot can drive",
            Self::Frozen => {
                "the pose does not change though the robot is told to drive: odometry is frozen, or the tracks are stuck"
            }
            Self::Reversed => {
                "the pose moves against the speed that odometry reports: one of the two has the wrong sign"
            }
        })
    }
}

/// What was believed at a tick.
#[derive(Clone, Copy, Debug)]
struct Believed {
    time_s: f64,
    pose: Pose,
    twist: Twist,
}

/// Judges observations, one after the other.
#[derive(Debug, Default)]
pub(super) struct ObservationValidator {
    last: Option<Believed>,
    /// Times of the last tick, and of the last scan that measured something.
    clock_s: Option<f64>,
    scan_s: Option<f64>,
    /// Another place, and how many poses in a row agreed about it.
    elsewhere: Option<(Pose, u32)>,
    frozen_since_s: Option<f64>,
    is_frozen: bool,
    is_reversed: bool,
    recent: VecDeque<Believed>,
    doubted_in_a_row: u32,
    /// Why the last observation was not believed.
    doubt: Option<ObservationFault>,
    counts: BTreeMap<ObservationFault, u64>,
}

impl ObservationValidator {
    /// Doubted observations by why.
    pub const fn counts(&self) -> &BTreeMap<ObservationFault, u64> {
        &self.counts
    }

    /// Why the last observation was not believed; none where it was.
    pub const fn doubt(&self) -> Option<ObservationFault> {
        self.doubt
    }

    /// Observations in a row that were doubted.
    pub const fn doubted_in_a_row(&self) -> u32 {
        self.doubted_in_a_row
    }

    /// Whether to act on an observation, and whether its scan is a new one.
    pub fn judge(
        &mut self,
        seen: &Observation,
        commanded: &Twist,
        limits: &Limits,
        settings: &NavigatorSettings,
    ) -> Result<bool, ObservationFault> {
        let judged = self.check(seen, commanded, limits, settings);
        self.doubt = judged.err();
        match judged {
            Ok(_) => self.doubted_in_a_row = 0,
            Err(doubt) => {
                self.doubted_in_a_row += 1;
                *self.counts.entry(doubt).or_default() += 1;
            }
        }
        judged
    }

    fn check(
        &mut self,
        seen: &Observation,
        commanded: &Twist,
        limits: &Limits,
        settings: &NavigatorSettings,
    ) -> Result<bool, ObservationFault> {
        if !seen.is_sound() {
            return Err(ObservationFault::NotFinite);
        }
        let now_s = seen.time_s;
        let before_s = self.clock_s.replace(now_s).unwrap_or(now_s);
        let elapsed_s = now_s - before_s;
        if !(0.0..=CLOCK_JUMP_S).contains(&elapsed_s) || seen.scan_s > now_s + CLOCKS_DIFFER_S {
            self.recent.clear();
            self.frozen_since_s = None;
            // What was measured by another clock has no age in this one.
            self.scan_s = self.scan_s.filter(|scan_s| *scan_s <= now_s);
            self.last = self.last.map(|last| Believed {
                time_s: now_s,
                ..last
            });
            return Err(ObservationFault::Clock);
        }
        let measures = seen.scan.ranges.iter().any(|range| !range.is_nan());
        let is_new = measures && self.scan_s.is_none_or(|scan_s| seen.scan_s > scan_s);
        if is_new {
            self.scan_s = Some(seen.scan_s);
        }
        if self
            .scan_s
            .is_none_or(|scan_s| now_s - scan_s > settings.scan_timeout_s)
        {
            return Err(ObservationFault::NoScan);
        }
        if let Some(why) = seen.lost {
            // Where it will be found it need not have driven to.
            self.last = None;
            self.recent.clear();
            return Err(ObservationFault::Lost(why));
        }
        self.check_place(seen, limits)?;
        self.check_frozen(seen, commanded)?;
        self.check_sense(seen)?;
        Ok(is_new)
    }

    /// Refuses a pose that the robot cannot have driven to, until several agree.
    fn check_place(&mut self, seen: &Observation, limits: &Limits) -> Result<(), ObservationFault> {
        let fastest = limits.max_vel_x.max(-limits.min_vel_x);
        let is_near = |from: &Pose, elapsed_s: f64| {
            let way_m = (seen.pose.position() - from.position()).norm();
            way_m <= CORRECTION_M + FASTER * fastest * elapsed_s.min(CLOCK_JUMP_S)
        };
        let Some(last) = self.last else {
            return Ok(());
        };
        if is_near(&last.pose, seen.time_s - last.time_s) {
            self.elsewhere = None;
            return Ok(());
        }
        let agreeing = match self.elsewhere {
            Some((place, agreeing)) if is_near(&place, 0.0) => agreeing + 1,
            _ => 1,
        };
        self.elsewhere = Some((seen.pose, agreeing));
        if agreeing < AGREEING {
            return Err(ObservationFault::Jump);
        }
        self.elsewhere = None;
        self.last = None;
        self.recent.clear();
        Ok(())
    }

    fn check_frozen(
        &mut self,
        seen: &Observation,
        commanded: &Twist,
    ) -> Result<(), ObservationFault> {
        let is_same = self.last.is_some_and(|last| last.pose == seen.pose);
        let drives = commanded.linear.abs() >= DRIVES || commanded.angular.abs() >= TURNS;
        self.is_frozen &= is_same;
        if is_same && drives {
            let since_s = *self.frozen_since_s.get_or_insert(seen.time_s);
            self.is_frozen |= seen.time_s - since_s > FROZEN_S;
        } else {
            self.frozen_since_s = None;
        }
        // A robot that brakes does not drive: the doubt stays until the pose changes.
        if self.is_frozen {
            return Err(ObservationFault::Frozen);
        }
        Ok(())
    }

    /// Compares the way by poses with the way by speeds.
    fn check_sense(&mut self, seen: &Observation) -> Result<(), ObservationFault> {
        let now = Believed {
            time_s: seen.time_s,
            pose: seen.pose,
            twist: seen.twist,
        };
        self.last = Some(now);
        self.recent.push_back(now);
        while self
            .recent
            .front()
            .is_some_and(|first| now.time_s - first.time_s > COMPARED_S)
        {
            self.recent.pop_front();
        }
        // Step by step, so that to and fro does not add up to nothing.
        let (mut with_speed_m, mut by_speed_m) = (0.0, 0.0);
        for (one, next) in self.recent.iter().zip(self.recent.iter().skip(1)) {
            let (sin, cos) = libm::sincos(one.pose.yaw);
            let speed = f64::midpoint(one.twist.linear, next.twist.linear);
            let step = next.pose.position() - one.pose.position();
            with_speed_m += step.dot(&Vector::new(cos, sin)) * speed.signum();
            by_speed_m += speed.abs() * (next.time_s - one.time_s);
        }
        // A wrong sign does not mend itself; a robot that stands shows none.
        self.is_reversed |= by_speed_m > COMPARED_M && with_speed_m < -AGAINST * by_speed_m;
        if self.is_reversed {
            return Err(ObservationFault::Reversed);
        }
        Ok(())
    }
}
