//! The network process: DDS on one side, the pipes of the control process on the other.

use std::collections::VecDeque;
use std::io::{BufReader, BufWriter, Read, Write};
use std::mem::discriminant;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use super::frame::{FromNetwork, ToNetwork, read_frame, write_frame};
use super::watchdog::CommandWatchdog;
use crate::ros::msg::{Time, Twist, TwistStamped};
use crate::ros::node::dds::{DdsNode, DdsSettings, NodeError};

/// Interval at which messages are taken on both sides.
const POLL_INTERVAL: Duration = Duration::from_millis(4);
/// Interval of the signs of life, seconds.
const ALIVE_INTERVAL_S: f64 = 0.1;
/// Frames that wait for the control process. With more, messages stay in the bounded queues of DDS.
const OUTBOX: usize = 64;
/// Zeros at the end, with a pause after each: DDS sends them in the background.
const STOP_REPEATS: u32 = 5;
const STOP_INTERVAL: Duration = Duration::from_millis(50);

/// The frames of the control process that are not yet published. An older command is never published after a newer one arrived.
#[derive(Default)]
struct Inbox {
    command: Option<TwistStamped>,
    /// Other frames in the order of their arrival: the newest of each kind, but all of those that answer requests.
    others: Vec<ToNetwork>,
    has_frame: bool,
    is_closed: bool,
}

/// Joins a DDS domain and passes messages until the control process closes its pipe or ends, or the flag is set. Then it
/// publishes zeros, if it has published a command.
///
/// While the control process is silent after a motion command, it publishes zeros. `clock` is monotonic, in seconds; `stamp`
/// is the time by the wall clock.
///
/// # Errors
/// When DDS cannot start. The control process gets the reason.
pub fn run_bridge(
    settings: &DdsSettings,
    input: impl Read + Send + 'static,
    mut output: impl Write + Send + 'static,
    stop: &AtomicBool,
    clock: &mut dyn FnMut() -> f64,
    stamp: &dyn Fn() -> Time,
) -> Result<(), NodeError> {
    let mut dds = match DdsNode::open(settings) {
        Ok(dds) => dds,
        Err(error) => {
            // Without a reader the reason is not needed.
            let _ = write_frame(&mut output, &FromNetwork::Failed(error.to_string()));
            return Err(error);
        }
    };
    let inbox = Arc::new(Mutex::new(Inbox::default()));
    let for_reader = Arc::clone(&inbox);
    thread::spawn(move || read_all(input, &for_reader));
    let (outbox, to_write) = sync_channel(OUTBOX);
    thread::spawn(move || write_all(output, &to_write));
    let mut watchdog = CommandWatchdog::default();
    let mut last_command: Option<TwistStamped> = None;
    let mut pending = VecDeque::new();
    let mut alive_s = f64::NEG_INFINITY;
    while !stop.load(Ordering::Relaxed) {
        let now_s = clock();
        let Inbox { command, others, has_frame, is_closed } = take(&inbox);
        if has_frame {
            watchdog.on_frame(now_s);
        }
        if let Some(command) = command {
            watchdog.on_command(command.twist == Twist::default());
            last_command = Some(command.clone());
            dds.publish(ToNetwork::Command(command));
        }
        others.into_iter().for_each(|message| dds.publish(message));
        if is_closed {
            break;
        }
        if watchdog.wants_zero(now_s) {
            publish_zero(&mut dds, last_command.as_ref(), stamp());
        }
        if pending.is_empty() {
            pending.extend(dds.receive().into_iter().map(FromNetwork::Message));
        }
        if now_s - alive_s >= ALIVE_INTERVAL_S {
            alive_s = now_s;
            pending.push_front(FromNetwork::Alive { unsent: dds.unsent() });
        }
        if !pass_on(&mut pending, &outbox) {
            break;
        }
        thread::sleep(POLL_INTERVAL);
    }
    if last_command.is_some() {
        for _ in 0..STOP_REPEATS {
            publish_zero(&mut dds, last_command.as_ref(), stamp());
            thread::sleep(STOP_INTERVAL);
        }
    }
    Ok(())
}

fn lock(inbox: &Mutex<Inbox>) -> MutexGuard<'_, Inbox> {
    inbox.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Takes the newest frames. Whether the pipe is closed remains.
fn take(inbox: &Mutex<Inbox>) -> Inbox {
    let mut inbox = lock(inbox);
    let is_closed = inbox.is_closed;
    std::mem::replace(&mut *inbox, Inbox { is_closed, ..Inbox::default() })
}

/// Publishes zero velocity in the frame of the last command.
fn publish_zero(dds: &mut DdsNode, last: Option<&TwistStamped>, stamp: Time) {
    let mut zero = TwistStamped::default();
    zero.header.stamp = stamp;
    if let Some(last) = last {
        zero.header.frame_id.clone_from(&last.header.frame_id);
    }
    dds.publish(ToNetwork::Command(zero));
}

/// Passes frames to the writer while it takes them. Returns false if the pipe is closed.
fn pass_on(pending: &mut VecDeque<FromNetwork>, outbox: &SyncSender<FromNetwork>) -> bool {
    while let Some(frame) = pending.pop_front() {
        match outbox.try_send(frame) {
            Ok(()) => {}
            Err(TrySendError::Full(FromNetwork::Alive { .. })) => return true,
            Err(TrySendError::Full(frame)) => {
                pending.push_front(frame);
                return true;
            }
            Err(TrySendError::Disconnected(_)) => return false,
        }
    }
    true
}

fn read_all(input: impl Read, inbox: &Mutex<Inbox>) {
    let mut reader = BufReader::new(input);
    while let Ok((frame, _)) = read_frame(&mut reader) {
        let mut inbox = lock(inbox);
        inbox.has_frame = true;
        match frame {
            ToNetwork::Alive => {}
            ToNetwork::Command(command) => inbox.command = Some(command),
            ToNetwork::Action(_) | ToNetwork::State(_) => inbox.others.push(frame),
            _ => {
                let kind = discriminant(&frame);
                inbox.others.retain(|older| discriminant(older) != kind);
                inbox.others.push(frame);
            }
        }
    }
    lock(inbox).is_closed = true;
}

fn write_all(output: impl Write, frames: &Receiver<FromNetwork>) {
    let mut writer = BufWriter::new(output);
    for frame in frames {
        if write_frame(&mut writer, &frame).is_err() {
            return;
        }
    }
}
