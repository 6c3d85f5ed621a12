//! `inbye drive --live`: the page of a running drive, in headless Chromium and by its requests.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use libtest_mimic::{Failed, Trial};
use serde_json::Value;

use super::playground::served::{read_answer, send};
use crate::support::browser::devtools::{DESKTOP, Look, PHONE, Page};
use crate::support::browser::program::{self, BrowserTest, Program};

pub fn trials() -> Vec<Trial> {
    let in_browser: [(&str, BrowserTest); 1] = [("page_follows_a_drive_and_keeps_it", follows)];
    let mut trials = program::trials(&in_browser);
    trials.push(Trial::test("requests_of_a_live_drive", requests));
    trials
}

/// A drive that is served. It is ended when this is dropped.
struct LiveDrive {
    child: Child,
    port: u16,
}

impl LiveDrive {
    fn start(arguments: &[&str]) -> Result<Self, Failed> {
        let mut child = Command::new(env!("CARGO_BIN_EXE_inbye"))
            .args(["drive", "--scene", "roadway", "--engine", "cpu", "--json", "--live"])
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()?;
        let stderr = BufReader::new(child.stderr.take().ok_or("no standard error")?);
        let port = stderr.lines().map_while(Result::ok).find_map(|line| {
            let address = line.strip_prefix("the drive is shown at http://127.0.0.1:")?;
            address.trim_end_matches('/').parse().ok()
        });
        let port = port.ok_or("no address of the page")?;
        Ok(Self { child, port })
    }

    fn url(&self) -> String {
        format!("http://127.0.0.1:{}/", self.port)
    }

    /// The result of the drive.
    fn result(mut self) -> Result<Value, Failed> {
        let stdout = self.child.stdout.take().ok_or("no standard output")?;
        Ok(serde_json::from_reader(stdout)?)
    }
}

impl Drop for LiveDrive {
    fn drop(&mut self) {
        let _ = self.child.kill().and_then(|()| self.child.wait());
    }
}

fn requests() -> Result<(), Failed> {
    let drive = LiveDrive::start(&["--real-time-factor", "5"])?;
    let ask = |method: &str, path: &str, host: &str| {
        let request = format!(
            "{method} {path} HTTP/1.1\r\nHost: {host}\r\nContent-Type: application/json\r\nContent-Length: 0\r\n\r\n"
        );
        send(drive.port, request.as_bytes()).and_then(read_answer)
    };
    let own = format!("127.0.0.1:{}", drive.port);
    let page = ask("GET", "/", &own)?;
    assert_eq!(page.status, 200);
    assert!(page.head.contains("frame-ancestors 'self'"), "{}", page.head);
    assert!(String::from_utf8(page.body)?.contains("connect-src 'self'"));
    assert_eq!(ask("GET", "/ticks?frames=0", "example.org")?.status, 403);
    assert_eq!(ask("GET", "/ticks?frames=many", &own)?.status, 400);
    assert_eq!(ask("POST", "/stop", &own)?.status, 404, "the page can only look");
    assert_eq!(ask("POST", "/ticks", &own)?.status, 405);
    assert_eq!(ask("GET", "/elsewhere", &own)?.status, 404);
    let ticks = ask("GET", "/ticks?frames=0", &own)?.json()?;
    assert!(ticks["part"]["first"] == 0 && ticks["drive"]["end"].is_null(), "{}", ticks["drive"]);
    Ok(())
}

fn follows(program: &Program) -> Result<(), Failed> {
    let drive = LiveDrive::start(&["--real-time-factor", "4"])?;
    let mut page = Page::open(program, &[], DESKTOP, &drive.url())?;
    page.wait_for("document.querySelector('#drive-state')?.textContent === 'driving'")?;
    let slider = "document.querySelector('[data-action=seek]')";
    // It shows the newest tick, again and again.
    let ticks = page.evaluate(&format!("Number({slider}.max)"))?;
    page.wait_for(&format!(
        "Number({slider}.max) > {ticks} + 10 && {slider}.value === {slider}.max"
    ))?;
    page.photograph("live")?;
    // A tick that the user selects stays, while the drive continues.
    page.evaluate("document.querySelector('[data-action=back]').click()")?;
    let newest = "document.querySelector('[data-action=live]')";
    page.wait_for(&format!("{newest}.getAttribute('aria-pressed') === 'false'"))?;
    let selected = page.evaluate(&format!("{slider}.value"))?;
    page.wait_for(&format!("Number({slider}.max) > Number({selected}) + 10"))?;
    assert_eq!(page.evaluate(&format!("{slider}.value"))?, selected);
    page.evaluate(&format!("{newest}.click()"))?;
    page.wait_for("document.querySelector('#drive-state').textContent === 'ended'")?;
    let shown = page.evaluate("document.querySelector('#drive-text').textContent")?;
    assert!(shown.as_str().is_some_and(|text| text.starts_with("goal reached")), "{shown}");
    // The page has the whole drive, after the program has ended too.
    let result = drive.result()?;
    let frames = page.evaluate(&format!("Number({slider}.max) + 1"))?;
    assert_eq!(frames.as_u64(), result["ticks"].as_u64());
    assert_eq!(page.evaluate(&format!("{slider}.value === {slider}.max"))?, Value::Bool(true));
    page.look(Look { is_dark: true, ..PHONE })?;
    page.wait_for(
        "window.innerWidth < 400 && document.documentElement.scrollWidth <= window.innerWidth",
    )?;
    page.photograph("live-phone")?;
    assert_eq!(page.console, [""; 0], "messages on the console");
    Ok(())
}
