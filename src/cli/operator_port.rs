//! The operator's port on localhost: HTTP requests that arm and stop the robot.
//!
//! A request that asks for a stop in any form stops the robot, complete or not; only the exact request arms it.
//!
//! One thread serves all clients at once. A client that is slow or silent delays no other one.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::thread;
use std::time::{Duration, Instant};

use inbye::base::OperatorState;
use serde_json::json;

use super::operator::Operator;

/// Longest head of a request, bytes, and its longest time.
const MAX_HEAD: usize = 4096;
const REQUEST_TIME: Duration = Duration::from_millis(500);

/// Most clients at once. A further one takes the place of the client that has waited longest.
const MAX_CLIENTS: usize = 64;

/// Answers, each with the reason of a refusal.
type Answer = (&'static str, Option<&'static str>);
const OK: Answer = ("200 OK", None);
const FOREIGN: Answer = (
    "403 Forbidden",
    Some(
        "a page of a browser must not arm a robot: send POST /arm without an Origin, such as with curl",
    ),
);
const INEXACT: Answer = (
    "400 Bad Request",
    Some(
        "POST /arm must be text with lines that end with CR and LF: send it with a HTTP client, such as curl",
    ),
);
const UNKNOWN: Answer =
    ("404 Not Found", Some("unknown request: use POST /arm, POST /stop or GET /status"));

/// Time between two looks at the clients that have not sent their requests.
const POLL_TIME: Duration = Duration::from_millis(2);

/// A client whose request is not complete.
struct Client {
    stream: TcpStream,
    head: Vec<u8>,
    since: Instant,
    /// Whether the robot was stopped for this request.
    has_stopped: bool,
}

/// What became of a client.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Progress {
    Waiting,
    Complete,
    Gone,
}

/// Whether more of a request's head may come.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Head {
    MayGrow,
    IsOver,
}

/// Serves the port as long as it exists.
pub fn serve(listener: &TcpListener, operator: &Operator) {
    let mut clients: Vec<Client> = Vec::new();
    loop {
        // Without clients it waits for one; else it looks for more, and at all of them.
        if listener.set_nonblocking(!clients.is_empty()).is_err() {
            return;
        }
        if let Ok(client) = accept(listener) {
            if clients.len() == MAX_CLIENTS {
                clients.remove(0).obey_stop(Head::IsOver, operator);
            }
            clients.push(client);
        } else {
            thread::sleep(POLL_TIME);
        }
        serve_clients(&mut clients, operator);
    }
}

fn accept(listener: &TcpListener) -> io::Result<Client> {
    let (stream, _) = listener.accept()?;
    stream.set_nonblocking(true)?;
    Ok(Client { stream, head: Vec::new(), since: Instant::now(), has_stopped: false })
}

/// Answers every complete request, and drops the clients that are too slow or send too much.
fn serve_clients(clients: &mut Vec<Client>, operator: &Operator) {
    clients.retain_mut(|client| {
        let progress = client.read();
        let stays = progress == Progress::Waiting && client.since.elapsed() < REQUEST_TIME;
        client.obey_stop(if stays { Head::MayGrow } else { Head::IsOver }, operator);
        if progress == Progress::Complete {
            client.answer(operator);
        }
        stays
    });
}

/// Whether a request asks for a stop: by any method, with slashes, a query or a host around the word.
fn asks_for_stop(request_line: &str) -> bool {
    let target = request_line.split_whitespace().nth(1).unwrap_or_default();
    let path = target.split(['?', '#']).next().unwrap_or_default().trim_end_matches('/');
    path.rsplit('/').next().is_some_and(|name| name.eq_ignore_ascii_case("stop"))
}

