//! What the latest scan shows of the space around the robot. Unknown space is not free.

use core::f64::consts::TAU;

use super::scan_health::ScanHealth;
use super::scan_visibility::is_full_turn;
use crate::geometry::{Point, Pose, Vector, bearing};
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

    /// Distance of a place and its direction in the robot's frame.
    fn polar(&self, place: &Point) -> (f64, f64) {
        let robot = self.pose.position();
        ((place - robot).norm(), bearing(&robot, place) - self.pose.yaw)
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
    pub fn sees_way(&self, footprint: &Footprint, from: &Pose, to: &Pose) -> bool {
        let is_inside = |place: &Point| {
            footprint.at(from).any(|(center, radius)| (place - center).norm() <= radius + OUTSIDE_M)
        };
        footprint.at(to).all(|(center, radius)| {
            (0..OUTLINE_POINTS).all(|point| {
                let (sin, cos) = libm::sincos(TAU * f64::from(point) / f64::from(OUTLINE_POINTS));
                let place = center + Vector::new(cos, sin) * radius;
                is_inside(&place) || self.sees(&place)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A front lidar of 270 degrees with a post ahead on the left.
    fn scan() -> Scan {
        let mut scan = Scan {
            angle_min: -0.75 * core::f64::consts::PI,
            angle_increment: 1.5 * core::f64::consts::PI / 540.0,
            range_max: 10.0,
            ranges: vec![f64::INFINITY; 541],
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
        let sees = |x: f64| space.sees_way(&footprint, &Pose::default(), &Pose::new(x, 0.0, 0.0));
        assert!(sees(1.0) && sees(0.01) && sees(-0.02) && !sees(-0.3));
    }
}
