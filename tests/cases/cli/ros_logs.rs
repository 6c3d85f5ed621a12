//! Logs from recordings of ROS 2.
#![cfg(all(feature = "mcap", feature = "logs"))]

use core::f64::consts::FRAC_1_SQRT_2;
use std::collections::BTreeMap;
use std::io::Cursor;

use inbye::geometry::Pose;
use inbye::lidar_log::{LidarLog, LoggedScan};
use inbye::map::TimedScan;
use inbye::recording::{RecordingError, RosLogReader, RosLogWarning};
use inbye::ros::msg::{self, Header, LaserScan, Message, Odometry, TFMessage, Time};
use mcap::records::MessageHeader;
use mcap::write::{WriteOptions, Writer};

use super::logs::{CIRCLE_M, range_m};
use super::program::Workplace;

/// Time of the first message, seconds since 1970.
const EPOCH_S: f64 = 1_700_000_000.0;
/// Pose of the lidar on the robot.
const MOUNT: Pose = Pose { x: 0.2, y: -0.1, yaw: 0.7 };
const BEAMS: usize = 360;
/// Time between two beams, seconds; the robot turns meanwhile.
const BEAM_S: f64 = 0.0002;
const RADIANS_PER_S: f64 = 0.4;

/// What is different in a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Odd {
    Nothing,
    NoMount,
    NoOdometry,
    SecondLidar,
    ShortMessage,
    OnlyShortMessages,
    /// The scans say that they are in big-endian CDR.
    BigEndian,
    OtherEncoding,
    /// Scans are published after newer odometry.
    LateScans,
    /// Of each two odometry messages the newer one comes first.
    SwappedOdometry,
    /// Each odometry message comes twice.
    RepeatedOdometry,
    /// Every second scan has no stamp.
    UnstampedScans,
    /// Scans have no ranges.
    EmptyScans,
    /// Transforms of a tick come after its odometry, and static ones after the first scans.
    LateTransforms,
    /// The frames of a camera and a wheel are tilted.
    TiltedFrames,
    TiltedLidar,
    /// Frames have the slash of ROS 1, and topics a namespace.
    Names,
    SecondOdometry,
    ClockSetBack,
    /// A reading without an echo is the largest range.
    Saturated,
}

/// The true pose on a circle in a room.
fn truth(time_s: f64) -> Pose {
    let (sin, cos) = libm::sincos(RADIANS_PER_S * time_s);
    let yaw = RADIANS_PER_S * time_s + core::f64::consts::FRAC_PI_2;
    Pose::new(CIRCLE_M * cos, CIRCLE_M * sin, libm::remainder(yaw, core::f64::consts::TAU))
}

/// Odometry starts at zero.
fn odometry(time_s: f64) -> Pose {
    truth(0.0).inverse_transform_pose(&truth(time_s))
}

fn header(time_s: f64, frame: &str) -> Header {
    Header { stamp: Time::from_seconds(EPOCH_S + time_s), frame_id: frame.to_owned() }
}

fn scan(begin_s: f64, frame: &str) -> LaserScan {
    let step = core::f64::consts::TAU / BEAMS as f64;
    let range = |beam: usize| {
        let lidar = truth(begin_s + BEAM_S * beam as f64).transform_pose(&MOUNT);
        range_m((lidar.x, lidar.y), lidar.yaw + step * beam as f64) as f32
    };
    LaserScan {
        header: header(begin_s, frame),
        angle_max: (step * (BEAMS - 1) as f64) as f32,
        angle_increment: step as f32,
        time_increment: BEAM_S as f32,
        range_min: 0.05,
        range_max: 20.0,
        ranges: (0..BEAMS).map(range).collect(),
        ..LaserScan::default()
    }
}

fn transform(time_s: f64, [parent, child]: [&str; 2], pose: &Pose) -> TFMessage {
    let transform = msg::Transform::from(pose);
    let stamped = msg::TransformStamped {
        header: header(time_s, parent),
        child_frame_id: child.to_owned(),
        transform,
    };
    TFMessage { transforms: vec![stamped] }
}

