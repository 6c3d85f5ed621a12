//! Progress along the path, and the time without any.
//!
//! Progress is that the length left falls by a radius below a reference. A plan alone is no progress, and undoes none. The behaviours
//! need the progress along the present path, so for them a longer plan raises the reference by what it is longer.
//!
//! A mission must end, so new plans must not renew the time that it has. For it these hold:
//!
//! - A shorter plan leaves the reference, and the least length left can fall only so often. A longer plan raises it only by what it
//!   is longer than all since the robot was nearest to its goal: that part of the detour is new. What the robot backs away, and a
//!   detour that it knew, it drives without progress.
//! - The robot is nearest to its goal where progress ends at least the radius below the least length left before.
//!
//! Between two such places all progress together is thus at most the longest detour. A robot among obstacles that come and go fails
//! in the end, and one that finds one passage after the other blocked does not.

use super::Mode;
use super::state::State;

/// A robot that waits for people has this many times the time without progress.
const WAITING_PATIENCES: f64 = 4.0;
/// At most so much of the way back counts as no progress, metres: escapes are shorter, and a robot that was carried starts again.
const MAX_RETREAT_M: f64 = 5.0;
/// A robot that comes nearer to its goal by this on the path, metres, approaches it.
const APPROACHED_M: f64 = 0.05;
/// A robot that made progress along its present path within this time goes on, seconds, for up to this many times its allowance: plans
/// that led to and fro may have cost the time before.
const ADVANCED_S: f64 = 10.0;
const MOST_ALLOWANCES: f64 = 2.0;
/// Share of its highest speed at which the robot drives what it has to drive again before it can make progress.
const DETOUR_SPEED: f64 = 0.5;

/// Measures the time since the last progress, as Nav2's progress checker, and the time since the robot came nearer at all.
#[derive(Clone, Debug, Default)]
pub(super) struct Progress {
    /// Along the present path.
    recent: Reference,
    /// The same since the last escape, for less than what counts as progress.
    approach: Reference,
    /// Not renewed by new plans.
    bounded: Reference,
    /// Time since the last bounded progress for which the robot waited for people, seconds.
    waited_s: f64,
    /// Length left beyond the reference of the bounded progress, metres.
    behind_m: f64,
    /// Time since the last progress along the present path, seconds.
    stuck_s: f64,
    /// Time since the last progress that new plans do not renew, seconds.
    pub bounded_s: f64,
}

impl Progress {
    /// Counts the time of a tick for which the robot waits for people, also while it parks. Where the air is full of dust, no time is
    /// spared for people, whom grains look like.
    pub fn count_waiting(&mut self, state: &State<'_>, is_in_dust: bool) {
        if state.waits_for_people() && !is_in_dust {
            self.waited_s += state.tick.elapsed_s();
        }
    }

    /// Updates with the state of a tick and sets its times without progress. Returns whether the mission fails: it made no progress for
    /// longer than it may.
    pub fn check(&mut self, state: &mut State<'_>) -> bool {
        let (now_s, left_m) = (state.now.time_s, state.route.left_m());
        self.update(now_s, left_m, state.settings.required_movement_radius);
        if state.mode == Mode::Escaping {
            self.approach = Reference::default();
        }
        state.since_nearer_s = self.approach.stuck_s(now_s, left_m, APPROACHED_M);
        state.stuck_s = self.stuck_s;
        self.has_failed(state.robot.limits.max_vel_x, state.settings.movement_time_allowance)
    }

    /// Whether the robot had the time that it may have without progress, seconds, by its highest speed, m/s.
    fn has_failed(&self, highest_speed: f64, allowance_s: f64) -> bool {
        let allowances = if self.stuck_s <= ADVANCED_S { MOST_ALLOWANCES } else { 1.0 };
        self.counted_s(highest_speed) > allowances * allowance_s
    }

    /// Updates with the length of path left, metres, and the shortest advance that counts.
    fn update(&mut self, now_s: f64, left_m: f64, radius_m: f64) {
        self.stuck_s = self.recent.stuck_s(now_s, left_m, radius_m);
        self.bounded_s = self.bounded.stuck_s(now_s, left_m, radius_m);
        self.behind_m =
            self.bounded.least_left_m.map_or(0.0, |least_m| (left_m - least_m).max(0.0));
        if self.bounded_s == 0.0 {
            self.waited_s = 0.0;
        }
    }

