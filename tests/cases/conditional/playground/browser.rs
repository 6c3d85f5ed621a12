//! The page as somebody finds it who uses it.

use libtest_mimic::{Failed, Trial};
use serde_json::{Value, json};

use super::devtools::{DESKTOP, Look, PHONE, Page, SHIFT, WEBGPU};
use super::served::Served;
use crate::support::browser::program::{self, BrowserTest, Program};

const TRIALS: [(&str, BrowserTest); 10] = [
    ("dragging changes the winner, and the bits agree", drags),
    ("65536 samples have one digest in browser and server", dense),
    ("one wrong bit is shown as a difference", wrong_bit),
    (
        "a slip in a shader is shown as a difference",
        slip_in_a_shader,
    ),
    (
        "without WebGPU the page says so and shows the server's answer",
        without_webgpu,
    ),
    (
        "a GPU process that crashes is survived, and so is a server that is gone",
        losses,
    ),
    (
        "what is dragged follows the pointer while a decision is awaited, and the latest wins",
        follows,
    ),
    ("keys alone do all of it", keys),
    ("it fits a phone and the dark", fits),
    (
        "a map of one's own is played on, and what is too much is told",
        own_map,
    ),
];

pub fn trials() -> Vec<Trial> {
    program::trials(&TRIALS)
}

/// Nothing is under way, and something is shown.
const SETTLED: &str = "document.querySelector('#results')?.getAttribute('aria-busy') === 'false' && \
    document.querySelector('#told').textContent !== '' && \
    document.querySelector('#told').textContent === document.querySelector('#winner').textContent";

fn open(program: &Program, served: &Served, flags: &[&str], look: Look) -> Result<Page, Failed> {
    let mut page = Page::open(program, flags, look, &served.url)?;
    page.wait_for(SETTLED)?;
    Ok(page)
}

fn text(page: &mut Page, selector: &str) -> Result<String, Failed> {
    let found = page.evaluate(&format!(
        "document.querySelector({}).textContent",
        json!(selector)
    ))?;
    Ok(found.as_str().unwrap_or_default().to_owned())
}

/// How many decisions were begun.
const DECISIONS: &str = "Number(document.querySelector('#results').dataset.decisions)";

/// Does something, and waits until a decision has come of it.
fn decide(
    page: &mut Page,
    does: impl FnOnce(&mut Page) -> Result<(), Failed>,
) -> Result<(), Failed> {
    let before = page.evaluate(DECISIONS)?;
    does(page)?;
    page.wait_for(&format!("{DECISIONS} > {before}"))?;
    page.wait_for(SETTLED)
}

/// Waits for a few frames: one in which the page learns of its size, one in which it draws.
const FRAMES: &str = "new Promise((resolve) => { let left = 4; \
    const next = () => left-- > 0 ? requestAnimationFrame(next) : resolve(); next(); })";

/// The middle of a thing in the window, which is scrolled to it.
fn place(page: &mut Page, selector: &str) -> Result<(f64, f64), Failed> {
    let expression = format!(
        "(() => {{ const one = document.querySelector({}); one.scrollIntoView({{ block: 'center' }}); \
         const box = one.getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]; }})()",
        json!(selector)
    );
    let found = page.evaluate(&expression)?;
    let number = |index: usize| found[index].as_f64().ok_or("no place");
    Ok((number(0)?, number(1)?))
}

/// The middle of a thing on the page, wherever that is scrolled to.
fn on_page(page: &mut Page, selector: &str) -> Result<(f64, f64), Failed> {
    let (x, y) = place(page, selector)?;
    let scrolled = page.evaluate("[window.scrollX, window.scrollY]")?;
    let number = |index: usize| scrolled[index].as_f64().unwrap_or_default();
    Ok((x + number(0), y + number(1)))
}

fn focus(page: &mut Page, selector: &str) -> Result<(), Failed> {
    page.evaluate(&format!(
        "document.querySelector({}).focus()",
        json!(selector)
    ))?;
    Ok(())
}

