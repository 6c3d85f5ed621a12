//! Opens a page in a browser, operates it, and returns the findings.

use std::fs;
use std::thread;
use std::time::{Duration, Instant};

use libtest_mimic::Failed;
use serde_json::Value;
use tempfile::TempDir;
use tiny_http::{Header, Method, Response, Server};

use crate::support::browser::program::Program;

/// Longest time until the browser answers.
const DEADLINE: Duration = Duration::from_secs(120);

/// The window of the browser.
pub struct Look {
    /// Width of the window, pixels.
    pub width: u32,
    /// Whether the dark theme is preferred.
    pub dark: bool,
}

impl Default for Look {
    fn default() -> Self {
        Self { width: 1200, dark: false }
    }
}

/// The result of a look at a page.
pub struct Seen {
    pub findings: Value,
    /// The lines on the console.
    pub console: Vec<String>,
}

/// Opens a page inside another one that operates it, and returns the findings.
pub fn look_at(program: &Program, page: &str, look: &Look) -> Result<Seen, Failed> {
    let server = Server::http("127.0.0.1:0").map_err(|error| error.to_string())?;
    let profile = TempDir::new()?;
    let size = format!("--window-size={},900", look.width + 40);
    let scheme = u8::from(!look.dark);
    let scheme = format!("--blink-settings=preferredColorScheme={scheme}");
    let flags = [&size, &scheme, "--enable-logging=stderr"];
    let address = format!("http://{}/?{}", server.server_addr(), look.width);
    let mut browser = program.start(profile.path(), &flags, &address)?;
    let findings = serve(&server, page);
    browser.kill()?;
    browser.wait()?;
    // Its processes may still write into the profile.
    thread::sleep(Duration::from_millis(100));
    let log = fs::read_to_string(profile.path().join("stderr")).unwrap_or_default();
    let findings = findings.map_err(|why| format!("{why}\n{log}"))?;
    let console = log.lines().filter(|line| line.contains(":CONSOLE"));
    Ok(Seen { findings, console: console.map(str::to_owned).collect() })
}

fn serve(server: &Server, page: &str) -> Result<Value, String> {
    let deadline = Instant::now() + DEADLINE;
    while Instant::now() < deadline {
        let request = server.recv_timeout(Duration::from_millis(100));
        let Some(mut request) = request.map_err(|error| error.to_string())? else {
            continue;
        };
        let mut body = String::new();
        let read = request.as_reader().read_to_string(&mut body);
        read.map_err(|error| error.to_string())?;
        let path = request.url().split('?').next().unwrap_or_default().to_owned();
        let answer = match (request.method(), path.as_str()) {
            (Method::Get, "/") => include_str!("reader.html"),
            (Method::Get, "/page") => page,
            (Method::Post, "/done") => {
                let _ = request.respond(Response::from_string(""));
                return serde_json::from_str(&body).map_err(|error| format!("{error}: {body}"));
            }
            _ => "",
        };
        let header: Result<Header, ()> = "Content-Type: text/html; charset=utf-8".parse();
        let header = header.map_err(|()| "no header")?;
        let _ = request.respond(Response::from_string(answer).with_header(header));
    }
    Err(format!("no answer within {DEADLINE:?}"))
}
