//! What meetings with people cost a drive.

use serde::Serialize;

use super::Trace;
use crate::geometry::Point;
use crate::map::{GridRay, ObstacleGrid};

/// A person is met where the robot is within this distance of its centre, metres, and the map has no obstacle in between.
pub const MET_WITHIN_M: f64 = 4.0;
/// Least time, seconds, and least forward distance, metres, without people that show the speed of the robot alone.
const LEAST_ALONE_S: f64 = 5.0;
const LEAST_ALONE_M: f64 = 2.0;
/// A robot that is more than this many times as fast with people as alone was not alone where it drives: it turned, waited or
/// parked. Its speed alone then says nothing about the time that people cost.
const MOST_SPEED_RATIO: f64 = 2.0;

/// The people that the robot met, and the time that they cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Encounters {
    /// Number of people that the robot met.
    pub people_met: usize,
    /// Time with people, less the time that the robot takes for the same distance at its mean speed without people, seconds. Below
    /// zero for a robot that was faster with people. None where it met no person, was alone for less than 5 s, drove less than 2 m
    /// forwards alone, or was more than twice as fast with people as alone, forwards or backwards. So the figure is within minus
    /// one and three times the time with people.
    ///
    /// The speed without people includes turns in place, waits and parking, so the loss is rather too small.
    pub time_lost_s: Option<f64>,
}

impl Encounters {
    /// The encounters of a drive on a map, with this time between two rows, seconds.
    #[must_use]
    pub fn of(trace: &Trace, obstacles: &ObstacleGrid, period_s: f64) -> Self {
        let mut met = vec![false; trace.moving_radii.len()];
        // Ticks, and the sum of their forward speeds, alone and with people.
        let mut sums = [(0_u32, 0.0); 2];
        for row in &trace.rows {
            let robot = row.pose.position();
            let mut is_with_people = false;
            for (met, person) in met.iter_mut().zip(&row.moving) {
                let is_met = person.is_some_and(|person| is_in_sight(obstacles, &robot, &person));
                *met |= is_met;
                is_with_people |= is_met;
            }
            let sum = &mut sums[usize::from(is_with_people)];
            *sum = (sum.0 + 1, sum.1 + row.twist.linear);
        }
        let [(alone, speeds_alone), (with, speeds_with)] = sums;
        let [speed_alone, speed_with] =
            sums.map(|(ticks, speeds)| speeds / f64::from(ticks.max(1)));
        let is_known = f64::from(alone) * period_s >= LEAST_ALONE_S
            && speeds_alone * period_s >= LEAST_ALONE_M
            && speed_with.abs() <= MOST_SPEED_RATIO * speed_alone;
        let time_lost_s = period_s * (f64::from(with) - speeds_with / speed_alone);
        Self {
            people_met: met.iter().filter(|met| **met).count(),
            time_lost_s: (with > 0 && is_known).then_some(time_lost_s),
        }
    }
}

