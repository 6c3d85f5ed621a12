//! Where on the path the robot is, and the key node it makes for.

use super::{NavigatorFeatures, NavigatorSettings};
use crate::geometry::Point;
use crate::global::{Path, Plan};

/// A global path with its key nodes: the local targets, taken one after the other; the last is the goal.
#[derive(Clone, Debug)]
pub struct Route {
    path: Path,
    /// Arc lengths of the key nodes, increasing; the last is the path's length.
    key_nodes_m: Vec<f64>,
    progress_m: f64,
    /// Key nodes touched so far, where that is what counts.
    touched: Option<usize>,
}

/// How far back, and ahead, of the last known progress the robot is looked for on the path, metres: so that a path that
/// passes near itself is not skipped.
const SEARCH_BACK_M: f64 = 1.0;
const SEARCH_AHEAD_M: f64 = 3.0;
/// A key node this near is touched, metres. The paper does not say when it is.
const TOUCH_M: f64 = 0.5;

impl Route {
    /// The route of a plan: its key nodes are the pruned path's nodes and, where those are further apart than the settings
    /// allow, points between them. Fewer nodes, or only the goal, where the features say so.
    #[must_use]
    pub fn new(plan: &Plan, settings: &NavigatorSettings) -> Self {
        let NavigatorFeatures {
            global_path,
            progress,
            ..
        } = settings.features;
        if !global_path {
            let ends = plan.raw.points();
            let straight = Path::new(vec![ends[0], ends[ends.len() - 1]]);
            return Self::with_nodes(straight, Vec::new(), f64::INFINITY);
        }
        let path = plan.smoothed.clone();
        let nodes = plan.pruned.points().iter();
        let nodes = nodes.map(|node| path.project(node).arc_m).collect();
        if progress {
            return Self::with_nodes(path, nodes, settings.key_node_spacing_m);
        }
        Self {
            touched: Some(0),
            ..Self::with_nodes(path, nodes, f64::INFINITY)
        }
    }

    fn with_nodes(path: Path, mut nodes: Vec<f64>, spacing_m: f64) -> Self {
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
        Self {
            path,
            key_nodes_m,
            progress_m: 0.0,
            touched: None,
        }
    }

    /// The path.
    #[must_use]
    pub const fn path(&self) -> &Path {
        &self.path
    }

    /// The key nodes in order, the goal last.
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
        if let Some(touched) = &mut self.touched {
            let is_touched = |&&arc: &&f64| (self.path.point_at(arc) - robot).norm() <= TOUCH_M;
            *touched += self.key_nodes_m[*touched..]
                .iter()
                .take_while(is_touched)
                .count();
        }
        let range = self.progress_m - SEARCH_BACK_M..self.progress_m + SEARCH_AHEAD_M;
        let found = self.path.project_within(robot, range);
        self.progress_m = found.arc_m;
        found.distance_m
    }

    /// The key node to make for: of those from the first at least `nearest_m` further along the path to the first at least
    /// `farthest_m`, the last that is in sight, or the first of them; but the first that was not touched where that is what
    /// counts; the goal when there is none.
    #[must_use]
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
        candidates
            .into_iter()
            .find(in_sight)
            .unwrap_or_else(|| node(nearest))
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
