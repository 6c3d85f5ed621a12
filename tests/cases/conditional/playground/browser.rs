//! The page in a browser, used with mouse, keys and touch.

use libtest_mimic::{Failed, Trial};
use serde_json::{Value, json};

use super::devtools::{DESKTOP, Look, PHONE, Page, SHIFT, WEBGPU};
use super::served::Served;
use crate::support::browser::program::{self, BrowserTest, Program};

const TRIALS: [(&str, BrowserTest); 10] = [
    ("dragging_changes_winner_and_bits_agree", dragging_changes_winner),
    ("browser_and_server_agree_on_65536_samples", dense_sampling_agrees),
    ("page_shows_wrong_bit", page_shows_wrong_bit),
    ("page_shows_changed_shader", page_shows_changed_shader),
    ("page_without_webgpu_shows_server_decision", page_without_webgpu_shows_server_decision),
    ("page_recovers_from_lost_gpu_and_reports_lost_server", page_recovers_from_losses),
    ("drag_never_waits_for_decision_and_latest_wins", drag_never_waits_for_decision),
    ("page_is_usable_with_keys_alone", page_is_usable_with_keys_alone),
    ("page_fits_phone_and_dark_mode", page_fits_phone_and_dark_mode),
    ("page_shows_own_map_and_limits", page_shows_own_map_and_limits),
];

pub fn trials() -> Vec<Trial> {
    program::trials(&TRIALS)
}

/// No decision is in progress, and one is shown.
const SETTLED: &str = "document.querySelector('#results')?.getAttribute('aria-busy') === 'false' && \
    document.querySelector('#announcement').textContent !== '' && \
    document.querySelector('#announcement').textContent === document.querySelector('#winner').textContent";

fn open(program: &Program, served: &Served, flags: &[&str], look: Look) -> Result<Page, Failed> {
    let mut page = Page::open(program, flags, look, &served.url)?;
    page.wait_for(SETTLED)?;
    Ok(page)
}

fn text(page: &mut Page, selector: &str) -> Result<String, Failed> {
    let found =
        page.evaluate(&format!("document.querySelector({}).textContent", json!(selector)))?;
    Ok(found.as_str().unwrap_or_default().to_owned())
}

/// Number of started decisions.
const DECISIONS: &str = "Number(document.querySelector('#results').dataset.decisions)";

/// Performs an action and waits for its decision.
fn decide(
    page: &mut Page,
    action: impl FnOnce(&mut Page) -> Result<(), Failed>,
) -> Result<(), Failed> {
    let before = page.evaluate(DECISIONS)?;
    action(page)?;
    page.wait_for(&format!("{DECISIONS} > {before}"))?;
    page.wait_for(SETTLED)
}

/// Waits for four frames: the page needs one to resize and one to draw.
const FRAMES: &str = "new Promise((resolve) => { let left = 4; \
    const next = () => left-- > 0 ? requestAnimationFrame(next) : resolve(); next(); })";

/// The middle of an element in the window, which is scrolled to it.
fn place(page: &mut Page, selector: &str) -> Result<(f64, f64), Failed> {
    let expression = format!(
        "(() => {{ const element = document.querySelector({}); element.scrollIntoView({{ block: 'center' }}); \
         const box = element.getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]; }})()",
        json!(selector)
    );
    let found = page.evaluate(&expression)?;
    let number = |index: usize| found[index].as_f64().ok_or("no position");
    Ok((number(0)?, number(1)?))
}

/// The middle of an element on the page, independent of scrolling.
fn on_page(page: &mut Page, selector: &str) -> Result<(f64, f64), Failed> {
    let (x, y) = place(page, selector)?;
    let scrolled = page.evaluate("[window.scrollX, window.scrollY]")?;
    let number = |index: usize| scrolled[index].as_f64().unwrap_or_default();
    Ok((x + number(0), y + number(1)))
}

fn focus(page: &mut Page, selector: &str) -> Result<(), Failed> {
    page.evaluate(&format!("document.querySelector({}).focus()", json!(selector)))?;
    Ok(())
}

#[track_caller]
fn assert_agrees(page: &mut Page) -> Result<(), Failed> {
    let agreement = text(page, "#agreement")?;
    let explanation = text(page, "#explanation")?;
    assert_eq!(agreement, "agree, bit for bit", "{explanation}");
    let own = text(page, "#digest-own")?;
    assert_eq!(own.len(), 64, "{own}");
    assert_eq!(own, text(page, "#digest-cpu")?);
    Ok(())
}

