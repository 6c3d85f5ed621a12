//! The robot and the moving obstacles when a command takes effect, predicted from what was measured and sent.

use std::collections::VecDeque;

use crate::geometry::{Pose, Twist};
use crate::map::MovingDisc;
use crate::robot::{Limits, TickTime};

/// Longest history of commands, seconds: no base reacts later. Largest number of commands.
const IN_FLIGHT_S: f64 = 2.0;
const MAX_IN_FLIGHT: usize = 256;

/// The latest commands with their times. Radio, bus and motor delay a command; until it takes effect the robot follows the
/// earlier ones.
#[derive(Clone, Debug, Default)]
pub(super) struct CommandsInFlight(VecDeque<(f64, Twist)>);

impl CommandsInFlight {
    /// Records a command handed over at a time, seconds. A time that descends clears the history: the clock jumped.
    pub fn record(&mut self, time_s: f64, command: &Twist) {
        if self.0.back().is_some_and(|last| last.0 >= time_s) {
            self.0.clear();
        }
        self.0.push_back((time_s, *command));
        while self.0.len() > MAX_IN_FLIGHT
            || self.0.get(1).is_some_and(|next| time_s - next.0 > IN_FLIGHT_S)
        {
            self.0.pop_front();
        }
    }
}

/// Oldest scan from which moving obstacles are predicted, seconds.
const OLDEST_SCAN_S: f64 = 1.0;

/// A measured pose and velocity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measured<'a> {
    /// Time of the tick, seconds.
    pub time_s: f64,
    /// Time at which pose and velocity were measured, seconds, by the same clock.
    pub odometry_s: f64,
    /// Time of the scan that shows the moving obstacles, seconds.
    pub scan_s: f64,
    pub pose: &'a Pose,
    pub twist: &'a Twist,
}

/// The robot and the moving obstacles at the time when a command sent now takes effect.
///
/// A decision for the present pose would brake too late by the distance driven until then. The prediction starts at the time of
/// the measurement, not of the tick, so it covers the age of the measurement.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PredictedState {
    /// Time of the observation, seconds.
    pub time_s: f64,
    /// Predicted pose of the robot.
    pub pose: Pose,
    /// Predicted velocity, as far as the base can have followed the commands.
    pub twist: Twist,
    /// Predicted moving obstacles.
    pub moving: Vec<MovingDisc>,
    /// People who walk, with the velocity of the body rather than that of a leg: for paths, not for safety.
    pub walkers: Vec<MovingDisc>,
    /// `moving`, and people who entered free ground and are not tracked.
    pub may_come: Vec<MovingDisc>,
    /// The people whom a turn in place may meet: `may_come`, where people who have not stood for long may walk, and people whom
    /// the tracker lost.
    pub near_turn: Vec<MovingDisc>,
    /// Objects that stand alone: each may be a post, or a person who starts to walk.
    pub may_start: Vec<MovingDisc>,
    /// Time from the scan to the effect of the command, seconds.
    pub since_scan_s: f64,
}

impl PredictedState {
    /// Predicts from the measurement, the tracked obstacles of the tick, and the commands. Each command takes effect after a
    /// delay, seconds.
    pub fn new(
        measured: &Measured<'_>,
        moving: &[MovingDisc],
        commands: &CommandsInFlight,
        limits: &Limits,
        delay_s: f64,
    ) -> Self {
        let Measured { time_s, odometry_s, scan_s, .. } = *measured;
        let (mut pose, mut twist) = (*measured.pose, *measured.twist);
        let mut at_s = odometry_s.clamp(time_s - IN_FLIGHT_S, time_s);
        let mut active = Twist::STOP;
        for (sent_s, command) in &commands.0 {
            let effect_s = sent_s + delay_s;
            if effect_s > at_s {
                (pose, twist) = limits.advance(&pose, &twist, &active, effect_s - at_s);
                at_s = effect_s;
            }
            active = *command;
        }
        let left_s = (time_s + delay_s - at_s).max(0.0);
        (pose, twist) = limits.advance(&pose, &twist, &active, left_s);
        let since_scan_s = delay_s + (time_s - scan_s).clamp(0.0, OLDEST_SCAN_S);
        let moving: Vec<_> = moving.iter().map(|disc| disc.after(since_scan_s)).collect();
        Self {
            time_s,
            pose,
            twist,
            may_come: moving.clone(),
            near_turn: moving.clone(),
            may_start: Vec::new(),
            walkers: Vec::new(),
            moving,
            since_scan_s,
        }
    }
}

