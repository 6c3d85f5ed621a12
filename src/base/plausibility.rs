//! Whether a base does what it is told: what stuck, ran away or is wired the wrong way.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::settings::above_zero;
use super::{BaseError, BaseSettings, Faults, Feedback, Verdict};
use crate::documented::documented;
use crate::geometry::Twist;
use crate::robot::{PerTrack, Side, TrackSpeeds, TrackedDrive};

/// A track that runs slower than this share of what it was told stands, if for long.
const STANDING_SHARE: f64 = 0.1;

/// A track that runs backwards by at least this share of what it was told is wired the wrong way round, if for long. Half
/// of it is more than any track coasts or rolls back.
const REVERSED_SHARE: f64 = 0.5;

/// Commands must be late for so long, seconds: a machine that is held up for a moment catches up.
const LATE_S: f64 = 0.5;

/// Supply voltage must be low for so long, seconds: it sags under load when a base starts.
const LOW_BATTERY_S: f64 = 5.0;

documented! {
    /// How doubtful motion must be, and for how long, to be called a fault.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct PlausibilitySettings {
        /// Speed of a track, m/s, above zero, from which on it is expected to move when told so. Default 0.1 m/s: below it
        /// a deadband, a slope or coarse encoders may hold it back for good reasons.
        pub sure_to_move: f64,
        /// Time after which a track that should move and stands is stuck, seconds, above zero. Default 1 s: motors of a
        /// lag of 0.1 s have long moved, and what blocks them has not yet burnt them.
        pub stuck_s: f64,
        /// Time after which a track that runs against its command is wired the wrong way, seconds, above zero. Default 0.5 s:
        /// commands are ramped before they are sent, so that tracks follow them within a lag or two.
        pub reversed_s: f64,
        /// A track that is faster by this, m/s, above zero, than it was told at any time lately has run away. Default
        /// 0.15 m/s: more than a good speed control overshoots.
        pub runaway_speed: f64,
        /// For how long, seconds, above zero, it must have been so. Default 0.5 s, as above.
        pub runaway_s: f64,
        /// Difference of turn rates by gyro and tracks, rad/s, above zero, which is slip beyond use, where it is also half of
        /// the greater of the two. Default 0.4 rad/s: the effective width of tracks is known to some 10 % on one floor.
        pub slip_rate: f64,
        /// For how long, seconds, above zero, it must have been so. Default 1 s: over stones a base slips for moments.
        pub slip_s: f64,
        /// Age at which a command that the base has not taken is late, seconds, above zero, for a base that says what it has
        /// taken. Default 0.2 s: ten commands, and two turns of the slowest planner.
        pub late_s: f64,
    }
}

impl Default for PlausibilitySettings {
    fn default() -> Self {
        Self {
            sure_to_move: 0.1,
            stuck_s: 1.0,
            reversed_s: 0.5,
            runaway_speed: 0.15,
            runaway_s: 0.5,
            slip_rate: 0.4,
            slip_s: 1.0,
            late_s: 0.2,
        }
    }
}

impl PlausibilitySettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`BaseError::BadSetting`] names the first that is not finite and above zero.
    pub fn validate(&self) -> Result<(), BaseError> {
        for (name, value) in [
            ("sure_to_move", self.sure_to_move),
            ("stuck_s", self.stuck_s),
            ("reversed_s", self.reversed_s),
            ("runaway_speed", self.runaway_speed),
            ("runaway_s", self.runaway_s),
            ("slip_rate", self.slip_rate),
            ("slip_s", self.slip_s),
            ("late_s", self.late_s),
        ] {
            above_zero(name, value)?;
        }
        Ok(())
    }
}

/// One look at a base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// When, seconds from any origin; never backwards.
    pub now_s: f64,
    /// The motion that was last sent, after all limits and ramps.
    pub sent: Twist,
    /// The newest feedback, not out of date.
    pub feedback: Feedback,
}

/// Judges a base by what it was told and what it says, and keeps to its verdict until that is released.
///
/// Each doubt has its clock, which starts anew when the doubt ends: a track is stuck when every command of the last second
/// demanded motion and it stood all the while. Ramped commands pass through zero at a reversal, so that neither that nor a
/// start is held against a track; and one that is to slow down may be as fast as it was told to be lately.
#[derive(Clone, Debug)]
pub struct Plausibility {
    settings: PlausibilitySettings,
    drive: TrackedDrive,
    min_battery_v: Option<f64>,
    /// What the tracks were told lately, the oldest first.
    told: VecDeque<(f64, TrackSpeeds)>,
    tracks: PerTrack<Watched>,
    slipping: Since,
    late: Since,
    low_battery: Since,
    verdict: Option<Verdict>,
}

/// What is doubtful about one track.
#[derive(Clone, Copy, Debug, Default)]
struct Watched {
    standing: Since,
    reversed: Since,
    too_fast: Since,
}

/// Since when something holds without a break.
#[derive(Clone, Copy, Debug, Default)]
struct Since(Option<f64>);

impl Since {
    /// Whether it has held for so long.
    fn holds(&mut self, now: bool, now_s: f64, for_s: f64) -> bool {
        self.0 = if now { self.0.or(Some(now_s)) } else { None };
        self.0.is_some_and(|start_s| now_s - start_s >= for_s)
    }
}

