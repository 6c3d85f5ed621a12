//! Connections on the loopback, a bounded number of them at a time.

use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use hyper::StatusCode;
use tokio::sync::Semaphore;
use tokio::{net, runtime, time};

use super::connection;
use super::refusal::Refusal;
use super::routes::Site;

/// Connections at a time; one more is told to come again. Of 1024 files, which many systems grant, it leaves some.
const MOST_CONNECTIONS: usize = 1008;
/// Threads that answers are made in. Most of them wait: an evaluation has a bound of its own.
const WORKERS: usize = 32;
/// After an error of the system's, such as too many open files.
const PAUSE: Duration = Duration::from_millis(20);

/// What was served.
#[derive(Default)]
pub struct Tally {
    /// Requests that are being answered.
    pub under_way: AtomicUsize,
    /// Requests answered with what they asked for.
    pub answered: AtomicU64,
    /// Requests refused.
    pub refused: AtomicU64,
}

impl Tally {
    /// One more answer.
    pub fn count(&self, status: StatusCode) {
        let count = if status.is_success() {
            &self.answered
        } else {
            &self.refused
        };
        count.fetch_add(1, Ordering::Relaxed);
    }
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
    let runtime = runtime::Builder::new_current_thread()
        .enable_all()
        .max_blocking_threads(WORKERS)
        .thread_name("playground work")
        .build()?;
    listener.set_nonblocking(true)?;
    let listener = {
        let _entered = runtime.enter();
        net::TcpListener::from_std(listener)?
    };
    let (site, counted) = (Arc::new(site), tally.clone());
    thread::Builder::new()
        .name("playground".to_owned())
        .spawn(move || runtime.block_on(admit(&listener, &site, &counted)))?;
    Ok(tally)
}

async fn admit(listener: &net::TcpListener, site: &Arc<Site>, tally: &Arc<Tally>) {
    let places = Arc::new(Semaphore::new(MOST_CONNECTIONS));
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            time::sleep(PAUSE).await;
            continue;
        };
        if let Ok(place) = places.clone().try_acquire_owned() {
            let (site, tally) = (site.clone(), tally.clone());
            tokio::spawn(async move {
                connection::serve(stream, &site, &tally).await;
                drop(place);
            });
        } else {
            let what = format!("{MOST_CONNECTIONS} requests wait already: come again later");
            let refusal = Refusal::new(StatusCode::SERVICE_UNAVAILABLE, what);
            connection::send_away(stream, refusal, tally).await;
        }
    }
}
