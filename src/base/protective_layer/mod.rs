//! The protective layer in the sender: it limits each command by the raw scan, independently of the planner.
//!
//! It follows Nav2's `collision_monitor`, and knows no map, no pose and no plan. It sweeps the body along the stopping
//! motion of a command: the motion until the command takes effect, one period with the command, then braking to a standstill.
//! A command passes only if the swept area holds no return of the raw scan. Otherwise the layer reduces it at constant
//! curvature, down to a full stop. A robot thus passes along walls at full speed, and stops before obstacles ahead.
//!
//! - A return within the free space of an earlier scan counts as moving. It may approach at walking speed (ISO 13855).
//! - A robot that touches something already may only move away from it, slowly.
//! - A scan that is missing, old, blind or frozen stops the robot. Directions without measurements permit creeping only.
//! - Nothing moves before [`ProtectiveLayer::arm`], and after [`ProtectiveLayer::operator_stop`] until it is armed again.
//!
//! The layer takes time as a parameter and does no I/O.

mod action;
mod body;
mod directions;
mod obstacle;
mod operator;
mod polygon;
mod ramp;
mod raw_scan;
mod settings;
mod stopping_motion;
mod thinning;

pub use action::ProtectiveAction;
pub use operator::{OperatorState, OperatorSwitch};
pub use polygon::{ActionType, Polygons, ZoneError, ZonePolygon};
pub use settings::CollisionMonitorSettings;

use std::collections::VecDeque;

use crate::geometry::{Point, Twist};
use crate::map::TimedScan;
use crate::robot::{Footprint, Limits, MotionIdentifier, TickTime, TrackLimits, TrackedDrive};
use crate::settings::SettingError;
use body::Body;
use obstacle::obstacle_return;
use ramp::Ramp;
use raw_scan::{RawPoint, RawScans};
use stopping_motion::{Clearance, MotionModel, Obstruction, StoppingMotion, too_near_m};

/// Time for which a body that was too near to something does not move at anything near, seconds: ten scans of a small lidar.
const TOO_NEAR_FOR_S: f64 = 1.0;

/// Factor of a command below which the robot stands.
const MIN_FACTOR: f64 = 0.05;

/// Bisections of the factor: to 3 % of the command.
const BISECTIONS: u32 = 5;

/// Least difference between measured and commanded motion at which the layer checks both, m/s and rad/s.
const SAME_MOTION: f64 = 0.05;

/// Bound of measured speeds, m/s and rad/s.
const MAX_MEASURED: f64 = 10.0;

/// Least identified deceleration, m/s^2.
const MIN_DECELERATION: f64 = 0.05;

/// Limits each command by the raw scan, the measured motion and the operator's switch. Times in seconds of one clock.
#[derive(Clone, Debug)]
pub struct ProtectiveLayer {
    settings: CollisionMonitorSettings,
    body: Body,
    /// How the sender changes its commands.
    ramp: Ramp,
    /// Latency and braking as this layer identifies them.
    identifier: MotionIdentifier,
    /// Delay, seconds, and deceleration, m/s^2, that are known otherwise.
    known_stopping: Option<(f64, f64)>,
    period_s: f64,
    /// Commands that were sent, each with its time; the oldest first.
    sent: VecDeque<(f64, Twist)>,
    /// Time of the last call.
    last_s: f64,
    /// When the body was too near to something last, seconds.
    too_near_s: f64,
    scans: RawScans,
    requires_scan: bool,
    operator: OperatorSwitch,
    action: ProtectiveAction,
}

impl ProtectiveLayer {
    /// Creates the layer of a robot that is not armed. A command is kept for `period_s`, seconds.
    ///
    /// # Errors
    /// A setting or a limit out of range.
    pub fn new(
        settings: CollisionMonitorSettings,
        footprint: &Footprint,
        limits: Limits,
        period_s: f64,
    ) -> Result<Self, SettingError> {
        settings.validate()?;
        limits.validate()?;
        Ok(Self {
            identifier: MotionIdentifier::new(&limits, settings.stopping_delay_s),
            known_stopping: None,
            settings,
            body: Body::new(footprint),
            ramp: Ramp::Twist(limits),
            period_s: period_s.clamp(0.0, 1.0),
            sent: VecDeque::new(),
            last_s: f64::NEG_INFINITY,
            too_near_s: f64::NEG_INFINITY,
            scans: RawScans::new(),
            requires_scan: true,
            operator: OperatorSwitch::default(),
            action: ProtectiveAction::NotArmed,
        })
    }

