//! Bounds the work for a scan of very many beams.

use super::directions::bin_of;
use crate::map::{Beam, TimedScan};

/// Directions of a turn, each a quarter of a degree wide: a centimetre at 2.3 m.
const DIRECTIONS: usize = 1440;

/// Depth within which the returns of a direction count as one obstacle, metres.
const DEPTH_M: f64 = 0.1;

/// The returns that the layer checks, each with the number of returns that it represents. A scan of at most 1440 beams keeps all
/// returns. A larger scan keeps the nearest return of each direction, which represents the returns within 0.1 m behind it. The nearest
/// surface is therefore never lost; returns farther behind it in the same direction do not count.
pub(super) fn thinned(scan: &TimedScan) -> Vec<(Beam, usize)> {
    let returns = scan.beams.iter().filter(|beam| beam.is_return(scan.range_max));
    if scan.beams.len() <= DIRECTIONS {
        return returns.map(|beam| (*beam, 1)).collect();
    }
    let mut nearest: Vec<Option<(Beam, usize)>> = vec![None; DIRECTIONS];
    for beam in returns.clone() {
        if let Some(direction) = nearest.get_mut(bin_of(beam.angle, DIRECTIONS))
            && direction.is_none_or(|(before, _)| beam.range < before.range)
        {
            *direction = Some((*beam, 0));
        }
    }
    for beam in returns {
        if let Some(Some((first, count))) = nearest.get_mut(bin_of(beam.angle, DIRECTIONS))
            && beam.range <= first.range + DEPTH_M
        {
            *count += 1;
        }
    }
    nearest.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;

    use super::*;

    fn scan(beams: usize, range: impl Fn(usize) -> f64) -> TimedScan {
        let beam = |index: usize| Beam {
            angle: index as f64 / beams as f64 * TAU,
            range: range(index),
            time_s: 0.0,
        };
        TimedScan { beams: (0..beams).map(beam).collect(), range_max: 10.0, ..TimedScan::default() }
    }

    #[test]
    fn usual_scan_keeps_every_return() {
        let kept = thinned(&scan(1440, |index| if index % 2 == 0 { 5.0 } else { f64::INFINITY }));
        assert_eq!(kept.len(), 720);
        assert!(kept.iter().all(|(_, count)| *count == 1));
    }

    #[test]
    fn dense_scan_keeps_the_nearest_return_of_each_direction() {
        // Direction 10 has the beams from 455.1 to 500.6.
        let range = |index: usize| match index {
            470 => 0.5,
            480 | 490 => 0.59,
            _ => 5.0,
        };
        let kept = thinned(&scan(65_536, range));
        assert_eq!(kept.len(), 1440);
        let near: Vec<_> = kept.iter().filter(|(beam, _)| beam.range < 1.0).collect();
        let [(beam, count)] = near[..] else { panic!("{near:?}") };
        assert_eq!((beam.range, *count), (0.5, 3));
        let all: usize = kept.iter().map(|(_, count)| count).sum();
        assert_eq!(all, 65_536 - 45 + 3, "what stands 4 m behind does not count");
    }
}
