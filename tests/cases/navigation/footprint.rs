//! The body of the robot, the discs that cover it, and their text in a settings file.

use std::f64::consts::PI;

use inbye::geometry::{Point, Pose, Twist};
use inbye::robot::{Disc, Footprint, Polygon};
use inbye::runtime::Config;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

fn is_covered(discs: &[Disc], point: &Point) -> bool {
    discs.iter().any(|disc| libm::hypot(point.x - disc.x, point.y - disc.y) <= disc.radius + 1e-9)
}

/// A star-shaped polygon with corners at random distances from its middle.
fn random_polygon(rng: &mut Pcg64Mcg) -> Polygon {
    let middle = Point::new(rng.random_range(-0.2..0.2), rng.random_range(-0.2..0.2));
    let stretch = rng.random_range(0.3..1.0);
    let count = rng.random_range(3..9);
    let corner = |index: i32| {
        let angle = 2.0 * PI * f64::from(index) / f64::from(count);
        let reach = rng.random_range(0.1..0.6);
        let (sin, cos) = libm::sincos(angle);
        Point::new(middle.x + reach * cos, middle.y + stretch * reach * sin)
    };
    Polygon::new((0..count).map(corner).collect()).expect("a polygon with an area")
}

fn points_in(body: &Polygon, rng: &mut Pcg64Mcg) -> Vec<Point> {
    let at =
        |rng: &mut Pcg64Mcg| Point::new(rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0));
    (0..2000).map(|_| at(rng)).filter(|point| body.contains(point)).collect()
}

#[test]
fn default_discs_cover_the_whole_stated_body() {
    let footprint = Config::default().robot.footprint;
    assert_eq!(footprint.discs().len(), 2);
    for column in 0..=140 {
        for row in 0..=100 {
            let point = Point::new(f64::from(column) * 0.005 - 0.35, f64::from(row) * 0.005 - 0.25);
            assert!(is_covered(footprint.discs(), &point), "{point:?}");
        }
    }
    // They overhang the sides by little, and the body is not larger than stated.
    assert!(footprint.max_disc_radius_m() < 0.25 + 0.06);
    assert!((footprint.body_radius_m() - libm::hypot(0.35, 0.25)).abs() < 1e-12);
}

#[test]
fn discs_of_random_polygons_cover_them() {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    for _ in 0..200 {
        let body = random_polygon(&mut rng);
        let footprint = Footprint::covering(body.clone());
        for point in points_in(&body, &mut rng) {
            assert!(is_covered(footprint.discs(), &point), "{point:?} of {body:?}");
        }
        Footprint::with_body(body, footprint.discs().to_vec()).expect("they cover the body");
    }
}

/// A convex polygon: corners on an ellipse.
fn convex_polygon(rng: &mut Pcg64Mcg) -> Option<Polygon> {
    let (length, width) = (rng.random_range(0.1..0.8), rng.random_range(0.1..0.8));
    let middle = Point::new(rng.random_range(-0.2..0.2), rng.random_range(-0.2..0.2));
    let count = rng.random_range(3..9);
    let mut angles: Vec<f64> = (0..count).map(|_| rng.random_range(0.0..2.0 * PI)).collect();
    angles.sort_by(f64::total_cmp);
    let corner = |angle: f64| {
        let (sin, cos) = libm::sincos(angle);
        Point::new(middle.x + length * cos, middle.y + width * sin)
    };
    Polygon::new(angles.into_iter().map(corner).collect()).ok()
}

/// Largest distance of a disc's outline from a body, by samples.
fn overhang_m(body: &Polygon, discs: &[Disc]) -> f64 {
    let on_outline = |disc: &Disc, index: i32| {
        let (sin, cos) = libm::sincos(PI / 90.0 * f64::from(index));
        body.distance(&Point::new(disc.x + disc.radius * cos, disc.y + disc.radius * sin))
    };
    let beyond = discs.iter().flat_map(|disc| (0..180).map(move |index| on_outline(disc, index)));
    beyond.fold(0.0, f64::max)
}

