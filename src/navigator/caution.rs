//! How fast to drive towards people, who may turn round.

use crate::map::MovingDisc;
use crate::robot::{Footprint, Limits};

use super::outlook::Outlook;

/// Who is this much to the side of the robot's own width is passed, metres.
const BESIDE_M: f64 = 0.1;
/// Until the scans have shown that somebody turned, seconds: the tracker takes about half a second to be sure of a motion,
/// and most of that of a change.
const NOTICED_S: f64 = 0.4;
/// The robot stands this far off when somebody reaches it, metres.
const LEFT_M: f64 = 0.05;

/// The highest speed, m/s, from which the robot stands before somebody ahead of it would reach it if he came straight at it
/// from now on, at the pace that he has. A robot that follows somebody keeps its distance by it.
pub(super) fn cautious_speed(
    now: &Outlook,
    footprint: &Footprint,
    limits: &Limits,
    delay_s: f64,
) -> f64 {
    let half_width_m = footprint
        .discs()
        .iter()
        .map(|disc| disc.y.abs() + disc.radius)
        .fold(0.0, f64::max);
    let is_ahead = |disc: &&MovingDisc| {
        let place = now.pose.inverse_transform(&disc.center());
        place.x > 0.0 && place.y.abs() < half_width_m + disc.radius + BESIDE_M
    };
    let braking = -limits.decel_lim_x;
    let delay_s = delay_s + NOTICED_S;
    let speed = |disc: &MovingDisc| {
        let gap_m = footprint.gap_to_disc_m(&now.pose, &disc.center(), disc.radius);
        let pace = libm::hypot(disc.vx, disc.vy);
        // v delay + v^2 / 2a + pace (delay + v / a) = gap, solved for v.
        let linear_s = delay_s + pace / braking;
        let left_m = (gap_m - LEFT_M - pace * delay_s).max(0.0);
        braking * ((linear_s * linear_s + 2.0 * left_m / braking).sqrt() - linear_s)
    };
    let ahead = now.moving.iter().filter(is_ahead);
    ahead.map(speed).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Pose, Twist};

    fn speed(x: f64, y: f64, vx: f64) -> f64 {
        let disc = MovingDisc {
            x,
            y,
            radius: 0.3,
            vx,
            vy: 0.0,
        };
        let now = Outlook {
            time_s: 0.0,
            pose: Pose::default(),
            twist: Twist::STOP,
            moving: vec![disc],
        };
        let footprint = Footprint::round(0.3).expect("a sound radius");
        cautious_speed(&now, &footprint, &Limits::default(), 0.1)
    }

    #[test]
    fn both_together_use_up_the_gap() {
        for (x, vx) in [(1.2, 0.0), (1.6, 0.75), (3.0, -0.5), (8.0, 1.5)] {
            let fast = speed(x, 0.0, vx);
            let stopping_s = 0.5 + fast;
            let way_m = fast * 0.5 + fast * fast / 2.0 + libm::fabs(vx) * stopping_s;
            assert!((way_m - (x - 0.65)).abs() < 1e-9, "{x}, {vx}: {fast}");
        }
    }

    #[test]
    fn who_is_behind_or_beside_is_no_reason_to_slow_down() {
        assert_eq!(speed(-1.0, 0.0, 1.0), f64::INFINITY);
        assert_eq!(speed(1.0, 0.8, -1.0), f64::INFINITY);
        assert!(speed(0.7, 0.0, -1.0) < 1e-9 && speed(0.5, 0.0, 0.0) < 1e-9);
    }
}