#[track_caller]
fn assert_quiet(page: &Page) {
    assert_eq!(page.console, [""; 0], "messages on the console");
}

fn dragging_changes_winner(program: &Program) -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let mut page = open(program, &served, &WEBGPU, DESKTOP)?;
    assert_agrees(&mut page)?;
    page.photograph("first")?;
    let digest = text(&mut page, "#digest-own")?;
    let announcement = text(&mut page, "#announcement")?;
    let robot = place(&mut page, "[data-handle=robot]")?;
    let before = on_page(&mut page, "[data-handle=robot]")?;
    let label = "document.querySelector('[data-handle=robot]').getAttribute('aria-label')";
    let label_before = page.evaluate(label)?;
    decide(&mut page, |page| page.drag(robot, (robot.0 + 60.0, robot.1 - 30.0)))?;
    assert_agrees(&mut page)?;
    assert_ne!(text(&mut page, "#digest-own")?, digest);
    page.wait_for(&format!(
        "document.querySelector('#announcement').textContent !== {}",
        json!(announcement)
    ))?;
    // The handle and its label have followed the pointer.
    let now = on_page(&mut page, "[data-handle=robot]")?;
    assert!(
        (now.0 - before.0 - 60.0).abs() < 2.0 && (now.1 - before.1 + 30.0).abs() < 2.0,
        "{before:?} to {now:?}"
    );
    assert_ne!(page.evaluate(label)?, label_before);
    for handle in ["goal", "heading", "'obstacle 0'", "'velocity 0'"] {
        let before = text(&mut page, "#digest-own")?;
        let at = place(&mut page, &format!("[data-handle={handle}]"))?;
        decide(&mut page, |page| page.drag(at, (at.0 - 25.0, at.1 - 40.0)))?;
        assert_agrees(&mut page)?;
        assert_ne!(text(&mut page, "#digest-own")?, before, "{handle}");
    }
    for button in ["#add", "#step", "#remove", "#reset"] {
        let at = place(&mut page, button)?;
        decide(&mut page, |page| page.click(at))?;
        assert_agrees(&mut page)?;
    }
    assert_eq!(text(&mut page, "#digest-own")?, digest, "as at first");
    // Under the pointer.
    let canvas = place(&mut page, "#canvas")?;
    page.mouse("mouseMoved", (canvas.0 + 40.0, canvas.1 + 20.0), 0)?;
    page.wait_for("document.querySelector('#selected-text').textContent.startsWith('sample ')")?;
    let selected = "document.querySelector('[data-term=v] td:last-child').textContent";
    assert_ne!(page.evaluate(selected)?, json!("–"));
    page.photograph("dragged")?;
    assert_quiet(&page);
    Ok(())
}

fn dense_sampling_agrees(program: &Program) -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let mut page = open(program, &served, &WEBGPU, DESKTOP)?;
    for (slider, count) in [("#vx_samples", "128"), ("#vtheta_samples", "512")] {
        focus(&mut page, slider)?;
        page.press("Home", 0, 1)?;
        let shown = format!("{slider} ~ *, label:has({slider}) output");
        for _ in 0..30 {
            if text(&mut page, &shown)? == count {
                break;
            }
            page.press("ArrowRight", 0, 1)?;
        }
        assert_eq!(text(&mut page, &shown)?, count);
    }
    page.wait_for(
        "document.querySelector('[data-reading=admissible] dd').textContent.endsWith('of 65,536')",
    )?;
    page.wait_for(SETTLED)?;
    assert_agrees(&mut page)?;
    // The same problem from another client.
    let problem = served.dense_problem(128, 512)?;
    let answer = served.request("POST", "/decision", &problem.to_string())?.json()?;
    assert_eq!(answer["cpu"]["digest"], json!(text(&mut page, "#digest-own")?));
    assert!(text(&mut page, "[data-reading='browser, last'] dd")?.contains(" ms"));
    assert!(text(&mut page, "[data-reading='browser, cold start'] dd")?.contains(" ms"));
    page.photograph("dense")?;
    assert_quiet(&page);
    Ok(())
}

