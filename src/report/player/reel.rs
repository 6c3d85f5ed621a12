//! What a player needs of each tick, gathered while the robot drives.

use super::faults::Faults;
use crate::geometry::{Point, Pose, Twist};
use crate::local::{SampleStatus, Sampling, TrajectoryFan};
use crate::map::{MovingDisc, Scan};
use crate::runtime::{TickEvent, TraceRow};

/// Frames that a reel keeps at most: ten minutes of ten a second. A longer run is shown in every second tick, or fourth.
const MOST_FRAMES: usize = 6000;

/// Beams that a frame keeps at most: one in three degrees.
const MOST_BEAMS: usize = 120;

/// Arcs of a frame's fan at most, along each axis.
const FAN: Sampling = Sampling {
    vx_samples: 5,
    vtheta_samples: 11,
};

/// Moving obstacles farther than this from the robot are not kept, metres: what the lidar reaches, and a little.
const NEAR_M: f64 = 12.0;

/// A beam that measured nothing, and one that met nothing. Smaller numbers are shares of the longest range.
const NO_MEASUREMENT: u8 = 255;
const NOTHING_MET: u8 = 254;

/// Least score of a fan as a byte. Smaller numbers are the reasons for which samples are not admissible.
const LEAST_SCORE: u8 = 8;

/// The frames of one run, to be played back in a report.
#[derive(Clone, Debug)]
pub struct Reel {
    pub(super) frames: Vec<Frame>,
    /// What went wrong, at all ticks.
    pub(super) faults: Faults,
    /// One of so many ticks is kept.
    pub(super) stride: usize,
    ticks: usize,
}

/// One tick.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    pub row: TraceRow,
    pub took_ms: f64,
    pub beams: Beams,
    pub window: Option<Window>,
    /// Moving obstacles near the robot: what is truly there.
    pub moving: Vec<MovingDisc>,
}

/// A thinned scan.
#[derive(Clone, Debug, Default)]
pub(super) struct Beams {
    pub angle_min: f64,
    pub angle_increment: f64,
    pub range_max: f64,
    pub ranges: Vec<u8>,
}

/// A thinned dynamic window.
#[derive(Clone, Debug)]
pub(super) struct Window {
    pub from: Pose,
    pub horizon_s: f64,
    /// Its least and greatest velocities, which are those of its first and last arc.
    pub ends: [Twist; 2],
    pub columns: usize,
    /// A byte for each arc: see [`score_byte`].
    pub scores: Vec<u8>,
    pub winner: Option<crate::local::WinnerSi>,
    pub predicted: Vec<MovingDisc>,
}

impl Default for Reel {
    fn default() -> Self {
        Self {
            frames: Vec::new(),
            faults: Faults::default(),
            stride: 1,
            ticks: 0,
        }
    }
}

impl Reel {
    /// Takes the next tick of the run.
    pub fn take(&mut self, moment: &TickEvent<'_>) {
        self.faults.take(self.ticks, moment);
        let is_kept = self.ticks.is_multiple_of(self.stride);
        self.ticks += 1;
        if !is_kept {
            return;
        }
        if self.frames.len() == MOST_FRAMES {
            self.thin();
            if !(self.ticks - 1).is_multiple_of(self.stride) {
                return;
            }
        }
        self.frames.push(Frame::of(moment));
    }

    /// Whether there is anything to play.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Keeps every second frame only, now and from now on.
    fn thin(&mut self) {
        self.stride *= 2;
        let mut index = 0;
        self.frames.retain(|_| {
            index += 1;
            index % 2 == 1
        });
    }
}

impl Frame {
    fn of(moment: &TickEvent<'_>) -> Self {
        let row = moment.row;
        let place = row.pose.position();
        let disc = |(center, radius): (&Option<Point>, &f64)| {
            center.map(|center| MovingDisc {
                x: center.x,
                y: center.y,
                radius: *radius,
                vx: 0.0,
                vy: 0.0,
            })
        };
        let is_near = |disc: &MovingDisc| (disc.center() - place).norm() - disc.radius < NEAR_M;
        let moving = row.moving.iter().zip(moment.moving_radii).filter_map(disc);
        Self {
            took_ms: moment.took_s * 1e3,
            beams: Beams::of(&moment.observation.scan),
            window: moment.fan(FAN).map(Window::of),
            moving: moving.filter(is_near).collect(),
            row: TraceRow {
                moving: Vec::new(),
                ..row.clone()
            },
        }
    }
}

