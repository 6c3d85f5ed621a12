//! Relations between poses as ground truth, and the errors of a trajectory against them.

use std::path::{Path, PathBuf};

use serde::Serialize;
use thiserror::Error;

use super::by_time::ByTime;
use super::errors::difference;
use super::{ErrorStatistics, TimedPose};
use crate::geometry::{Pose, wrap_angle};
use crate::input_file::{InputFileError, read_text};

/// The motion of the robot between two times, as a person aligned the scans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relation {
    /// Times of the first and second pose, seconds.
    pub times_s: [f64; 2],
    /// The second pose in the frame of the first.
    pub motion: Pose,
}

/// A file of relations that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum RelationFileError {
    /// A file that cannot be read as text.
    #[error("{}: {problem}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The problem.
        problem: InputFileError,
    },
    /// A line that is no relation.
    #[error("{}: line {line}: not eight finite numbers: write t1 t2 x y z roll pitch yaw", path.display())]
    BadLine {
        /// The file.
        path: PathBuf,
        /// Line number, from one.
        line: usize,
    },
}

/// Reads a file with one relation per line: two times, x, y, z, roll, pitch, yaw; metres, radians, seconds. Motion in the
/// plane is used. Empty lines and lines that begin with `#` are skipped.
///
/// # Errors
/// Returns an error if the file cannot be read or a line is no relation.
pub fn read_relations(path: &Path) -> Result<Vec<Relation>, RelationFileError> {
    let text = read_text(path)
        .map_err(|problem| RelationFileError::Unreadable { path: path.to_path_buf(), problem })?;
    let mut relations = Vec::new();
    for (index, line) in text.lines().enumerate() {
        if line.trim().is_empty() || line.trim_start().starts_with('#') {
            continue;
        }
        let numbers: Option<Vec<f64>> = line
            .split_whitespace()
            .map(|word| word.parse().ok().filter(|number: &f64| number.is_finite()))
            .collect();
        let numbers: Option<[f64; 8]> = numbers.and_then(|numbers| numbers.try_into().ok());
        let Some([from_s, to_s, x, y, _, _, _, yaw]) = numbers else {
            return Err(RelationFileError::BadLine { path: path.to_path_buf(), line: index + 1 });
        };
        let motion = Pose::new(x, y, wrap_angle(yaw));
        relations.push(Relation { times_s: [from_s, to_s], motion });
    }
    Ok(relations)
}

/// Errors of a trajectory against relations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RelationError {
    /// Number of relations whose both times are on the trajectory.
    pub relations: usize,
    /// Distances, metres.
    pub translation_m: ErrorStatistics,
    /// Angles, degrees, as they are published.
    pub rotation_deg: ErrorStatistics,
}

