//! Returns of dust, fog or rain in a scan.
//!
//! A grain returns one beam of one scan. The beams next to it end elsewhere, and those of the scan before went beyond it. A thin post
//! far away can look the same, when some scans miss it. Therefore such a return counts once one of the next scans has another one
//! near it, and all count where the air is clear: the filter acts only while some such returns were followed by none.
//!
//! What grains do to the robot depends on their number in a scan, not on the number of beams.

use std::mem::take;

use super::scan_visibility::{is_full_turn, shows_free};
use crate::geometry::{Point, Pose};
use crate::map::Scan;

/// The beams next to a grain end at least this much nearer or farther, metres.
const APART_M: f64 = 0.15;
/// A return confirms an earlier one within this time, seconds, and this distance, metres: a leg walks at 1.6 m/s.
const CONFIRMS_S: f64 = 0.25;
const CONFIRMS_M: f64 = 0.3;
/// The same distance where a leg has two returns at least, and its part that grows with the range: what has one is thinner, and
/// stands. Two grains are seldom so near.
const THIN_CONFIRMS_M: f64 = 0.05;
const THIN_CONFIRMS_SHARE: f64 = 0.02;
/// Least width of a leg, metres.
const LEG_M: f64 = 0.05;
/// The mean number of grains is that of about this many scans.
const MEAN_SCANS: f64 = 20.0;
/// Grains per scan from which the air is dusty. In clean air there are none in most scans.
const DUSTY: f64 = 0.1;
/// The same from which grains often look like people who come.
const HEAVY: f64 = 1.5;

/// Finds the grains of dust in scans, one after the other.
#[derive(Debug, Default)]
pub(super) struct DustFilter {
    /// The last scan without its grains, with its time, seconds, and the pose from which it was made.
    last: Option<(f64, Pose, Scan)>,
    /// Single returns of the last scans, with their times, seconds.
    single: Vec<(f64, Point)>,
    /// Mean number of grains in a scan.
    grains: f64,
}

impl DustFilter {
    /// Forgets the last scan, where the pose was wrong.
    pub fn forget(&mut self) {
        self.last = None;
        self.single.clear();
    }

    /// The share of grains among the beams, where the air is so full of them that they look like people who come.
    pub fn heavy_share(&self) -> Option<f64> {
        let beams = self.last.as_ref().map_or(0, |(.., scan)| scan.ranges.len());
        self.is_heavy().then(|| self.grains / beams.max(1) as f64)
    }

    /// Whether there is a [`Self::heavy_share`].
    pub const fn is_heavy(&self) -> bool {
        self.grains > HEAVY
    }

    /// The scan of a time, seconds, without the beams that end on grains of dust; `None` where there are none.
    pub fn without_dust(&mut self, time_s: f64, pose: &Pose, scan: &Scan) -> Option<Scan> {
        let is_recent = |then_s: f64| (0.0..=CONFIRMS_S).contains(&(time_s - then_s));
        let Some((before_s, before, last)) = self.last.take().filter(|last| is_recent(last.0))
        else {
            self.last = Some((time_s, *pose, scan.clone()));
            return None;
        };
        let lidar = pose.transform(&scan.origin);
        let singles = (0..scan.ranges.len()).filter(|beam| is_single(scan, *beam));
        let singles = singles.map(|beam| (beam, scan.end_from(&lidar, pose.yaw, beam)));
        let singles: Vec<(usize, Point)> =
            singles.filter(|(_, point)| shows_free(&before, &last, point)).collect();
        let is_confirmed = |beam: usize, point: &Point| {
            let range_m = scan.ranges[beam];
            let is_thin = range_m * scan.angle_increment * 2.0 < LEG_M;
            let thin_m = THIN_CONFIRMS_M + THIN_CONFIRMS_SHARE * range_m;
            let within_m = if is_thin { thin_m } else { CONFIRMS_M };
            self.single.iter().any(|(_, one)| (point - one).norm() < within_m)
        };
        let mut clear = scan.clone();
        let mut has_grains = false;
        for (beam, point) in &singles {
            if !is_confirmed(*beam, point) {
                clear.ranges[*beam] = f64::NAN;
                has_grains = true;
            }
        }
        // A grain of the last scan that no return of this one is near to was dust.
        let is_followed =
            |(_, one): &(f64, Point)| scan.hits(pose).any(|hit| (hit - one).norm() < CONFIRMS_M);
        let dust = self.single.iter().filter(|one| one.0 == before_s && !is_followed(one)).count();
        self.grains += (dust as f64 - self.grains) / MEAN_SCANS;
        let earlier = take(&mut self.single).into_iter().filter(|one| is_recent(one.0));
        self.single =
            earlier.chain(singles.into_iter().map(|(_, point)| (time_s, point))).collect();
        let without = (has_grains && self.grains > DUSTY).then(|| clear.clone());
        self.last = Some((time_s, *pose, clear));
        without
    }
}

