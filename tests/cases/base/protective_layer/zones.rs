//! Fixed zones as in Nav2.

use inbye::base::protective_layer::{Polygons, ZonePolygon};
use inbye::base::{CollisionMonitorSettings, ProtectiveAction};
use inbye::geometry::{Point, Twist};

use super::checks::{disc, layer, scan};

/// Reads zones as a configuration has them.
fn zones(text: &str) -> Result<Polygons, String> {
    let settings: Result<CollisionMonitorSettings, _> = toml::from_str(text);
    settings.map(|settings| settings.polygons).map_err(|error| error.to_string())
}

const POINTS: &str = "points = [[0.4, 0.4], [1.5, 0.4], [1.5, -0.4], [0.4, -0.4]]";

fn zone(more: &str) -> ZonePolygon {
    let text = format!("polygons = [{{ name = \"front\", {POINTS}, {more} }}]");
    zones(&text).expect("a zone").zones()[0].clone()
}

/// The command at 0.2 m/s with a pillar 1.2 m ahead, which is in the zone.
fn limited(more: &str) -> (Twist, ProtectiveAction) {
    let polygons = Polygons::new(vec![zone(more)]).expect("a zone");
    let mut layer = layer(CollisionMonitorSettings::default().polygons(polygons));
    layer.update_scan(&scan(0.0, disc(Point::new(1.3, 0.0), 0.1)), 0.0);
    layer.limit(&Twist::new(0.2, 0.1), &Twist::STOP, 0.0)
}

#[test]
fn each_action_type_acts_as_in_nav2() {
    assert_eq!(limited("action_type = \"stop\"").0, Twist::STOP);
    let (slow, action) = limited("action_type = \"slowdown\", slowdown_ratio = 0.3");
    assert!((slow.linear - 0.06).abs() < 1e-12 && (slow.angular - 0.03).abs() < 1e-12);
    assert!(matches!(action, ProtectiveAction::Zone { .. }), "{action}");
    let (limit, _) = limited("action_type = \"limit\", linear_limit = 0.1, angular_limit = 1.0");
    assert!((limit.linear - 0.1).abs() < 1e-12 && (limit.angular - 0.05).abs() < 1e-12);
    let faster = limited("action_type = \"limit\", linear_limit = 0.3, angular_limit = 1.0");
    assert!(faster.1.passes());
    assert!(limited("action_type = \"stop\", enabled = false").1.passes());
    assert!(limited("action_type = \"stop\", min_points = 100").1.passes());
}

#[test]
fn approach_keeps_the_time_before_a_collision() {
    let text = "polygons = [{ name = \"body\", action_type = \"approach\", min_points = 1, \
        points = [[0.3, 0.3], [0.3, -0.3], [-0.3, -0.3], [-0.3, 0.3]], time_before_collision = 6.0 }]";
    let mut layer =
        layer(CollisionMonitorSettings::default().polygons(zones(text).expect("a zone")));
    layer.update_scan(&scan(0.0, disc(Point::new(1.0, 0.0), 0.1)), 0.0);
    // 0.6 m to go at 0.2 m/s: 3 s of 6 s.
    let (command, _) = layer.limit(&Twist::new(0.2, 0.0), &Twist::STOP, 0.0);
    assert!((command.linear - 0.1).abs() < 0.005, "{command:?}");
    let back = Twist::new(-0.2, 0.0);
    assert_eq!(layer.limit(&back, &Twist::STOP, 0.0).0, back);
}

/// A turn on the spot swings the end of a long zone at a pillar to its left.
#[test]
fn approach_counts_the_turn_of_a_command() {
    let text = "polygons = [{ name = \"arm\", action_type = \"approach\", min_points = 1, \
        points = [[1.0, 0.1], [1.0, -0.1], [0.5, -0.1], [0.5, 0.1]], time_before_collision = 6.0 }]";
    let mut layer =
        layer(CollisionMonitorSettings::default().polygons(zones(text).expect("a zone")));
    layer.update_scan(&scan(0.0, disc(Point::new(0.0, 0.8), 0.1)), 0.0);
    let turn = |rate: f64| Twist::new(0.0, rate);
    // 1.3 rad to go at 0.4 rad/s: 3.3 s of 6 s.
    let (command, action) = layer.limit(&turn(0.4), &Twist::STOP, 0.0);
    assert!((command.angular - 0.22).abs() < 0.02, "{command:?} {action}");
    assert_eq!(layer.limit(&turn(-0.4), &Twist::STOP, 0.0).0, turn(-0.4));
}

#[test]
fn zone_out_of_range_is_refused_by_name() {
    for (more, expected) in [
        ("action_type = \"stop\", min_points = 0", "min_points"),
        ("action_type = \"slowdown\", slowdown_ratio = 1.5", "slowdown_ratio"),
        ("action_type = \"limit\", linear_limit = -1.0", "linear_limit"),
        ("action_type = \"limit\", angular_limit = nan", "angular_limit"),
        ("action_type = \"approach\", time_before_collision = 0.0", "time_before_collision"),
        ("action_type = \"kick\"", "kick"),
        ("action_type = \"stop\", typo = 1", "typo"),
    ] {
        let text = format!("polygons = [{{ name = \"front\", {POINTS}, {more} }}]");
        let error = zones(&text).expect_err(more);
        assert!(error.contains(expected), "{error}");
    }
    let two = "polygons = [{ name = \"a\", action_type = \"stop\", points = [[0, 0], [1, 0]] }]";
    assert!(zones(two).expect_err("two corners").contains("number of points"));
}

#[test]
fn zones_are_bounded_in_number() {
    let zones = |count| Polygons::new(vec![zone("action_type = \"stop\""); count]);
    assert!(zones(32).is_ok());
    assert!(zones(33).is_err_and(|error| error.to_string().contains("number of zones")));
}

#[test]
fn limit_acts_on_turns_and_on_motion_backwards() {
    let polygons = |more: &str| Polygons::new(vec![zone(more)]).expect("a zone");
    let zone = "action_type = \"limit\", linear_limit = 0.1, angular_limit = 0.1";
    for (target, factor) in [
        (Twist::new(0.05, 0.2), 0.5),
        (Twist::new(0.05, -0.2), 0.5),
        (Twist::new(-0.2, 0.05), 0.5),
        (Twist::new(0.1, 0.1), 1.0),
    ] {
        let mut layer = layer(CollisionMonitorSettings::default().polygons(polygons(zone)));
        layer.update_scan(&scan(0.0, disc(Point::new(1.3, 0.0), 0.1)), 0.0);
        let (command, _) = layer.limit(&target, &Twist::STOP, 0.0);
        assert!((command.linear - factor * target.linear).abs() < 1e-12, "{command:?}");
        assert!((command.angular - factor * target.angular).abs() < 1e-12, "{command:?}");
    }
}

#[test]
fn triangle_contains_its_middle_and_not_its_surroundings() {
    let text =
        "polygons = [{ name = \"a\", action_type = \"stop\", points = [[0, 0], [2, 0], [0, 2]] }]";
    let zones = zones(text).expect("a zone");
    let contains = |x: f64, y: f64| zones.zones()[0].contains(&Point::new(x, y));
    assert!(
        contains(0.5, 0.5) && !contains(1.5, 1.5) && !contains(-0.5, 0.5) && !contains(0.5, -0.5)
    );
}
