//! Scans of rooms and halls with a lidar that is covered, in part or as a whole.

use super::*;
use crate::map::{Cell, GridFrame};

/// A room of 8 by 8 m, or a hall of 40 by 40 m, with the robot in its middle.
fn room(side_m: f64) -> ObstacleGrid {
    let side = (side_m / 0.1) as i32;
    let origin = Pose::new(-side_m / 2.0, -side_m / 2.0, 0.0);
    let frame = GridFrame::new(side, side, 0.1, origin).expect("a valid size");
    ObstacleGrid::from_fn(frame, |cell| {
        [cell.column, cell.row].iter().any(|&at| at == 0 || at == side - 1)
    })
}

/// A scan with a return in each direction where this holds.
fn scan(returns: impl Fn(f64) -> bool, otherwise: f64) -> Scan {
    let mut scan = Scan {
        angle_min: -core::f64::consts::PI,
        angle_increment: TAU / 360.0,
        range_max: 12.0,
        ranges: vec![otherwise; 360],
        ..Scan::default()
    };
    for beam in 0..360 {
        if returns(wrap_angle(scan.angle(beam))) {
            scan.ranges[beam] = 4.0;
        }
    }
    scan
}

fn body() -> Footprint {
    Footprint::round(0.3).expect("a radius")
}

fn after(scans: u32, scan: &Scan, known: &ObstacleGrid) -> ScanHealth {
    let mut health = ScanHealth::default();
    let known = RayCaster::new(known);
    for _ in 0..scans {
        health.update(&Pose::default(), scan, &known);
    }
    health
}

#[test]
fn lidar_without_returns_is_blind_between_walls_and_not_in_a_hall() {
    let room = room(8.0);
    for otherwise in [f64::INFINITY, f64::NAN, 13.0] {
        let nothing = scan(|_| false, otherwise);
        assert_eq!(after(1, &nothing, &room).fault(), None);
        assert!(after(1, &nothing, &room).is_suspect());
        assert_eq!(after(2, &nothing, &room).fault(), Some(ObservationFault::LidarBlind));
        assert_eq!(after(9, &nothing, &self::room(40.0)).fault(), None);
    }
    // A fifth of the beams suffices, also of those from a crowd around the robot.
    assert_eq!(after(9, &scan(|_| true, f64::INFINITY), &room).fault(), None);
}

#[test]
fn sector_without_returns_is_blind_until_it_sees_again() {
    let room = room(8.0);
    let covered =
        |from: f64, to: f64| scan(move |direction| !(from..to).contains(&direction), f64::INFINITY);
    // Ahead: the robot may not drive.
    let mut health = after(3, &covered(-0.3, 0.3), &room);
    assert_eq!(health.fault(), Some(ObservationFault::LidarPartlyBlind));
    assert!(health.is_blind_towards(0.0) && !health.is_blind_towards(1.0));
    health.update(&Pose::default(), &covered(9.0, 9.0), &RayCaster::new(&room));
    assert_eq!((health.fault(), health.blind_sectors()), (None, 0));
    // To the left: it drives on, and learns nothing there.
    let left = covered(1.2, 2.0);
    let health = after(3, &left, &room);
    assert_eq!(health.fault(), None);
    assert!(health.is_blind_towards(1.57) && !health.is_blind_towards(-1.57));
    let masked = health.masked(&left, &body()).expect("a blind sector");
    assert!(masked.ranges[270].is_nan() && masked.ranges[90] == 4.0);
    let mut grid = self::room(8.0);
    health.block_unseen(&mut grid, &Pose::default(), 1.0);
    let blocked = |x: f64, y: f64| {
        grid.frame().cell_of(&Point::new(x, y)).is_some_and(|cell| grid.is_blocked(cell))
    };
    assert!(blocked(0.0, 1.5) && !blocked(0.0, 0.8) && !blocked(0.0, -1.5) && !blocked(1.5, 0.0));
}

/// The walls are at 0.6 of the range, beyond half of it.
#[test]
fn covered_sector_of_a_hall_is_blind_once_scans_have_shown_how_far_the_lidar_sees() {
    let hall = RayCaster::new(&room(14.4));
    let walls = |covered: Range<f64>| {
        let mut scan = scan(|direction| !covered.contains(&direction), f64::INFINITY);
        scan.ranges.iter_mut().filter(|range| range.is_finite()).for_each(|range| *range = 7.2);
        scan
    };
    let blind_after = |open_scans: u32| {
        let mut health = ScanHealth::default();
        (0..open_scans).for_each(|_| health.update(&Pose::default(), &walls(9.0..9.0), &hall));
        (0..30).for_each(|_| health.update(&Pose::default(), &walls(-0.6..0.6), &hall));
        health.fault()
    };
    assert_eq!(blind_after(20), Some(ObservationFault::LidarPartlyBlind));
    let mut health = ScanHealth::default();
    (0..3).for_each(|_| health.update(&Pose::default(), &walls(-0.6..0.6), &hall));
    assert_eq!(health.fault(), None, "nothing has been shown");
}