impl Client {
    /// Reads what has come of the head of its request.
    fn read(&mut self) -> Progress {
        let mut bytes = [0; 512];
        while self.head.len() <= MAX_HEAD {
            match self.stream.read(&mut bytes) {
                Ok(0) => return Progress::Gone,
                Ok(count) => self.head.extend_from_slice(bytes.get(..count).unwrap_or_default()),
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Progress::Waiting,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(_) => return Progress::Gone,
            }
            let ends = |end: &[u8]| self.head.windows(end.len()).any(|part| part == end);
            if ends(b"\n\r\n") || ends(b"\n\n") {
                return Progress::Complete;
            }
        }
        Progress::Gone
    }

    /// Stops the robot if the request asks for it, once its first line is complete or no more of it comes.
    fn obey_stop(&mut self, head: Head, operator: &Operator) {
        let line = self.head.split(|&byte| byte == b'\n').next().unwrap_or_default();
        let is_complete = head == Head::IsOver || line.len() < self.head.len();
        if self.has_stopped || !is_complete || !asks_for_stop(&String::from_utf8_lossy(line)) {
            return;
        }
        self.has_stopped = true;
        // Requests may repeat many times a second: the first is noted.
        match operator.switch.state() {
            OperatorState::Stopped => operator.switch.stop(),
            _ => operator.stop(),
        }
    }

    /// Answers a request, and arms the robot if it is the exact request for that.
    fn answer(&mut self, operator: &Operator) {
        let head = String::from_utf8_lossy(&self.head);
        // A page of another site in a browser must not arm a robot.
        let is_foreign = head.to_ascii_lowercase().contains("\norigin:");
        let is_exact = head.ends_with("\r\n\r\n") && str::from_utf8(&self.head).is_ok();
        let mut words = head.split_whitespace();
        let (status, reason) = match (words.next(), words.next()) {
            _ if self.has_stopped => OK,
            (Some("POST"), Some("/arm")) if is_foreign => FOREIGN,
            (Some("POST"), Some("/arm")) if !is_exact => INEXACT,
            (Some("POST"), Some("/arm")) => {
                match operator.switch.state() {
                    OperatorState::Armed => operator.switch.arm(),
                    _ => operator.arm(),
                }
                OK
            }
            (Some("GET"), Some("/status")) => OK,
            _ => UNKNOWN,
        };
        let body = reason.map_or_else(|| operator.status(), |reason| json!({ "error": reason }));
        let body = body.to_string();
        let length = body.len();
        // A client that has gone needs no answer, and an answer this short fits into the buffer of every other one.
        let _ = write!(
            self.stream,
            "HTTP/1.1 {status}\r\nContent-Type: application/json\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n{body}"
        );
    }
}

#[cfg(test)]
mod tests {
    use std::net::{Ipv4Addr, SocketAddr};

    use inbye::base::OperatorSwitch;

    use super::*;

    /// A served port and its switch.
    fn served() -> (SocketAddr, OperatorSwitch) {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a free port");
        let address = listener.local_addr().expect("an address");
        let operator = Operator::default();
        let switch = operator.switch.clone();
        thread::spawn(move || serve(&listener, &operator));
        (address, switch)
    }

    fn request(address: SocketAddr, text: impl AsRef<[u8]>) -> String {
        let mut stream = TcpStream::connect(address).expect("a connection");
        stream.write_all(text.as_ref()).expect("a request");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("an answer");
        answer
    }