/// The place of the lidar, and other fixed frames.
fn static_transforms(odd: Odd) -> TFMessage {
    let mut lidar = transform(0.0, ["base_link", "laser"], &MOUNT);
    let mut camera = transform(0.0, ["base_link", "camera_optical"], &Pose::default());
    camera.transforms[0].transform.rotation = msg::Quaternion { x: -0.5, y: 0.5, z: -0.5, w: 0.5 };
    match odd {
        Odd::TiltedFrames => {
            TFMessage { transforms: [camera.transforms, lidar.transforms].concat() }
        }
        Odd::TiltedLidar => {
            let upside_down = msg::Quaternion { x: 1.0, y: 0.0, z: 0.0, w: 0.0 };
            lidar.transforms[0].transform.rotation = upside_down;
            lidar
        }
        _ => lidar,
    }
}

fn odometry_message(odd: Odd, time_s: f64) -> Odometry {
    let slash = if odd == Odd::Names { "/" } else { "" };
    let set_back_s = if odd == Odd::ClockSetBack && time_s > 10.0 { 5.0 } else { 0.0 };
    Odometry {
        header: header(time_s - set_back_s, "odom"),
        child_frame_id: format!("{slash}base_link"),
        pose: msg::PoseWithCovariance {
            pose: msg::Pose::from(&odometry(time_s)),
            ..Default::default()
        },
        ..Odometry::default()
    }
}

fn scan_message(odd: Odd, tick: u32, begin_s: f64) -> Vec<u8> {
    let mut scan = scan(begin_s, if odd == Odd::Names { "/laser" } else { "laser" });
    if odd == Odd::Saturated {
        scan.ranges.iter_mut().step_by(10).for_each(|range| *range = 20.0);
    }
    if odd == Odd::UnstampedScans && tick.is_multiple_of(2) {
        scan.header.stamp = Time::default();
    }
    if odd == Odd::EmptyScans {
        scan.ranges.clear();
    }
    let mut message = scan.to_cdr();
    if odd == Odd::OnlyShortMessages || odd == Odd::ShortMessage && tick == 50 {
        message.truncate(40);
    }
    if odd == Odd::BigEndian {
        message[1] = 0;
    }
    message
}

/// A recording of 20 s, as `rosbag2` writes it.
fn recording(odd: Odd) -> Vec<u8> {
    let mut file = Bag::new();
    let encoding = if odd == Odd::OtherEncoding { "ros1" } else { "cdr" };
    let statics = if odd == Odd::Names { "/rover/tf_static" } else { "/tf_static" };
    let statics = file.channel::<TFMessage>(statics, "cdr");
    let transforms = file.channel::<TFMessage>("/tf", "cdr");
    let scans = file.channel::<LaserScan>("/front/scan", encoding);
    let rear = (odd == Odd::SecondLidar).then(|| file.channel::<LaserScan>("/rear/scan", "cdr"));
    let odometries = (odd != Odd::NoOdometry).then(|| file.channel::<Odometry>("/odom", "cdr"));
    let camera =
        (odd == Odd::SecondOdometry).then(|| file.channel::<Odometry>("/camera/odom", "cdr"));
    let static_tick = if odd == Odd::LateTransforms { 50 } else { 0 };
    file.write(transforms, 0.0, &transform(0.0, ["map", "odom"], &truth(0.0)).to_cdr());
    for tick in 0..1000_u32 {
        let time_s = 0.02 * f64::from(tick);
        if tick == static_tick && odd != Odd::NoMount {
            file.write(statics, time_s, &static_transforms(odd).to_cdr());
        }
        let mut moved = transform(time_s, ["odom", "base_link"], &odometry(time_s));
        if odd == Odd::TiltedFrames {
            let mut wheel = transform(time_s, ["base_link", "wheel"], &Pose::default()).transforms;
            wheel[0].transform.rotation =
                msg::Quaternion { x: FRAC_1_SQRT_2, y: 0.0, z: 0.0, w: FRAC_1_SQRT_2 };
            moved.transforms.splice(0..0, wheel);
        }
        if odd != Odd::LateTransforms {
            file.write(transforms, time_s, &moved.to_cdr());
        }
        let measured = if odd == Odd::SwappedOdometry { tick ^ 1 } else { tick };
        let measured_s = 0.02 * f64::from(measured);
        let repeated = odometries.filter(|_| odd == Odd::RepeatedOdometry);
        for channel in odometries.into_iter().chain(camera).chain(repeated) {
            file.write(channel, time_s, &odometry_message(odd, measured_s).to_cdr());
        }
        if odd == Odd::LateTransforms {
            file.write(transforms, time_s, &moved.to_cdr());
        }
        // A scan is published at its end, or after newer odometry.
        let ago = if odd == Odd::LateScans { 7 } else { 0 };
        if tick >= ago && (tick - ago).is_multiple_of(5) {
            let message = scan_message(odd, tick, 0.02 * f64::from(tick - ago) + 0.003);
            for channel in [Some(scans), rear].into_iter().flatten() {
                file.write(channel, time_s + 0.075, &message);
            }
        }
    }
    file.finish()
}

