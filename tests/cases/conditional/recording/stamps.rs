//! The times of the messages of a recording.

use std::io::Cursor;

use inbye::geometry::{Point, Pose};
use inbye::map::DistanceField;
use inbye::recording::RosLogReader;
use inbye::sim::MovingObstacles;

use super::drives::{record, tour};

pub const TESTS: &[super::Test] =
    &[("scans_of_a_recording_have_the_time_of_their_pose", scans_have_the_time_of_their_pose)];

/// A lidar that turns slower than the control loop: a program that reads the recording, such as `inbye map`, puts the returns onto
/// the walls, also while the robot turns.
fn scans_have_the_time_of_their_pose() {
    let (mut simulation, mut config) = tour();
    simulation.moving_obstacles = MovingObstacles::default();
    let lidar = &mut config.simulation.lidar;
    (lidar.scan_rate_hz, lidar.sweep_s, lidar.range_sigma_m) = (Some(7.0), 0.14, 0.0);
    let (result, file) = record(&simulation, &config);
    assert!(result.reached);
    let mut reader = RosLogReader::new(None, None);
    reader.read(Cursor::new(file)).expect("a recording");
    let (log, warnings) = reader.finish().expect("a log");
    assert!(warnings.is_empty(), "{warnings:?}");
    let walls = simulation.mission.map.obstacles(config.unknown);
    let distances = DistanceField::new(&walls);
    let (mut returns, mut turning, mut last_yaw) = (0, 0, None);
    for record in &log.records {
        let (Some(pose), Some(scan)) = (record.corrected, &record.scan) else { continue };
        turning += usize::from(last_yaw.is_some_and(|yaw: f64| (yaw - pose.yaw).abs() > 0.05));
        last_yaw = Some(pose.yaw);
        for beam in scan.beams.beams.iter().filter(|beam| beam.range < scan.beams.range_max) {
            let along = Pose { yaw: pose.yaw + beam.angle, ..pose };
            let end = along.transform(&Point::new(beam.range, 0.0));
            let cell = walls.frame().cell_of(&end);
            // In cells of 0.2 m, that of a return on a corner may be diagonal to the wall.
            let distance_m = cell.map_or(f64::INFINITY, |cell| distances.distance_m(cell));
            assert!(distance_m < 0.3, "{distance_m} m from a wall at {} s", record.time_s);
            returns += 1;
        }
    }
    assert!(returns > 10_000 && turning > 10, "{returns} returns, {turning} turns");
}