    /// The same layer for a base without a lidar, such as one that is commanded by hand: only the switch acts.
    #[must_use]
    pub fn without_lidar(mut self) -> Self {
        self.requires_scan = false;
        self
    }

    /// The same layer for a sender that ramps the speed of each track, and not forward speed and turn rate apart.
    #[must_use]
    pub fn with_tracks(mut self, drive: TrackedDrive, limits: TrackLimits) -> Self {
        self.ramp = Ramp::Tracks { drive, limits };
        self
    }

    /// Takes a raw scan, in the robot's frame at the time of each beam, and the time of its newest beam. The beams may be in any
    /// order. The same scan may come again. An invalid scan is ignored, and the last valid one ages. A scan is invalid if a direction
    /// or a time is not finite, if it has more than 65,536 beams, or if a beam is newer than the scan or over a second older.
    pub fn update_scan(&mut self, scan: &TimedScan, stamp_s: f64) {
        if self.uses_scans() {
            self.scans.update_scan(scan, stamp_s);
        }
    }

    /// Takes the measured motion and its time.
    pub fn update_motion(&mut self, measured: &Twist, stamp_s: f64) {
        self.scans.update_motion(measured, stamp_s);
    }

    /// Sets the time from a command to its effect, seconds, and the deceleration, m/s^2, where they are known; else the layer
    /// identifies them. Values that are not finite or out of range are ignored.
    #[doc(hidden)]
    pub fn set_stopping(&mut self, delay_s: f64, deceleration_m_s2: f64) {
        let is_valid = delay_s.is_finite() && delay_s >= 0.0 && deceleration_m_s2.is_finite();
        if is_valid && deceleration_m_s2 >= MIN_DECELERATION {
            self.known_stopping = Some((delay_s, deceleration_m_s2));
        }
    }

    /// Delay of a command, seconds, and deceleration, m/s^2, that the layer uses.
    #[must_use]
    pub fn stopping(&self) -> (f64, f64) {
        let estimate = self.identifier.estimate();
        let identified = (estimate.safe_delay_s, estimate.braking_m_s2.max(MIN_DECELERATION));
        self.known_stopping.unwrap_or(identified)
    }

    /// The operator's switch. It arms and stops this layer from any thread.
    #[must_use]
    pub fn operator(&self) -> OperatorSwitch {
        self.operator.clone()
    }

    /// Permits motion, as an operator's explicit decision. Ends an operator's stop.
    pub fn arm(&mut self) {
        self.operator.arm();
    }

    /// Forbids motion until the next [`Self::arm`].
    pub fn disarm(&mut self) {
        self.operator.disarm();
    }

    /// Latches a stop until the next [`Self::arm`].
    pub fn operator_stop(&mut self) {
        self.operator.stop();
    }

    /// What the layer did to the last command.
    #[must_use]
    pub const fn action(&self) -> &ProtectiveAction {
        &self.action
    }

    /// The command to send instead of a target, after the command that was sent last; and what acts. Zero is a full stop: the
    /// sender brakes as hard as it may.
    pub fn limit(&mut self, target: &Twist, sent: &Twist, now_s: f64) -> (Twist, ProtectiveAction) {
        self.record_sent(sent, now_s);
        let (command, action) = self.decide(target, now_s);
        self.action.clone_from(&action);
        (command, action)
    }

    /// A limited command within the accelerations, at a tick after the command that was sent last: a full stop keeps the
    /// curvature, so that the robot brakes along the checked arc. For senders without a ramp of their own. A layer that is not
    /// enabled returns the command.
    #[must_use]
    pub fn ramp(&self, command: &Twist, sent: &Twist, tick: TickTime) -> Twist {
        if !self.settings.enabled {
            *command
        } else if *command == Twist::STOP {
            self.ramp.brake(sent, tick)
        } else {
            self.ramp.towards(sent, command, tick)
        }
    }

