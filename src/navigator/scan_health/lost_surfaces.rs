//! Surfaces nearby that the lidar has lost sight of.
//!
//! What goes away is seen to go: it is next to its old place in the next scan, or the beams show what is behind it. Where the beams
//! towards a surface have no return from one scan to the next, and nothing returns beside it, a cover may hide it, or it is glass at
//! another angle. In a hall the map shows nothing that would tell. Such beams do not show that the surface is gone.

use crate::geometry::{Point, Pose, bearing};
use crate::map::Scan;
use crate::navigator::scan_visibility::{is_in_view, places_towards, ranges_towards};

/// Neighbouring beams show one surface if their ranges differ by at most this, metres. A beam without such neighbours may have ended on a
/// grain of dust.
const SURFACE_M: f64 = 0.2;
/// A leg is at most this far from its place in the scan before, metres: 3 m/s at 7 scans per second.
const MOVES_M: f64 = 0.4;
/// The beams that pass a lost end within this, metres, do not show that it is gone.
const BESIDE_M: f64 = 0.1;

/// The ends of beams on surfaces that the last scan showed or that were lost before.
#[derive(Clone, Debug, Default)]
pub(super) struct LostSurfaces {
    /// Those of the last scan, in the map frame.
    seen: Vec<Point>,
    /// Those that were lost, in the map frame, the newest last.
    lost: Vec<Point>,
    /// For each beam of the last scan, whether it goes to a lost end; empty without any.
    hides: Vec<bool>,
}

impl LostSurfaces {
    /// Compares a new scan from a pose in the map with what was seen before, of a lidar that certainly shows surfaces within a range,
    /// metres.
    pub fn update(&mut self, pose: &Pose, scan: &Scan, sure_m: f64) {
        let lidar = pose.transform(&scan.origin);
        let sees_all = scan.ranges.iter().all(|range| scan.is_return(*range));
        self.lost.append(&mut self.seen);
        self.lost.retain(|end| !sees_all && is_lost(end, &lidar, (pose, scan)));
        // The newest are enough for all beams.
        let count = scan.ranges.len();
        self.lost.drain(..self.lost.len().saturating_sub(count));
        self.hides.clear();
        self.hides.resize(if self.lost.is_empty() { 0 } else { count }, false);
        for end in &self.lost {
            let away_m = (*end - lidar).norm();
            let beams = places_towards(pose, scan, bearing(&lidar, end), BESIDE_M / away_m);
            beams.into_iter().flatten().flatten().for_each(|beam| self.hides[beam] = true);
        }
        let shows_surface = |&beam: &usize| {
            let range_m = scan.ranges[beam];
            let is_near = scan.is_return(range_m) && range_m <= sure_m;
            is_near
                && [beam + 1, beam + count - 1]
                    .iter()
                    .all(|neighbour| (scan.ranges[neighbour % count] - range_m).abs() <= SURFACE_M)
        };
        let end = |beam| scan.end_from(&lidar, pose.yaw, beam);
        self.seen.extend((0..count).filter(shows_surface).map(end));
    }

    /// Whether a beam of the last scan that has no return does not show that its direction is free.
    pub fn hides(&self, beam: usize) -> bool {
        self.hides.get(beam).is_some_and(|hides| *hides)
    }
}

/// Whether a scan shows neither a surface at a place nearby, nor anything in its direction. A place out of view is not lost: no beam is
/// sent there.
fn is_lost(end: &Point, lidar: &Point, (pose, scan): (&Pose, &Scan)) -> bool {
    let (away_m, direction) = ((*end - *lidar).norm(), bearing(lidar, end));
    let towards = |half_angle: f64| ranges_towards(pose, scan, direction, half_angle);
    let sees_nothing =
        towards(0.0).is_some_and(|mut ranges| ranges.all(|range_m| !scan.is_return(range_m)));
    let is_near = |range_m: f64| (range_m - away_m).abs() <= MOVES_M;
    sees_nothing
        && is_in_view(pose, scan, direction, 0.0)
        && towards(MOVES_M / away_m).is_some_and(|mut ranges| !ranges.any(is_near))
}

#[cfg(test)]
mod tests {
    use core::f64::consts::{PI, TAU};

    use super::*;

    /// No beam is hidden.
    const NONE: [usize; 0] = [];

