//! The pages and pictures of benchmarks.

use inbye::experiment::{
    ContactCause, Group, RunOutcome, RunRow, TrafficKind, WorldKind, ablation_groups,
};
use inbye::report::{BenchReport, bench_files, bench_svg};
use roxmltree::Document;

use super::check;
use super::scene::{closed_loop, density, quality, skipped};

/// In world 7 all runs reach the goal, in world 5 one of two gives up, in world 9 none reaches it.
fn barn() -> Vec<RunRow> {
    let run = |world: u32, seed, outcome, time_s, score| RunRow {
        kind: WorldKind::Barn,
        world: world.to_string(),
        seed,
        outcome,
        time_s,
        optimal_time_s: Some(5.0),
        score: Some(score),
        ..RunRow::default()
    };
    vec![
        run(5, 0, RunOutcome::Reached, 12.0, 0.42),
        run(5, 1, RunOutcome::Failed, 62.0, 0.0),
        run(7, 0, RunOutcome::Reached, 8.0, 0.5),
        run(7, 1, RunOutcome::Reached, 9.0, 0.5),
        run(9, 0, RunOutcome::Contact, 3.0, 0.0),
        run(9, 1, RunOutcome::Timeout, 100.0, 0.0),
    ]
}

fn dynabarn() -> Vec<RunRow> {
    let run = |world: u32, outcome, contact_cause| RunRow {
        kind: WorldKind::DynaBarn,
        world: world.to_string(),
        outcome,
        contact_cause,
        time_s: 11.0,
        ..RunRow::default()
    };
    vec![
        run(0, RunOutcome::Reached, None),
        run(2, RunOutcome::Contact, Some(ContactCause::Robot)),
        run(4, RunOutcome::Contact, Some(ContactCause::Avoidable)),
        run(6, RunOutcome::Contact, Some(ContactCause::Other)),
    ]
}

/// On one map both missions reach their goal; on the other one of four does, and the others end differently.
fn soak() -> Vec<RunRow> {
    let run = |map: &str, seed, outcome, contact_cause| RunRow {
        kind: WorldKind::Missions,
        world: map.to_owned(),
        seed,
        traffic: Some(if seed > 2 { TrafficKind::NonYielding } else { TrafficKind::None }),
        obstacles: usize::from(seed > 2),
        outcome,
        time_s: 20.0 * seed as f64,
        path_m: Some(10.0),
        min_clearance_m: Some(0.1 * seed as f64),
        contact_cause,
        reason: (outcome != RunOutcome::Reached).then(|| format!("<b>reason</b> {seed}")),
        ..RunRow::default()
    };
    let other = Some(ContactCause::Other);
    vec![
        run("an easy map", 1, RunOutcome::Reached, None),
        run("an easy map", 2, RunOutcome::Reached, None),
        run("<script>", 3, RunOutcome::Reached, None),
        run("<script>", 4, RunOutcome::Contact, other),
        run("<script>", 5, RunOutcome::Failed, None),
        run("<script>", 6, RunOutcome::Timeout, None),
    ]
}

fn ablation() -> Vec<Group> {
    let of_variant = |config: &'static str| {
        soak().into_iter().map(move |row| RunRow { config: Some(config.to_owned()), ..row })
    };
    let rows = ["dwa", "recovery"].into_iter().flat_map(of_variant);
    ablation_groups(&rows.collect::<Vec<_>>())
}

fn page_of(report: &BenchReport) -> String {
    let files = bench_files(report);
    assert_eq!(files[0].name, "index.html");
    files[0].text.clone()
}

#[test]
fn page_of_all_benchmarks_is_self_contained_and_links_its_files() {
    let report = BenchReport {
        title: "All",
        machine: "a made machine",
        command: "inbye bench draw",
        density: &density(),
        skipped: &skipped(),
        quality: &quality(),
        closed_loop: &closed_loop(),
        barn: &barn(),
        dynabarn: &dynabarn(),
        soak: &soak(),
        ablation: &ablation(),
        ..BenchReport::default()
    };
    let files = bench_files(&report);
    let page = page_of(&report);
    check(&page);
    // A soak has three charts, an ablation two.
    assert_eq!(page.matches("role=\"img\"").count(), 5 + 3 + 2);
    // One for each chart, the most samples at each rate, and the missions that did not reach their goal.
    assert_eq!(page.matches("<table").count(), 5 + 3 + 2 + 2);
    for file in &files[1..] {
        assert!(page.contains(&format!("href=\"{}\"", file.name)), "{}", file.name);
        if file.text.starts_with("<svg") {
            check(&file.text);
        }
    }
    assert_eq!(files.len(), 1 + 7 * 3);
    assert_eq!(files, bench_files(&report));
    check(&bench_svg(&report));
}

