//! Evades moving obstacles that come at a slow robot.
//!
//! Where no sample of the dynamic window is admissible, the robot stops, and an approaching obstacle hits it. A robot that would
//! be hit where it is chooses the motion with the greatest distance to all moving obstacles for some seconds, wherever
//! that leads.

use super::super::state::State;
use super::super::{Decision, Mode};
use super::Override;
use crate::geometry::Twist;
use crate::map::MovingDisc;

/// Time and time step of the prediction, seconds.
const HORIZON_S: f64 = 3.0;
const STEP_S: f64 = 0.1;
/// A robot evades an obstacle that would come nearer than this, metres.
const EVADED_GAP_M: f64 = 0.1;
/// More distance than this has no further value, metres.
const ENOUGH_GAP_M: f64 = 0.7;
/// An obstacle below this speed does not approach, m/s.
const MIN_APPROACH_SPEED: f64 = 0.15;
/// Least gain in distance over standing, metres.
const MIN_GAIN_M: f64 = 0.02;
/// Tried shares of the highest forward, backward and turning speeds.
const FORWARD: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
const BACKWARD: [f64; 2] = [0.5, 1.0];
const TURNING: [f64; 9] = [0.0, 0.25, -0.25, 0.5, -0.5, 0.75, -0.75, 1.0, -1.0];

/// A decision to leave the path of an approaching obstacle; `None` where there is none, or the robot drives on.
pub(super) fn replacement(state: &State<'_>, allowed: Override) -> Option<Decision> {
    if allowed == Override::Never || !state.settings.features.recovery {
        return None;
    }
    let wanted = safest_motion(state)?;
    Some(Decision { command: state.towards(&wanted), ..state.stand(Mode::Evading) })
}

/// The motion with the greatest distance to all moving obstacles; `None` where standing is safe, or no motion is better.
fn safest_motion(state: &State<'_>) -> Option<Twist> {
    let moving = &state.now.moving;
    let approaches = |disc: &&MovingDisc| libm::hypot(disc.vx, disc.vy) >= MIN_APPROACH_SPEED;
    let approaching: Vec<MovingDisc> = moving.iter().filter(approaches).copied().collect();
    if min_gap_m(state, &Twist::STOP, &approaching)? >= EVADED_GAP_M {
        return None;
    }
    // Never hits one obstacle to avoid another, not even more gently; stops if no escape is clear.
    let least_m = if state.settings.features.passive_safety { 0.0 } else { f64::NEG_INFINITY };
    let standing_m = min_gap_m(state, &Twist::STOP, moving)?.max(least_m);
    let limits = &state.robot.limits;
    let backward = BACKWARD.map(|share| share * limits.min_vel_x.min(0.0));
    let forward = FORWARD.map(|share| share * limits.max_vel_x);
    let mut best = (standing_m + MIN_GAIN_M, None);
    for linear in forward.into_iter().chain(backward) {
        for share in TURNING {
            let wanted = Twist::new(linear, share * limits.max_vel_theta);
            let Some(gap_m) = min_gap_m(state, &wanted, moving) else {
                continue;
            };
            let gap_m = gap_m.min(ENOUGH_GAP_M);
            if gap_m > best.0
                && can_stop_clear(state, &wanted)
                && state.is_safe_towards(&wanted)
                && state.is_path_visible(&wanted)
            {
                best = (gap_m, Some(wanted));
            }
        }
    }
    best.1
}

/// Whether a robot that starts towards a velocity, and brakes from the next decision on, touches nothing static.
fn can_stop_clear(state: &State<'_>, wanted: &Twist) -> bool {
    let limits = &state.robot.limits;
    let (pose, twist) = limits.advance(&state.now.pose, &state.now.twist, wanted, STEP_S);
    for (pose, twist) in limits.braking(pose, twist, STEP_S) {
        if twist.linear == 0.0 {
            return true;
        }
        if !state.inflated.is_clear_of_static(state.field, &pose) {
            return false;
        }
    }
    false
}

/// The least distance to obstacles on a motion towards a velocity at the acceleration limits, metres; `None` where a static
/// obstacle is on that path.
fn min_gap_m(state: &State<'_>, wanted: &Twist, obstacles: &[MovingDisc]) -> Option<f64> {
    let (mut pose, mut twist) = (state.now.pose, state.now.twist);
    let mut least_m = f64::INFINITY;
    for step in 1..=(HORIZON_S / STEP_S) as u32 {
        let before = twist;
        (pose, twist) = state.robot.limits.advance(&pose, &twist, wanted, STEP_S);
        let moves = before != Twist::STOP || twist != Twist::STOP;
        if moves && !state.inflated.is_clear_of_static(state.field, &pose) {
            return None;
        }
        let gap_m = |disc: &MovingDisc| state.robot.footprint.gap_to_moving_m(&pose, disc);
        for disc in obstacles {
            least_m = least_m.min(gap_m(&disc.after(f64::from(step) * STEP_S)));
            // The obstacle may have stopped or turned: its present place counts as occupied too.
            if moves && state.settings.features.passive_safety {
                least_m = least_m.min(gap_m(disc));
            }
        }
    }
    Some(least_m)
}
