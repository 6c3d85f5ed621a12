//! An HTTP server on `127.0.0.1` for pages and their data. Other machines cannot reach it, and pages of other origins cannot
//! read it or change anything.

mod connection;
mod response;

use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use hyper::body::Bytes;
use hyper::header::{CONTENT_TYPE, HOST, HeaderName, ORIGIN};
use hyper::{Method, Request, StatusCode};
use serde_json::{Value, json};
use tokio::sync::Semaphore;
use tokio::{net, runtime, time};

#[cfg(feature = "playground")]
pub use connection::MAX_BODY_BYTES;
#[cfg(feature = "playground")]
pub use response::ok;
pub use response::{HttpError, Response, json, page};

/// Maximum number of connections at the same time: many systems allow 1024 open files, and this leaves some.
const MAX_CONNECTIONS: usize = 1008;
/// The port of URLs without a port.
const DEFAULT_PORT: u16 = 80;
/// Threads that answer requests. Most of them wait: evaluations have a limit of their own.
const WORKERS: usize = 32;
/// Pause after an error of the operating system, such as too many open files.
const ERROR_PAUSE: Duration = Duration::from_millis(20);
/// Interval at which [`Server::finish`] looks for requests in progress.
const POLL_INTERVAL: Duration = Duration::from_millis(20);
/// The longest wait for requests in progress at the end, in poll intervals.
const MAX_POLLS: u32 = 100;

/// Answers the requests of a server. The server has checked their host and their size.
pub trait Service: Send + Sync + 'static {
    /// The response to a request, on one of several threads.
    ///
    /// # Errors
    /// The error response.
    fn answer(&self, request: &Request<Bytes>) -> Result<Response, HttpError>;
}

/// A server on `127.0.0.1`, in its own threads. It serves until the process ends.
pub struct Server {
    address: SocketAddr,
    stats: Arc<RequestStats>,
}

/// How many requests a [`Server`] has answered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct RequestCounts {
    /// Requests with a successful response.
    pub answered: u64,
    /// Requests with an error response.
    pub rejected: u64,
}

impl Server {
    /// Serves at a port, or at any free port if it is 0.
    ///
    /// # Errors
    /// When the port is in use or the system provides no threads.
    pub fn start(port: u16, service: Arc<dyn Service>) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let address = listener.local_addr()?;
        let runtime = runtime::Builder::new_current_thread()
            .enable_all()
            .max_blocking_threads(WORKERS)
            .thread_name("server work")
            .build()?;
        listener.set_nonblocking(true)?;
        let listener = {
            let _entered = runtime.enter();
            net::TcpListener::from_std(listener)?
        };
        let stats = Arc::new(RequestStats::default());
        let shared = Arc::new(Shared { port: address.port(), service, stats: Arc::clone(&stats) });
        thread::Builder::new()
            .name("server".to_owned())
            .spawn(move || runtime.block_on(accept(&listener, &shared)))?;
        Ok(Self { address, stats })
    }

    /// The address of the server.
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// Waits up to 2 s for requests in progress and returns the request counts.
    #[must_use]
    pub fn finish(self) -> RequestCounts {
        for _ in 0..MAX_POLLS {
            if self.stats.in_progress.load(Ordering::Relaxed) == 0 {
                break;
            }
            thread::sleep(POLL_INTERVAL);
        }
        RequestCounts {
            answered: self.stats.answered.load(Ordering::Relaxed),
            rejected: self.stats.rejected.load(Ordering::Relaxed),
        }
    }
}

/// What all connections share.
struct Shared {
    port: u16,
    service: Arc<dyn Service>,
    stats: Arc<RequestStats>,
}

/// Counters of requests.
#[derive(Default)]
struct RequestStats {
    in_progress: AtomicUsize,
    /// Requests with a successful response.
    answered: AtomicU64,
    /// Requests with an error response.
    rejected: AtomicU64,
}

impl RequestStats {
    /// Counts a response.
    fn count(&self, status: StatusCode) {
        let count = if status.is_success() { &self.answered } else { &self.rejected };
        count.fetch_add(1, Ordering::Relaxed);
    }
}