#[test]
fn worlds_are_sorted_from_the_easiest_to_the_hardest() {
    let picture = bench_svg(&BenchReport { barn: &barn(), ..BenchReport::default() });
    let document = Document::parse(&picture).expect("sound markup");
    let titles = document.descendants().filter(|node| node.has_tag_name("title"));
    let tooltips: Vec<&str> = titles.filter_map(|node| node.text()).collect();
    let expected = [
        "world 7: 2 of 2 runs reached the goal, in 8.0 to 9.0 s",
        "world 5: 1 of 2 runs reached the goal, in 12.0 to 12.0 s",
        "world 9: 0 of 2 runs reached the goal",
    ];
    // In the panel of the ends and in that of the times.
    assert_eq!(tooltips, [expected, expected].concat());
    let drawn = |class: &str| {
        let node = |node: &roxmltree::Node| node.attribute("class") == Some(class);
        document.descendants().filter(node).count()
    };
    // Each end in a world and in the legend; the medians of two worlds and the legend.
    for class in ["end-contact", "end-stopped", "end-timeout"] {
        assert_eq!(drawn(class), 2, "{class}");
    }
    assert_eq!((drawn("end-avoidable"), drawn("end-hit")), (0, 0));
    assert_eq!(drawn("series-0 middle-mark"), 3);
    assert!(picture.contains("full score up to here"));
}

#[test]
fn contacts_are_coloured_by_their_cause() {
    let picture = bench_svg(&BenchReport { dynabarn: &dynabarn(), ..BenchReport::default() });
    for class in ["end-contact", "end-avoidable", "end-hit"] {
        let drawn = picture.matches(&format!("<rect class=\"{class}\"")).count();
        assert_eq!(drawn, 2, "{class}");
    }
    assert!(!picture.contains("<rect class=\"end-stopped\""));
}

/// Two sets of weights with two samplings each, and one of them in scenes.
fn sweep() -> Vec<Group> {
    let group = |kind, weights: &str, samples: u32, reached, mean_shared_time_s| Group {
        kind,
        weights: Some(weights.to_owned()),
        engine: "cpu".to_owned(),
        vx_samples: 16,
        vtheta_samples: samples / 16,
        samples: u64::from(samples),
        runs: 10,
        reached,
        contacts: 1,
        timeouts: 0,
        failed: 9 - reached,
        mean_time_s: mean_shared_time_s,
        mean_shared_time_s,
        shared: 4,
        mean_score: Some(0.4),
        ..Group::default()
    };
    vec![
        group(WorldKind::Barn, "paper <&>", 256, 7, Some(30.5)),
        group(WorldKind::Barn, "paper <&>", 1024, 9, Some(29.0)),
        group(WorldKind::Barn, "fast", 256, 4, Some(12.5)),
        group(WorldKind::Barn, "fast", 1024, 5, Some(f64::NAN)),
        group(WorldKind::Scenes, "fast", 256, 0, None),
    ]
}

#[test]
fn sweep_has_a_chart_for_each_kind_of_worlds() {
    let groups = sweep();
    let report = BenchReport { title: "A sweep", sweep: &groups, ..BenchReport::default() };
    let page = page_of(&report);
    check(&page);
    let names: Vec<String> = bench_files(&report).into_iter().map(|file| file.name).collect();
    let expected = |chart: &str| ["csv", "json", "svg"].map(|ending| format!("{chart}.{ending}"));
    assert_eq!(names[1..], [expected("groups-barn"), expected("groups-scenes")].concat());
    for text in [
        "Goal reached, % of 10 runs",
        "Mean time of the 4 runs that all reached, s",
        "paper &lt;&amp;&gt;: 70.0 % and 30.5 s with 256 samples, 90.0 % and 29.0 s with 1024 samples.",
        "fast: 40.0 % and 12.5 s with 256 samples, 50.0 % and no time with 1024 samples.",
        "fast: 0.0 % and no time with 256 samples",
    ] {
        assert!(page.contains(text), "{text}");
    }
    let picture = bench_svg(&report);
    check(&picture);
    // Success of each group, times of the groups that have one, and a legend entry for each curve.
    assert_eq!(picture.matches("class=\"marker\"").count(), 5 + 3 + 3);
}