    /// Whether the body was too near to something a moment before the last call.
    fn was_too_near(&self) -> bool {
        (0.0..=TOO_NEAR_FOR_S).contains(&(self.last_s - self.too_near_s))
    }

    fn record_sent(&mut self, sent: &Twist, now_s: f64) {
        let sent = if sent.is_finite() { *sent } else { Twist::STOP };
        if !now_s.is_finite() {
            return;
        }
        if now_s < self.last_s {
            // The clock ran backwards.
            self.sent.clear();
            // A hold continues by the new clock.
            self.too_near_s = if self.was_too_near() { now_s } else { f64::NEG_INFINITY };
            self.last_s = f64::NEG_INFINITY;
        }
        // It was sent after the last call.
        self.sent.push_back((self.last_s, sent));
        self.identifier.command(self.last_s, &sent);
        if let Some((measured_s, measured)) = self.scans.measured() {
            self.identifier.observe(measured_s, &measured);
        }
        self.last_s = now_s;
        let (delay_s, _) = self.stopping();
        let is_past = |(sent_s, _): &(f64, Twist)| sent_s + delay_s <= now_s;
        // The last command in force is kept.
        while self.sent.get(1).is_some_and(is_past) {
            self.sent.pop_front();
        }
    }

    /// The commands that were sent, each with the time until it takes effect, seconds; the first is in force.
    fn pending(&self, now_s: f64) -> Vec<(f64, Twist)> {
        let (delay_s, _) = self.stopping();
        let effect = |(sent_s, twist): &(f64, Twist)| (sent_s + delay_s - now_s, *twist);
        self.sent.iter().map(effect).collect()
    }

    /// Whether what the lidar measures may change a command.
    const fn uses_scans(&self) -> bool {
        self.settings.enabled && self.requires_scan
    }

    fn decide(&mut self, target: &Twist, now_s: f64) -> (Twist, ProtectiveAction) {
        if let Some(action) = self.full_stop(target, now_s) {
            return (Twist::STOP, action);
        }
        if !self.uses_scans() {
            return (*target, ProtectiveAction::Pass);
        }
        let points = self.scans.points(&self.body, now_s);
        let near_m = too_near_m(self.settings.margin_m);
        let near = points.iter().filter(|point| point.gap_m <= near_m);
        if obstacle_return(near, self.settings.min_points).is_some() {
            self.too_near_s = now_s;
        }
        let situation = Situation {
            points: &points,
            sent: &self.pending(now_s),
            age_s: self.scans.age_s(now_s).unwrap_or_default().max(0.0),
        };
        // A factor of a command that no base follows is too coarse: the smallest one may be more than its largest speed.
        let command = self.ramp.within_limits(target);
        let mut limited = Limited { command, action: ProtectiveAction::Pass };
        self.limit_by_polygons(&points, &mut limited);
        self.limit_by_body(&points, &mut limited);
        self.limit_by_blindness(&situation, now_s, &mut limited);
        self.limit_by_approach(&situation, &mut limited);
        self.limit_near_returns(&situation, &mut limited);
        (limited.command, limited.action)
    }

    /// The reason for a stop that does not depend on the surroundings, if there is one.
    fn full_stop(&self, target: &Twist, now_s: f64) -> Option<ProtectiveAction> {
        match self.operator.state() {
            OperatorState::NotArmed => return Some(ProtectiveAction::NotArmed),
            OperatorState::Stopped => return Some(ProtectiveAction::OperatorStop),
            OperatorState::Armed => {}
        }
        if !(target.is_finite() && now_s.is_finite()) {
            return Some(ProtectiveAction::NotFinite);
        }
        if !self.uses_scans() {
            return None;
        }
        let Some(age_s) = self.scans.age_s(now_s) else {
            return Some(ProtectiveAction::NoScan);
        };
        let share = self.scans.return_share();
        let frozen = self.scans.frozen_scans();
        if age_s.abs() > self.settings.source_timeout {
            Some(ProtectiveAction::StaleScan { age_s })
        } else if share < self.settings.min_return_share {
            Some(ProtectiveAction::BlindScan { share })
        } else {
            let scans = frozen.filter(|scans| *scans >= self.settings.frozen_scans)?;
            Some(ProtectiveAction::FrozenScan { scans })
        }
    }

