//! Pages and pictures: self-contained, well formed, accessible, and the same for the same data.

mod benchmarks;
mod maps;
mod markup;
mod scene;

use std::sync::Arc;

use inbye::bench::{DensityRow, QualityRow};
use inbye::experiment::Group;
use inbye::geometry::{Point, Pose};
use inbye::global::Path;
use inbye::map::{GridFrame, OccupancyGrid};
use inbye::report::{BenchReport, Report, bench_svg, html};
use inbye::runtime::{Config, EarlyEnd, Trace};
use markup::{attribute, check_well_formed, numbers_that_are_none, opening_tag, pictures};
use scene::{Scene, closed_loop, comparisons, density, quality, scene, skipped};

fn page_with(scenes: &[Scene]) -> String {
    html(&Report {
        title: "Missions",
        intro: "A first paragraph.\n\nA second one.",
        machine: "a made machine",
        missions: scenes.iter().map(Scene::view).collect(),
        comparisons: &comparisons(),
        density: &density(),
        skipped: &skipped(),
        quality: &quality(),
        density_command: "inbye bench density",
    })
}

/// A path with other points.
fn altered(path: &Path, alter: impl FnOnce(&mut [Point])) -> Path {
    let mut points = path.points().to_vec();
    alter(&mut points);
    Path::new(points)
}

/// The picture of the density benchmark.
fn density_picture(
    density: &[DensityRow],
    quality: &[QualityRow],
    closed_loop: &[Group],
) -> String {
    bench_svg(&BenchReport { density, quality, closed_loop, ..BenchReport::default() })
}

/// Checks what holds for every page.
fn check(page: &str) {
    let without_namespace = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for outside in ["http://", "https://", "<script", "<link", "@import", "url("] {
        assert!(!without_namespace.contains(outside), "the page refers to {outside}");
    }
    assert_eq!(numbers_that_are_none(page), [""; 0]);
    for picture in pictures(page) {
        let tag = opening_tag(picture);
        let says_something = attribute(tag, "aria-label").is_some_and(|label| label.len() > 20);
        let decoration = attribute(tag, "aria-hidden") == Some("true");
        assert!(says_something || decoration, "no text alternative: {tag}");
        assert!(attribute(tag, "role").is_some(), "no role: {tag}");
        assert_eq!(check_well_formed(picture), Ok(()), "{picture}");
    }
}

#[test]
fn whole_page_is_self_contained_well_formed_and_accessible() {
    let page = page_with(&[scene(400)]);
    check(&page);
    let drawn = pictures(&page);
    let images = drawn.iter().filter(|picture| picture.contains("role=\"img\""));
    // Map, motion, gap, latency over time, its distribution, density, quality.
    assert_eq!(images.count(), 7);
    assert_eq!(
        page.matches("<table").count(),
        10,
        "one table for each picture, one of paths, one of engines, one of densities"
    );
}

#[test]
fn checks_find_broken_markup() {
    for broken in [
        "<svg><g></svg></g>",
        "<svg><line x1=\"1\"></svg>",
        "<svg><line x1=1></line></svg>",
        "<svg><line x=\"1\" x=\"2\"></line></svg>",
        "<svg><text>a & b</text></svg>",
    ] {
        assert!(check_well_formed(broken).is_err(), "{broken}");
    }
    assert_eq!(numbers_that_are_none("x=\"NaN\" y=\"-inf\" an information"), ["NaN", "inf"]);
}

#[test]
fn same_data_give_the_same_bytes() {
    assert_eq!(page_with(&[scene(120)]), page_with(&[scene(120)]));
}

#[test]
fn hostile_text_is_escaped() {
    let mut made = scene(30);
    let hostile = "</title><script>alert('&')</script>\"";
    hostile.clone_into(&mut made.result.engine);
    let facts = [(hostile.to_owned(), hostile.to_owned())];
    let mut view = made.view();
    (view.title, view.command, view.facts) = (hostile, hostile, &facts);
    let mut rows = density();
    for row in &mut rows {
        (row.adapter, row.name) = (Some(hostile.to_owned()), hostile.to_owned());
    }
    let mut cells = skipped();
    (cells[0].name, cells[0].reason) = (hostile.to_owned(), hostile.to_owned());
    let page = html(&Report {
        title: hostile,
        intro: hostile,
        machine: hostile,
        missions: vec![view],
        density: &rows,
        skipped: &cells,
        density_command: hostile,
        ..Report::default()
    });
    check(&page);
    check(&density_picture(&rows, &[], &[]));
    assert!(page.contains("&lt;script&gt;"));
}

#[test]
fn robot_is_drawn_as_its_body() {
    let mut made = scene(600);
    let [discs, polygon] =
        ["circle", "polygon"].map(|part| format!("<g class=\"footprint\"><{part} "));
    let page = page_with(&[made.clone()]);
    assert!(page.contains(&discs) && !page.contains(&polygon));
    made.config.robot.footprint = Config::default().robot.footprint;
    let page = page_with(&[made]);
    check(&page);
    assert!(page.contains(&polygon) && !page.contains(&discs));
}