impl Plausibility {
    /// A judge of a base that stands.
    ///
    /// # Errors
    /// Those of the settings' own checks.
    pub fn new(base: &BaseSettings, settings: PlausibilitySettings) -> Result<Self, BaseError> {
        base.validate()?;
        settings.validate()?;
        Ok(Self {
            settings,
            drive: base.drive(),
            min_battery_v: base.min_battery_v,
            told: VecDeque::new(),
            tracks: PerTrack::default(),
            slipping: Since::default(),
            late: Since::default(),
            low_battery: Since::default(),
            verdict: None,
        })
    }

    /// Takes a look and returns the reason to stop, if there is one: the first that was found since the last release.
    ///
    /// To be called at least ten times a second. [`Faults::WATCHDOG`] alone is no reason: it ends with the next command.
    pub fn judge(&mut self, look: &Observation) -> Option<&Verdict> {
        let found = self.look(look);
        self.verdict = self.verdict.or(found);
        self.verdict.as_ref()
    }

    /// The reason to stop, if there is one.
    #[must_use]
    pub const fn verdict(&self) -> Option<&Verdict> {
        self.verdict.as_ref()
    }

    /// Forgets the verdict and all that led to it, as an operator's explicit wish. What still holds is found again.
    pub fn release(&mut self) {
        self.verdict = None;
        self.told.clear();
        self.tracks = PerTrack::default();
        self.slipping = Since::default();
        self.late = Since::default();
        self.low_battery = Since::default();
    }

    fn look(&mut self, look: &Observation) -> Option<Verdict> {
        let Observation {
            now_s, feedback, ..
        } = *look;
        let told = self.drive.tracks(&look.sent);
        self.told.push_back((now_s, told));
        let oldest_s = now_s - self.settings.runaway_s;
        while self.told.front().is_some_and(|(at_s, _)| *at_s < oldest_s) {
            self.told.pop_front();
        }
        if feedback.emergency_stop {
            return Some(Verdict::EmergencyStop);
        }
        let faults = feedback.faults.without(Faults::WATCHDOG);
        if !faults.is_none() {
            return Some(Verdict::Fault(faults));
        }
        if !feedback.twist.is_finite() {
            return Some(Verdict::NotFinite);
        }
        let measured = self.drive.tracks(&feedback.twist);
        // All are looked at in each case: their clocks must not stand still because another one's is up.
        let left = self.track(Side::Left, now_s, told.left, measured.left);
        let right = self.track(Side::Right, now_s, told.right, measured.right);
        let slip = self.slip(now_s, &feedback);
        let late = self.lateness(now_s, &feedback);
        let battery = self.battery(now_s, &feedback);
        left.or(right).or(slip).or(late).or(battery)
    }

    fn track(&mut self, side: Side, now_s: f64, told: f64, measured: f64) -> Option<Verdict> {
        let settings = self.settings;
        let lately = || {
            let of_side = |(_, told): &(f64, TrackSpeeds)| PerTrack::from(*told).of(side);
            self.told.iter().map(of_side)
        };
        let fastest = lately().fold(0.0, f64::max);
        let slowest = lately().fold(0.0, f64::min);
        let moves = told.abs() >= settings.sure_to_move;
        let along = measured * told.signum();
        let standing = moves && along.abs() < STANDING_SHARE * told.abs();
        let against = moves && along <= -REVERSED_SHARE * told.abs();
        let too_fast = measured > fastest + settings.runaway_speed
            || measured < slowest - settings.runaway_speed;
        let watched = match side {
            Side::Left => &mut self.tracks.left,
            Side::Right => &mut self.tracks.right,
        };
        let standing = watched.standing.holds(standing, now_s, settings.stuck_s);
        let reversed = watched.reversed.holds(against, now_s, settings.reversed_s);
        let too_fast = watched.too_fast.holds(too_fast, now_s, settings.runaway_s);
        // Under a speed control swapped leads make a track ever faster: that is no runaway.
        if reversed || too_fast && against {
            Some(Verdict::Reversed {
                side,
                told,
                measured,
            })
        } else if too_fast {
            Some(Verdict::Runaway {
                side,
                told,
                measured,
            })
        } else if standing {
            Some(Verdict::Stuck {
                side,
                told,
                measured,
            })
        } else {
            None
        }
    }

    fn slip(&mut self, now_s: f64, feedback: &Feedback) -> Option<Verdict> {
        let tracks = feedback.twist.angular;
        let gyro = feedback.yaw_rate.unwrap_or(tracks);
        let apart = (gyro - tracks).abs();
        let far = apart > self.settings.slip_rate && apart > 0.5 * gyro.abs().max(tracks.abs());
        self.slipping
            .holds(far, now_s, self.settings.slip_s)
            .then_some(Verdict::Slip { tracks, gyro })
    }

    fn lateness(&mut self, now_s: f64, feedback: &Feedback) -> Option<Verdict> {
        let behind_s = feedback.behind_s?;
        self.late
            .holds(behind_s > self.settings.late_s, now_s, LATE_S)
            .then_some(Verdict::Late { behind_s })
    }

    fn battery(&mut self, now_s: f64, feedback: &Feedback) -> Option<Verdict> {
        let least = self.min_battery_v?;
        let volts = feedback.battery_v?;
        self.low_battery
            .holds(volts < least, now_s, LOW_BATTERY_S)
            .then_some(Verdict::LowBattery { volts, least })
    }
}
