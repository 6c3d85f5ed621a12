//! The LD19: its packets, damaged streams, revolutions, and the reader.

use std::cell::Cell;
use std::f64::consts::FRAC_PI_2;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use inbye::base::ld19::{
    Decoder, LidarFault, LidarReader, LidarSettings, PACKET_LENGTH, POINTS, Packet, Point,
    RevolutionAssembler,
};
use inbye::base::{BaseConfig, BaseError};
use inbye::geometry::{Pose, Twist};
use inbye::localization::{DeskewedScan, PoseHistory};
use inbye::map::{GridFrame, ObstacleGrid, TimedScan};
use inbye::sim::{Lidar, RotatingLidar, World};
use proptest::collection::vec;
use proptest::prelude::{Strategy, any, prop_assert_eq};

use super::goldens::bytes;
use super::property::for_all;
use super::streams::{Codec, check_streams};

/// The packet of the manual's section on the protocol.
const MANUAL_PACKET: &str = "54 2C 68 08 AB 7E E0 00 E4 DC 00 E2 D9 00 E5 D5 00 E3 D3 00 E4 D0 00 E9 CD 00 E4 CA 00 E2 C7 00 E9 \
    C5 00 E5 C2 00 E5 C0 00 E5 BE 82 3A 1A 50";

fn packets(stream: &[u8]) -> Vec<Packet> {
    let mut decoder = Decoder::default();
    decoder.push(stream);
    decoder.collect()
}

#[test]
fn manual_packet_round_trips() {
    let line = bytes(MANUAL_PACKET);
    let found = packets(&line);
    let [packet] = found.as_slice() else { panic!("{found:?}") };
    assert_eq!(packet.speed_deg_s, 2152);
    assert_eq!((packet.first, packet.last), (32_427, 33_470));
    assert_eq!(packet.time_ms, 6714);
    let distances = packet.points.map(|point| point.distance_mm);
    assert_eq!(distances, [224, 220, 217, 213, 211, 208, 205, 202, 199, 197, 194, 192]);
    assert_eq!((packet.points[0].intensity, packet.points[11].intensity), (228, 229));
    assert_eq!(packet.encode().as_slice(), line);
}

struct Ld19;

impl Codec for Ld19 {
    type Item = Packet;
    fn encode(item: &Packet) -> Vec<u8> {
        item.encode().to_vec()
    }
    fn decode(pieces: &[&[u8]]) -> Vec<Packet> {
        let mut decoder = Decoder::default();
        let mut found = Vec::new();
        for piece in pieces {
            decoder.push(piece);
            found.extend(decoder.by_ref());
        }
        found
    }
}

/// Packets without header bytes in their points, so that damage creates no packet across two of them.
fn packet() -> impl Strategy<Value = Packet> {
    let point = (0..84_u16, 0..84_u8)
        .prop_map(|(high, intensity)| Point { distance_mm: high << 8 | 0x11, intensity });
    (vec(point, POINTS), 0..36_000_u16, 0..9_000_u16, 0..30_000_u16).prop_map(
        |(points, first, span, time_ms)| Packet {
            speed_deg_s: 3600,
            first,
            points: points.try_into().expect("twelve"),
            last: (first + span) % 36_000,
            time_ms,
        },
    )
}

#[test]
fn packets_are_found_in_every_stream() {
    check_streams::<Ld19>(packet());
}

