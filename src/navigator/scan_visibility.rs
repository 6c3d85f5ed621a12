//! Whether a lidar scan, or an earlier one, saw through a place.

use core::f64::consts::TAU;
use core::ops::RangeInclusive;
use std::collections::VecDeque;

use crate::geometry::{Point, Pose, bearing, wrap_angle};
use crate::map::Scan;

/// Largest error of a pose, radians and metres: three standard deviations of each of two poses.
const YAW_ERROR: f64 = 0.012;
const PLACE_ERROR_M: f64 = 0.03;
/// Error of a distance as a share of it: beams meet far surfaces at a flatter angle.
const MARGIN_SHARE: f64 = 0.01;

/// The first and the last beam within an angle of a direction in the map frame, and of the two next to it at least. They may lie
/// beyond the field of view. `None` without beams.
fn beams_towards(
    pose: &Pose,
    scan: &Scan,
    direction: f64,
    half_angle: f64,
) -> Option<RangeInclusive<i64>> {
    let (beams, increment) = (scan.ranges.len(), scan.angle_increment);
    let turned = (direction - pose.yaw - scan.angle_min) / TAU;
    let mut turned = (turned - turned.floor()) * TAU;
    let field = beams.checked_sub(1)? as f64 * increment;
    if !is_full_turn(scan) && turned > 0.5 * (field + TAU) {
        turned -= TAU;
    }
    let half_angle = half_angle.max(increment);
    let from = ((turned - half_angle) / increment).ceil() as i64;
    let to = ((turned + half_angle) / increment).floor() as i64;
    Some(from..=to)
}

/// The beams of [`beams_towards`] by their place in the scan; `None` for one beyond the field of view. `None` without beams.
pub(super) fn places_towards(
    pose: &Pose,
    scan: &Scan,
    direction: f64,
    half_angle: f64,
) -> Option<impl Iterator<Item = Option<usize>> + use<>> {
    let (count, is_full_turn) = (scan.ranges.len() as i64, is_full_turn(scan));
    let place = move |beam: i64| {
        // In a full turn the first beam follows the last.
        let beam = match beam {
            ..0 if is_full_turn => beam + count,
            beam if is_full_turn && beam >= count => beam - count,
            beam => beam,
        };
        usize::try_from(beam).ok().filter(|_| beam < count)
    };
    Some(beams_towards(pose, scan, direction, half_angle)?.map(place))
}

/// The ranges of the beams of [`beams_towards`], metres; NaN beyond the field of view. `None` without beams.
pub(super) fn ranges_towards<'a>(
    pose: &Pose,
    scan: &'a Scan,
    direction: f64,
    half_angle: f64,
) -> Option<impl Iterator<Item = f64> + 'a> {
    let range = |place: Option<usize>| place.map_or(f64::NAN, |place| scan.ranges[place]);
    Some(places_towards(pose, scan, direction, half_angle)?.map(range))
}

/// Whether a scan has beams in all directions within an angle of a direction in the map frame.
pub(super) fn is_in_view(pose: &Pose, scan: &Scan, direction: f64, half_angle: f64) -> bool {
    let is_within =
        |beams: RangeInclusive<i64>| *beams.start() >= 0 && *beams.end() < scan.ranges.len() as i64;
    beams_towards(pose, scan, direction, half_angle)
        .is_some_and(|beams| is_full_turn(scan) || is_within(beams))
}

/// The shortest of the ranges within an angle of a direction in the map frame, metres. A beam without a return saw to the sensor's
/// range. `None` where a beam has no measurement or there is no beam.
pub(super) fn seen_to_m(pose: &Pose, scan: &Scan, direction: f64, half_angle: f64) -> Option<f64> {
    let nearer = |least: f64, range: f64| (!range.is_nan()).then_some(least.min(range));
    ranges_towards(pose, scan, direction, half_angle)?.try_fold(scan.range_max, nearer)
}