    fn limit_by_polygons(&self, points: &[RawPoint], limited: &mut Limited) {
        for zone in self.settings.polygons.zones() {
            let step_s = self.settings.simulation_time_step;
            let factor = zone.factor(points, &limited.command, step_s);
            limited.scale(factor, || ProtectiveAction::Zone { name: zone.name.clone(), factor });
        }
    }

    /// Slows a robot with returns in its body. Whether it moves away from them is checked as for every motion.
    fn limit_by_body(&self, points: &[RawPoint], limited: &mut Limited) {
        let within = points.iter().filter(|point| point.gap_m <= 0.0);
        if obstacle_return(within.clone(), self.settings.min_points).is_some() {
            let limit = self.settings.escape_speed;
            let depth_m = within.map(|point| -point.gap_m).fold(0.0, f64::max);
            let factor = self.factor_to(limit, &limited.command);
            limited.scale(factor, || ProtectiveAction::Escape { limit, depth_m });
        }
    }

    /// Slows a robot that would move into directions without measurements. On a way ahead it counts how fast it enters them: a long body
    /// that follows a slight curve enters those beside its rear slowly.
    fn limit_by_blindness(&self, situation: &Situation<'_>, now_s: f64, limited: &mut Limited) {
        let mut blind = self.scans.blind_directions(now_s).peekable();
        if blind.peek().is_none() || limited.command == Twist::STOP {
            return;
        }
        let motion = self.commanded_motion(situation, &limited.command);
        if let Some((direction_rad, share)) = motion.fastest_entry(blind) {
            let limit = self.settings.blind_speed_limit;
            let Twist { linear, angular } = limited.command;
            // The ground beside the rear was ahead of the robot a moment ago, unless the robot turns on the spot or reverses.
            let was_ahead = linear > angular.abs() * self.body.radius_m;
            let fastest = if was_ahead { limit / share } else { limit };
            let factor = self.factor_to(fastest, &limited.command);
            limited.scale(factor, || ProtectiveAction::BlindSector { direction_rad, limit });
        }
    }