    /// Only the exact request arms; a line that ends in LF alone, and a byte that is no text, are none of it.
    #[test]
    fn everything_that_means_stop_stops_and_only_the_exact_request_arms() {
        let (address, switch) = served();
        for stop in [
            &b"POST /stop HTTP/1.1\n\n"[..],
            b"POST /stop\r\nName: \xff\r\n\r\n",
            b"POST /stop/ HTTP/1.1\r\n\r\n",
            b"POST //stop HTTP/1.1\r\n\r\n",
            b"POST /stop?x=1 HTTP/1.1\r\n\r\n",
            b"PUT /Stop HTTP/1.1\r\n\r\n",
            b"GET http://localhost:8700/stop HTTP/1.1\r\nOrigin: a\r\n\r\n",
            // No end: it is dropped after its time.
            b"POST /stop HTTP/1.1\r\nHost",
            b"POST /stop",
        ] {
            switch.arm();
            request(address, stop);
            assert_eq!(switch.state(), OperatorState::Stopped, "{}", stop.escape_ascii());
        }
        for no_arm in [
            &b"POST /arm HTTP/1.1\n\n"[..],
            b"POST /arm HTTP/1.1\r\nName: \xff\r\n\r\n",
            b"POST /arm/ HTTP/1.1\r\n\r\n",
            b"POST /stopwatch HTTP/1.1\r\n\r\n",
            b"PUT /arm HTTP/1.1\r\n\r\n",
            b"POST /arm HTTP/1.1\r\nHost",
        ] {
            request(address, no_arm);
            assert_eq!(switch.state(), OperatorState::Stopped, "{}", no_arm.escape_ascii());
        }
        switch.arm();
        request(address, "POST /stopwatch HTTP/1.1\r\n\r\n");
        assert_eq!(switch.state(), OperatorState::Armed);
    }

    #[test]
    fn requests_arm_stop_and_show_the_state() {
        let (address, switch) = served();
        for (text, status, state) in [
            ("POST /arm HTTP/1.1\r\n\r\n", "200 OK", OperatorState::Armed),
            ("POST /stop HTTP/1.1\r\nHost: a\r\n\r\n", "200 OK", OperatorState::Stopped),
            (
                "POST /arm HTTP/1.1\r\nOrigin: http://a\r\n\r\n",
                "403 Forbidden",
                OperatorState::Stopped,
            ),
            ("GET /arm HTTP/1.1\r\n\r\n", "404 Not Found", OperatorState::Stopped),
            ("GET /status HTTP/1.1\r\n\r\n", "200 OK", OperatorState::Stopped),
        ] {
            let answer = request(address, text);
            assert!(answer.starts_with(&format!("HTTP/1.1 {status}\r\n")), "{text}: {answer}");
            let body = match status {
                "200 OK" => format!("{{\"state\":\"{}\"}}", state.name()),
                "403 Forbidden" => json!({ "error": FOREIGN.1 }).to_string(),
                _ => "{\"error\":\"unknown request: use POST /arm, POST /stop or GET /status\"}"
                    .to_owned(),
            };
            assert!(answer.ends_with(&format!("\r\n\r\n{body}")), "{answer}");
            assert_eq!(switch.state(), state, "{text}");
        }
    }

    /// Silent clients, as many as are served at once and more, and one whose request has no end.
    #[test]
    fn silent_clients_do_not_delay_a_stop() {
        let (address, switch) = served();
        switch.arm();
        let connect = || TcpStream::connect(address).expect("a connection");
        let mut clients: Vec<TcpStream> = (0..2 * MAX_CLIENTS).map(|_| connect()).collect();
        clients.iter_mut().step_by(3).for_each(|client| _ = client.write_all(b"POST /arm"));
        let began = Instant::now();
        let answer = request(address, "POST /stop HTTP/1.1\r\n\r\n");
        let took = began.elapsed();
        assert!(answer.starts_with("HTTP/1.1 200 OK"), "{answer}");
        assert_eq!(switch.state(), OperatorState::Stopped);
        assert!(took < REQUEST_TIME, "{took:?}");
    }

    #[test]
    fn slow_and_long_requests_are_dropped() {
        let (address, switch) = served();
        let mut silent = TcpStream::connect(address).expect("a connection");
        let mut long = TcpStream::connect(address).expect("a connection");
        // The client may be dropped while it still sends.
        let _ = long.write_all(&[b'a'; 3 * MAX_HEAD]);
        let mut answer = Vec::new();
        let _ = long.read_to_end(&mut answer);
        assert!(answer.is_empty());
        assert_eq!(silent.read_to_end(&mut answer).ok(), Some(0), "closed without an answer");
        assert_eq!(switch.state(), OperatorState::NotArmed);
    }
}
