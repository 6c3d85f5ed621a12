//! Records the data of each tick for the player while the robot drives.

use super::FaultList;
use super::protection::ProtectionEvents;
use crate::geometry::{Point, Pose, Twist};
use crate::local::{SampleStatus, Sampling, TrajectoryFan, WinnerSi};
use crate::map::{MovingDisc, Scan, is_measurement};
use crate::runtime::{TickEvent, TraceRow};

/// Most frames of a playback: ten minutes at 10 Hz. A longer run keeps every second tick, then every fourth.
const MAX_FRAMES: usize = 6000;

/// Most beams of a frame: one in three degrees.
const MAX_BEAMS: usize = 120;

/// Most trajectories of a frame along each axis.
const SAMPLING: Sampling = Sampling { vx_samples: 5, vtheta_samples: 11 };

/// Range within which moving obstacles are recorded, m. It is a little more than the range of the lidar.
const NEAR_M: f64 = 12.0;

/// Range bytes of a beam without a measurement, and of one without a return. Smaller bytes are fractions of the longest
/// range.
pub(super) const NO_MEASUREMENT: u8 = 255;
pub(in crate::report) const NO_RETURN: u8 = 254;

/// Least score byte. Smaller bytes say why a sample is not admissible.
pub(in crate::report) const MIN_SCORE: u8 = 8;

/// Records the frames of one run for the playback in a report.
#[derive(Clone, Debug)]
pub struct PlaybackRecorder {
    pub(in crate::report) frames: Vec<Frame>,
    /// The faults of all ticks.
    pub(super) faults: FaultList,
    /// The actions of the protective layer of all ticks.
    pub(super) protection: ProtectionEvents,
    /// The global paths so far.
    paths: Vec<Vec<Point>>,
    /// What the frames have in common.
    pub(super) shape: Shape,
    /// The last frame, if it is the latest tick and not a multiple of the stride.
    is_extra: bool,
    ticks: usize,
}

/// What the encoding of all frames depends on.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    /// Ticks for each recorded frame.
    pub(super) stride: usize,
    /// Most beams and trajectories of a frame so far. A frame may have fewer: a scan without a measurement has none, and near a
    /// deadline the robot evaluates fewer samples.
    pub(super) beams: usize,
    pub(super) trajectories: usize,
}

impl Shape {
    /// Makes room for a frame.
    fn include(&mut self, scan: &ThinnedScan, window: Option<&Window>) {
        self.beams = self.beams.max(scan.ranges.len());
        self.trajectories = self.trajectories.max(window.map_or(0, |window| window.scores.len()));
    }

    /// Differs for shapes whose encoded frames do not fit together.
    pub(super) fn key(&self) -> String {
        format!("{}-{}-{}", self.stride, self.beams, self.trajectories)
    }
}

/// Consecutive frames of a playback, and what they refer to.
#[derive(Clone, Debug)]
pub(crate) struct PlaybackPart {
    /// Index of the first frame.
    pub(super) first: usize,
    pub(super) frames: Vec<Frame>,
    pub(super) shape: Shape,
    pub(super) paths: Vec<Vec<Point>>,
    /// Number of ticks with a fault or an action of the protective layer, which only grows.
    pub(super) event_ticks: usize,
    /// The faults and the actions of the protective layer; none if the receiver knows them.
    pub(super) events: Option<(FaultList, ProtectionEvents)>,
}

#[cfg(feature = "server")]
impl PlaybackPart {
    /// Index after its last frame.
    pub(crate) const fn end(&self) -> usize {
        self.first + self.frames.len()
    }
}

/// One tick.
#[derive(Clone, Debug)]
pub(in crate::report) struct Frame {
    pub(in crate::report) row: TraceRow,
    pub(super) decision_ms: f64,
    pub(in crate::report) scan: ThinnedScan,
    pub(in crate::report) window: Option<Window>,
    /// The true moving obstacles near the robot.
    pub(in crate::report) moving: Vec<MovingDisc>,
}

/// A scan with fewer beams.
#[derive(Clone, Debug, Default)]
pub(in crate::report) struct ThinnedScan {
    pub(in crate::report) origin: Point,
    pub(in crate::report) angle_min: f64,
    pub(in crate::report) angle_increment: f64,
    pub(in crate::report) range_max: f64,
    pub(in crate::report) ranges: Vec<u8>,
}

/// A dynamic window with fewer samples.
#[derive(Clone, Debug)]
pub(in crate::report) struct Window {
    pub(in crate::report) start: Pose,
    pub(in crate::report) horizon_s: f64,
    /// Its least and greatest velocities: those of its first and last trajectory.
    pub(in crate::report) ends: [Twist; 2],
    pub(in crate::report) columns: usize,
    /// A byte for each trajectory: see [`score_byte`] and [`status_byte`].
    pub(in crate::report) scores: Vec<u8>,
    pub(in crate::report) winner: Option<WinnerSi>,
    /// Some points of each trajectory and of the winner; empty where they are arcs of a constant velocity.
    pub(in crate::report) paths: Vec<Vec<Point>>,
    pub(super) predicted: Vec<MovingDisc>,
}

