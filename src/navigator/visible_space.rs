//! What the latest scan shows of the space around the robot. Unknown space is not free.

use core::f64::consts::TAU;

use super::scan_health::ScanHealth;
use super::scan_visibility::is_full_turn;
use crate::geometry::{Point, Pose, bearing};
use crate::map::Scan;
use crate::robot::Footprint;

/// A place is seen where the adjacent beams reach its distance less this tolerance, metres: noise and pose error.
const NEARER_M: f64 = 0.1;
/// Half the width of a seen place, metres, and the least half angle of its adjacent beams, in angles between two beams.
const HALF_WIDTH_M: f64 = 0.05;
const MIN_HALF_BEAMS: f64 = 1.5;
/// Points checked on the outline of each disc of the footprint.
const OUTLINE_POINTS: u32 = 8;
/// A point this far outside the robot's present outline is newly entered, metres: the lidar does not see below its own body.
const OUTSIDE_M: f64 = 0.03;

/// The latest scan, from the pose where it was made.
#[derive(Clone, Copy)]
pub(super) struct VisibleSpace<'a> {
    pub pose: Pose,
    pub scan: &'a Scan,
    pub health: &'a ScanHealth,
}

impl VisibleSpace<'_> {
    /// Whether the lidar sees a place: it has beams there, the sector is not blind, and nothing nearer hides it. A beam without
    /// a measurement counts as one that went through: many lidars do not tell the two apart, and the health of the sector is
    /// judged by the map.
    pub fn sees(&self, place: &Point) -> bool {
        let (distance, direction) = self.polar(place);
        if self.scan.ranges.is_empty() || self.health.is_blind_towards(direction) {
            return false;
        }
        let (mut seen, mut all) = (0, 0);
        for range in self.ranges_beside(distance, direction, HALF_WIDTH_M) {
            all += 1;
            let goes_through = |range: f64| range.is_nan() || range >= distance - NEARER_M;
            seen += i32::from(range.is_some_and(goes_through));
        }
        2 * seen >= all
    }

    /// Whether something nearer hides a disc around a place wholly.
    pub fn hides(&self, place: &Point, radius_m: f64) -> bool {
        let (distance, direction) = self.polar(place);
        let mut ranges = self.ranges_beside(distance, direction, radius_m);
        ranges.all(|range| range.is_some_and(|range| range < distance || range.is_nan()))
    }

    /// Distance of a place from the lidar, and its direction from there in the robot's frame.
    fn polar(&self, place: &Point) -> (f64, f64) {
        let lidar = self.pose.transform(&self.scan.origin);
        ((place - lidar).norm(), bearing(&lidar, place) - self.pose.yaw)
    }

    /// The ranges of the beams within half a width of a place, metres, and of two beams at least; `None` outside the field of
    /// view.
    fn ranges_beside(
        &self,
        distance: f64,
        direction: f64,
        half_width_m: f64,
    ) -> impl Iterator<Item = Option<f64>> {
        let scan = self.scan;
        let beams = scan.ranges.len() as i64;
        let turned = (direction - scan.angle_min) / TAU;
        let at = (turned - turned.floor()) * TAU / scan.angle_increment;
        let half = (half_width_m / distance.max(half_width_m) / scan.angle_increment)
            .max(MIN_HALF_BEAMS)
            .min(beams as f64);
        let (from, to) = ((at - half).ceil() as i64, (at + half).floor() as i64);
        let is_full_turn = is_full_turn(scan);
        (from..=to).map(move |beam| {
            let in_view = is_full_turn || (0..beams).contains(&beam);
            in_view.then(|| scan.ranges[beam.rem_euclid(beams) as usize])
        })
    }

    /// Whether the lidar sees what a body newly enters that moves from one pose to another.
    pub fn is_path_visible(&self, footprint: &Footprint, from: &Pose, to: &Pose) -> bool {
        let is_inside = |place: &Point| {
            footprint.at(from).any(|(center, radius)| (place - center).norm() <= radius + OUTSIDE_M)
        };
        footprint.at(to).all(|(center, radius)| {
            center
                .circle(radius, OUTLINE_POINTS)
                .all(|place| is_inside(&place) || self.sees(&place))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{GridFrame, ObstacleGrid, RayCaster};

    /// A front lidar of 270 degrees with a post ahead on the left.
    fn scan() -> Scan {
        let mut scan = Scan {
            angle_min: -0.75 * core::f64::consts::PI,
            angle_increment: 1.5 * core::f64::consts::PI / 540.0,
            range_max: 10.0,
            ranges: vec![f64::INFINITY; 541],
            ..Scan::default()
        };
        for beam in 0..541 {
            if (scan.angle(beam) - 0.5).abs() < 0.1 {
                scan.ranges[beam] = 2.0;
            }
        }
        scan.ranges[270] = f64::NAN;
        scan
    }

    #[test]
    fn hidden_places_and_places_outside_the_field_of_view_are_not_seen() {
        let (scan, health) = (scan(), ScanHealth::default());
        let pose = Pose::new(1.0, 2.0, 0.3);
        let space = VisibleSpace { pose, scan: &scan, health: &health };
        let at = |range: f64, direction: f64| {
            let (sin, cos) = libm::sincos(direction);
            space.sees(&pose.transform(&Point::new(range * cos, range * sin)))
        };
        assert!(at(3.0, 0.0) && at(1.9, 0.5) && at(3.0, -2.3));
        assert!(!at(2.5, 0.5) && !at(1.0, 3.1) && !at(0.5, -2.6));
    }

    #[test]
    fn front_lidar_sees_the_space_ahead_and_not_behind() {
        let (scan, health) = (scan(), ScanHealth::default());
        let space = VisibleSpace { pose: Pose::default(), scan: &scan, health: &health };
        let footprint = Footprint::round(0.4).expect("a valid radius");
        let sees =
            |x: f64| space.is_path_visible(&footprint, &Pose::default(), &Pose::new(x, 0.0, 0.0));
        assert!(sees(1.0) && sees(0.01) && sees(-0.02) && !sees(-0.3));
    }

    #[test]
    fn blind_sectors_and_empty_scans_show_nothing() {
        let frame = GridFrame::new(80, 80, 0.1, Pose::new(-4.0, -4.0, 0.0)).expect("a size");
        let known = ObstacleGrid::from_fn(frame, |cell| {
            [cell.column, cell.row].iter().any(|&at| at == 0 || at == 79)
        });
        let known = RayCaster::new(&known);
        let mut scan = Scan { ranges: vec![4.0; 541], ..scan() };
        for beam in 0..541 {
            if (scan.angle(beam) - 1.57).abs() < 0.5 {
                scan.ranges[beam] = f64::INFINITY;
            }
        }
        let mut health = ScanHealth::default();
        let sees = |health: &ScanHealth, scan: &Scan, x: f64, y: f64| {
            VisibleSpace { pose: Pose::default(), scan, health }.sees(&Point::new(x, y))
        };
        assert!(sees(&health, &scan, 0.0, 2.0), "far away in the open");
        (0..3).for_each(|_| health.update(&Pose::default(), &scan, &known));
        assert!(!sees(&health, &scan, 0.0, 2.0) && sees(&health, &scan, 2.0, 0.0));
        let empty = Scan { ranges: Vec::new(), ..scan };
        for step in 0..40 {
            let (sin, cos) = libm::sincos(0.157 * f64::from(step));
            assert!(!sees(&ScanHealth::default(), &empty, cos, sin), "{step}");
        }
    }

    /// The post covers 0.2 rad at 2 m.
    #[test]
    fn disc_is_hidden_only_behind_a_nearer_surface_that_covers_it() {
        let (mut scan, health) = (scan(), ScanHealth::default());
        let pose = Pose::new(1.0, 2.0, 0.3);
        let hides = |scan: &Scan, range: f64, direction: f64, radius_m: f64| {
            let (sin, cos) = libm::sincos(direction);
            let place = pose.transform(&Point::new(range * cos, range * sin));
            VisibleSpace { pose, scan, health: &health }.hides(&place, radius_m)
        };
        assert!(hides(&scan, 2.5, 0.5, 0.2) && !hides(&scan, 1.9, 0.5, 0.2));
        assert!(!hides(&scan, 2.5, 0.5, 0.4) && !hides(&scan, 2.5, 0.0, 0.2));
        // A beam without a measurement does not show what is behind the post.
        let (first, step) = (scan.angle_min, scan.angle_increment);
        scan.ranges[((0.5 - first) / step) as usize] = f64::NAN;
        assert!(hides(&scan, 2.5, 0.5, 0.2));
    }

    #[test]
    fn place_is_seen_up_to_a_tenth_of_a_metre_beyond_its_range() {
        let (scan, health) = (Scan { ranges: vec![3.0; 541], ..scan() }, ScanHealth::default());
        let space = VisibleSpace { pose: Pose::default(), scan: &scan, health: &health };
        assert!(space.sees(&Point::new(3.08, 0.0)) && !space.sees(&Point::new(3.12, 0.0)));
    }

    #[test]
    fn place_is_seen_by_half_of_its_beams_also_where_a_full_turn_closes() {
        let (scan, health) = (scan(), ScanHealth::default());
        let sees = |scan: &Scan, range: f64, direction: f64| {
            let (sin, cos) = libm::sincos(direction);
            let space = VisibleSpace { pose: Pose::default(), scan, health: &health };
            space.sees(&Point::new(range * cos, range * sin))
        };
        assert!(!sees(&scan, 2.5, 0.412) && sees(&scan, 2.5, 0.38));
        assert!(!sees(&scan, 2.5, 0.4035), "by two beams of five");
        let turn =
            Scan { angle_min: 0.0, angle_increment: TAU / 360.0, ranges: vec![9.0; 360], ..scan };
        assert!(sees(&turn, 2.0, 0.0) && sees(&turn, 2.0, -0.01) && sees(&turn, 2.0, 0.01));
        // A disc there is hidden by the beams on both sides.
        let space = VisibleSpace { pose: Pose::default(), scan: &turn, health: &health };
        assert!(
            space.hides(&Point::new(9.5, 0.0), 0.3) && !space.hides(&Point::new(8.5, 0.0), 0.3)
        );
    }

    #[test]
    fn beams_without_a_measurement_count_as_seen_through() {
        let (scan, health) =
            (Scan { ranges: vec![f64::NAN; 541], ..scan() }, ScanHealth::default());
        let space = VisibleSpace { pose: Pose::default(), scan: &scan, health: &health };
        assert!(space.sees(&Point::new(3.0, 0.0)));
    }

    /// Beams of 10 degrees, and a far place in the middle between two of them.
    #[test]
    fn place_between_two_beams_is_judged_by_both() {
        let turn = Scan {
            angle_min: 0.0,
            angle_increment: TAU / 36.0,
            range_max: 10.0,
            ranges: vec![3.0; 36],
            ..Scan::default()
        };
        let health = ScanHealth::default();
        let space = VisibleSpace { pose: Pose::default(), scan: &turn, health: &health };
        let (sin, cos) = libm::sincos(TAU / 72.0);
        let at = |range: f64| space.sees(&Point::new(range * cos, range * sin));
        assert!(at(2.0) && !at(4.0));
    }

    #[test]
    fn far_place_is_judged_by_the_beams_next_to_its_own_too() {
        let mut turn = Scan {
            angle_min: 0.0,
            angle_increment: TAU / 36.0,
            range_max: 10.0,
            ranges: vec![3.0; 36],
            ..Scan::default()
        };
        turn.ranges[5] = 9.0;
        let health = ScanHealth::default();
        let space = VisibleSpace { pose: Pose::default(), scan: &turn, health: &health };
        let (sin, cos) = libm::sincos(turn.angle(5));
        assert!(!space.sees(&Point::new(4.0 * cos, 4.0 * sin)));
    }
}
