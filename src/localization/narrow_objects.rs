//! Narrow objects that stand alone in a scan: people, and posts. The map shows no people, so beams that end on them say nothing of
//! the pose, and a person near the lidar hides a third of what it sees.

use core::cell::Cell;
use core::f64::consts::TAU;

use super::{DeskewedScan, Hit};
use crate::map::object_runs;

/// An object is at most this wide, metres: a person, or two legs that stand apart.
const WIDEST_M: f64 = 0.8;
/// The beams next to an object end this much nearer or farther, metres, or have nothing within range.
const APART_M: f64 = 0.3;
/// Ends of neighbouring beams belong to one object within this distance, metres, plus this many beam spacings.
const NEAR_M: f64 = 0.1;
const NEAR_SPACINGS: f64 = 2.0;

/// What lies beside an edge of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Beside {
    /// Nothing, or something farther away.
    Beyond,
    /// Something nearer, which may hide a part of it, or what the field of view does not show.
    Hidden,
    /// Something as far away.
    Adjacent,
}

/// The beams of a scan with a return or with nothing within range.
struct Beams<'a> {
    /// Marked while the runs of beams are found.
    hits: &'a [Cell<Hit>],
    /// In their order: the index of the hit, or `None` for a beam with nothing within range.
    order: &'a [Option<usize>],
    /// Mean angle between two beams, radians, at least that of a full turn.
    spacing: f64,
    /// Whether the last beam is next to the first one.
    is_full_turn: bool,
}

impl Beams<'_> {
    /// The hit of a beam; beams are counted on around a full turn.
    fn hit(&self, beam: usize) -> Option<Hit> {
        self.order[beam % self.order.len()].map(|hit| self.hits[hit].get())
    }

    /// Whether a beam and the next one end on one object.
    fn are_near(&self, beam: usize) -> bool {
        let (Some(one), Some(next)) = (self.hit(beam), self.hit(beam + 1)) else {
            return false;
        };
        let range_m = one.range_m().min(next.range_m());
        (next.end - one.end).norm() < NEAR_M + NEAR_SPACINGS * self.spacing * range_m
    }

    /// What a beam next to the edge of an object shows; none where the field of view ends.
    fn beside(&self, edge: &Hit, beam: Option<usize>) -> Beside {
        let Some(beam) = beam else {
            return Beside::Hidden;
        };
        let range_m = self.hit(beam).map_or(f64::INFINITY, |hit| hit.range_m());
        match range_m - edge.range_m() {
            farther_m if farther_m > APART_M => Beside::Beyond,
            farther_m if farther_m < -APART_M => Beside::Hidden,
            _ => Beside::Adjacent,
        }
    }

    /// Whether these beams end on a narrow object that stands alone.
    fn is_alone(&self, from: usize, to: usize) -> bool {
        let (Some(right), Some(left)) = (self.hit(from), self.hit(to)) else {
            return false;
        };
        let count = self.order.len();
        let before = (self.is_full_turn || from > 0).then(|| from + count - 1);
        let after = (self.is_full_turn || to + 1 < count).then_some(to + 1);
        let edges = [self.beside(&right, before), self.beside(&left, after)];
        let is_narrow = (from..=to)
            .filter_map(|beam| self.hit(beam))
            .all(|hit| (hit.end - right.end).norm() <= WIDEST_M);
        is_narrow && edges.contains(&Beside::Beyond) && !edges.contains(&Beside::Adjacent)
    }

    /// Marks the hits on narrow objects that stand alone.
    fn mark(&self) {
        let count = self.order.len();
        let runs = object_runs(count, self.is_full_turn, |beam| self.are_near(beam));
        let alone = runs.filter(|run| self.is_alone(run.start, run.end - 1));
        for hit in alone.flatten().filter_map(|beam| self.order[beam % count]) {
            self.hits[hit].set(Hit { is_alone: true, ..self.hits[hit].get() });
        }
    }
}

