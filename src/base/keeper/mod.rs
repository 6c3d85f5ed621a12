//! The sender apart from the planner: what goes to the base fifty times a second, whatever the planner does meanwhile.
//!
//! [`Guard`] decides, with time as a parameter; [`Keeper`] is a thread around it that owns the line. What they promise:
//!
//! - The base is told something at a fixed rate. A plan counts for 0.3 s from the time it was made for, and then the base is
//!   braked to a standstill: by the age of the plan, not by a sign of life of the planner's thread.
//! - What is not finite, older than what was planned before, or planned far ahead is refused and counted.
//! - A stop that was asked for, or that the judge of the base found reason for, is latched: plans are refused until an
//!   explicit [`Keeper::release`] while the base stands.
//! - A line that fails is given up with three or more commands of zero, and opened anew after a pause that doubles from one failure to
//!   the next. On a new line zeros go first, until the base has answered.
//! - Where the keeper ends, three or more commands of zero are sent: when it is dropped, so also when the thread that has it panics;
//!   when its own thread panics; and when its end is asked for by a flag, as a handler of Ctrl-C and SIGTERM does.
//!
//! A process that is killed (SIGKILL, a loss of power) sends nothing more, and then the base's own watchdog must act: after
//! 0.5 s with our own frames and, as the session sets it, with a `RoboClaw`; after 2 s with a `ROSArduinoBridge`. WHEELTEC's
//! published firmware has none and drives on.

pub(super) mod back_off;
mod guard;
mod link;
mod odometer;
mod settings;
mod thread;

pub use guard::{Condition, Guard, Order, Refusal, StopReason};
pub use link::Open;
pub use odometer::Odometer;
pub use settings::KeeperSettings;
pub use thread::{Keeper, KeeperCounters, Status};