#[track_caller]
fn assert_agrees(page: &mut Page) -> Result<(), Failed> {
    let verdict = text(page, "#verdict")?;
    let why = text(page, "#why")?;
    assert_eq!(verdict, "agree, bit for bit", "{why}");
    let own = text(page, "#digest-own")?;
    assert_eq!(own.len(), 64, "{own}");
    assert_eq!(own, text(page, "#digest-cpu")?);
    Ok(())
}

#[track_caller]
fn assert_quiet(page: &Page) {
    assert_eq!(page.console, [""; 0], "words on the console");
}

fn drags(program: &Program) -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let mut page = open(program, &served, &WEBGPU, DESKTOP)?;
    assert_agrees(&mut page)?;
    page.photograph("first")?;
    let digest = text(&mut page, "#digest-own")?;
    let told = text(&mut page, "#told")?;
    let robot = place(&mut page, "[data-handle=robot]")?;
    let before = on_page(&mut page, "[data-handle=robot]")?;
    let label = "document.querySelector('[data-handle=robot]').getAttribute('aria-label')";
    let label_before = page.evaluate(label)?;
    decide(&mut page, |page| {
        page.drag(robot, (robot.0 + 60.0, robot.1 - 30.0))
    })?;
    assert_agrees(&mut page)?;
    assert_ne!(text(&mut page, "#digest-own")?, digest);
    page.wait_for(&format!(
        "document.querySelector('#told').textContent !== {}",
        json!(told)
    ))?;
    // The handle has gone along, and so has what it says of itself.
    let now = on_page(&mut page, "[data-handle=robot]")?;
    assert!(
        (now.0 - before.0 - 60.0).abs() < 2.0 && (now.1 - before.1 + 30.0).abs() < 2.0,
        "{before:?} to {now:?}"
    );
    assert_ne!(page.evaluate(label)?, label_before);
    for handle in ["goal", "nose", "'obstacle 0'", "'tip 0'"] {
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
    page.wait_for("document.querySelector('#looked-words').textContent.startsWith('sample ')")?;
    let looked = "document.querySelector('[data-term=v] td:last-child').textContent";
    assert_ne!(page.evaluate(looked)?, json!("–"));
    page.photograph("dragged")?;
    assert_quiet(&page);
    Ok(())
}

fn dense(program: &Program) -> Result<(), Failed> {
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
    // The server alone, asked by somebody else for the same.
    let problem = served.dense_problem(128, 512)?;
    let answer = served
        .request("POST", "/decision", &problem.to_string())?
        .json()?;
    assert_eq!(
        answer["cpu"]["digest"],
        json!(text(&mut page, "#digest-own")?)
    );
    assert!(text(&mut page, "[data-reading='browser, last'] dd")?.contains(" ms"));
    assert!(text(&mut page, "[data-reading='browser, cold start'] dd")?.contains(" ms"));
    page.photograph("dense")?;
    assert_quiet(&page);
    Ok(())
}

fn wrong_bit(program: &Program) -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let mut page = open(program, &served, &WEBGPU, DESKTOP)?;
    assert_agrees(&mut page)?;
    page.evaluate("document.querySelector('details').open = true")?;
    let flip = place(&mut page, "#flip")?;
    decide(&mut page, |page| page.click(flip))?;
    assert_eq!(text(&mut page, "#verdict")?, "differ");
    let why = text(&mut page, "#why")?;
    // The middle of 20 x 40 samples; both values, one bit apart.
    assert!(why.starts_with("sample 400, path: browser 0x"), "{why}");
    let values: Vec<u32> = why
        .split("0x")
        .skip(1)
        .map(|part| u32::from_str_radix(&part[..8], 16).unwrap_or_default())
        .collect();
    assert_eq!(values[0] ^ values[1], 1, "{why}");
    assert_ne!(
        text(&mut page, "#digest-own")?,
        text(&mut page, "#digest-cpu")?
    );
    page.wait_for(
        "document.querySelector('#told').textContent.endsWith('Browser and CPU differ.')",
    )?;
    page.photograph("differs")?;
    let flip = place(&mut page, "#flip")?;
    decide(&mut page, |page| page.click(flip))?;
    assert_agrees(&mut page)?;
    assert_quiet(&page);
    Ok(())
}

