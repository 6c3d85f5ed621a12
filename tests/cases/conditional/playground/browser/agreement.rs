//! The decisions of the browser and of the server agree, and the page shows where they do not.

use libtest_mimic::Failed;
use serde_json::json;

use super::{SETTLED, assert_agrees, assert_quiet, decide, focus, open, place, text};
use crate::cases::conditional::playground::served::Served;
use crate::support::browser::devtools::{DESKTOP, WEBGPU};
use crate::support::browser::program::Program;

pub fn dense_sampling_agrees(program: &Program) -> Result<(), Failed> {
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

pub fn page_shows_wrong_bit(program: &Program) -> Result<(), Failed> {
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
pub fn page_shows_changed_shader(program: &Program) -> Result<(), Failed> {
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

pub fn page_without_webgpu_shows_server_decision(program: &Program) -> Result<(), Failed> {
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

pub fn page_recovers_from_losses(program: &Program) -> Result<(), Failed> {
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

pub fn page_shows_own_map_and_limits(program: &Program) -> Result<(), Failed> {
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
