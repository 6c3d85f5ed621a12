//! Detects a base that does not follow its commands: stuck, reversed or runaway tracks, slip, delay, low battery.

mod held_speed;

use std::collections::VecDeque;

use held_speed::HeldSpeed;
use serde::{Deserialize, Serialize};

use super::{BaseError, BaseSettings, Faults, Feedback, StopCause, Tilt};
use crate::geometry::Twist;
use crate::robot::{PerTrack, Side, TrackSpeeds, TrackedDrive};
use crate::settings::settings;

/// A track that travels less than this share of its commanded distance stands, if for long.
const STUCK_SHARE: f64 = 0.2;

/// Time after which a base whose tracks both stand, or both keep their speed, ignores its commands, as a share of the time for one
/// stuck track. It is shorter because both tracks agree.
const IGNORED_SHARE: f64 = 0.7;

/// A track that travels backwards by at least this share of its commanded distance is wired in reverse. No track coasts or rolls
/// back at half its commanded speed.
const REVERSED_SHARE: f64 = 0.5;

/// Lag with which a track is expected to follow, and with which its measured speed is smoothed, seconds: jitter of coarse
/// encoders is no travel.
const LAG_S: f64 = 0.1;

/// Age at which a sample no longer counts for a track, seconds.
const MAX_AGE_S: f64 = 10.0;

/// Longest time between two samples that counts, seconds.
const MAX_STEP_S: f64 = 0.1;

/// Largest weight of the excess speed of a runaway track: three times as fast is found in a third of the time.
const MAX_EXCESS_WEIGHT: f64 = 3.0;

/// Rate at which a symptom is forgotten while it does not show, relative to the rate at which it counts. A single sample
/// without the symptom delays its detection; it does not restart it.
const RECOVERY_RATE: f64 = 4.0;

/// Time for which commands must be delayed, seconds: a controller that is held up for a moment catches up.
const COMMAND_DELAY_S: f64 = 0.5;

/// Time for which the battery voltage must be low, seconds: it sags under load when a base starts.
const LOW_BATTERY_S: f64 = 5.0;

settings! {
    /// How far the measured motion may deviate from the command, and for how long.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct FaultDetectorSettings {
        /// Commanded speed from which a track is expected to move. Default 0.1 m/s: below it a deadband, a slope or
        /// coarse encoders may hold a sound track.
        pub motion_threshold_m_s: f64 = 0.1, ["m/s", above 0 to 1];
        /// Time of commanded motion after which a track that stands is stuck. Default 1 s: motors with a lag of 0.2 s
        /// have long moved, and blocked motors have not yet burnt out. A base whose tracks both stand or both keep their
        /// speed ignores its commands after 0.7 of this time.
        pub stuck_s: f64 = 1.0, ["s", above 0 to 5];
        /// Time after which a track that runs against its command is reversed. Default 0.5 s: commands are ramped, so
        /// that tracks follow them within a lag or two.
        pub reversed_s: f64 = 0.5, ["s", above 0 to 5];
        /// Speed by which a runaway track exceeds every recent command. Default 0.15 m/s: more than a good speed
        /// control overshoots.
        pub runaway_margin_m_s: f64 = 0.15, ["m/s", above 0 to 1];
        /// Time after which such a track has run away, and the time that counts as recent. Default 0.5 s. A track that
        /// exceeds the margin twice or three times is found in half or a third of this time.
        pub runaway_s: f64 = 0.5, ["s", above 0 to 5];
        /// Difference of the turn rates by gyro and tracks that counts as slip if it also exceeds half of the
        /// greater rate. Default 0.4 rad/s: the effective track width is known to about 10 % on one floor.
        pub slip_rate_rad_s: f64 = 0.4, ["rad/s", above 0 to 5];
        /// Time after which slip is a fault. Default 1 s: over stones a base slips for moments.
        pub slip_s: f64 = 1.0, ["s", above 0 to 5];
        /// Age at which a command that the base has not accepted is delayed; only for protocols that acknowledge
        /// commands. Default 0.2 s: ten commands, and two cycles of the slowest planner.
        pub command_delay_s: f64 = 0.2, ["s", above 0 to 5];
        /// Largest roll or pitch; only for bases that measure it. Default 0.35 rad, 20 degrees: steeper than ramps and
        /// most stairs allow.
        pub max_tilt_rad: f64 = 0.35, ["rad", above 0 to 1.57];
        /// Time after which such a tilt is a fault. Default 0.2 s: a track that climbs a stone tilts for a moment.
        pub tilt_s: f64 = 0.2, ["s", above 0 to 5];
    }
}

