//! Scan health: in which directions the lidar measures, judged by the map.
//!
//! A lidar behind a covered window reports no return in any direction, as one in a wide hall does. The map tells the two apart:
//! where it shows a surface well within range, a beam without a return contradicts it. A single such beam is no evidence (glass,
//! a black surface, a removed wall). Most beams of a sector in several scans show that the lidar does not see there.

mod lost_surfaces;
mod openings;
mod own_body;
mod sure_range;

use core::f64::consts::TAU;
use core::ops::Range;

use super::ObservationFault;
use super::scan_visibility::is_full_turn;
use crate::geometry::{Point, Pose, bearing, wrap_angle};
use crate::map::{ObstacleGrid, RayCaster, RayEnd, Scan};
use crate::robot::Footprint;
use lost_surfaces::LostSurfaces;
use openings::Openings;
use own_body::{ends_alone_within, sees_own_body};
use sure_range::{ComparedBeam, SureRange};

/// Sectors around the lidar; the first is centred in the direction of the robot's x axis.
pub(super) const SECTORS: usize = 16;
/// Beams that are compared with the map in each sector.
const RAYS: usize = 12;
/// Surfaces beyond half of the lidar's range count only in gaps that are at least this wide, radians: a wall across a roadway that is gone
/// leaves a narrower one.
const WIDE_GAP_RAD: f64 = 0.8;
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
/// Scans in a row with surfaces within the robot's outline until the lidar counts as fouled.
const FOULED_SCANS: u32 = 10;
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
    /// The sectors that scans have had beams in.
    in_view: [bool; SECTORS],
    blind_scans: u32,
    /// The number of scans in a row with surfaces within the robot's outline.
    fouled_scans: u32,
    /// Within what the map must show a surface: far and grazed surfaces return little.
    sure_range: SureRange,
    lost: LostSurfaces,
    openings: Openings,
    /// Place of the lidar in the robot's frame.
    lidar: Point,
}

impl ScanHealth {
    /// Looks in a new scan for dirt on the lidar, or a part of the robot before it.
    pub fn look_for_own_body(&mut self, scan: &Scan, body: &Footprint) {
        self.fouled_scans = if sees_own_body(body, scan) { self.fouled_scans + 1 } else { 0 };
    }

    /// Judges a new scan from a pose in the map.
    pub fn update(&mut self, pose: &Pose, scan: &Scan, known: &RayCaster) {
        self.lidar = scan.origin;
        self.lost.update(pose, scan, self.sure_range.share() * scan.range_max);
        self.openings.update(pose, scan);
        let sectors = self.coverage(pose, scan, known);
        let sum = |count: fn(&Coverage) -> u32| sectors.iter().map(count).sum::<u32>();
        let (expected, missing) = (sum(|one| one.expected), sum(|one| one.missing));
        if expected >= MIN_EXPECTED_IN_ALL {
            let is_blind = f64::from(missing) >= BLIND_SHARE * f64::from(expected);
            self.blind_scans = if is_blind { self.blind_scans + 1 } else { 0 };
        } else if sum(|one| one.returns) >= MIN_EXPECTED_IN_ALL {
            self.blind_scans = 0;
        }
        let was_dark = self.dark_scans.map(|scans| scans > 0);
        let judged = sectors.map(|sector| sector.is_dark());
        let states = self.dark_scans.iter_mut().zip(&mut self.in_view);
        for ((dark_scans, in_view), (sector, is_dark)) in states.zip(sectors.iter().zip(judged)) {
            *in_view |= sector.beams >= MIN_EXPECTED;
            match is_dark {
                Some(true) => *dark_scans += 1,
                Some(false) => *dark_scans = 0,
                // The scans lack a part of the field of view that they had.
                None if sector.beams == 0 && *in_view => *dark_scans += 1,
                None if sector.beams == 0 => *dark_scans = 0,
                // The lidar was not shown to see again.
                None => {}
            }
        }
        self.release(&was_dark, &judged);
    }

    /// Sectors in which the scan shows nothing, such as the middle of an opening, are no longer dark where the sectors on both sides of
    /// them see and one of these was dark too: the cover is gone. Otherwise a robot that stands still would wait for ever.
    fn release(&mut self, was_dark: &[bool; SECTORS], judged: &[Option<bool>; SECTORS]) {
        let at = |place: usize| place % SECTORS;
        for before in (0..SECTORS).filter(|&sector| judged[sector] == Some(false)) {
            let shows_nothing =
                |step: &usize| judged[at(before + step)].is_none() && was_dark[at(before + step)];
            let count = (1..SECTORS).take_while(shows_nothing).count();
            let after = at(before + count + 1);
            if judged[after] == Some(false) && (was_dark[before] || was_dark[after]) {
                (1..=count).for_each(|step| self.dark_scans[at(before + step)] = 0);
            }
        }
    }

