//! The thread that owns the line. It reads a clock, as the serial port does, and nothing else in this room.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use serde::Serialize;

use super::link::{Link, Open, Outcome};
use super::{Condition, Guard, KeeperSettings, Odometer, Refusal, StopReason};
use crate::base::{BaseError, BaseSettings, Feedback};
use crate::geometry::{Pose, Twist};

/// What happened so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct KeeperCounters {
    /// Commands handed to the line.
    pub commands: u64,
    /// Plans refused because they made no sense.
    pub refused_plans: u64,
    /// Commands that were late by more than a period.
    pub late: u64,
    /// Failures of the line, attempts to open it counted.
    pub line_failures: u64,
    /// Times the line was opened, the first counted.
    pub opened: u64,
}

/// A base and its keeper at a moment.
#[derive(Clone, Debug)]
pub struct Status {
    /// What the base is told, and why.
    pub condition: Condition,
    /// Why a stop is latched, if one is.
    pub stopped: Option<StopReason>,
    /// What it was last told.
    pub sent: Twist,
    /// Its newest report since the line was opened.
    pub feedback: Option<Feedback>,
    /// Where it is by its reports, of where it stood at the first.
    pub pose: Pose,
    /// Its way by its reports, metres.
    pub travelled_m: f64,
    /// What happened so far.
    pub counters: KeeperCounters,
    /// What the line failed of last, if it ever did.
    pub last_failure: Option<BaseError>,
    /// Whether commands are still sent: not after the end was asked for.
    pub is_running: bool,
}

/// A thread that tells a base at a fixed rate what was last planned, as long as that counts: see the promises of [its module](super).
///
/// Dropping it stops the base with three or more commands of zero and waits for that: some 0.2 s at worst.
pub struct Keeper {
    began: Instant,
    board: Arc<Mutex<Board>>,
    end: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// What the thread shares with its owner. Never locked while the line is used.
struct Board {
    guard: Guard,
    odometer: Odometer,
    feedback: Option<Feedback>,
    counters: KeeperCounters,
    last_failure: Option<BaseError>,
    is_running: bool,
}

impl Keeper {
    /// Opens the line and keeps the base on it from now on, until dropped or until the flag is set: a handler of signals may do
    /// that.
    ///
    /// # Errors
    /// Those of the settings' own checks, and of the line's first opening.
    pub fn start(
        open: Open,
        base: &BaseSettings,
        settings: KeeperSettings,
        end: Arc<AtomicBool>,
    ) -> Result<Self, BaseError> {
        let board = Arc::new(Mutex::new(Board {
            guard: Guard::new(base, settings)?,
            odometer: Odometer::new(base),
            feedback: None,
            counters: KeeperCounters {
                opened: 1,
                ..KeeperCounters::default()
            },
            last_failure: None,
            is_running: true,
        }));
        let link = Link::new(open, &settings)?;
        let began = Instant::now();
        let rounds = Rounds {
            began,
            period: Duration::from_secs_f64(settings.period_s()),
            link,
            board: Arc::clone(&board),
            end: Arc::clone(&end),
        };
        let thread = thread::Builder::new()
            .name("keeper".to_owned())
            .spawn(move || rounds.run())
            .map_err(|error| BaseError::CannotOpen {
                port: "thread of the sender".to_owned(),
                reason: error.to_string(),
            })?;
        Ok(Self {
            began,
            board,
            end,
            thread: Some(thread),
        })
    }

    /// The keeper's time, seconds: what plans are made for.
    #[must_use]
    pub fn now_s(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    /// Takes a motion planned for a time by [`Self::now_s`]. Never blocks.
    ///
    /// # Errors
    /// As [`Guard::want`].
    pub fn want(&self, twist: &Twist, for_s: f64) -> Result<(), Refusal> {
        lock(&self.board).guard.want(twist, for_s, self.now_s())
    }

    /// Latches a stop, which goes out with the next command.
    pub fn stop(&self) {
        lock(&self.board).guard.stop(StopReason::Asked);
    }

    /// Ends a stop.
    ///
    /// # Errors
    /// As [`Guard::release`].
    pub fn release(&self) -> Result<(), Refusal> {
        lock(&self.board).guard.release()
    }

    /// How things are.
    #[must_use]
    pub fn status(&self) -> Status {
        let board = lock(&self.board);
        let guard = &board.guard;
        Status {
            condition: guard.condition().clone(),
            stopped: guard.stopped().copied(),
            sent: *guard.sent(),
            feedback: board.feedback,
            pose: board.odometer.pose(),
            travelled_m: board.odometer.travelled_m(),
            counters: KeeperCounters {
                refused_plans: guard.refused(),
                ..board.counters
            },
            last_failure: board.last_failure.clone(),
            is_running: board.is_running,
        }
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        self.end.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // If it panicked its line was left with zeros all the same.
            let _ = thread.join();
        }
    }
}

/// What the thread has. Dropped at its end, however that comes, and the link with it.
struct Rounds {
    began: Instant,
    period: Duration,
    link: Link,
    board: Arc<Mutex<Board>>,
    end: Arc<AtomicBool>,
}

impl Rounds {
    fn run(mut self) {
        let mut due = Instant::now();
        while !self.end.load(Ordering::Relaxed) {
            self.round();
            due += self.period;
            let now = Instant::now();
            if due + self.period < now {
                // What was missed is not made up for by a burst.
                lock(&self.board).counters.late += 1;
                due = now;
            }
            thread::sleep(due.saturating_duration_since(now));
        }
    }

    fn round(&mut self) {
        let now_s = self.began.elapsed().as_secs_f64();
        let order = lock(&self.board).guard.order(now_s);
        let outcome = self.link.exchange(order, now_s);
        let now_s = self.began.elapsed().as_secs_f64();
        lock(&self.board).take(outcome, now_s);
    }
}

impl Drop for Rounds {
    fn drop(&mut self) {
        lock(&self.board).is_running = false;
    }
}

impl Board {
    fn take(&mut self, outcome: Outcome, now_s: f64) {
        match outcome {
            Outcome::Up(feedback) => {
                self.counters.commands += 1;
                if let Some(feedback) = feedback {
                    self.feedback = Some(feedback);
                    self.odometer.take(&feedback, now_s);
                    self.guard.heard(&feedback, now_s);
                }
            }
            Outcome::Pausing => {}
            Outcome::Opened => {
                self.counters.opened += 1;
                self.guard.line_opened();
            }
            Outcome::Lost(why) => {
                self.counters.line_failures += 1;
                self.feedback = None;
                self.odometer.interrupt();
                self.last_failure = Some(why.clone());
                self.guard.line_lost(why);
            }
        }
    }
}

/// The board; a panic of another thread leaves nothing half done in it that matters to a stop.
fn lock(board: &Mutex<Board>) -> MutexGuard<'_, Board> {
    board.lock().unwrap_or_else(PoisonError::into_inner)
}
