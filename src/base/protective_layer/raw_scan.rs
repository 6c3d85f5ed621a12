//! The newest raw scan in the robot's own odometry: its returns, the moving ones, and its blind sectors.

use core::f64::consts::TAU;
use std::borrow::Cow;
use std::collections::VecDeque;

use super::body::Body;
use super::directions::{BINS, Largest, bin_of, polar};
use super::obstacle::together_m;
use super::thinning::thinned;
use crate::geometry::{Frame, Point, Pose, Twist, Vector, wrap_angle};
use crate::localization::PoseHistory;
use crate::map::{Beam, ScanChange, TimedScan};

/// Sectors of a turn for which it is known whether the lidar measures there.
const SECTORS: usize = 36;
/// A sector counts as seen if one of this many on either side is. Many lidars report nothing where no surface is within their
/// range, as along a straight roadway: only a wide gap in a scan is a blind lidar. The navigator compares narrow ones with the map.
const SEEN_NEIGHBOURS: usize = 2;

/// Share of a sector's beams with a measurement from which the sector is seen: dust and dark rock swallow some beams.
const SEEN_SHARE: f64 = 0.2;

/// Neighbours on each side whose shortest range counts: a wall at a grazing angle moves along the beam when the robot turns.
const NEIGHBOURS: usize = 2;

/// Share of a turn by which the measured turn may be wrong; more neighbours count then. Tracks slip sideways.
const TURN_ERROR: f64 = 0.1;

/// Ages of the scans that show earlier free space, seconds, between multiples of a usual period. The youngest detects fast
/// walkers, the oldest detects slow walkers, who have left their earlier place by then.
const FREE_AGES_S: [f64; 3] = [0.15, 0.25, 0.75];

/// Longest time for which a scan is remembered, seconds.
const REMEMBERED_S: f64 = 1.2;

/// Distance behind a vanished return within which a return belongs to the same obstacle: a person who walks away, and may turn.
const WALKED_M: f64 = 0.6;

/// Depth of a return in earlier free space from which it moved, metres: noise, and the error of the odometry.
const MOVED_M: f64 = 0.12;

/// Longest time over which a measured motion is extrapolated, seconds.
const EXTRAPOLATED_S: f64 = 0.5;

/// Motion of the base from which identical scans are a fault: far beyond the resolution of a range and of a beam.
const MOVED_FROZEN_M: f64 = 0.05;
const MOVED_FROZEN_RAD: f64 = 0.05;

/// Most beams of a scan.
const MAX_BEAMS: usize = 65_536;

/// Longest time of a scan, seconds: a beam that is older shows another place than the robot's surroundings.
const MAX_SCAN_S: f64 = 1.0;

/// Rounding of a time, seconds.
const ROUNDING_S: f64 = 1e-6;

/// A return in the robot's present frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RawPoint {
    pub place: Point,
    /// Whether it moves: earlier scans show its place free.
    pub moves: bool,
    /// Distance from the body, metres; negative within it.
    pub gap_m: f64,
    /// Number of returns that this one stands for.
    pub beams: usize,
    /// A return of the same obstacle may be this far away, metres.
    pub together_m: f64,
}

/// Poses of the base by its measured motion. The frame is arbitrary: that of the first report.
#[derive(Clone, Debug)]
struct MeasuredMotion {
    poses: PoseHistory,
    newest: Option<(f64, Twist)>,
    /// Distance and turn driven so far.
    travelled_m: f64,
    turned_rad: f64,
}

impl MeasuredMotion {
    fn update(&mut self, twist: &Twist, stamp_s: f64) {
        if !(twist.is_finite() && stamp_s.is_finite()) {
            return;
        }
        let pose = self.pose_at(stamp_s);
        if let Some((before_s, before)) = self.newest {
            let elapsed_s = (stamp_s - before_s).clamp(0.0, EXTRAPOLATED_S);
            // What only one of two reports shows is braking or an old report: a base that stands since must not count as moving.
            self.travelled_m += before.linear.abs().min(twist.linear.abs()) * elapsed_s;
            self.turned_rad += before.angular.abs().min(twist.angular.abs()) * elapsed_s;
        }
        self.newest = Some((stamp_s, *twist));
        self.poses.record(stamp_s, &pose);
    }