impl Beams {
    /// The nearest of so many neighbours each.
    fn of(scan: &Scan) -> Self {
        let together = scan.ranges.len().div_ceil(MOST_BEAMS).max(1);
        let middle = (together - 1) as f64 / 2.0;
        Self {
            angle_min: scan.angle_min + middle * scan.angle_increment,
            angle_increment: scan.angle_increment * together as f64,
            range_max: scan.range_max,
            ranges: scan
                .ranges
                .chunks(together)
                .map(|beams| range_byte(beams, scan.range_max))
                .collect(),
        }
    }
}

/// The shortest of some ranges, in steps of the longest one's 253rd part.
fn range_byte(beams: &[f64], range_max: f64) -> u8 {
    let measured = beams.iter().copied().filter(|range| !range.is_nan());
    match measured.reduce(f64::min) {
        None => NO_MEASUREMENT,
        Some(range) if range < range_max => (range / range_max * 253.0).round() as u8,
        Some(_) => NOTHING_MET,
    }
}

impl Window {
    fn of(fan: TrajectoryFan) -> Self {
        let ends = [fan.arcs.first(), fan.arcs.last()].map(|arc| arc.map(|arc| arc.twist));
        Self {
            from: fan.from,
            horizon_s: fan.horizon_s,
            ends: ends.map(Option::unwrap_or_default),
            columns: fan.columns,
            scores: fan
                .arcs
                .iter()
                .zip(fan.relative_scores())
                .map(|(arc, share)| share.map_or(reason_byte(arc.status), score_byte))
                .collect(),
            winner: fan.winner,
            predicted: fan.obstacles,
        }
    }
}

/// A score by its place in its fan, 0 to 1.
fn score_byte(share: f64) -> u8 {
    LEAST_SCORE + (share * f64::from(u8::MAX - LEAST_SCORE)).round() as u8
}

const fn reason_byte(reason: SampleStatus) -> u8 {
    match reason {
        SampleStatus::Ok | SampleStatus::Collision => 0,
        SampleStatus::CannotStop => 1,
        SampleStatus::Outside => 2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::local::FanArc;

    #[test]
    fn ranges_are_bytes() {
        let nothing = f64::INFINITY;
        assert_eq!(range_byte(&[5.0, 2.0, f64::NAN], 10.0), 51);
        assert_eq!(range_byte(&[0.0], 10.0), 0);
        assert_eq!(range_byte(&[9.999], 10.0), 253);
        assert_eq!(range_byte(&[nothing, 10.0], 10.0), NOTHING_MET);
        assert_eq!(range_byte(&[f64::NAN], 10.0), NO_MEASUREMENT);
    }

    #[test]
    fn scores_are_bytes_above_the_reasons() {
        let bytes = |scores: [f64; 2]| {
            let arc = |score| FanArc {
                twist: Twist::STOP,
                score: Some(score),
                status: SampleStatus::Ok,
            };
            let fan = TrajectoryFan {
                from: Pose::default(),
                horizon_s: 1.0,
                arcs: scores.map(arc).to_vec(),
                columns: 1,
                winner: None,
                obstacles: Vec::new(),
            };
            Window::of(fan).scores
        };
        assert_eq!(bytes([-1.0, 3.0]), [LEAST_SCORE, 255]);
        assert_eq!(bytes([2.0, 2.0]), [255, 255]);
        let reasons = [
            SampleStatus::Collision,
            SampleStatus::CannotStop,
            SampleStatus::Outside,
        ];
        assert!(
            reasons
                .map(reason_byte)
                .iter()
                .all(|byte| *byte < LEAST_SCORE)
        );
    }

    #[test]
    fn every_third_degree_keeps_the_nearest_of_its_beams() {
        let scan = Scan {
            angle_min: -1.0,
            angle_increment: 0.01,
            range_max: 10.0,
            ranges: (0..240).map(|beam| f64::from(beam % 7) + 1.0).collect(),
        };
        let beams = Beams::of(&scan);
        assert_eq!(beams.ranges.len(), 120);
        assert!((beams.angle_min + 0.995).abs() < 1e-12);
        assert!((beams.angle_increment - 0.02).abs() < 1e-12);
        assert_eq!(beams.ranges[3], range_byte(&[1.0], 10.0));
    }
}
