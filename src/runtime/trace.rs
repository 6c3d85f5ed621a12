//! What happened: one row for each tick. The only thing that leaves a simulation.

use crate::digest::BitDigest;
use crate::geometry::{Point, Pose, Twist};
use crate::navigator::Mode;
use serde::Serialize;

/// The truth at one tick, and what the robot decided.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TraceRow {
    /// Simulated time at the start of the tick, seconds.
    pub time_s: f64,
    /// Where the robot truly is.
    pub pose: Pose,
    /// Where it believes to be.
    pub belief: Pose,
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
    /// Centre of each moving obstacle; none for one that has not yet appeared.
    pub moving: Vec<Option<Point>>,
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
    /// A digest over the exact bits of every row and path. Two runs that differ in one bit of one number have different
    /// digests; how long a decision took is not part of it.
    #[must_use]
    pub fn digest(&self) -> String {
        let mut digest = BitDigest::default();
        self.rows.iter().for_each(|row| row.add_to(&mut digest));
        for path in &self.paths {
            digest.wide(path.len() as u64);
            path.iter().for_each(|point| add_point(&mut digest, point));
        }
        self.moving_radii
            .iter()
            .for_each(|&radius| digest.real(radius));
        digest.hex()
    }
}

impl TraceRow {
    fn add_to(&self, digest: &mut BitDigest) {
        let Self {
            pose,
            twist,
            command,
            ..
        } = self;
        for value in [
            self.time_s,
            pose.x,
            pose.y,
            pose.yaw,
            self.belief.x,
            self.belief.y,
            self.belief.yaw,
            twist.linear,
            twist.angular,
            command.linear,
            command.angular,
            self.gap_m,
        ] {
            digest.real(value);
        }
        add_point(digest, &self.local_target);
        digest.word(self.admissible);
        digest.word(self.samples);
        digest.word(self.mode as u32);
        digest.wide(self.path as u64);
        // No centre is NaN, so this is none of them.
        let absent = Point::new(f64::NAN, f64::NAN);
        self.moving
            .iter()
            .for_each(|center| add_point(digest, center.as_ref().unwrap_or(&absent)));
    }
}

fn add_point(digest: &mut BitDigest, point: &Point) {
    digest.real(point.x);
    digest.real(point.y);
}