/// Compares the motions of a trajectory with relations. A pose belongs to a time if its own time plus `offset_s` is the
/// nearest one and differs by at most `tolerance_s`. None if no relation has both poses.
#[must_use]
pub fn relation_error(
    trajectory: &[TimedPose],
    relations: &[Relation],
    offset_s: f64,
    tolerance_s: f64,
) -> Option<RelationError> {
    // Stamps of real logs go back at times. A later pose of the same time follows the scan, and stays last.
    let ordered = ByTime::new(trajectory, offset_s);
    let pose_at = |time_s: f64| {
        let (nearest, gap_s) = ordered.nearest(time_s)?;
        (gap_s <= tolerance_s).then_some(nearest.pose)
    };
    let errors = relations.iter().filter_map(|relation| {
        let (from, to) = (pose_at(relation.times_s[0])?, pose_at(relation.times_s[1])?);
        Some(difference(&relation.motion, &from.inverse_transform_pose(&to)))
    });
    let (distances, angles): (Vec<f64>, Vec<f64>) =
        errors.map(|(distance_m, angle)| (distance_m, angle.to_degrees())).unzip();
    Some(RelationError {
        relations: distances.len(),
        translation_m: ErrorStatistics::of(distances)?,
        rotation_deg: ErrorStatistics::of(angles)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trajectory() -> Vec<TimedPose> {
        let pose = |step: usize| {
            let along = 0.05 * step as f64;
            Pose::new(along, libm::sin(along), wrap_angle(0.7 * along))
        };
        (0..300).map(|step| TimedPose { time_s: 0.1 * step as f64, pose: pose(step) }).collect()
    }

    /// Relations with known errors: 0.03 m forward for even ones, 0.01 rad for odd ones.
    fn relations(of: &[TimedPose]) -> Vec<Relation> {
        let relation = |index: usize| {
            let (from, to) = (&of[index], &of[(index * 37 + 11) % of.len()]);
            let wrong = if index.is_multiple_of(2) {
                Pose::new(-0.03, 0.0, 0.0)
            } else {
                Pose::new(0.0, 0.0, 0.01)
            };
            let motion = from.pose.inverse_transform_pose(&to.pose).transform_pose(&wrong);
            Relation { times_s: [from.time_s + 1000.0, to.time_s + 1000.0], motion }
        };
        (0..300).map(relation).collect()
    }

    /// Means by homogeneous matrices: the error is the inverse of the relation times the estimated motion.
    fn naive_means(trajectory: &[TimedPose], relations: &[Relation]) -> (f64, f64) {
        let matrix = |pose: &Pose| {
            let (s, c) = libm::sincos(pose.yaw);
            nalgebra::Matrix3::new(c, -s, pose.x, s, c, pose.y, 0.0, 0.0, 1.0)
        };
        let (mut distance, mut angle) = (0.0, 0.0);
        for relation in relations {
            let at = |time_s: f64| {
                let found = trajectory.iter().find(|it| (it.time_s + 1000.0 - time_s).abs() < 1e-6);
                matrix(&found.expect("the time is there").pose)
            };
            let [from, to] = relation.times_s.map(at);
            let inverse = |it: nalgebra::Matrix3<f64>| it.try_inverse().expect("a rigid motion");
            let error = inverse(matrix(&relation.motion)) * inverse(from) * to;
            distance += (error[(0, 2)].powi(2) + error[(1, 2)].powi(2)).sqrt();
            angle += libm::atan2(error[(1, 0)], error[(0, 0)]).abs().to_degrees();
        }
        (distance / relations.len() as f64, angle / relations.len() as f64)
    }

    fn agrees(computed: &[TimedPose], checked: &[TimedPose], relations: &[Relation]) -> bool {
        let error = relation_error(computed, relations, 1000.0, 0.01).expect("all are there");
        let (distance, angle) = naive_means(checked, relations);
        error.relations == relations.len()
            && (error.translation_m.mean - distance).abs() < 1e-9
            && (error.rotation_deg.mean - angle).abs() < 1e-6
    }

    #[test]
    fn relation_error_equals_that_by_matrices() {
        let trajectory = trajectory();
        let relations = relations(&trajectory);
        assert!(agrees(&trajectory, &trajectory, &relations));
        let error = relation_error(&trajectory, &relations, 1000.0, 0.01).expect("all are there");
        assert!((error.translation_m.mean - 0.015).abs() < 1e-9, "{error:?}");
        assert!((error.translation_m.sd - 0.015).abs() < 1e-9, "{error:?}");
        assert!((error.rotation_deg.mean - 0.005_f64.to_degrees()).abs() < 1e-9, "{error:?}");
    }

    #[test]
    fn one_wrong_pose_is_seen_by_the_matrices() {
        let right = trajectory();
        let relations = relations(&right);
        let mut wrong = right.clone();
        wrong[100].pose.y += 0.02;
        assert!(!agrees(&wrong, &right, &relations));
        // A time that is off by more than the tolerance has no pose.
        wrong[100].time_s += 0.05;
        let error = relation_error(&wrong, &relations, 1000.0, 0.01).expect("most are there");
        assert!(error.relations < relations.len());
    }

    #[test]
    fn bad_line_of_relations_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.relations");
        std::fs::write(&path, "# two\n1 2 0.5 0 0 0 0 0.1\n1 2 0.5 0 0 0 0\n").expect("written");
        let error = read_relations(&path).expect_err("a number is missing");
        assert!(error.to_string().contains("line 3: not eight finite numbers"), "{error}");
        std::fs::write(&path, "1 2 0.5 0 0 0 0 0.1\n").expect("written");
        let relations = read_relations(&path).expect("it is complete");
        assert_eq!(relations[0].motion, Pose::new(0.5, 0.0, 0.1));
    }
}