    /// The pose at a time, seconds; beyond the last report by the motion of that report.
    fn pose_at(&self, time_s: f64) -> Pose {
        match (self.newest, self.poses.newest()) {
            (Some((newest_s, twist)), Some((_, pose))) if time_s >= newest_s => {
                pose.after(&twist, (time_s - newest_s).min(EXTRAPOLATED_S))
            }
            _ => self.poses.at(time_s).unwrap_or_default(),
        }
    }
}

/// Ranges of an earlier scan by direction.
#[derive(Clone, Debug)]
struct SeenSpace {
    stamp_s: f64,
    pose: Pose,
    frame: Frame,
    /// The shortest distance that was seen free in each direction and its neighbours, metres. Directions without a measurement do
    /// not count: a lidar has few beams, and some of them return nothing. It is infinite where none was measured.
    nearest_free_m: Vec<f64>,
    /// Nothing farther is free in a direction, metres.
    farthest_free_m: Largest,
    /// Returns in the frame of the measured motion.
    returns: Vec<Point>,
}

impl SeenSpace {
    /// Creates it from the distance that was seen free in each direction, metres; infinite where nothing was measured.
    fn new(stamp_s: f64, pose: Pose, free_m: &[f64], returns: Vec<Point>) -> Self {
        let measured = free_m.iter().filter(|free_m| free_m.is_finite());
        let longest_m = measured.copied().fold(f64::NEG_INFINITY, f64::max);
        let nearest_free_m = least_around(free_m, NEIGHBOURS);
        // More neighbours may count later, so a direction without a measurement may get any of the distances.
        let bounds_m: Vec<f64> =
            nearest_free_m.iter().map(|free_m| free_m.min(longest_m)).collect();
        Self {
            stamp_s,
            pose,
            frame: pose.to_frame(),
            nearest_free_m,
            farthest_free_m: Largest::of(&bounds_m, 0),
            returns,
        }
    }

    /// Direction and distance as of [`polar`], for a point in space that was seen free, by [`Self::nearest_free_m`].
    fn free_place(&self, nearest_free_m: &[f64], point: &Point) -> Option<(usize, f64)> {
        let (bin, away_m) = self.polar_within(&self.farthest_free_m, -MOVED_M, point)?;
        let nearest_m = nearest_free_m.get(bin).filter(|free_m| free_m.is_finite())?;
        (away_m < nearest_m - MOVED_M).then_some((bin, away_m))
    }

    /// Direction and distance as of [`polar`], for a point nearer than a bound in its direction and a margin, metres.
    fn polar_within(&self, bound: &Largest, margin_m: f64, point: &Point) -> Option<(usize, f64)> {
        let local = self.frame.inverse_transform(point);
        (local.to_vector().norm() < bound.at(&local) + margin_m).then(|| polar(&local))
    }

    /// The shortest distance that was seen free in each direction and its neighbours, metres, from another pose.
    fn nearest_free_m(&self, now: &Pose) -> Cow<'_, [f64]> {
        let turn_error = wrap_angle(now.yaw - self.pose.yaw).abs() * TURN_ERROR;
        match (turn_error / TAU * BINS as f64) as usize {
            0 => Cow::Borrowed(&self.nearest_free_m),
            more => Cow::Owned(least_around(&self.nearest_free_m, more)),
        }
    }

    /// Where returns of earlier scans have vanished, if any has.
    fn vanished<'a>(&self, earlier: impl Iterator<Item = &'a Self>) -> Option<Vanished> {
        let mut by_direction_m = vec![f64::NEG_INFINITY; BINS];
        let mut is_any = false;
        for seen in earlier {
            let free_m = self.nearest_free_m(&seen.pose);
            let places = seen.returns.iter().filter_map(|point| self.free_place(&free_m, point));
            for (bin, away_m) in places {
                if let Some(farthest_m) = by_direction_m.get_mut(bin) {
                    *farthest_m = farthest_m.max(away_m);
                    is_any = true;
                }
            }
        }
        is_any.then(|| Vanished {
            farthest_m: Largest::of(&by_direction_m, NEIGHBOURS),
            by_direction_m,
        })
    }

    /// Whether a point lies right behind a vanished return.
    fn is_behind(&self, vanished: &Vanished, point: &Point) -> bool {
        let Some((bin, away_m)) = self.polar_within(&vanished.farthest_m, WALKED_M, point) else {
            return false;
        };
        (0..=2 * NEIGHBOURS)
            .filter_map(|offset| {
                vanished.by_direction_m.get((bin + BINS + offset - NEIGHBOURS) % BINS)
            })
            .any(|vanished_m| (*vanished_m..*vanished_m + WALKED_M).contains(&away_m))
    }
}

