//! `inbye base calibrate`: turns a base on the spot, drives it a metre, and prints the settings that follow.

use std::f64::consts::TAU;
use std::io::{IsTerminal, Write, stdin};

use anyhow::{bail, ensure};
use clap::Args;
use inbye::base::{BaseSettings, BaseSupervisor, SupervisorStatus};
use inbye::geometry::Twist;
use inbye::robot::{Limits, MotionEstimate, MotionIdentifier, PerTrack, travel_m};
use inbye::runtime::hardware::stop_cause;
use serde_json::{Value, json};

use super::arguments::{above_zero, real};
use super::base::{self, LineArguments};
use super::output;

/// Turn rate, rad/s, and speed, m/s, of the two motions: slow enough for any floor.
const TURN_RATE: f64 = 0.5;
const SPEED: f64 = 0.2;

/// Time for which the base stands before and after a motion, seconds.
const PAUSE_S: f64 = 1.0;

/// Longest time of a motion, as a multiple of the one that the command takes.
const LONGEST: f64 = 3.0;

/// Largest rate of the gyro while the base stands, rad/s. A gyro that reads more was not zeroed, and its scale may be wrong as well.
const MAX_GYRO_BIAS: f64 = 0.1;

/// Largest change of that rate during a turn, rad/s: it changes `effective_width_ratio` by 2 %.
const MAX_GYRO_DRIFT: f64 = 0.02 * TURN_RATE;

/// Time at a standstill after which the gyro shows its bias, seconds: a body rocks when it stops.
const SETTLED_S: f64 = 0.3;

/// Assumed latency before it is identified, seconds. It affects nothing here.
const ASSUMED_S: f64 = 0.3;

/// `inbye base calibrate`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye base calibrate --port /dev/ttyUSB0 --protocol wheeltec --turned 342 --driven 0.98\n\n\
    The base turns on the spot by its encoders and drives straight ahead. It needs 1 m of free floor on all sides and as far \
    ahead as it drives, and an operator at the emergency stop. A gyro measures the real turn, less the rate that it \
    reads while the base stands; without one, measure the turn by a \
    mark on the floor and give it with --turned. Measure the distance with a tape and give it with --driven.\n\
    The settings to paste into the file of --base-config are printed, and the latency for [navigator] actuation_delay_s.\n\
    Exit status 1: the base was stopped, the line was lost, a motion was not completed, the gyro is not usable, or a signal came. \
    Then no settings are printed."
)]
pub struct CalibrateArguments {
    #[command(flatten)]
    pub line: LineArguments,
    /// Start to move without asking.
    #[arg(long)]
    pub yes: bool,
    /// Turns on the spot, by the encoders; 0 for none.
    #[arg(long, value_name = "N", default_value_t = 1.0, allow_negative_numbers = true, value_parser = real(0.0..=20.0, "0 to 20 turns"))]
    pub turns: f64,
    /// Distance to drive straight ahead, by the encoders, metres; 0 for none.
    #[arg(long, value_name = "M", default_value_t = 1.0, allow_negative_numbers = true, value_parser = real(0.0..=10.0, "metres, 0 to 10"))]
    pub distance: f64,
    /// The real turn, degrees, if it is known from an earlier calibration with the same settings.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = real(above_zero(10_000.0), "above zero"))]
    pub turned: Option<f64>,
    /// The real distance, metres, if it is known from an earlier calibration with the same settings.
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = real(above_zero(10_000.0), "above zero"))]
    pub driven: Option<f64>,
}

/// What a base measured of its own motion.
#[derive(Clone, Copy, Debug, Default)]
struct Motion {
    /// Turn and distance by the tracks, radians and metres.
    turned_rad: f64,
    driven_m: f64,
    /// What the gyro measured, if there is one.
    gyro: Option<GyroTurn>,
    /// Whether the tracks were measured by encoder counts, which `ticks_per_m` scales.
    has_counts: bool,
}

impl Motion {
    /// Turn by the gyro, radians.
    fn by_gyro_rad(&self) -> Option<f64> {
        self.gyro.map(|gyro| gyro.turned_rad())
    }
}

