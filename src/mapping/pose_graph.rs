//! Pose graph optimisation: the poses that agree best with measured relative poses.
//!
//! Gauss-Newton steps on the sum of squared errors, weighted by information (Grisetti, Kuemmerle, Stachniss and Burgard, "A
//! Tutorial on Graph-Based SLAM", IEEE Intelligent Transportation Systems Magazine, 2010). Edges that may be wrong are scaled
//! down as far as they contradict the others (Agarwal, Tipaldi, Spinello, Stachniss and Burgard, "Robust Map Optimization using
//! Dynamic Covariance Scaling", ICRA 2013). A sparse Cholesky factorisation solves each step. All sums run in a fixed order.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, Matrix3, Vector3};
use nalgebra_sparse::factorization::CscCholesky;
use nalgebra_sparse::{CooMatrix, CscMatrix};

use crate::geometry::{Pose, wrap_angle};

/// Largest number of steps.
const MAX_STEPS: usize = 30;
/// Poses that move by less than this in a step have converged, metres and radians.
const CONVERGED: f64 = 1e-5;
/// Squared error in standard deviations from which an edge that may be wrong is scaled down.
const SCALED_FROM: f64 = 10.0;

/// A measured relative pose of two nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub from: usize,
    pub to: usize,
    /// The second node's pose in the frame of the first.
    pub motion: Pose,
    /// Information of x, y and yaw in the frame of the first node.
    pub information: Matrix3<f64>,
    /// Whether the edge may be wrong: a closed loop.
    pub is_uncertain: bool,
}

impl Edge {
    /// The error at the nodes' poses.
    fn error(&self, from: &Pose, to: &Pose) -> Vector3<f64> {
        let motion = from.inverse_transform_pose(to);
        Vector3::new(
            motion.x - self.motion.x,
            motion.y - self.motion.y,
            wrap_angle(motion.yaw - self.motion.yaw),
        )
    }

    /// The factor of the information at an error, 0 to 1.
    fn scale(&self, error: &Vector3<f64>) -> f64 {
        if !self.is_uncertain {
            return 1.0;
        }
        let squared = error.dot(&(self.information * error));
        let root = (2.0 * SCALED_FROM / (SCALED_FROM + squared)).min(1.0);
        root * root
    }
}

/// Moves poses to where the edges agree best. The first pose stays. Poses stay as they are where the equations have no
/// solution.
pub(super) fn optimize(poses: &mut [Pose], edges: &[Edge]) {
    if poses.len() < 2 {
        return;
    }
    let order = elimination_order(poses.len(), edges);
    let mut place = vec![0; poses.len()];
    for (index, &node) in order.iter().enumerate() {
        place[node] = index;
    }
    for _ in 0..MAX_STEPS {
        let Some(step) = step(poses, edges, &place) else {
            return;
        };
        let mut largest = 0.0_f64;
        for (node, pose) in poses.iter_mut().enumerate().skip(1) {
            let [dx, dy, turn] = [0, 1, 2].map(|axis| step[(3 * place[node] + axis, 0)]);
            largest = largest.max(dx.abs()).max(dy.abs()).max(turn.abs());
            *pose = Pose::new(pose.x + dx, pose.y + dy, wrap_angle(pose.yaw + turn));
        }
        if largest < CONVERGED {
            return;
        }
    }
}

/// A Gauss-Newton step: three numbers for each node, at its place in the order of elimination.
fn step(poses: &[Pose], edges: &[Edge], place: &[usize]) -> Option<DMatrix<f64>> {
    let size = 3 * poses.len();
    let mut hessian = CooMatrix::new(size, size);
    let mut gradient = DMatrix::zeros(size, 1);
    let mut add_block = |row: usize, column: usize, block: &Matrix3<f64>| {
        for r in 0..3 {
            for c in 0..3 {
                hessian.push(3 * place[row] + r, 3 * place[column] + c, block[(r, c)]);
            }
        }
    };
    for edge in edges {
        let (from, to) = (&poses[edge.from], &poses[edge.to]);
        let error = edge.error(from, to);
        let information = edge.information * edge.scale(&error);
        let (sin, cos) = libm::sincos(from.yaw);
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        let of_to = Matrix3::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0);
        let of_from = Matrix3::new(
            -cos,
            -sin,
            -sin * dx + cos * dy,
            sin,
            -cos,
            -cos * dx - sin * dy,
            0.0,
            0.0,
            -1.0,
        );
        let ends = [(edge.from, of_from), (edge.to, of_to)];
        for (row, of_row) in &ends {
            for (column, of_column) in &ends {
                add_block(*row, *column, &(of_row.transpose() * information * of_column));
            }
            let part = of_row.transpose() * information * error;
            for axis in 0..3 {
                gradient[(3 * place[*row] + axis, 0)] -= part[axis];
            }
        }
    }
    // The first pose stays; a little is added to all others, which edges may leave undetermined.
    for node in 0..poses.len() {
        add_block(node, node, &(Matrix3::identity() * if node == 0 { 1e12 } else { 1e-6 }));
    }
    let factor = CscCholesky::factor(&CscMatrix::from(&hessian)).ok()?;
    let step = factor.solve(&gradient);
    step.iter().all(|value| value.is_finite()).then_some(step)
}

