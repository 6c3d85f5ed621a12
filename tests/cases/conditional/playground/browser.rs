//! The page in a browser: how tests open, read and operate it.

mod agreement;
mod input;

use libtest_mimic::{Failed, Trial};
use serde_json::json;

use super::served::Served;
use crate::support::browser::devtools::{Look, Page};
use crate::support::browser::program::{self, BrowserTest, Program};

const TRIALS: [(&str, BrowserTest); 10] = [
    ("dragging_changes_winner_and_bits_agree", input::dragging_changes_winner),
    ("browser_and_server_agree_on_65536_samples", agreement::dense_sampling_agrees),
    ("page_shows_wrong_bit", agreement::page_shows_wrong_bit),
    ("page_shows_changed_shader", agreement::page_shows_changed_shader),
    (
        "page_without_webgpu_shows_server_decision",
        agreement::page_without_webgpu_shows_server_decision,
    ),
    ("page_recovers_from_lost_gpu_and_reports_lost_server", agreement::page_recovers_from_losses),
    ("drag_never_waits_for_decision_and_latest_wins", input::drag_never_waits_for_decision),
    ("page_is_usable_with_keys_alone", input::page_is_usable_with_keys_alone),
    ("page_fits_phone_and_dark_mode", input::page_fits_phone_and_dark_mode),
    ("page_shows_own_map_and_limits", agreement::page_shows_own_map_and_limits),
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
