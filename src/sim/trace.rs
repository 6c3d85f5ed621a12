//! What happened: one row for each tick. The only thing that leaves a simulation.

use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::geometry::{Point, Pose, Twist};
use crate::navigator::Mode;

/// The truth at one tick, and what the robot decided.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TraceRow {
    /// Simulated time at the start of the tick, seconds.
    pub time_s: f64,
    /// Where the robot truly is.
    pub pose: Pose,
    /// How fast it truly moves.
    pub twist: Twist,
    /// The command sent to the base.
    pub command: Twist,
    /// The key node it made for.
    pub local_target: Point,
    /// Smallest gap between the footprint and anything solid, metres; not above zero is contact.
    pub gap_m: f64,
    /// Samples of the dynamic window that were admissible.
    pub admissible: u32,
    /// Samples that were evaluated; zero where the decision needed none.
    pub samples: u32,
    /// What the navigator was doing.
    pub mode: Mode,
    /// Which of [`Trace::paths`] it followed.
    pub path: usize,
    /// Centre of each moving obstacle.
    pub moving: Vec<Point>,
}

/// A whole run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Trace {
    /// One for each tick, in order.
    pub rows: Vec<TraceRow>,
    /// Each global path that was followed, in order of planning.
    pub paths: Vec<Vec<Point>>,
    /// Radius of each moving obstacle, metres, in the order of [`TraceRow::moving`].
    pub moving_radii: Vec<f64>,
}

impl Trace {
    /// A SHA-256 over the exact bits of every row and path, in hex. Two runs that differ in one bit of one number
    /// have different digests; how long a decision took is not part of it.
    #[must_use]
    pub fn digest(&self) -> String {
        let mut hasher = BitHasher(Sha256::new());
        for row in &self.rows {
            hasher.number(row.time_s);
            hasher.numbers(&[row.pose.x, row.pose.y, row.pose.yaw]);
            hasher.numbers(&[row.twist.linear, row.twist.angular]);
            hasher.numbers(&[row.command.linear, row.command.angular]);
            hasher.point(&row.local_target);
            hasher.number(row.gap_m);
            hasher.count(u64::from(row.admissible));
            hasher.count(u64::from(row.samples));
            hasher.count(row.mode as u64);
            hasher.count(row.path as u64);
            row.moving.iter().for_each(|center| hasher.point(center));
        }
        for path in &self.paths {
            hasher.count(path.len() as u64);
            path.iter().for_each(|point| hasher.point(point));
        }
        hasher.numbers(&self.moving_radii);
        hasher
            .0
            .finalize()
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect()
    }
}

struct BitHasher(Sha256);

impl BitHasher {
    fn count(&mut self, value: u64) {
        self.0.update(value.to_le_bytes());
    }

    fn number(&mut self, value: f64) {
        self.count(value.to_bits());
    }

    fn numbers(&mut self, values: &[f64]) {
        values.iter().for_each(|&value| self.number(value));
    }

    fn point(&mut self, point: &Point) {
        self.numbers(&[point.x, point.y]);
    }
}
