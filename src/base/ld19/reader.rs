//! A thread that reads a lidar, and its latest revolution.

use std::io::Read;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use thiserror::Error;

use super::revolutions::MIN_SPEED_DEG_S;
use super::{Decoder, LidarSettings, RevolutionAssembler};
use crate::base::BaseError;
use crate::base::error::is_timeout;
use crate::base::supervisor::Backoff;
use crate::map::TimedScan;

/// Shortest and longest pause between attempts to reconnect, seconds.
const RECONNECT_MIN_S: f64 = 0.125;
const RECONNECT_MAX_S: f64 = 1.0;

/// Time between checks while disconnected.
const POLL_PERIOD: Duration = Duration::from_millis(20);

/// Longest time between two reads. After a longer one the port has buffered bytes that measure the surroundings of that time.
const MAX_GAP: Duration = Duration::from_millis(500);

/// Number of bytes without a packet after which another device or baud rate is assumed.
const UNKNOWN_DATA_BYTES: u64 = 2_000;

/// Opens the lidar's port, also after a disconnection. Its reads block for a short time only.
pub type OpenLidar = Box<dyn FnMut() -> Result<Box<dyn Read + Send>, BaseError> + Send>;

/// Why there is no recent revolution.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LidarFault {
    /// The port is gone.
    #[error("the lidar is disconnected ({reason}): plug it in")]
    Disconnected {
        /// Message of the operating system.
        reason: String,
    },
    /// Bytes arrive that contain no packet.
    #[error("no LD19 packet in the received bytes: is it an LD19, at 230400 baud?")]
    UnknownData,
    /// Packets arrive, but the lidar does not rotate.
    #[error("the lidar does not rotate: is its motor free and its 5 V supply strong enough?")]
    NotRotating,
    /// No complete revolution within the timeout.
    #[error("no complete revolution of the lidar for {for_s:.1} s: is it switched on?")]
    Silent {
        /// Time since the last revolution, seconds.
        for_s: f64,
    },
}

/// Snapshot of a lidar.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct LidarStatus {
    /// The latest revolution, with times by the reader's clock.
    pub scan: Option<Arc<TimedScan>>,
    /// Complete revolutions so far.
    pub revolutions: u64,
    /// Valid packets so far.
    pub packets: u64,
    /// Bytes that are no part of a packet.
    pub dropped_bytes: u64,
    /// Times the port was opened.
    pub connections: u64,
    /// Why there is no recent revolution, if so.
    pub fault: Option<LidarFault>,
}

/// Reads a lidar on a thread until it is dropped.
pub struct LidarReader {
    shared: Arc<Mutex<SharedState>>,
    settings: LidarSettings,
    started: Instant,
    shutdown: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct SharedState {
    status: LidarStatus,
    /// Time of the last revolution, and the speed of rotation.
    revolution_s: f64,
    speed_deg_s: u16,
    disconnected: Option<String>,
    /// Bytes since the last packet.
    unknown_bytes: u64,
}

impl LidarReader {
    /// Opens the port and starts reading.
    ///
    /// # Errors
    /// Settings out of range, and errors of the first `open`.
    pub fn start(mut open: OpenLidar, settings: LidarSettings) -> Result<Self, BaseError> {
        settings.validate()?;
        let port = open()?;
        let shared = Arc::new(Mutex::new(SharedState::default()));
        lock(&shared).status.connections = 1;
        let (started, shutdown) = (Instant::now(), Arc::new(AtomicBool::new(false)));
        let read_loop = ReadLoop {
            open,
            port: Some(port),
            backoff: Backoff::new(RECONNECT_MIN_S, RECONNECT_MAX_S),
            decoder: Decoder::default(),
            assembler: RevolutionAssembler::new(settings),
            settings,
            last_read: started,
            drops_buffered: false,
            started,
            shared: Arc::clone(&shared),
            shutdown: Arc::clone(&shutdown),
        };
        let thread = thread::Builder::new()
            .name("lidar".to_owned())
            .spawn(move || read_loop.run())
            .map_err(|error| BaseError::Port {
                port: "lidar".to_owned(),
                reason: format!("cannot start its thread ({error})"),
            })?;
        Ok(Self { shared, settings, started, shutdown, thread: Some(thread) })
    }