/// An order of the nodes in which elimination adds few entries: each time a node with the fewest neighbours.
fn elimination_order(nodes: usize, edges: &[Edge]) -> Vec<usize> {
    let mut neighbours = vec![BTreeSet::new(); nodes];
    for edge in edges.iter().filter(|edge| edge.from != edge.to) {
        neighbours[edge.from].insert(edge.to);
        neighbours[edge.to].insert(edge.from);
    }
    let mut by_degree: BTreeSet<(usize, usize)> =
        neighbours.iter().enumerate().map(|(node, near)| (near.len(), node)).collect();
    let mut order = Vec::with_capacity(nodes);
    while let Some((_, node)) = by_degree.pop_first() {
        order.push(node);
        let near = core::mem::take(&mut neighbours[node]);
        for &one in &near {
            by_degree.remove(&(neighbours[one].len(), one));
            neighbours[one].remove(&node);
            neighbours[one].extend(near.iter().filter(|&&other| other != one));
            by_degree.insert((neighbours[one].len(), one));
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 40 nodes, one metre apart, whose measured motions turn too little, and a last edge that closes it.
    fn square(is_uncertain: bool, closing: Pose) -> (Vec<Pose>, Vec<Edge>) {
        let mut poses = vec![Pose::default()];
        let mut edges = Vec::new();
        for node in 1..40 {
            let turn = if node % 10 == 0 { core::f64::consts::FRAC_PI_2 - 0.02 } else { 0.0 };
            let motion = Pose::new(1.0, 0.0, turn);
            let information = Matrix3::from_diagonal(&Vector3::new(1e4, 1e4, 1e4));
            let from = node - 1;
            edges.push(Edge { from, to: node, motion, information, is_uncertain: false });
            poses.push(poses[from].transform_pose(&motion));
        }
        let information = Matrix3::identity() * 1e6;
        edges.push(Edge { from: 39, to: 0, motion: closing, information, is_uncertain });
        (poses, edges)
    }

    #[test]
    fn closed_loop_distributes_the_error() {
        let closing = Pose::new(1.0, 0.0, core::f64::consts::FRAC_PI_2);
        let (mut poses, edges) = square(false, closing);
        let before = edges[39].error(&poses[39], &poses[0]).norm();
        optimize(&mut poses, &edges);
        assert!(before > 0.3, "{before}");
        assert!(edges[39].error(&poses[39], &poses[0]).norm() < 0.01);
        assert_eq!(poses[0], Pose::default());
        // The gradient is zero, by differences of the sum of squares.
        let cost = |poses: &[Pose]| -> f64 {
            edges
                .iter()
                .map(|edge| {
                    let error = edge.error(&poses[edge.from], &poses[edge.to]);
                    error.dot(&(edge.information * error))
                })
                .sum()
        };
        let at = cost(&poses);
        for node in [1, 17, 39] {
            for (dx, dy, turn) in [(1e-4, 0.0, 0.0), (0.0, 1e-4, 0.0), (0.0, 0.0, 1e-4)] {
                let mut moved = poses.clone();
                let pose = moved[node];
                moved[node] = Pose::new(pose.x + dx, pose.y + dy, pose.yaw + turn);
                assert!(cost(&moved) >= at, "node {node}: {} below {at}", cost(&moved));
            }
        }
    }

    #[test]
    fn wrong_loop_is_scaled_down() {
        let wrong = Pose::new(9.0, 4.0, 0.0);
        let (start, edges) = square(true, wrong);
        let mut poses = start.clone();
        optimize(&mut poses, &edges);
        let moved = |node: usize| (poses[node].position() - start[node].position()).norm();
        assert!((0..40).map(moved).fold(0.0, f64::max) < 0.2);
        // As a certain edge it bends the square.
        let (mut poses, edges) = square(false, wrong);
        optimize(&mut poses, &edges);
        assert!((poses[39].position() - start[39].position()).norm() > 1.0);
    }
}