fn page_shows_wrong_bit(program: &Program) -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let mut page = open(program, &served, &WEBGPU, DESKTOP)?;
    assert_agrees(&mut page)?;
    page.evaluate("document.querySelector('details').open = true")?;
    let flip = place(&mut page, "#flip")?;
    decide(&mut page, |page| page.click(flip))?;
    assert_eq!(text(&mut page, "#agreement")?, "differ");
    let explanation = text(&mut page, "#explanation")?;
    // The middle of 20 x 40 samples; its values differ by one bit.
    assert!(explanation.starts_with("sample 400, path: browser 0x"), "{explanation}");
    let values: Vec<u32> = explanation
        .split("0x")
        .skip(1)
        .map(|part| u32::from_str_radix(&part[..8], 16).unwrap_or_default())
        .collect();
    assert_eq!(values[0] ^ values[1], 1, "{explanation}");
    assert_ne!(text(&mut page, "#digest-own")?, text(&mut page, "#digest-cpu")?);
    page.wait_for(
        "document.querySelector('#announcement').textContent.endsWith('Browser and CPU differ.')",
    )?;
    page.photograph("differs")?;
    let flip = place(&mut page, "#flip")?;
    decide(&mut page, |page| page.click(flip))?;
    assert_agrees(&mut page)?;
    assert_quiet(&page);
    Ok(())
}

/// The page shows the evaluation of the browser: a changed shader changes it.
fn page_shows_changed_shader(program: &Program) -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let mut page = open(program, &served, &WEBGPU, DESKTOP)?;
    assert_agrees(&mut page)?;
    // A sixteenth of a unit of length along one axis, about 0.01 mm.
    page.reload_with(
        "const real = window.fetch; window.fetch = async (path, ...rest) => {
            const answer = await real(path, ...rest);
            if (path !== '/shader.wgsl') return answer;
            const parts = (await answer.text()).split('squared_length(to_key_x,');
            if (parts.length !== 2) throw new Error('no such call');
            return new Response(parts.join('squared_length(to_key_x + 1,'));
        };",
    )?;
    page.wait_for(SETTLED)?;
    assert_eq!(text(&mut page, "#agreement")?, "differ");
    let explanation = text(&mut page, "#explanation")?;
    assert!(
        explanation.starts_with("sample ") && explanation.contains(": browser 0x"),
        "{explanation}"
    );
    assert_quiet(&page);
    Ok(())
}

fn page_without_webgpu_shows_server_decision(program: &Program) -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let mut page = open(program, &served, &[], DESKTOP)?;
    assert_eq!(text(&mut page, "#agreement")?, "server only");
    let explanation = text(&mut page, "#explanation")?;
    let expected = "This browser evaluates nothing: this browser has WebGPU but no adapter";
    assert!(explanation.contains(expected), "{explanation}");
    page.reload_with("delete Navigator.prototype.gpu")?;
    page.wait_for(SETTLED)?;
    assert_eq!(text(&mut page, "#agreement")?, "server only");
    let explanation = text(&mut page, "#explanation")?;
    assert!(explanation.contains("navigator.gpu is absent"), "{explanation}");
    assert_eq!(text(&mut page, "#digest-own")?, "–");
    let answer = served.request("POST", "/decision", &served.problem()?.to_string())?.json()?;
    assert_eq!(answer["cpu"]["digest"], json!(text(&mut page, "#digest-cpu")?));
    let winner = answer["cpu"]["winner"]["index"].to_string();
    let announcement = text(&mut page, "#announcement")?;
    assert!(announcement.starts_with(&format!("Winner: sample {winner},")), "{announcement}");
    let robot = place(&mut page, "[data-handle=robot]")?;
    decide(&mut page, |page| page.drag(robot, (robot.0 + 40.0, robot.1)))?;
    assert_ne!(answer["cpu"]["digest"], json!(text(&mut page, "#digest-cpu")?));
    page.photograph("without-webgpu")?;
    assert_quiet(&page);
    Ok(())
}

fn page_recovers_from_losses(program: &Program) -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let mut page = open(program, &served, &WEBGPU, DESKTOP)?;
    assert_agrees(&mut page)?;
    page.crash_gpu()?;
    let step = place(&mut page, "#step")?;
    decide(&mut page, |page| page.click(step))?;
    page.wait_for("document.querySelector('#agreement').textContent === 'agree, bit for bit'")?;
    page.wait_for(SETTLED)?;
    assert_agrees(&mut page)?;
    drop(served);
    page.click(step)?;
    let announcement =
        "document.querySelector('#error').textContent.startsWith('The server does not answer')";
    page.wait_for(announcement)?;
    assert_eq!(text(&mut page, "#agreement")?, "not decided");
    page.photograph("gone")?;
    Ok(())
}

