//! Assembles packets to complete revolutions, each point with its time by the host's clock.

use core::f64::consts::TAU;

use super::{LidarSettings, POINTS, Packet, RANGE_MAX_M, REVOLUTION};
use crate::geometry::Pose;
use crate::map::{Beam, TimedScan};

/// Wrap-around of the lidar's clock, ms.
const CLOCK_MS: u16 = 30_000;

/// Longest time between consecutive packets by the lidar's clock, ms: beyond it packets were lost.
const MAX_GAP_MS: u16 = 100;

/// Largest relative drift of the two clocks: typical crystals are a hundred times better.
const MAX_DRIFT: f64 = 1e-3;

/// Longest revolution, seconds.
const MAX_REVOLUTION_S: f64 = 0.5;

/// Speed below which a lidar counts as not rotating, degrees per second: no revolution of it would be complete.
pub(super) const MIN_SPEED_DEG_S: f64 = 360.0 / MAX_REVOLUTION_S;

/// Most points of a revolution that are kept: no lidar of this family makes as many.
const MAX_POINTS: usize = 4096;

/// Joins packets to revolutions.
///
/// Buffers deliver bytes late, never early. So the packet with the shortest delay gives the best estimate of the clocks' offset.
#[derive(Clone, Debug)]
pub struct RevolutionAssembler {
    settings: LidarSettings,
    mount: Pose,
    /// The unwrapped lidar clock, seconds, and its last reading, ms.
    clock: Option<(f64, u16)>,
    /// Host clock minus lidar clock, seconds.
    offset_s: f64,
    /// Angle of the last point, 0.01 degrees clockwise.
    angle: Option<f64>,
    beams: Vec<Beam>,
    /// Times of the revolution's first and last point by the lidar's clock, seconds.
    span_s: (f64, f64),
    speed_deg_s: u16,
}

impl RevolutionAssembler {
    /// Creates an assembler for a lidar with this mounting. The settings are valid.
    #[must_use]
    pub fn new(settings: LidarSettings) -> Self {
        Self {
            settings,
            mount: settings.mount(),
            clock: None,
            offset_s: f64::INFINITY,
            angle: None,
            beams: Vec::with_capacity(MAX_POINTS),
            span_s: (0.0, 0.0),
            speed_deg_s: 0,
        }
    }

    /// Takes a packet with its time of arrival by the host's clock, seconds, not descending. Returns the revolution that it completes:
    /// the beams from one passing of the sensor's front to the next, in the robot's frame.
    pub fn push(&mut self, packet: &Packet, now_s: f64) -> Option<TimedScan> {
        let last_s = self.host_time_s(packet, now_s);
        self.speed_deg_s = packet.speed_deg_s;
        let step = f64::from(packet.span()) / (POINTS - 1) as f64;
        // A lidar that does not rotate measures all points of a packet at once.
        let step_s = match packet.speed_deg_s {
            0 => 0.0,
            speed => step / 100.0 / f64::from(speed),
        };
        let mut complete = None;
        for (index, point) in packet.points.iter().enumerate() {
            let angle = (f64::from(packet.first) + step * index as f64) % f64::from(REVOLUTION);
            let passes_front =
                self.angle.is_some_and(|before| before - angle > f64::from(REVOLUTION) / 2.0);
            if passes_front {
                complete = self.complete().or(complete);
            }
            self.angle = Some(angle);
            let earlier_s = (POINTS - 1 - index) as f64 * step_s;
            let lidar_s = self.clock.map_or(0.0, |(clock_s, _)| clock_s) - earlier_s;
            if self.beams.is_empty() {
                self.span_s.0 = lidar_s;
            }
            self.span_s.1 = lidar_s;
            let before_s = self.beams.last().map_or(f64::NEG_INFINITY, |beam| beam.time_s);
            let time_s = (last_s - earlier_s).max(before_s);
            if self.beams.len() < MAX_POINTS {
                self.beams.push(self.beam(angle, point.distance_mm, time_s));
            }
        }
        complete
    }

    /// Time of a packet's last point by the host's clock, seconds.
    fn host_time_s(&mut self, packet: &Packet, now_s: f64) -> f64 {
        let time_ms = packet.time_ms % CLOCK_MS;
        let since = |before: u16| (time_ms + CLOCK_MS - before) % CLOCK_MS;
        let (clock_s, elapsed_s) = match self.clock {
            Some((clock_s, before)) if since(before) <= MAX_GAP_MS => {
                let elapsed_s = f64::from(since(before)) / 1e3;
                (clock_s + elapsed_s, elapsed_s)
            }
            _ => {
                self.beams.clear();
                self.angle = None;
                self.offset_s = f64::INFINITY;
                (0.0, 0.0)
            }
        };
        self.clock = Some((clock_s, time_ms));
        let drifted_s = self.offset_s + MAX_DRIFT * elapsed_s;
        self.offset_s = drifted_s.min(now_s - clock_s);
        clock_s + self.offset_s
    }

    fn beam(&self, angle: f64, distance_mm: u16, time_s: f64) -> Beam {
        let clockwise = angle / f64::from(REVOLUTION) * TAU;
        let counter_clockwise = if self.settings.upside_down { clockwise } else { -clockwise };
        let range = f64::from(distance_mm) / 1e3;
        let is_measured = distance_mm != 0 && range >= self.settings.range_min_m;
        Beam {
            angle: counter_clockwise,
            range: if is_measured && range <= RANGE_MAX_M { range } else { f64::NAN },
            time_s,
        }
    }

    /// Returns the revolution so far, if it took a plausible time; the first one after a gap may be partial.
    fn complete(&mut self) -> Option<TimedScan> {
        let (first_s, last_s) = self.span_s;
        let expected_s = 360.0 / f64::from(self.speed_deg_s.max(1));
        let is_complete = !self.beams.is_empty()
            && (0.5 * expected_s..MAX_REVOLUTION_S).contains(&(last_s - first_s));
        let scan = is_complete.then(|| {
            let beams = self.beams.clone();
            let scan = TimedScan { beams, range_max: RANGE_MAX_M, ..TimedScan::default() };
            scan.from_mount(&self.mount)
        });
        self.beams.clear();
        scan
    }
}
