//! Error messages for invalid ends and settings.

use inbye::geometry::{Point, Pose};
use inbye::global::{Heuristic, PlanError, PlanningSpace, Searcher, Settings, plan};
use inbye::map::{FreeSpace, GridFrame, ObstacleGrid};

use super::{WORKINGS, free_space, query};

/// The last point that a message names.
fn last_point_of(message: &str) -> Point {
    let (_, tail) = message.rsplit_once('(').expect("a point in the message");
    let (x, y) = tail.trim_end_matches(')').split_once(", ").expect(message);
    Point::new(x.parse().expect(message), y.parse().expect(message))
}

#[test]
fn plan_error_names_the_end_the_cause_and_a_free_point() {
    let good = Point::new(-8.7, 21.3);
    let space = free_space(&WORKINGS, 0.3);
    let cases = [
        (Point::new(-9.9, 20.1), "OCCUPIED", "is in an obstacle"),
        (Point::new(-9.4, 21.3), "OCCUPIED", "is in a cell less than 0.300 m from an obstacle"),
        (
            Point::new(-10.01, 21.3),
            "OUTSIDE_MAP",
            "is off the map, which spans (-10.00, 20.00) to (10.00, 27.00)",
        ),
        (Point::new(10.0, 21.3), "OUTSIDE_MAP", "is off the map"),
        (Point::new(1e300, -1e300), "OUTSIDE_MAP", "is off the map"),
    ];
    for (bad, code, wrong) in cases {
        for (end, outcome) in
            [("start", query(&space, bad, good)), ("goal", query(&space, good, bad))]
        {
            let error = outcome.expect_err("a bad end");
            let message = error.to_string();
            let end_code = format!("{}_{code}", end.to_uppercase());
            let place = format!("{end_code}: {end} ({:.2}, {:.2}) {wrong}", bad.x, bad.y);
            assert_eq!(error.code(), end_code);
            assert!(message.starts_with(&place), "{message}");
            assert!(message.contains(": the nearest free point is ("), "{message}");
            assert!(!message.contains('\n'), "{message}");
            let mended = last_point_of(&message);
            let plan = query(&space, mended, mended).expect(&message);
            assert_eq!(plan.smoothed.points().first(), Some(&mended));
        }
    }
}

#[test]
fn plan_error_names_the_nearest_free_cell() {
    let space = free_space(&WORKINGS, 0.3);
    let frame = space.frame();
    let bad = Point::new(-9.6, 23.4);
    let error = query(&space, bad, bad).expect_err("a bad end");
    let named = (last_point_of(&error.to_string()) - bad).norm();
    let nearest = frame
        .cells()
        .filter(|&cell| space.is_free(cell))
        .map(|cell| (frame.center_of(cell) - bad).norm())
        .fold(f64::INFINITY, f64::min);
    assert!((named - nearest).abs() < 1e-3);
}

#[test]
fn plan_rejects_ends_that_are_not_finite_and_maps_without_free_cells() {
    let good = Point::new(-8.7, 21.3);
    let space = free_space(&WORKINGS, 0.0);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for place in [Point::new(bad, 21.3), Point::new(-8.7, bad)] {
            let start = query(&space, place, good).expect_err("not finite");
            let goal = query(&space, good, place).expect_err("not finite");
            assert_eq!(start.code(), "START_OUTSIDE_MAP");
            assert_eq!(goal.code(), "GOAL_OUTSIDE_MAP");
            assert!(start.to_string().contains("must be finite"), "{start}");
        }
    }
    for radius_m in [50.0, f64::INFINITY, f64::NAN] {
        let space = free_space(&WORKINGS, radius_m);
        let error = query(&space, good, good).expect_err("no free cell");
        assert_eq!(error.code(), "START_OCCUPIED");
        let message = error.to_string();
        assert!(message.contains("the map has no free cell"), "{message}");
    }
}

/// The bounding box of a turned map contains points that are off the map.
#[test]
fn place_off_a_turned_map_is_told_the_corners() {
    let frame = GridFrame::new(40, 20, 0.5, Pose::new(1.0, 2.0, 0.6)).expect("a size");
    let space = FreeSpace::new(&ObstacleGrid::filled(frame, false), 0.3);
    let inside = frame.origin.transform(&Point::new(5.0, 5.0));
    let error = query(&space, Point::new(0.5, 2.0), inside).expect_err("off the map").to_string();
    let expected = "START_OUTSIDE_MAP: start (0.50, 2.00) is off the map, which is turned by 0.600 rad and has the corners \
        (1.00, 2.00), (17.51, 13.29), (11.86, 21.55), (-4.65, 10.25): the nearest free point is (";
    assert!(error.starts_with(expected), "{error}");
}

