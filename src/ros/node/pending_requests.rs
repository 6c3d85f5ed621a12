//! Requests to services over DDS, and those whose answer comes from the control process.

use std::collections::VecDeque;

use ros2_client::RmwRequestId;

use super::incoming::IncomingMessage;

/// Maximum number of requests of each kind that one call takes.
pub const MAX_REQUESTS: usize = 16;

/// The requests that arrived, at most [`MAX_REQUESTS`]. One that cannot be decoded becomes a message that names the topic and what was
/// expected there.
pub fn arrived<R, E: ToString>(
    mut receive: impl FnMut() -> Result<Option<R>, E>,
    (topic, expected): (&'static str, &'static str),
    all: &mut Vec<IncomingMessage>,
) -> Vec<R> {
    let mut requests = Vec::new();
    for _ in 0..MAX_REQUESTS {
        match receive() {
            Ok(Some(request)) => requests.push(request),
            Ok(None) => break,
            Err(error) => {
                let reason = error.to_string();
                all.push(IncomingMessage::Undecodable { topic, expected, reason });
            }
        }
    }
    requests
}

/// Requests that wait for an answer, by the numbers that the two processes of the node give them.
#[derive(Default)]
pub struct PendingRequests {
    waiting: VecDeque<(u64, RmwRequestId)>,
    last: u64,
}

impl PendingRequests {
    /// Adds a request and returns its number, above zero. Beyond this number of requests the oldest is dropped.
    pub fn add(&mut self, request: RmwRequestId, max: usize) -> u64 {
        self.last += 1;
        if self.waiting.len() >= max {
            self.waiting.pop_front();
        }
        self.waiting.push_back((self.last, request));
        self.last
    }

    /// Takes the request with a number, if it still waits.
    pub fn take(&mut self, number: u64) -> Option<RmwRequestId> {
        let at = self.waiting.iter().position(|(waiting, _)| *waiting == number)?;
        self.waiting.remove(at).map(|(_, request)| request)
    }
}