    /// Reduces the command until the robot can stop before every return.
    fn limit_by_approach(&self, situation: &Situation<'_>, limited: &mut Limited) {
        let wanted = limited.command;
        if wanted == Twist::STOP {
            return;
        }
        let clearance = self.clearance(situation);
        let motions = |factor: f64| self.motions(situation, scaled(&wanted, factor));
        let obstruction =
            motions(1.0).find_map(|motion| motion.obstruction(situation.points, &clearance));
        let Some(first) = obstruction else {
            return;
        };
        let (mut free, mut blocked) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = f64::midpoint(free, blocked);
            let is_obstructed =
                motions(middle).any(|motion| motion.is_obstructed(situation.points, &clearance));
            if is_obstructed { blocked = middle } else { free = middle }
        }
        let factor = if free < MIN_FACTOR { 0.0 } else { free };
        limited.scale(factor, || match first {
            Obstruction::NoStandstill(within_s) => {
                ProtectiveAction::NoStandstill { factor, within_s }
            }
            Obstruction::Return(RawPoint { place: Point { x, y }, gap_m, .. }) => {
                if factor == 0.0 {
                    ProtectiveAction::Stop { x, y, gap_m }
                } else {
                    ProtectiveAction::Approach { factor, x, y }
                }
            }
        });
    }

    fn clearance(&self, situation: &Situation<'_>) -> Clearance {
        Clearance {
            margin_m: self.settings.margin_m,
            min_points: self.settings.min_points,
            approach_speed_m_s: self.settings.approach_speed_m_s,
            age_s: situation.age_s,
            was_too_near: self.was_too_near(),
        }
    }

    /// The stopping motion of a base that moves as it was commanded.
    fn commanded_motion(&self, situation: &Situation<'_>, command: &Twist) -> StoppingMotion<'_> {
        self.model().motion(&self.body, &situation.in_force(), situation.sent, command)
    }

    /// The stopping motions of a command. The base may move as commanded, follow the last command at once, or keep its measured
    /// motion until the command takes effect; only the first where these are the same.
    fn motions<'a>(
        &'a self,
        situation: &'a Situation<'_>,
        command: Twist,
    ) -> impl Iterator<Item = StoppingMotion<'a>> {
        let expected = situation.in_force();
        let newest = situation.sent.last().map_or(Twist::STOP, |(_, twist)| *twist);
        let (_, measured) = self.scans.measured().unwrap_or((0.0, expected));
        let bound = |rate: f64| rate.clamp(-MAX_MEASURED, MAX_MEASURED);
        let measured = Twist::new(bound(measured.linear), bound(measured.angular));
        let differ = |one: &Twist, other: &Twist| {
            (one.linear - other.linear).abs() > SAME_MOTION
                || (one.angular - other.angular).abs() > SAME_MOTION
        };
        let model = self.model();
        let motion =
            move |sent: &[(f64, Twist)]| model.motion(&self.body, &measured, sent, &command);
        let follows = differ(&measured, &newest) || differ(&expected, &newest);
        let keeps = differ(&measured, &expected);
        // Each is calculated when it is asked for: the first one often forbids the command.
        let commanded = move || self.commanded_motion(situation, &command);
        let at_once = follows.then_some(()).into_iter().map(move |()| motion(&[(0.0, newest)]));
        let kept = keeps.then_some(()).into_iter().map(move |()| motion(&[]));
        core::iter::once_with(commanded).chain(at_once).chain(kept)
    }

    /// Limits the speed of a robot with returns near its stopping motion.
    fn limit_near_returns(&self, situation: &Situation<'_>, limited: &mut Limited) {
        let limit = self.settings.linear_limit;
        let factor = self.factor_to(limit, &limited.command);
        let distance_m = self.settings.margin_m + self.settings.slow_margin_m;
        if factor >= 1.0 || self.settings.slow_margin_m == 0.0 {
            return;
        }
        let motion = self.commanded_motion(situation, &limited.command);
        let min_points = self.settings.min_points;
        if let Some(point) = motion.passed_return(situation.points, distance_m, min_points) {
            let Point { x, y } = point.place;
            limited.scale(factor, || ProtectiveAction::Slow { limit, x, y });
        }
    }

    fn model(&self) -> MotionModel {
        let (delay_s, deceleration_m_s2) = self.stopping();
        MotionModel {
            ramp: self.ramp.braking_with(deceleration_m_s2),
            delay_s,
            hold_s: self.period_s.max(self.settings.time_before_collision),
            step_s: self.settings.simulation_time_step,
        }
    }

    /// Factor with which a command moves every point of the body at most at a speed, m/s; at most 1.
    fn factor_to(&self, speed: f64, command: &Twist) -> f64 {
        let fastest = command.linear.abs() + command.angular.abs() * self.body.radius_m;
        if fastest > speed { speed / fastest } else { 1.0 }
    }
}

/// The inputs of the checks of a command.
struct Situation<'a> {
    points: &'a [RawPoint],
    /// Commands that were sent, by the time until they take effect, seconds.
    sent: &'a [(f64, Twist)],
    /// Age of the returns, seconds.
    age_s: f64,
}

impl Situation<'_> {
    /// The command that the base follows now.
    fn in_force(&self) -> Twist {
        let newest = self.sent.iter().rev().find(|(effect_s, _)| *effect_s <= 0.0);
        newest.or(self.sent.first()).map_or(Twist::STOP, |(_, twist)| *twist)
    }
}

/// A command between two checks, and the last action on it.
struct Limited {
    command: Twist,
    action: ProtectiveAction,
}

impl Limited {
    /// Reduces the command; the last check that reduces it is the one that is reported.
    fn scale(&mut self, factor: f64, action: impl FnOnce() -> ProtectiveAction) {
        if factor < 1.0 && self.command != Twist::STOP {
            self.command = scaled(&self.command, factor);
            self.action = action();
        }
    }
}

fn scaled(command: &Twist, factor: f64) -> Twist {
    if factor <= 0.0 {
        return Twist::STOP;
    }
    Twist::new(command.linear * factor, command.angular * factor)
}
