//! Scan health: in which directions the lidar measures, judged by the map.
//!
//! A lidar behind a covered window reports no return in any direction, as one in a wide hall does. The map tells the two apart:
//! where it shows a surface well within range, a beam without a return contradicts it. A single such beam is no evidence (glass,
//! a black surface, a removed wall). Most beams of a sector in several scans show that the lidar does not see there.

use core::f64::consts::TAU;

use super::ObservationFault;
use super::scan_visibility::{ends_alone_within, is_full_turn};
use crate::geometry::{Point, Pose, bearing, wrap_angle};
use crate::map::{ObstacleGrid, RayCaster, RayEnd, Scan};
use crate::robot::Footprint;

/// Sectors around the lidar; the first is centred in the direction of the robot's x axis.
pub(super) const SECTORS: usize = 16;
/// Beams that are compared with the map in each sector.
const RAYS: usize = 12;
/// The map must show a surface within this share of the lidar's range: far and grazed surfaces return little.
const SURE_RANGE_SHARE: f64 = 0.5;
/// Nearer surfaces do not count, metres: a small error of the pose puts the robot onto them.
const MIN_RANGE_M: f64 = 0.3;
/// A sector is judged by at least this many beams that the map expects to return.
const MIN_EXPECTED: u32 = 6;
/// The end of a roadway is out of range. A gap there, neighbouring beams without a return, is dark if it hides the walls too: this
/// many beams. It is open if the walls are seen from this share of the sure range on.
const MIN_EXPECTED_IN_GAP: usize = 6;
const OPEN_SHARE: f64 = 0.5;
/// The lidar as a whole is judged by at least this many.
const MIN_EXPECTED_IN_ALL: u32 = 12;
/// Share of the expected beams without a return from which a sector is dark, and the whole lidar.
const DARK_SHARE: f64 = 0.75;
const BLIND_SHARE: f64 = 0.9;
/// Scans in a row that a sector is dark, or the whole lidar, until it counts as blind.
const DARK_SCANS: u32 = 3;
const BLIND_SCANS: u32 = 2;
/// A robot does not drive with a blind sector within this of its heading, radians.
const FRONT: f64 = 0.8;

/// What one scan shows in a sector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Coverage {
    /// Compared beams, and those of them with a return.
    beams: u32,
    returns: u32,
    /// Beams that end on a surface of the map within the sure range, and those of them without a return.
    expected: u32,
    missing: u32,
    /// Beams in dark gaps, and in open ones.
    in_dark_gaps: u32,
    in_open_gaps: u32,
}

impl Coverage {
    /// Whether the scan contradicts the map, or `None` without enough evidence.
    fn is_dark(&self) -> Option<bool> {
        if 2 * self.in_dark_gaps > self.beams {
            return Some(true);
        }
        if 2 * self.in_open_gaps > self.beams {
            return Some(false);
        }
        if self.expected < MIN_EXPECTED {
            // Returns from obstacles that are not in the map show that the lidar sees.
            return (2 * self.returns >= self.beams && self.returns > 0).then_some(false);
        }
        Some(f64::from(self.missing) >= DARK_SHARE * f64::from(self.expected))
    }
}

/// Judges scans, one after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct ScanHealth {
    /// For each sector, the number of scans in a row that were dark.
    dark_scans: [u32; SECTORS],
    blind_scans: u32,
    /// Place of the lidar in the robot's frame.
    lidar: Point,
}