#[test]
fn discs_of_convex_bodies_cover_every_millimetre_and_stand_out_little() {
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    let mut grids = 0;
    for _ in 0..300 {
        let Some(body) = convex_polygon(&mut rng) else {
            continue;
        };
        let footprint = Footprint::covering(body.clone());
        let discs = footprint.discs();
        assert!((1..=8).contains(&discs.len()), "{body:?}");
        // Between the corners along the outline, and inside.
        let corners = body.corners();
        for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            let steps = ((*to - *from).norm() * 1000.0).ceil().max(1.0);
            for step in 0..=steps as u32 {
                let point = *from + (*to - *from) * (f64::from(step) / steps);
                assert!(is_covered(discs, &point), "{point:?} of {body:?}");
            }
        }
        for point in points_in(&body, &mut rng) {
            assert!(is_covered(discs, &point), "{point:?} of {body:?}");
        }
        let overhang_m = overhang_m(&body, discs);
        let (least, most) =
            corners.iter().fold(([f64::MAX; 2], [f64::MIN; 2]), |(low, high), at| {
                ([low[0].min(at.x), low[1].min(at.y)], [high[0].max(at.x), high[1].max(at.y)])
            });
        let pairs = corners.iter().zip(corners.iter().cycle().skip(1));
        let area = pairs.map(|(from, to)| from.x * to.y - to.x * from.y).sum::<f64>() / 2.0;
        // A tapered body has a row of equal discs over its whole bounding box.
        let is_tapered = area.abs() < 0.71 * (most[0] - least[0]) * (most[1] - least[1]);
        // One wider than long has a row that stands out little to the sides.
        let (length, width) = (most[0] - least[0], most[1] - least[1]);
        if width > length {
            let side =
                |disc: &Disc| (disc.y - f64::midpoint(least[1], most[1])).abs() + disc.radius;
            let side_m = discs.iter().map(side).fold(0.0, f64::max) - width / 2.0;
            assert!(side_m <= 0.06 * width, "{side_m} m, {body:?}: {discs:?}");
        } else {
            assert!(is_tapered || overhang_m <= 0.25, "{overhang_m} m, {body:?}: {discs:?}");
        }
        assert!(
            footprint.circumscribed_radius_m() <= footprint.body_radius_m() + overhang_m + 1e-3
        );
        grids += u32::from(discs.iter().any(|disc| disc.radius < 0.9 * discs[0].radius));
    }
    assert!(grids > 4, "{grids} with discs of several sizes");
}

/// Larger discs would reach beyond the circle around the body, for which paths are planned.
#[test]
fn discs_of_nearly_square_bodies_stay_within_their_circle() {
    let square = Polygon::rectangle(1.5, 1.4).expect("a rectangle");
    let hexagon = (0..6).map(|index| {
        let (sin, cos) = libm::sincos(f64::from(index) * PI / 3.0);
        Point::new(0.4 * cos, 0.4 * sin)
    });
    let hexagon = Polygon::new(hexagon.collect()).expect("a hexagon");
    for body in [square, hexagon, Polygon::rectangle(0.99, 0.67).expect("a rectangle")] {
        let footprint = Footprint::covering(body.clone());
        assert!(overhang_m(&body, footprint.discs()) < 0.1, "{footprint:?}");
        assert!(footprint.circumscribed_radius_m() < footprint.body_radius_m() + 0.005);
    }
    // A short row suffices for a small body, and costs less time.
    let small = Polygon::rectangle(0.508, 0.43).expect("a rectangle");
    let row = Footprint::covering(small);
    let radius = libm::hypot(0.127, 0.215);
    assert_eq!(row.discs(), [-0.127, 0.127].map(|x| Disc { x, y: 0.0, radius }));
}

/// Random discs are accepted exactly where no random point of the body is outside all of them.
#[test]
fn given_discs_that_leave_a_point_of_the_body_open_are_rejected() {
    let mut rng = Pcg64Mcg::seed_from_u64(2);
    let (mut accepted, mut rejected) = (0, 0);
    for _ in 0..2000 {
        let body = random_polygon(&mut rng);
        let discs: Vec<Disc> = (0..rng.random_range(1..6))
            .map(|_| Disc {
                x: rng.random_range(-0.4..0.4),
                y: rng.random_range(-0.4..0.4),
                radius: rng.random_range(0.2..0.7),
            })
            .collect();
        let open = points_in(&body, &mut rng).into_iter().find(|point| !is_covered(&discs, point));
        match Footprint::with_body(body.clone(), discs.clone()) {
            Ok(_) => {
                accepted += 1;
                assert_eq!(open, None, "{body:?}, {discs:?}");
            }
            Err(error) => {
                rejected += 1;
                assert!(error.to_string().contains("uncovered"), "{error}");
                // Random points may miss a small gap, and do so seldom.
                accepted -= i32::from(open.is_none());
            }
        }
    }
    assert!(accepted > 100 && rejected > 100, "{accepted} accepted, {rejected} rejected");
}

