//! A connection: one request and its answer over HTTP/1.1, which `hyper` speaks, within bounds of size and time.

use std::convert::Infallible;
use std::future::ready;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use hyper::body::Incoming;
use hyper::server::conn::http1::Builder;
use hyper::service::service_fn;
use hyper::{Error, Request, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::io::{self, AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio::sync::Notify;
use tokio::task::spawn_blocking;
use tokio::time::{Instant, sleep, timeout, timeout_at};

use super::gate::Gate;
use super::refusal::Refusal;
use super::request::{self, MOST_HEAD_BYTES, MOST_HEADERS, PATIENCE};
use super::response::Response;
use super::routes::Site;
use super::server::Tally;

/// How long a client may take to read an answer.
const READING: Duration = Duration::from_secs(20);
/// How long a client may go on sending after its answer; one that is sent away at the door, less.
const FAREWELL: Duration = Duration::from_secs(1);
const BRIEF_FAREWELL: Duration = Duration::from_millis(10);
/// Most that is read of what a client sends on, bytes.
const MOST_DRAINED: u64 = 1 << 22;

/// Answers what the client asks, and closes the connection.
pub async fn serve(mut stream: TcpStream, site: &Arc<Site>, tally: &Tally) {
    let deadline = Instant::now() + PATIENCE;
    // Browsers open connections before they know whether they need them.
    let first = timeout_at(deadline, stream.peek(&mut [0])).await;
    if !matches!(first, Ok(Ok(1))) {
        return;
    }
    let (is_asked, is_answered) = (&AtomicBool::new(false), &Notify::new());
    let service = service_fn(|request| async move {
        is_asked.store(true, Ordering::Relaxed);
        tally.under_way.fetch_add(1, Ordering::Relaxed);
        let response = answer(request, deadline, site).await;
        let response = response.unwrap_or_else(Response::from);
        tally.count(response.status());
        is_answered.notify_one();
        Ok::<_, Infallible>(response)
    });
    // What is written goes at once: TCP would hold the last piece of several back.
    let _ = stream.set_nodelay(true);
    let (reader, writer) = stream.split();
    let both = io::join(reader, Gate::new(writer, is_asked));
    let connection = http(deadline).serve_connection(TokioIo::new(both), service);
    let unread = async {
        is_answered.notified().await;
        sleep(READING).await;
    };
    let served = tokio::select! {
        served = connection => served,
        () = unread => Ok(()),
    };
    if is_asked.load(Ordering::Relaxed) {
        tally.under_way.fetch_sub(1, Ordering::Relaxed);
    } else if let Err(error) = served {
        send(&mut stream, of_head(&error), tally).await;
    }
    // That is left to us where the client asked for another protocol.
    let _ = stream.shutdown().await;
    drain(stream, FAREWELL).await;
}

/// Refuses whatever the client is going to ask.
pub async fn send_away(mut stream: TcpStream, refusal: Refusal, tally: &Tally) {
    // The first bytes that a socket takes go without waiting.
    let _ = timeout(BRIEF_FAREWELL, send(&mut stream, refusal, tally)).await;
    drain(stream, BRIEF_FAREWELL).await;
}

/// Sends a refusal to a client that has asked for nothing that could be read: a request is put in its place.
async fn send(stream: &mut TcpStream, refusal: Refusal, tally: &Tally) {
    let response = Response::from(refusal);
    tally.count(response.status());
    let (_, writer) = stream.split();
    let both = io::join(&b"GET / HTTP/1.1\r\n\r\n"[..], writer);
    let service = service_fn(|_| ready(Ok::<_, Infallible>(response.clone())));
    // A client that is gone is no error of ours.
    let _ = http(Instant::now() + PATIENCE)
        .serve_connection(TokioIo::new(both), service)
        .await;
}

fn http(deadline: Instant) -> Builder {
    let mut http = Builder::new();
    http.timer(TokioTimer::new())
        .header_read_timeout(deadline - Instant::now())
        .max_buf_size(MOST_HEAD_BYTES)
        .max_headers(MOST_HEADERS)
        .keep_alive(false)
        .half_close(true)
        .title_case_headers(true);
    http
}

/// A mistake of ours costs one answer.
async fn answer(
    request: Request<Incoming>,
    deadline: Instant,
    site: &Arc<Site>,
) -> Result<Response, Refusal> {
    let request = request::receive(request, deadline).await?;
    let site = site.clone();
    let answered = spawn_blocking(move || site.answer(&request)).await;
    answered.unwrap_or_else(|_| {
        let what = "a mistake in the program: please report it with the request";
        Err(Refusal::new(StatusCode::INTERNAL_SERVER_ERROR, what))
    })
}

/// Why there is no request to answer.
fn of_head(error: &Error) -> Refusal {
    if error.is_timeout() {
        request::late()
    } else if error.is_parse_too_large() {
        request::head_too_large()
    } else {
        let what = format!("this is not HTTP/1.1: {error}");
        Refusal::new(StatusCode::BAD_REQUEST, what)
    }
}

/// Reads for so long what a client still sends: a connection closed on unread bytes loses the answer as well.
async fn drain(stream: TcpStream, farewell: Duration) {
    let mut rest = stream.take(MOST_DRAINED);
    let _ = timeout(farewell, io::copy(&mut rest, &mut io::sink())).await;
}
