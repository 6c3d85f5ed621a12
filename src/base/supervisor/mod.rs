//! Sends velocity commands to a base at a fixed rate, independent of the planner's timing.
//!
//! [`SafetyController`] decides what to send and takes time as a parameter. [`BaseSupervisor`] runs it on a thread that owns the
//! connection. They guarantee:
//!
//! - The base receives a command at a fixed rate. A target is valid for 0.3 s from its time stamp; after that the base is braked
//!   to a standstill. The age of the target decides, not the liveness of the planner's thread.
//! - A target that is not finite, older than the previous one or too far ahead is rejected and counted.
//! - A requested stop, and a stop by the fault detector, is latched: targets are rejected until an explicit
//!   [`BaseSupervisor::release`] while the base stands still.
//! - A failed connection is closed with three or more zero commands and reopened after a pause that doubles with each failure.
//!   On a new connection zero commands go first, until the base has reported.
//! - The supervisor ends with three or more zero commands: when it is dropped, hence also when the owner's thread panics; when
//!   its own thread panics; and when the shutdown flag is set, as a handler of Ctrl-C and SIGTERM does.
//!
//! A process that is killed (SIGKILL, loss of power) sends nothing more. The base's own watchdog must then act: after 0.5 s with
//! native frames and, as the session configures it, with a `RoboClaw`; after 2 s with a `ROSArduinoBridge`. WHEELTEC's published
//! firmware has no watchdog and keeps driving.

pub(super) mod backoff;
mod connection;
mod odometer;
mod safety;
mod settings;
mod thread;

pub use connection::OpenBase;
pub use safety::{CommandRejected, DriveStatus, OutgoingCommand, SafetyController};
pub use settings::SupervisorSettings;
pub use thread::{BaseSupervisor, SupervisorCounters, SupervisorStatus};
