//! The player of a report in headless Chromium: it plays, steps and shows the values of the trace, in both themes and on
//! small screens, with an empty console. `support/browser/program.rs` ignores these tests without Chromium.

mod faulty;
mod page;
mod runs;

use libtest_mimic::{Failed, Trial};
use serde_json::{Value, json};

use crate::support::browser::program::{BrowserTest, Program};
use page::{Look, look_at};
use runs::{Run, faulty_run, long_run, protected_run, short_run};

const IN_BROWSER: [(&str, BrowserTest); 6] = [
    ("player_plays_steps_and_shows_the_trace", plays),
    ("player_shows_faults_at_their_ticks", faults),
    ("player_zooms_explains_and_links", views_and_links),
    ("player_fits_a_phone_and_the_dark_theme", fits),
    ("altered_script_is_not_run", altered),
    ("page_of_several_runs_has_a_player_for_each", several),
];

pub fn trials() -> Vec<Trial> {
    let mut trials = crate::support::browser::program::trials(&IN_BROWSER);
    trials.push(Trial::test("pages_of_ten_minutes_and_of_an_hour_are_small", || {
        sizes();
        Ok(())
    }));
    trials.push(Trial::test("page_lists_and_counts_the_actions_of_the_protective_layer", || {
        protective_actions();
        Ok(())
    }));
    trials.push(Trial::test("same_run_gives_the_same_page", || {
        assert!(short_run().page() == short_run().page());
        Ok(())
    }));
    trials
}

fn number(value: &Value, name: &str) -> f64 {
    value[name].as_f64().unwrap_or_else(|| panic!("{name} in {value}"))
}

/// Checks that the player shows the values of the trace at a tick.
#[track_caller]
fn assert_shows(readings: &Value, run: &Run, tick: usize) {
    let row = &run.result.trace.rows[tick];
    for (name, expected) in [
        ("time", format!("{:.2}", row.time_s)),
        ("speed", fixed(row.twist.linear, 2)),
        ("turn_rate", fixed(row.twist.angular, 2)),
        ("gap", fixed(row.gap_m, 3)),
    ] {
        let shown = readings[name].as_str().unwrap_or_default();
        // Both are rounded, one of them from single precision.
        let number = |text: &str| text.parse::<f64>().unwrap_or(f64::NAN);
        assert!(
            (number(shown) - number(&expected)).abs() < 0.0101,
            "tick {tick}, {name}: {shown:?}, not {expected:?}"
        );
    }
    let samples = readings["admissible"].as_str().unwrap_or_default();
    let expected = match row.samples {
        0 => "–".to_owned(),
        samples => format!("{} of {samples}", row.admissible),
    };
    assert_eq!(samples, expected, "tick {tick}");
}

fn fixed(value: f64, digits: usize) -> String {
    format!("{value:.digits$}")
}

fn plays(program: &Program) -> Result<(), Failed> {
    let run = short_run();
    let last = run.result.trace.rows.len() - 1;
    let seen = look_at(program, &run.page(), &Look::default())?;
    assert_eq!(seen.console, [""; 0], "the console is not empty");
    let of = |name: &str| &seen.findings[name];
    assert_eq!(of("last"), &json!(last));
    assert_shows(of("at_first"), &run, 0);
    assert_shows(of("after_two_steps"), &run, 2);
    assert_shows(of("in_the_middle"), &run, last / 2);
    assert_shows(of("at_the_end"), &run, last);
    assert_eq!(of("at_the_end")["mode"], json!("arrived"));
    // The player ran for a while at sixteen times the speed, and stopped at the second click.
    let played = number(&seen.findings, "played_to");
    assert!(played > 2.0 && played <= last as f64, "{played}");
    assert_eq!(of("paused_at"), of("paused_later"));
    assert_eq!(of("labels_while_playing"), &json!(["Pause", "Play"]));
    // The canvas is not empty, and changes with the time and the layers.
    assert!(number(&seen.findings, "colours") > 4.0);
    let pictures =
        ["picture_first", "picture_middle", "picture_without_trajectories", "picture_whole"];
    for (index, one) in pictures.iter().enumerate() {
        for other in &pictures[index + 1..] {
            assert_ne!(of(one), of(other), "{one} and {other}");
        }
    }
    assert_eq!(of("picture_reset"), of("picture_middle"));
    Ok(())
}

