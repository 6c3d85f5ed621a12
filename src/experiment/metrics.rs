//! Figures of the motion of a drive, from its true trace.

use super::RunRow;
use super::group::mean;
use super::outcome::gap_to_moving_m;
use crate::geometry::{Point, Vector, wrap_angle};
use crate::global::Path;
use crate::robot::{Footprint, TrackedDrive};
use crate::runtime::{Trace, TraceRow};

/// The robot is near an obstacle below this gap, metres: our choice for MRPB's safe distance, which is a parameter there.
const NEAR_M: f64 = 0.3;
/// Distances that people keep from others, metres: the outer edges of the intimate, personal and social space (Hall 1966).
const SPACES_M: [f64; 3] = [0.45, 1.2, 3.6];
/// Distance between the three points whose circle gives the curvature, metres. Shorter distances would measure noise.
const CURVATURE_STEP_M: f64 = 0.2;
/// A contact that is farther away than this is none, seconds.
const FARTHEST_CONTACT_S: f64 = 10.0;

impl RunRow {
    /// Fills in the figures of the motion from a trace with this time between two rows, seconds. A figure is none where the drive
    /// is too short for it.
    pub(super) fn fill_motion(
        &mut self,
        trace: &Trace,
        footprint: &Footprint,
        drive: &TrackedDrive,
        period_s: f64,
    ) {
        let rows = &trace.rows;
        let share = |count: usize| (!rows.is_empty()).then(|| count as f64 / rows.len() as f64);
        let changes = rows.windows(2).map(|pair| pair[1].twist.linear - pair[0].twist.linear);
        let jerks = rows.windows(3).map(|three| {
            let [before, now, after] = [0, 1, 2].map(|index: usize| three[index].twist.linear);
            (after - 2.0 * now + before) / (period_s * period_s)
        });
        let turned_rad: f64 =
            rows.windows(2).map(|pair| wrap_angle(pair[1].pose.yaw - pair[0].pose.yaw).abs()).sum();
        let driven_m = trace.travelled_m();
        self.near_share = share(rows.iter().filter(|row| row.gap_m < NEAR_M).count());
        self.speed_change_m_s2 = mean(changes.map(f64::abs)).map(|change| change / period_s);
        self.jerk_rms_m_s3 = mean(jerks.map(|jerk| jerk * jerk)).map(f64::sqrt);
        self.control_effort_m_s2 = control_effort_m_s2(rows, drive, period_s);
        self.drive_work_j_per_kg = drive_work_j_per_kg(rows, drive);
        self.off_path_rms_m = off_path_rms_m(trace);
        self.angle_per_m = (driven_m > 0.0).then(|| turned_rad / driven_m);
        self.curvature_per_m = mean_curvature(rows);
        self.least_time_to_contact_s = least_time_to_contact_s(trace, footprint, period_s);
        if trace.moving_radii.is_empty() {
            return;
        }
        let gap_m = |row| gap_to_moving_m(row, &trace.moving_radii, footprint);
        let gaps_m: Vec<f64> = rows.iter().filter_map(gap_m).collect();
        let within = |space_m: f64| share(gaps_m.iter().filter(|gap_m| **gap_m < space_m).count());
        [self.intimate_share, self.personal_share, self.social_share] = SPACES_M.map(within);
    }
}

fn control_effort_m_s2(rows: &[TraceRow], drive: &TrackedDrive, period_s: f64) -> Option<f64> {
    let squares = rows.windows(2).map(|pair| {
        let [before, now] = [0, 1].map(|index: usize| drive.tracks(&pair[index].command));
        let changes = now.zip(before, |now, before| ((now - before) / period_s).powi(2));
        f64::midpoint(changes.left, changes.right)
    });
    mean(squares).map(f64::sqrt)
}

fn drive_work_j_per_kg(rows: &[TraceRow], drive: &TrackedDrive) -> Option<f64> {
    let works = rows.windows(2).map(|pair| {
        let [before, now] = [0, 1].map(|index: usize| drive.tracks(&pair[index].twist));
        let gains = now.zip(before, |now, before| (now * now - before * before).max(0.0) / 2.0);
        f64::midpoint(gains.left, gains.right)
    });
    (rows.len() > 1).then(|| works.sum())
}

fn off_path_rms_m(trace: &Trace) -> Option<f64> {
    let paths: Vec<Option<Path>> = trace
        .paths
        .iter()
        .map(|points| (!points.is_empty()).then(|| Path::new(points.clone())))
        .collect();
    let squares = trace.rows.iter().filter_map(|row| {
        let path = paths.get(row.path)?.as_ref()?;
        Some(path.project(&row.pose.position()).distance_m.powi(2))
    });
    mean(squares).map(f64::sqrt)
}

