//! Predictions of people: where they may be in the next seconds, as discs that grow, with several hypotheses.
//!
//! A person goes on, turns back or turns aside at some moment. Each is a branch with a weight: the probability that it comes true.
//! The cost of a motion is the expected worst closeness over the branches. It grows before there is contact.

use core::f64::consts::FRAC_1_SQRT_2;

use crate::geometry::{Point, Pose, Vector};
use crate::map::MovingDisc;
use crate::robot::Footprint;

/// Time step, seconds, and number of predicted times: 5 s.
pub(super) const STEP_S: f64 = 0.1;
pub(super) const STEPS: usize = 50;

/// Rate at which walking people cease to go straight on, 1/s: identified from the motion of the simulated people.
/// The rate at which they turn back is a choice, below the identified 0.17: with that the robot waits for people who pace.
const CHANGE_RATE: f64 = 0.28;
const BACK_RATE: f64 = 0.04;
/// Times at which a person may turn back, seconds: each stands for a second.
const TURNS_BACK_S: [f64; 4] = [0.5, 1.5, 2.5, 3.5];
/// Probability of a turn by an eighth of a circle to each side, and its time, seconds.
const TURNS_ASIDE: f64 = 0.02;
const TURNS_ASIDE_S: f64 = 0.5;
/// A person below this speed stands, m/s.
const STANDING: f64 = 0.15;
/// A motion within this distance of a person's disc has a cost even where the estimate is certain, metres.
const MARGIN_M: f64 = 0.15;
/// Deviation of a tracked place, metres.
const PLACE_DEVIATION_M: f64 = 0.1;

/// A person with the deviation of the estimated velocity, m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Person {
    pub disc: MovingDisc,
    pub velocity_deviation: f64,
}

/// What a person does from a moment on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Branch {
    weight: f64,
    /// Rate at which its probability falls, 1/s.
    decay: f64,
    /// Time of the turn, seconds, place then, and velocity from then on.
    from_s: f64,
    place: Point,
    velocity: Vector,
    radius_m: f64,
    velocity_deviation: f64,
}

/// The branches of all people.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Predictions {
    pub people: Vec<Person>,
    branches: Vec<Branch>,
}

impl Predictions {
    /// The branches of people.
    pub fn new(people: &[Person]) -> Self {
        let mut branches = Vec::new();
        for person in people {
            let MovingDisc { vx, vy, radius, .. } = person.disc;
            let velocity = Vector::new(vx, vy);
            let branch = Branch {
                weight: 1.0,
                decay: CHANGE_RATE,
                from_s: 0.0,
                place: person.disc.center(),
                velocity,
                radius_m: radius,
                velocity_deviation: person.velocity_deviation,
            };
            if velocity.norm() < STANDING {
                branches.push(Branch { velocity: Vector::ZERO, decay: 0.0, ..branch });
                continue;
            }
            branches.push(branch);
            let mut turns = |from_s: f64, weight: f64, (cos, sin): (f64, f64)| {
                let place = branch.place + velocity * from_s;
                let turned = Vector::new(cos * vx - sin * vy, sin * vx + cos * vy);
                let branch =
                    Branch { weight, decay: 0.0, from_s, place, velocity: turned, ..branch };
                branches.push(branch);
            };
            for from_s in TURNS_BACK_S {
                let weight = BACK_RATE * libm::exp(-CHANGE_RATE * from_s);
                turns(from_s, weight, (-1.0, 0.0));
            }
            for sin in [FRAC_1_SQRT_2, -FRAC_1_SQRT_2] {
                turns(TURNS_ASIDE_S, TURNS_ASIDE, (FRAC_1_SQRT_2, sin));
            }
        }
        Self { branches, people: people.to_vec() }
    }

    /// The branches of people who were seen a time ago, seconds, each with the deviation of the velocity, m/s, and with at least this
    /// radius, metres.
    pub fn seen(
        people: impl Iterator<Item = (MovingDisc, f64)>,
        radius_m: f64,
        since_s: f64,
    ) -> Self {
        let person = |(disc, velocity_deviation): (MovingDisc, f64)| Person {
            disc: MovingDisc { radius: disc.radius.max(radius_m), ..disc.after(since_s) },
            velocity_deviation,
        };
        Self::new(&people.map(person).collect::<Vec<_>>())
    }

    /// Whether there are no people.
    pub fn is_empty(&self) -> bool {
        self.branches.is_empty()
    }