impl Default for PlaybackRecorder {
    fn default() -> Self {
        Self {
            frames: Vec::new(),
            faults: FaultList::default(),
            protection: ProtectionEvents::default(),
            paths: Vec::new(),
            shape: Shape { stride: 1, beams: 0, trajectories: 0 },
            is_extra: false,
            ticks: 0,
        }
    }
}

impl PlaybackRecorder {
    /// Records the next tick of the run.
    pub fn record(&mut self, event: &TickEvent<'_>) {
        self.faults.record(self.ticks, event);
        self.protection.record(self.ticks, event);
        let tick = self.ticks;
        self.ticks += 1;
        // The last tick of a drive shows its end, so the newest tick is always kept.
        if self.is_extra {
            self.frames.pop();
        }
        if tick.is_multiple_of(self.shape.stride) && self.frames.len() == MAX_FRAMES {
            self.thin();
        }
        self.is_extra = !tick.is_multiple_of(self.shape.stride);
        let frame = Frame::new(event);
        self.shape.include(&frame.scan, frame.window.as_ref());
        self.frames.push(frame);
        let plans = event.navigator.plans().iter().skip(self.paths.len());
        self.paths.extend(plans.map(|plan| plan.smoothed.points().to_vec()));
    }

    /// All frames.
    pub(super) fn whole(&self) -> PlaybackPart {
        self.part(0, usize::MAX, None)
    }

    /// At most `most` frames from `first` on, and the events if there are more than the known number of ticks with one.
    pub(super) fn part(
        &self,
        first: usize,
        most: usize,
        known_event_ticks: Option<usize>,
    ) -> PlaybackPart {
        let event_ticks = self.faults.list.ticks() + self.protection.event_ticks();
        let is_known = known_event_ticks == Some(event_ticks);
        PlaybackPart {
            first,
            frames: self.frames.iter().skip(first).take(most).cloned().collect(),
            shape: self.shape.clone(),
            paths: self.paths.clone(),
            event_ticks,
            events: (!is_known).then(|| (self.faults.clone(), self.protection.clone())),
        }
    }

    /// Number of frames.
    #[cfg(feature = "server")]
    pub(crate) const fn frame_count(&self) -> usize {
        self.frames.len()
    }

    /// Number of frames that no later tick replaces.
    #[cfg(feature = "server")]
    pub(super) const fn lasting_frames(&self) -> usize {
        self.frames.len() - self.is_extra as usize
    }

    /// Whether no tick was recorded.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// The longest range of a recorded scan, m; zero without any.
    pub(in crate::report) fn lidar_range_m(&self) -> f64 {
        self.frames.iter().map(|frame| frame.scan.range_max).fold(0.0, f64::max)
    }

    /// Halves the frames and doubles the stride.
    fn thin(&mut self) {
        self.shape.stride *= 2;
        let mut index = 0;
        self.frames.retain(|_| {
            index += 1;
            index % 2 == 1
        });
    }
}

impl Frame {
    fn new(event: &TickEvent<'_>) -> Self {
        let row = event.row;
        let position = row.pose.position();
        let disc = |(center, &radius): (&Option<Point>, &f64)| {
            let center = (*center)?;
            Some(MovingDisc { x: center.x, y: center.y, radius, vx: 0.0, vy: 0.0 })
        };
        let is_near = |disc: &MovingDisc| (disc.center() - position).norm() - disc.radius < NEAR_M;
        let moving = row.moving.iter().zip(event.moving_radii).filter_map(disc);
        Self {
            decision_ms: event.took_s * 1e3,
            scan: ThinnedScan::new(&event.observation.scan),
            window: event.fan(SAMPLING).map(Window::new),
            moving: moving.filter(is_near).collect(),
            row: TraceRow { moving: Vec::new(), ..row.clone() },
        }
    }
}

impl ThinnedScan {
    /// Reduces a scan to the nearest return of each group of neighbouring beams.
    fn new(scan: &Scan) -> Self {
        let group = scan.ranges.len().div_ceil(MAX_BEAMS).max(1);
        let middle = (group - 1) as f64 / 2.0;
        let beams = scan.ranges.chunks(group);
        Self {
            origin: scan.origin,
            angle_min: scan.angle_min + middle * scan.angle_increment,
            angle_increment: scan.angle_increment * group as f64,
            range_max: scan.range_max,
            ranges: beams.map(|beams| range_byte(beams, scan.range_max)).collect(),
        }
    }
}

/// The shortest of some ranges, in units of 1/253 of the longest possible.
fn range_byte(beams: &[f64], range_max: f64) -> u8 {
    let measured = beams.iter().copied().filter(|range| is_measurement(*range));
    match measured.reduce(f64::min) {
        None => NO_MEASUREMENT,
        Some(range) if range <= range_max => (range / range_max * 253.0).round() as u8,
        Some(_) => NO_RETURN,
    }
}

