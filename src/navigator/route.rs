//! The path that the robot follows, the key node it drives to, and its progress.

use super::{NavigatorFeatures, NavigatorSettings};
use crate::geometry::{Point, Pose};
use crate::global::{Path, Plan};

/// A global path with its key nodes. They are the local targets, one after the other; the last one is the goal.
#[derive(Clone, Debug)]
pub(crate) struct Route {
    pub(super) path: Path,
    /// Distance that the path keeps from obstacles, metres.
    pub(super) radius_m: f64,
    /// Arc lengths of the key nodes, metres, increasing; the last is the path's length.
    key_nodes_m: Vec<f64>,
    /// Arc length that the robot has reached, metres.
    pub(super) progress_m: f64,
    /// Distance of a robot behind the start of the path from it, metres: a path begins where the robot was when it was requested.
    behind_m: f64,
    /// Number of key nodes touched so far; `None` where progress along the path counts.
    touched: Option<usize>,
}

/// The robot is searched on the path within these distances back and ahead of its last progress, metres: a path may pass near
/// itself.
const SEARCH_BACK_M: f64 = 1.0;
const SEARCH_AHEAD_M: f64 = 3.0;
/// At most so much of the way back counts as no progress, metres: escapes are shorter, and a robot that was carried starts again.
const MAX_RETREAT_M: f64 = 5.0;
/// Distance at which a key node is touched, metres. The paper gives none.
const TOUCH_M: f64 = 0.5;

impl Route {
    /// The route of a plan. Its key nodes are the nodes of the pruned path, and points between them at most
    /// `key_node_spacing_m` apart. Without some features there are fewer nodes, or only the goal.
    pub fn new(plan: &Plan, settings: &NavigatorSettings) -> Self {
        let NavigatorFeatures { global_path, progress, .. } = settings.features;
        if !global_path {
            let ends = plan.raw.points();
            let straight = Path::new(vec![ends[0], ends[ends.len() - 1]]);
            return Self::with_nodes(straight, Vec::new(), f64::INFINITY, plan.radius_m);
        }
        let path = plan.smoothed.clone();
        let nodes = plan.pruned.points().iter();
        let nodes = nodes.map(|node| path.project(node).arc_m).collect();
        if progress {
            return Self::with_nodes(path, nodes, settings.key_node_spacing_m, plan.radius_m);
        }
        Self { touched: Some(0), ..Self::with_nodes(path, nodes, f64::INFINITY, plan.radius_m) }
    }

    fn with_nodes(path: Path, mut nodes: Vec<f64>, spacing_m: f64, radius_m: f64) -> Self {
        nodes.push(path.length_m());
        nodes.sort_by(f64::total_cmp);
        let mut key_nodes_m = Vec::new();
        let mut last = 0.0;
        for node in nodes {
            let pieces = ((node - last) / spacing_m).ceil().max(1.0);
            let between =
                (1..=pieces as usize).map(|piece| last + (node - last) * piece as f64 / pieces);
            key_nodes_m.extend(between);
            last = node;
        }
        Self { path, radius_m, key_nodes_m, progress_m: 0.0, behind_m: 0.0, touched: None }
    }

    /// The key nodes in order, the goal last.
    #[cfg(feature = "experiment")]
    pub fn key_nodes(&self) -> impl Iterator<Item = Point> + '_ {
        self.key_nodes_m.iter().map(|&arc| self.path.point_at(arc))
    }

    /// Length of the way left along the path, metres.
    pub fn left_m(&self) -> f64 {
        self.behind_m + self.path.length_m() - self.progress_m
    }

    /// Updates the progress of the robot and returns its distance from the path, metres.
    pub fn advance(&mut self, robot: &Point) -> f64 {
        if let Some(touched) = &mut self.touched {
            let is_touched = |&&arc: &&f64| (self.path.point_at(arc) - robot).norm() <= TOUCH_M;
            *touched += self.key_nodes_m[*touched..].iter().take_while(is_touched).count();
        }
        let range = self.progress_m - SEARCH_BACK_M..self.progress_m + SEARCH_AHEAD_M;
        let found = self.path.project_within(robot, range);
        self.progress_m = found.arc_m;
        self.behind_m = if found.arc_m > 0.0 { 0.0 } else { found.distance_m };
        found.distance_m
    }

    /// The key node to drive to. The candidates are those from the first at least `nearest_m` further along the path to the
    /// first at least `farthest_m`. Returns the last candidate in sight, else the first candidate. Where touched nodes count
    /// instead of progress, returns the first that is not touched. Returns the goal where there is no such node.
    pub fn key_node(
        &self,
        nearest_m: f64,
        farthest_m: f64,
        in_sight: impl Fn(&Point) -> bool,
    ) -> Point {
        let last = self.key_nodes_m.len() - 1;
        let node = |index: usize| self.path.point_at(self.key_nodes_m[index]);
        if let Some(touched) = self.touched {
            return node(touched.min(last));
        }
        let first_after = |ahead_m: f64| {
            let from = self.progress_m + ahead_m;
            let next = self.key_nodes_m.partition_point(|&arc| arc < from);
            next.min(last)
        };
        let nearest = first_after(nearest_m);
        let candidates = (nearest..=first_after(farthest_m)).rev().map(node);
        candidates.into_iter().find(in_sight).unwrap_or_else(|| node(nearest))
    }

    /// Points on the next `ahead_m` metres of the path, `spacing_m` apart.
    pub fn ahead(&self, ahead_m: f64, spacing_m: f64) -> impl Iterator<Item = Point> + '_ {
        self.arcs_ahead(ahead_m, spacing_m).map(|arc_m| self.path.point_at(arc_m))
    }

    /// The same points, with the heading along the path there.
    pub fn poses_ahead(&self, ahead_m: f64, spacing_m: f64) -> impl Iterator<Item = Pose> + '_ {
        self.arcs_ahead(ahead_m, spacing_m).map(|arc_m| {
            let (at, along) = (self.path.point_at(arc_m), self.path.direction_at(arc_m));
            Pose::new(at.x, at.y, libm::atan2(along.y, along.x))
        })
    }

    fn arcs_ahead(&self, ahead_m: f64, spacing_m: f64) -> impl Iterator<Item = f64> + use<> {
        let (from_m, length_m) = (self.progress_m, self.path.length_m());
        let count = (ahead_m.min(length_m - from_m) / spacing_m) as usize;
        (0..=count).map(move |index| from_m + index as f64 * spacing_m)
    }
}

