//! Stretches of a path on which the heading of the robot matters.

use super::{Path, Plan, Spline, StageTimes};
use crate::geometry::Point;

/// Direction of travel along a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Travel {
    /// The robot's nose points along the path.
    Forward,
    /// The robot's tail points along the path.
    Backward,
}

/// A straight stretch of a path with so little room that the robot must hold the direction of the path. The robot turns in place
/// at its begin.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct NarrowStretch {
    /// Arc length of its begin on the smoothed path, metres.
    pub from_m: f64,
    /// Arc length of its end, metres.
    pub to_m: f64,
    /// Whether the robot drives it forwards or backwards.
    pub travel: Travel,
}

/// A part of a path with narrow stretches.
#[derive(Clone, Debug)]
pub(crate) enum Part {
    /// A path with room for every heading.
    Open(Box<Plan>),
    /// A straight line from the end of the part before.
    Narrow {
        /// Its end.
        to: Point,
        /// Direction of travel.
        travel: Travel,
    },
}

/// Joins parts, each of which begins where the one before it ends.
pub(crate) fn joined(start: Point, parts: Vec<Part>) -> Plan {
    let mut stages = [vec![start], vec![start], vec![start]];
    let (mut ends, mut expanded, mut time_s) = (Vec::new(), 0, StageTimes::default());
    for part in parts {
        match part {
            Part::Open(plan) => {
                for (points, path) in stages.iter_mut().zip([plan.raw, plan.pruned, plan.smoothed])
                {
                    path.points().iter().for_each(|&point| push(points, point));
                }
                (expanded, time_s) = (expanded + plan.expanded, time_s + plan.time_s);
            }
            Part::Narrow { to, travel } => {
                let first = stages[2].len() - 1;
                stages.iter_mut().for_each(|points| push(points, to));
                ends.push((first, stages[2].len() - 1, travel));
            }
        }
    }
    let [raw, pruned, smoothed] = stages;
    let arc_m = |last: usize| Path::new(smoothed[..=last].to_vec()).length_m();
    let narrow = ends
        .iter()
        .map(|&(first, last, travel)| NarrowStretch {
            from_m: arc_m(first),
            to_m: arc_m(last),
            travel,
        })
        .collect();
    Plan {
        raw: Path::new(raw),
        pruned: Path::new(pruned),
        spline: Spline::polyline(&smoothed),
        smoothed: Path::new(smoothed),
        narrow,
        expanded,
        time_s,
    }
}

/// Appends a point that differs from the last one.
fn push(points: &mut Vec<Point>, point: Point) {
    if points.last() != Some(&point) {
        points.push(point);
    }
}
