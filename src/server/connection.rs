//! One connection: a request and its response over HTTP/1.1 (`hyper`), within limits of size and time.

use std::convert::Infallible;
use std::future::ready;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll};
use std::time::Duration;

use http_body_util::BodyExt as _;
use hyper::body::{Body as _, Bytes, Incoming};
use hyper::header::{CONTENT_LENGTH, HOST, TRANSFER_ENCODING};
use hyper::http::request::Parts;
use hyper::server::conn::http1::Builder;
use hyper::service::service_fn;
use hyper::{Error, Method, Request, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::io::{self, AsyncReadExt as _, AsyncWrite, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio::sync::Notify;
use tokio::task::spawn_blocking;
use tokio::time::{Instant, sleep, timeout, timeout_at};

use super::response::{HttpError, Response};
use super::{RequestStats, Shared};

/// Longest body of a request, bytes. A problem of the playground with the maximum number of obstacles has a twentieth of it.
pub const MAX_BODY_BYTES: u64 = 65_536;
/// Longest request line and headers, bytes.
const MAX_HEAD_BYTES: usize = 16_384;
/// Maximum number of headers.
const MAX_HEADERS: usize = 64;
/// Time within which the client must send the whole request.
const REQUEST_TIMEOUT: Duration = Duration::from_secs(5);
/// Time within which a client must read a response.
const RESPONSE_TIMEOUT: Duration = Duration::from_secs(20);
/// How long the server reads on after its response, and after the rejection of a connection.
const LINGER: Duration = Duration::from_secs(1);
const REJECTED_LINGER: Duration = Duration::from_millis(10);
/// Maximum number of bytes that the server reads and discards after its response.
const MAX_DRAINED_BYTES: u64 = 1 << 22;

/// Answers the client's request and closes the connection.
pub async fn serve(mut stream: TcpStream, shared: &Arc<Shared>) {
    let stats = &shared.stats;
    let deadline = Instant::now() + REQUEST_TIMEOUT;
    // Browsers open connections in advance and may never use them.
    let first = timeout_at(deadline, stream.peek(&mut [0])).await;
    if !matches!(first, Ok(Ok(1))) {
        return;
    }
    let (is_requested, is_answered) = (&AtomicBool::new(false), &Notify::new());
    let service = service_fn(|request| async move {
        is_requested.store(true, Ordering::Relaxed);
        stats.in_progress.fetch_add(1, Ordering::Relaxed);
        let response = answer(request, deadline, shared).await;
        let response = response.unwrap_or_else(Response::from);
        stats.count(response.status());
        is_answered.notify_one();
        Ok::<_, Infallible>(response)
    });
    // Without this, TCP delays the last segment of a response.
    let _ = stream.set_nodelay(true);
    let (reader, writer) = stream.split();
    let both = io::join(reader, GatedWriter { writer, is_open: is_requested });
    let connection = http(deadline).serve_connection(TokioIo::new(both), service);
    let response_timeout = async {
        is_answered.notified().await;
        sleep(RESPONSE_TIMEOUT).await;
    };
    let served = tokio::select! {
        served = connection => served,
        () = response_timeout => Ok(()),
    };
    if is_requested.load(Ordering::Relaxed) {
        stats.in_progress.fetch_sub(1, Ordering::Relaxed);
    } else if let Err(error) = served {
        send(&mut stream, head_error(&error), stats).await;
    }
    // hyper does not shut the stream down after a protocol upgrade request.
    let _ = stream.shutdown().await;
    drain(stream, LINGER).await;
}

/// Rejects the client's request without reading it.
pub async fn reject(mut stream: TcpStream, error: HttpError, stats: &RequestStats) {
    // The socket's buffer takes the response without waiting.
    let _ = timeout(REJECTED_LINGER, send(&mut stream, error, stats)).await;
    drain(stream, REJECTED_LINGER).await;
}

/// Sends an error response to a client without a valid request: `hyper` gets a substitute request.
async fn send(stream: &mut TcpStream, error: HttpError, stats: &RequestStats) {
    let response = Response::from(error);
    stats.count(response.status());
    let (_, writer) = stream.split();
    let both = io::join(&b"GET / HTTP/1.1\r\n\r\n"[..], writer);
    let service = service_fn(|_| ready(Ok::<_, Infallible>(response.clone())));
    // The client may have closed the connection: that is no error here.
    let _ =
        http(Instant::now() + REQUEST_TIMEOUT).serve_connection(TokioIo::new(both), service).await;
}

fn http(deadline: Instant) -> Builder {
    let mut http = Builder::new();
    http.timer(TokioTimer::new())
        .header_read_timeout(deadline - Instant::now())
        .max_buf_size(MAX_HEAD_BYTES)
        .max_headers(MAX_HEADERS)
        .keep_alive(false)
        .half_close(true)
        .title_case_headers(true);
    http
}

/// The response to a request. A panic in the service fails this response only.
async fn answer(
    request: Request<Incoming>,
    deadline: Instant,
    shared: &Arc<Shared>,
) -> Result<Response, HttpError> {
    let request = receive(request, deadline).await?;
    let shared = shared.clone();
    let answered = spawn_blocking(move || shared.answer(&request)).await;
    answered.unwrap_or_else(|_| {
        let message = "internal error of the program: please report it with the request";
        Err(HttpError::new(StatusCode::INTERNAL_SERVER_ERROR, message))
    })
}

/// Returns the request with its whole body.
async fn receive(
    request: Request<Incoming>,
    deadline: Instant,
) -> Result<Request<Bytes>, HttpError> {
    let (head, body) = request.into_parts();
    // The lower bound is the Content-Length: chunked bodies are rejected.
    check(&head, body.size_hint().lower())?;
    let received = timeout_at(deadline, body.collect()).await;
    let body = received
        .map_err(|_| timed_out())?
        .map_err(|error| HttpError::bad_request(format!("the body is incomplete: {error}")))?;
    Ok(Request::from_parts(head, body.to_bytes()))
}

fn check(head: &Parts, body_bytes: u64) -> Result<(), HttpError> {
    if head.headers.get_all(HOST).iter().count() != 1 {
        return Err(HttpError::bad_request("a request has exactly one Host"));
    }
    if head.headers.contains_key(TRANSFER_ENCODING) {
        let cure = "send the body with a Content-Length, not in chunks";
        return Err(HttpError::new(StatusCode::LENGTH_REQUIRED, cure));
    }
    if head.method == Method::POST && !head.headers.contains_key(CONTENT_LENGTH) {
        let cure = "a POST needs the Content-Length of its body";
        return Err(HttpError::new(StatusCode::LENGTH_REQUIRED, cure));
    }
    if body_bytes > MAX_BODY_BYTES {
        let message = format!("the body has {body_bytes} bytes: send at most {MAX_BODY_BYTES}");
        return Err(HttpError::new(StatusCode::PAYLOAD_TOO_LARGE, message));
    }
    Ok(())
}

/// The error for a request that exceeds [`REQUEST_TIMEOUT`].
fn timed_out() -> HttpError {
    let seconds = REQUEST_TIMEOUT.as_secs();
    let message = format!("the request took longer than {seconds} s: send all of it at once");
    HttpError::new(StatusCode::REQUEST_TIMEOUT, message)
}

/// The error for a request line and headers that `hyper` cannot read.
fn head_error(error: &Error) -> HttpError {
    if error.is_timeout() {
        return timed_out();
    }
    if !error.is_parse_too_large() {
        return HttpError::bad_request(format!("this is not HTTP/1.1: {error}"));
    }
    let message =
        format!("the head is too large: at most {MAX_HEAD_BYTES} bytes and {MAX_HEADERS} headers");
    HttpError::new(StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE, message)
}

/// Reads what the client still sends: closing a connection with unread bytes would discard the response as well.
async fn drain(stream: TcpStream, linger: Duration) {
    let mut rest = stream.take(MAX_DRAINED_BYTES);
    let _ = timeout(linger, io::copy(&mut rest, &mut io::sink())).await;
}

/// A writer that discards everything until it is opened.
///
/// `hyper` answers an invalid head by itself, without a message, and has no setting against it. This writer discards that
/// response, and [`serve`] sends its own.
struct GatedWriter<'a, W> {
    writer: W,
    is_open: &'a AtomicBool,
}

impl<W: Unpin> GatedWriter<'_, W> {
    /// The inner writer, if the gate is open.
    fn inner(self: Pin<&mut Self>) -> Option<Pin<&mut W>> {
        let is_open = self.is_open.load(Ordering::Relaxed);
        is_open.then(|| Pin::new(&mut self.get_mut().writer))
    }
}

impl<W: AsyncWrite + Unpin> AsyncWrite for GatedWriter<'_, W> {
    fn poll_write(
        self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let discarded = Poll::Ready(Ok(bytes.len()));
        self.inner().map_or(discarded, |writer| writer.poll_write(context, bytes))
    }

    fn poll_flush(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.inner().map_or(Poll::Ready(Ok(())), |writer| writer.poll_flush(context))
    }

    fn poll_shutdown(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.inner().map_or(Poll::Ready(Ok(())), |writer| writer.poll_shutdown(context))
    }
}
