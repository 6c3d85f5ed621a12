//! Places where a person may be hidden: behind the range edges of the scan, where the map has room for a person.

use super::NavigatorSettings;
use super::passive_safety::obstacle_that_may_come;
use super::visible_space::VisibleSpace;
use crate::geometry::{Point, Vector};
use crate::map::{FreeSpace, MovingDisc, ObstacleGrid};

/// Radius of a person, metres. The map must leave this much room around a hidden place.
const PERSON_RADIUS_M: f64 = 0.25;
/// The range jumps by at least this where a person may stand behind the nearer surface, metres.
const MIN_JUMP_M: f64 = 2.0 * PERSON_RADIUS_M;
/// Checked distances behind the edge, metres. Where an opening begins, a wall leaves no room near its edge, and a person who
/// comes out of it is deeper inside.
const BEHIND_M: [f64; 6] = [0.3, 0.6, 0.9, 1.3, 1.8, 2.4];
/// Places farther than this do not limit a robot of up to 1.5 m/s, metres.
const FARTHEST_M: f64 = 5.0;
/// Places behind the robot do not limit its forward speed, metres.
const BEHIND_ROBOT_M: f64 = -0.5;
/// An edge within this distance of a moving obstacle belongs to it, metres.
const MOVING_EDGE_M: f64 = 0.2;
/// Largest number of places: the nearest count.
const MAX_PLACES: usize = 24;
/// Beams without a measurement between the two beams of an edge.
const MAX_GAP: usize = 3;

/// Where the map has room for a person; `None` if hidden people are not considered.
pub(super) fn standing_room(
    known: &ObstacleGrid,
    settings: &NavigatorSettings,
) -> Option<FreeSpace> {
    settings.features.occlusion_speed.then(|| FreeSpace::new(known, PERSON_RADIUS_M))
}

/// Hidden places near the robot as people that start towards it, nearest first. Places behind a moving obstacle do not count:
/// the navigator considers the obstacle itself.
pub(super) fn hidden_people(
    space: &VisibleSpace<'_>,
    room: &FreeSpace,
    moving: &[MovingDisc],
    speed: f64,
) -> Vec<MovingDisc> {
    let scan = space.scan;
    let beams = scan.ranges.len();
    let mut places: Vec<(f64, Point)> = Vec::new();
    let mut before: Option<(usize, f64)> = None;
    for beam in 0..beams {
        let range = scan.ranges[beam];
        if range.is_nan() || range <= 0.0 {
            continue;
        }
        let range = range.min(scan.range_max);
        if let Some((other, other_m)) = before.replace((beam, range))
            && beam - other <= MAX_GAP
            && (range - other_m).abs() >= MIN_JUMP_M
        {
            // The shadow lies behind the nearer beam, on its side of the edge.
            let (near, near_m, aside) =
                if range < other_m { (beam, range, 1.0) } else { (other, other_m, -1.0) };
            let depth_m = (range - other_m).abs();
            let (sin, cos) = libm::sincos(scan.angle(near));
            let edge = space.pose.transform(&(scan.origin + Vector::new(cos, sin) * near_m));
            let is_moving = moving
                .iter()
                .any(|disc| (disc.center() - edge).norm() <= disc.radius + MOVING_EDGE_M);
            if near_m < FARTHEST_M && !is_moving {
                places.extend(hidden_place(space, room, near, near_m, aside, depth_m));
            }
        }
    }
    places.sort_by(|one, other| one.0.total_cmp(&other.0));
    places.truncate(MAX_PLACES);
    let person = |(_, place): (f64, Point)| obstacle_that_may_come(place, PERSON_RADIUS_M, speed);
    places.into_iter().map(person).collect()
}