fn drag_never_waits_for_decision(program: &Program) -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let mut page = open(program, &served, &WEBGPU, DESKTOP)?;
    let goal = place(&mut page, "[data-handle=goal]")?;
    let before = page.evaluate(DECISIONS)?.as_u64().ok_or("a number")?;
    page.mouse("mouseMoved", goal, 0)?;
    page.mouse("mousePressed", goal, 1)?;
    served.signal("STOP")?;
    for part in 1..=10 {
        let to = (goal.0 - 6.0 * f64::from(part), goal.1 + 4.0 * f64::from(part));
        page.mouse("mouseMoved", to, 1)?;
        page.evaluate(FRAMES)?;
        let expression = "(() => { const box = document.querySelector('[data-handle=goal]').getBoundingClientRect(); \
            return [box.x + box.width / 2, box.y + box.height / 2]; })()";
        let now = page.evaluate(expression)?;
        let near =
            |index: usize, to: f64| now[index].as_f64().is_some_and(|at| (at - to).abs() < 1.5);
        assert!(near(0, to.0) && near(1, to.1), "{to:?}: {now}");
    }
    let busy = "document.querySelector('#results').getAttribute('aria-busy')";
    assert_eq!(page.evaluate(busy)?, json!("true"));
    served.signal("CONT")?;
    page.mouse("mouseReleased", (goal.0 - 60.0, goal.1 + 40.0), 0)?;
    page.wait_for(SETTLED)?;
    // The decision in progress and the last one.
    let decisions = page.evaluate(DECISIONS)?.as_u64().ok_or("a number")?;
    assert_eq!(decisions - before, 2);
    assert_agrees(&mut page)?;
    // The decision is about the position in the label.
    let label = "document.querySelector('[data-handle=goal]').getAttribute('aria-label')";
    let label = page.evaluate(label)?;
    let numbers: Vec<f64> = label
        .as_str()
        .unwrap_or_default()
        .split([' ', ','])
        .filter_map(|word| word.parse().ok())
        .collect();
    let mut problem = served.problem()?;
    let moved = (problem["target"][0].as_f64(), problem["target"][1].as_f64());
    assert_ne!((Some(numbers[0]), Some(numbers[1])), moved);
    problem["target"] = json!(numbers);
    let answer = served.request("POST", "/decision", &problem.to_string())?.json()?;
    // The label is rounded to a centimetre, which gives the same winner.
    let announcement = text(&mut page, "#announcement")?;
    let winner = answer["cpu"]["winner"]["index"].to_string();
    assert!(
        announcement.starts_with(&format!("Winner: sample {winner},")),
        "{winner}: {announcement}"
    );
    assert_quiet(&page);
    Ok(())
}

/// The focused element.
const FOCUSED: &str = "document.activeElement.dataset.handle ?? document.activeElement.id";

fn page_is_usable_with_keys_alone(program: &Program) -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let mut page = open(program, &served, &WEBGPU, DESKTOP)?;
    let mut visited = Vec::new();
    for _ in 0..60 {
        page.press("Tab", 0, 1)?;
        let focused = page.evaluate(FOCUSED)?;
        let focused = focused.as_str().unwrap_or_default().to_owned();
        if visited.contains(&focused) && focused == "scene" {
            break;
        }
        visited.push(focused.clone());
        let label =
            |page: &mut Page| page.evaluate("document.activeElement.getAttribute('aria-label')");
        let presses: &[(&str, u32)] = match focused.as_str() {
            "robot" => &[("ArrowRight", 0), ("ArrowUp", SHIFT), ("q", 0), ("E", SHIFT)],
            "goal" => &[("ArrowLeft", SHIFT), ("ArrowDown", 0)],
            "obstacle 0" => &[("ArrowDown", SHIFT), ("+", SHIFT), ("-", 0)],
            _ => &[],
        };
        for (key, modifiers) in presses {
            let before = label(&mut page)?;
            decide(&mut page, |page| page.press(key, *modifiers, 1))?;
            assert_ne!(label(&mut page)?, before, "{focused}: {key}");
        }
    }
    assert_agrees(&mut page)?;
    for expected in [
        "scene",
        "add",
        "robot",
        "goal",
        "obstacle 0",
        "zoom-in",
        "selected",
        "vx_samples",
        "path",
        "stopping",
    ] {
        assert!(visited.iter().any(|focused| focused == expected), "{expected}: {visited:?}");
    }
    // The selected sample, a removed obstacle, and the focus after it.
    focus(&mut page, "#selected")?;
    page.press("ArrowRight", 0, 3)?;
    assert!(text(&mut page, "#selected-text")?.starts_with("sample "));
    focus(&mut page, "[data-handle='obstacle 0']")?;
    decide(&mut page, |page| page.press("Delete", 0, 1))?;
    assert_eq!(
        page.evaluate("document.querySelector(\"[data-handle='obstacle 0']\")")?,
        Value::Null
    );
    assert_eq!(page.evaluate(FOCUSED)?, json!("add"));
    decide(&mut page, |page| page.press(" ", 0, 1))?;
    focus(&mut page, "[data-handle='obstacle 0']")?;
    page.photograph("keys")?;
    assert_quiet(&page);
    Ok(())
}