struct Bag(Writer<Cursor<Vec<u8>>>);

impl Bag {
    fn new() -> Self {
        // Several chunks: a truncated file is readable up to its last whole one.
        let options = WriteOptions::new().profile("ros2").chunk_size(Some(1 << 16));
        Self(options.create(Cursor::new(Vec::new())).expect("writable memory"))
    }

    fn channel<M: Message>(&mut self, topic: &str, encoding: &str) -> u16 {
        let name = format!("{}/msg/{}", M::PACKAGE, M::NAME);
        let schema = self.0.add_schema(&name, "ros2msg", M::schema().as_bytes());
        let schema = schema.expect("writable memory");
        let channel = self.0.add_channel(schema, topic, encoding, &BTreeMap::new());
        channel.expect("writable memory")
    }

    fn write(&mut self, channel_id: u16, time_s: f64, data: &[u8]) {
        let nanoseconds = ((EPOCH_S + time_s) * 1e9) as u64;
        let header = MessageHeader {
            channel_id,
            sequence: 0,
            log_time: nanoseconds,
            publish_time: nanoseconds,
        };
        self.0.write_to_known_channel(&header, data).expect("writable memory");
    }

    fn finish(mut self) -> Vec<u8> {
        self.0.finish().expect("writable memory");
        self.0.into_inner().into_inner()
    }
}

fn read(file: &[u8]) -> Result<(LidarLog, Vec<RosLogWarning>), RecordingError> {
    let mut reader = RosLogReader::new(None, None);
    reader.read(Cursor::new(file))?;
    reader.finish()
}

#[test]
fn scans_have_odometry_of_their_end_and_the_place_of_the_lidar() {
    let (log, warnings) = read(&recording(Odd::Nothing)).expect("a log");
    assert_eq!((log.scans(), warnings), (200, Vec::new()));
    let mut last_s = -1.0;
    for record in &log.records {
        assert!(record.time_s >= last_s, "records are in the order of their times");
        last_s = record.time_s;
        let expected = odometry(record.time_s);
        let error = record.odometry.position() - expected.position();
        assert!(error.norm() < 1e-4, "{record:?}");
        let corrected = record.corrected.expect("the map's frame is there");
        assert!((corrected.position() - truth(record.time_s).position()).norm() < 0.015);
        let Some(scan) = &record.scan else { continue };
        let TimedScan { beams, .. } = &scan.beams;
        assert_eq!((beams.len(), scan.mount.x, scan.mount.y), (BEAMS, MOUNT.x, MOUNT.y));
        let end_s = beams.last().expect("beams").time_s;
        assert!((end_s - record.time_s).abs() < 1e-6, "{end_s} {}", record.time_s);
    }
    assert_eq!(log.records[0].time_s, 0.0);
}