#[test]
fn path_within_a_cell_is_straight() {
    let space = free_space(&WORKINGS, 0.0);
    let here = Point::new(-8.7, 21.3);
    let plan = query(&space, here, here).expect("free");
    assert_eq!((plan.raw.turns(), plan.raw.length_m()), (0, 0.0));
}

/// The robot may not leave the map, also where no wall is at its edge.
#[test]
fn places_at_an_open_edge_are_as_near_to_it_as_to_a_wall() {
    let (open, wall) = ("..........", "....#.....");
    let space = free_space(&[open, open, open, wall, wall], 0.4);
    let (start, goal) = (Point::new(-9.25, 20.75), Point::new(-5.75, 20.75));
    query(&space, start, goal).expect("a path between the wall and the edge");
    let beside = Point::new(-7.75, 22.25);
    let error = query(&space, start, beside).expect_err("at the edge").to_string();
    let near = "is in a cell less than 0.400 m from an obstacle or the edge of the map";
    assert!(error.contains(near), "{error}");
    let closed = free_space(&[open, open, wall, wall, wall], 0.4);
    let error = query(&closed, start, goal).expect_err("no way past the wall");
    assert_eq!(error.code(), "NO_VALID_PATH");
}

/// Each cell of the room touches a wall.
#[test]
fn coarse_cells_without_free_ones_are_named_as_such() {
    let space = free_space(&["######", "#....#", "#....#", "######"], 0.01);
    let place = Point::new(-9.25, 20.75);
    let error = query(&space, place, place).expect_err("no free cell").to_string();
    assert!(error.contains("is in a cell less than 0.010 m from an obstacle"), "{error}");
    assert!(error.contains("cells of 0.5 m are too coarse"), "{error}");
}

#[test]
fn plan_to_a_closed_chamber_names_the_nearest_reachable_point() {
    let space = free_space(&WORKINGS, 0.0);
    let (start, chamber) = (Point::new(-8.7, 21.3), Point::new(0.8, 23.4));
    let error = query(&space, start, chamber).expect_err("a closed chamber");
    let PlanError::NoValidPath { expanded, nearest: Some(nearest), .. } = error else {
        panic!("{error}");
    };
    assert!(expanded > 200);
    assert_eq!(
        error.to_string(),
        format!(
            "NO_VALID_PATH: no path from (-8.70, 21.30) to (0.80, 23.40) keeps 0.000 m from every obstacle \
             ({} cells searched); the reachable point nearest to the goal is ({:.3}, {:.3}): choose a goal on the \
             same side, a smaller radius (that of the footprint and its margins) or a finer map",
            space.count() - 6,
            nearest.x,
            nearest.y
        )
    );
    // The named point is reachable, and nearer to the goal than the start.
    let plan = query(&space, start, nearest).expect("a reachable point");
    assert_eq!(plan.smoothed.points().last(), Some(&nearest));
    assert!((nearest - chamber).norm() < (start - chamber).norm());
}

#[test]
fn plan_rejects_settings_out_of_range_by_name() {
    let space = free_space(&WORKINGS, 0.0);
    let ground = PlanningSpace { search: &space, smoothing: &space, costs: None };
    let here = Point::new(-8.7, 21.3);
    let with = |heuristic, spline_degree| {
        let settings = Settings::default().heuristic(heuristic).spline_degree(spline_degree);
        plan(&mut Searcher::default(), &ground, here, here, &settings, &mut || 0.0)
            .map_err(|error| error.to_string())
    };
    for degree in [0, 10, usize::MAX] {
        let message = with(Heuristic::Octile, degree).expect_err("a bad degree");
        assert!(message.starts_with("spline_degree is "), "{message}");
    }
    for k in [-1e-9, 1.1e6, f64::NAN, f64::INFINITY] {
        for (name, heuristic) in [
            ("normalized", Heuristic::Normalized { k }),
            ("additive", Heuristic::Additive { k }),
            ("literal", Heuristic::Literal { k }),
        ] {
            let message = with(heuristic, 3).expect_err("a bad weight");
            assert_eq!(message, format!("heuristic.{name}.k is {k}: it must be 0 to 1e6"));
        }
    }
    for degrees in [0.0, -30.0, 90.1, f64::NAN] {
        let message = with(Heuristic::Theta { degrees }, 3).expect_err("a bad angle");
        assert!(message.starts_with("heuristic.theta.degrees is "), "{message}");
    }
}