/// Where earlier returns have vanished.
struct Vanished {
    /// The farthest distance in each direction, metres; minus infinity without any.
    by_direction_m: Vec<f64>,
    /// The farthest of the neighbours.
    farthest_m: Largest,
}

/// The least of the values in each direction and this many on each side of it.
fn least_around(values: &[f64], neighbours: usize) -> Vec<f64> {
    let mut least = vec![f64::INFINITY; BINS];
    for offset in 0..=2 * neighbours {
        let (before, from) = values.split_at((BINS + offset - neighbours) % BINS);
        let (first, rest) = least.split_at_mut(from.len());
        for (least, values) in [(first, from), (rest, before)] {
            for (least, value) in least.iter_mut().zip(values) {
                *least = if value < least { *value } else { *least };
            }
        }
    }
    least
}

/// A return of the newest scan.
#[derive(Clone, Copy, Debug)]
struct Return {
    /// Its place in the frame of the measured motion.
    place: Point,
    moves: bool,
    /// Number of returns that this one stands for.
    beams: usize,
    /// A return of the same obstacle may be this far away, metres.
    together_m: f64,
}

/// The newest scan.
#[derive(Clone, Debug)]
struct NewestScan {
    stamp_s: f64,
    pose: Pose,
    returns: Vec<Return>,
    /// Share of all beams with a return.
    return_share: f64,
    /// Whether each sector is seen.
    seen: [bool; SECTORS],
}

/// Identical scans.
#[derive(Clone, Copy, Debug)]
struct Repetition {
    scans: usize,
    /// Distance and turn of the base when the first of them came.
    since_m: f64,
    since_rad: f64,
}

/// The raw scans and the measured motion of a robot.
#[derive(Clone, Debug)]
pub(super) struct RawScans {
    motion: MeasuredMotion,
    newest: Option<NewestScan>,
    earlier: VecDeque<SeenSpace>,
    change: ScanChange,
    repetition: Repetition,
}

impl RawScans {
    pub fn new() -> Self {
        let motion = MeasuredMotion {
            poses: PoseHistory::new(),
            newest: None,
            travelled_m: 0.0,
            turned_rad: 0.0,
        };
        let repetition = Repetition { scans: 0, since_m: 0.0, since_rad: 0.0 };
        let change = ScanChange::default();
        Self { motion, newest: None, earlier: VecDeque::new(), change, repetition }
    }

    /// Takes the measured motion at its time, seconds.
    pub fn update_motion(&mut self, twist: &Twist, stamp_s: f64) {
        self.motion.update(twist, stamp_s);
    }

    /// The measured motion and its time, seconds; none before the first report.
    pub fn measured(&self) -> Option<(f64, Twist)> {
        self.motion.newest
    }