#[test]
fn map_of_a_recording_is_right_and_the_robot_is_localized_on_it() {
    let place = Workplace::new();
    let whole = recording(Odd::Nothing);
    place.write("bag/bag_0.mcap", &whole);
    let (status, object) = place.json("map bag --out room.yaml");
    assert_eq!((status, &object["scans"]), (0, &200.into()), "{object}");
    let mean_m = object["absolute"]["position_m"]["mean"].as_f64().expect("a mean");
    assert!(mean_m < 0.02, "{object}");
    let (status, object) = place.json("bench localization --log bag/bag_0.mcap --map room.yaml");
    assert_eq!((status, &object["lost_scans"]), (0, &0.into()), "{object}");
    let refused = |odd: Odd, arguments: &str| {
        place.write("odd.mcap", recording(odd));
        place.refusal(&format!("map odd.mcap --out odd.yaml{arguments}"))
    };
    let no_mount = refused(Odd::NoMount, "");
    assert!(no_mount.contains("no transform from base_link to laser"), "{no_mount}");
    let no_odometry = refused(Odd::NoOdometry, "");
    assert!(no_odometry.contains("no Odometry"), "{no_odometry}");
    let two = refused(Odd::SecondLidar, "");
    assert!(two.contains("/front/scan, /rear/scan") && two.contains("--scan-topic"), "{two}");
    let unknown = refused(Odd::Nothing, " --scan-topic /scan");
    assert!(unknown.contains("no LaserScan on /scan: they are on /front/scan"), "{unknown}");
    let poses = refused(Odd::SecondOdometry, "");
    assert!(poses.contains("/odom, /camera/odom") && poses.contains("--odometry-topic"), "{poses}");
    let short = refused(Odd::OnlyShortMessages, "");
    assert!(short.contains("on /front/scan") && short.contains("odd.mcap"), "{short}");
    let big = refused(Odd::BigEndian, "");
    assert!(big.contains("on /front/scan: it is in big-endian CDR"), "{big}");
    let back = refused(Odd::ClockSetBack, "");
    assert!(back.contains("on /odom: its stamp is 5.0 s before"), "{back}");
    let tilted = refused(Odd::TiltedLidar, "");
    assert!(tilted.contains("laser is tilted against base_link"), "{tilted}");
    place.write("odd.mcap", recording(Odd::ShortMessage));
    let one = place.run("map odd.mcap --out odd.yaml");
    assert!(
        one.status == 0
            && one.errors.iter().any(|line| line.contains("messages left out on /front/scan: 1;")),
        "{one:?}"
    );
    let other = refused(Odd::OtherEncoding, "");
    assert!(other.contains("ros1"), "{other}");
    for (file, remedy) in [
        ("one/a.db3", "ros2 bag convert"),
        ("two/a.mcap.zstd", "zstd -d"),
        ("three/a.log.gz", "gunzip"),
    ] {
        place.write(file, b"other data");
        let (folder, _) = file.split_once('/').expect("a folder");
        for log in [file, folder] {
            let other = place.refusal(&format!("map {log} --out odd.yaml"));
            assert!(other.contains(remedy), "{other}");
        }
    }
    // Such a file next to the recording does not matter.
    place.write("bag/bag_0.db3", b"other data");
    assert_eq!(place.run("map bag --out odd.yaml").status, 0);
    place.write("odd.mcap", recording(Odd::SecondLidar));
    assert_eq!(place.run("map odd.mcap --out odd.yaml --scan-topic /rear/scan").status, 0);
}