impl DeskewedScan {
    /// Marks the hits on narrow objects that stand alone.
    pub(super) fn mark_narrow_objects(&mut self) {
        let Self { hits, order, directions, .. } = self;
        let (Some(first), Some(last)) = (directions.first(), directions.last()) else {
            return;
        };
        let spacing = TAU / directions.len() as f64;
        let gap = (first.0 - last.0).rem_euclid(TAU);
        let is_full_turn = gap.min(TAU - gap) <= NEAR_SPACINGS * spacing;
        let hits = Cell::from_mut(hits.as_mut_slice()).as_slice_of_cells();
        Beams { hits, order, spacing, is_full_turn }.mark();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, Vector};

    /// A scan with these ranges at equal angles over this field of view, radians, the first one at zero.
    fn scan(ranges_m: &[f64], field: f64) -> DeskewedScan {
        let mut scan = DeskewedScan::default();
        for (beam, &range_m) in ranges_m.iter().enumerate() {
            let angle = field * beam as f64 / ranges_m.len() as f64;
            scan.directions.push((angle, 0.0));
            if range_m.is_infinite() {
                scan.order.push(None);
                continue;
            }
            let (sin, cos) = libm::sincos(angle);
            let (from, end) =
                (Point::default(), Point::default() + Vector::new(cos, sin) * range_m);
            scan.order.push(Some(scan.hits.len()));
            scan.hits.push(Hit { from, end, is_alone: false });
        }
        scan.mark_narrow_objects();
        scan
    }

    fn marked(scan: &DeskewedScan) -> Vec<usize> {
        (0..scan.hits.len()).filter(|&hit| scan.hits[hit].is_alone).collect()
    }

    /// Hits of 360 beams on a wall 4 m away, and on an object 1 m away at these beams.
    fn with_object(beams: core::ops::Range<usize>, field: f64) -> DeskewedScan {
        let mut ranges = vec![4.0; 360];
        beams.for_each(|beam| ranges[beam % 360] = 1.0);
        scan(&ranges, field)
    }

    #[test]
    fn person_in_front_of_a_wall_is_alone_also_across_the_first_beam() {
        assert_eq!(marked(&with_object(100..120, TAU)), (100..120).collect::<Vec<_>>());
        let across: Vec<usize> = (0..10).chain(350..360).collect();
        assert_eq!(marked(&with_object(350..370, TAU)), across);
        let mut ranges = vec![f64::INFINITY; 360];
        ranges[100..120].fill(1.0);
        assert_eq!(marked(&scan(&ranges, TAU)).len(), 20, "in the open");
    }

    #[test]
    fn person_partly_hidden_or_cut_by_the_field_of_view_is_alone_too() {
        assert_eq!(marked(&with_object(0..20, TAU / 2.0)), (0..20).collect::<Vec<_>>());
        let mut ranges = vec![4.0; 360];
        ranges[100..110].fill(2.0);
        ranges[110..130].fill(1.0);
        assert_eq!(marked(&scan(&ranges, TAU)), (100..130).collect::<Vec<_>>());
    }

    /// A doorway hides neither of its sides.
    #[test]
    fn wall_between_two_nearer_ones_is_not() {
        let mut ranges = vec![1.0; 360];
        ranges[100..110].fill(3.0);
        assert!(marked(&scan(&ranges, TAU)).is_empty());
    }

    #[test]
    fn wide_objects_and_objects_at_a_wall_are_not() {
        assert!(marked(&with_object(100..160, TAU)).is_empty(), "1 m wide");
        let mut ranges = vec![1.2; 360];
        ranges[100..120].fill(1.0);
        assert!(marked(&scan(&ranges, TAU)).is_empty(), "0.2 m before a wall");
        assert!(marked(&scan(&[2.0; 360], TAU)).is_empty(), "a round room");
        assert!(marked(&scan(&[], TAU)).is_empty());
    }
}