/// Measures the time since the last progress along the path, as Nav2's progress checker.
#[derive(Clone, Debug, Default)]
pub(super) struct ProgressChecker {
    least_left_m: Option<f64>,
    since_s: f64,
    /// Time since then for which the robot waited for people, seconds.
    pub waited_s: f64,
}

impl ProgressChecker {
    /// Measures along a new path from now on, given the lengths left on the path before and on this one, metres. A new path alone is
    /// no progress, and undoes none: the robot may have come nearer by less than what counts, or have backed away.
    pub fn rebase(&mut self, before_m: f64, left_m: f64) {
        let gained_m = self.least_left_m.map_or(0.0, |least_m| least_m - before_m);
        self.least_left_m = Some(left_m + gained_m.max(-MAX_RETREAT_M));
    }

    /// Leaves out a time in which the robot could not make progress, seconds.
    pub fn pause(&mut self, pause_s: f64) {
        self.since_s += pause_s;
    }

    /// Updates with the length of path left and returns the time since it last shrank by `radius_m`, seconds.
    pub fn stuck_s(&mut self, now_s: f64, left_m: f64, radius_m: f64) -> f64 {
        if self.least_left_m.is_none_or(|least| left_m <= least - radius_m) {
            *self = Self { least_left_m: Some(left_m), since_s: now_s, ..Self::default() };
        }
        now_s - self.since_s
    }
}

/// Measures how long a condition has held without a break.
#[derive(Clone, Debug, Default)]
pub(super) struct ConditionTimer(Option<f64>);

impl ConditionTimer {
    /// Seconds since `holds` became true; zero while it is false.
    pub fn update(&mut self, now_s: f64, holds: bool) -> f64 {
        if !holds {
            self.0 = None;
            return 0.0;
        }
        now_s - *self.0.get_or_insert(now_s)
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::FRAC_PI_2;

    use super::*;

    const RADIUS_M: f64 = 0.5;

    /// Seconds without progress of a robot with these lengths left, one per second, on paths that are a metre longer than the one
    /// before from the given seconds on.
    fn stuck_s(left_m: &[f64], replaced: &[usize]) -> f64 {
        let (mut progress, mut longer_m, mut stuck_s) = (ProgressChecker::default(), 0.0, 0.0);
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
        let route_from = |start| {
            let path = Path::new(vec![start, Point::new(10.0, 0.0)]);
            Route::with_nodes(path, Vec::new(), 1.0, 0.3)
        };
        let (mut route, mut progress, mut stuck_s) =
            (route_from(at(0)), ProgressChecker::default(), 0.0);
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

    #[test]
    fn heading_along_a_path_changes_at_its_corner() {
        let corner = vec![Point::new(0.0, 0.0), Point::new(1.0, 0.0), Point::new(1.0, 1.0)];
        let route = Route::with_nodes(Path::new(corner), Vec::new(), 1.0, 0.3);
        let yaws: Vec<f64> = route.poses_ahead(2.0, 0.4).map(|pose| pose.yaw).collect();
        assert_eq!(yaws, [0.0, 0.0, 0.0, FRAC_PI_2, FRAC_PI_2, FRAC_PI_2]);
    }
}