/// A CRC-8 detects every wrong bit and every burst of up to 8 bits; of other damage it accepts one in 256.
#[test]
fn packet_with_wrong_bit_or_burst_is_rejected() {
    let line = bytes(MANUAL_PACKET);
    let flipped = |first: usize, burst: u8| {
        let mut line = line.clone();
        for bit in 0..8 {
            if burst >> bit & 1 != 0 && first + bit < 8 * line.len() {
                // In the order of the CRC: the highest bit of a byte first.
                line[(first + bit) / 8] ^= 0x80 >> ((first + bit) % 8);
            }
        }
        line
    };
    for first in 0..8 * PACKET_LENGTH {
        for burst in (1..=u8::MAX).step_by(2) {
            assert_eq!(packets(&flipped(first, burst)), [], "{burst:08b} from bit {first}");
        }
    }
    let accepted = Cell::new(0);
    for_all(20_000, (packet(), any::<u64>(), 6..41_usize), |(packet, bits, at)| {
        let mut line = packet.encode();
        for (byte, wrong) in line[at..].iter_mut().zip(bits.to_le_bytes()) {
            *byte ^= wrong;
        }
        let found = packets(&line);
        let is_wrong = !found.is_empty() && found != [packet];
        accepted.set(accepted.get() + u32::from(is_wrong));
        Ok(())
    });
    assert!((20..160).contains(&accepted.get()), "{} of 20,000, not one in 256", accepted.get());
}

#[test]
fn false_header_loses_no_later_packet() {
    let good = bytes(MANUAL_PACKET);
    for noise in ["54", "54 2C", "54 54 2C 00", "2C 54", "54 2C 68 08 AB 7E E0"] {
        let noise = bytes(noise);
        let stream = [noise.clone(), good.clone(), good.clone()].concat();
        let mut decoder = Decoder::default();
        let mut found = 0;
        for byte in &stream {
            decoder.push(&[*byte]);
            found += decoder.by_ref().count();
        }
        assert_eq!((found, decoder.dropped_bytes()), (2, noise.len() as u64));
    }
}

/// The CRC of these packets is right.
#[test]
fn impossible_angles_are_rejected() {
    let good = packets(&bytes(MANUAL_PACKET))[0];
    for (first, last) in [(36_000, 100), (100, 36_001), (0, 9_001), (100, 99)] {
        let packet = Packet { first, last, ..good };
        assert_eq!(packets(&packet.encode()), [], "{first} to {last}");
    }
    let across_front = Packet { first: 35_800, last: 500, ..good };
    assert_eq!(packets(&across_front.encode()), [across_front]);
}

/// Packets of a lidar that rotates at 10 Hz and measures the same distance except at one angle, 0.01 degrees clockwise.
fn rotating(seconds: f64, post: u16) -> Vec<Packet> {
    let number = (seconds * 4500.0 / 12.0) as u32;
    let angle = |point: u32| ((point * 80) % 36_000) as u16;
    let packet = |number: u32| Packet {
        speed_deg_s: 3600,
        first: angle(12 * number),
        last: angle(12 * number + 11),
        points: core::array::from_fn(|index| Point {
            distance_mm: if angle(12 * number + index as u32) == post { 1000 } else { 5000 },
            intensity: 200,
        }),
        time_ms: (f64::from(12 * number + 11) / 4.5 % 30_000.0) as u16,
    };
    (0..number).map(packet).collect()
}

/// Assembles packets that arrive with a delay, seconds.
fn assemble(
    settings: LidarSettings,
    packets: &[Packet],
    delay_s: impl Fn(usize) -> f64,
) -> Vec<TimedScan> {
    let mut assembler = RevolutionAssembler::new(settings);
    let mut now_s = 0.0_f64;
    let mut all = Vec::new();
    for (number, packet) in packets.iter().enumerate() {
        let measured_s = 7.0 + (12 * number + 11) as f64 / 4500.0;
        now_s = now_s.max(measured_s + delay_s(number));
        all.extend(assembler.push(packet, now_s));
    }
    all
}

fn post(scan: &TimedScan) -> (f64, f64) {
    let mut near = scan.beams.iter().filter(|beam| beam.range < 2.0);
    let beam = near.next().expect("the post is seen");
    assert!(near.next().is_none());
    (beam.angle, beam.range)
}