impl Window {
    fn new(fan: TrajectoryFan) -> Self {
        let ends = [fan.arcs.first(), fan.arcs.last()].map(|arc| arc.map(|arc| arc.twist));
        let scores = fan.arcs.iter().zip(fan.relative_scores());
        let scores =
            scores.map(|(arc, share)| share.map_or(status_byte(arc.status), score_byte)).collect();
        Self {
            start: fan.from,
            horizon_s: fan.horizon_s,
            ends: ends.map(Option::unwrap_or_default),
            columns: fan.columns,
            scores,
            paths: paths(&fan),
            winner: fan.winner,
            predicted: fan.obstacles,
        }
    }
}

/// Parts of the drawn path of a trajectory.
const PATH_PARTS: u32 = 5;

/// Some points of each trajectory and, last, of the winner; empty where they are arcs of a constant velocity.
fn paths(fan: &TrajectoryFan) -> Vec<Vec<Point>> {
    if fan.arcs.iter().all(|arc| arc.path.is_empty()) {
        return Vec::new();
    }
    let arcs = fan.arcs.iter().map(|arc| fan.points(arc, PATH_PARTS));
    arcs.chain([fan.winner_points(2 * PATH_PARTS)]).collect()
}

/// The byte of a score relative to the least (0) and greatest (1) of its window.
fn score_byte(share: f64) -> u8 {
    MIN_SCORE + (share * f64::from(u8::MAX - MIN_SCORE)).round() as u8
}

/// The byte of a sample that is not admissible.
const fn status_byte(status: SampleStatus) -> u8 {
    match status {
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
    fn range_byte_is_a_fraction_of_the_longest_range() {
        let no_return = f64::INFINITY;
        assert_eq!(range_byte(&[5.0, 2.0, f64::NAN], 10.0), 51);
        assert_eq!(range_byte(&[0.001], 10.0), 0);
        assert_eq!(range_byte(&[0.0, -1.0, 2.0], 10.0), 51);
        assert_eq!(range_byte(&[no_return, 10.0], 10.0), 253);
        assert_eq!(range_byte(&[no_return, 10.1], 10.0), NO_RETURN);
        assert_eq!(range_byte(&[f64::NAN, 0.0, -1.0], 10.0), NO_MEASUREMENT);
    }

    #[test]
    fn score_bytes_are_above_the_status_bytes() {
        let bytes = |scores: [f64; 2]| {
            let arc = |score| FanArc {
                twist: Twist::STOP,
                score: Some(score),
                status: SampleStatus::Ok,
                path: Vec::new(),
            };
            let fan = TrajectoryFan {
                from: Pose::default(),
                horizon_s: 1.0,
                winner_path: Vec::new(),
                arcs: scores.map(arc).to_vec(),
                columns: 1,
                winner: None,
                obstacles: Vec::new(),
            };
            Window::new(fan).scores
        };
        assert_eq!(bytes([-1.0, 3.0]), [MIN_SCORE, 255]);
        assert_eq!(bytes([2.0, 2.0]), [255, 255]);
        let statuses = [SampleStatus::Collision, SampleStatus::CannotStop, SampleStatus::Outside];
        assert!(statuses.map(status_byte).iter().all(|byte| *byte < MIN_SCORE));
    }

    /// The first scan has no beam, and the last frame fewer trajectories.
    #[test]
    fn shape_has_room_for_the_largest_frame() {
        let window = |count: usize| Window {
            start: Pose::default(),
            horizon_s: 1.0,
            ends: [Twist::STOP; 2],
            columns: 1,
            scores: vec![MIN_SCORE; count],
            winner: None,
            paths: Vec::new(),
            predicted: Vec::new(),
        };
        let mut shape = PlaybackRecorder::default().shape;
        for (beams, trajectories) in [(0, 55), (120, 40)] {
            let scan = ThinnedScan { ranges: vec![0; beams], ..ThinnedScan::default() };
            shape.include(&scan, Some(&window(trajectories)));
        }
        assert_eq!((shape.beams, shape.trajectories), (120, 55));
    }

    #[test]
    fn thinned_scan_keeps_the_nearest_of_each_group() {
        let scan = Scan {
            angle_min: -1.0,
            angle_increment: 0.01,
            range_max: 10.0,
            ranges: (0..240).map(|beam| f64::from(beam % 7) + 1.0).collect(),
            ..Scan::default()
        };
        let thinned = ThinnedScan::new(&scan);
        assert_eq!(thinned.ranges.len(), 120);
        assert!((thinned.angle_min + 0.995).abs() < 1e-12);
        assert!((thinned.angle_increment - 0.02).abs() < 1e-12);
        assert_eq!(thinned.ranges[3], range_byte(&[1.0], 10.0));
    }
}
