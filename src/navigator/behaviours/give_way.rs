//! Gives way to people early: leaves the path of a person seconds before the person is there.
//!
//! Near a person passive safety forbids nearly every motion, and a robot that stands there is walked into. So the robot compares
//! what the predictions of people cost: to follow its route, to follow it slower, to stand, and to drive to a place nearby.

use core::f64::consts::{PI, TAU};

use super::super::predictions::{Person, STEP_S, STEPS};
use super::super::state::State;
use super::super::{Decision, Fault, Mode};
use super::{Behaviour, Override, Proposal, evasion};
use crate::geometry::{Point, Pose, Twist, Vector, bearing, wrap_angle};

/// The robot gives way where the expected closeness on its route is above this, and until it is below half of it.
const ACCEPTED: f64 = 0.3;
/// What it costs to be slower, to stand, and to leave the route, in the same unit: a choice between equal closeness.
const SLOWER_COST: f64 = 0.03;
const STANDING_COST: f64 = 0.06;
const LEAVING_COST: f64 = 0.08;
/// What a metre of distance costs, and what a metre towards the local target is worth.
const METRE_COST: f64 = 0.02;
/// What it is worth to keep the chosen place: the robot does not dither between two.
const KEPT_GAIN: f64 = 0.05;
/// Tried shares of the highest speed along the route.
const SLOWER: [f64; 2] = [0.6, 0.3];
/// Tried directions, and distances of a place, metres.
const DIRECTIONS: u32 = 16;
const DISTANCES_M: [f64; 4] = [0.6, 1.0, 1.5, 2.2];
/// Ways to drive to a place: the share of the speed while the place is not ahead, and whether the robot reverses.
const MANNERS: [(f64, bool); 3] = [(0.0, false), (0.4, false), (0.0, true)];
/// The robot has arrived within this distance of a place, metres.
const ARRIVED_M: f64 = 0.1;
/// A place within this angle is ahead, radians.
const AHEAD_RAD: f64 = 0.6;
/// Turn rate for an angle, 1/s.
const TURNING_GAIN: f64 = 2.5;
/// Share of the braking deceleration that the approach to a place uses.
const APPROACH: f64 = 0.6;
/// Distance of the point on the route that a rollout heads for, metres.
const AIM_M: f64 = 1.0;
/// What a rollout assumes of passive safety: reaction, seconds, speed of a person, m/s, and distance kept, metres.
const REACTION_S: f64 = 0.3;
const PERSON_SPEED: f64 = 1.4;
const KEPT_M: f64 = 0.1;
/// Obstacles further behind than this do not limit the speed, metres.
const BEHIND_M: f64 = 0.1;

/// Leaves the path of people early.
#[derive(Default)]
pub(super) struct GiveWay {
    /// The place that the robot drives to.
    place: Option<Point>,
}

/// A predicted motion.
struct Motion {
    /// The pose at each predicted time.
    poses: Vec<Pose>,
    /// The velocity that it starts towards.
    first: Twist,
}

/// What the robot may do.
#[derive(Clone, Copy)]
enum Choice {
    /// Follow its route at a share of the highest speed.
    Follow(f64),
    Stand,
    /// Drive to a place, at first towards a velocity.
    Leave(Point, Twist),
}

impl Behaviour for GiveWay {
    fn propose(&mut self, state: &State<'_>) -> Result<Option<Proposal>, Fault> {
        let kept = self.place.take();
        let predictions = &state.now.predictions;
        if !state.settings.features.recovery || predictions.is_empty() {
            return Ok(None);
        }
        let cost = |motion: &Motion| predictions.cost(&state.robot.footprint, &motion.poses);
        let standing_cost = cost(&standing(state));
        let fastest = state.robot.limits.max_vel_x;
        // A robot that parks hardly moves.
        let following_cost = |share: f64| {
            if state.is_at_goal { standing_cost } else { cost(&following(state, share * fastest)) }
        };
        let full_cost = following_cost(1.0);
        let accepted = if kept.is_some() { ACCEPTED / 2.0 } else { ACCEPTED };
        if full_cost < accepted {
            return Ok(None);
        }
        let mut best = (full_cost, Choice::Follow(1.0));
        let slower =
            SLOWER.map(|share| (following_cost(share) + SLOWER_COST, Choice::Follow(share)));
        for choice in slower.into_iter().chain([(standing_cost + STANDING_COST, Choice::Stand)]) {
            if choice.0 < best.0 {
                best = choice;
            }
        }
        for (place, place_cost) in places(state, kept) {
            for manner in MANNERS {
                // Its prediction cannot make it cheaper.
                if place_cost >= best.0 {
                    break;
                }
                let Some(motion) = driving(state, &place, manner) else {
                    continue;
                };
                let total = cost(&motion) + place_cost;
                if total < best.0
                    && evasion::can_stop_clear(state, &motion.first)
                    && state.is_safe_towards(&motion.first)
                    && state.sees_way_of(&motion.first)
                {
                    best = (total, Choice::Leave(place, motion.first));
                }
            }
        }
        let stand = state.stand(Mode::Evading);
        Ok(match best.1 {
            Choice::Follow(1.0) => None,
            Choice::Follow(share) => Some(Proposal::SpeedLimit(share * fastest)),
            Choice::Stand => Some(Proposal::Decide(stand, Override::Never)),
            Choice::Leave(place, wanted) => {
                self.place = Some(place);
                let command = state.towards(&wanted);
                Some(Proposal::Decide(Decision { command, ..stand }, Override::Never))
            }
        })
    }
}

