//! A thread that hears a lidar, and what it heard last.

use core::fmt;
use std::io::{ErrorKind, Read};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::{Decoder, LidarSettings, Revolutions};
use crate::base::BaseError;
use crate::base::keeper::back_off::BackOff;
use crate::map::TimedScan;

/// First and longest pause before a line that was lost is opened anew, seconds.
const FIRST_PAUSE_S: f64 = 0.125;
const LONGEST_PAUSE_S: f64 = 1.0;

/// Longest time without looking whether to end.
const LOOK: Duration = Duration::from_millis(20);

/// So many bytes without a packet in them are of another device, or at another speed.
const STRANGE_BYTES: u64 = 2_000;

/// A lidar that turns more slowly than this stands, degrees per second.
const STANDS_DEG_S: u16 = 360;

/// Opens the lidar's line, again after it was lost. Reads of it do not block for long.
pub type OpenLidar = Box<dyn FnMut() -> Result<Box<dyn Read + Send>, BaseError> + Send>;

/// Why there is no fresh revolution.
#[derive(Clone, Debug, PartialEq)]
pub enum LidarTrouble {
    /// The line is gone.
    Unplugged {
        /// As the system has it.
        reason: String,
    },
    /// Bytes come, and no packet is in them.
    Strange,
    /// Packets come, and it does not turn.
    Stands,
    /// No whole turn has come for a while, or none yet.
    Silent {
        /// For how long, seconds.
        for_s: f64,
    },
}

impl fmt::Display for LidarTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unplugged { reason } => {
                write!(f, "the lidar is gone ({reason}): plug it in")
            }
            Self::Strange => f.write_str(
                "what comes is no packet of an LD19: is it one, and does its line run at 230400 baud?",
            ),
            Self::Stands => f.write_str("the lidar does not turn: is its motor free and its 5 V strong enough?"),
            Self::Silent { for_s } => {
                write!(f, "no whole turn of the lidar for {for_s:.1} s: is it switched on?")
            }
        }
    }
}

/// How things are.
#[derive(Clone, Debug, Default)]
pub struct LidarStatus {
    /// The newest whole turn, by the keeper's time.
    pub sweep: Option<Arc<TimedScan>>,
    /// Whole turns so far.
    pub turns: u64,
    /// Packets so far.
    pub packets: u64,
    /// Bytes that were no part of a packet.
    pub dropped_bytes: u64,
    /// Times that the line was opened.
    pub opened: u64,
    /// Why there is no fresh turn.
    pub trouble: Option<LidarTrouble>,
}

/// Hears a lidar until it is dropped.
pub struct LidarKeeper {
    board: Arc<Mutex<Board>>,
    settings: LidarSettings,
    began: Instant,
    end: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Board {
    status: LidarStatus,
    /// When the last whole turn came, and how it turned.
    turned_s: f64,
    speed_deg_s: u16,
    unplugged: Option<String>,
    /// Bytes since the last packet.
    strange: u64,
}

impl LidarKeeper {
    /// Opens the line and listens.
    ///
    /// # Errors
    /// Settings out of range, and those of the opener at its first try.
    pub fn start(mut open: OpenLidar, settings: LidarSettings) -> Result<Self, BaseError> {
        settings.validate()?;
        let line = open()?;
        let board = Arc::new(Mutex::new(Board::default()));
        lock(&board).status.opened = 1;
        let (began, end) = (Instant::now(), Arc::new(AtomicBool::new(false)));
        let listener = Listener {
            open,
            line: Some(line),
            back_off: BackOff::new(FIRST_PAUSE_S, LONGEST_PAUSE_S),
            decoder: Decoder::default(),
            revolutions: Revolutions::new(settings),
            began,
            board: Arc::clone(&board),
            end: Arc::clone(&end),
        };
        let thread = thread::Builder::new()
            .name("lidar".to_owned())
            .spawn(move || listener.run())
            .map_err(|error| BaseError::Port {
                port: "lidar".to_owned(),
                reason: format!("no thread to listen on ({error})"),
            })?;
        Ok(Self {
            board,
            settings,
            began,
            end,
            thread: Some(thread),
        })
    }

    /// The keeper's time, seconds: that of the beams.
    #[must_use]
    pub fn now_s(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    /// How things are.
    #[must_use]
    pub fn status(&self) -> LidarStatus {
        let now_s = self.now_s();
        let board = lock(&self.board);
        let for_s = now_s - board.turned_s;
        let trouble = if let Some(reason) = &board.unplugged {
            let reason = reason.clone();
            Some(LidarTrouble::Unplugged { reason })
        } else if for_s <= self.settings.silent_after_s {
            None
        } else if board.strange > STRANGE_BYTES {
            Some(LidarTrouble::Strange)
        } else if board.status.packets > 0 && board.speed_deg_s < STANDS_DEG_S {
            Some(LidarTrouble::Stands)
        } else {
            Some(LidarTrouble::Silent { for_s })
        };
        LidarStatus {
            trouble,
            ..board.status.clone()
        }
    }
}

impl Drop for LidarKeeper {
    fn drop(&mut self) {
        self.end.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// What the thread has.
struct Listener {
    open: OpenLidar,
    line: Option<Box<dyn Read + Send>>,
    back_off: BackOff,
    decoder: Decoder,
    revolutions: Revolutions,
    began: Instant,
    board: Arc<Mutex<Board>>,
    end: Arc<AtomicBool>,
}

impl Listener {
    fn run(mut self) {
        let mut bytes = [0; 1024];
        while !self.end.load(Ordering::Relaxed) {
            let Some(line) = &mut self.line else {
                self.open_again();
                continue;
            };
            match line.read(&mut bytes) {
                Ok(0) => self.lose("the line has ended".to_owned()),
                Ok(count) => self.hear(&bytes[..count]),
                Err(error) if is_silence(error.kind()) => {}
                Err(error) => self.lose(error.to_string()),
            }
        }
    }

    fn hear(&mut self, bytes: &[u8]) {
        let now_s = self.began.elapsed().as_secs_f64();
        self.decoder.push(bytes);
        let mut board = lock(&self.board);
        board.strange += bytes.len() as u64;
        for packet in self.decoder.by_ref() {
            board.strange = 0;
            board.status.packets += 1;
            board.speed_deg_s = packet.speed_deg_s;
            if let Some(sweep) = self.revolutions.take(&packet, now_s) {
                board.status.turns += 1;
                board.turned_s = now_s;
                board.status.sweep = Some(Arc::new(sweep));
            }
        }
        board.status.dropped_bytes = self.decoder.dropped_bytes();
    }

    fn lose(&mut self, reason: String) {
        self.line = None;
        self.back_off.failed(self.began.elapsed().as_secs_f64());
        lock(&self.board).unplugged = Some(reason);
    }

    fn open_again(&mut self) {
        thread::sleep(LOOK);
        let now_s = self.began.elapsed().as_secs_f64();
        if !self.back_off.is_due(now_s) {
            return;
        }
        match (self.open)() {
            Ok(line) => {
                self.line = Some(line);
                self.back_off.worked();
                self.decoder = Decoder::default();
                let mut board = lock(&self.board);
                board.unplugged = None;
                board.strange = 0;
                board.status.opened += 1;
            }
            Err(error) => self.lose(error.to_string()),
        }
    }
}

fn is_silence(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
    )
}

fn lock(board: &Mutex<Board>) -> MutexGuard<'_, Board> {
    board.lock().unwrap_or_else(PoisonError::into_inner)
}
