//! Starts the server, and sends requests byte by byte.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use libtest_mimic::Failed;
use serde_json::{Value, json};

/// Time limit of a response.
pub const DEADLINE: Duration = Duration::from_secs(120);

/// A test of the server.
pub type ServerTest = fn() -> Result<(), Failed>;

/// `inbye playground` at a free port. It ends when this is dropped.
pub struct Served {
    child: Child,
    pub url: String,
    pub port: u16,
    /// The first line of its output.
    pub first_line: Value,
}

/// A response.
#[derive(Debug)]
pub struct Answer {
    pub status: u16,
    pub head: String,
    pub body: Vec<u8>,
}

impl Answer {
    pub fn json(&self) -> Result<Value, Failed> {
        Ok(serde_json::from_slice(&self.body)?)
    }
}

impl Served {
    pub fn start(arguments: &[&str]) -> Result<Self, Failed> {
        let mut child = Command::new(env!("CARGO_BIN_EXE_inbye"))
            .args(["playground", "--port", "0", "--json"])
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()?;
        let stdout = child.stdout.take().ok_or("no standard output")?;
        let mut line = String::new();
        BufReader::new(stdout).read_line(&mut line)?;
        let first_line: Value = serde_json::from_str(&line)?;
        let port = first_line["port"].as_u64().ok_or("no port")?;
        Ok(Self {
            child,
            url: first_line["url"].as_str().ok_or("no address")?.to_owned(),
            port: u16::try_from(port)?,
            first_line,
        })
    }

    pub fn id(&self) -> u32 {
        self.child.id()
    }

    pub fn connect(&self) -> Result<TcpStream, Failed> {
        connect(self.port)
    }

    /// Sends bytes and reads the whole response.
    pub fn exchange(&self, bytes: &[u8]) -> Result<Answer, Failed> {
        read_answer(send(self.port, bytes)?)
    }

    /// A request as the page sends it.
    pub fn request(&self, method: &str, path: &str, body: &str) -> Result<Answer, Failed> {
        let host = format!("127.0.0.1:{}", self.port);
        let origin = format!("http://{host}");
        self.request_from(method, path, &host, &origin, "application/json", body)
    }

    pub fn request_from(
        &self,
        method: &str,
        path: &str,
        host: &str,
        origin: &str,
        content_type: &str,
        body: &str,
    ) -> Result<Answer, Failed> {
        let head = format!(
            "{method} {path} HTTP/1.1\r\nHost: {host}\r\nOrigin: {origin}\r\nContent-Type: {content_type}\r\nContent-Length: {}\r\n\r\n{body}",
            body.len()
        );
        self.exchange(head.as_bytes())
    }

    /// The initial problem of the first scene.
    pub fn problem(&self) -> Result<Value, Failed> {
        let mut setup = self.request("GET", "/setup", "")?.json()?;
        Ok(setup["scenes"][0]["problem"].take())
    }

    /// The initial problem with another number of samples.
    pub fn dense_problem(&self, vx_samples: u32, vtheta_samples: u32) -> Result<Value, Failed> {
        let mut problem = self.problem()?;
        problem["vx_samples"] = json!(vx_samples);
        problem["vtheta_samples"] = json!(vtheta_samples);
        Ok(problem)
    }

    /// Sends a signal to the server.
    pub fn signal(&self, name: &str) -> Result<(), Failed> {
        let (name, id) = (format!("-{name}"), self.id().to_string());
        let sent = Command::new("kill").args([name, id]).status()?;
        assert!(sent.success());
        Ok(())
    }

    /// Ends the server as Ctrl-C does, and returns its exit status.
    #[cfg(unix)]
    pub fn interrupt(mut self) -> Result<Option<i32>, Failed> {
        self.signal("INT")?;
        let deadline = Instant::now() + DEADLINE;
        while Instant::now() < deadline {
            if let Some(status) = self.child.try_wait()? {
                return Ok(status.code());
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        Err("the server does not end".into())
    }
}

fn connect(port: u16) -> Result<TcpStream, Failed> {
    let stream = TcpStream::connect(("127.0.0.1", port))?;
    stream.set_read_timeout(Some(DEADLINE))?;
    Ok(stream)
}

/// Sends bytes to a server of this machine.
pub fn send(port: u16, bytes: &[u8]) -> Result<TcpStream, Failed> {
    let mut stream = connect(port)?;
    stream.write_all(bytes)?;
    Ok(stream)
}

/// The interim response to a client with `Expect: 100-continue`.
const CONTINUE: &[u8] = b"HTTP/1.1 100 Continue\r\n\r\n";

/// Reads a response to its end.
pub fn read_answer(mut stream: TcpStream) -> Result<Answer, Failed> {
    let mut bytes = Vec::new();
    stream.read_to_end(&mut bytes)?;
    if bytes.starts_with(CONTINUE) {
        bytes.drain(..CONTINUE.len());
    }
    let end = bytes.windows(4).position(|four| four == b"\r\n\r\n");
    let end = end.ok_or_else(|| format!("no answer: {:?}", String::from_utf8_lossy(&bytes)))?;
    let head = String::from_utf8(bytes[..end].to_vec())?;
    let status = head.split(' ').nth(1).and_then(|status| status.parse().ok());
    let body = bytes.split_off(end + 4);
    let length = head.lines().find_map(|line| line.strip_prefix("Content-Length: "));
    assert_eq!(length, Some(body.len().to_string().as_str()), "{head}");
    Ok(Answer { status: status.ok_or("no status")?, head, body })
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