/// The numbers of beams within an angle of a direction in the map frame: of those with a measurement, and of all. `None` where one
/// ends within a distance, metres, or the scan does not reach it.
fn beams_beyond(
    pose: &Pose,
    scan: &Scan,
    direction: f64,
    half_angle: f64,
    distance_m: f64,
) -> Option<(u32, u32)> {
    if scan.range_max <= distance_m {
        return None;
    }
    ranges_towards(pose, scan, direction, half_angle)?.try_fold((0, 0), |(measured, all), range| {
        let ends_before = range <= distance_m;
        (!ends_before).then_some((measured + u32::from(!range.is_nan()), all + 1))
    })
}

/// Whether [`seen_to_m`] is beyond a distance, metres; false where it is unknown.
pub(super) fn sees_beyond(
    pose: &Pose,
    scan: &Scan,
    direction: f64,
    half_angle: f64,
    distance_m: f64,
) -> bool {
    beams_beyond(pose, scan, direction, half_angle, distance_m)
        .is_some_and(|(measured, all)| measured == all)
}

/// As [`sees_beyond`], by the measured beams alone, which are at least half of them. Surfaces that absorb or deflect a beam leave
/// gaps in the scans of real lidars, everywhere: what left a place in front of them would otherwise never be gone.
pub(crate) fn measures_beyond(
    pose: &Pose,
    scan: &Scan,
    direction: f64,
    half_angle: f64,
    distance_m: f64,
) -> bool {
    beams_beyond(pose, scan, direction, half_angle, distance_m)
        .is_some_and(|(measured, all)| 2 * measured >= all)
}

/// Whether the first beam follows the last.
pub(super) fn is_full_turn(scan: &Scan) -> bool {
    scan.ranges.len() as f64 * scan.angle_increment > TAU - 0.5 * scan.angle_increment
}

/// Whether the beams of a scan around a point all went beyond it, for every pose within the error: then the point was free. The
/// point is from another scan, with this motion between the two.
///
/// The ranges of two neighbouring beams to a wall at a flat angle differ much. The beams on both sides count, so that a small
/// rotation of the robot does not let the scan see through the wall.
pub(super) fn proves_free(pose: &Pose, scan: &Scan, point: &Point, apart: &Motion) -> bool {
    let (direction, half_angle, distance_m) = beams_past(pose, scan, point, apart);
    sees_beyond(pose, scan, direction, half_angle, distance_m)
}

/// As [`proves_free`] for a point of the same scan, by the measured beams alone: see [`measures_beyond`].
pub(super) fn shows_free(pose: &Pose, scan: &Scan, point: &Point) -> bool {
    let (direction, half_angle, distance_m) = beams_past(pose, scan, point, &Motion::default());
    measures_beyond(pose, scan, direction, half_angle, distance_m)
}

/// The beams that pass a point for every pose within the error: their direction in the map frame, the angle to each side of it, and
/// their least range, metres.
fn beams_past(pose: &Pose, scan: &Scan, point: &Point, apart: &Motion) -> (f64, f64, f64) {
    let lidar = pose.transform(&scan.origin);
    let distance = (point - lidar).norm();
    let place_error_m = PLACE_ERROR_M + SLIP * apart.driven_m;
    let half_angle =
        YAW_ERROR + TURN_ERROR * apart.turned + place_error_m / distance.max(place_error_m);
    let drift_m = (DRIFT * apart.time_s).max(SLIP * apart.driven_m);
    let margin_m = FREE_MARGIN_M + drift_m + MARGIN_SHARE * distance;
    (bearing(&lidar, point), half_angle, distance + margin_m)
}

/// Interval of the kept scans, seconds, and their number.
pub(super) const INTERVAL_S: f64 = 0.099;
pub(super) const KEPT: usize = 20;
/// Ages of the scans that are checked, seconds: the latest shows fast motion, and only the oldest slow motion.
pub(super) const AGES_S: [f64; 4] = [0.25, 0.5, 1.0, 1.7];
/// Distance that a beam must go beyond a place to show that it was free, metres, and its growth with the time between the two
/// scans, m/s: odometry drifts.
const FREE_MARGIN_M: f64 = 0.06;
const DRIFT: f64 = 0.05;
/// Error of the distance driven between two scans, and of the angle turned, as shares of them: tracks slip.
const SLIP: f64 = 0.05;
const TURN_ERROR: f64 = 0.03;

