//! Where on the path the robot is, and the key node it makes for.

use crate::geometry::Point;
use crate::global::{Path, Plan};

/// A global path with its key nodes: the local targets, taken one after the other; the last is the goal.
#[derive(Clone, Debug)]
pub struct Route {
    path: Path,
    /// Arc lengths of the key nodes, increasing; the last is the path's length.
    key_nodes_m: Vec<f64>,
    progress_m: f64,
}

/// How far back, and ahead, of the last known progress the robot is looked for on the path, metres: so that a path that
/// passes near itself is not skipped.
const SEARCH_BACK_M: f64 = 1.0;
const SEARCH_AHEAD_M: f64 = 3.0;

impl Route {
    /// The route of a plan: its key nodes are the pruned path's nodes and, where those are further apart than
    /// `spacing_m`, points between them.
    #[must_use]
    pub fn new(plan: &Plan, spacing_m: f64) -> Self {
        let path = plan.smoothed.clone();
        let length = path.length_m();
        let mut nodes: Vec<f64> = plan
            .pruned
            .points()
            .iter()
            .map(|node| path.project(node).arc_m)
            .collect();
        nodes.push(length);
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
        Self {
            path,
            key_nodes_m,
            progress_m: 0.0,
        }
    }

    /// The path.
    #[must_use]
    pub const fn path(&self) -> &Path {
        &self.path
    }

    /// The key nodes in their order; the last is the path's end.
    pub fn key_nodes(&self) -> impl Iterator<Item = Point> + '_ {
        self.key_nodes_m.iter().map(|&arc| self.path.point_at(arc))
    }

    /// Arc length reached, metres.
    #[must_use]
    pub const fn progress_m(&self) -> f64 {
        self.progress_m
    }

    /// Arc length left, metres.
    #[must_use]
    pub fn left_m(&self) -> f64 {
        self.path.length_m() - self.progress_m
    }

    /// Finds the robot on the path; returns its distance from it, metres.
    pub fn advance(&mut self, robot: &Point) -> f64 {
        let range = self.progress_m - SEARCH_BACK_M..self.progress_m + SEARCH_AHEAD_M;
        let found = self.path.project_within(robot, range);
        self.progress_m = found.arc_m;
        found.distance_m
    }

    /// The first key node at least `ahead_m` further along the path; the goal when there is none.
    #[must_use]
    pub fn key_node(&self, ahead_m: f64) -> Point {
        let from = self.progress_m + ahead_m;
        let next = self.key_nodes_m.partition_point(|&arc| arc < from);
        let arc = self
            .key_nodes_m
            .get(next)
            .copied()
            .unwrap_or(self.path.length_m());
        self.path.point_at(arc)
    }

    /// Points of the path's next `ahead_m` metres, `spacing_m` apart.
    pub fn ahead(&self, ahead_m: f64, spacing_m: f64) -> impl Iterator<Item = Point> + '_ {
        let stretch_m = ahead_m.min(self.left_m());
        let count = (stretch_m / spacing_m) as usize;
        (0..=count).map(move |index| {
            self.path
                .point_at(self.progress_m + index as f64 * spacing_m)
        })
    }
}