/// The mean of Menger's curvature: four times the area of a triangle over the product of its sides.
fn mean_curvature(rows: &[TraceRow]) -> Option<f64> {
    let mut points: Vec<Point> = Vec::new();
    for row in rows {
        let point = row.pose.position();
        if points.last().is_none_or(|last| (point - last).norm() >= CURVATURE_STEP_M) {
            points.push(point);
        }
    }
    mean(points.windows(3).map(|three| {
        let (one, next) = (three[1] - three[0], three[2] - three[1]);
        let sides = one.norm() * next.norm() * (three[2] - three[0]).norm();
        if sides > 0.0 { 2.0 * one.perp(&next).abs() / sides } else { 0.0 }
    }))
}

/// The circle around the robot's origin that contains its body stands for it.
fn least_time_to_contact_s(trace: &Trace, footprint: &Footprint, period_s: f64) -> Option<f64> {
    let mut least_s: Option<f64> = None;
    for pair in trace.rows.windows(2) {
        let (row, next) = (&pair[0], &pair[1]);
        let own = (next.pose.position() - row.pose.position()) / period_s;
        let places = row.moving.iter().zip(&next.moving).zip(&trace.moving_radii);
        for ((center, after), radius_m) in places {
            let (Some(center), Some(after)) = (center, after) else { continue };
            let away = *center - row.pose.position();
            let velocity = (*after - *center) / period_s - own;
            let reach_m = radius_m + footprint.body_radius_m();
            let found_s = time_to_contact_s(&away, &velocity, reach_m);
            least_s = found_s.into_iter().chain(least_s).reduce(f64::min);
        }
    }
    least_s.filter(|time_s| *time_s <= FARTHEST_CONTACT_S)
}

/// The time until two points that are apart by `away` and move by this relative velocity are within a distance; none where
/// they never are.
fn time_to_contact_s(away: &Vector, velocity: &Vector, within_m: f64) -> Option<f64> {
    let apart = away.norm_squared() - within_m * within_m;
    if apart <= 0.0 {
        return Some(0.0);
    }
    let (speed_squared, closing) = (velocity.norm_squared(), -away.dot(velocity));
    let discriminant = closing * closing - speed_squared * apart;
    (closing > 0.0 && discriminant >= 0.0).then(|| apart / (closing + discriminant.sqrt()))
}