#[test]
fn beams_run_counter_clockwise_and_follow_mounting() {
    // A quarter turn clockwise from the front is to the right.
    let scans = assemble(LidarSettings::default(), &rotating(0.55, 9_040), |_| 0.0);
    assert_eq!(scans.len(), 5);
    for scan in &scans {
        let (angle, range) = post(scan);
        assert!((angle + FRAC_PI_2).abs() < 0.008 && (range - 1.0).abs() < 1e-9, "{angle}");
        assert_eq!(scan.beams.len(), 450);
        assert!(scan.is_valid());
        let times = scan.beams.windows(2).map(|pair| pair[1].time_s - pair[0].time_s);
        assert!(times.clone().all(|step_s| (0.0..0.002).contains(&step_s)));
        assert!((times.sum::<f64>() - 449.0 / 4500.0).abs() < 2e-3);
    }
    let mounted = |settings| assemble(settings, &rotating(0.3, 9_040), |_| 0.0)[0].clone();
    let plain = LidarSettings::default();
    let (angle, _) = post(&mounted(plain.upside_down(true)));
    assert!((angle - FRAC_PI_2).abs() < 0.008, "{angle}");
    let scan = mounted(plain.mount_x_m(0.2).mount_yaw_rad(FRAC_PI_2));
    let (angle, range) = post(&scan);
    assert!(angle.abs() < 0.008 && (range - 1.0).abs() < 1e-9, "{angle} {range}");
    assert_eq!((scan.origin.x, scan.origin.y), (0.2, 0.0));
}

/// Buffers deliver bytes in late bursts.
#[test]
fn point_times_are_independent_of_delays() {
    let delay_s = |number: usize| 0.001 + 0.016 * ((number * 7919) % 16) as f64 / 16.0;
    for (number, scan) in
        assemble(LidarSettings::default(), &rotating(40.0, 0), delay_s).iter().enumerate().skip(5)
    {
        // A revolution ends with the last point before the front.
        let end_s = scan.end_s().expect("beams");
        let truth_s = 7.0 + (450 * (number + 1) - 1) as f64 / 4500.0;
        assert!((end_s - truth_s).abs() < 0.004, "revolution {number}: {end_s} {truth_s}");
    }
}

#[test]
fn lost_packets_lose_points_and_gap_loses_revolution() {
    let all = rotating(1.0, 0);
    let without = |lost: core::ops::Range<usize>| -> Vec<Packet> {
        let kept = all.iter().enumerate().filter(|(number, _)| !lost.contains(number));
        kept.map(|(_, packet)| *packet).collect()
    };
    let plain = LidarSettings::default();
    let whole = assemble(plain, &all, |_| 0.0).len();
    let few = assemble(plain, &without(100..103), |_| 0.0);
    assert_eq!(few.len(), whole);
    assert!(few.iter().any(|scan| scan.beams.len() == 450 - 36));
    let gap = assemble(plain, &without(100..160), |_| 0.0);
    assert!(gap.len() < whole && gap.iter().all(TimedScan::is_valid));
    // Zero, too short and too long distances are no measurement.
    let mut invalid = all;
    for packet in &mut invalid {
        packet.points[3].distance_mm = 0;
        packet.points[4].distance_mm = 99;
        packet.points[5].distance_mm = 12_001;
    }
    let scans = assemble(plain, &invalid, |_| 0.0);
    let measured = scans[1].beams.iter().filter(|beam| beam.range.is_finite());
    assert!((336..=339).contains(&measured.count()));
}

#[test]
fn random_packets_make_valid_revolutions() {
    let packets = vec((packet(), 0..7200_u16, 0.0..0.1_f64), 0..200);
    for_all(200, packets, |packets| {
        let mut assembler = RevolutionAssembler::new(LidarSettings::default());
        let mut now_s = 0.0;
        for (packet, speed_deg_s, pause_s) in packets {
            now_s += pause_s;
            let packet = Packet { speed_deg_s, ..packet };
            if let Some(scan) = assembler.push(&packet, now_s) {
                prop_assert_eq!(scan.is_valid(), true);
                let times = || scan.beams.iter().map(|beam| beam.time_s);
                prop_assert_eq!(times().is_sorted(), true);
                let (first_s, last_s) = (times().next(), times().next_back());
                prop_assert_eq!(
                    last_s.zip(first_s).is_some_and(|(last, first)| last - first < 0.5),
                    true
                );
            }
        }
        Ok(())
    });
}

