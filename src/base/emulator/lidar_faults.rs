//! Faults of an emulated LD19 lidar, applied to the packets that it writes.

use super::{InjectedFault, ScheduledFault};
use crate::base::frame_decoder::Frame;
use crate::base::ld19::{PACKET_LENGTH, POINTS, Packet, Point};

/// Points of a revolution, and the angle between two of them, 0.01 degrees.
const REVOLUTION_POINTS: usize = 450;
const STEP: usize = 80;

/// Angles of the sector that a cover hides, 0.01 degrees to both sides of the front.
const HIDDEN: usize = 4_500;

/// Applies the scheduled faults of a lidar. Faults of the base have no effect here.
#[derive(Clone, Debug)]
pub struct LidarFaultInjector {
    faults: Vec<ScheduledFault>,
    /// The last revolution before the lidar froze.
    revolution: Vec<Point>,
}

impl LidarFaultInjector {
    /// Creates an injector of these faults.
    #[must_use]
    pub fn new(faults: &[ScheduledFault]) -> Self {
        Self { faults: faults.to_vec(), revolution: vec![Point::default(); REVOLUTION_POINTS] }
    }

    /// Changes whole packets that the lidar writes at a time, seconds. Angles and time stamps stay.
    pub fn apply(&mut self, now_s: f64, packets: &mut [u8]) {
        let has = |fault| {
            let mut faults = self.faults.iter();
            faults.any(|scheduled| scheduled.fault == fault && scheduled.is_active(now_s))
        };
        let is_frozen = has(InjectedFault::LidarFrozen);
        let is_blind = has(InjectedFault::LidarBlind);
        let is_covered = has(InjectedFault::LidarSectorBlind);
        for bytes in packets.chunks_exact_mut(PACKET_LENGTH) {
            let Some(mut packet) = Packet::decode(bytes) else {
                continue;
            };
            let step = usize::from(packet.span()) / (POINTS - 1);
            for (index, point) in packet.points.iter_mut().enumerate() {
                let angle = usize::from(packet.first) + step * index;
                let recorded = &mut self.revolution[angle / STEP % REVOLUTION_POINTS];
                if is_frozen {
                    *point = *recorded;
                } else {
                    *recorded = *point;
                }
                let turn = REVOLUTION_POINTS * STEP;
                let from_front = (angle % turn).min(turn - angle % turn);
                if is_blind || is_covered && from_front <= HIDDEN {
                    *point = Point::default();
                }
            }
            bytes.copy_from_slice(&packet.encode());
        }
    }
}