/// A turn by the gyro, which reads a bias also while the base stands.
#[derive(Clone, Copy, Debug, Default)]
struct GyroTurn {
    /// The whole turn, with the bias.
    whole: GyroRate,
    /// The standstill before and after the motion.
    before: GyroRate,
    after: GyroRate,
    has_moved: bool,
    /// Time of the present standstill, seconds.
    still_s: f64,
}

/// A turn with its time, in radians and seconds.
#[derive(Clone, Copy, Debug, Default)]
struct GyroRate {
    turned_rad: f64,
    time_s: f64,
}

impl GyroRate {
    fn add(&mut self, rate: f64, time_s: f64) {
        self.turned_rad += rate * time_s;
        self.time_s += time_s;
    }

    /// The mean rate, rad/s; none without a time.
    fn mean(&self) -> Option<f64> {
        (self.time_s > 0.0).then(|| self.turned_rad / self.time_s)
    }
}

impl GyroTurn {
    /// Takes a measured turn rate, rad/s, for a time step, seconds.
    fn update(&mut self, rate: f64, time_s: f64, is_still: bool) {
        self.whole.add(rate, time_s);
        self.has_moved |= !is_still;
        self.still_s = if is_still { self.still_s + time_s } else { 0.0 };
        if self.still_s >= SETTLED_S {
            let standstill = if self.has_moved { &mut self.after } else { &mut self.before };
            standstill.add(rate, time_s);
        }
    }

    /// The rate at a standstill, rad/s: the mean of before and after the motion; none if the base never stood.
    fn bias(&self) -> Option<f64> {
        match (self.before.mean(), self.after.mean()) {
            (Some(before), Some(after)) => Some(f64::midpoint(before, after)),
            (before, after) => before.or(after),
        }
    }

    /// The turn without the bias, radians.
    fn turned_rad(&self) -> f64 {
        self.whole.turned_rad - self.bias().unwrap_or(0.0) * self.whole.time_s
    }

    /// Why the gyro does not measure a turn; none if it does.
    fn unusable(&self) -> Option<String> {
        const CURE: &str = "measure the turn by a mark on the floor, and give it with --turned";
        let (Some(before), Some(after)) = (self.before.mean(), self.after.mean()) else {
            return Some(format!(
                "the base did not stand for {SETTLED_S} s before and after the turn, so the gyro's bias is unknown: {CURE}"
            ));
        };
        if (after - before).abs() > MAX_GYRO_DRIFT {
            return Some(format!(
                "the gyro of the standing base read {before:.3} rad/s before the turn and {after:.3} rad/s after it: let it warm up, \
                 or {CURE}"
            ));
        }
        let bias = f64::midpoint(before, after);
        (bias.abs() > MAX_GYRO_BIAS).then(|| {
            format!(
                "the gyro of the standing base reads {bias:.3} rad/s, at most {MAX_GYRO_BIAS} is usable: switch the base on while it \
                 stands still, or {CURE}"
            )
        })
    }
}

/// Integrates the reports of a base.
struct Meter {
    settings: BaseSettings,
    before_s: f64,
    counts: Option<PerTrack<u32>>,
    motion: Motion,
}

impl Meter {
    fn new(settings: BaseSettings, now_s: f64) -> Self {
        Self { settings, before_s: now_s, counts: None, motion: Motion::default() }
    }

    fn update(&mut self, now_s: f64, status: &SupervisorStatus) {
        let elapsed_s = now_s - std::mem::replace(&mut self.before_s, now_s);
        let Some(feedback) = &status.feedback else {
            return;
        };
        let moved = match feedback.encoder_counts {
            None => {
                Twist::new(feedback.twist.linear * elapsed_s, feedback.twist.angular * elapsed_s)
            }
            Some(counts) => {
                self.motion.has_counts = true;
                let before = self.counts.replace(counts).unwrap_or(counts);
                let travel_m = travel_m(&before, &counts, &self.settings.ticks_per_m);
                self.settings.drive().twist(&travel_m)
            }
        };
        self.motion.turned_rad += moved.angular;
        self.motion.driven_m += moved.linear;
        if let Some(rate) = feedback.yaw_rate {
            let gyro = self.motion.gyro.get_or_insert_default();
            gyro.update(rate, elapsed_s, base::is_still(status));
        }
    }
}