#[test]
fn page_without_data_says_so() {
    let empty = html(&Report::default());
    check(&empty);
    assert!(empty.contains("There is no mission in this report."));
    assert!(pictures(&empty).is_empty());

    let mut made = scene(50);
    made.result.trace = Trace::default();
    let page = html(&Report {
        missions: vec![made.view()],
        density_command: "inbye bench density",
        ..Report::default()
    });
    check(&page);
    for sentence in [
        "The run has no tick, so there is no motion to show.",
        "No obstacle was in range at any tick.",
        "No decision of this run was timed.",
        "No engine was timed at any density.",
    ] {
        assert!(page.contains(sentence), "{sentence}");
    }
}

#[test]
fn trails_begin_when_an_obstacle_appears() {
    let trails =
        |made: &Scene| page_with(std::slice::from_ref(made)).matches("class=\"trail\"").count();
    let mut made = scene(60);
    let all = trails(&made);
    for row in &mut made.result.trace.rows[..30] {
        row.moving[1] = None;
    }
    check(&page_with(std::slice::from_ref(&made)));
    assert_eq!(trails(&made), all);
    for row in &mut made.result.trace.rows {
        row.moving[1] = None;
    }
    check(&page_with(std::slice::from_ref(&made)));
    assert_eq!(trails(&made), all - 1);
}

#[test]
fn numbers_that_are_not_finite_are_left_out() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut made = scene(60);
        for tick in [0, 7, 30, 59] {
            let row = &mut made.result.trace.rows[tick];
            (row.gap_m, row.pose.x, row.pose.yaw, row.twist.linear) = (bad, bad, bad, bad);
            (row.command.angular, row.local_target.x) = (bad, bad);
            row.moving[0] = Some(Point::new(1.0, bad));
            made.result.decision_s[tick] = bad;
        }
        made.result.trace.rows[20].time_s = bad;
        let (result, mission) = (&mut made.result, &mut made.mission);
        let plan = &mut result.plans[0];
        plan.smoothed = altered(&plan.smoothed, |points| points[3].x = bad);
        plan.pruned = altered(&plan.pruned, |points| points[1].y = bad);
        (result.min_clearance_m, result.final_error_m, result.final_yaw_error) =
            (bad, (bad, bad), Some(bad));
        (mission.start, mission.goal.position) = (Pose::new(bad, 0.0, bad), Point::new(0.0, bad));
        made.config.local.control_period_s = bad;
        let mut rows = density();
        (rows[0].p50_ms, rows[4].p99_ms, rows[7].steps_per_s) = (bad, bad, bad);
        let mut lost = quality();
        (lost[0].window_s, lost[1].regret_p50, lost[2].v_off_p50_m_s) = (bad, Some(bad), Some(bad));
        (lost[3].regret_max, lost[4].omega_off_max_rad_s) = (None, Some(bad));
        let page = html(&Report {
            missions: vec![made.view()],
            density: &rows,
            quality: &lost,
            ..Report::default()
        });
        check(&page);
        let mut driven = closed_loop();
        (driven[0].shared_time_p50_s, driven[3].shared_time_p90_s) = (Some(bad), Some(bad));
        check(&density_picture(&rows, &lost, &driven));
    }
}

/// The picture of `bench density --chart` has no page around it.
#[test]
fn density_picture_needs_no_page() {
    let picture = density_picture(&density(), &quality(), &[]);
    check(&picture);
    assert!(picture.starts_with("<svg") && picture.contains("</style>"));
    // Colours, texts and legends are part of the picture.
    for drawn in [
        ".series-0 { color: #0068a8; }",
        "prefers-color-scheme: dark",
        "CPU, 16 threads, AVX2",
        "NVIDIA H200",
        "20 Hz",
        "100 Hz",
        "window 0.1 s, arcs, v : omega = 1:1",
        "window 1 s, arcs, v : omega = 1:4",
    ] {
        assert!(picture.contains(drawn), "{drawn}");
    }
    // A curve for each engine, and for each window and shape.
    assert_eq!(picture.matches("<polyline class=\"median\"").count(), 3 + 4);
    let alone = density_picture(&density(), &[], &[]);
    check(&alone);
    assert_eq!(alone.matches("<polyline class=\"median\"").count(), 3);
    let empty = density_picture(&[], &[], &[]);
    assert_eq!(check_well_formed(&empty), Ok(()));
    assert!(empty.contains("No engine was timed at any density."));
}