impl ScanHealth {
    /// Judges a new scan from a pose in the map.
    pub fn update(&mut self, pose: &Pose, scan: &Scan, known: &RayCaster) {
        self.lidar = scan.origin;
        let sectors = coverage(pose, scan, known);
        let sum = |count: fn(&Coverage) -> u32| sectors.iter().map(count).sum::<u32>();
        let (expected, missing) = (sum(|one| one.expected), sum(|one| one.missing));
        if expected >= MIN_EXPECTED_IN_ALL {
            let is_blind = f64::from(missing) >= BLIND_SHARE * f64::from(expected);
            self.blind_scans = if is_blind { self.blind_scans + 1 } else { 0 };
        } else if sum(|one| one.returns) >= MIN_EXPECTED_IN_ALL {
            self.blind_scans = 0;
        }
        for (dark_scans, sector) in self.dark_scans.iter_mut().zip(&sectors) {
            match sector.is_dark() {
                Some(true) => *dark_scans += 1,
                Some(false) => *dark_scans = 0,
                // Beyond the field of view.
                None if sector.beams == 0 => *dark_scans = 0,
                // The lidar was not shown to see again.
                None => {}
            }
        }
    }

    /// The fault of a lidar that sees nothing at all, or nothing ahead.
    pub fn fault(&self) -> Option<ObservationFault> {
        if self.blind_scans >= BLIND_SCANS {
            return Some(ObservationFault::LidarBlind);
        }
        let is_ahead =
            |sector: usize| wrap_angle(sector as f64 * TAU / SECTORS as f64).abs() <= FRONT;
        let is_blind_ahead =
            (0..SECTORS).any(|sector| is_ahead(sector) && self.is_blind_sector(sector));
        is_blind_ahead.then_some(ObservationFault::LidarPartlyBlind)
    }

    /// Number of blind sectors.
    pub fn blind_sectors(&self) -> usize {
        (0..SECTORS).filter(|&sector| self.is_blind_sector(sector)).count()
    }

    fn is_blind_sector(&self, sector: usize) -> bool {
        self.dark_scans[sector] >= DARK_SCANS
    }

    /// Whether the lidar sees nothing in a direction from its place, radians in the robot's frame.
    pub fn is_blind_towards(&self, direction: f64) -> bool {
        self.is_blind_sector(sector_of(direction))
    }

    /// Whether the last scan contradicts the map as a whole: nothing may be learned from it.
    pub const fn is_suspect(&self) -> bool {
        self.blind_scans > 0
    }

    /// The scan without the beams of dark sectors: they saw nothing, also not that something is gone. And without single ones that
    /// end within the robot's body, as on dust. `None` where there are no such beams.
    pub fn masked(&self, scan: &Scan, body: &Footprint) -> Option<Scan> {
        let ends_alone_within = ends_alone_within(body, scan);
        let mut beams = (0..scan.ranges.len()).filter(|&beam| {
            let sees_nothing = || !scan.is_return(scan.ranges[beam]);
            ends_alone_within(beam)
                || self.dark_scans[sector_of(scan.angle(beam))] > 0 && sees_nothing()
        });
        let first = beams.next()?;
        let mut masked = scan.clone();
        for beam in core::iter::once(first).chain(beams) {
            masked.ranges[beam] = f64::NAN;
        }
        Some(masked)
    }

    /// Blocks the cells in blind sectors beyond a distance of the robot, metres.
    pub fn block_unseen(&self, grid: &mut ObstacleGrid, pose: &Pose, from_m: f64) {
        let frame = *grid.frame();
        let (robot, lidar) = (pose.position(), pose.transform(&self.lidar));
        for index in 0..frame.len() {
            let cell = frame.cell_at(index);
            let center = frame.center_of(cell);
            let is_far = (center - robot).norm() >= from_m;
            if is_far && self.is_blind_towards(bearing(&lidar, &center) - pose.yaw) {
                grid.set(cell, true);
            }
        }
    }
}

fn sector_of(direction: f64) -> usize {
    let turns = direction / TAU + 0.5 / SECTORS as f64;
    (((turns - turns.floor()) * SECTORS as f64) as usize).min(SECTORS - 1)
}

/// A beam that is compared with the map.
#[derive(Clone, Copy, Debug)]
struct Ray {
    sector: usize,
    returns: bool,
    is_expected: bool,
    /// Whether it shows a surface where the map does, so far away that the surfaces next to it may be out of range.
    is_far: bool,
}

