//! Chromium without a window, and the small server whose page runs in it.

use std::fs;
use std::io::Write;
use std::process::Child;
use std::time::{Duration, Instant};

use libtest_mimic::Failed;
use tempfile::TempDir;
use tiny_http::{Header, Method, Request, Response, Server};

use super::plan::Plan;
use super::program::Program;

/// A browser that has not answered after this long never will.
const DEADLINE: Duration = Duration::from_secs(120);
/// How long a closing browser may take.
const FAREWELL: Duration = Duration::from_secs(5);
/// How often to look whether the browser is still there.
const TICK: Duration = Duration::from_millis(100);

/// WebGPU on Chromium's own software adapter, which is there on every machine.
const FLAGS: [&str; 2] = ["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader"];

/// One browser with one page. Both go when this is dropped, and when this process ends otherwise: then the page finds
/// its server gone and closes itself.
pub struct Browser {
    child: Child,
    server: Server,
    profile: TempDir,
}

impl Browser {
    /// Starts Chromium with a profile that is new and goes with it.
    pub fn start(program: &Program) -> Result<Self, Failed> {
        // WebGPU is there on secure origins only, and this address is one.
        let server = Server::http("127.0.0.1:0").map_err(|error| error.to_string())?;
        let profile = TempDir::new()?;
        let page = format!("http://{}/", server.server_addr());
        let child = program.start(profile.path(), &FLAGS, &page)?;
        Ok(Self { child, server, profile })
    }

    /// Runs a plan in the page and returns the bytes it asked for. An error ends with what Chromium itself said.
    pub fn run(&mut self, plan: &Plan<'_>) -> Result<Vec<u8>, Failed> {
        self.exchange(plan).map_err(|failed| {
            let said = fs::read_to_string(self.profile.path().join("stderr")).unwrap_or_default();
            // Most of it is that a container has no message bus.
            let lines = said.lines().filter(|line| !line.contains("dbus/"));
            let lines: Vec<&str> = lines.collect();
            let last = lines[lines.len().saturating_sub(20)..].join("\n");
            let what = failed.message().unwrap_or_default();
            format!("{what}\nChromium's standard error ends with:\n{last}").into()
        })
    }

    fn exchange(&mut self, plan: &Plan<'_>) -> Result<Vec<u8>, Failed> {
        let plan_text = serde_json::to_string(plan)?;
        let deadline = Instant::now() + DEADLINE;
        loop {
            let mut request = self.next_request(deadline)?;
            let mut body = Vec::new();
            request.as_reader().read_to_end(&mut body)?;
            let path = request.url().to_owned();
            match (request.method(), path.as_str()) {
                (Method::Get, "/") => respond(request, "text/html", include_str!("page.html"))?,
                (Method::Get, "/page.js") => {
                    respond(request, "text/javascript", include_str!("page.js"))?;
                }
                (Method::Get, "/next") => respond(request, "application/json", &plan_text)?,
                (Method::Post, "/done") => {
                    respond(request, "text/plain", "")?;
                    if body.len() as u64 == plan.bytes_read() {
                        return Ok(body);
                    }
                    let (found, expected) = (body.len(), plan.bytes_read());
                    return Err(format!("{found} bytes came, not {expected}").into());
                }
                (Method::Post, "/failed") => {
                    respond(request, "text/plain", "")?;
                    return Err(String::from_utf8_lossy(&body).into());
                }
                (method, path) => {
                    return Err(format!("the page asked for {method} {path}").into());
                }
            }
        }
    }

    fn next_request(&mut self, deadline: Instant) -> Result<Request, Failed> {
        loop {
            if let Some(request) = self.server.recv_timeout(TICK)? {
                return Ok(request);
            }
            if let Some(status) = self.child.try_wait()? {
                return Err(format!("Chromium is gone: {status}").into());
            }
            if Instant::now() > deadline {
                return Err(format!("no answer within {DEADLINE:?}").into());
            }
        }
    }

    /// Ends the browser as a crash would, for a test of what follows.
    pub fn crash(&mut self) -> Result<(), Failed> {
        self.child.kill()?;
        self.child.wait()?;
        // The page's own process outlives it by a moment, and would work on if what it asked for came.
        while let Some(request) = self.server.recv_timeout(TICK)? {
            drop(request);
        }
        Ok(())
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // A request dropped is an error to the page, at which it closes and Chromium ends. Killed at once, Chromium
        // would leave processes of its own that still write into the profile.
        let deadline = Instant::now() + FAREWELL;
        while Instant::now() < deadline {
            if matches!(self.child.try_wait(), Ok(Some(_))) {
                return;
            }
            drop(self.server.recv_timeout(TICK));
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn respond(request: Request, content_type: &str, text: &str) -> Result<(), Failed> {
    let header = format!("Content-Type: {content_type}");
    let header: Header = header.parse().map_err(|()| "not a header")?;
    let response = Response::from_string(text).with_header(header);
    // In one write: of the several that `Request::respond` makes, TCP holds the last back for 40 ms.
    let mut bytes = Vec::new();
    let version = request.http_version().clone();
    response.raw_print(&mut bytes, version, request.headers(), false, None)?;
    let mut writer = request.into_writer();
    // A page that is gone takes no answer: the next wait says what became of its browser.
    let _ = writer.write_all(&bytes).and_then(|()| writer.flush());
    Ok(())
}