/// Calibrates a base. Returns false if a motion was not completed on one connection.
pub fn run(arguments: &CalibrateArguments) -> anyhow::Result<bool> {
    ensure!(
        arguments.turns > 0.0 || arguments.distance > 0.0,
        "--turns and --distance are both 0: there is nothing to do"
    );
    if !arguments.yes {
        confirm(arguments)?;
    }
    let (line, supervisor) = base::open(&arguments.line)?;
    let settings = line.config.base;
    let mut identifier = MotionIdentifier::new(&limits(&settings), ASSUMED_S);
    let failures = supervisor.status().counters.connection_failures;
    let turn_rad = arguments.turns * TAU;
    let mut drive = |twist: Twist, is_done: &dyn Fn(&Motion) -> bool, longest_s: f64| {
        motion(&supervisor, &settings, &mut identifier, &twist, is_done, longest_s)
    };
    let turn_s = LONGEST * turn_rad / TURN_RATE + PAUSE_S;
    let has_turned = |it: &Motion| it.turned_rad >= turn_rad;
    let (turned, mut is_complete) = drive(Twist::new(0.0, TURN_RATE), &has_turned, turn_s);
    let mut driven = Motion::default();
    if is_complete {
        let drive_s = LONGEST * arguments.distance / SPEED + PAUSE_S;
        let is_there = |it: &Motion| it.driven_m >= arguments.distance;
        (driven, is_complete) = drive(Twist::new(SPEED, 0.0), &is_there, drive_s);
    }
    let status = supervisor.end();
    let gyro = turned.gyro.filter(|_| arguments.turns > 0.0 && arguments.turned.is_none());
    let why = why_invalid(&status, is_complete, failures)
        .or_else(|| gyro.and_then(|gyro| gyro.unusable()));
    let estimate = *identifier.estimate();
    let result = if why.is_none() {
        Calibration::new(&settings, &turned, &driven, arguments)
    } else {
        Calibration::default()
    };
    let mut object = result.object(&turned, &driven, &estimate, &status);
    object["why"] = json!(why);
    let mut lines = Calibration::lines(&turned, &driven, &estimate, arguments);
    match &why {
        Some(why) => lines.push(format!("no settings  {why}")),
        None => lines.extend(result.settings_text(&settings)),
    }
    if why.is_none() && arguments.driven.is_some() && result.ticks_per_m.is_none() {
        let protocol = line.protocol;
        lines.push(format!(
            "--driven     has no effect: the protocol {protocol} has no encoder counts, and no setting corrects the distance of its \
             firmware"
        ));
    }
    output::result(&object, lines)?;
    Ok(why.is_none())
}

/// Why the motions give no settings. A lost line hides a part of them, also if it was opened again.
fn why_invalid(status: &SupervisorStatus, is_complete: bool, failures: u64) -> Option<String> {
    let is_lost = status.counters.connection_failures > failures;
    let lost = || is_lost.then(|| "the connection was lost".to_owned());
    let ended = || (!status.is_running).then(|| "stopped by a signal".to_owned());
    let slow = || "the base did not complete a motion in the longest time for it".to_owned();
    stop_cause(status).or_else(ended).or_else(lost).or_else(|| (!is_complete).then(slow))
}

/// Asks the operator before the base moves.
fn confirm(arguments: &CalibrateArguments) -> anyhow::Result<()> {
    if !stdin().is_terminal() {
        bail!("the base is about to move: run it in a terminal, or confirm with --yes");
    }
    output::note(format!(
        "The base on {} turns {} times on the spot and drives {} m ahead. Is the floor free, and is the emergency \
         stop within reach? [y/N]",
        arguments.line.port, arguments.turns, arguments.distance
    ));
    std::io::stderr().flush()?;
    let mut answer = String::new();
    stdin().read_line(&mut answer)?;
    ensure!(
        matches!(answer.trim(), "y" | "Y" | "yes"),
        "not confirmed: the base stays where it is"
    );
    Ok(())
}

