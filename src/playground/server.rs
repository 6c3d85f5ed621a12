//! Accepts connections on the loopback, a limited number at the same time.

use std::io;
use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use hyper::StatusCode;
use tokio::sync::Semaphore;
use tokio::{net, runtime, time};

use super::connection;
use super::response::HttpError;
use super::router::Router;

/// Maximum number of connections at the same time: many systems allow 1024 open files, and this leaves some.
const MAX_CONNECTIONS: usize = 1008;
/// Threads that answer requests. Most of them wait: evaluations have a limit of their own.
const WORKERS: usize = 32;
/// Pause after an error of the operating system, such as too many open files.
const ERROR_PAUSE: Duration = Duration::from_millis(20);

/// Counters of requests.
#[derive(Default)]
pub struct RequestStats {
    pub in_progress: AtomicUsize,
    /// Requests with a successful response.
    pub answered: AtomicU64,
    /// Requests with an error response.
    pub rejected: AtomicU64,
}

impl RequestStats {
    /// Counts a response.
    pub fn count(&self, status: StatusCode) {
        let count = if status.is_success() { &self.answered } else { &self.rejected };
        count.fetch_add(1, Ordering::Relaxed);
    }
}

/// Serves in threads of its own until the process ends.
pub fn start(listener: TcpListener, router: Router) -> io::Result<Arc<RequestStats>> {
    let stats = Arc::new(RequestStats::default());
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
    let (router, counted) = (Arc::new(router), stats.clone());
    thread::Builder::new()
        .name("playground".to_owned())
        .spawn(move || runtime.block_on(accept(&listener, &router, &counted)))?;
    Ok(stats)
}

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
