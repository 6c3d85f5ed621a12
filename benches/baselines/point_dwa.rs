//! A conventional dynamic window approach on lidar points in f64, from the paper (eqs. 27 to 35), without the engines'
//! code.
//!
//! Each pose of each sample is measured against each point. It is neither slowed down nor tuned.

use std::f64::consts::{PI, TAU};

use inbye::geometry::{Point, Pose, Twist};
use inbye::map::MovingDisc;
use inbye::robot::Disc;

/// Inputs of a decision.
pub struct PointDwa {
    /// End points of the lidar's beams, map frame.
    pub points: Vec<Point>,
    /// People; each step uses their predicted positions.
    pub people: Vec<MovingDisc>,
    pub discs: Vec<Disc>,
    pub pose: Pose,
    /// The sampled velocities, in the engines' order.
    pub velocities: Vec<Twist>,
    pub steps: u32,
    pub step_s: f64,
    pub max_clearance_m: f64,
    /// Deceleration along the path and angular deceleration.
    pub braking: [f64; 2],
    pub target: Point,
    pub key_node: Point,
    /// Weights of heading, clearance, velocity and path.
    pub weights: [f64; 4],
}

impl PointDwa {
    /// The index of the best velocity; `None` if every one collides or cannot stop.
    pub fn choose(&self) -> Option<usize> {
        let terms: Vec<Option<[f64; 4]>> =
            self.velocities.iter().map(|velocity| self.terms(velocity)).collect();
        // Eq. 33: each term divided by its sum.
        let mut sums = [0.0; 4];
        for terms in terms.iter().flatten() {
            for (sum, term) in sums.iter_mut().zip(terms) {
                *sum += term;
            }
        }
        let [heading, clearance, velocity, path] = self.weights;
        // For the path term less is better.
        let weights = [heading, clearance, velocity, -path];
        let score = |terms: &[f64; 4]| {
            let mut score = 0.0;
            for term in 0..4 {
                if sums[term] > 0.0 {
                    score += weights[term] * terms[term] / sums[term];
                }
            }
            score
        };
        let mut best = None;
        for (index, terms) in terms.iter().enumerate() {
            let Some(terms) = terms else { continue };
            let score = score(terms);
            if best.is_none_or(|(most, _)| score > most) {
                best = Some((score, index));
            }
        }
        best.map(|(_, index)| index)
    }

    /// Heading, clearance, velocity and path of an admissible sample.
    fn terms(&self, velocity: &Twist) -> Option<[f64; 4]> {
        let mut pose = self.pose;
        let mut clearance = self.max_clearance_m;
        for step in 1..=self.steps {
            // Eq. 27.
            let (sin, cos) = turned(pose.yaw);
            pose.x += velocity.linear * self.step_s * cos;
            pose.y += velocity.linear * self.step_s * sin;
            pose.yaw += velocity.angular * self.step_s;
            clearance = clearance.min(self.clearance(&pose, f64::from(step) * self.step_s));
            if clearance <= 0.0 {
                return None;
            }
        }
        // Eq. 30, squared.
        let [braking_x, braking_theta] = self.braking;
        if velocity.linear.powi(2) > 2.0 * clearance * braking_x
            || velocity.angular.powi(2) > 2.0 * clearance * braking_theta
        {
            return None;
        }
        let direction = libm::atan2(self.target.y - pose.y, self.target.x - pose.x);
        let off = (direction - pose.yaw + PI).rem_euclid(TAU) - PI;
        let to_key = Point::new(pose.x, pose.y) - self.key_node;
        Some([PI - off.abs(), clearance, velocity.linear.max(0.0), to_key.norm()])
    }

    /// Clearance at a pose and a time, metres.
    fn clearance(&self, pose: &Pose, time_s: f64) -> f64 {
        let (sin, cos) = turned(pose.yaw);
        let mut least = f64::INFINITY;
        for disc in &self.discs {
            let x = pose.x + cos * disc.x - sin * disc.y;
            let y = pose.y + sin * disc.x + cos * disc.y;
            let mut squared = f64::INFINITY;
            for point in &self.points {
                let (to_x, to_y) = (point.x - x, point.y - y);
                squared = squared.min(to_x * to_x + to_y * to_y);
            }
            least = least.min(squared.sqrt() - disc.radius);
            for person in &self.people {
                let to_x = person.x + person.vx * time_s - x;
                let to_y = person.y + person.vy * time_s - y;
                let gap = (to_x * to_x + to_y * to_y).sqrt() - person.radius - disc.radius;
                least = least.min(gap);
            }
        }
        least
    }
}

/// Sine and cosine.
#[expect(
    clippy::disallowed_methods,
    reason = "the system's are faster, and this needs no bit to be the same elsewhere"
)]
fn turned(yaw: f64) -> (f64, f64) {
    yaw.sin_cos()
}