    /// The time without progress that counts, seconds. A part of the time with people does not, nor does what the robot needs to
    /// drive before it can make progress, by its highest speed, m/s.
    fn counted_s(&self, highest_speed: f64) -> f64 {
        let spared_s = spared_s(self.waited_s);
        let detour_s = self.behind_m / (DETOUR_SPEED * highest_speed);
        // A robot that cannot drive ahead drives nothing again.
        self.bounded_s - spared_s - if highest_speed > 0.0 { detour_s } else { 0.0 }
    }

    /// Measures along a new path from now on, given the lengths left on the path before and on this one, metres.
    pub fn rebase(&mut self, before_m: f64, left_m: f64) {
        self.recent.rebase(before_m, left_m);
        self.approach.rebase(before_m, left_m);
        self.bounded.rebase_bounded(before_m, left_m);
    }

    /// Leaves out a time in which the robot could not make progress, seconds.
    pub fn pause(&mut self, pause_s: f64) {
        for reference in [&mut self.recent, &mut self.approach, &mut self.bounded] {
            reference.since_s += pause_s;
        }
    }
}

/// The part of a time that a robot waited for people, seconds, which does not count as time without progress.
pub(super) fn spared_s(waited_s: f64) -> f64 {
    waited_s * (1.0 - 1.0 / WAITING_PATIENCES)
}

/// The length left below which the robot makes progress.
#[derive(Clone, Debug, Default)]
struct Reference {
    least_left_m: Option<f64>,
    /// The reference where the robot was nearest to its goal, and the longest one since, metres.
    nearest_m: f64,
    longest_m: f64,
    since_s: f64,
}

impl Reference {
    /// Measures along a new path, given the lengths left on the path before and on this one, metres.
    fn rebase(&mut self, before_m: f64, left_m: f64) {
        self.least_left_m = self.rebased_m(before_m, left_m);
    }

    /// As [`Self::rebase`], but raised only by what is new.
    fn rebase_bounded(&mut self, before_m: f64, left_m: f64) {
        let (Some(least_m), Some(rebased_m)) =
            (self.least_left_m, self.rebased_m(before_m, left_m))
        else {
            return;
        };
        let new_m = (rebased_m - self.longest_m).max(0.0);
        self.longest_m += new_m;
        // A shorter path leaves it: otherwise plans of changing lengths would take away what the robot has driven.
        self.least_left_m = Some(least_m + new_m);
    }

    /// The reference on a new path: the robot may have come nearer by less than what counts, or have backed away.
    fn rebased_m(&self, before_m: f64, left_m: f64) -> Option<f64> {
        self.least_left_m.map(|least_m| left_m + (least_m - before_m).max(-MAX_RETREAT_M))
    }