#[test]
fn glass_and_dropouts_do_not_count_as_blindness() {
    let room = room(8.0);
    // Every second beam, and a pane of 15 degrees.
    let patchy = scan(|direction| (direction * 180.0) as i32 % 2 == 0, f64::NAN);
    assert_eq!(after(9, &patchy, &room).blind_sectors(), 0);
    let pane = scan(|direction| !(0.0..0.26).contains(&direction), f64::INFINITY);
    assert_eq!(after(9, &pane, &room).blind_sectors(), 0);
}

#[test]
fn few_and_near_expected_returns_show_no_blindness() {
    let nothing = scan(|_| false, f64::INFINITY);
    // A post of 0.4 m in a hall: two beams of a sector.
    let mut hall = room(40.0);
    for row in 198..202 {
        hall.set(Cell::new(230, row), true);
    }
    assert_eq!(after(9, &nothing, &hall).blind_sectors(), 0);
    // Walls that the robot touches.
    let narrow = after(9, &nothing, &room(0.6));
    assert_eq!((narrow.blind_sectors(), narrow.fault()), (0, None));
    // Walls beyond half of the range.
    let wide = after(9, &nothing, &room(13.0));
    assert_eq!((wide.blind_sectors(), wide.fault()), (0, None));
}

/// A roadway along x, 3 m wide, whose ends are out of range.
#[test]
fn gap_that_hides_the_edges_of_a_long_roadway_is_blind() {
    let frame = GridFrame::new(400, 50, 0.1, Pose::new(-20.0, -2.5, 0.0)).expect("a size");
    let roadway = ObstacleGrid::from_fn(frame, |cell| !(10..40).contains(&cell.row));
    // The walls are more than 6 m away within 0.25 rad of the axis.
    for (half_width, blind) in [(0.25, 0), (0.3, 0), (0.5, 3)] {
        let covered = scan(
            |direction| {
                let to_axis = direction.abs().min(core::f64::consts::PI - direction.abs());
                direction.abs() > half_width && to_axis > 0.12
            },
            f64::INFINITY,
        );
        let health = after(DARK_SCANS, &covered, &roadway);
        assert_eq!(health.blind_sectors(), blind, "{half_width} rad");
        assert_eq!(health.fault().is_some(), blind > 0);
    }
    // The open end of the roadway shows that the lidar sees again.
    let open = |direction: f64| {
        let to_axis = direction.abs().min(core::f64::consts::PI - direction.abs());
        to_axis > 0.25
    };
    let mut health = after(DARK_SCANS, &scan(|_| false, f64::INFINITY), &room(8.0));
    assert!(health.is_blind_towards(0.0));
    health.update(&Pose::default(), &scan(open, f64::INFINITY), &RayCaster::new(&roadway));
    assert!(!health.is_blind_towards(0.0));
}

/// The room has an opening ahead, through which the lidar sees no surface, and something stands before the walls beside it.
#[test]
fn opening_without_a_return_is_seen_again_with_both_its_sides() {
    let mut known = room(8.0);
    (30..50).for_each(|row| known.set(Cell::new(79, row), false));
    let rays = RayCaster::new(&known);
    let near = |returns: &dyn Fn(f64) -> bool| {
        let mut seen = scan(returns, f64::INFINITY);
        seen.ranges.iter_mut().filter(|range| range.is_finite()).for_each(|range| *range = 2.0);
        seen
    };
    let covered = near(&|direction| direction.abs() > 0.7);
    let mut health = after(DARK_SCANS, &covered, &known);
    assert!(health.is_blind_towards(0.0) && health.fault().is_some());
    health.update(&Pose::default(), &near(&|to| !(-0.26..0.7).contains(&to)), &rays);
    assert!(health.is_blind_towards(0.0), "one side is still covered");
    health.update(&Pose::default(), &near(&|direction| direction.abs() > 0.26), &rays);
    assert_eq!((health.blind_sectors(), health.fault()), (0, None));
}

#[test]
fn returns_in_a_hall_end_the_blindness_of_a_room() {
    let mut health = after(2, &scan(|_| false, f64::NAN), &room(8.0));
    assert_eq!(health.fault(), Some(ObservationFault::LidarBlind));
    let hall = RayCaster::new(&room(40.0));
    health.update(&Pose::default(), &scan(|_| false, f64::NAN), &hall);
    assert!(health.is_suspect(), "a hall shows nothing");
    health.update(&Pose::default(), &scan(|_| true, f64::NAN), &hall);
    assert!(!health.is_suspect());
    assert_eq!(health.fault(), None);
}

/// Blindness on the left of a robot that looks along y.
#[test]
fn blocked_cells_turn_with_the_robot() {
    let left = scan(|direction| !(1.2..2.0).contains(&direction), f64::INFINITY);
    let pose = Pose::new(0.0, 0.0, 1.57);
    let mut health = ScanHealth::default();
    for _ in 0..3 {
        health.update(&pose, &left, &RayCaster::new(&room(8.0)));
    }
    let mut grid = room(8.0);
    health.block_unseen(&mut grid, &pose, 1.0);
    let blocked = |x: f64, y: f64| {
        grid.frame().cell_of(&Point::new(x, y)).is_some_and(|cell| grid.is_blocked(cell))
    };
    assert!(blocked(-1.5, 0.0) && !blocked(1.5, 0.0));
    assert!(!blocked(0.0, 1.5) && !blocked(0.0, -1.5) && !blocked(-0.8, 0.0));
}

