//! A web page on the loopback that evaluates decisions in the browser with the shaders of the GPU engine.
//!
//! The server converts a problem to the integers that the GPU engine would upload. The page runs the same WGSL over them in
//! the browser's WebGPU. The response also holds the CPU engine's result, and the page shows whether both have the same bits.

mod connection;
mod decision;
mod response;
mod router;
mod scene;

use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use hyper::StatusCode;
use tokio::sync::Semaphore;
use tokio::{net, runtime, time};

pub use decision::{FieldLookup, ProblemParser};
use response::HttpError;
use router::Router;
pub use scene::{Scene, SceneError};

/// Maximum number of connections at the same time: many systems allow 1024 open files, and this leaves some.
const MAX_CONNECTIONS: usize = 1008;
/// Threads that answer requests. Most of them wait: evaluations have a limit of their own.
const WORKERS: usize = 32;
/// Pause after an error of the operating system, such as too many open files.
const ERROR_PAUSE: Duration = Duration::from_millis(20);
/// Interval at which [`Playground::finish`] looks for requests in progress.
const POLL_INTERVAL: Duration = Duration::from_millis(20);
/// The longest wait for requests in progress at the end, in poll intervals.
const MAX_POLLS: u32 = 100;

/// A server on `127.0.0.1`, in threads of its own. It serves until the process ends.
pub struct Playground {
    address: SocketAddr,
    stats: Arc<RequestStats>,
}

/// How many requests a [`Playground`] has answered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct RequestCounts {
    /// Requests with a successful response.
    pub answered: u64,
    /// Requests with an error response.
    pub rejected: u64,
}

impl Playground {
    /// Serves these scenes at a port, or at any free port if it is 0. `parse` reads the problems of the requests.
    ///
    /// # Errors
    /// When the port is in use or the system provides no threads.
    pub fn start(port: u16, scenes: Vec<Scene>, parse: ProblemParser) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let address = listener.local_addr()?;
        let engines = thread::available_parallelism().map_or(1, usize::from);
        let router = Arc::new(Router::new(address.port(), scenes, engines, parse));
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
        let stats = Arc::new(RequestStats::default());
        let counted = stats.clone();
        thread::Builder::new()
            .name("playground".to_owned())
            .spawn(move || runtime.block_on(accept(&listener, &router, &counted)))?;
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
async fn accept(listener: &net::TcpListener, router: &Arc<Router>, stats: &Arc<RequestStats>) {
    let permits = Arc::new(Semaphore::new(MAX_CONNECTIONS));
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            time::sleep(ERROR_PAUSE).await;
            continue;
        };
        if let Ok(permit) = permits.clone().try_acquire_owned() {
            let (router, stats) = (router.clone(), stats.clone());
            tokio::spawn(async move {
                connection::serve(stream, &router, &stats).await;
                drop(permit);
            });
        } else {
            let message =
                format!("{MAX_CONNECTIONS} requests are already waiting: try again later");
            let error = HttpError::new(StatusCode::SERVICE_UNAVAILABLE, message);
            connection::reject(stream, error, stats).await;
        }
    }
}