/// Serves connections, a limited number at the same time.
async fn accept(listener: &net::TcpListener, shared: &Arc<Shared>) {
    let permits = Arc::new(Semaphore::new(MAX_CONNECTIONS));
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            time::sleep(ERROR_PAUSE).await;
            continue;
        };
        if let Ok(permit) = permits.clone().try_acquire_owned() {
            let shared = shared.clone();
            tokio::spawn(async move {
                connection::serve(stream, &shared).await;
                drop(permit);
            });
        } else {
            let message =
                format!("{MAX_CONNECTIONS} requests are already waiting: try again later");
            let error = HttpError::new(StatusCode::SERVICE_UNAVAILABLE, message);
            connection::reject(stream, error, &shared.stats).await;
        }
    }
}

impl Shared {
    fn answer(&self, request: &Request<Bytes>) -> Result<Response, HttpError> {
        self.check_host(request)?;
        self.service.answer(request)
    }

    /// Rejects other host names: a foreign page could otherwise read this server by DNS rebinding.
    fn check_host(&self, request: &Request<Bytes>) -> Result<(), HttpError> {
        let host = header(request, HOST).unwrap_or_default();
        if is_own_host(&host, self.port) {
            return Ok(());
        }
        let own = self.port;
        let message = format!("this server is not {}: open http://127.0.0.1:{own}/", quoted(&host));
        Err(HttpError::new(StatusCode::FORBIDDEN, message))
    }
}

/// Whether the header `Host` of a request names a server on this port. Clients leave out the default port.
fn is_own_host(host: &str, port: u16) -> bool {
    let (name, found) = match host.rsplit_once(':') {
        Some((name, found)) => (name, found.parse().ok()),
        None => (host, Some(DEFAULT_PORT)),
    };
    ["127.0.0.1", "localhost"].contains(&name) && found == Some(port)
}

/// Accepts GET and HEAD only.
///
/// # Errors
/// The response to another method.
pub fn check_get(request: &Request<Bytes>) -> Result<(), HttpError> {
    match *request.method() {
        Method::GET | Method::HEAD => Ok(()),
        ref other => Err(HttpError::method_not_allowed(other, "GET, HEAD")),
    }
}

/// Accepts a POST of JSON from a page of this server or from a program. Pages of another origin cannot send JSON without a
/// preflight request, so other content types are rejected too.
///
/// # Errors
/// The response to another request.
pub fn check_post(request: &Request<Bytes>) -> Result<(), HttpError> {
    if request.method() != Method::POST {
        return Err(HttpError::method_not_allowed(request.method(), "POST"));
    }
    let own = format!("http://{}", header(request, HOST).unwrap_or_default());
    if let Some(origin) = header(request, ORIGIN).filter(|origin| *origin != own) {
        let message = format!("requests from pages of {} are rejected", quoted(&origin));
        return Err(HttpError::new(StatusCode::FORBIDDEN, message));
    }
    let content_type = header(request, CONTENT_TYPE).unwrap_or_default();
    let content_type = content_type.split(';').next().unwrap_or_default();
    if content_type.trim().eq_ignore_ascii_case("application/json") {
        Ok(())
    } else {
        let cure = "send the body with Content-Type: application/json";
        Err(HttpError::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, cure))
    }
}

/// The error for a path without content.
#[must_use]
pub fn nothing_at(path: &str) -> HttpError {
    let message = format!("there is nothing at {}: start at /", quoted(path));
    HttpError::new(StatusCode::NOT_FOUND, message)
}

/// The value of a header.
fn header(request: &Request<Bytes>, name: HeaderName) -> Option<String> {
    let value = request.headers().get(name)?;
    Some(String::from_utf8_lossy(value.as_bytes()).into_owned())
}

/// A client's text in quotes, at most 60 characters, on one line.
fn quoted(text: &str) -> Value {
    let short: String = text.chars().take(60).collect();
    json!(short)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn host_without_a_port_is_that_of_port_80() {
        for host in ["127.0.0.1", "localhost", "localhost:80"] {
            assert!(is_own_host(host, 80), "{host}");
            assert!(!is_own_host(host, 8080), "{host}");
        }
        assert!(is_own_host("127.0.0.1:8080", 8080));
        for host in ["", "example.org", "example.org:8080", "localhost:", "127.0.0.1:8080:8080"] {
            assert!(!is_own_host(host, 80) && !is_own_host(host, 8080), "{host}");
        }
    }
}