/// Limits of the commands, for the identification: those of the tracks.
fn limits(settings: &BaseSettings) -> Limits {
    let tracks = &settings.tracks;
    let arm_m = settings.drive().track_width_m / 2.0;
    Limits::default()
        .acc_lim_x(tracks.acc_lim_track)
        .decel_lim_x(tracks.decel_lim_track)
        .acc_lim_theta(tracks.acc_lim_track / arm_m)
        .decel_lim_theta(tracks.decel_lim_track / arm_m)
}

/// Commands a motion until it is done, then stops, and stands for a moment. Returns it, and whether it was completed.
fn motion(
    supervisor: &BaseSupervisor,
    settings: &BaseSettings,
    identifier: &mut MotionIdentifier,
    twist: &Twist,
    is_done: &dyn Fn(&Motion) -> bool,
    longest_s: f64,
) -> (Motion, bool) {
    let start_s = supervisor.now_s();
    let mut meter = Meter::new(*settings, start_s);
    let mut follow = |target: &Twist, is_over: &dyn Fn(f64, &Motion) -> bool| {
        let begin_s = supervisor.now_s();
        // A supervisor that has ended gives no further status.
        let mut motion = meter.motion;
        base::drive_while(supervisor, target, |supervisor, status| {
            let now_s = supervisor.now_s();
            let feedback = status.feedback.as_ref();
            identifier.observe(now_s, &feedback.map_or(Twist::STOP, |report| report.twist));
            identifier.command(now_s, target);
            meter.update(now_s, status);
            motion = meter.motion;
            !is_over(now_s - begin_s, &motion)
        });
        motion
    };
    follow(&Twist::STOP, &|elapsed_s, _| elapsed_s >= PAUSE_S);
    let moved = follow(twist, &|elapsed_s, motion| elapsed_s >= longest_s || is_done(motion));
    let motion = follow(&Twist::STOP, &|elapsed_s, _| elapsed_s >= PAUSE_S);
    (motion, is_done(&moved))
}

/// The settings that follow from the motions.
#[derive(Default)]
struct Calibration {
    /// Ratio of the effective to the geometric track width; it needs a gyro or a measured turn.
    width_ratio: Option<f64>,
    /// Ticks per metre; they need a measured distance, and encoder counts.
    ticks_per_m: Option<PerTrack<f64>>,
}

impl Calibration {
    fn new(
        settings: &BaseSettings,
        turned: &Motion,
        driven: &Motion,
        given: &CalibrateArguments,
    ) -> Self {
        let real_m = given.driven.filter(|_| driven.driven_m > 0.0 && driven.has_counts);
        let ticks =
            real_m.map(|real_m| settings.ticks_per_m.map(|per_m| per_m * driven.driven_m / real_m));
        // More ticks per metre make the measured turn smaller in the same proportion.
        let scale = real_m.map_or(1.0, |real_m| real_m / driven.driven_m);
        let real_rad = given.turned.map(f64::to_radians).or_else(|| turned.by_gyro_rad());
        let width = real_rad.filter(|real_rad| *real_rad > 0.1 && turned.turned_rad > 0.1);
        let present = settings.effective_width_ratio;
        Self {
            width_ratio: width.map(|real_rad| present * scale * turned.turned_rad / real_rad),
            ticks_per_m: ticks,
        }
    }

    fn object(
        &self,
        turned: &Motion,
        driven: &Motion,
        estimate: &MotionEstimate,
        status: &SupervisorStatus,
    ) -> Value {
        json!({
            "turned_rad": turned.turned_rad,
            "turned_by_gyro_rad": turned.by_gyro_rad(),
            "gyro_bias_rad_s": turned.gyro.and_then(|gyro| gyro.bias()),
            "driven_m": driven.driven_m,
            "effective_width_ratio": self.width_ratio,
            "ticks_per_m": self.ticks_per_m,
            "motion": estimate,
            "stop_cause": stop_cause(status),
            "interrupted": !status.is_running,
        })
    }