    /// Updates with the length of path left and returns the time since it last shrank by `radius_m`, seconds.
    fn stuck_s(&mut self, now_s: f64, left_m: f64, radius_m: f64) -> f64 {
        let is_first = self.least_left_m.is_none();
        if self.least_left_m.is_none_or(|least_m| left_m <= least_m - radius_m) {
            (self.least_left_m, self.since_s) = (Some(left_m), now_s);
            if is_first || left_m <= self.nearest_m - radius_m {
                (self.nearest_m, self.longest_m) = (left_m, left_m);
            }
        }
        now_s - self.since_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;
    use crate::global::Path;
    use crate::navigator::Route;

    const RADIUS_M: f64 = 0.5;

    /// Seconds without progress of a robot with these lengths left, one per second, on paths that are a metre longer than the one
    /// before from the given seconds on.
    fn stuck_s(left_m: &[f64], replaced: &[usize]) -> f64 {
        let (mut progress, mut longer_m, mut stuck_s) = (Reference::default(), 0.0, 0.0);
        for (second, left_m) in left_m.iter().enumerate() {
            stuck_s = progress.stuck_s(second as f64, left_m + longer_m, RADIUS_M);
            if replaced.contains(&second) {
                progress.rebase(left_m + longer_m, left_m + longer_m + 1.0);
                longer_m += 1.0;
            }
        }
        stuck_s
    }

    #[test]
    fn new_paths_are_no_progress_and_undo_none() {
        let slow = [9.0, 8.8, 8.6, 8.4];
        let to_and_fro = [9.0, 10.0, 12.0, 9.1, 12.0, 9.1, 12.0, 8.6];
        let every_second: Vec<usize> = (0..8).collect();
        for replaced in [&[][..], &every_second] {
            assert_eq!(stuck_s(&slow, replaced), 0.0);
            assert_eq!(stuck_s(&to_and_fro, replaced), 7.0);
        }
        // A robot that was carried far back starts again.
        assert_eq!(stuck_s(&[9.0, 30.0, 25.1, 24.4], &[1]), 0.0);
    }

    /// The robot drives 0.4 m to and fro at 0.2 m/s, 10 m before its goal. Each plan begins where it was a moment ago.
    #[test]
    fn driving_to_and_fro_on_new_paths_is_no_progress() {
        let at = |tick: i32| Point::new(0.02 * f64::from((tick % 40 - 20).abs()), 0.0);
        let route_from = |start| Route::straight(Path::new(vec![start, Point::new(10.0, 0.0)]));
        let (mut route, mut progress, mut stuck_s) = (route_from(at(0)), Reference::default(), 0.0);
        for tick in 0..1200 {
            route.advance(&at(tick));
            stuck_s = progress.stuck_s(0.1 * f64::from(tick), route.left_m(), RADIUS_M);
            if tick % 5 == 4 {
                let mut next = route_from(at(tick - 1));
                next.advance(&at(tick));
                progress.rebase(route.left_m(), next.left_m());
                route = next;
            }
        }
        assert!(stuck_s > 119.0, "{stuck_s} s");
    }

    /// The robot drives half a metre along each plan. Then dust lies on it, and the next plan leads around it from there: the length
    /// left is the same as before, or up to 3 m longer. From time to time a plan is shorter again.
    #[test]
    fn detours_around_obstacles_that_come_and_go_are_no_progress() {
        let (mut progress, mut left_m, mut stuck_s) = (Reference::default(), 20.0, 0.0);
        for second in 0..200 {
            stuck_s = progress.stuck_s(f64::from(second), left_m, RADIUS_M);
            let before_m = left_m - 0.5;
            stuck_s = progress.stuck_s(f64::from(second) + 0.5, before_m, RADIUS_M).min(stuck_s);
            left_m = [20.0, 21.3, 19.7, 23.0, 20.6][second as usize % 5];
            progress.rebase_bounded(before_m, left_m);
        }
        assert!(stuck_s > 180.0, "{stuck_s} s");
    }

    /// The robot drives at 0.1 m/s among obstacles that come and go, and each second a plan is a metre longer or shorter than the one
    /// before.
    #[test]
    fn plans_of_changing_lengths_undo_no_progress() {
        let (mut progress, mut longest_s) = (Reference::default(), 0.0_f64);
        let left_m = |second: u32| 20.0 - 0.1 * f64::from(second) + f64::from(second % 2);
        for second in 0..150 {
            longest_s =
                longest_s.max(progress.stuck_s(f64::from(second), left_m(second), RADIUS_M));
            let before_m = left_m(second) - 0.1;
            progress.rebase_bounded(before_m, left_m(second + 1));
        }
        assert!(longest_s < 30.0, "{longest_s} s");
    }

    /// Plans led it to and fro, and now it drives along one of them.
    #[test]
    fn robot_that_advances_again_has_twice_the_time() {
        for (stuck_s, bounded_s, has_failed) in
            [(0.0, 91.0, false), (9.0, 179.0, false), (11.0, 91.0, true), (0.0, 181.0, true)]
        {
            let progress = Progress { stuck_s, bounded_s, ..Progress::default() };
            assert_eq!(progress.has_failed(1.0, 90.0), has_failed, "{stuck_s} {bounded_s}");
        }
    }

    #[test]
    fn robot_that_cannot_drive_ahead_makes_no_progress() {
        for behind_m in [0.0, 1.0] {
            let progress = Progress { bounded_s: 91.0, behind_m, ..Progress::default() };
            assert_eq!(progress.counted_s(0.0), 91.0);
        }
    }

    /// The robot drives at 1 m/s, and finds one passage after the other blocked; each way back is longer than all before.
    #[test]
    fn detours_after_blocked_passages_are_progress() {
        let (mut progress, mut left_m, mut time_s, mut longest_s) =
            (Progress::default(), 20.0, 0.0, 0.0_f64);
        for (drives_m, then_m) in
            [(15.0, 45.0), (20.0, 60.0), (30.0, 40.0), (15.0, 70.0), (70.0, 0.0)]
        {
            for _ in 0..(10.0 * drives_m) as u32 {
                (left_m, time_s) = (left_m - 0.1, time_s + 0.1);
                progress.update(time_s, left_m, RADIUS_M);
                longest_s = longest_s.max(progress.counted_s(1.0));
            }
            progress.rebase(left_m, then_m);
            left_m = then_m;
        }
        assert!(longest_s < 60.0, "{longest_s} s");
    }
}