/// Success weighted by path length (Anderson et al. 2018): the least length over the greater one of this and the driven one, or
/// zero without success.
pub(super) fn weighted_success(reached: bool, least: f64, actual: f64) -> f64 {
    if reached && least > 0.0 { least / actual.max(least) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    use crate::geometry::{Pose, Twist};

    const PERIOD_S: f64 = 0.1;

    fn row(pose: Pose, linear: f64) -> TraceRow {
        TraceRow::driving(pose, Twist::new(linear, 0.0))
    }

    fn metrics(trace: &Trace) -> RunRow {
        let drive = TrackedDrive { track_width_m: 0.4 };
        let mut row = RunRow::default();
        row.fill_motion(trace, &Footprint::round(0.25).expect("a radius"), &drive, PERIOD_S);
        row
    }

    fn close(value: Option<f64>, expected: f64) -> bool {
        value.is_some_and(|value| (value - expected).abs() < 1e-9 * (1.0 + expected.abs()))
    }

    #[test]
    fn empty_drive_has_no_figures() {
        assert_eq!(metrics(&Trace::default()), RunRow::default());
    }

    /// On a circle of radius R a robot turns by 1/R per metre of arc; Menger's circle through three points is that circle.
    #[test]
    fn circle_has_the_curvature_of_its_radius() {
        let radius_m = 2.0;
        let steps = 200;
        let at = |step: i32| {
            let angle = TAU * f64::from(step) / f64::from(steps);
            let (sin, cos) = libm::sincos(angle);
            row(Pose::new(radius_m * cos, radius_m * sin, angle + TAU / 4.0), 0.5)
        };
        let trace = Trace { rows: (0..=steps).map(at).collect(), ..Trace::default() };
        let figures = metrics(&trace);
        assert!(close(figures.curvature_per_m, 1.0 / radius_m), "{figures:?}");
        // The chords are shorter than the arcs.
        let chords = 2.0 * radius_m * libm::sin(TAU / 2.0 / f64::from(steps)) * f64::from(steps);
        assert!(close(figures.angle_per_m, TAU / chords), "{figures:?}");
        assert_eq!(figures.social_share, None);
    }

    /// Speeds 0, 0.1, 0.3, 0.3: changes of 1, 2 and 0 m/s^2, jerks of 10 and -20 m/s^3.
    #[test]
    fn speed_change_and_jerk_are_those_of_the_differences() {
        let rows = [0.0, 0.1, 0.3, 0.3].map(|speed| row(Pose::default(), speed)).to_vec();
        let figures = metrics(&Trace { rows, ..Trace::default() });
        assert!(close(figures.speed_change_m_s2, 1.0), "{figures:?}");
        assert!(close(figures.jerk_rms_m_s3, 250.0_f64.sqrt()), "{figures:?}");
        assert_eq!(figures.angle_per_m, None);
    }

    /// Commands 0, 0.1, 0.3, 0.3 m/s ask both belts for 1, 2 and 0 m/s^2. Belts 0.4 m apart that turn by 0.5 rad/s within a period
    /// change by 0.1 m/s: 1 m/s^2. A robot that drives at 0.3 m/s has 0.045 J/kg, and braking returns nothing.
    #[test]
    fn control_effort_and_work_are_those_of_the_belts() {
        let at = |linear, angular| {
            let mut row = TraceRow::driving(Pose::default(), Twist::new(linear, angular));
            row.command = row.twist;
            row
        };
        let figures = |rows: Vec<TraceRow>| metrics(&Trace { rows, ..Trace::default() });
        let straight = figures([0.0, 0.1, 0.3, 0.3].map(|speed| at(speed, 0.0)).to_vec());
        assert!(close(straight.control_effort_m_s2, (5.0_f64 / 3.0).sqrt()), "{straight:?}");
        assert!(close(straight.drive_work_j_per_kg, 0.045), "{straight:?}");
        let turn = figures([0.0, 0.5, 0.0].map(|rate| at(0.0, rate)).to_vec());
        assert!(close(turn.control_effort_m_s2, 1.0), "{turn:?}");
        assert!(close(turn.drive_work_j_per_kg, 0.005), "{turn:?}");
        let stops = figures([0.3, 0.0].map(|speed| at(speed, 0.0)).to_vec());
        assert!(close(stops.drive_work_j_per_kg, 0.0), "{stops:?}");
    }

    #[test]
    fn distance_from_the_path_is_that_to_the_path_of_the_time() {
        let along = |y: f64| vec![Point::new(0.0, y), Point::new(10.0, y)];
        let mut rows = vec![row(Pose::new(1.0, 0.3, 0.0), 0.5), row(Pose::new(2.0, 0.4, 0.0), 0.5)];
        rows[1].path = 1;
        rows[1].gap_m = 0.2;
        let trace = Trace { rows, paths: vec![along(0.0), along(1.0)], ..Trace::default() };
        let figures = metrics(&trace);
        assert!(close(figures.off_path_rms_m, f64::midpoint(0.09, 0.36).sqrt()), "{figures:?}");
        assert!(close(figures.near_share, 0.5), "{figures:?}");
    }

    /// A robot at 1 m/s towards a person at 1 m/s, 4 m apart: with 0.25 m and 0.3 m of radius they meet after 1.725 s; at the
    /// second of three ticks 0.1 s later.
    #[test]
    fn time_to_contact_and_intrusions_follow_from_the_motion_of_both() {
        let at = |step: i32| TraceRow {
            moving: vec![Some(Point::new(4.0 - 0.1 * f64::from(step), 0.0))],
            ..row(Pose::new(0.1 * f64::from(step), 0.0, 0.0), 1.0)
        };
        let trace =
            Trace { rows: (0..3).map(at).collect(), moving_radii: vec![0.3], ..Trace::default() };
        let figures = metrics(&trace);
        assert!(close(figures.least_time_to_contact_s, 1.625), "{figures:?}");
        // The gaps are 3.45, 3.25 and 3.05 m.
        let shares = [figures.intimate_share, figures.personal_share, figures.social_share];
        assert_eq!(shares, [0.0, 0.0, 1.0].map(Some));
        let past = time_to_contact_s(&Vector::new(4.0, 1.0), &Vector::new(-2.0, 0.0), 0.55);
        assert_eq!(past, None, "the person passes at a metre");
        assert_eq!(time_to_contact_s(&Vector::new(0.5, 0.0), &Vector::ZERO, 0.55), Some(0.0));
    }

    #[test]
    fn weighted_success_is_at_most_one_and_zero_without_success() {
        assert_eq!(weighted_success(true, 10.0, 12.5), 0.8);
        assert_eq!(weighted_success(true, 10.0, 9.0), 1.0);
        assert_eq!(weighted_success(false, 10.0, 9.0), 0.0);
    }
}