/// Whether a place is near a robot, with no obstacle of the map in between.
fn is_in_sight(obstacles: &ObstacleGrid, robot: &Point, place: &Point) -> bool {
    let line = place - robot;
    let distance_m = line.norm();
    if distance_m.is_nan() || distance_m > MET_WITHIN_M {
        return false;
    }
    let frame = obstacles.frame();
    let (start, end) = (frame.to_cell_units(robot), frame.to_cell_units(place));
    let length = (end - start).norm();
    length == 0.0
        || GridRay::new(&start, &((end - start) / length))
            .take_while(|(_, entered)| *entered < length)
            .all(|(cell, _)| !obstacles.is_blocked(cell))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Pose, Twist};
    use crate::map::{Cell, GridFrame};
    use crate::runtime::TraceRow;

    /// A drive along x for 20 s. The robot has these speeds without and with the person, who stands at x = 20 m beyond `y`.
    fn drive(alone: f64, with: f64, y: f64) -> Trace {
        let person = Point::new(20.0, y);
        let mut x = 10.0;
        let row = |tick: u32| {
            let pose = Pose::new(x, 0.0, 0.0);
            let is_near = (person - pose.position()).norm() <= MET_WITHIN_M;
            let linear = if is_near { with } else { alone };
            x += linear * 0.1;
            let moving = vec![Some(person), None];
            let time_s = f64::from(tick) * 0.1;
            TraceRow { time_s, moving, ..TraceRow::driving(pose, Twist::new(linear, 0.0)) }
        };
        let rows = (0..200).map(row).collect();
        Trace { rows, moving_radii: vec![0.3, 0.3], ..Trace::default() }
    }

    /// A map of 60 by 20 m with a wall at y = 1 m where `is_walled`.
    fn map(is_walled: bool) -> ObstacleGrid {
        let origin = Pose::new(0.0, -10.0, 0.0);
        let frame = GridFrame::new(600, 200, 0.1, origin).expect("a valid size");
        let mut obstacles = ObstacleGrid::filled(frame, false);
        (0..600).for_each(|column| obstacles.set(Cell::new(column, 110), is_walled));
        obstacles
    }

    #[test]
    fn time_lost_is_the_time_beyond_that_of_the_speed_without_people() {
        let encounters = Encounters::of(&drive(1.0, 0.5, 2.0), &map(false), 0.1);
        // The robot is within 4 m for the last 13.5 s, at half its speed.
        let lost_s = encounters.time_lost_s.expect("a loss");
        assert_eq!(encounters.people_met, 1);
        assert!((lost_s - 6.75).abs() < 0.1, "{lost_s}");
        let same = Encounters::of(&drive(1.0, 1.0, 2.0), &map(false), 0.1);
        assert!(same.time_lost_s.is_some_and(|lost_s| lost_s.abs() < 1e-9), "{same:?}");
    }

    #[test]
    fn people_behind_walls_or_far_away_are_not_met() {
        let none = Encounters::default();
        assert_eq!(Encounters::of(&drive(1.0, 0.5, 2.0), &map(true), 0.1), none);
        assert_eq!(Encounters::of(&drive(1.0, 0.5, 4.5), &map(false), 0.1), none);
    }

    /// The oracle is the definition itself: the time with the person less their distance over the speed alone, in closed form.
    #[test]
    fn time_lost_is_unknown_where_the_speed_alone_says_nothing() {
        let lost_s = |alone, with| {
            let trace = drive(alone, with, 2.0);
            (Encounters::of(&trace, &map(false), 0.1).time_lost_s, trace)
        };
        for (alone, with) in [(0.9, 1.7), (0.9, 0.9), (0.9, 0.1), (0.9, -0.3)] {
            let (lost_s, trace) = lost_s(alone, with);
            let with_s =
                0.1 * trace.rows.iter().filter(|row| row.twist.linear == with).count() as f64;
            let lost_s = lost_s.expect("a loss");
            if alone != with {
                let expected = with_s - with_s * with / alone;
                assert!((lost_s - expected).abs() < 1e-9, "{alone} {with}: {lost_s}, {expected}");
                assert!((-with_s..=3.0 * with_s).contains(&lost_s), "{alone} {with}: {lost_s}");
            }
        }
        // More than twice as fast with people: the robot alone did not drive as it does.
        assert_eq!(lost_s(0.7, 1.5).0, None);
        // Backwards as well.
        assert_eq!(lost_s(0.7, -1.5).0, None);
        // A robot that hardly moved alone: 1.9 m in the first 19 s.
        let mut trace = drive(0.0, 0.0, 2.0);
        for (index, row) in trace.rows.iter_mut().enumerate() {
            let is_alone = index < 190;
            row.pose.x = if is_alone { 10.0 } else { 19.0 };
            row.twist.linear = 0.1;
        }
        assert_eq!(Encounters::of(&trace, &map(false), 0.1).time_lost_s, None);
        trace.rows.iter_mut().for_each(|row| row.twist.linear = 0.11);
        assert!(Encounters::of(&trace, &map(false), 0.1).time_lost_s.is_some());
    }

    #[test]
    fn time_lost_is_unknown_where_the_robot_was_never_alone() {
        let mut trace = drive(1.0, 0.5, 2.0);
        trace.rows.retain(|row| (16.6..23.0).contains(&row.pose.x));
        let encounters = Encounters::of(&trace, &map(false), 0.1);
        assert_eq!((encounters.people_met, encounters.time_lost_s), (1, None));
    }
}