/// What the browser shows is its own: another shader gives another answer.
fn slip_in_a_shader(program: &Program) -> Result<(), Failed> {
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
    assert_eq!(text(&mut page, "#verdict")?, "differ");
    let why = text(&mut page, "#why")?;
    assert!(
        why.starts_with("sample ") && why.contains(": browser 0x"),
        "{why}"
    );
    assert_quiet(&page);
    Ok(())
}

fn without_webgpu(program: &Program) -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let mut page = open(program, &served, &[], DESKTOP)?;
    assert_eq!(text(&mut page, "#verdict")?, "server only");
    let why = text(&mut page, "#why")?;
    let expected = "Nothing is evaluated in this browser: this browser has WebGPU but no adapter";
    assert!(why.contains(expected), "{why}");
    page.reload_with("delete Navigator.prototype.gpu")?;
    page.wait_for(SETTLED)?;
    assert_eq!(text(&mut page, "#verdict")?, "server only");
    let why = text(&mut page, "#why")?;
    assert!(why.contains("navigator.gpu is absent"), "{why}");
    assert_eq!(text(&mut page, "#digest-own")?, "–");
    let answer = served
        .request("POST", "/decision", &served.problem()?.to_string())?
        .json()?;
    assert_eq!(
        answer["cpu"]["digest"],
        json!(text(&mut page, "#digest-cpu")?)
    );
    let winner = answer["cpu"]["winner"]["index"].to_string();
    let told = text(&mut page, "#told")?;
    assert!(
        told.starts_with(&format!("Winner: sample {winner},")),
        "{told}"
    );
    let robot = place(&mut page, "[data-handle=robot]")?;
    decide(&mut page, |page| {
        page.drag(robot, (robot.0 + 40.0, robot.1))
    })?;
    assert_ne!(
        answer["cpu"]["digest"],
        json!(text(&mut page, "#digest-cpu")?)
    );
    page.photograph("without-webgpu")?;
    assert_quiet(&page);
    Ok(())
}

fn losses(program: &Program) -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let mut page = open(program, &served, &WEBGPU, DESKTOP)?;
    assert_agrees(&mut page)?;
    page.crash_gpu()?;
    let step = place(&mut page, "#step")?;
    decide(&mut page, |page| page.click(step))?;
    page.wait_for("document.querySelector('#verdict').textContent === 'agree, bit for bit'")?;
    page.wait_for(SETTLED)?;
    assert_agrees(&mut page)?;
    drop(served);
    page.click(step)?;
    let told =
        "document.querySelector('#trouble').textContent.startsWith('The server does not answer')";
    page.wait_for(told)?;
    assert_eq!(text(&mut page, "#verdict")?, "not decided");
    page.photograph("gone")?;
    Ok(())
}