    /// The reader's clock, seconds since its start: the time base of the beams.
    #[must_use]
    pub fn now_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Returns a snapshot of the state.
    #[must_use]
    pub fn status(&self) -> LidarStatus {
        let now_s = self.now_s();
        let shared = lock(&self.shared);
        let for_s = now_s - shared.revolution_s;
        let fault = if let Some(reason) = &shared.disconnected {
            let reason = reason.clone();
            Some(LidarFault::Disconnected { reason })
        } else if for_s <= self.settings.timeout_s {
            None
        } else if shared.unknown_bytes > UNKNOWN_DATA_BYTES {
            Some(LidarFault::UnknownData)
        } else if shared.status.packets > 0 && f64::from(shared.speed_deg_s) < MIN_SPEED_DEG_S {
            Some(LidarFault::NotRotating)
        } else {
            Some(LidarFault::Silent { for_s })
        };
        LidarStatus { fault, ..shared.status.clone() }
    }
}

impl Drop for LidarReader {
    fn drop(&mut self) {
        self.shutdown.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// The thread's state.
struct ReadLoop {
    open: OpenLidar,
    port: Option<Box<dyn Read + Send>>,
    backoff: Backoff,
    decoder: Decoder,
    assembler: RevolutionAssembler,
    settings: LidarSettings,
    last_read: Instant,
    /// Whether received bytes are dropped until the port's buffer is empty.
    drops_buffered: bool,
    started: Instant,
    shared: Arc<Mutex<SharedState>>,
    shutdown: Arc<AtomicBool>,
}

impl ReadLoop {
    fn run(mut self) {
        let mut bytes = [0; 1024];
        while !self.shutdown.load(Ordering::Relaxed) {
            let Some(port) = &mut self.port else {
                self.reconnect();
                continue;
            };
            let read = port.read(&mut bytes);
            let now = Instant::now();
            self.drops_buffered |= now.duration_since(self.last_read) > MAX_GAP;
            self.last_read = now;
            match read {
                Ok(0) => self.disconnect("end of the stream".to_owned()),
                Ok(count) if self.drops_buffered => self.drop_buffered(count == bytes.len()),
                Ok(count) => self.receive(&bytes[..count]),
                Err(error) if is_timeout(error.kind()) => {}
                Err(error) => self.disconnect(error.to_string()),
            }
        }
    }

    /// Drops received bytes. The last ones are those that do not fill the buffer: then the next revolution begins.
    fn drop_buffered(&mut self, is_more_buffered: bool) {
        if !is_more_buffered {
            self.drops_buffered = false;
            self.decoder = Decoder::default();
            self.assembler = RevolutionAssembler::new(self.settings);
        }
    }

    fn receive(&mut self, bytes: &[u8]) {
        let now_s = self.started.elapsed().as_secs_f64();
        self.decoder.push(bytes);
        let dropped_before = self.decoder.dropped_bytes();
        let mut shared = lock(&self.shared);
        shared.unknown_bytes += bytes.len() as u64;
        for packet in self.decoder.by_ref() {
            shared.unknown_bytes = 0;
            shared.status.packets += 1;
            shared.speed_deg_s = packet.speed_deg_s;
            if let Some(scan) = self.assembler.push(&packet, now_s) {
                shared.status.revolutions += 1;
                shared.revolution_s = now_s;
                shared.status.scan = Some(Arc::new(scan));
            }
        }
        // The decoder is a new one after each reconnection.
        shared.status.dropped_bytes += self.decoder.dropped_bytes() - dropped_before;
    }

    fn disconnect(&mut self, reason: String) {
        self.port = None;
        self.backoff.failed(self.started.elapsed().as_secs_f64());
        lock(&self.shared).disconnected = Some(reason);
    }

    fn reconnect(&mut self) {
        thread::sleep(POLL_PERIOD);
        let now_s = self.started.elapsed().as_secs_f64();
        if !self.backoff.is_due(now_s) {
            return;
        }
        match (self.open)() {
            Ok(port) => {
                self.port = Some(port);
                self.last_read = Instant::now();
                self.backoff.succeeded();
                self.decoder = Decoder::default();
                self.assembler = RevolutionAssembler::new(self.settings);
                let mut shared = lock(&self.shared);
                shared.disconnected = None;
                shared.unknown_bytes = 0;
                shared.status.connections += 1;
            }
            Err(error) => self.disconnect(error.to_string()),
        }
    }
}

fn lock(shared: &Mutex<SharedState>) -> MutexGuard<'_, SharedState> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}
