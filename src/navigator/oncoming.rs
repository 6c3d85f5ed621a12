//! People who walk towards the robot along its roadway, and the ground that they will walk over.
//!
//! Two that meet in a roadway pass each other if each keeps to a side early. A robot that keeps to the middle stops in front of such
//! a person, or reverses before them all the way. So the robot plans a path beside the ground of the person, and stays on its side.

use super::state::State;
use crate::geometry::{Point, Pose, Vector};
use crate::map::MovingDisc;

/// A path beside a person may be longer by this, metres.
pub(super) const LONGEST_DETOUR_M: f64 = 1.0;
/// Time from a search without room beside a person to the next one, seconds.
pub(super) const NO_ROOM_S: f64 = 1.0;

/// In a roadway, a wall is within this distance of the robot's body everywhere on the next part of its path, metres. On open ground
/// the dynamic window avoids people sooner than a new path would.
const ROADWAY_M: f64 = 1.5;
const ROADWAY_AHEAD_M: f64 = 3.0;
/// A slower person does not come, m/s.
const MIN_SPEED: f64 = 0.3;
/// The person comes if path and way are opposite to within 30 degrees, and the way leads to the robot to within 30 degrees: cosine of
/// the first angle.
const OPPOSITE: f64 = -0.866;
/// The tracker knows the velocity of a person to this, m/s: 10 m farther that is more than the width of a roadway.
const NOISE: f64 = 0.15;
/// The direction of the roadway is that of the path this far beyond the person, metres: where it does not lead past the person.
const BEYOND_M: f64 = 3.0;
/// The path must keep clear of where the person walks within this time, seconds. A new path keeps clear of it for longer, so that
/// the next scan does not ask for another one.
const CHECKED_S: f64 = 4.0;
const PLANNED_S: f64 = 10.0;
/// Distance between two discs on the way of the person, and between two points of the path, metres.
const STEP_M: f64 = 0.2;
/// Share of the radius of a person that the path keeps clear of: the local planner sees the person as a whole.
const RADIUS_SHARE: f64 = 0.67;
/// The robot has this much room around the circle in which it turns for its step to the side, metres.
const ROOM_TO_TURN_M: f64 = 0.8;
/// A robot that passes a person at one side does not change sides: on the other side, this many discs next to each other are closed.
const CLOSED_DISCS: u32 = 3;
/// A path nearer than this to where the person walks has no side yet, metres.
const NO_SIDE_M: f64 = 0.2;
/// A person who comes is met up to this many times the checked length of the path away; one who stands, up to this distance, metres.
const MET_WITHIN: f64 = 1.5;
const NEXT_TO_M: f64 = 3.0;

/// What the path of the robot leads past.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum PathKind {
    /// No people who come.
    #[default]
    Usual,
    /// People who come along the roadway.
    PastPeople,
}

impl PathKind {
    /// The kind while the robot meets people; the usual one afterwards.
    pub fn while_met(self, state: &State<'_>) -> Self {
        if is_met(state) { self } else { Self::Usual }
    }
}

/// The ground that people who come along the path will walk over, as discs; none where the path keeps clear of it. The robot turns
/// within a radius, metres. A robot that has a path past them stays on its side.
pub(super) fn ground_of_oncoming(state: &State<'_>, turning_m: f64) -> Vec<MovingDisc> {
    if state.now.walkers.is_empty() || !is_in_roadway(state) {
        return Vec::new();
    }
    let robot = state.now.pose.position();
    let has_room = |disc: &MovingDisc| {
        (disc.center() - robot).norm() > disc.radius + turning_m + ROOM_TO_TURN_M
    };
    let ahead_m = state.settings.path_check_distance_m;
    let path: Vec<Pose> = state.route.poses_ahead(ahead_m, STEP_M).collect();
    let clear_m = state.robot.footprint.passing_radius_m();
    let mut ground = Vec::new();
    for person in &state.now.walkers {
        let Some(walk) = Walk::new(state, person, &path) else { continue };
        if !walk.meets(clear_m) {
            continue;
        }
        let closed = state.is_past_people().then(|| walk.other_side()).flatten();
        for disc in walk.ground(PLANNED_S).take_while(has_room) {
            let aside = |step: u32| closed.unwrap_or_default() * f64::from(step);
            let discs = (0..=if closed.is_some() { CLOSED_DISCS } else { 0 }).map(|step| {
                let place = disc.center() + aside(step);
                MovingDisc { x: place.x, y: place.y, ..disc }
            });
            ground.extend(discs.filter(has_room));
        }
    }
    ground
}