/// The whole chain for a robot on a curve: emulated lidar, decoder, assembler, deskewing.
#[test]
fn deskewed_scans_of_moving_robot_hit_the_walls() {
    hit_the_walls(&Pose::default());
    hit_the_walls(&Pose::new(0.25, -0.1, 1.0));
}

fn hit_the_walls(mount: &Pose) {
    let frame = GridFrame::new(80, 60, 0.1, Pose::default()).expect("a frame");
    let open = |index| {
        let cell = frame.cell_at(index);
        (10..70).contains(&cell.column) && (10..50).contains(&cell.row)
    };
    let world =
        World::new(ObstacleGrid::new(frame, (0..frame.len()).map(|index| !open(index)).collect()));
    let quiet = Lidar::default().range_sigma_m(0.0).dropout(0.0);
    let lidar = quiet.mount_x_m(mount.x).mount_y_m(mount.y).mount_yaw_rad(mount.yaw);
    let mut lidar = RotatingLidar::new(lidar, world, 1).expect("good settings");
    let settings = LidarSettings::default();
    let settings = settings.mount_x_m(mount.x).mount_y_m(mount.y).mount_yaw_rad(mount.yaw);
    let (start, twist) = (Pose::new(2.5, 2.0, 0.3), Twist::new(0.8, 0.7));
    let (mut decoder, mut assembler) = (Decoder::default(), RevolutionAssembler::new(settings));
    let (mut history, mut scans) = (PoseHistory::new(), 0);
    for tick in 0..400 {
        let now_s = 0.005 * f64::from(tick);
        let pose = start.after(&twist, now_s);
        let mut line = Vec::new();
        lidar.step(now_s, &pose, &mut line);
        history.record(now_s, &pose);
        decoder.push(&line);
        for packet in decoder.by_ref() {
            let Some(scan) = assembler.push(&packet, now_s) else {
                continue;
            };
            let mut deskewed = DeskewedScan::default();
            deskewed.deskew(&scan, &history);
            scans += 1;
            assert!(deskewed.hits.len() > 440);
            for hit in &deskewed.hits {
                let at = pose.transform(&hit.end);
                let off_x = (at.x - 1.0).abs().min((at.x - 7.0).abs());
                let off_y = (at.y - 1.0).abs().min((at.y - 5.0).abs());
                // Packet times have a resolution of 1 ms, in which the robot moves about 1 mm.
                assert!(off_x.min(off_y) < 0.015, "{at:?} at {now_s}");
            }
        }
    }
    assert_eq!((scans, decoder.dropped_bytes()), (19, 0));
}

/// A port in memory; once closed it returns no more bytes.
#[derive(Clone, Default)]
struct Port(Arc<Mutex<(Vec<u8>, bool)>>);

impl std::io::Read for Port {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        let mut line = self.0.lock().expect("not poisoned");
        if line.1 {
            return Ok(0);
        }
        if line.0.is_empty() {
            drop(line);
            std::thread::sleep(Duration::from_millis(2));
            return Err(std::io::ErrorKind::TimedOut.into());
        }
        let count = line.0.len().min(bytes.len());
        bytes[..count].copy_from_slice(&line.0[..count]);
        line.0.drain(..count);
        Ok(count)
    }
}

