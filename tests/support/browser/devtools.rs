//! A page in headless Chromium, used through the `DevTools` protocol: with a mouse, keys and eyes, as a person would.

use std::fs;
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::Child;
use std::thread;
use std::time::{Duration, Instant};

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use libtest_mimic::Failed;
use serde_json::{Value, json};
use tempfile::TempDir;
use tungstenite::{Message, WebSocket, client};

use super::program::Program;

/// A browser that has not answered after this long never will.
const DEADLINE: Duration = Duration::from_secs(120);
/// How long a closing browser may take.
const FAREWELL: Duration = Duration::from_secs(10);
/// Between two looks.
const LOOK: Duration = Duration::from_millis(30);
/// WebGPU on Chromium's own software adapter, which is there on every machine.
pub const WEBGPU: [&str; 2] = ["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader"];
/// The shift key among the modifiers of an event.
pub const SHIFT: u32 = 8;

/// Size and colour scheme of the window.
#[derive(Clone, Copy)]
pub struct Look {
    /// Size of the window, pixels.
    pub size: (u32, u32),
    /// Whether the reader likes it dark.
    pub is_dark: bool,
}

pub const DESKTOP: Look = Look { size: (1280, 1000), is_dark: false };
pub const PHONE: Look = Look { size: (360, 740), is_dark: false };

/// One browser with one page. It goes when this is dropped.
pub struct Page {
    child: Child,
    profile: TempDir,
    socket: WebSocket<TcpStream>,
    session: String,
    calls: u64,
    /// What the page said on its console, and what it threw.
    pub console: Vec<String>,
}

impl Page {
    /// Opens an address in a browser with a profile that is new.
    pub fn open(program: &Program, flags: &[&str], look: Look, url: &str) -> Result<Self, Failed> {
        let profile = TempDir::new()?;
        let flags = [&["--remote-debugging-port=0"], flags].concat();
        let mut child = program.start(profile.path(), &flags, "about:blank")?;
        let socket = match connect(profile.path(), &mut child) {
            Ok(socket) => socket,
            Err(failed) => {
                let _ = child.kill().and_then(|()| child.wait());
                return Err(failed);
            }
        };
        let mut page =
            Self { child, profile, socket, session: String::new(), calls: 0, console: Vec::new() };
        let targets = page.call("Target.getTargets", &json!({}))?;
        let targets = targets["targetInfos"].as_array().ok_or("no targets")?;
        let found = targets.iter().find(|target| target["type"] == "page");
        let id = &found.ok_or("the browser has no page")?["targetId"];
        let attached =
            page.call("Target.attachToTarget", &json!({ "targetId": id, "flatten": true }))?;
        attached["sessionId"].as_str().ok_or("no session")?.clone_into(&mut page.session);
        for domain in ["Page", "Runtime", "Log"] {
            page.call(&format!("{domain}.enable"), &json!({}))?;
        }
        page.look(look)?;
        page.call("Page.navigate", &json!({ "url": url }))?;
        Ok(page)
    }