#[test]
fn hole_between_discs_that_cover_the_outline_is_found() {
    let body = Polygon::rectangle(1.0, 1.0).expect("a square");
    let ring: Vec<Disc> = (0..8)
        .map(|index| {
            let (sin, cos) = libm::sincos(f64::from(index) * PI / 4.0);
            Disc { x: 0.55 * cos, y: 0.55 * sin, radius: 0.3 }
        })
        .collect();
    let error = Footprint::with_body(body.clone(), ring.clone()).expect_err("a hole");
    assert!(error.to_string().contains("uncovered"), "{error}");
    let filled = [ring, vec![Disc { x: 0.0, y: 0.0, radius: 0.4 }]].concat();
    Footprint::with_body(body, filled).expect("no hole is left");
}

#[test]
fn settings_file_takes_corners_or_discs_or_both() {
    let parse = |footprint: &str| {
        let text = format!("[robot]\nfootprint = {footprint}\n");
        toml::from_str::<Config>(&text).map(|config| config.robot.footprint)
    };
    let corners = "[[0.35, 0.25], [0.35, -0.25], [-0.35, -0.25], [-0.35, 0.25]]";
    assert_eq!(parse(corners).expect("corners"), Config::default().robot.footprint);
    let text = parse(&format!("\"{corners}\"")).expect("a text, as in Nav2");
    assert_eq!(text, Config::default().robot.footprint);
    let discs = "[{ x = 0.0, y = 0.0, radius = 0.44 }]";
    let round = parse(discs).expect("a disc");
    assert_eq!(round.body(), None);
    let both = parse(&format!("{{ body = {corners}, discs = {discs} }}")).expect("both");
    assert_eq!(
        (both.discs(), both.body()),
        (round.discs(), Config::default().robot.footprint.body())
    );
    for footprint in [Config::default().robot.footprint, round, both] {
        let mut config = Config::default();
        config.robot.footprint = footprint;
        let text = toml::to_string(&config).expect("a settings file");
        assert_eq!(toml::from_str::<Config>(&text).expect("the same file"), config);
    }
    for (footprint, words) in [
        ("\"[[0.3, 0.2], [0.3, -0.2]\"".to_owned(), "is no list of corners"),
        // The discs of earlier versions: the corners of the body are 40 mm outside.
        (
            format!(
                "{{ body = {corners}, discs = [{{ x = 0.12, y = 0, radius = 0.3 }}, \
                 {{ x = -0.12, y = 0, radius = 0.3 }}] }}"
            ),
            "of the body uncovered",
        ),
        ("[[0, 0], [1, 0]]".to_owned(), "fewer than 3"),
        ("[[0, 0], [1, 0], [2, 0]]".to_owned(), "no area"),
        ("[[0, 0], [1, 0], [0, 999]]".to_owned(), "beyond 100 m"),
        (format!("[[0, 0], [1, 0], [0, 1], {}", &discs[1..]), "mixes"),
        (format!("{{ body = {corners} }}"), "missing field `discs`"),
    ] {
        let error = parse(&footprint).expect_err(words).to_string();
        assert!(error.contains(words), "no {words:?} in {error}");
    }
}

#[test]
fn closing_speed_is_that_of_the_nearest_part_of_the_body() {
    let footprint = Config::default().robot.footprint;
    let speed = |twist: Twist, x: f64, y: f64| {
        footprint.closing_speed_m_s(
            &Pose::new(1.0, 2.0, 0.0),
            &twist,
            &Point::new(1.0 + x, 2.0 + y),
        )
    };
    assert!((speed(Twist::new(0.5, 0.0), 1.0, 0.0) - 0.5).abs() < 1e-12);
    assert!((speed(Twist::new(0.5, 0.0), -1.0, 0.1) + 0.5).abs() < 1e-12);
    // The front left corner swings to the left at 0.35 m from the axis.
    assert!((speed(Twist::new(0.0, 1.0), 0.35, 1.0) - 0.35).abs() < 1e-12);
    assert!((speed(Twist::new(0.0, -1.0), 0.35, 1.0) + 0.35).abs() < 1e-12);
}