fn views_and_links(program: &Program) -> Result<(), Failed> {
    let run = short_run();
    let seen = look_at(program, &run.page(), &Look::default())?;
    assert_eq!(seen.console, [""; 0], "the console is not empty");
    let of = |name: &str| &seen.findings[name];
    // Every change of the view changes the picture; only a moved map is not centred on the robot.
    let views = of("views").as_array().expect("a list");
    for pair in views.windows(2) {
        assert_ne!(pair[0]["picture"], pair[1]["picture"], "{pair:?}");
    }
    let follows: Vec<&str> = views
        .iter()
        .filter(|view| view["follows"] == json!(true))
        .filter_map(|view| view["change"].as_str())
        .collect();
    assert_eq!(follows, ["first", "wheel", "key", "button", "reset"]);
    assert_eq!(views[0]["picture"], views[views.len() - 1]["picture"]);
    let legend = of("legend").to_string();
    for entry in [
        "global path",
        "driven track",
        "lidar returns",
        "sampled trajectories",
        "rejected samples",
        "chosen trajectory",
        "present position",
        "predicted",
        "robot",
        "key node",
        "goal",
        "obstacle",
    ] {
        assert!(legend.contains(entry), "{entry}: {legend}");
    }
    let meanings = of("meanings").as_array().expect("a list");
    assert_eq!(
        meanings.len(),
        seen.findings["at_first"].as_object().map_or(0, serde_json::Map::len)
    );
    for meaning in meanings {
        assert!(meaning["text"].as_str().is_some_and(|text| text.len() > 20), "{meaning}");
        let shown = (&meaning["before"], &meaning["focused"], &meaning["fits"]);
        assert_eq!(shown, (&json!(false), &json!(true), &json!(true)), "{meaning}");
    }
    let rows = &run.result.trace.rows;
    let links = of("links");
    assert_eq!(links["shown"], json!(fixed(rows[7].time_s, 2)));
    assert_eq!(links["address"], json!(format!("#mission-1&t={:.2}", rows[7].time_s)));
    let before = rows.iter().rfind(|row| row.time_s <= 2.35).map(|row| fixed(row.time_s, 2));
    assert_eq!(links["selected"], json!(before));
    let end = format!("/page#mission-1&t={}", before.unwrap_or_default());
    assert!(links["copied"].as_str().is_some_and(|text| text.ends_with(&end)), "{links}");
    assert_eq!(of("contents"), &json!(vec![true; 6]), "a link of the contents has no target");
    assert_eq!(of("copy_is_shown"), &json!(true));
    assert_eq!(of("help"), &json!([false, true, false]));
    Ok(())
}

/// Checks the list, the readings and the timeline against the faults of each tick.
fn faults(program: &Program) -> Result<(), Failed> {
    let run = faulty_run(400);
    let seen = look_at(program, &run.page(), &Look::default())?;
    assert_eq!(seen.console, [""; 0], "the console is not empty");
    let found = &seen.findings["faults"];
    let in_words = |at: &Vec<String>| match at.len() {
        0 => json!("none"),
        _ => json!(at.join("; ")),
    };
    let expected: Vec<Value> = run.observed.at.iter().map(in_words).collect();
    assert_eq!(found["readings"], json!(expected));
    let begun = run.observed.begun();
    // Two kinds of sensor faults, a base fault, and a GPU that is lost and reopened.
    let kinds = |start: &str| begun.iter().filter(|(_, words)| words.starts_with(start)).count();
    assert_eq!((kinds("sensors: "), kinds("base: ")), (2, 1), "{begun:?}");
    assert!(kinds("engine: ") > 3, "{begun:?}");
    let listed = found["listed"].as_array().expect("a list");
    assert_eq!(listed.len(), begun.len());
    for ((tick, words), entry) in begun.iter().zip(listed) {
        let time = format!("{:.2} s {words}", run.result.trace.rows[*tick].time_s);
        let text = entry["text"].as_str().unwrap_or_default();
        assert!(text.starts_with(&time), "{text:?}, not {time:?}");
        assert_eq!(entry["frame"], json!(tick), "{text}");
        assert_eq!(entry["has_focus"], json!(true), "{text}");
        assert_shows(&entry["shown"], &run, *tick);
    }
    assert!(number(found, "marked") > 20.0, "{}", found["marked"]);
    let expected = format!("{} faults are marked", begun.len());
    assert!(found["alt_text"].as_str().is_some_and(|text| text.contains(&expected)));
    // The other run has no fault.
    let sound = look_at(program, &short_run().page(), &Look::default())?;
    let found = &sound.findings["faults"];
    assert_eq!((&found["listed"], &found["marked"]), (&json!([]), &json!(0)));
    assert_eq!(found["text"], json!("Faultsnone"));
    let readings = found["readings"].as_array().expect("a list");
    assert!(readings.iter().all(|text| text == "none"));
    Ok(())
}

