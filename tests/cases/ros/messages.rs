//! Message types: CDR bytes and definitions.

use inbye::ros::msg::{
    DiagnosticStatus, Header, LaserScan, MapMetaData, Marker, Message, OccupancyGrid, Path, Pose,
    PoseStamped, Quaternion, Time,
};

#[test]
fn numbers_are_aligned_to_their_size() {
    let mut meta = MapMetaData {
        map_load_time: Time { sec: -3, nanosec: 0x0102_0304 },
        resolution: 1.5,
        width: 7,
        height: 8,
        origin: Pose::default(),
    };
    meta.origin.position.x = -0.5;
    let expected: [&[u8]; 11] = [
        &[0, 1, 0, 0],
        &[0xFD, 0xFF, 0xFF, 0xFF],
        &[4, 3, 2, 1],
        &[0, 0, 0xC0, 0x3F],
        &[7, 0, 0, 0],
        &[8, 0, 0, 0],
        // The encoding's four bytes do not count.
        &[0; 4],
        &[0, 0, 0, 0, 0, 0, 0xE0, 0xBF],
        &[0; 16],
        &[0; 24],
        &[0, 0, 0, 0, 0, 0, 0xF0, 0x3F],
    ];
    assert_eq!(meta.to_cdr(), expected.concat());
}

#[test]
fn strings_end_with_zero() {
    let status = DiagnosticStatus {
        level: DiagnosticStatus::WARN,
        name: "map".to_owned(),
        ..DiagnosticStatus::default()
    };
    let expected: [&[u8]; 7] = [
        &[0, 1, 0, 0],
        &[1, 0, 0, 0],
        &[4, 0, 0, 0, b'm', b'a', b'p', 0],
        &[1, 0, 0, 0, 0],
        &[0; 3],
        &[1, 0, 0, 0, 0],
        &[0; 7],
    ];
    assert_eq!(status.to_cdr(), expected.concat());
}

#[test]
fn decoding_returns_the_encoded_bits() {
    let quiet_nan = f64::from_bits(0x7FF8_0000_0000_0123);
    for x in [0.1, -0.0, f64::INFINITY, quiet_nan, f64::MIN_POSITIVE / 2.0] {
        let mut pose = PoseStamped::default();
        pose.pose.position.x = x;
        let decoded = PoseStamped::from_cdr(&pose.to_cdr()).expect("a message");
        assert_eq!(decoded.pose.position.x.to_bits(), x.to_bits());
    }
    let header = Header { stamp: Time { sec: -3, nanosec: 7 }, frame_id: "übel".to_owned() };
    let map = OccupancyGrid { header, data: vec![-1, 0, 100], ..OccupancyGrid::default() };
    assert_eq!(OccupancyGrid::from_cdr(&map.to_cdr()), Some(map));
    let marker = Marker {
        r#type: Marker::LINE_LIST,
        frame_locked: true,
        mesh_use_embedded_materials: true,
        text: "arc".to_owned(),
        ..Marker::default()
    };
    assert_eq!(Marker::from_cdr(&marker.to_cdr()), Some(marker));
}

#[test]
fn decoding_rejects_truncated_messages_and_wrong_lengths() {
    let scan = LaserScan { ranges: vec![1.0], ..LaserScan::default() };
    let bytes = scan.to_cdr();
    assert_eq!(LaserScan::from_cdr(&bytes).as_ref(), Some(&scan));
    for end in 0..bytes.len() {
        assert_eq!(LaserScan::from_cdr(&bytes[..end]), None, "{end}");
    }
    assert_eq!(LaserScan::from_cdr(&[&bytes[..], &[0]].concat()), None);
    let mut other_encoding = bytes.clone();
    other_encoding[1] = 0;
    assert_eq!(LaserScan::from_cdr(&other_encoding), None);
    // The length of the ranges is before their only value and the length of the intensities.
    let mut too_long = bytes;
    let at = too_long.len() - 12;
    too_long[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_eq!(LaserScan::from_cdr(&too_long), None);
}

#[test]
fn schema_defines_each_type_once() {
    let schema = Path::schema();
    let lines = || schema.lines().filter(|line| !line.starts_with('#'));
    let own: Vec<&str> = lines().take(2).collect();
    assert_eq!(own, ["std_msgs/Header header", "geometry_msgs/PoseStamped[] poses"]);
    let names: Vec<&str> = lines().filter_map(|line| line.strip_prefix("MSG: ")).collect();
    assert_eq!(
        names,
        [
            "std_msgs/Header",
            "builtin_interfaces/Time",
            "geometry_msgs/PoseStamped",
            "geometry_msgs/Pose",
            "geometry_msgs/Point",
            "geometry_msgs/Quaternion",
        ]
    );
}

#[test]
fn definition_has_constants_defaults_and_keywords() {
    let marker = Marker::schema();
    assert!(marker.contains("\nint32 CYLINDER=3\n") && marker.contains("\nint32 type\n"));
    assert!(Quaternion::schema().contains("\nfloat64 w 1\n"));
}

#[test]
fn times_are_rounded_to_nanoseconds() {
    for (seconds, sec, nanosec) in [
        (2.5, 2, 500_000_000),
        (0.1, 0, 100_000_000),
        (3_600.3, 3_600, 300_000_000),
        (-1.0, 0, 0),
        (f64::NAN, 0, 0),
    ] {
        assert_eq!(Time::from_seconds(seconds), Time { sec, nanosec });
    }
}