/// A report of the base with the command it should follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseSample {
    /// Time, seconds from any origin; never backwards.
    pub now_s: f64,
    /// The last motion sent, after all limits and ramps.
    pub sent: Twist,
    /// The latest feedback, not out of date.
    pub feedback: Feedback,
}

/// Compares a base's motion with its commands. Latches the first fault until it is released.
///
/// The commanded and the measured travel of each track are compared over the last second of commanded motion. Neither a command
/// that passes through zero nor a single wrong sample restarts that comparison. A track that slows down may be as fast as any
/// recent command.
#[derive(Clone, Debug)]
pub struct FaultDetector {
    settings: FaultDetectorSettings,
    drive: TrackedDrive,
    min_battery_v: Option<f64>,
    /// Recent commands to the tracks, the oldest first.
    recent: VecDeque<(f64, TrackSpeeds)>,
    /// Time of the last sample.
    last_s: Option<f64>,
    symptoms: Symptoms,
    cause: Option<StopCause>,
}

/// Evidence of all symptoms.
#[derive(Clone, Debug, Default)]
struct Symptoms {
    tracks: PerTrack<TrackTravel>,
    held_speed: HeldSpeed,
    slip: SymptomTimer,
    command_delay: SymptomTimer,
    low_battery: SymptomTimer,
    tilt: SymptomTimer,
}

/// Commanded and measured travel of one track.
#[derive(Clone, Debug, Default)]
struct TrackTravel {
    /// The command and the measured speed with a lag, m/s.
    expected: f64,
    smoothed: f64,
    /// Samples with commanded motion, the oldest first.
    samples: VecDeque<TravelSample>,
    too_fast: SymptomTimer,
}

/// Travel of a track in one sample.
#[derive(Clone, Copy, Debug, Default)]
struct TravelSample {
    now_s: f64,
    time_s: f64,
    /// Commanded distance, metres.
    expected_m: f64,
    /// Measured distance in either direction, at most the commanded one.
    path_m: f64,
    /// Measured distance in the direction of the command, at most the commanded one.
    along_m: f64,
}

impl TrackTravel {
    /// Takes the command and the measured speed, m/s, of a time step, seconds.
    fn update(&mut self, commanded: f64, measured: f64, (now_s, time_s): (f64, f64), least: f64) {
        let share = 1.0 - libm::exp(-time_s / LAG_S);
        self.expected += share * (commanded - self.expected);
        self.smoothed += share * (measured - self.smoothed);
        let speed = commanded.abs().min(self.expected.abs());
        if speed >= least && time_s > 0.0 {
            // While a track reverses, the direction of its motion is unknown.
            let direction = if commanded * self.expected > 0.0 { commanded.signum() } else { 0.0 };
            self.samples.push_back(TravelSample {
                now_s,
                time_s,
                expected_m: speed * time_s,
                path_m: self.smoothed.abs().min(speed) * time_s,
                along_m: (measured * direction).clamp(-speed, speed) * time_s,
            });
        }
    }

    /// Drops samples that are outside the longest window, seconds of commanded motion, or too old.
    fn drop_old(&mut self, now_s: f64, window_s: f64) {
        let mut kept_s: f64 = self.samples.iter().map(|sample| sample.time_s).sum();
        while let Some(first) = self.samples.front()
            && (kept_s - first.time_s >= window_s || now_s - first.now_s > MAX_AGE_S)
        {
            kept_s -= first.time_s;
            self.samples.pop_front();
        }
    }

    /// The travel in the last seconds of commanded motion; none if there were fewer.
    fn over(&self, window_s: f64) -> Option<TravelSample> {
        let mut sum = TravelSample::default();
        for sample in self.samples.iter().rev() {
            sum.time_s += sample.time_s;
            sum.expected_m += sample.expected_m;
            sum.path_m += sample.path_m;
            sum.along_m += sample.along_m;
            if sum.time_s >= window_s {
                return Some(sum);
            }
        }
        None
    }

    /// Whether the track stood while motion was commanded for this time, seconds.
    fn stood(&self, window_s: f64) -> bool {
        self.over(window_s).is_some_and(|sum| sum.path_m < STUCK_SHARE * sum.expected_m)
    }

    /// Whether the track ran backwards while motion was commanded for this time, seconds.
    fn ran_backwards(&self, window_s: f64) -> bool {
        self.over(window_s).is_some_and(|sum| sum.along_m <= -REVERSED_SHARE * sum.expected_m)
    }
}

