//! A web page on the loopback that evaluates decisions in the browser with the shaders of the GPU engine.
//!
//! The server converts a problem to the integers that the GPU engine would upload. The page runs the same WGSL over them in
//! the browser's WebGPU. The response also holds the CPU engine's result, and the page shows whether both have the same bits.
//! The page can also let the whole navigator drive to the goal.

mod decision;
mod drive;
mod router;
mod scene;

use std::io;
use std::sync::Arc;
use std::thread;

pub use crate::server::{RequestCounts, Server};
pub use decision::{FieldLookup, ProblemParser};
use router::Router;
pub use scene::{Scene, SceneError};

/// Serves these scenes on `127.0.0.1` at a port, or at any free port if it is 0. `parse` reads the problems of the requests.
///
/// # Errors
/// When the port is in use or the system provides no threads.
pub fn start(port: u16, scenes: Vec<Scene>, parse: ProblemParser) -> io::Result<Server> {
    let engines = thread::available_parallelism().map_or(1, usize::from);
    Server::start(port, Arc::new(Router::new(scenes, engines, parse)))
}
