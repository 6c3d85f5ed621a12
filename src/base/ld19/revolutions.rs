//! Whole turns of packets, each point with its time by the host's clock.

use core::f64::consts::TAU;

use super::frames::{POINTS, TURN};
use super::{LidarSettings, Packet, RANGE_MAX_M};
use crate::geometry::Pose;
use crate::map::{Beam, TimedScan};

/// The lidar's clock begins anew after so long, ms.
const CLOCK_MS: u16 = 30_000;

/// A packet this much later than the one before by the lidar's clock, ms, is not the next one: what lies between is lost.
const GAP_MS: u16 = 100;

/// The two clocks may drift apart by this share: usual crystals are a hundred times better.
const DRIFT: f64 = 1e-3;

/// A turn that takes longer than this, seconds, is none: it stands.
const LONGEST_S: f64 = 0.5;

/// Points of a turn that are kept: no lidar of the kind makes as many.
const MOST: usize = 4096;

/// Puts packets together.
///
/// Bytes reach the host late by what lies in buffers, never early. So of all packets the one that came soonest after its own time
/// tells the difference of the clocks best.
#[derive(Clone, Debug)]
pub struct Revolutions {
    settings: LidarSettings,
    mount: Pose,
    /// The lidar's clock without its beginnings anew, seconds, and its last reading.
    clock: Option<(f64, u16)>,
    /// The host's clock less the lidar's, seconds.
    ahead_s: f64,
    /// Angle of the last point, 0.01 degrees clockwise.
    angle: Option<f64>,
    turn: Vec<Beam>,
    /// When its first and its last point were measured, by the lidar's clock, seconds.
    took: (f64, f64),
    speed_deg_s: u16,
}

impl Revolutions {
    /// Of a lidar that sits so on the robot. The settings are valid.
    #[must_use]
    pub fn new(settings: LidarSettings) -> Self {
        Self {
            settings,
            mount: settings.mount(),
            clock: None,
            ahead_s: f64::INFINITY,
            angle: None,
            turn: Vec::with_capacity(MOST),
            took: (0.0, 0.0),
            speed_deg_s: 0,
        }
    }

    /// How fast it turns, degrees per second, as the last packet has it.
    #[must_use]
    pub const fn speed_deg_s(&self) -> u16 {
        self.speed_deg_s
    }

    /// Takes a packet that came at a time by the host's clock, seconds, which does not descend; gives the turn that it completes. The
    /// beams of a turn are those from one passing of the sensor's front to the next, in the robot's frame.
    pub fn take(&mut self, packet: &Packet, now_s: f64) -> Option<TimedScan> {
        let last_s = self.host_time_s(packet, now_s);
        self.speed_deg_s = packet.speed_deg_s;
        let step = f64::from(packet.span()) / (POINTS - 1) as f64;
        // A lidar that stands measures all points of a packet at once.
        let step_s = match packet.speed_deg_s {
            0 => 0.0,
            speed => step / 100.0 / f64::from(speed),
        };
        let mut whole = None;
        for (index, point) in packet.points.iter().enumerate() {
            let angle = (f64::from(packet.first) + step * index as f64) % f64::from(TURN);
            let passes_front = self
                .angle
                .is_some_and(|before| before - angle > f64::from(TURN) / 2.0);
            if passes_front {
                whole = self.complete().or(whole);
            }
            self.angle = Some(angle);
            let earlier_s = (POINTS - 1 - index) as f64 * step_s;
            let own_s = self.clock.map_or(0.0, |(clock_s, _)| clock_s) - earlier_s;
            if self.turn.is_empty() {
                self.took.0 = own_s;
            }
            self.took.1 = own_s;
            let before_s = self
                .turn
                .last()
                .map_or(f64::NEG_INFINITY, |beam| beam.time_s);
            let time_s = (last_s - earlier_s).max(before_s);
            if self.turn.len() < MOST {
                self.turn.push(self.beam(angle, point.distance_mm, time_s));
            }
        }
        whole
    }

    /// When a packet's last point was measured, by the host's clock, seconds.
    fn host_time_s(&mut self, packet: &Packet, now_s: f64) -> f64 {
        let time_ms = packet.time_ms % CLOCK_MS;
        let passed = |before: u16| (time_ms + CLOCK_MS - before) % CLOCK_MS;
        let (clock_s, elapsed_s) = match self.clock {
            Some((clock_s, before)) if passed(before) <= GAP_MS => {
                let elapsed_s = f64::from(passed(before)) / 1e3;
                (clock_s + elapsed_s, elapsed_s)
            }
            _ => {
                self.turn.clear();
                self.angle = None;
                self.ahead_s = f64::INFINITY;
                (0.0, 0.0)
            }
        };
        self.clock = Some((clock_s, time_ms));
        let least_s = self.ahead_s + DRIFT * elapsed_s;
        self.ahead_s = least_s.min(now_s - clock_s);
        clock_s + self.ahead_s
    }

    fn beam(&self, angle: f64, distance_mm: u16, time_s: f64) -> Beam {
        let clockwise = angle / f64::from(TURN) * TAU;
        let own = if self.settings.upside_down {
            clockwise
        } else {
            -clockwise
        };
        let range = f64::from(distance_mm) / 1e3;
        let is_measured = distance_mm != 0 && range >= self.settings.range_min_m;
        let beam = Beam {
            angle: own,
            range: if is_measured && range <= RANGE_MAX_M {
                range
            } else {
                f64::NAN
            },
            time_s,
        };
        beam.from_mount(&self.mount)
    }

    /// The turn so far, if it is whole in time and not the rest of one.
    fn complete(&mut self) -> Option<TimedScan> {
        let (first_s, last_s) = self.took;
        let expected_s = 360.0 / f64::from(self.speed_deg_s.max(1));
        let is_whole =
            !self.turn.is_empty() && (0.5 * expected_s..LONGEST_S).contains(&(last_s - first_s));
        let sweep = is_whole.then(|| TimedScan {
            beams: self.turn.clone(),
            range_max: RANGE_MAX_M + self.mount.position().coords.norm(),
        });
        self.turn.clear();
        sweep
    }
}
