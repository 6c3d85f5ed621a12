//! One connection: a request and its response over HTTP/1.1 (`hyper`), within limits of size and time.

use std::convert::Infallible;
use std::future::ready;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll};
use std::time::Duration;

use hyper::body::Incoming;
use hyper::server::conn::http1::Builder;
use hyper::service::service_fn;
use hyper::{Error, Request, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::io::{self, AsyncReadExt as _, AsyncWrite, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio::sync::Notify;
use tokio::task::spawn_blocking;
use tokio::time::{Instant, sleep, timeout, timeout_at};

use super::request::{self, MAX_HEAD_BYTES, MAX_HEADERS, REQUEST_TIMEOUT};
use super::response::{HttpError, Response};
use super::router::Router;
use super::server::RequestStats;

/// Time within which a client must read a response.
const RESPONSE_TIMEOUT: Duration = Duration::from_secs(20);
/// How long the server reads on after its response, and after the rejection of a connection.
const LINGER: Duration = Duration::from_secs(1);
const REJECTED_LINGER: Duration = Duration::from_millis(10);
/// Maximum number of bytes that the server reads and discards after its response.
const MAX_DRAINED_BYTES: u64 = 1 << 22;

/// Answers the client's request and closes the connection.
pub async fn serve(mut stream: TcpStream, router: &Arc<Router>, stats: &RequestStats) {
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
        let response = answer(request, deadline, router).await;
        let response = response.unwrap_or_else(Response::from);
        stats.count(response.status());
        is_answered.notify_one();
        Ok::<_, Infallible>(response)
    });
    // Without this, TCP delays the last segment of a response.
    let _ = stream.set_nodelay(true);
    let (reader, writer) = stream.split();
    let both = io::join(reader, GatedWriter::new(writer, is_requested));
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

/// The response to a request. A panic in the router fails this response only.
async fn answer(
    request: Request<Incoming>,
    deadline: Instant,
    router: &Arc<Router>,
) -> Result<Response, HttpError> {
    let request = request::receive(request, deadline).await?;
    let router = router.clone();
    let answered = spawn_blocking(move || router.answer(&request)).await;
    answered.unwrap_or_else(|_| {
        let message = "internal error of the program: please report it with the request";
        Err(HttpError::new(StatusCode::INTERNAL_SERVER_ERROR, message))
    })
}

/// The error for a request line and headers that `hyper` cannot read.
fn head_error(error: &Error) -> HttpError {
    if error.is_timeout() {
        request::timed_out()
    } else if error.is_parse_too_large() {
        request::head_too_large()
    } else {
        HttpError::bad_request(format!("this is not HTTP/1.1: {error}"))
    }
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

impl<'a, W> GatedWriter<'a, W> {
    const fn new(writer: W, is_open: &'a AtomicBool) -> Self {
        Self { writer, is_open }
    }

    /// The inner writer, if the gate is open.
    fn inner(self: Pin<&mut Self>) -> Option<Pin<&mut W>>
    where
        W: Unpin,
    {
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
        match self.inner() {
            Some(writer) => writer.poll_write(context, bytes),
            None => Poll::Ready(Ok(bytes.len())),
        }
    }

    fn poll_flush(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        match self.inner() {
            Some(writer) => writer.poll_flush(context),
            None => Poll::Ready(Ok(())),
        }
    }

    fn poll_shutdown(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        match self.inner() {
            Some(writer) => writer.poll_shutdown(context),
            None => Poll::Ready(Ok(())),
        }
    }
}