/// The closed loop has its own chart over the same axis, if missions were driven.
#[test]
fn density_picture_shows_the_closed_loop() {
    let picture = density_picture(&density(), &quality(), &closed_loop());
    check(&picture);
    for drawn in [
        "Goal reached, % of 12 missions",
        "Time of missions reached by all (6 of 12), s",
        "v : omega = 1:1: 50 % and 40.0 s with 64 samples, 100 % and 30.0 s with 16384 samples.",
        "v : omega = 1:4: 50 % and no time with 64 samples,",
    ] {
        assert!(picture.contains(drawn), "{drawn}");
    }
    // A curve of times for each shape, after the engines and the windows, and a bar of success for each density.
    let medians = |picture: &str| picture.matches("<polyline class=\"median\"").count();
    assert_eq!(medians(&picture), 3 + 4 + 2);
    assert_eq!(picture.matches(" marker\" x=").count(), 10);
    assert_eq!(medians(&density_picture(&[], &[], &closed_loop())), 2);
    let mut none = closed_loop();
    none.iter_mut().for_each(|row| row.runs = 0);
    let without = density_picture(&density(), &quality(), &none);
    assert_eq!(medians(&without), 3 + 4);
    assert!(!without.contains("Goal reached"));
}

#[test]
fn skipped_cells_are_listed_with_their_reason() {
    let page = page_with(&[]);
    assert!(page.contains(
        "SwiftShader Device (Subzero) with 1048576 samples: a decision would take about 6.2 s"
    ));
}

#[test]
fn contact_is_marked_on_the_map_and_in_text() {
    let mut made = scene(100);
    made.result.trace.rows[40].gap_m = -0.02;
    (made.result.collided, made.result.reached) = (true, false);
    let page = html(&Report { missions: vec![made.view()], ..Report::default() });
    check(&page);
    assert!(page.contains("✗ contact") && page.contains("✗ goal not reached"));
    // One on the map, one in its legend.
    assert_eq!(page.matches("<path class=\"contact-mark\"").count(), 2);
}

#[test]
fn outcome_names_what_ended_a_drive_early() {
    for (early_end, outcome) in [
        (None, "✗ time limit before the goal"),
        (Some(EarlyEnd::Interrupted), "✗ interrupted before the goal"),
        (Some(EarlyEnd::RobotStopped), "✗ goal not reached"),
    ] {
        let mut made = scene(100);
        (made.result.reached, made.result.early_end) = (false, early_end);
        let page = html(&Report { missions: vec![made.view()], ..Report::default() });
        check(&page);
        // In the contents and in the section.
        assert_eq!(page.matches(outcome).count(), 2, "{outcome}");
    }
}

#[test]
fn pages_of_long_runs_are_small() {
    let three = page_with(&[scene(1000), scene(1000), scene(1000)]);
    assert!(three.len() < 600_000, "three missions of 1000 ticks take {} bytes", three.len());
    let long = page_with(&[scene(6000)]);
    check(&long);
    assert!(long.len() < 400_000, "a mission of 6000 ticks takes {} bytes", long.len());
}

#[test]
fn large_map_is_cropped_or_scaled_down() {
    let mut cropped = scene(200);
    cropped.mission.map = Arc::new(pillars_of(2230, 1470));
    let page = page_with(std::slice::from_ref(&cropped));
    check(&page);
    assert!(page.len() < 300_000, "{} bytes", page.len());

    // A path from corner to corner shows the whole map.
    let mut whole = cropped;
    whole.result.plans[0].smoothed =
        Path::new(vec![Point::new(-1.0, -1.0), Point::new(270.0, 178.0)]);
    let page = page_with(&[whole]);
    check(&page);
    assert!(page.len() < 300_000, "{} bytes", page.len());
}

/// Pillars with rough walls as in a mine map: roadways 2 to 5 m wide at 0.125 m.
fn pillars_of(width: i32, height: i32) -> OccupancyGrid {
    let frame =
        GridFrame { width, height, resolution_m: 0.125, origin: Pose::new(-2.0, -2.0, 0.0) };
    OccupancyGrid::from_fn(frame, |cell| {
        let (x, y) = (f64::from(cell.column), f64::from(cell.row));
        let rough =
            5.0 * libm::sin(x / 7.0) * libm::cos(y / 5.0) + 3.0 * libm::sin((x + 2.0 * y) / 3.0);
        let pillar = (x + rough) % 90.0 > 30.0 && (y - rough) % 70.0 > 25.0;
        i8::from(pillar) * 100
    })
}

/// Compares one small picture byte by byte. `INBYE_BLESS=1` renews the file after a reviewed change.
#[test]
fn gap_chart_equals_the_golden_file() {
    let page = page_with(&[scene(40)]);
    let picture = pictures(&page)
        .into_iter()
        .find(|picture| picture.contains("aria-label=\"Gap between"))
        .expect("the page has a gap picture")
        .replace("><", ">\n<");
    let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/goldens/gap.svg");
    if std::env::var_os("INBYE_BLESS").is_some_and(|value| value == "1") {
        std::fs::write(golden, format!("{picture}\n")).expect("the golden file can be written");
    }
    let expected = std::fs::read_to_string(golden).unwrap_or_default();
    assert!(
        expected.trim_end() == picture,
        "the gap picture differs from tests/goldens/gap.svg: if the change is meant, run the test again with \
         INBYE_BLESS=1 and review the file's difference. The picture is now:\n{picture}"
    );
}