/// What hid a place was nearer by at least this, metres: an object does not hide its own side.
const HIDING_M: f64 = 0.3;

/// A motion of the robot.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Motion {
    /// Its duration, seconds.
    pub time_s: f64,
    /// Distance driven, metres.
    pub driven_m: f64,
    /// Sum of the angles turned to both sides, radians.
    pub turned: f64,
}

/// A scan with its time, seconds, the pose from which it was made, and the motion until the newest scan.
#[derive(Debug, Default)]
struct TimedPoseScan {
    time_s: f64,
    until_now: Motion,
    pose: Pose,
    scan: Scan,
}

/// What earlier scans show of a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Earlier {
    /// One of them saw through it.
    Free,
    /// Something nearer hid it a moment ago.
    Hidden,
    /// Neither.
    Unknown,
}

/// Scans of the last two seconds, the newest last.
#[derive(Debug, Default)]
pub(super) struct History {
    scans: VecDeque<TimedPoseScan>,
    /// Indices of the scans that are checked now.
    selected: Vec<usize>,
    last_pose: Option<Pose>,
}

impl History {
    /// Forgets all scans.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Moves on to a scan made at a time, seconds, from a pose, and selects the scans to check.
    pub fn select(&mut self, time_s: f64, pose: &Pose) {
        let last = self.last_pose.replace(*pose).unwrap_or(*pose);
        let driven_m = (pose.position() - last.position()).norm();
        let turned = wrap_angle(pose.yaw - last.yaw).abs();
        for earlier in &mut self.scans {
            earlier.until_now.time_s = time_s - earlier.time_s;
            earlier.until_now.driven_m += driven_m;
            earlier.until_now.turned += turned;
        }
        self.selected.clear();
        for age_s in AGES_S {
            let old_enough = |earlier: &TimedPoseScan| earlier.until_now.time_s >= age_s;
            if let Some(place) = self.scans.iter().rposition(old_enough)
                && !self.selected.contains(&place)
            {
                self.selected.push(place);
            }
        }
    }

    /// The motion since a time, seconds: that since the scan before it.
    pub fn motion_since(&self, since_s: f64) -> Motion {
        let before = |earlier: &&TimedPoseScan| earlier.time_s <= since_s;
        let found = self.scans.iter().rev().find(before).or(self.scans.front());
        found.map_or_else(Motion::default, |earlier| earlier.until_now)
    }

    /// Whether a selected scan saw through a point.
    fn was_free(&self, point: &Point) -> bool {
        self.selected.iter().any(|&place| {
            let TimedPoseScan { pose, scan, until_now, .. } = &self.scans[place];
            proves_free(pose, scan, point, until_now)
        })
    }

    /// Whether something much nearer hid a point in the latest selected scan.
    fn was_hidden(&self, point: &Point) -> bool {
        self.selected.first().is_some_and(|&place| {
            let TimedPoseScan { pose, scan, .. } = &self.scans[place];
            let lidar = pose.transform(&scan.origin);
            let farthest_m = (point - lidar).norm() - HIDING_M;
            seen_to_m(pose, scan, bearing(&lidar, point), 0.0)
                .is_some_and(|seen_m| seen_m < farthest_m)
        })
    }

    /// What the selected scans show of a point; `Hidden` only if hidden places matter.
    pub fn of(&self, point: &Point, hidden_matters: bool) -> Earlier {
        if self.was_free(point) {
            Earlier::Free
        } else if hidden_matters && self.was_hidden(point) {
            Earlier::Hidden
        } else {
            Earlier::Unknown
        }
    }

