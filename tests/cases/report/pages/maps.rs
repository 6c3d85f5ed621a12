//! Pictures of plans show the right part of the map in the right direction.

use inbye::geometry::{Point, Pose};
use inbye::map::{GridFrame, OccupancyGrid};
use inbye::report::{PathStages, PlanOutcome, PlanView, plan_svg};
use roxmltree::{Document, Node};

use super::markup::numbers_that_are_none;

/// A picture of a path on a free map with cells of half a metre.
fn picture(path: &[Point], width: i32, height: i32) -> String {
    let frame = GridFrame { width, height, resolution_m: 0.5, origin: Pose::new(-2.0, 3.0, 0.0) };
    let (first, last) = (path[0], path[path.len() - 1]);
    plan_svg(&PlanView {
        title: "A plan on a free map",
        map: &OccupancyGrid::filled(frame, 0),
        zones: None,
        start: Pose::new(first.x, first.y, 0.0),
        stops: &[],
        goal: last,
        stages: PathStages { smoothed: path, ..PathStages::default() },
        outcome: PlanOutcome::NotFound { reason: "a made plan", nearest: None },
    })
}

/// The elements of a class on the map; the legend is outside of the map.
fn on_map<'a>(document: &'a Document, class: &str) -> Vec<Node<'a, 'a>> {
    let is_map = |node: &Node| node.has_tag_name("svg") && node.parent_element().is_some();
    let map = document.descendants().find(is_map).expect("the map is a nested picture");
    map.descendants().filter(|node| node.attribute("class") == Some(class)).collect()
}

fn number(node: &Node, name: &str) -> f64 {
    let value = node.attribute(name).expect("an attribute");
    value.parse().expect("a number")
}

/// Whether all corners of the map are in the picture.
fn shows_whole_map(picture: &str) -> bool {
    let document = Document::parse(picture).expect("sound markup");
    let (width, height) = (720.0, number(&on_map(&document, "outside")[0], "height"));
    let corners = on_map(&document, "free")[0].attribute("points").expect("corners");
    corners.split(' ').all(|corner| {
        let (x, y) = corner.split_once(',').expect("a corner");
        let [x, y] = [x, y].map(|text| text.parse::<f64>().expect("a number"));
        (-0.1..=width + 0.1).contains(&x) && (-0.1..=height + 0.1).contains(&y)
    })
}

#[test]
fn small_map_is_shown_whole_and_large_one_in_part() {
    let path = [Point::new(0.0, 5.0), Point::new(10.0, 9.0)];
    let (small, large) = (picture(&path, 30, 20), picture(&path, 3000, 2000));
    assert!(shows_whole_map(&small) && !shows_whole_map(&large));
    for picture in [small, large] {
        let document = Document::parse(&picture).expect("sound markup");
        let height = number(&on_map(&document, "outside")[0], "height");
        let line = on_map(&document, "smoothed")[0].attribute("points").expect("points");
        let points: Vec<[f64; 2]> = line
            .split(' ')
            .filter_map(|point| point.split_once(','))
            .map(|(x, y)| [x, y].map(|text| text.parse().expect("a number")))
            .collect();
        assert!(
            points.iter().all(|[x, y]| (0.0..=720.0).contains(x) && (0.0..=height).contains(y)),
            "{points:?}"
        );
        // A map of 15 by 10 m, or a path of 10.8 m with its margin: less than 15 m wide and more than 10 m.
        let units_per_m = (points[1][0] - points[0][0]) / 10.0;
        assert!((720.0 / 15.1..72.0).contains(&units_per_m), "{units_per_m}");
    }
}

#[test]
fn greater_y_is_higher_in_the_drawing() {
    for (start_y, goal_y) in [(5.0, 9.0), (9.0, 5.0)] {
        let picture = picture(&[Point::new(0.0, start_y), Point::new(10.0, goal_y)], 99, 99);
        let document = Document::parse(&picture).expect("sound markup");
        let line = on_map(&document, "smoothed")[0].attribute("points").expect("points");
        let ys = line.split(' ').filter_map(|point| point.split_once(',')?.1.parse::<f64>().ok());
        let ys: Vec<f64> = ys.collect();
        assert_eq!(ys[0] > ys[1], start_y < goal_y, "{line}");
    }
}

#[test]
fn picture_ignores_points_that_are_not_finite() {
    let path = [Point::new(f64::NAN, 0.0), Point::new(0.0, f64::INFINITY)];
    let picture = picture(&path, 10, 10);
    assert_eq!(numbers_that_are_none(&picture), [""; 0]);
    assert!(shows_whole_map(&picture));
}