/// Waits until the reader's status satisfies a condition, long enough for a busy machine.
fn await_status(
    reader: &LidarReader,
    what: &str,
    condition: impl Fn(&inbye::base::ld19::LidarStatus) -> bool,
) {
    let started = Instant::now();
    while !condition(&reader.status()) {
        assert!(started.elapsed() < Duration::from_secs(20), "{what}: {:?}", reader.status());
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn reader_reports_faults_and_recovers() {
    let line = Port::default();
    let opened = line.clone();
    let open = Box::new(move || -> Result<Box<dyn std::io::Read + Send>, BaseError> {
        if opened.0.lock().expect("not poisoned").1 {
            return Err(BaseError::Disconnected { port: "port".to_owned() });
        }
        Ok(Box::new(opened.clone()))
    });
    let reader = LidarReader::start(open, LidarSettings::default()).expect("open");
    let write = |bytes: &[u8]| line.0.lock().expect("not poisoned").0.extend(bytes);
    let stream =
        |packets: &[Packet]| -> Vec<u8> { packets.iter().flat_map(Packet::encode).collect() };
    let silent = |status: &inbye::base::ld19::LidarStatus| {
        matches!(status.fault, Some(LidarFault::Silent { .. }))
    };
    await_status(&reader, "nothing yet", silent);
    write(&stream(&rotating(0.5, 0)));
    await_status(&reader, "turns", |status| status.revolutions == 4 && status.scan.is_some());
    await_status(&reader, "silent", silent);
    write(&[0x55; 5000]);
    await_status(&reader, "unknown data", |status| status.fault == Some(LidarFault::UnknownData));
    // A revolution of half a second is 720 degrees per second.
    for speed_deg_s in [719, 0] {
        let standing = Packet { speed_deg_s, ..rotating(0.1, 0)[0] };
        write(&standing.encode());
        await_status(&reader, "not rotating", |status| {
            status.fault == Some(LidarFault::NotRotating)
        });
    }
    line.0.lock().expect("not poisoned").1 = true;
    let disconnected = |status: &inbye::base::ld19::LidarStatus| matches!(&status.fault, Some(fault @ LidarFault::Disconnected { .. }) if fault.to_string().contains("plug it in"));
    await_status(&reader, "disconnected", disconnected);
    line.0.lock().expect("not poisoned").1 = false;
    await_status(&reader, "open again", |status| status.connections == 2);
    write(&stream(&rotating(0.5, 0)));
    await_status(&reader, "turns again", |status| status.revolutions == 8);
    let dropped_bytes = reader.status().dropped_bytes;
    assert!(dropped_bytes >= 5000, "{dropped_bytes}: those before the reconnection count too");
}

/// The lidar was moved or replaced meanwhile.
#[test]
fn no_revolution_has_points_from_before_and_after_a_reconnection() {
    let line = Port::default();
    let opened = line.clone();
    let open = Box::new(move || -> Result<Box<dyn std::io::Read + Send>, BaseError> {
        opened.0.lock().expect("not poisoned").1 = false;
        Ok(Box::new(opened.clone()))
    });
    let reader = LidarReader::start(open, LidarSettings::default()).expect("open");
    let packets = rotating(0.5, 0);
    // The rest of the turn that is cut is too short to count as a revolution.
    let (before, after) = packets.split_at(packets.len() * 27 / 50);
    for (part, connections) in [(before, 1), (after, 2)] {
        let bytes = part.iter().flat_map(Packet::encode);
        line.0.lock().expect("not poisoned").0.extend(bytes);
        let read = reader.status().packets + part.len() as u64;
        await_status(&reader, "packets", |status| status.packets == read);
        assert_eq!(reader.status().connections, connections);
        line.0.lock().expect("not poisoned").1 = true;
        await_status(&reader, "opened", |status| status.connections == connections + 1);
    }
    assert_eq!(reader.status().revolutions, 3, "the fourth would have points of both");
}

#[test]
fn lidar_settings_reject_value_out_of_range() {
    let bad = LidarSettings::default().mount_yaw_rad(4.0);
    let config = BaseConfig::default().lidar(bad);
    let message = config.validate().expect_err("out of range").to_string();
    assert_eq!(message, "[lidar] mount_yaw_rad is 4: it must be -3.2 to 3.2");
}