    /// Keeps a scan.
    pub fn push(&mut self, time_s: f64, pose: &Pose, scan: &Scan) {
        if self.scans.back().is_some_and(|last| time_s - last.time_s < INTERVAL_S) {
            return;
        }
        // The oldest scan gives its memory to the new one.
        let oldest = if self.scans.len() >= KEPT { self.scans.pop_front() } else { None };
        let mut ranges = oldest.map_or_else(Vec::new, |oldest| oldest.scan.ranges);
        ranges.clone_from(&scan.ranges);
        let scan = Scan { ranges, ..*scan };
        let until_now = Motion::default();
        self.scans.push_back(TimedPoseScan { time_s, until_now, pose: *pose, scan });
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A full turn with four beams for each degree, by the direction in degrees.
    pub fn scan(range: impl Fn(f64) -> f64) -> Scan {
        Scan {
            angle_min: -core::f64::consts::PI,
            angle_increment: TAU / 1440.0,
            range_max: 10.0,
            ranges: (-720..720).map(|beam| range(f64::from(beam) / 4.0)).collect(),
            ..Scan::default()
        }
    }

    fn wall(at_m: f64) -> Scan {
        scan(|_| at_m)
    }

    /// What scans show at a time, seconds, of a place ahead, metres. Each scan has its time.
    fn earlier(scans: &[(f64, Scan)], now_s: f64, ahead_m: f64) -> Earlier {
        let mut history = History::default();
        for (time_s, scan) in scans {
            history.push(*time_s, &Pose::default(), scan);
        }
        history.select(now_s, &Pose::default());
        // Between two beams.
        history.of(&Point::new(ahead_m, 0.001), true)
    }

    #[test]
    fn place_was_free_before_a_surface_and_hidden_only_well_behind_it() {
        let of = |ahead_m: f64| earlier(&[(0.0, wall(3.0))], 0.3, ahead_m);
        assert_eq!([of(2.0), of(2.85)], [Earlier::Free; 2]);
        assert_eq!([of(2.95), of(3.0), of(3.2)], [Earlier::Unknown; 3]);
        assert_eq!([of(3.4), of(9.0)], [Earlier::Hidden; 2]);
        // Odometry drifts.
        assert_eq!(earlier(&[(0.0, wall(3.0))], 1.75, 2.85), Earlier::Unknown);
        assert_eq!(earlier(&[(0.0, wall(3.0))], 0.1, 2.0), Earlier::Unknown, "too new");
    }

    #[test]
    fn hidden_places_are_listed_only_where_they_matter() {
        let mut history = History::default();
        history.push(0.0, &Pose::default(), &wall(3.0));
        history.select(0.3, &Pose::default());
        assert_eq!(history.of(&Point::new(5.0, 0.0), false), Earlier::Unknown);
        assert_eq!(history.of(&Point::new(2.0, 0.0), false), Earlier::Free);
    }

    #[test]
    fn latest_scan_decides_whether_a_place_was_hidden() {
        let at =
            |first: f64, then: f64| earlier(&[(0.0, wall(first)), (1.0, wall(then))], 1.3, 4.0);
        assert_eq!(at(1.0, 4.0), Earlier::Unknown);
        assert_eq!(at(4.0, 1.0), Earlier::Hidden);
    }

    #[test]
    fn beams_beside_and_beams_without_a_measurement_prove_nothing() {
        let of = |scan: Scan, ahead_m: f64| earlier(&[(0.0, scan)], 0.3, ahead_m);
        // A beam within the error of the poses meets something nearer.
        let beside = |at_m: f64| scan(move |degree| if degree == 1.0 { at_m } else { 9.0 });
        assert_eq!(of(beside(2.0), 2.5), Earlier::Unknown);
        assert_eq!(of(beside(f64::NAN), 2.5), Earlier::Unknown);
        assert_eq!(of(beside(9.0), 2.5), Earlier::Free);
        assert_eq!(of(wall(f64::NAN), 2.5), Earlier::Unknown);
        // Beyond the field of view.
        let behind = Scan { angle_min: 0.5, ranges: vec![9.0; 720], ..wall(9.0) };
        assert_eq!(of(behind, 2.5), Earlier::Unknown);
    }

    #[test]
    fn scan_with_gaps_shows_what_is_gone_and_proves_nothing() {
        let place = Point::new(2.5, 0.0);
        let shown = |range: &dyn Fn(f64) -> f64| {
            let scan = scan(range);
            let pose = Pose::default();
            (
                shows_free(&pose, &scan, &place),
                proves_free(&pose, &scan, &place, &Motion::default()),
            )
        };
        let is_third = |degree: f64| (4.0 * degree) as i32 % 3 == 0;
        assert_eq!(shown(&|_| 9.0), (true, true));
        // A third of the beams is measured; then all but one.
        assert_eq!(shown(&|degree| if is_third(degree) { 9.0 } else { f64::NAN }), (false, false));
        assert_eq!(shown(&|degree| if degree == 0.0 { f64::NAN } else { 9.0 }), (true, false));
        assert_eq!(shown(&|degree| if degree == 0.25 { 2.5 } else { 9.0 }), (false, false));
        assert_eq!(shown(&|_| f64::NAN), (false, false));
    }

    /// A fan of 90 degrees to each side, at the place of a lidar ahead of the robot's origin.
    #[test]
    fn edge_of_the_field_shows_what_at_least_half_of_the_beams_pass() {
        let ranges = vec![9.0; 721];
        let angle_min = -core::f64::consts::FRAC_PI_2;
        let fan = Scan { origin: Point::new(0.4, 0.0), angle_min, ranges, ..wall(9.0) };
        let pose = Pose::default();
        for (x, is_shown, is_proved) in
            [(0.5, true, true), (0.402, true, false), (0.39, false, false)]
        {
            for y in [-0.5, 0.5] {
                let place = Point::new(x, y);
                let proved = proves_free(&pose, &fan, &place, &Motion::default());
                assert_eq!(
                    (shows_free(&pose, &fan, &place), proved),
                    (is_shown, is_proved),
                    "{x} {y}"
                );
            }
        }
        assert!(is_in_view(&pose, &fan, 1.5, 0.01) && !is_in_view(&pose, &fan, 1.57, 0.01));
        assert!(!is_in_view(&pose, &fan, -1.57, 0.01) && !is_in_view(&pose, &fan, 3.1, 0.01));
    }

    /// Tracks slip: after a drive of 2 m, scans may be 10 cm apart.
    #[test]
    fn motion_between_two_scans_widens_what_must_be_free() {
        let driven = |driven_m: f64, turned: f64| Motion { time_s: 1.0, driven_m, turned };
        let is_free = |scan: Scan, apart: Motion| {
            proves_free(&Pose::default(), &scan, &Point::new(2.0, 0.001), &apart)
        };
        assert!(is_free(wall(2.15), driven(0.0, 0.0)) && is_free(wall(2.15), driven(1.0, 3.0)));
        assert!(!is_free(wall(2.15), driven(2.0, 0.0)));
        // A beam 3 degrees aside meets something nearer.
        let beside = || scan(|degree| if degree == 3.0 { 1.0 } else { 9.0 });
        assert!(is_free(beside(), driven(0.3, 0.3)));
        assert!(!is_free(beside(), driven(1.5, 0.0)) && !is_free(beside(), driven(0.0, 1.0)));
    }

    #[test]
    fn history_adds_up_the_motion_since_each_scan() {
        let mut history = History::default();
        let poses = [(0.0, 0.0, 0.0), (0.1, 0.2, 0.1), (0.2, 0.5, -0.1)];
        for (time_s, x, yaw) in poses {
            let pose = Pose::new(x, 0.0, yaw);
            history.select(time_s, &pose);
            history.push(time_s, &pose, &wall(3.0));
        }
        let is_near = |motion: Motion, time_s: f64, driven_m: f64, turned: f64| {
            let errors =
                [motion.time_s - time_s, motion.driven_m - driven_m, motion.turned - turned];
            errors.iter().all(|error| error.abs() < 1e-9)
        };
        assert!(is_near(history.motion_since(0.0), 0.2, 0.5, 0.3));
        assert!(is_near(history.motion_since(0.15), 0.1, 0.3, 0.2));
        assert!(is_near(history.motion_since(-1.0), 0.2, 0.5, 0.3), "the oldest scan there is");
    }

    #[test]
    fn scans_of_a_fast_lidar_are_kept_for_two_seconds() {
        let fast = (0..60).map(|tick| (0.02 * f64::from(tick), wall(3.0)));
        let scans: Vec<_> = core::iter::once((-0.5, wall(6.0))).chain(fast).collect();
        assert_eq!(earlier(&scans, 1.3, 4.0), Earlier::Free);
    }
}