/// Whether a return is apart from those of both beams next to it. A neighbour without a measurement counts as such a beam.
fn is_single(scan: &Scan, beam: usize) -> bool {
    let (range_m, count) = (scan.ranges[beam], scan.ranges.len());
    let is_at_end = beam == 0 || beam + 1 == count;
    scan.is_return(range_m)
        && (!is_at_end || is_full_turn(scan))
        && [beam + 1, beam + count - 1].iter().all(|next| {
            let next_m = scan.ranges[next % count];
            !(next_m > 0.0 && (next_m - range_m).abs() <= APART_M)
        })
}

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;

    use super::*;

    const BEAMS: usize = 360;

    /// A scan of a lidar at x = 0, in a round hall with a radius of 9 m around it, of a post on the x axis. The grains are beams with
    /// their ranges, metres.
    fn scan(pose: &Pose, post: (Point, f64), grains: &[(usize, f64)]) -> Scan {
        scan_of(BEAMS, pose, post, grains)
    }

    fn scan_of(beams: usize, pose: &Pose, post: (Point, f64), grains: &[(usize, f64)]) -> Scan {
        let increment = TAU / beams as f64;
        let (center, radius_m) = post;
        let towards = center - pose.position();
        let range_m = |beam: usize| {
            let (sin, cos) = libm::sincos(pose.yaw + increment * beam as f64);
            let (ahead_m, aside_m) =
                (towards.x * cos + towards.y * sin, towards.y * cos - towards.x * sin);
            if ahead_m > 0.0 && aside_m.abs() < radius_m { ahead_m } else { 9.0 }
        };
        let mut ranges: Vec<f64> = (0..beams).map(range_m).collect();
        for &(beam, range_m) in grains {
            ranges[beam] = range_m;
        }
        Scan { angle_increment: increment, range_max: 10.0, ranges, ..Scan::default() }
    }

    const NO_POST: (Point, f64) = (Point { x: 100.0, y: 0.0 }, 0.01);

    /// The grains of a scan of 1 % dust, at changing places.
    fn dust(number: usize) -> [(usize, f64); 4] {
        [0, 1, 2, 3].map(|grain| {
            let beam = 40 + (number * 97 + grain * 83) % 280;
            (beam, 0.7 + ((number * 31 + grain * 17) % 60) as f64 * 0.1)
        })
    }

    /// A filter after this many dusty scans, one each 0.1 s.
    fn after(scans: usize) -> DustFilter {
        let mut filter = DustFilter::default();
        for number in 0..scans {
            let dusty = scan(&Pose::default(), NO_POST, &dust(number));
            filter.without_dust(0.1 * number as f64, &Pose::default(), &dusty);
        }
        filter
    }

    #[test]
    fn grains_are_left_out_in_dusty_air_only() {
        let one = scan(&Pose::default(), NO_POST, &[(10, 1.0)]);
        let mut clear = DustFilter::default();
        clear.without_dust(0.0, &Pose::default(), &scan(&Pose::default(), NO_POST, &[]));
        assert_eq!(clear.without_dust(0.1, &Pose::default(), &one), None);
        assert!(!clear.is_heavy());
        let mut dusty = after(20);
        assert!(dusty.heavy_share().is_some_and(|share| share > 0.004), "{dusty:?}");
        let left = dusty.without_dust(2.0, &Pose::default(), &one).expect("without the grain");
        assert!(left.ranges[10].is_nan() && left.ranges[11] == 9.0);
        // A second return next to it is no grain, nor is one that another one follows.
        let two = scan(&Pose::default(), NO_POST, &[(12, 1.0), (13, 1.02)]);
        assert_eq!(dusty.without_dust(2.1, &Pose::default(), &two), None);
        assert_eq!(dusty.without_dust(2.2, &Pose::default(), &one), None);
    }

    /// The same number of grains in a scan does the same harm, however many beams there are.
    #[test]
    fn few_grains_among_many_beams_are_left_out() {
        let (beams, pose) = (1081, Pose::default());
        let mut filter = DustFilter::default();
        let mut kept = 0;
        for number in 0..60 {
            let grains = &dust(number)[..1];
            let raw = scan_of(beams, &pose, NO_POST, grains);
            let filtered = filter.without_dust(0.1 * number as f64, &pose, &raw).unwrap_or(raw);
            let is_kept = filtered.ranges.iter().any(|range_m| *range_m < 8.0);
            kept += u32::from(number >= 20 && is_kept);
        }
        assert!(kept <= 2, "{kept} of 40 grains");
    }

    /// Two neighbouring beams that end on grains at two ranges.
    #[test]
    fn grains_next_to_each_other_are_left_out() {
        let raw = scan(&Pose::default(), NO_POST, &[(10, 1.0), (11, 2.0)]);
        let left = after(20).without_dust(2.0, &Pose::default(), &raw).expect("without grains");
        assert!(left.ranges[10].is_nan() && left.ranges[11].is_nan());
    }

    /// A post of 2 cm in dusty air, from 6 m away: at 2 m its gap between two beams is wider than the post. The robot comes at 1 m/s,
    /// with the post ahead or beside its course.
    #[test]
    fn thin_post_is_seen_in_dust_before_it_is_near() {
        for aside in 0..20 {
            let post = (Point::new(6.0, 0.013 * f64::from(aside)), 0.01);
            let mut filter = after(20);
            let (mut first_m, mut filtered_first_m) = (0.0_f64, 0.0_f64);
            for number in 20..75 {
                let pose = Pose::new(0.1 * (number - 20) as f64, 0.0, 0.0);
                let raw = scan(&pose, post, &dust(number));
                let filtered = filter.without_dust(0.1 * number as f64, &pose, &raw);
                let filtered = filtered.unwrap_or_else(|| raw.clone());
                let sees = |scan: &Scan| scan.hits(&pose).any(|hit| (hit - post.0).norm() < 0.05);
                let away_m = (post.0 - pose.position()).norm();
                first_m = first_m.max(if sees(&raw) { away_m } else { 0.0 });
                filtered_first_m = filtered_first_m.max(if sees(&filtered) { away_m } else { 0.0 });
            }
            assert!(
                filtered_first_m > 2.5 || filtered_first_m > first_m - 0.25,
                "{aside}: {filtered_first_m} of {first_m} m"
            );
        }
    }
}