fn fits(program: &Program) -> Result<(), Failed> {
    let page = faulty_run(120).page();
    let mut pictures = Vec::new();
    for (width, dark) in [(390, false), (390, true), (1280, true), (1920, false)] {
        let seen = look_at(program, &page, &Look { width, dark })?;
        assert_eq!(seen.console, [""; 0], "the console is not empty");
        let of = |name: &str| number(&seen.findings, name);
        assert!(of("content_width") <= of("window_width"), "{:?}", seen.findings);
        // On a wide window the values stand next to the map.
        assert!(of("map_width") > 0.6 * of("window_width"), "{:?}", seen.findings);
        let meanings = seen.findings["meanings"].as_array().expect("a list");
        assert!(meanings.iter().all(|meaning| meaning["fits"] == json!(true)), "{meanings:?}");
        assert_eq!(seen.findings["is_dark"], json!(dark));
        pictures.push(seen.findings["picture_first"].clone());
    }
    assert_ne!(pictures[0], pictures[1], "both themes have the same colours");
    Ok(())
}

/// The content policy of the page keeps other scripts out.
fn altered(program: &Program) -> Result<(), Failed> {
    let page = short_run().page();
    let own = "Starts the player of a figure";
    assert_eq!(page.matches(own).count(), 1);
    let seen = look_at(program, &page.replace(own, "Stops the players"), &Look::default())?;
    assert_eq!(seen.findings["at_first"]["time"], json!("–"));
    assert!(
        seen.console.iter().any(|line| line.contains("Content Security Policy")),
        "{:?}",
        seen.console
    );
    Ok(())
}

fn several(program: &Program) -> Result<(), Failed> {
    let runs = [short_run(), short_run()];
    let seen = look_at(program, &runs::page_of(&runs), &Look::default())?;
    assert_eq!(seen.findings["players"], json!(2));
    assert_eq!(seen.findings["players_that_show"], json!(2));
    assert_eq!(seen.console, [""; 0]);
    Ok(())
}

/// The lists and the title of the lane have the ticks of the result.
fn protective_actions() {
    for (run, acts) in [(protected_run(), true), (short_run(), false)] {
        let ticks = &run.result.protective_actions;
        let is_reduction =
            |name: &str| ["approach", "slow", "escape", "blind_sector"].contains(&name);
        let sum = |reductions: bool| -> u64 {
            let counted = ticks.iter().filter(|(name, _)| is_reduction(name) == reductions);
            counted.map(|(_, count)| count).sum()
        };
        assert!(!acts || (sum(true) > 0 && sum(false) > 0), "{ticks:?}");
        let page = run.page();
        for (title, count) in [("Stops", sum(false)), ("Reduced commands", sum(true))] {
            let summary =
                format!("<summary>{title} of the protective layer: {count} ticks</summary>");
            assert!(page.contains(&summary), "{summary}");
        }
        assert_eq!(page.contains("</b> stop: a return at ("), ticks.contains_key("stop"));
        let counts: Vec<String> = ticks
            .iter()
            .map(|(name, count)| format!("{} {count}", name.replace('_', " ")))
            .collect();
        if acts {
            let title = format!("\"title\":\"protective layer: {} ticks\"", counts.join(", "));
            assert!(page.contains(&title), "{title}");
        }
    }
}

fn sizes() {
    let ten_minutes = long_run(6000);
    assert_eq!(ten_minutes.result.trace.rows.len(), 6000);
    let page = ten_minutes.page();
    assert!(page.contains("\"frames\":6000"));
    assert!(page.len() < 5_000_000, "{} bytes", page.len());
    let hour = long_run(9000).page();
    assert!(hour.contains("\"frames\":4501"), "every second tick, and the last");
    assert!(hour.len() < page.len());
    // Frames of every second tick and of the last, and the faults of all ticks.
    let faulty = faulty_run(6200);
    let page = faulty.page();
    assert!(page.contains("\"frames\":3101"));
    assert!(page.len() < 5_000_000, "{} bytes", page.len());
    for (tick, words) in faulty.observed.begun().iter().take(4) {
        let words = words.replace('<', "&lt;").replace('>', "&gt;");
        let button =
            format!("data-frame=\"{}\"><b>{:.2} s</b> {words}", tick / 2, *tick as f64 * 0.1);
        assert!(page.contains(&button), "{button}");
    }
}
