//! Planners that are wrong on purpose: they test the protective layer without a correct planner.

use core::f64::consts::PI;
use std::collections::VecDeque;

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::fault_injection::active_faults;
use super::{FaultInjection, RngStream, WrongPlanner, generator};
use crate::geometry::{Point, Pose, Twist, bearing, wrap_angle};
use crate::map::MovingDisc;
use crate::robot::Limits;

/// Age of the commands that are repeated, seconds.
const OLD_S: f64 = 10.0;

/// Distance within which it drives at a person, metres.
const PERSON_M: f64 = 6.0;

/// Longest time of a direction, and of a random command, seconds.
const DIRECTION_S: f64 = 6.0;
const RANDOM_S: f64 = 2.0;

/// Speed that no base reaches, m/s.
const TOO_FAST_M_S: f64 = 1e3;

/// Angle off the heading within which it drives at full speed, radians.
const AHEAD_RAD: f64 = 0.8;

/// Replaces commands by wrong ones.
#[derive(Clone, Debug)]
pub(super) struct WrongCommands {
    kind: WrongPlanner,
    /// What [`WrongPlanner::Mixed`] is with this seed.
    mixed: WrongPlanner,
    limits: Limits,
    rng: Pcg64Mcg,
    /// The present direction in the map, radians, or random command, and its end.
    direction: f64,
    random: Twist,
    until_s: f64,
    /// The planner's own commands.
    own: VecDeque<(f64, Twist)>,
}

impl WrongCommands {
    pub fn new(kind: WrongPlanner, limits: Limits, seed: u64) -> Self {
        let mixed = match seed % 3 {
            0 => WrongPlanner::Obstacles,
            1 => WrongPlanner::Random,
            _ => WrongPlanner::Old,
        };
        Self {
            kind,
            mixed,
            limits,
            rng: generator(seed, RngStream::WrongPlanner),
            direction: 0.0,
            random: Twist::STOP,
            until_s: f64::NEG_INFINITY,
            own: VecDeque::new(),
        }
    }

    /// The command instead of the planner's own, at a time, seconds, of a robot at a true pose among people. A wrong planner
    /// among the faults comes before that of the settings.
    pub fn instead(
        &mut self,
        own: &Twist,
        faults: &[FaultInjection],
        time_s: f64,
        pose: &Pose,
        people: &[MovingDisc],
    ) -> Twist {
        let injected = active_faults(faults, time_s).find_map(|fault| match fault {
            FaultInjection::WrongPlanner { planner, .. } => Some(*planner),
            _ => None,
        });
        let kind = injected.unwrap_or(self.kind);
        match if kind == WrongPlanner::Mixed { self.mixed } else { kind } {
            WrongPlanner::Off | WrongPlanner::Mixed => *own,
            WrongPlanner::Obstacles => self.at_obstacles(time_s, pose, people),
            WrongPlanner::Random => self.random(time_s),
            WrongPlanner::Old => self.old(own, time_s),
            WrongPlanner::NotFinite => Twist::new(f64::NAN, f64::INFINITY),
            WrongPlanner::TooFast => Twist::new(TOO_FAST_M_S, 0.0),
        }
    }

    fn at_obstacles(&mut self, time_s: f64, pose: &Pose, people: &[MovingDisc]) -> Twist {
        if time_s >= self.until_s {
            self.until_s = time_s + self.rng.random_range(1.0..DIRECTION_S);
            self.direction = self.rng.random_range(-PI..PI);
        }
        let away_m = |place: &Point| (*place - pose.position()).norm();
        let nearest = people
            .iter()
            .map(MovingDisc::center)
            .min_by(|one, other| away_m(one).total_cmp(&away_m(other)));
        let direction = nearest
            .filter(|place| away_m(place) < PERSON_M)
            .map_or(self.direction, |place| bearing(&pose.position(), &place));
        let off = wrap_angle(direction - pose.yaw);
        let linear = if off.abs() < AHEAD_RAD { self.limits.max_vel_x } else { 0.0 };
        self.limits.clamp(&Twist::new(linear, 2.0 * off))
    }

    fn random(&mut self, time_s: f64) -> Twist {
        if time_s >= self.until_s {
            self.until_s = time_s + self.rng.random_range(0.0..RANDOM_S);
            let Limits { min_vel_x, max_vel_x, max_vel_theta, .. } = self.limits;
            let mut within =
                |least: f64, most: f64| least + (most - least) * self.rng.random::<f64>();
            self.random =
                Twist::new(within(min_vel_x, max_vel_x), within(-max_vel_theta, max_vel_theta));
        }
        self.random
    }

    /// Before there are old commands: straight ahead.
    fn old(&mut self, own: &Twist, time_s: f64) -> Twist {
        self.own.push_back((time_s, *own));
        while self.own.get(1).is_some_and(|(sent_s, _)| time_s - sent_s >= OLD_S) {
            self.own.pop_front();
        }
        let oldest = self.own.front().filter(|(sent_s, _)| time_s - sent_s >= OLD_S);
        oldest.map_or(Twist::new(self.limits.max_vel_x, 0.0), |(_, twist)| *twist)
    }
}
