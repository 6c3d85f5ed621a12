//! The page used with mouse, keys and touch.

use libtest_mimic::Failed;
use serde_json::{Value, json};

use super::{
    DECISIONS, FRAMES, SETTLED, assert_agrees, assert_quiet, decide, focus, on_page, open, place,
    text,
};
use crate::cases::conditional::playground::served::Served;
use crate::support::browser::devtools::{DESKTOP, Look, PHONE, Page, SHIFT, WEBGPU};
use crate::support::browser::program::Program;

/// The focused element.
const FOCUSED: &str = "document.activeElement.dataset.handle ?? document.activeElement.id";

pub fn dragging_changes_winner(program: &Program) -> Result<(), Failed> {
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

pub fn drag_never_waits_for_decision(program: &Program) -> Result<(), Failed> {
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

pub fn page_is_usable_with_keys_alone(program: &Program) -> Result<(), Failed> {
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

pub fn page_fits_phone_and_dark_mode(program: &Program) -> Result<(), Failed> {
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