    /// The expected cost of a motion, given by its pose at each predicted time: 1 is a certain contact now.
    pub fn cost(&self, footprint: &Footprint, poses: &[Pose]) -> f64 {
        self.branches.iter().map(|branch| branch.weight * branch.worst(footprint, poses)).sum()
    }
}

impl Branch {
    /// The highest closeness of a motion, 0 to 1: the share of the soft distance that is missing.
    fn worst(&self, footprint: &Footprint, poses: &[Pose]) -> f64 {
        let reach_m = footprint.circumscribed_radius_m() + self.radius_m;
        let first = (self.from_s / STEP_S) as usize;
        let mut worst = 0.0_f64;
        for (step, pose) in poses.iter().enumerate().skip(first) {
            let time_s = (step + 1) as f64 * STEP_S;
            let center = self.place + self.velocity * (time_s - self.from_s);
            let deviation_m = libm::hypot(PLACE_DEVIATION_M, self.velocity_deviation * time_s);
            let soft_m = MARGIN_M + deviation_m;
            let away = center - pose.position();
            if away.norm() - reach_m >= soft_m {
                continue;
            }
            let gap_m = footprint.gap_to_disc_m(pose, &center, self.radius_m);
            let closeness = (1.0 - gap_m / soft_m).clamp(0.0, 1.0);
            worst = worst.max(closeness * libm::exp(-self.decay * time_s));
        }
        worst
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn predictions(x: f64, y: f64, vx: f64) -> Predictions {
        let disc = MovingDisc { x, y, radius: 0.3, vx, vy: 0.0 };
        Predictions::new(&[Person { disc, velocity_deviation: 0.1 }])
    }

    /// The cost of standing at a place for the horizon.
    fn standing(predictions: &Predictions, x: f64, y: f64) -> f64 {
        let footprint = Footprint::round(0.3).expect("a radius");
        predictions.cost(&footprint, &[Pose::new(x, y, 0.0); STEPS])
    }

    #[test]
    fn place_on_the_path_of_a_person_costs_more_than_one_next_to_it() {
        let person = predictions(4.0, 0.0, -1.0);
        let costs = [0.0, 0.8, 1.2, 2.5].map(|y| standing(&person, 0.0, y));
        assert!(costs[0] > 0.2, "{costs:?}");
        assert!(costs.windows(2).all(|pair| pair[0] > pair[1]), "cost before contact: {costs:?}");
        assert_eq!(costs[3], 0.0);
    }

    #[test]
    fn person_who_comes_soon_costs_more_than_one_who_comes_late() {
        let costs = [1.5, 3.0, 4.5].map(|x| standing(&predictions(x, 0.0, -1.0), 0.0, 0.0));
        assert!(costs.windows(2).all(|pair| pair[0] > pair[1]), "{costs:?}");
    }

    /// A robot behind a person who walks away is on the path of one who turns back.
    #[test]
    fn person_who_walks_away_may_turn_back() {
        let away = predictions(2.0, 0.0, 1.0);
        let behind = standing(&away, 0.0, 0.0);
        assert!((0.02..0.3).contains(&behind), "{behind}");
        assert!(behind < standing(&predictions(2.0, 0.0, -1.0), 0.0, 0.0));
        assert_eq!(standing(&away, 0.0, 1.5), 0.0);
    }

    #[test]
    fn motion_that_leaves_the_path_in_time_costs_less_than_standing() {
        let person = predictions(4.0, 0.0, -1.0);
        let footprint = Footprint::round(0.3).expect("a radius");
        let aside = |step: usize| Pose::new(0.0, (0.05 * step as f64).min(1.5), 0.0);
        let leaves: Vec<Pose> = (0..STEPS).map(aside).collect();
        assert!(person.cost(&footprint, &leaves) < 0.5 * standing(&person, 0.0, 0.0));
    }

    #[test]
    fn person_who_stands_occupies_the_place_for_certain() {
        let person = predictions(0.5, 0.0, 0.0);
        assert_eq!(standing(&person, 0.0, 0.0), 1.0);
        assert_eq!(standing(&person, 0.0, 2.0), 0.0);
    }

    #[test]
    fn uncertain_velocity_makes_the_disc_grow() {
        let disc = MovingDisc { x: 3.0, y: 0.95, radius: 0.3, vx: -1.0, vy: 0.0 };
        let costs = [0.0, 0.3].map(|velocity_deviation| {
            standing(&Predictions::new(&[Person { disc, velocity_deviation }]), 0.0, 0.0)
        });
        assert!(costs[0] < costs[1], "{costs:?}");
    }
}