/// Whether a person comes from ahead, or is next to the robot and not behind it.
fn is_met(state: &State<'_>) -> bool {
    let robot = state.now.pose.position();
    let along = state.route.path.direction_at(state.route.progress_m);
    let reach_m = MET_WITHIN * state.settings.path_check_distance_m;
    state.now.walkers.iter().any(|disc| {
        let to_disc = disc.center() - robot;
        let comes = along.dot(&Vector::new(disc.vx, disc.vy)) < 0.0;
        let within_m = if comes { reach_m } else { NEXT_TO_M };
        to_disc.norm() < within_m && to_disc.dot(&along) > -disc.radius
    })
}

fn is_in_roadway(state: &State<'_>) -> bool {
    let room_m = |pose: &Pose| state.field.clearance_m(&state.robot.footprint, pose);
    state
        .route
        .poses_ahead(ROADWAY_AHEAD_M, STEP_M)
        .all(|pose| room_m(&pose).is_some_and(|room_m| room_m < ROADWAY_M))
}

/// The way of a person who comes along the path.
struct Walk {
    person: MovingDisc,
    velocity: Vector,
    /// The points of the path ahead at which the person comes.
    path: Vec<Point>,
}

impl Walk {
    /// `None` for a person who stands, or walks elsewhere.
    fn new(state: &State<'_>, person: &MovingDisc, path: &[Pose]) -> Option<Self> {
        let velocity = along_roadway(state, person);
        let speed = velocity.norm();
        let to_robot = state.now.pose.position() - person.center();
        let is_towards = velocity.dot(&to_robot) > -OPPOSITE * speed * to_robot.norm();
        let comes = |pose: &&Pose| {
            let along = Vector::new(libm::cos(pose.yaw), libm::sin(pose.yaw));
            along.dot(&velocity) < OPPOSITE * speed
                && (pose.position() - person.center()).dot(&velocity) > 0.0
        };
        let path: Vec<Point> = path.iter().filter(comes).map(Pose::position).collect();
        let radius = RADIUS_SHARE * person.radius;
        let person = MovingDisc { radius, vx: velocity.x, vy: velocity.y, ..*person };
        (speed >= MIN_SPEED && is_towards && !path.is_empty()).then_some(Self {
            person,
            velocity,
            path,
        })
    }

    /// The ground of the next time, seconds.
    fn ground(&self, time_s: f64) -> impl Iterator<Item = MovingDisc> + '_ {
        let speed = self.velocity.norm();
        let steps = 0..=(speed * time_s / STEP_M) as u32;
        steps.map(move |step| self.person.after(f64::from(step) * STEP_M / speed))
    }

    /// Whether the path leads nearer than this, metres, to where the person soon walks.
    fn meets(&self, clear_m: f64) -> bool {
        self.ground(CHECKED_S).any(|disc| {
            self.path.iter().any(|at| (disc.center() - at).norm() < disc.radius + clear_m)
        })
    }

    /// The step from a disc to the next one at the side of the person on which the path does not pass; `None` before it has a side.
    fn other_side(&self) -> Option<Vector> {
        let left = Vector::new(-self.velocity.y, self.velocity.x) / self.velocity.norm();
        let offsets_m = self.path.iter().map(|at| (at - self.person.center()).dot(&left));
        let side_m = offsets_m.max_by(|one, other| one.abs().total_cmp(&other.abs()))?;
        let step_m = 2.0 * self.person.radius;
        (side_m.abs() > NO_SIDE_M).then(|| left * (-side_m.signum() * step_m))
    }
}

/// The velocity of a person, m/s, without a part across the path that may be noise.
fn along_roadway(state: &State<'_>, person: &MovingDisc) -> Vector {
    let velocity = Vector::new(person.vx, person.vy);
    let path = &state.route.path;
    let beyond = path.direction_at(path.project(&person.center()).arc_m + BEYOND_M);
    let across = Vector::new(-beyond.y, beyond.x);
    velocity - across * velocity.dot(&across).clamp(-NOISE, NOISE)
}