    /// Takes a scan and the time of its newest beam, seconds. The same scan may come again; an invalid one is ignored, and the
    /// last one ages.
    pub fn update_scan(&mut self, scan: &TimedScan, stamp_s: f64) {
        if !is_usable(scan, stamp_s)
            || self.newest.as_ref().is_some_and(|newest| newest.stamp_s == stamp_s)
        {
            return;
        }
        self.count_repetition(scan);
        let pose = self.motion.pose_at(stamp_s);
        // Of the scans that are old enough, the newest.
        let newest_of_age = |age_s: f64| {
            self.earlier.iter().rev().find(move |seen| stamp_s - seen.stamp_s >= age_s)
        };
        let references = FREE_AGES_S.map(newest_of_age);
        let mut free_m = vec![f64::INFINITY; BINS];
        let mut beams = [(0_u32, 0_u32); SECTORS];
        let mut return_count = 0;
        for beam in &scan.beams {
            let is_return = beam.is_return(scan.range_max);
            return_count += usize::from(is_return);
            let is_measured = is_return || beam.range == f64::INFINITY;
            if let Some((all, measured)) = beams.get_mut(bin_of(beam.angle, SECTORS)) {
                *all += 1;
                *measured += u32::from(is_measured);
            }
            let bin = free_m.get_mut(bin_of(beam.angle, BINS)).filter(|_| is_measured);
            if let Some(bin) = bin {
                *bin = bin.min(beam.range.min(scan.range_max));
            }
        }
        let kept = thinned(scan);
        let mut at: Option<(f64, Frame)> = None;
        let returns = kept.iter().map(|(beam, _)| {
            // All beams of many scans have one time.
            let (_, frame) = at
                .filter(|(time_s, _)| *time_s == beam.time_s)
                .unwrap_or_else(|| (beam.time_s, self.motion.pose_at(beam.time_s).to_frame()));
            at = Some((beam.time_s, frame));
            let (sin, cos) = libm::sincos(beam.angle);
            frame.transform(&(scan.origin + Vector::new(cos, sin) * beam.range))
        });
        let returns = returns.collect();
        let Point { x, y } = pose.transform(&scan.origin);
        let seen = SeenSpace::new(stamp_s, Pose { x, y, ..pose }, &free_m, returns);
        let vanished = seen.vanished(references.iter().flatten().copied());
        let earlier: Vec<(&SeenSpace, Cow<'_, [f64]>)> =
            references.iter().flatten().map(|seen| (*seen, seen.nearest_free_m(&pose))).collect();
        let has_moved = |place: &Point| {
            earlier.iter().any(|(earlier, free_m)| earlier.free_place(free_m, place).is_some())
                || vanished.as_ref().is_some_and(|vanished| seen.is_behind(vanished, place))
        };
        let increment = TAU / scan.beams.len() as f64;
        let with_motion = |(place, (beam, beams)): (&Point, &(Beam, usize))| Return {
            place: *place,
            moves: has_moved(place),
            beams: *beams,
            together_m: together_m(beam.range, increment),
        };
        let returns: Vec<Return> = seen.returns.iter().zip(&kept).map(with_motion).collect();
        self.remember(seen);
        let is_seen = |(all, measured): (u32, u32)| {
            all > 0 && f64::from(measured) >= SEEN_SHARE * f64::from(all)
        };
        self.newest = Some(NewestScan {
            stamp_s,
            pose,
            return_share: return_count as f64 / scan.beams.len() as f64,
            returns,
            seen: with_neighbours(beams.map(is_seen)),
        });
    }

    fn remember(&mut self, seen: SeenSpace) {
        let newest_s = seen.stamp_s;
        // A clock that runs backwards makes every memory useless.
        let is_kept = |old: &SeenSpace| (0.0..REMEMBERED_S).contains(&(newest_s - old.stamp_s));
        while self.earlier.front().is_some_and(|old| !is_kept(old)) {
            self.earlier.pop_front();
        }
        self.earlier.push_back(seen);
    }

    fn count_repetition(&mut self, scan: &TimedScan) {
        if self.change.is_repeated(scan.beams.iter().map(|beam| beam.range)) {
            self.repetition.scans += 1;
        } else {
            let MeasuredMotion { travelled_m, turned_rad, .. } = self.motion;
            self.repetition = Repetition { scans: 1, since_m: travelled_m, since_rad: turned_rad };
        }
    }

    /// Number of identical scans if the base has moved since the first of them; else none.
    pub fn frozen_scans(&self) -> Option<usize> {
        let Repetition { scans, since_m, since_rad } = self.repetition;
        let moved_m = self.motion.travelled_m - since_m;
        let turned_rad = self.motion.turned_rad - since_rad;
        let has_moved = moved_m > MOVED_FROZEN_M || turned_rad > MOVED_FROZEN_RAD;
        has_moved.then_some(scans)
    }

    /// Age of the newest scan, seconds; none without one.
    pub fn age_s(&self, now_s: f64) -> Option<f64> {
        self.newest.as_ref().map(|newest| now_s - newest.stamp_s)
    }

    /// Share of the beams with a return.
    pub fn return_share(&self) -> f64 {
        self.newest.as_ref().map_or(0.0, |newest| newest.return_share)
    }

    /// The returns in the robot's present frame.
    pub fn points(&self, body: &Body, now_s: f64) -> Vec<RawPoint> {
        let frame = self.motion.pose_at(now_s).to_frame();
        let returns = self.newest.iter().flat_map(|newest| &newest.returns);
        returns
            .map(|seen| {
                let place = frame.inverse_transform(&seen.place);
                let gap_m = body.distance_m(&place);
                let Return { moves, beams, together_m, .. } = *seen;
                RawPoint { place, moves, gap_m, beams, together_m }
            })
            .collect()
    }

    /// The middles of the sectors that the lidar does not see, radians in the robot's present frame.
    pub fn blind_directions(&self, now_s: f64) -> impl Iterator<Item = f64> + '_ {
        let yaw = self.motion.pose_at(now_s).yaw;
        self.newest.iter().flat_map(move |newest| {
            let turned = yaw - newest.pose.yaw;
            let blind = newest.seen.iter().enumerate().filter(|(_, seen)| !**seen);
            blind.map(move |(sector, _)| {
                wrap_angle((sector as f64 + 0.5) * TAU / SECTORS as f64 - turned)
            })
        })
    }
}