    /// Looks at the page in another way.
    pub fn look(&mut self, look: Look) -> Result<(), Failed> {
        let (width, height) = look.size;
        let metrics = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600 });
        self.call("Emulation.setDeviceMetricsOverride", &metrics)?;
        let touch = json!({ "enabled": width < 600 });
        self.call("Emulation.setTouchEmulationEnabled", &touch)?;
        let scheme = if look.is_dark { "dark" } else { "light" };
        let features = json!({ "features": [{ "name": "prefers-color-scheme", "value": scheme }] });
        self.call("Emulation.setEmulatedMedia", &features)?;
        Ok(())
    }

    /// Loads the page again, with a script that runs before its own.
    pub fn reload_with(&mut self, script: &str) -> Result<(), Failed> {
        let source = json!({ "source": script });
        self.call("Page.addScriptToEvaluateOnNewDocument", &source)?;
        self.evaluate("document.querySelector('#announcement').textContent = ''")?;
        self.call("Page.reload", &json!({}))?;
        Ok(())
    }

    /// Ends the process that has the graphics adapter.
    pub fn crash_gpu(&mut self) -> Result<(), Failed> {
        let session = core::mem::take(&mut self.session);
        let crashed = self.call("Browser.crashGpuProcess", &json!({}));
        self.session = session;
        crashed?;
        Ok(())
    }

    /// The value of an expression in the page.
    pub fn evaluate(&mut self, expression: &str) -> Result<Value, Failed> {
        let parameters =
            json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let mut answer = self.call("Runtime.evaluate", &parameters)?;
        if answer.get("exceptionDetails").is_some() {
            return Err(format!("{expression}: {}", answer["exceptionDetails"]).into());
        }
        Ok(answer["result"]["value"].take())
    }

    /// Waits until an expression is true in the page.
    pub fn wait_for(&mut self, expression: &str) -> Result<(), Failed> {
        let deadline = Instant::now() + DEADLINE;
        // Within a page that is not there yet nothing can be evaluated.
        while self.evaluate(expression).ok() != Some(Value::Bool(true)) {
            if Instant::now() > deadline {
                let shown = self.evaluate("document.body.innerText").unwrap_or_default();
                let what =
                    format!("not within {DEADLINE:?}: {expression}\n{shown}\n{:#?}", self.console);
                return Err(what.into());
            }
            thread::sleep(LOOK);
        }
        Ok(())
    }

    /// Drags the mouse from one place of the window to another, in several moves.
    pub fn drag(&mut self, from: (f64, f64), to: (f64, f64)) -> Result<(), Failed> {
        self.mouse("mouseMoved", from, 0)?;
        self.mouse("mousePressed", from, 1)?;
        for part in 1..=8 {
            let share = f64::from(part) / 8.0;
            let at = |from: f64, to: f64| from + share * (to - from);
            self.mouse("mouseMoved", (at(from.0, to.0), at(from.1, to.1)), 1)?;
        }
        self.mouse("mouseReleased", to, 0)
    }

    /// Drags a finger likewise.
    pub fn swipe(&mut self, from: (f64, f64), to: (f64, f64)) -> Result<(), Failed> {
        let mut touch = |kind: &str, points: Value| {
            let event = json!({ "type": kind, "touchPoints": points });
            self.call("Input.dispatchTouchEvent", &event)
        };
        touch("touchStart", json!([{ "x": from.0, "y": from.1 }]))?;
        for part in 1..=8 {
            let share = f64::from(part) / 8.0;
            let at = |from: f64, to: f64| from + share * (to - from);
            let point = json!([{ "x": at(from.0, to.0), "y": at(from.1, to.1) }]);
            touch("touchMove", point)?;
        }
        touch("touchEnd", json!([]))?;
        Ok(())
    }

    /// Clicks at a place of the window.
    pub fn click(&mut self, at: (f64, f64)) -> Result<(), Failed> {
        self.mouse("mousePressed", at, 1)?;
        self.mouse("mouseReleased", at, 0)
    }

    pub fn mouse(&mut self, kind: &str, (x, y): (f64, f64), buttons: u32) -> Result<(), Failed> {
        let button = if kind == "mouseMoved" && buttons == 0 { "none" } else { "left" };
        let event = json!({ "type": kind, "x": x, "y": y, "button": button, "buttons": buttons, "clickCount": 1 });
        self.call("Input.dispatchMouseEvent", &event)?;
        Ok(())
    }

    /// Presses a key, named as browsers do, this number of times.
    pub fn press(&mut self, key: &str, modifiers: u32, times: u32) -> Result<(), Failed> {
        let code = match key {
            "Tab" => 9,
            "End" => 35,
            "Home" => 36,
            "ArrowLeft" => 37,
            "ArrowUp" => 38,
            "ArrowRight" => 39,
            "ArrowDown" => 40,
            "Delete" => 46,
            " " => 32,
            _ => 0,
        };
        for _ in 0..times {
            let mut event = json!({ "type": "keyDown", "key": key, "windowsVirtualKeyCode": code, "modifiers": modifiers });
            if key.chars().count() == 1 {
                event["text"] = json!(key);
            }
            self.call("Input.dispatchKeyEvent", &event)?;
            event["type"] = json!("keyUp");
            self.call("Input.dispatchKeyEvent", &event)?;
        }
        Ok(())
    }

    /// Saves an image of the whole page.
    pub fn photograph(&mut self, name: &str) -> Result<PathBuf, Failed> {
        let shot = json!({ "format": "png", "captureBeyondViewport": true });
        let shot = self.call("Page.captureScreenshot", &shot)?;
        let bytes = BASE64_STANDARD.decode(shot["data"].as_str().ok_or("no picture")?)?;
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("browser");
        fs::create_dir_all(&folder)?;
        let file = folder.join(format!("{name}.png"));
        fs::write(&file, bytes)?;
        Ok(file)
    }

    /// A call of the protocol, and its result.
    fn call(&mut self, method: &str, parameters: &Value) -> Result<Value, Failed> {
        self.calls += 1;
        let mut call = json!({ "id": self.calls, "method": method, "params": parameters });
        if !self.session.is_empty() {
            call["sessionId"] = json!(self.session);
        }
        self.socket.send(Message::text(call.to_string()))?;
        loop {
            let Message::Text(text) = self.socket.read()? else {
                continue;
            };
            let mut message: Value = serde_json::from_str(&text)?;
            if message["id"] == json!(self.calls) {
                if let Some(error) = message.get("error") {
                    return Err(format!("{method}: {error}").into());
                }
                return Ok(message["result"].take());
            }
            self.note(&message);
        }
    }

    fn note(&mut self, event: &Value) {
        let parameters = &event["params"];
        let said = match event["method"].as_str().unwrap_or_default() {
            "Runtime.consoleAPICalled" => &parameters["args"],
            "Runtime.exceptionThrown" => &parameters["exceptionDetails"],
            // What Chromium itself says of WebGPU is no error.
            "Log.entryAdded" if parameters["entry"]["level"] == "error" => &parameters["entry"],
            _ => return,
        };
        self.console.push(said.to_string());
    }
}

/// The browser writes where it listens into its profile.
fn connect(profile: &Path, child: &mut Child) -> Result<WebSocket<TcpStream>, Failed> {
    let deadline = Instant::now() + DEADLINE;
    loop {
        let said = fs::read_to_string(profile.join("DevToolsActivePort")).unwrap_or_default();
        if let Some((port, path)) = said.trim().split_once('\n') {
            let address = format!("127.0.0.1:{port}");
            let stream = TcpStream::connect(&address)?;
            stream.set_read_timeout(Some(DEADLINE))?;
            let (socket, _) = client(format!("ws://{address}{path}"), stream)
                .map_err(|error| error.to_string())?;
            return Ok(socket);
        }
        if let Some(status) = child.try_wait()? {
            return Err(format!("Chromium is gone: {status}").into());
        }
        if Instant::now() > deadline {
            return Err(format!("Chromium does not listen within {DEADLINE:?}").into());
        }
        thread::sleep(LOOK);
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        // Killed at once, Chromium would leave processes of its own that still write into the profile.
        self.session.clear();
        let _ = self.call("Browser.close", &json!({}));
        let deadline = Instant::now() + FAREWELL;
        while Instant::now() < deadline {
            if matches!(self.child.try_wait(), Ok(Some(_))) {
                return;
            }
            thread::sleep(LOOK);
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = self.profile.path();
    }
}
