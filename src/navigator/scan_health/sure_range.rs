//! How far a lidar certainly shows surfaces: half of its range, or farther where its scans have shown that it does.

use super::SECTORS;

/// Shares of the range. Surfaces within the first return for certain; for the bands between the next ones this is learned.
const SHARES: [f64; BANDS + 1] = [0.5, 0.6, 0.7, 0.8, 0.9];
const BANDS: usize = 4;
/// A sector shows a band by at least this many beams, if this share of them returns.
const MIN_BEAMS: u32 = 3;
const SEEN_SHARE: f64 = 0.9;
/// A scan shows a band if more than half of at least this many sectors do. Dark sectors do not count, unless no sector shows it: they may
/// be covered.
const MIN_SECTORS: usize = 2;
/// A band is sure with this many more scans that show it than scans that do not, where no nearer band has as many more that do not. At
/// most twice as many count.
const LEARNED_SCANS: i32 = 10;

/// What scans have shown.
#[derive(Clone, Debug, Default)]
pub(super) struct SureRange {
    /// For each band, by how many the scans that show it are more than those that do not.
    scans: [i32; BANDS],
}

/// A beam of a scan, compared with the map.
#[derive(Clone, Copy, Debug)]
pub(super) struct ComparedBeam {
    pub sector: usize,
    /// What the lidar measured, metres.
    pub range_m: f64,
    /// Distance of the surface in the map, metres; infinite where it shows none, and through an opening.
    pub on_map_m: f64,
    /// Whether the lidar measured a surface.
    pub returns: bool,
    /// Whether it had no return through an opening that the map does not have.
    pub is_in_opening: bool,
}

impl SureRange {
    /// The share within which surfaces always count, and the largest one that is of use.
    pub const LEAST: f64 = SHARES[0];
    pub const MOST: f64 = SHARES[BANDS];

    /// The share of the range within which surfaces return for certain.
    pub fn share(&self) -> f64 {
        let shown = self.scans.iter().take_while(|&&scans| scans > -LEARNED_SCANS).enumerate();
        let sure = shown.filter(|&(_, &scans)| scans >= LEARNED_SCANS);
        SHARES[sure.map(|(band, _)| band + 1).last().unwrap_or(0)]
    }

    /// Learns from the beams of a scan of a lidar with this range, metres, given which sectors the scans before showed as dark.
    pub fn learn(
        &mut self,
        beams: &[ComparedBeam],
        range_max_m: f64,
        is_dark: impl Fn(usize) -> bool,
    ) {
        let mut counts = [[(0_u32, 0_u32); SECTORS]; BANDS];
        for beam in beams {
            let is_beyond = |share: &&f64| beam.on_map_m > **share * range_max_m;
            let beyond = SHARES.iter().filter(is_beyond).count();
            if let Some(sectors) = beyond.checked_sub(1).and_then(|band| counts.get_mut(band)) {
                sectors[beam.sector].0 += 1;
                sectors[beam.sector].1 += u32::from(beam.returns);
            }
        }
        for (scans, sectors) in self.scans.iter_mut().zip(&counts) {
            let (mut dark, mut seen, mut missed) = (0, 0, 0);
            for (sector, &(beams, returns)) in sectors.iter().enumerate() {
                if beams < MIN_BEAMS {
                    continue;
                }
                if f64::from(returns) >= SEEN_SHARE * f64::from(beams) {
                    seen += 1;
                } else if is_dark(sector) {
                    dark += 1;
                } else {
                    missed += 1;
                }
            }
            let judged = seen + missed + if seen == 0 { dark } else { 0 };
            if judged >= MIN_SECTORS {
                let shows = if seen > missed { 1 } else { -1 };
                *scans = (*scans + shows).clamp(-2 * LEARNED_SCANS, 2 * LEARNED_SCANS);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use core::ops::Range;

    use super::*;

    const RANGE_M: f64 = 10.0;

    /// A scan in a hall with walls at these shares of the range, where the lidar sees up to a share in these sectors.
    fn scan(walls: &[f64], sees_to: f64, open: &Range<usize>) -> Vec<ComparedBeam> {
        let beam = |sector: usize, share: f64| {
            let returns = open.contains(&sector) && share < sees_to;
            let on_map_m = share * RANGE_M;
            ComparedBeam { sector, range_m: on_map_m, on_map_m, returns, is_in_opening: false }
        };
        let of_sector = |sector| walls.iter().flat_map(move |&share| [beam(sector, share); 3]);
        (0..SECTORS).flat_map(of_sector).collect()
    }

    fn learned(walls: &[f64], sees_to: f64, open: Range<usize>) -> f64 {
        let mut sure = SureRange::default();
        for _ in 0..=LEARNED_SCANS {
            sure.learn(&scan(walls, sees_to, &open), RANGE_M, |_| false);
        }
        sure.share()
    }

    #[test]
    fn range_is_sure_as_far_as_most_sectors_show_it() {
        assert_eq!(SureRange::default().share(), 0.5);
        let walls = [0.4, 0.55, 0.65, 0.75, 0.85];
        for (sees_to, share) in [(0.5, 0.5), (0.6, 0.6), (0.72, 0.7), (1.0, 0.9)] {
            assert_eq!(learned(&walls, sees_to, 0..SECTORS), share);
        }
        assert_eq!(learned(&walls, 1.0, 0..9), 0.9, "seven of sixteen sectors are covered");
        assert_eq!(learned(&walls, 1.0, 0..8), 0.5);
        assert_eq!(learned(&[0.65], 1.0, 0..SECTORS), 0.7, "it sees nearer ones too");
        assert_eq!(learned(&[0.65], 0.5, 0..SECTORS), 0.5);
    }

    /// The share after more scans than are needed to unlearn, in which only these sectors return.
    fn unlearned(sees: Range<usize>, is_dark: impl Fn(usize) -> bool) -> f64 {
        let mut sure = SureRange::default();
        for _ in 0..40 {
            sure.learn(&scan(&[0.55], 1.0, &(0..SECTORS)), RANGE_M, |_| false);
        }
        for dark in 0..50 {
            assert!(dark > LEARNED_SCANS || sure.share() == 0.6, "{dark} dark scans");
            sure.learn(&scan(&[0.55], 1.0, &sees), RANGE_M, &is_dark);
        }
        sure.share()
    }

    #[test]
    fn covered_sectors_say_nothing_of_the_range() {
        assert_eq!(unlearned(12..SECTORS, |sector| sector < 12), 0.6);
        assert_eq!(unlearned(12..SECTORS, |_| false), 0.5);
        assert_eq!(unlearned(0..0, |_| true), 0.5, "as in dust");
    }
}