/// Whether a scan has beams that can be placed, and ends at a time, seconds.
fn is_usable(scan: &TimedScan, stamp_s: f64) -> bool {
    let is_current =
        |beam: &Beam| (stamp_s - MAX_SCAN_S..=stamp_s + ROUNDING_S).contains(&beam.time_s);
    stamp_s.is_finite()
        && (1..=MAX_BEAMS).contains(&scan.beams.len())
        && scan.is_valid()
        && scan.beams.iter().all(is_current)
}

/// The sectors that are seen, or have a seen one next to them.
fn with_neighbours(seen: [bool; SECTORS]) -> [bool; SECTORS] {
    core::array::from_fn(|sector| {
        (0..=2 * SEEN_NEIGHBOURS)
            .any(|step| seen[(sector + SECTORS + step - SEEN_NEIGHBOURS) % SECTORS])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remembered_scans_are_bounded_in_time() {
        let mut scans = RawScans::new();
        let at = |scans: &mut RawScans, time_s: f64| {
            let beams = vec![Beam { angle: 0.0, range: 1.0, time_s }];
            scans.update_scan(&TimedScan { beams, range_max: 9.0, ..TimedScan::default() }, time_s);
        };
        for tick in 0..200 {
            at(&mut scans, 100.0 + 0.1 * f64::from(tick));
        }
        assert!((11..=13).contains(&scans.earlier.len()), "{}", scans.earlier.len());
        // A clock that runs backwards makes them useless, and so does their age.
        at(&mut scans, 0.0);
        assert_eq!(scans.earlier.len(), 1);
        at(&mut scans, REMEMBERED_S);
        assert_eq!(scans.earlier.len(), 1);
    }

    #[test]
    fn measured_motion_is_extrapolated_over_at_most_half_a_second() {
        let mut scans = RawScans::new();
        scans.update_motion(&Twist::new(1.0, 0.0), 10.0);
        for (time_s, x_m) in [(10.3, 0.3), (12.0, 0.5)] {
            assert!((scans.motion.pose_at(time_s).x - x_m).abs() < 1e-9, "{time_s} s");
        }
        // What is not finite is no motion.
        scans.update_motion(&Twist::new(f64::NAN, 0.0), 10.1);
        scans.update_motion(&Twist::STOP, f64::INFINITY);
        assert_eq!(scans.measured(), Some((10.0, Twist::new(1.0, 0.0))));
        scans.update_motion(&Twist::new(-1.0, -2.0), 10.2);
        scans.update_motion(&Twist::new(-1.0, -2.0), 10.3);
        assert!((scans.motion.travelled_m - 0.3).abs() < 1e-9);
        assert!((scans.motion.turned_rad - 0.2).abs() < 1e-9);
        // After a long silence of the base only half a second counts.
        scans.update_motion(&Twist::new(-1.0, -2.0), 15.3);
        assert!((scans.motion.travelled_m - 0.8).abs() < 1e-9);
        assert!((scans.motion.turned_rad - 1.2).abs() < 1e-9);
    }
}