    fn lines(
        turned: &Motion,
        driven: &Motion,
        estimate: &MotionEstimate,
        given: &CalibrateArguments,
    ) -> Vec<String> {
        let real = match (given.turned, turned.by_gyro_rad()) {
            (Some(degrees), _) => format!("{degrees:.1} deg by --turned"),
            (None, Some(rad)) => format!("{:.1} deg by the gyro", rad.to_degrees()),
            (None, None) => "no gyro: measure the real turn and give it with --turned".to_owned(),
        };
        let latency = estimate.delay_s.map_or_else(
            || "not identified".to_owned(),
            |it| format!("{:.2} s ({:.2} to {:.2})", it.value, it.low, it.high),
        );
        vec![
            format!("turned       {:.1} deg by the tracks, {real}", turned.turned_rad.to_degrees()),
            format!("driven       {:.3} m by the tracks", driven.driven_m),
            format!("latency      {latency}"),
        ]
    }

    /// The settings as TOML.
    fn settings_text(&self, present: &BaseSettings) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some(ratio) = self.width_ratio {
            let present = present.effective_width_ratio;
            lines.push(format!("effective_width_ratio = {ratio:.3}  # was {present}"));
        }
        if let Some(ticks) = self.ticks_per_m {
            let present = present.ticks_per_m;
            lines.push(format!(
                "ticks_per_m = {{ left = {:.0}, right = {:.0} }}  # was {}, {}",
                ticks.left, ticks.right, present.left, present.right
            ));
        }
        if lines.is_empty() {
            return lines;
        }
        lines.insert(0, "[base]".to_owned());
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A turn of 2 pi at 0.5 rad/s between two standstills of a second, with the gyro's bias before it and its growth, rad/s.
    fn turn(bias: f64, growth: f64) -> GyroTurn {
        let mut gyro = GyroTurn::default();
        let mut run = |rate: f64, time_s: f64, is_still: bool| {
            for _ in 0..(time_s * 50.0).round() as usize {
                gyro.update(rate, 0.02, is_still);
            }
        };
        run(bias, PAUSE_S, true);
        run(TURN_RATE + bias + growth / 2.0, TAU / TURN_RATE, false);
        // It rocks while it comes to a stop.
        run(0.2 + bias + growth, 0.2, true);
        run(-0.2 + bias + growth, 0.08, true);
        run(bias + growth, PAUSE_S, true);
        gyro
    }

    #[test]
    fn gyro_bias_does_not_change_the_turn() {
        for (bias, growth) in [(0.0, 0.0), (0.02, 0.0), (-0.09, 0.0), (0.05, 0.008)] {
            let gyro = turn(bias, growth);
            assert_eq!(gyro.unusable(), None, "{bias} {growth}");
            let relative = (gyro.turned_rad() - 0.024) / TAU;
            assert!((relative - 1.0).abs() < 0.002, "{bias} {growth}: {relative}");
            let read = gyro.bias().expect("it stood");
            assert!((read - bias - growth / 2.0).abs() < 1e-9, "{bias} {growth}: {read}");
        }
    }

    #[test]
    fn gyro_with_a_large_or_changing_bias_is_unusable() {
        for (bias, growth, expected) in [
            (0.12, 0.0, "reads 0.120 rad/s"),
            (0.01, 0.012, "read 0.010 rad/s before the turn and 0.022 rad/s after it"),
        ] {
            let why = turn(bias, growth).unusable().expect("unusable");
            assert!(why.contains(expected) && why.contains("--turned"), "{why}");
        }
        let mut moving = GyroTurn::default();
        moving.update(0.5, 0.02, false);
        assert!(moving.unusable().is_some_and(|why| why.contains("did not stand")));
    }
}
