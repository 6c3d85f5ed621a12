//! Faults of an emulated LD19 lidar, applied to the packets that it writes.

use std::collections::VecDeque;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::{InjectedFault, ScheduledFault, flip_bits};
use crate::base::frame_decoder::Frame;
use crate::base::ld19::{PACKET_LENGTH, POINTS, Packet, Point};

/// Points of a revolution, and the angle between two of them, 0.01 degrees.
const REVOLUTION_POINTS: usize = 450;
const STEP: usize = 80;

/// Angles of the sector that a cover hides, 0.01 degrees to both sides of the front.
const HIDDEN: usize = 4_500;

/// Delay of a late lidar, seconds.
const LATE_S: f64 = 1.0;

/// Applies the scheduled faults of a lidar. Faults of the base have no effect here.
#[derive(Clone, Debug)]
pub struct LidarFaultInjector {
    faults: Vec<ScheduledFault>,
    /// The last revolution before the lidar froze.
    revolution: Vec<Point>,
    /// The last packet before the motor stalled.
    last: Packet,
    /// Delayed packets, each with the time to write them.
    delayed: VecDeque<(f64, Vec<u8>)>,
    rng: Pcg64Mcg,
}

impl LidarFaultInjector {
    /// Creates an injector of these faults.
    #[must_use]
    pub fn new(faults: &[ScheduledFault], seed: u64) -> Self {
        Self {
            faults: faults.to_vec(),
            revolution: vec![Point::default(); REVOLUTION_POINTS],
            last: Packet::default(),
            delayed: VecDeque::new(),
            rng: Pcg64Mcg::seed_from_u64(seed),
        }
    }

    /// Changes, delays or drops whole packets that the lidar writes at a time, seconds.
    pub fn apply(&mut self, now_s: f64, packets: &mut Vec<u8>) {
        for bytes in packets.chunks_exact_mut(PACKET_LENGTH) {
            if let Some(mut packet) = Packet::decode(bytes) {
                self.change(now_s, &mut packet);
                bytes.copy_from_slice(&packet.encode());
            }
            if self.has(InjectedFault::LidarCorrupt, now_s) {
                let at = self.rng.random_range(0..PACKET_LENGTH);
                bytes[at] ^= 1 << self.rng.random_range(0..8);
            }
        }
        if self.has(InjectedFault::LidarBitFlips, now_s) {
            flip_bits(packets, &mut self.rng);
        }
        if self.has(InjectedFault::LidarSilent, now_s) {
            packets.clear();
        }
        let is_late = self.has(InjectedFault::LidarLate, now_s);
        if is_late || !self.delayed.is_empty() {
            let due_s = now_s + if is_late { LATE_S } else { 0.0 };
            self.delayed.push_back((due_s, core::mem::take(packets)));
        }
        while self.delayed.front().is_some_and(|(due_s, _)| *due_s <= now_s) {
            packets.extend(self.delayed.pop_front().map(|(_, bytes)| bytes).unwrap_or_default());
        }
    }

    /// Changes what a packet shows. Its time stamp stays.
    fn change(&mut self, now_s: f64, packet: &mut Packet) {
        let is_frozen = self.has(InjectedFault::LidarFrozen, now_s);
        let is_blind = self.has(InjectedFault::LidarBlind, now_s);
        let is_covered = self.has(InjectedFault::LidarSectorBlind, now_s);
        if self.has(InjectedFault::LidarStalled, now_s) {
            *packet = Packet {
                speed_deg_s: 0,
                points: [self.last.points[POINTS - 1]; POINTS],
                first: self.last.last,
                time_ms: packet.time_ms,
                ..self.last
            };
        }
        self.last = *packet;
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
    }

    fn has(&self, fault: InjectedFault, now_s: f64) -> bool {
        let mut faults = self.faults.iter();
        faults.any(|scheduled| scheduled.fault == fault && scheduled.is_active(now_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The packets of a second, 50 ms apart, with the time at which each is written.
    fn written(fault: InjectedFault) -> Vec<(f64, Vec<u8>)> {
        let mut injector = LidarFaultInjector::new(&[ScheduledFault::from(fault, 0.5)], 7);
        let packet = |tick: u16| Packet {
            speed_deg_s: 3600,
            first: 960 * tick,
            last: 960 * tick + 880,
            points: [Point { distance_mm: 1000 + tick, intensity: 200 }; POINTS],
            time_ms: 50 * tick,
        };
        let step = |tick: u16| {
            let now_s = f64::from(tick) * 0.05;
            let mut line = packet(tick).encode().to_vec();
            injector.apply(now_s, &mut line);
            (now_s, line)
        };
        (0..30).map(step).collect()
    }

    #[test]
    fn late_packets_come_one_second_later_and_complete() {
        let lines = written(InjectedFault::LidarLate);
        let times = |(now_s, line): &(f64, Vec<u8>)| {
            Some((*now_s, Packet::decode(line.get(..PACKET_LENGTH)?)?.time_ms))
        };
        let written: Vec<_> = lines.iter().filter_map(times).collect();
        assert_eq!(written[9], (0.45, 450));
        assert!(
            written[10..]
                .iter()
                .all(|(now_s, ms)| (now_s - f64::from(*ms) / 1e3 - 1.0).abs() < 0.06)
        );
        assert!(written.len() < 25, "{written:?}");
    }

    #[test]
    fn silent_lidar_writes_nothing_and_corrupt_one_no_valid_packet() {
        let silent = written(InjectedFault::LidarSilent);
        assert!(silent[10..].iter().all(|(_, line)| line.is_empty()));
        let corrupt = written(InjectedFault::LidarCorrupt);
        assert!(corrupt[..10].iter().all(|(_, line)| Packet::decode(line).is_some()));
        assert!(corrupt[10..].iter().all(|(_, line)| Packet::decode(line).is_none()));
    }

    #[test]
    fn stalled_lidar_measures_in_one_direction() {
        for (_, line) in &written(InjectedFault::LidarStalled)[10..] {
            let packet = Packet::decode(line).expect("a packet");
            assert_eq!((packet.speed_deg_s, packet.first, packet.span()), (0, 9 * 960 + 880, 0));
            assert!(packet.points.iter().all(|point| point.distance_mm == 1009));
        }
    }
}
