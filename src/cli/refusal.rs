//! Errors of the system in the form of this program: place, cause, and then the remedy.

use std::fmt::Display;

use anyhow::{Error, anyhow};

/// The error for a file or a port that the system refuses. The system's reason stands before the remedy, which ends the message.
pub fn refused(what: impl Display, reason: impl Display, remedy: &str) -> Error {
    anyhow!("{what} ({reason}): {remedy}")
}