/// Time for which a symptom has shown, seconds, less the time without it.
#[derive(Clone, Copy, Debug, Default)]
struct SymptomTimer(f64);

impl SymptomTimer {
    /// Adds a time step, seconds, and returns whether the symptom has shown for the given time.
    fn elapsed(&mut self, shows: bool, time_s: f64, for_s: f64) -> bool {
        self.elapsed_weighted(f64::from(u8::from(shows)), time_s, for_s)
    }

    /// As [`Self::elapsed`], for a symptom with a weight; zero if it does not show.
    fn elapsed_weighted(&mut self, weight: f64, time_s: f64, for_s: f64) -> bool {
        let rate = if weight > 0.0 { weight } else { -RECOVERY_RATE };
        self.0 = (self.0 + rate * time_s).max(0.0);
        // Time steps do not add up exactly.
        self.0 >= for_s - 1e-9
    }
}

impl FaultDetector {
    /// Creates the detector of a base that stands.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn new(base: &BaseSettings, settings: FaultDetectorSettings) -> Result<Self, BaseError> {
        base.validate()?;
        settings.validate()?;
        Ok(Self {
            settings,
            drive: base.drive(),
            min_battery_v: base.min_battery_v,
            recent: VecDeque::new(),
            last_s: None,
            symptoms: Symptoms::default(),
            cause: None,
        })
    }

    /// Takes a sample and returns the first fault since the last release, if there is one.
    ///
    /// Call it at least ten times per second. [`Faults::WATCHDOG`] alone is no fault: it ends with the next command.
    pub fn update(&mut self, sample: &BaseSample) -> Option<&StopCause> {
        let found = self.detect(sample);
        self.cause = self.cause.or(found);
        self.cause.as_ref()
    }

    /// Forgets the fault and the evidence of every symptom, as an operator's explicit decision. A fault that persists is detected again.
    pub fn release(&mut self) {
        self.cause = None;
        self.recent.clear();
        self.last_s = None;
        self.symptoms = Symptoms::default();
    }

    fn detect(&mut self, sample: &BaseSample) -> Option<StopCause> {
        let BaseSample { now_s, feedback, .. } = *sample;
        let time_s = now_s - self.last_s.replace(now_s).unwrap_or(now_s);
        if time_s > MAX_STEP_S
            && let Some(last) = self.recent.back_mut()
        {
            // The base may still follow the last command before a gap.
            last.0 = now_s;
        }
        let time_s = time_s.clamp(0.0, MAX_STEP_S);
        let commanded = self.drive.tracks(&sample.sent);
        self.recent.push_back((now_s, commanded));
        let oldest_s = now_s - self.settings.runaway_s;
        while self.recent.front().is_some_and(|(at_s, _)| *at_s < oldest_s) {
            self.recent.pop_front();
        }
        // A base may latch its emergency stop because of these: they are the cause.
        if feedback.bumper.is_pressed() {
            return Some(StopCause::Bumper { left: feedback.bumper.left });
        }
        if feedback.cliff {
            return Some(StopCause::Cliff);
        }
        if feedback.emergency_stop {
            return Some(StopCause::EmergencyStop);
        }
        let faults = feedback.faults.difference(Faults::WATCHDOG);
        if !faults.is_empty() {
            return Some(StopCause::Fault(faults));
        }
        if !feedback.twist.is_finite() {
            return Some(StopCause::NotFinite);
        }
        let measured = self.drive.tracks(&feedback.twist);
        // Every check runs in every case: no timer may stand still because another one has elapsed.
        let step = (now_s, time_s);
        let left = self.check_track(Side::Left, step, commanded.left, measured.left);
        let right = self.check_track(Side::Right, step, commanded.right, measured.right);
        let ignored = self.check_ignored(sample, time_s, left.or(right).is_some());
        let slip = self.check_slip(time_s, &feedback);
        let command_delay = self.check_command_delay(time_s, &feedback);
        let battery = self.check_battery(time_s, &feedback);
        let tilt = self.check_tilt(time_s, &feedback);
        tilt.or(ignored).or(left).or(right).or(slip).or(command_delay).or(battery)
    }

    fn check_track(
        &mut self,
        side: Side,
        (now_s, time_s): (f64, f64),
        commanded: f64,
        measured: f64,
    ) -> Option<StopCause> {
        let settings = self.settings;
        let recent = || {
            let of_side = |(_, speeds): &(f64, TrackSpeeds)| speeds.of(side);
            self.recent.iter().map(of_side)
        };
        let fastest = recent().fold(0.0, f64::max);
        let slowest = recent().fold(0.0, f64::min);
        let excess = (measured - fastest).max(slowest - measured) / settings.runaway_margin_m_s;
        let weight = if excess > 1.0 { excess.min(MAX_EXCESS_WEIGHT) } else { 0.0 };
        let travel = match side {
            Side::Left => &mut self.symptoms.tracks.left,
            Side::Right => &mut self.symptoms.tracks.right,
        };
        travel.update(commanded, measured, (now_s, time_s), settings.motion_threshold_m_s);
        travel.drop_old(now_s, settings.stuck_s.max(settings.reversed_s));
        let too_fast = travel.too_fast.elapsed_weighted(weight, time_s, settings.runaway_s);
        let against = measured * commanded < 0.0
            && measured.abs() >= REVERSED_SHARE * commanded.abs()
            && commanded.abs() >= settings.motion_threshold_m_s;
        // Under speed control swapped leads make a track ever faster: that is no runaway.
        if travel.ran_backwards(settings.reversed_s) || too_fast && against {
            Some(StopCause::Reversed { side, commanded, measured })
        } else if too_fast {
            Some(StopCause::Runaway { side, commanded, measured })
        } else if travel.stood(settings.stuck_s) {
            Some(StopCause::Stuck { side, commanded, measured })
        } else {
            None
        }
    }

    /// `is_wrong` tells whether a track does not follow its command by the other checks.
    fn check_ignored(
        &mut self,
        sample: &BaseSample,
        time_s: f64,
        is_wrong: bool,
    ) -> Option<StopCause> {
        let settings = &self.settings;
        let Symptoms { tracks: PerTrack { left, right }, held_speed, .. } = &mut self.symptoms;
        let window_s = IGNORED_SHARE * settings.stuck_s;
        let least = settings.motion_threshold_m_s;
        let stands = left.stood(window_s) && right.stood(window_s);
        let commanded = PerTrack::new(left.expected, right.expected);
        let measured = PerTrack::new(left.smoothed, right.smoothed);
        let keeps_speed = held_speed.update((commanded, measured), (time_s, window_s), least);
        // A track that keeps its speed looks like a runaway or reversed one as soon as its command is lower or reversed.
        let is_held = keeps_speed || is_wrong && held_speed.has_left(commanded, least);
        (stands || is_held).then_some(StopCause::IgnoresCommands {
            linear: sample.sent.linear,
            angular: sample.sent.angular,
            measured: sample.feedback.twist,
        })
    }

    fn check_slip(&mut self, time_s: f64, feedback: &Feedback) -> Option<StopCause> {
        let tracks = feedback.twist.angular;
        let gyro = feedback.yaw_rate.unwrap_or(tracks);
        let difference = (gyro - tracks).abs();
        let slips = difference > self.settings.slip_rate_rad_s
            && difference > 0.5 * gyro.abs().max(tracks.abs());
        self.symptoms
            .slip
            .elapsed(slips, time_s, self.settings.slip_s)
            .then_some(StopCause::Slip { tracks, gyro })
    }

    fn check_command_delay(&mut self, time_s: f64, feedback: &Feedback) -> Option<StopCause> {
        let delay_s = feedback.command_delay_s?;
        let is_delayed = delay_s > self.settings.command_delay_s;
        self.symptoms
            .command_delay
            .elapsed(is_delayed, time_s, COMMAND_DELAY_S)
            .then_some(StopCause::CommandDelay { delay_s })
    }

    fn check_battery(&mut self, time_s: f64, feedback: &Feedback) -> Option<StopCause> {
        let min = self.min_battery_v?;
        let volts = feedback.battery_v?;
        self.symptoms
            .low_battery
            .elapsed(volts < min, time_s, LOW_BATTERY_S)
            .then_some(StopCause::LowBattery { volts, min })
    }

    fn check_tilt(&mut self, time_s: f64, feedback: &Feedback) -> Option<StopCause> {
        let Tilt { roll, pitch } = feedback.tilt?;
        let max = self.settings.max_tilt_rad;
        // A tilt that is NaN is no measurement.
        let is_tilted = roll.abs().max(pitch.abs()) > max;
        self.symptoms
            .tilt
            .elapsed(is_tilted, time_s, self.settings.tilt_s)
            .then_some(StopCause::Tilt { roll, pitch, max })
    }
}