    /// Compares evenly chosen beams of a scan with the map.
    fn coverage(&mut self, pose: &Pose, scan: &Scan, rays: &RayCaster) -> [Coverage; SECTORS] {
        let beams = scan.ranges.len();
        let turn = beams as f64 * scan.angle_increment / TAU;
        let most = (SECTORS * RAYS).min(beams);
        let count = ((turn * (SECTORS * RAYS) as f64) as usize).clamp(1, most);
        let beam_of = |ray: usize| ray * beams / count;
        let start = pose.transform(&scan.origin);
        let cast: Vec<_> =
            (0..count).map(|ray| (start, pose.yaw + scan.angle(beam_of(ray)))).collect();
        let ends = rays.cast_all(&cast, SureRange::MOST * scan.range_max);
        let compared = |(ray, on_map): (usize, &RayEnd)| {
            let (direction, range_m) = (scan.angle(beam_of(ray)), scan.ranges[beam_of(ray)]);
            let (sector, returns) = (sector_of(direction), scan.is_return(range_m));
            let is_in_opening = !returns && self.openings.contain(direction);
            let on_map_m = match on_map {
                RayEnd::Blocked(on_map_m) if *on_map_m >= MIN_RANGE_M && !is_in_opening => {
                    *on_map_m
                }
                _ => f64::INFINITY,
            };
            ComparedBeam { sector, range_m, on_map_m, returns, is_in_opening }
        };
        let compared: Vec<_> = ends.iter().enumerate().map(compared).collect();
        let is_dark = |sector: usize| self.dark_scans[sector] > 0;
        self.sure_range.learn(&compared, scan.range_max, is_dark);
        let [near_m, sure_m] =
            [SureRange::LEAST, self.sure_range.share()].map(|share| share * scan.range_max);
        let spacing = scan.angle_increment * beams as f64 / count as f64;
        let gaps = gaps(count, |ray| compared[ray].returns);
        let wide = in_wide_gaps(&gaps, count, (WIDE_GAP_RAD / spacing).ceil() as usize);
        let ray = |(beam, is_in_wide_gap): (&ComparedBeam, bool)| {
            let &ComparedBeam { sector, range_m, on_map_m, returns, .. } = beam;
            let is_expected =
                on_map_m <= near_m || on_map_m <= sure_m && (returns || is_in_wide_gap);
            let is_on_map = is_expected || range_m > sure_m;
            let is_far = returns && is_on_map && range_m >= OPEN_SHARE * sure_m;
            Ray { sector, returns, is_expected, is_far }
        };
        let rays: Vec<Ray> = compared.iter().zip(wide).map(ray).collect();
        let mut sectors = [Coverage::default(); SECTORS];
        for (ray, beam) in rays.iter().zip(&compared) {
            let sector = &mut sectors[ray.sector];
            sector.beams += 1;
            sector.returns += u32::from(ray.returns);
            sector.expected += u32::from(ray.is_expected);
            sector.missing += u32::from(ray.is_expected && !ray.returns);
            sector.in_open_gaps += u32::from(beam.is_in_opening);
        }
        if is_full_turn(scan) {
            judge_gaps(&rays, gaps, &mut sectors);
        }
        sectors
    }

    /// The fault of a lidar that sees nothing at all, or nothing ahead.
    pub fn fault(&self) -> Option<ObservationFault> {
        if self.blind_scans >= BLIND_SCANS {
            return Some(ObservationFault::LidarBlind);
        }
        if self.fouled_scans >= FOULED_SCANS {
            return Some(ObservationFault::LidarFouled);
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

    /// The scan without the beams without a return of dark sectors and towards lost surfaces: they saw nothing, also not that something
    /// is gone. And without single ones that end within the robot's body, as on dust. `None` where there are no such beams.
    pub fn masked(&self, scan: &Scan, body: &Footprint) -> Option<Scan> {
        let ends_alone_within = ends_alone_within(body, scan);
        let mut beams = (0..scan.ranges.len()).filter(|&beam| {
            let sees_nothing = || !scan.is_return(scan.ranges[beam]);
            let is_dark = || self.dark_scans[sector_of(scan.angle(beam))] > 0;
            ends_alone_within(beam) || sees_nothing() && (is_dark() || self.lost.hides(beam))
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

/// The gaps of neighbouring beams without a return, of a number of beams. The last beam is next to the first one: places count on
/// around a full turn.
fn gaps(count: usize, returns: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    if !(0..count).any(&returns) {
        return core::iter::once(0..count).collect();
    }
    let after = |before: usize| {
        let length = (1..count).take_while(|step| !returns((before + step) % count)).count();
        before + 1..before + 1 + length
    };
    (0..count).filter(|&before| returns(before)).map(after).collect()
}

/// Whether each of a number of beams lies in a gap of at least some of them.
fn in_wide_gaps(gaps: &[Range<usize>], count: usize, least: usize) -> Vec<bool> {
    let mut wide = vec![false; count];
    for place in gaps.iter().filter(|gap| gap.len() >= least).cloned().flatten() {
        wide[place % count] = true;
    }
    wide
}

/// Counts the rays in dark and open gaps of a full turn. Gaps of half a turn and more are left to the sectors.
fn judge_gaps(rays: &[Ray], gaps: Vec<Range<usize>>, sectors: &mut [Coverage; SECTORS]) {
    let count = rays.len();
    let at = |place: usize| &rays[place % count];
    for gap in gaps {
        let expected = gap.clone().filter(|&place| at(place).is_expected).count();
        if 2 * gap.len() >= count || expected == gap.len() {
            continue;
        }
        let is_dark = expected >= MIN_EXPECTED_IN_GAP;
        let is_open = expected <= 1 && at(gap.start - 1).is_far && at(gap.end).is_far;
        for place in gap {
            let sector = &mut sectors[at(place).sector];
            sector.in_dark_gaps += u32::from(is_dark);
            sector.in_open_gaps += u32::from(is_open);
        }
    }
}

#[cfg(test)]
mod tests;