fn follows(program: &Program) -> Result<(), Failed> {
    let served = Served::start(&[])?;
    let mut page = open(program, &served, &WEBGPU, DESKTOP)?;
    let goal = place(&mut page, "[data-handle=goal]")?;
    let before = page.evaluate(DECISIONS)?.as_u64().ok_or("a number")?;
    page.mouse("mouseMoved", goal, 0)?;
    page.mouse("mousePressed", goal, 1)?;
    served.signal("STOP")?;
    for part in 1..=10 {
        let to = (
            goal.0 - 6.0 * f64::from(part),
            goal.1 + 4.0 * f64::from(part),
        );
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
    // The one that was under way, and the last.
    let decisions = page.evaluate(DECISIONS)?.as_u64().ok_or("a number")?;
    assert_eq!(decisions - before, 2);
    assert_agrees(&mut page)?;
    // What it decided on is what the handle says.
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
    let answer = served
        .request("POST", "/decision", &problem.to_string())?
        .json()?;
    // To a centimetre, as the label is rounded: the same winner.
    let told = text(&mut page, "#told")?;
    let winner = answer["cpu"]["winner"]["index"].to_string();
    assert!(
        told.starts_with(&format!("Winner: sample {winner},")),
        "{winner}: {told}"
    );
    assert_quiet(&page);
    Ok(())
}

/// What has the focus.
const FOCUSED: &str = "document.activeElement.dataset.handle ?? document.activeElement.id";

fn keys(program: &Program) -> Result<(), Failed> {
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
            "robot" => &[
                ("ArrowRight", 0),
                ("ArrowUp", SHIFT),
                ("q", 0),
                ("E", SHIFT),
            ],
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
    for wanted in [
        "scene",
        "add",
        "robot",
        "goal",
        "obstacle 0",
        "closer",
        "looked",
        "vx_samples",
        "path",
        "stopping",
    ] {
        assert!(
            visited.iter().any(|one| one == wanted),
            "{wanted}: {visited:?}"
        );
    }
    // The sample looked at, an obstacle that goes, and the focus that does not get lost.
    focus(&mut page, "#looked")?;
    page.press("ArrowRight", 0, 3)?;
    assert!(text(&mut page, "#looked-words")?.starts_with("sample "));
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

fn fits(program: &Program) -> Result<(), Failed> {
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
    // With a finger, which moves the goal and not the page.
    page.look(PHONE)?;
    page.evaluate(FRAMES)?;
    let goal = place(&mut page, "[data-handle=goal]")?;
    let scrolled = page.evaluate("window.scrollY")?;
    decide(&mut page, |page| {
        page.swipe(goal, (goal.0 - 30.0, goal.1 + 40.0))
    })?;
    let moved = page.evaluate(
        "(() => { const box = document.querySelector('[data-handle=goal]').getBoundingClientRect(); \
         return [box.x + box.width / 2, box.y + box.height / 2]; })()",
    )?;
    let near = |index: usize, to: f64| {
        moved[index]
            .as_f64()
            .is_some_and(|at| (at - to).abs() < 2.0)
    };
    assert!(
        near(0, goal.0 - 30.0) && near(1, goal.1 + 40.0),
        "{goal:?} to {moved}"
    );
    assert_eq!(page.evaluate("window.scrollY")?, scrolled);
    assert_agrees(&mut page)?;
    for (name, look) in [
        ("phone", PHONE),
        (
            "phone-dark",
            Look {
                is_dark: true,
                ..PHONE
            },
        ),
        (
            "dark",
            Look {
                is_dark: true,
                ..DESKTOP
            },
        ),
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
        assert!(
            stage.as_f64() > Some(f64::from(look.size.0.min(900)) * 0.7),
            "{name}: {stage}"
        );
        let ground = page.evaluate("getComputedStyle(document.body).backgroundColor")?;
        let is_dark = ground == json!("rgb(14, 17, 22)");
        assert_eq!(is_dark, look.is_dark, "{name}: {ground}");
    }
    assert_agrees(&mut page)?;
    assert_quiet(&page);
    Ok(())
}

fn own_map(program: &Program) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let map = folder.path().join("room.map");
    let wall = "@".repeat(80);
    let row = format!("@{}@", ".".repeat(78));
    let rows: Vec<&str> = (0..60)
        .map(|index| if index % 59 == 0 { wall.as_str() } else { &row })
        .collect();
    std::fs::write(
        &map,
        format!(
            "type octile\nheight 60\nwidth 80\nmap\n{}\n",
            rows.join("\n")
        ),
    )?;
    let file = map.to_string_lossy().into_owned();
    let served = Served::start(&["--map", &file, "--resolution", "0.1"])?;
    let mut page = open(program, &served, &WEBGPU, DESKTOP)?;
    assert_agrees(&mut page)?;
    page.photograph("own-map")?;
    // More at once than the server takes: it says so, and the page does.
    let add = place(&mut page, "#add")?;
    for _ in 0..8 {
        page.click(add)?;
    }
    for slider in ["#sim_time_s", "#vx_samples", "#vtheta_samples"] {
        focus(&mut page, slider)?;
        page.press("End", 0, 1)?;
    }
    let trouble = "document.querySelector('#trouble').textContent";
    page.wait_for(&format!("{trouble}.includes('at most 268435456 here')"))?;
    page.photograph("too-much")?;
    for slider in ["#vx_samples", "#vtheta_samples"] {
        focus(&mut page, slider)?;
        page.press("Home", 0, 1)?;
        page.press("ArrowRight", 0, 5)?;
    }
    page.wait_for("document.querySelector('#trouble').hidden")?;
    page.wait_for(SETTLED)?;
    assert_agrees(&mut page)
}