fn page_fits_phone_and_dark_mode(program: &Program) -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let mut page = open(program, &served, &WEBGPU, DESKTOP)?;
    focus(&mut page, "#scene")?;
    for name in ["crossing", "dead_end"] {
        decide(&mut page, |page| page.press("ArrowDown", 0, 1))?;
        let chosen = page.evaluate("document.querySelector('#scene').value")?;
        assert_eq!(chosen, json!(name));
        assert_agrees(&mut page)?;
        page.photograph(name)?;
    }
    let width = "[document.documentElement.scrollWidth, document.documentElement.clientWidth]";
    // A swipe on the handle moves the goal and not the page.
    page.look(PHONE)?;
    page.evaluate(FRAMES)?;
    let goal = place(&mut page, "[data-handle=goal]")?;
    let scrolled = page.evaluate("window.scrollY")?;
    decide(&mut page, |page| page.swipe(goal, (goal.0 - 30.0, goal.1 + 40.0)))?;
    let moved = page.evaluate(
        "(() => { const box = document.querySelector('[data-handle=goal]').getBoundingClientRect(); \
         return [box.x + box.width / 2, box.y + box.height / 2]; })()",
    )?;
    let near =
        |index: usize, to: f64| moved[index].as_f64().is_some_and(|at| (at - to).abs() < 2.0);
    assert!(near(0, goal.0 - 30.0) && near(1, goal.1 + 40.0), "{goal:?} to {moved}");
    assert_eq!(page.evaluate("window.scrollY")?, scrolled);
    assert_agrees(&mut page)?;
    for (name, look) in [
        ("phone", PHONE),
        ("phone-dark", Look { is_dark: true, ..PHONE }),
        ("dark", Look { is_dark: true, ..DESKTOP }),
    ] {
        page.look(look)?;
        let fit = place(&mut page, "#fit")?;
        page.click(fit)?;
        page.evaluate(FRAMES)?;
        page.evaluate("window.scrollTo(0, 0)")?;
        page.photograph(name)?;
        let found = page.evaluate(width)?;
        assert!(found[0].as_f64() <= found[1].as_f64(), "{name}: {found}");
        let stage = page.evaluate("document.querySelector('#stage').clientWidth")?;
        assert!(stage.as_f64() > Some(f64::from(look.size.0.min(900)) * 0.7), "{name}: {stage}");
        let ground = page.evaluate("getComputedStyle(document.body).backgroundColor")?;
        let is_dark = ground == json!("rgb(14, 17, 22)");
        assert_eq!(is_dark, look.is_dark, "{name}: {ground}");
    }
    assert_agrees(&mut page)?;
    assert_quiet(&page);
    Ok(())
}

fn page_shows_own_map_and_limits(program: &Program) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let map = folder.path().join("room.map");
    let wall = "@".repeat(80);
    let row = format!("@{}@", ".".repeat(78));
    let rows: Vec<&str> =
        (0..60).map(|index| if index % 59 == 0 { wall.as_str() } else { &row }).collect();
    std::fs::write(&map, format!("type octile\nheight 60\nwidth 80\nmap\n{}\n", rows.join("\n")))?;
    let file = map.to_string_lossy().into_owned();
    let served = Served::start(&["--map", &file, "--resolution", "0.1"])?;
    let mut page = open(program, &served, &WEBGPU, DESKTOP)?;
    assert_agrees(&mut page)?;
    page.photograph("own-map")?;
    // A problem beyond the limits of the server: the page shows its error.
    let add = place(&mut page, "#add")?;
    for _ in 0..8 {
        page.click(add)?;
    }
    for slider in ["#sim_time_s", "#vx_samples", "#vtheta_samples"] {
        focus(&mut page, slider)?;
        page.press("End", 0, 1)?;
    }
    let error = "document.querySelector('#error').textContent";
    page.wait_for(&format!("{error}.includes('at most 268435456 here')"))?;
    page.photograph("too-much")?;
    for slider in ["#vx_samples", "#vtheta_samples"] {
        focus(&mut page, slider)?;
        page.press("Home", 0, 1)?;
        page.press("ArrowRight", 0, 5)?;
    }
    page.wait_for("document.querySelector('#error').hidden")?;
    page.wait_for(SETTLED)?;
    assert_agrees(&mut page)
}
