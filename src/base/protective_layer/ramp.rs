//! The ramp by which a sender approaches a target.

use crate::geometry::Twist;
use crate::robot::{Limits, TickTime, TrackLimits, TrackedDrive};

/// How the commands of a sender change from one to the next.
#[derive(Clone, Copy, Debug)]
pub(super) enum Ramp {
    /// Forward speed and turn rate have limits of their own.
    Twist(Limits),
    /// Each track has limits, and both reach their targets together, as [`Mixer`](crate::robot::Mixer) does it.
    Tracks { drive: TrackedDrive, limits: TrackLimits },
}

impl Ramp {
    /// The command after a time, seconds, or at a tick, of the change to a target.
    pub fn towards(&self, twist: &Twist, target: &Twist, time: impl Into<TickTime>) -> Twist {
        match self {
            Self::Twist(limits) => limits.reachable(twist, target, time),
            Self::Tracks { drive, limits } => {
                let target = limits.scale_to_max(&drive.tracks(target));
                drive.twist(&limits.reachable(&drive.tracks(twist), &target, time))
            }
        }
    }

    /// The command that the base can follow: a faster one is that at its largest speeds.
    pub fn within_limits(&self, command: &Twist) -> Twist {
        match self {
            Self::Twist(limits) => limits.clamp(command),
            Self::Tracks { drive, limits } => {
                let tracks = drive.tracks(command);
                let scaled = limits.scale_to_max(&tracks);
                if scaled == tracks { *command } else { drive.twist(&scaled) }
            }
        }
    }

    /// The command after a time, seconds, or at a tick, of braking as hard as the limits allow.
    pub fn brake(&self, twist: &Twist, time: impl Into<TickTime>) -> Twist {
        match self {
            Self::Twist(limits) => limits.brake(twist, time),
            Self::Tracks { .. } => self.towards(twist, &Twist::STOP, time),
        }
    }

    /// The same ramp of a base that brakes with a deceleration, m/s^2. A turn brakes with the same share of its own limit. Tracks
    /// brake at most with their limit: the sender does not ask for more.
    pub fn braking_with(&self, deceleration_m_s2: f64) -> Self {
        match *self {
            Self::Twist(limits) => {
                let share = deceleration_m_s2 / -limits.decel_lim_x;
                Self::Twist(Limits {
                    decel_lim_x: -deceleration_m_s2,
                    decel_lim_theta: limits.decel_lim_theta * share,
                    ..limits
                })
            }
            Self::Tracks { drive, limits } => {
                let decel_lim_track = limits.decel_lim_track.max(-deceleration_m_s2);
                Self::Tracks { drive, limits: TrackLimits { decel_lim_track, ..limits } }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Mixer;

    const DRIVE: TrackedDrive = TrackedDrive { track_width_m: 0.5 };

    #[test]
    fn only_a_command_beyond_the_limits_is_changed() {
        let twist = Limits { min_vel_x: -0.3, ..Limits::default() };
        let tracks = Ramp::Tracks { drive: DRIVE, limits: TrackLimits::default() };
        for ramp in [Ramp::Twist(twist), tracks] {
            for command in [Twist::STOP, Twist::new(0.3, 0.1), Twist::new(-0.1, -0.3)] {
                assert_eq!(ramp.within_limits(&command), command);
            }
            let most = ramp.within_limits(&Twist::new(1e3, 0.0));
            assert!((0.1..=2.0).contains(&most.linear) && most.angular == 0.0, "{most:?}");
        }
    }

    #[test]
    fn tracks_follow_the_ramp_of_the_mixer() {
        let limits = TrackLimits::default();
        let ramp = Ramp::Tracks { drive: DRIVE, limits };
        let targets =
            [Twist::new(1.0, 0.5), Twist::new(-0.5, 1.0), Twist::new(3.0, 2.0), Twist::STOP];
        let mut mixer = Mixer::new(DRIVE, TrackLimits { deadband: 0.0, ..limits });
        let mut twist = Twist::STOP;
        for cycle in 0..200 {
            let target = targets[cycle / 50];
            let sent = mixer.twist(&mixer.clone().mix(&target, 0.02));
            mixer.mix(&target, 0.02);
            let brakes = target == Twist::STOP;
            twist =
                if brakes { ramp.brake(&twist, 0.02) } else { ramp.towards(&twist, &target, 0.02) };
            let (linear, angular) = (twist.linear - sent.linear, twist.angular - sent.angular);
            assert!(linear.abs() + angular.abs() < 1e-9, "{cycle}: {twist:?} {sent:?}");
        }
        assert_eq!(twist, Twist::STOP);
    }

    #[test]
    fn tracks_brake_with_the_weaker_of_limit_and_measurement() {
        let limits = TrackLimits { decel_lim_track: -0.5, ..TrackLimits::default() };
        let ramp = Ramp::Tracks { drive: DRIVE, limits };
        for (measured, expected) in [(1.0, 0.5), (0.2, 0.2)] {
            let braked = ramp.braking_with(measured).brake(&Twist::new(1.0, 0.0), 1.0);
            assert!((braked.linear - (1.0 - expected)).abs() < 1e-12, "{measured}: {braked:?}");
        }
    }
}
