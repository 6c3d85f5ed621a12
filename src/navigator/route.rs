//! The path that the robot follows, and the key node it drives to.

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

    /// A route along a path without other key nodes, for tests.
    #[cfg(test)]
    pub(super) fn straight(path: Path) -> Self {
        Self::with_nodes(path, Vec::new(), 1.0, 0.3)
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

#[cfg(test)]
mod tests {
    use core::f64::consts::FRAC_PI_2;

    use super::*;

    #[test]
    fn heading_along_a_path_changes_at_its_corner() {
        let corner = vec![Point::new(0.0, 0.0), Point::new(1.0, 0.0), Point::new(1.0, 1.0)];
        let route = Route::straight(Path::new(corner));
        let yaws: Vec<f64> = route.poses_ahead(2.0, 0.4).map(|pose| pose.yaw).collect();
        assert_eq!(yaws, [0.0, 0.0, 0.0, FRAC_PI_2, FRAC_PI_2, FRAC_PI_2]);
    }
}