#[test]
fn single_blind_scans_with_good_ones_between_do_not_add_up() {
    let (room, mut health) = (RayCaster::new(&room(8.0)), ScanHealth::default());
    for _ in 0..3 {
        health.update(&Pose::default(), &scan(|_| false, f64::NAN), &room);
        assert!(health.is_suspect() && health.fault().is_none());
        health.update(&Pose::default(), &scan(|_| true, f64::NAN), &room);
        assert!(!health.is_suspect());
    }
}

/// Four fifths of a sector's beams, and nine tenths of all.
#[test]
fn shares_of_missing_returns_decide() {
    let room = room(8.0);
    let share = |lost: i32| {
        scan(move |direction| (direction.to_degrees() + 720.0) as i32 % 20 >= lost, f64::NAN)
    };
    assert!(after(9, &share(8), &room).fault().is_none());
    assert!(!after(9, &share(14), &room).is_suspect());
    assert_eq!(after(9, &share(20), &room).fault(), Some(ObservationFault::LidarBlind));
    // The third dark scan makes a sector blind.
    let left = scan(|direction| !(1.2..2.0).contains(&direction), f64::INFINITY);
    assert_eq!(after(2, &left, &room).blind_sectors(), 0);
    assert!(after(3, &left, &room).blind_sectors() > 0);
    // Ahead counts to both sides of the heading.
    for middle in [0.75, -0.75] {
        let covered = scan(move |direction| (direction - middle).abs() > 0.3, f64::INFINITY);
        let fault = after(3, &covered, &room).fault();
        assert_eq!(fault, Some(ObservationFault::LidarPartlyBlind), "{middle}");
    }
}

/// A sector that the map does not judge keeps what is known of it.
#[test]
fn sector_stays_blind_until_returns_are_seen() {
    let left = scan(|direction| !(1.2..2.0).contains(&direction), f64::INFINITY);
    let mut health = after(3, &left, &room(8.0));
    let blind = health.blind_sectors();
    health.update(&Pose::default(), &left, &RayCaster::new(&room(40.0)));
    assert_eq!(health.blind_sectors(), blind);
    // Returns from what is not in the map show that the lidar sees.
    health.update(&Pose::default(), &scan(|_| true, f64::NAN), &RayCaster::new(&room(40.0)));
    assert_eq!(health.blind_sectors(), 0);
}

/// A wall along one side of a map whose columns lie along the world's y axis.
#[test]
fn expected_surfaces_turn_with_robot_and_map() {
    let origin = Pose::new(6.0, -6.0, core::f64::consts::FRAC_PI_2);
    let frame = GridFrame::new(120, 120, 0.1, origin).expect("a valid size");
    let mut known = ObstacleGrid::filled(frame, false);
    (0..120).for_each(|row| known.set(Cell::new(100, row), true));
    // The wall is at y = 4 m.
    let nothing = scan(|_| false, f64::NAN);
    for (yaw, left) in [(0.0, 1.57), (1.57, 0.0), (3.0, -1.43)] {
        let mut health = ScanHealth::default();
        for _ in 0..3 {
            health.update(&Pose::new(0.0, 0.0, yaw), &nothing, &RayCaster::new(&known));
        }
        assert!(health.is_blind_towards(left) && !health.is_blind_towards(left + 3.0), "{yaw}");
    }
}

/// A driver that loses a part of its messages may publish the rest as a whole scan.
#[test]
fn scan_that_became_shorter_is_blind_where_beams_are_missing() {
    let room = RayCaster::new(&room(8.0));
    let full = scan(|_| true, f64::NAN);
    let mut short = full.clone();
    short.ranges.truncate(90);
    let mut health = ScanHealth::default();
    (0..9).for_each(|_| health.update(&Pose::default(), &short, &room));
    assert_eq!(health.fault(), None, "a lidar that never looked ahead");
    health.update(&Pose::default(), &full, &room);
    (0..2).for_each(|_| health.update(&Pose::default(), &short, &room));
    assert_eq!(health.fault(), None);
    health.update(&Pose::default(), &short, &room);
    assert_eq!(health.fault(), Some(ObservationFault::LidarPartlyBlind));
    health.update(&Pose::default(), &full, &room);
    assert_eq!((health.fault(), health.blind_sectors()), (None, 0));
}

#[test]
fn returns_of_a_blind_sector_are_not_masked() {
    let left = scan(|direction| !(1.2..2.0).contains(&direction), f64::INFINITY);
    let health = after(3, &left, &room(8.0));
    let mut seen = left;
    seen.ranges[270] = 2.0;
    let masked = health.masked(&seen, &body()).expect("a blind sector");
    assert!(masked.ranges[270] == 2.0 && masked.ranges[272].is_nan());
}
