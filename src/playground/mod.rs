//! A web page on the loopback that evaluates decisions in the browser with the shaders of the GPU engine.
//!
//! The server converts a problem to the integers that the GPU engine would upload. The page runs the same WGSL over them in
//! the browser's WebGPU. The response also holds the CPU engine's result, and the page shows whether both have the same bits.

mod connection;
mod decision;
mod request;
mod response;
mod router;
mod scene;
mod server;

use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::Duration;

pub use decision::{FieldLookup, ProblemParser};
use router::Router;
pub use scene::{Scene, SceneError};
use server::RequestStats;

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
        let router = Router::new(address.port(), scenes, engines, parse);
        let stats = server::start(listener, router)?;
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