/// The command after the time of a tick of braking at the limit, from the slower of the predicted motion and the last command.
///
/// Motors follow a braking command with a lag. A command that starts from the measured motion follows that lag, and the robot
/// then brakes at a part of its limit. A robot that still accelerates is slower than its last command.
pub(super) fn brake(
    limits: &Limits,
    predicted: &Twist,
    last_command: &Twist,
    time: impl Into<TickTime>,
) -> Twist {
    let slower = |one: f64, other: f64| {
        if one * other <= 0.0 { 0.0 } else { one.abs().min(other.abs()).copysign(one) }
    };
    let from = Twist::new(
        slower(predicted.linear, last_command.linear),
        slower(predicted.angular, last_command.angular),
    );
    limits.brake(&from, time)
}

#[cfg(test)]
mod tests {
    use super::super::test_state::PERIOD_S;
    use super::*;

    const LAG_S: f64 = 0.15;

    /// A base at 1 m/s whose motors follow the command with a lag of 0.15 s. Returns the distance to a standstill, metres, when
    /// each command is computed from the measured speed and the last command.
    fn braking_distance_m(next_command: impl Fn(f64, f64) -> f64) -> f64 {
        let (mut speed, mut command, mut distance_m) = (1.0, 1.0, 0.0);
        for _ in 0..100 {
            command = next_command(speed, command);
            for _ in 0..100 {
                speed += (command - speed) * 0.001 / LAG_S;
                distance_m += speed * 0.001;
            }
        }
        assert!(speed.abs() < 1e-6, "{speed}");
        distance_m
    }

    #[test]
    fn braking_distance_with_motor_lag_is_that_of_the_full_deceleration() {
        let limits = Limits { decel_lim_x: -1.0, ..Limits::default() };
        let ideal_m = braking_distance_m(|_, command| (command - PERIOD_S).max(0.0));
        let braked_m = braking_distance_m(|speed, command| {
            let (pose, twist) = (&Pose::default(), &Twist::new(speed, 0.0));
            let measured = Measured { time_s: 0.0, odometry_s: 0.0, scan_s: 0.0, pose, twist };
            let last = Twist::new(command, 0.0);
            let mut in_flight = CommandsInFlight::default();
            in_flight.record(-PERIOD_S, &last);
            let now = PredictedState::new(&measured, &[], &in_flight, &limits, 0.08);
            brake(&limits, &now.twist, &last, PERIOD_S).linear
        });
        assert!((braked_m / ideal_m - 1.0).abs() < 0.1, "{braked_m} m, ideally {ideal_m} m");
    }

    /// Commands of 0.1 m/s more at each tick, on a base that reacts after two and a half ticks.
    #[test]
    fn prediction_plays_the_commands_in_flight_from_the_time_of_the_measurement() {
        let limits = Limits::default();
        let mut in_flight = CommandsInFlight::default();
        for tick in 0..10 {
            in_flight.record(PERIOD_S * f64::from(tick), &Twist::new(0.1 * f64::from(tick), 0.0));
        }
        let (delay_s, time_s) = (0.25, 1.0);
        let speed_at = |time_s: f64| (time_s - delay_s).max(0.0);
        for age_s in [0.0, 0.15] {
            let odometry_s = time_s - age_s;
            let twist = &Twist::new(speed_at(odometry_s), 0.0);
            let pose = &Pose::default();
            let measured = Measured { time_s, odometry_s, scan_s: time_s, pose, twist };
            let now = PredictedState::new(&measured, &[], &in_flight, &limits, delay_s);
            // The last command is that of the tick before.
            assert!((now.twist.linear - 0.9).abs() < 0.011, "{age_s}: {now:?}");
            let distance_m = (0.9 * 0.9 - twist.linear * twist.linear) / 2.0 + 0.05 * 0.9;
            assert!((now.pose.x - distance_m).abs() < 0.05, "{age_s}: {now:?} {distance_m}");
        }
    }

    #[test]
    fn brake_starts_from_the_slower_of_motion_and_last_command() {
        let limits = Limits::default();
        let from = |predicted: f64, last: f64| {
            brake(&limits, &Twist::new(predicted, 0.0), &Twist::new(last, 0.0), PERIOD_S).linear
        };
        assert!((from(0.9, 0.6) - 0.5).abs() < 1e-12, "a base that lags behind a braking command");
        assert!((from(0.3, 0.6) - 0.2).abs() < 1e-12, "a base that still accelerates");
        assert!((from(-0.3, -0.6) + 0.2).abs() < 1e-12, "in reverse");
        assert_eq!(from(0.3, -0.1), 0.0, "a reversal passes through zero");
    }
}