/// Compares evenly chosen beams of a scan with the map.
fn coverage(pose: &Pose, scan: &Scan, rays: &RayCaster) -> [Coverage; SECTORS] {
    let beams = scan.ranges.len();
    let turn = beams as f64 * scan.angle_increment / TAU;
    let count = ((turn * (SECTORS * RAYS) as f64) as usize).clamp(1, SECTORS * RAYS).min(beams);
    let sure_m = SURE_RANGE_SHARE * scan.range_max;
    let beam_of = |ray: usize| ray * beams / count;
    let start = pose.transform(&scan.origin);
    let cast: Vec<_> = (0..count).map(|ray| (start, pose.yaw + scan.angle(beam_of(ray)))).collect();
    let compare = |(ray, on_map): (usize, RayEnd)| {
        let beam = beam_of(ray);
        let (direction, range_m) = (scan.angle(beam), scan.ranges[beam]);
        let returns = scan.is_return(range_m);
        let is_expected = matches!(on_map, RayEnd::Blocked(on_map_m) if on_map_m >= MIN_RANGE_M);
        let is_on_map = is_expected || range_m > sure_m;
        let is_far = returns && is_on_map && range_m >= OPEN_SHARE * sure_m;
        Ray { sector: sector_of(direction), returns, is_expected, is_far }
    };
    let ends = rays.cast_all(&cast, sure_m);
    let rays: Vec<Ray> = ends.into_iter().enumerate().map(compare).collect();
    let mut sectors = [Coverage::default(); SECTORS];
    for ray in &rays {
        let sector = &mut sectors[ray.sector];
        sector.beams += 1;
        sector.returns += u32::from(ray.returns);
        sector.expected += u32::from(ray.is_expected);
        sector.missing += u32::from(ray.is_expected && !ray.returns);
    }
    if is_full_turn(scan) {
        judge_gaps(&rays, &mut sectors);
    }
    sectors
}

/// Counts the rays in dark and open gaps of a full turn. Gaps of half a turn and more are left to the sectors.
fn judge_gaps(rays: &[Ray], sectors: &mut [Coverage; SECTORS]) {
    let count = rays.len();
    let at = |place: usize| &rays[place % count];
    // The gap after each ray with a return.
    for before in (0..count).filter(|&before| at(before).returns) {
        let length = (1..count).take_while(|&step| !at(before + step).returns).count();
        let gap = before + 1..before + 1 + length;
        let expected = gap.clone().filter(|&place| at(place).is_expected).count();
        if 2 * length >= count || expected == length {
            continue;
        }
        let is_dark = expected >= MIN_EXPECTED_IN_GAP;
        let is_open = expected <= 1 && at(before).is_far && at(gap.end).is_far;
        for place in gap {
            let sector = &mut sectors[at(place).sector];
            sector.in_dark_gaps += u32::from(is_dark);
            sector.in_open_gaps += u32::from(is_open);
        }
    }
}

#[cfg(test)]
mod tests {
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
        let covered = |from: f64, to: f64| {
            scan(move |direction| !(from..to).contains(&direction), f64::INFINITY)
        };
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
        assert!(
            blocked(0.0, 1.5) && !blocked(0.0, 0.8) && !blocked(0.0, -1.5) && !blocked(1.5, 0.0)
        );
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

    #[test]
    fn returns_of_a_blind_sector_are_not_masked() {
        let left = scan(|direction| !(1.2..2.0).contains(&direction), f64::INFINITY);
        let health = after(3, &left, &room(8.0));
        let mut seen = left;
        seen.ranges[270] = 2.0;
        let masked = health.masked(&seen, &body()).expect("a blind sector");
        assert!(masked.ranges[270] == 2.0 && masked.ranges[272].is_nan());
    }
}