/// The nearest place behind an edge where a person is out of sight and the map is free, with its distance, metres.
fn hidden_place(
    space: &VisibleSpace<'_>,
    room: &FreeSpace,
    near: usize,
    near_m: f64,
    aside: f64,
    depth_m: f64,
) -> Option<(f64, Point)> {
    let (sin, cos) = libm::sincos(space.scan.angle(near));
    let along = Vector::new(cos, sin);
    let across = Vector::new(-sin, cos) * (aside * PERSON_RADIUS_M);
    BEHIND_M.iter().filter(|&&behind_m| behind_m < depth_m).find_map(|behind_m| {
        let own = space.scan.origin + along * (near_m + behind_m) + across;
        let place = space.pose.transform(&own);
        let cell = room.frame().cell_of(&place)?;
        let can_stand = own.x >= BEHIND_ROBOT_M && room.is_free(cell);
        (can_stand && space.hides(&place, PERSON_RADIUS_M))
            .then_some((own.to_vector().norm(), place))
    })
}

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;

    use super::*;
    use crate::geometry::Pose;
    use crate::map::{Cell, GridFrame, GridRay, Scan};
    use crate::navigator::scan_health::ScanHealth;

    /// A roadway along x, 3 m wide, with a side gallery from x = 6 to x = 8 m to the left where it is open.
    fn roadway(has_gallery: bool) -> ObstacleGrid {
        let frame = GridFrame::new(120, 80, 0.1, Pose::default()).expect("a valid size");
        let mut obstacles = ObstacleGrid::filled(frame, true);
        for row in 10..75 {
            for column in 2..118 {
                let in_gallery = has_gallery && (60..80).contains(&column);
                if row < 40 || in_gallery {
                    obstacles.set(Cell::new(column, row), false);
                }
            }
        }
        obstacles
    }

    fn scan_from(obstacles: &ObstacleGrid, pose: &Pose) -> Scan {
        let frame = obstacles.frame();
        let mut scan = Scan {
            angle_min: -core::f64::consts::PI,
            angle_increment: TAU / 450.0,
            range_max: 10.0,
            ranges: Vec::new(),
            ..Scan::default()
        };
        for beam in 0..450 {
            let (sin, cos) = libm::sincos(scan.angle(beam) + pose.yaw);
            let start = frame.to_cell_units(&pose.position());
            let hit = GridRay::new(&start, &Vector::new(cos, sin))
                .find(|&(cell, _)| obstacles.is_blocked(cell));
            let range = hit.map_or(f64::INFINITY, |(_, entered)| entered * frame.resolution_m);
            scan.ranges.push(if range > 10.0 { f64::INFINITY } else { range });
        }
        scan
    }

    fn people(has_gallery: bool, x: f64) -> Vec<MovingDisc> {
        let obstacles = roadway(has_gallery);
        let pose = Pose::new(x, 2.5, 0.0);
        let (scan, health) = (scan_from(&obstacles, &pose), ScanHealth::default());
        let room = FreeSpace::new(&obstacles, PERSON_RADIUS_M);
        let space = VisibleSpace { pose, scan: &scan, health: &health };
        hidden_people(&space, &room, &[], 1.6)
    }

    #[test]
    fn person_may_hide_around_the_corner_of_a_gallery() {
        let people = people(true, 3.0);
        let first = people.first().expect("a hidden place");
        assert!((6.0..7.2).contains(&first.x) && (4.0..5.2).contains(&first.y), "{first:?}");
    }

    #[test]
    fn occlusion_ignores_roadway_walls_and_visible_places() {
        assert_eq!(people(false, 3.0), []);
        assert_eq!(people(true, 7.0), []);
    }

    /// People by a scan with a range for each whole degree of -180 to 179, from the middle of a free map of 20 m. The robot
    /// looks along y; the map is blocked where this holds, by distances ahead and to the left.
    fn found(
        range: impl Fn(i32) -> f64,
        is_blocked: impl Fn(f64, f64) -> bool,
        moving: &[MovingDisc],
    ) -> Vec<MovingDisc> {
        let frame = GridFrame::new(200, 200, 0.1, Pose::default()).expect("a valid size");
        let pose = Pose::new(10.0, 10.0, 1.5);
        let obstacles = ObstacleGrid::from_fn(frame, |cell| {
            let own = pose.inverse_transform(&frame.center_of(cell));
            is_blocked(own.x, own.y)
        });
        let scan = Scan {
            angle_min: -core::f64::consts::PI,
            angle_increment: TAU / 360.0,
            range_max: 9.0,
            ranges: (-180..180).map(range).collect(),
            ..Scan::default()
        };
        let (room, health) = (FreeSpace::new(&obstacles, PERSON_RADIUS_M), ScanHealth::default());
        let space = VisibleSpace { pose, scan: &scan, health: &health };
        hidden_people(&space, &room, moving, 1.6)
    }

    const FREE: fn(f64, f64) -> bool = |_, _| false;

    /// A surface to the right of the heading, and one behind it everywhere else ahead.
    fn edge(near_m: f64, far_m: f64) -> impl Fn(i32) -> f64 {
        move |degree| {
            if (-60..0).contains(&degree) {
                near_m
            } else if degree < 60 {
                far_m
            } else {
                near_m
            }
        }
    }

    /// The edge at the heading of those that `edge` has.
    fn ahead(people: &[MovingDisc]) -> Vec<MovingDisc> {
        let pose = Pose::new(10.0, 10.0, 1.5);
        let own = |person: &&MovingDisc| pose.inverse_transform(&person.center());
        people
            .iter()
            .filter(|person| own(person).x > 1.0 && own(person).y.abs() < 0.6)
            .copied()
            .collect()
    }

    #[test]
    fn jump_of_a_person_s_width_hides_somebody_with_a_speed() {
        assert_eq!(ahead(&found(edge(3.0, 3.4), FREE, &[])), []);
        let people = ahead(&found(edge(3.0, 3.6), FREE, &[]));
        assert_eq!(people.len(), 1, "{people:?}");
        assert_eq!((people[0].vx, people[0].radius), (1.6, PERSON_RADIUS_M));
        let away_m = (people[0].center() - Point::new(10.0, 10.0)).norm();
        assert!((away_m - 3.31).abs() < 0.02, "{away_m}");
        // On either side of the nearer surface, and not in front of it.
        let mirrored = |degree: i32| edge(3.0, 3.6)(-1 - degree);
        assert_eq!(ahead(&found(mirrored, FREE, &[])).len(), 1);
        // Only 0.6 m are in the shadow of a surface 0.6 m nearer.
        assert_eq!(ahead(&found(edge(3.0, 3.6), |x, _| x < 3.3, &[])), []);
        assert_eq!(ahead(&found(edge(3.0, 6.0), |_, _| true, &[])), [], "no room in the map");
    }

    #[test]
    fn far_edges_and_edges_of_moving_obstacles_give_no_hidden_person() {
        assert_eq!(ahead(&found(edge(4.9, 8.0), FREE, &[])).len(), 1);
        assert_eq!(ahead(&found(edge(5.1, 8.0), FREE, &[])), []);
        let place = Pose::new(10.0, 10.0, 1.5).transform(&Point::new(3.0, -0.2));
        let walker = MovingDisc { x: place.x, y: place.y, radius: 0.2, vx: 1.0, vy: 0.0 };
        assert_eq!(ahead(&found(edge(3.0, 6.0), FREE, &[walker])), []);
        let elsewhere = MovingDisc { x: place.x + 1.0, ..walker };
        assert_eq!(ahead(&found(edge(3.0, 6.0), FREE, &[elsewhere])).len(), 1);
        // Behind the robot.
        let behind = |degree: i32| if degree < -150 { 3.0 } else { 6.0 };
        assert_eq!(found(behind, FREE, &[]), []);
    }

    #[test]
    fn gap_between_beams_and_a_thin_post_give_no_hidden_person() {
        let with_gap = |beams: i32| {
            move |degree: i32| {
                if (0..beams).contains(&degree) { f64::NAN } else { edge(3.0, 6.0)(degree) }
            }
        };
        assert_eq!(ahead(&found(with_gap(2), FREE, &[])).len(), 1);
        assert_eq!(ahead(&found(with_gap(3), FREE, &[])), []);
        let post = |degree: i32| if degree == 0 { 3.0 } else { 6.0 };
        assert_eq!(found(post, FREE, &[]), []);
    }

    #[test]
    fn nearest_hidden_place_comes_first() {
        let two = |degree: i32| match degree {
            -60..-20 => 4.0,
            20..60 => 2.0,
            _ => 7.0,
        };
        let people = found(two, FREE, &[]);
        let away: Vec<f64> =
            people.iter().map(|one| (one.center() - Point::new(10.0, 10.0)).norm()).collect();
        assert!(away.len() >= 3 && away.is_sorted() && away[0] < 2.5, "{away:?}");
        // Surfaces of 4 degrees with as much between them: more edges ahead than places are kept.
        let many = |degree: i32| if degree.rem_euclid(14) < 9 { 4.5 } else { 8.0 };
        assert_eq!(found(many, FREE, &[]).len(), MAX_PLACES);
    }

    /// The map leaves room for a person only at the greatest checked distance.
    #[test]
    fn person_may_hide_deep_behind_an_edge() {
        let people = ahead(&found(edge(3.0, 8.0), |x, _| x < 5.0, &[]));
        assert_eq!(people.len(), 1, "{people:?}");
        let away_m = (people[0].center() - Point::new(10.0, 10.0)).norm();
        assert!((away_m - 5.4).abs() < 0.05, "{away_m}");
    }

    #[test]
    fn edge_before_open_space_hides_somebody() {
        assert_eq!(ahead(&found(edge(3.0, f64::INFINITY), FREE, &[])).len(), 1);
    }

    /// More edges than places are kept, the nearest one among the last beams.
    #[test]
    fn nearest_hidden_place_is_kept_among_many() {
        let range = |degree: i32| match degree {
            76..92 => 2.0,
            _ if degree.rem_euclid(14) < 9 => 4.5,
            _ => 8.0,
        };
        let people = found(range, FREE, &[]);
        let away_m = (people[0].center() - Point::new(10.0, 10.0)).norm();
        assert!(people.len() == MAX_PLACES && away_m < 2.5, "{away_m}");
    }
}