#[cfg(test)]
mod tests {
    use super::super::predicted_state::PredictedState;
    use super::super::test_state::{standing_at, with_state};
    use super::super::{NavigatorSettings, RobotModel};
    use super::*;
    use crate::geometry::Twist;
    use crate::map::{Cell, GridFrame, ObstacleGrid};
    use crate::robot::{Footprint, Limits};

    /// The ground of a person in a roadway of a width, metres, for a robot at the origin whose path leads 3 m along x.
    fn ground(width_m: f64, person: (f64, f64, f64, f64), kind: PathKind) -> Vec<MovingDisc> {
        let settings = NavigatorSettings::default();
        let footprint = Footprint::round(0.25).expect("a radius");
        let robot = RobotModel { footprint, limits: Limits::default() };
        let frame = GridFrame::new(160, 80, 0.1, Pose::new(-4.0, -4.0, 0.0)).expect("a size");
        let mut obstacles = ObstacleGrid::filled(frame, false);
        for column in 0..160 {
            for side in [-1.0, 1.0] {
                let row = (40.0 + side * width_m / 0.2) as i32;
                obstacles.set(Cell::new(column, row), true);
            }
        }
        let (x, y, vx, vy) = person;
        let walkers = vec![MovingDisc { x, y, radius: 0.3, vx, vy }];
        let now = PredictedState { walkers, ..standing_at(Pose::default()) };
        with_state(&settings, &robot, &obstacles, &now, (Twist::STOP, Twist::STOP), |state| {
            state.path_kind = kind;
            let ground = ground_of_oncoming(state, 0.3);
            let is_next = x > 0.0 && (vx < 0.0 || x < 3.0);
            assert_eq!(is_met(state), is_next, "{person:?}");
            ground
        })
    }

    #[test]
    fn person_who_comes_along_a_roadway_needs_the_ground_up_to_the_robot() {
        let found = ground(2.4, (5.0, 0.0, -1.0, 0.0), PathKind::Usual);
        let nearest_m = found.iter().map(|disc| disc.x).fold(f64::INFINITY, f64::min);
        assert!((1.3..1.5).contains(&nearest_m), "{nearest_m}");
        assert!(found.iter().all(|disc| disc.y.abs() < 1e-9 && (disc.radius - 0.201).abs() < 1e-9));
        // What may be noise leads to no wall.
        assert_eq!(found, ground(2.4, (5.0, 0.0, -1.0, 0.14), PathKind::Usual));
        for (person, why) in [
            ((5.0, 0.0, 1.0, 0.0), "it walks away"),
            ((5.0, 0.0, -0.2, 0.0), "it stands"),
            ((2.0, -1.0, 0.0, 1.0), "it crosses the path"),
            ((5.0, 0.7, -1.0, 0.0), "the path keeps clear"),
            ((-5.0, 0.0, 1.0, 0.0), "it follows"),
        ] {
            assert_eq!(ground(2.4, person, PathKind::Usual), [], "{why}");
        }
        assert_eq!(ground(6.0, (5.0, 0.0, -1.0, 0.0), PathKind::Usual), [], "open ground");
    }

    #[test]
    fn robot_beside_a_person_does_not_change_sides() {
        // The path passes at the right of the robot, which is the left of the person.
        let person = (5.0, 0.3, -1.0, 0.0);
        assert!(
            ground(2.4, person, PathKind::Usual).iter().all(|disc| (disc.y - 0.3).abs() < 1e-9)
        );
        let closed = ground(2.4, person, PathKind::PastPeople);
        let highest_m = closed.iter().map(|disc| disc.y).fold(f64::NEG_INFINITY, f64::max);
        assert!((highest_m - (0.3 + 3.0 * 0.402)).abs() < 1e-9, "{highest_m}");
        assert!(closed.iter().all(|disc| disc.y > 0.29), "{closed:?}");
        // In the middle there is no side yet.
        let middle = (5.0, 0.1, -1.0, 0.0);
        assert_eq!(ground(2.4, middle, PathKind::PastPeople), ground(2.4, middle, PathKind::Usual));
    }
}
