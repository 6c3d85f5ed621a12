//! Recent positions of moving obstacles, for sensors that deliver late.

use std::collections::VecDeque;

use crate::map::MovingDisc;

/// Length of the history, seconds: longer than the largest delay.
const HISTORY_S: f64 = 1.0;

/// The parts of the moving obstacles that a lidar hits, tick by tick. A part belongs to the obstacle of its list; it is none
/// while that has not yet appeared.
#[derive(Clone, Debug, Default)]
pub(super) struct PastObstacles {
    ticks: VecDeque<(f64, Vec<Vec<Option<MovingDisc>>>)>,
}

impl PastObstacles {
    /// Records the parts of each obstacle at a time, seconds, which ascends from call to call.
    pub fn record(&mut self, time_s: f64, parts: Vec<Vec<Option<MovingDisc>>>) {
        while self.ticks.get(1).is_some_and(|(next_s, _)| time_s - next_s > HISTORY_S) {
            self.ticks.pop_front();
        }
        self.ticks.push_back((time_s, parts));
    }

    /// The parts at an earlier time, seconds, interpolated between ticks; each with the index of its obstacle among those
    /// that have appeared by the newest tick. An obstacle that appeared between two ticks is seen from the later one on.
    pub fn at(&self, time_s: f64) -> Vec<(usize, MovingDisc)> {
        let after = self.ticks.partition_point(|(tick_s, _)| *tick_s <= time_s);
        let Some((before_s, before)) = after.checked_sub(1).and_then(|row| self.ticks.get(row))
        else {
            return Vec::new();
        };
        let next = self.ticks.get(after);
        let mut seen = Vec::new();
        let newest = self.ticks.back().map_or(&[][..], |(_, parts)| parts);
        let mut index = 0;
        for (obstacle, parts) in before.iter().enumerate() {
            for (part, disc) in parts.iter().enumerate() {
                let Some(disc) = disc else { continue };
                let moved = next.and_then(|(next_s, next)| {
                    let then = next.get(obstacle)?.get(part)?.as_ref()?;
                    let share = (time_s - before_s) / (next_s - before_s);
                    let between = |from: f64, to: f64| from + (to - from) * share;
                    Some(MovingDisc {
                        x: between(disc.x, then.x),
                        y: between(disc.y, then.y),
                        ..*disc
                    })
                });
                seen.push((index, moved.unwrap_or(*disc)));
            }
            let has_appeared =
                newest.get(obstacle).is_some_and(|it| it.iter().any(Option::is_some));
            index += usize::from(has_appeared);
        }
        seen
    }
}
