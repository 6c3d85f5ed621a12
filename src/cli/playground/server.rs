//! Connections on the loopback, a bounded number of them at a time.
//!
//! Of the small servers there are, `tiny_http` reads headers of any length, waits for slow clients for ever, and starts a
//! thread for each: here head, body, time, threads and the queue before them all have a bound. `httparse` reads the heads.

use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use super::head::Request;
use super::refusal::Refusal;
use super::request;
use super::response::Response;
use super::routes::Site;

/// Connections served at a time. Most of them wait for their client: an evaluation has a bound of its own.
const WORKERS: usize = 32;
/// Connections that wait for their turn; one more is told to come again.
const WAITING: usize = 1024;
/// How long a client may go on sending after its answer; one that is sent away at the door, less.
const FAREWELL: Duration = Duration::from_secs(1);
const BRIEF_FAREWELL: Duration = Duration::from_millis(10);
/// After an error of the system's, such as too many open files.
const PAUSE: Duration = Duration::from_millis(20);

/// What was served.
#[derive(Default)]
pub struct Tally {
    /// Connections that are being served, or wait to be.
    pub open: AtomicUsize,
    /// Requests answered with what they asked for.
    pub answered: AtomicU64,
    /// Requests refused.
    pub refused: AtomicU64,
}

/// The loopback address with this port, or any free one where it is 0.
pub fn bind(port: u16) -> io::Result<(TcpListener, SocketAddr)> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
    let address = listener.local_addr()?;
    Ok((listener, address))
}

/// Serves in threads of its own until the program ends.
pub fn start(listener: TcpListener, site: Site) -> io::Result<Arc<Tally>> {
    let tally = Arc::new(Tally::default());
    let site = Arc::new(site);
    let (sender, receiver) = sync_channel::<TcpStream>(WAITING);
    let receiver = Arc::new(Mutex::new(receiver));
    for _ in 0..WORKERS {
        let (site, tally, receiver) = (site.clone(), tally.clone(), receiver.clone());
        thread::Builder::new()
            .name("playground".to_owned())
            .spawn(move || work(&receiver, &site, &tally))?;
    }
    let counted = tally.clone();
    thread::Builder::new()
        .name("playground door".to_owned())
        .spawn(move || admit(&listener, &sender, &counted))?;
    Ok(tally)
}

fn admit(listener: &TcpListener, sender: &SyncSender<TcpStream>, tally: &Tally) {
    loop {
        let Ok((stream, _)) = listener.accept() else {
            thread::sleep(PAUSE);
            continue;
        };
        tally.open.fetch_add(1, Ordering::Relaxed);
        match sender.try_send(stream) {
            Ok(()) => {}
            Err(TrySendError::Full(stream)) => {
                let what = format!("{WAITING} requests wait already: come again later");
                let response = Refusal::new(503, what).into();
                send(&response, stream, BRIEF_FAREWELL, tally);
                tally.open.fetch_sub(1, Ordering::Relaxed);
            }
            Err(TrySendError::Disconnected(_)) => return,
        }
    }
}

fn work(receiver: &Mutex<Receiver<TcpStream>>, site: &Site, tally: &Tally) {
    loop {
        let next = receiver
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .recv();
        let Ok(mut stream) = next else {
            return;
        };
        let response = match request::read(&mut stream) {
            Ok(None) => None,
            Ok(Some(request)) => Some(answer(site, &request)),
            Err(refusal) => Some(refusal.into()),
        };
        if let Some(response) = response {
            send(&response, stream, FAREWELL, tally);
        }
        tally.open.fetch_sub(1, Ordering::Relaxed);
    }
}

/// A mistake of ours costs one answer, not a thread.
fn answer(site: &Site, request: &Request) -> Response {
    let answered = catch_unwind(AssertUnwindSafe(|| site.answer(request)));
    let what = "a mistake in the program: please report it with the request";
    let response = answered.unwrap_or_else(|_| Err(Refusal::new(500, what)));
    response
        .unwrap_or_else(Response::from)
        .in_answer_to(&request.method)
}

fn send(response: &Response, stream: TcpStream, farewell: Duration, tally: &Tally) {
    let count = if response.status == 200 {
        &tally.answered
    } else {
        &tally.refused
    };
    count.fetch_add(1, Ordering::Relaxed);
    // What is written goes at once: TCP would hold the last piece of several back.
    let _ = stream.set_nodelay(true);
    response.send(stream, farewell);
}