/// Samplings with one number of samples lay on a vertical line of one series.
#[test]
fn samplings_of_one_number_and_several_shapes_are_several_series() {
    let group = |vx_samples, vtheta_samples| Group {
        kind: WorldKind::Barn,
        vx_samples,
        vtheta_samples,
        samples: 256,
        runs: 10,
        reached: 5,
        ..Group::default()
    };
    let groups = [group(8, 32), group(16, 16), group(4, 64)];
    let picture = bench_svg(&BenchReport { sweep: &groups, ..BenchReport::default() });
    for name in ["v : omega = 1:4", "v : omega = 1:1", "v : omega = 1:16"] {
        assert!(picture.contains(name), "{name}");
    }
    let one_shape = [
        group(8, 32),
        Group { vx_samples: 16, vtheta_samples: 64, samples: 1024, ..group(16, 64) },
    ];
    let picture = bench_svg(&BenchReport { sweep: &one_shape, ..BenchReport::default() });
    assert!(!picture.contains("v : omega"));
}

#[test]
fn closed_loop_names_samplers_where_they_differ() {
    let mut groups = closed_loop();
    let picture = |groups: &[Group]| {
        bench_svg(&BenchReport { closed_loop: groups, ..BenchReport::default() })
    };
    assert!(!picture(&groups).contains("arcs, v : omega"));
    groups[0].config = Some("two_segments".to_owned());
    let picture = picture(&groups);
    assert!(picture.contains("two_segments, v : omega") && picture.contains("arcs, v : omega"));
}

#[test]
fn wrong_planners_have_a_bar_with_the_layer_and_one_without() {
    let with = |config: &str, row: RunRow| RunRow { config: Some(config.to_owned()), ..row };
    let rows: Vec<RunRow> = soak()
        .into_iter()
        .flat_map(|row| [with("with the layer", row.clone()), with("without the layer", row)])
        .collect();
    let report = BenchReport { title: "Wrong", protection: &rows, ..BenchReport::default() };
    let page = page_of(&report);
    check(&page);
    for text in [
        "with the layer: 0 contacts by the robot",
        "without the layer: 0 contacts by the robot",
        "with the layer: missions",
    ] {
        assert!(page.contains(text), "{text}");
    }
    assert!(!page.contains("Soak"));
}

#[test]
fn ends_of_a_soak_are_stacked_by_map_and_by_traffic() {
    let rows = soak();
    let picture = bench_svg(&BenchReport { soak: &rows, ..BenchReport::default() });
    let document = Document::parse(&picture).expect("sound markup");
    let titles = document.descendants().filter(|node| node.has_tag_name("title"));
    let tooltips: Vec<&str> = titles.filter_map(|node| node.text()).collect();
    let ends = [
        "all missions: 3 of 6 reached",
        "<script>: 1 of 4 reached",
        "an easy map: 2 of 2 reached",
        "no pedestrians: 2 of 2 reached",
        "pedestrians that ignore the robot: 1 of 4 reached",
    ];
    assert_eq!(tooltips[..5], ends);
    // The second and the third chart: time per metre, and gaps.
    assert_eq!(
        [tooltips[5], tooltips[10]],
        ["all missions: median 4.00", "all missions: median 0.200"]
    );
    // Each end in the rows of all missions, of its map and of its traffic, and in the legend.
    for class in ["end-hit", "end-stopped", "end-timeout"] {
        let bars = document.descendants().filter(|node| node.attribute("class") == Some(class));
        let widths: Vec<&str> = bars.filter_map(|bar| bar.attribute("width")).collect();
        assert_eq!(widths.len(), 4, "{class}");
        // One of six missions, and one of the four on the map.
        let width = |index: usize| widths[index].parse::<f64>().expect("a number");
        assert!((width(1) / width(0) - 1.5).abs() < 0.01, "{widths:?}");
    }
    assert!(!picture.contains("<rect class=\"end-contact\""));
}

#[test]
fn bad_times_and_hostile_text_leave_pages_sound() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0] {
        let mut rows = barn();
        rows[0].time_s = bad;
        (rows[2].optimal_time_s, rows[3].score) = (Some(bad), Some(bad));
        let mut moving = dynabarn();
        moving[0].time_s = bad;
        let mut missions = soak();
        (missions[0].time_s, missions[1].path_m, missions[2].min_clearance_m) =
            (bad, Some(bad), Some(bad));
        let report = BenchReport {
            title: "</title><script>alert('&')</script>",
            intro: "<script>",
            machine: "<script>",
            command: "<script>",
            barn: &rows,
            dynabarn: &moving,
            soak: &missions,
            ..BenchReport::default()
        };
        check(&page_of(&report));
        check(&bench_svg(&report));
    }
}

#[test]
fn page_without_rows_says_so() {
    let page = page_of(&BenchReport::default());
    check(&page);
    assert!(page.contains("No engine was timed at any density."));
    assert_eq!(bench_files(&BenchReport::default()).len(), 1);
}
