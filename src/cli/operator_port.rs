//! The operator's port on localhost: HTTP requests that arm and stop the robot.
//!
//! One thread serves all clients at once. A client that is slow or silent delays no other one.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::thread;
use std::time::{Duration, Instant};

use inbye::base::OperatorSwitch;
use serde_json::json;

/// Longest head of a request, bytes, and its longest time.
const MAX_HEAD: usize = 4096;
const REQUEST_TIME: Duration = Duration::from_millis(500);

/// Most clients at once. A further one takes the place of the client that has waited longest.
const MAX_CLIENTS: usize = 64;

/// Time between two looks at the clients that have not sent their requests.
const POLL_TIME: Duration = Duration::from_millis(2);

/// A client whose request is not complete.
struct Client {
    stream: TcpStream,
    head: Vec<u8>,
    since: Instant,
}

/// What became of a client.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Progress {
    Waiting,
    Complete,
    Gone,
}

/// Serves the port as long as it exists.
pub fn serve(listener: &TcpListener, switch: &OperatorSwitch) {
    let mut clients: Vec<Client> = Vec::new();
    loop {
        // Without clients it waits for one; else it looks for more, and at all of them.
        if listener.set_nonblocking(!clients.is_empty()).is_err() {
            return;
        }
        if let Ok(client) = accept(listener) {
            if clients.len() == MAX_CLIENTS {
                clients.remove(0);
            }
            clients.push(client);
        } else {
            thread::sleep(POLL_TIME);
        }
        serve_clients(&mut clients, switch);
    }
}

fn accept(listener: &TcpListener) -> io::Result<Client> {
    let (stream, _) = listener.accept()?;
    stream.set_nonblocking(true)?;
    Ok(Client { stream, head: Vec::new(), since: Instant::now() })
}

/// Answers every complete request, and drops the clients that are too slow or send too much.
fn serve_clients(clients: &mut Vec<Client>, switch: &OperatorSwitch) {
    clients.retain_mut(|client| match client.read() {
        Progress::Waiting => client.since.elapsed() < REQUEST_TIME,
        Progress::Complete => {
            client.answer(switch);
            false
        }
        Progress::Gone => false,
    });
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
            if self.head.windows(4).any(|end| end == b"\r\n\r\n") {
                return Progress::Complete;
            }
        }
        Progress::Gone
    }

    /// Obeys a request and answers it.
    fn answer(&mut self, switch: &OperatorSwitch) {
        let Ok(head) = str::from_utf8(&self.head) else {
            return;
        };
        // A page of another site in a browser must not arm a robot.
        let is_foreign = head.to_ascii_lowercase().contains("\norigin:");
        let mut words = head.split_whitespace();
        let status = match (words.next(), words.next()) {
            (Some("POST"), Some("/stop")) => {
                switch.stop();
                "200 OK"
            }
            (Some("POST"), Some("/arm")) if is_foreign => "403 Forbidden",
            (Some("POST"), Some("/arm")) => {
                switch.arm();
                "200 OK"
            }
            (Some("GET"), Some("/status")) => "200 OK",
            _ => "404 Not Found",
        };
        let body = json!({ "state": switch.state().name() }).to_string();
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

    use inbye::base::OperatorState;

    use super::*;

    /// A served port and its switch.
    fn served() -> (SocketAddr, OperatorSwitch) {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a free port");
        let address = listener.local_addr().expect("an address");
        let switch = OperatorSwitch::default();
        let shared = switch.clone();
        thread::spawn(move || serve(&listener, &shared));
        (address, switch)
    }

    fn request(address: SocketAddr, text: &str) -> String {
        let mut stream = TcpStream::connect(address).expect("a connection");
        stream.write_all(text.as_bytes()).expect("a request");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("an answer");
        answer
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
            assert!(answer.ends_with(&format!("{{\"state\":\"{}\"}}", state.name())), "{answer}");
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