    /// A scan of a full turn, or a part of it around the robot's x axis, with a range in each direction, metres; infinite where nothing
    /// is.
    fn scan(field: f64, range_m: impl Fn(f64) -> f64) -> Scan {
        let angle_increment = TAU / 360.0;
        let beams = (field / angle_increment).round() as usize;
        let angle_min = -0.5 * field;
        let angle = |beam: usize| angle_min + beam as f64 * angle_increment;
        let ranges = (0..beams).map(|beam| range_m(angle(beam))).collect();
        Scan { angle_min, angle_increment, range_max: 12.0, ranges, ..Scan::default() }
    }

    /// A box 3 m away in this direction, 0.6 m wide, in a hall.
    fn box_at(middle: f64) -> impl Fn(f64) -> f64 {
        move |angle| if (angle - middle).abs() < 0.1 { 3.0 } else { f64::INFINITY }
    }

    /// The beams that are hidden after these scans, from poses in the map.
    fn hidden(scans: &[(Pose, Scan)]) -> Vec<usize> {
        let mut surfaces = LostSurfaces::default();
        for (pose, scan) in scans {
            surfaces.update(pose, scan, 6.0);
        }
        (0..scans[0].1.ranges.len()).filter(|&beam| surfaces.hides(beam)).collect()
    }

    /// The hidden beams after two scans from one place.
    fn after(before: Scan, now: Scan) -> Vec<usize> {
        hidden(&[(Pose::default(), before), (Pose::default(), now)])
    }

    fn nothing(_: f64) -> f64 {
        f64::INFINITY
    }

    #[test]
    fn surface_that_is_gone_without_a_trace_hides_its_beams_until_something_is_seen_there() {
        let (shown, covered) = (scan(TAU, box_at(0.0)), scan(TAU, nothing));
        let beams = after(shown.clone(), covered.clone());
        // Beams with such neighbours end within 0.07 rad, and 0.1 m beside them is 0.033 rad.
        assert_eq!(beams, (175..=185).collect::<Vec<usize>>());
        let at = |pose: Pose, scan: &Scan| (pose, scan.clone());
        let origin = Pose::default();
        let later = [at(origin, &shown), at(origin, &covered), at(origin, &covered)];
        assert_eq!(hidden(&later), beams, "it stays lost");
        // From the side its direction is another one.
        let aside = Pose::new(3.0, -3.0, PI / 2.0);
        assert_eq!(hidden(&[at(origin, &shown), at(aside, &covered)])[0] / 10, 17);
        let beyond = scan(TAU, |angle| if angle.abs() < 0.1 { 8.0 } else { f64::INFINITY });
        assert_eq!(hidden(&[at(origin, &shown), at(origin, &covered), at(origin, &beyond)]), NONE);
    }

    #[test]
    fn what_moved_or_shows_what_is_behind_it_is_not_lost() {
        let shown = || scan(TAU, box_at(0.0));
        assert_eq!(after(shown(), scan(TAU, box_at(0.1))), NONE, "it moved by 0.3 m");
        assert_eq!(after(shown(), scan(TAU, |_| 9.0)), NONE, "there is a wall behind it");
        let through = |angle: f64| if angle.abs() < 0.3 { 2.0 } else { f64::INFINITY };
        assert_eq!(after(shown(), scan(TAU, through)), NONE, "something is before it");
        assert!(!after(shown(), scan(TAU, box_at(0.5))).is_empty(), "that is another one");
    }

    #[test]
    fn far_surfaces_and_single_beams_may_be_gone() {
        let far = |angle: f64| if angle.abs() < 0.1 { 7.0 } else { f64::INFINITY };
        assert_eq!(after(scan(TAU, far), scan(TAU, nothing)), NONE);
        let dust = |angle: f64| 1.0 + 0.5 * ((angle * 360.0 / TAU).round().rem_euclid(3.0));
        assert_eq!(after(scan(TAU, dust), scan(TAU, nothing)), NONE);
    }

    #[test]
    fn surface_out_of_view_is_not_lost() {
        let ahead = || (Pose::default(), scan(PI, box_at(0.0)));
        let turned = (Pose::new(0.0, 0.0, PI), scan(PI, nothing));
        let back = (Pose::default(), scan(PI, nothing));
        assert_eq!(hidden(&[ahead(), turned, back.clone()]), NONE);
        assert!(!hidden(&[ahead(), back]).is_empty());
    }
}