/// Places around the robot with what they cost without people, and the place that it drives to.
fn places(state: &State<'_>, kept: Option<Point>) -> impl Iterator<Item = (Point, f64)> {
    let Pose { yaw, .. } = state.now.pose;
    let robot = state.now.pose.position();
    let to_target = state.local_target - robot;
    let ahead = to_target / to_target.norm().max(f64::MIN_POSITIVE);
    let place_cost = move |place: &Point| {
        let away = *place - robot;
        LEAVING_COST + METRE_COST * (away.norm() - away.dot(&ahead))
    };
    let kept = kept.map(|place| (place, place_cost(&place) - KEPT_GAIN));
    let around = (0..DIRECTIONS).flat_map(move |number| {
        let (sin, cos) = libm::sincos(yaw + TAU * f64::from(number) / f64::from(DIRECTIONS));
        DISTANCES_M.map(|far_m| robot + Vector::new(cos, sin) * far_m)
    });
    kept.into_iter().chain(around.map(move |place| (place, place_cost(&place))))
}

/// Brakes and stands.
fn standing(state: &State<'_>) -> Motion {
    let (mut pose, mut twist) = (state.now.pose, state.now.twist);
    let step = |_| {
        (pose, twist) = state.robot.limits.advance_braking(&pose, &twist, STEP_S);
        pose
    };
    Motion { poses: (0..STEPS).map(step).collect(), first: Twist::STOP }
}

/// Follows the route at a speed, m/s, as far as people allow it.
fn following(state: &State<'_>, speed: f64) -> Motion {
    let (mut pose, mut twist) = (state.now.pose, state.now.twist);
    let mut along_m = state.route.progress_m;
    let step = |step: usize| {
        let aim = state.route.path.point_at(along_m + AIM_M);
        let speed = speed.min(speed_near_people(state, &pose, step, false));
        let wanted = towards(state, &pose, &aim, speed, 0.0);
        (pose, twist) = state.robot.limits.advance(&pose, &twist, &wanted, STEP_S);
        along_m += twist.linear * STEP_S;
        pose
    };
    Motion { poses: (0..STEPS).map(step).collect(), first: Twist::STOP }
}

/// Drives to a place and stands there; `None` where a static obstacle is in the way.
fn driving(
    state: &State<'_>,
    place: &Point,
    (turning_share, reverses): (f64, bool),
) -> Option<Motion> {
    let limits = &state.robot.limits;
    if reverses && limits.min_vel_x >= 0.0 {
        return None;
    }
    let (mut pose, mut twist) = (state.now.pose, state.now.twist);
    let mut first = None;
    let mut has_arrived = false;
    let mut poses = Vec::with_capacity(STEPS);
    for step in 0..STEPS {
        let left_m = (*place - pose.position()).norm();
        has_arrived |= left_m < ARRIVED_M;
        let stops_in_time = (-2.0 * APPROACH * limits.decel_lim_x * left_m).sqrt();
        let speed = stops_in_time.min(speed_near_people(state, &pose, step, reverses));
        let wanted = if has_arrived {
            Twist::STOP
        } else if reverses {
            let turned = Pose::new(pose.x, pose.y, wrap_angle(pose.yaw + PI));
            let speed = speed.min(-limits.min_vel_x);
            let forwards = towards(state, &turned, place, speed, turning_share);
            Twist::new(-forwards.linear, forwards.angular)
        } else {
            towards(state, &pose, place, speed.min(limits.max_vel_x), turning_share)
        };
        first.get_or_insert(wanted);
        let before = twist;
        (pose, twist) = limits.advance(&pose, &twist, &wanted, STEP_S);
        let moves = before != Twist::STOP || twist != Twist::STOP;
        if moves && !state.inflated.is_clear_of_static(state.field, &pose) {
            return None;
        }
        poses.push(pose);
    }
    Some(Motion { poses, first: first? })
}

/// The velocity from a pose towards a point: at a speed, m/s, where it is ahead, else turning at a share of it.
fn towards(state: &State<'_>, pose: &Pose, point: &Point, speed: f64, turning_share: f64) -> Twist {
    let most = state.robot.limits.max_vel_theta;
    let error = wrap_angle(bearing(&pose.position(), point) - pose.yaw);
    let share = if error.abs() < AHEAD_RAD { libm::cos(error) } else { turning_share };
    Twist::new(share * speed, (TURNING_GAIN * error).clamp(-most, most))
}

/// The speed that passive safety allows at a pose in a rollout, m/s, as it follows from the distance to people ahead.
fn speed_near_people(state: &State<'_>, pose: &Pose, step: usize, reverses: bool) -> f64 {
    if !state.settings.features.passive_safety {
        return f64::INFINITY;
    }
    let braking = -state.robot.limits.decel_lim_x;
    let reach_m = state.robot.footprint.circumscribed_radius_m();
    let (sin, cos) = libm::sincos(if reverses { pose.yaw + PI } else { pose.yaw });
    let heading = Vector::new(cos, sin);
    let speed = |person: &Person| {
        let disc = person.disc.after(step as f64 * STEP_S);
        let away = disc.center() - pose.position();
        if away.dot(&heading) < -BEHIND_M {
            return f64::INFINITY;
        }
        let gap_m = away.norm() - disc.radius - reach_m - KEPT_M;
        // Robot and person together use up the gap: v t + v^2 / 2a + p (t + v / a) = gap.
        let (linear, left_m) =
            (REACTION_S + PERSON_SPEED / braking, gap_m - PERSON_SPEED * REACTION_S);
        let root = linear * linear + 2.0 * left_m.max(0.0) / braking;
        (root.sqrt() - linear) * braking
    };
    state.now.predictions.people.iter().map(speed).fold(f64::INFINITY, f64::min)
}