/// Publishers are late and the frames of other parts are tilted, in usual recordings.
#[test]
fn order_of_messages_and_other_frames_change_no_record() {
    let (expected, _) = read(&recording(Odd::Nothing)).expect("a log");
    for odd in
        [Odd::LateScans, Odd::SwappedOdometry, Odd::LateTransforms, Odd::TiltedFrames, Odd::Names]
    {
        let (log, _) = read(&recording(odd)).expect("a log");
        // The last late scan is not published.
        let scans = if odd == Odd::LateScans { 199 } else { 200 };
        assert_eq!(log.scans(), scans, "{odd:?}");
        for (record, expected) in log.records.iter().zip(&expected.records).take(1190) {
            assert!(record == expected, "{odd:?} at {} s", record.time_s);
        }
    }
}

/// Such readings are no walls at the largest range.
#[test]
fn largest_reading_that_occurs_often_is_no_echo() {
    let (log, _) = read(&recording(Odd::Saturated)).expect("a log");
    let scans = || log.records.iter().filter_map(|record| record.scan.as_ref());
    let without =
        |scan: &LoggedScan| scan.beams.beams.iter().filter(|it| it.range.is_nan()).count();
    assert!(scans().count() > 190 && scans().all(|scan| without(scan) == BEAMS / 10));
}

#[test]
fn messages_that_are_left_out_are_counted() {
    let warnings = |odd| read(&recording(odd)).expect("a log").1;
    let repeated = warnings(Odd::RepeatedOdometry);
    let [RosLogWarning::InvalidMessages { topic, count: 1000, reason }] = repeated.as_slice()
    else {
        panic!("{repeated:?}");
    };
    assert!(topic == "/odom" && reason.contains("another message has its stamp"), "{reason}");
    // A stamp of zero is the start of a simulation's clock, and not within this recording.
    let unstamped = RosLogWarning::ScansWithoutOdometry { count: 100 };
    assert_eq!(warnings(Odd::UnstampedScans), [unstamped]);
    let error = read(&recording(Odd::EmptyScans)).expect_err("no scan has ranges").to_string();
    assert!(error.contains("it has no ranges"), "{error}");
}

/// A file that was cut off is readable up to its last whole chunk; other damage is an error.
#[test]
fn truncated_recording_is_read_and_a_damaged_one_is_refused() {
    let whole = recording(Odd::Nothing);
    let (log, warnings) = read(&whole[..whole.len() * 2 / 3]).expect("most of the log");
    assert!((50..200).contains(&log.scans()), "{}", log.scans());
    assert!(warnings.contains(&RosLogWarning::Truncated), "{warnings:?}");
    assert!(matches!(read(&whole[..1000]), Err(RecordingError::TruncatedLog)));
    for other in [&b"a text, and no MCAP file"[..], b"hello\n", b""] {
        assert!(matches!(read(other), Err(RecordingError::NotMcap)));
    }
}

#[test]
fn drive_of_inbye_is_a_log_too() {
    let place = Workplace::new();
    let drive = place.run("drive --scene dead_end --engine cpu --record run.mcap");
    assert_eq!(drive.status, 0, "{drive:?}");
    let (status, object) = place.json("map run.mcap --out own.yaml");
    assert_eq!(status, 0, "{object}");
    let mean_m = object["absolute"]["position_m"]["mean"].as_f64().expect("a mean");
    assert!(mean_m < 0.1, "{object}");
}

#[test]
fn recording_of_lost_robot_has_no_pose_in_the_map() {
    let place = Workplace::new();
    let drive = "drive --scene roadway --engine cpu --unknown-start --set pose_source=\"scans\" --time-limit 8 --record run.mcap";
    let run = place.run(drive);
    assert!(run.errors.is_empty(), "{run:?}");
    let (log, _) =
        read(&std::fs::read(place.path("run.mcap")).expect("a recording")).expect("a log");
    let corrected: Vec<bool> =
        log.records.iter().map(|record| record.corrected.is_some()).collect();
    assert_eq!([corrected.first(), corrected.last()], [Some(&false), Some(&true)]);
}
