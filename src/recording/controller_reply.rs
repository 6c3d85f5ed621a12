//! The answers of a controller in a recording, and the controller that repeats them in a replay.

use std::sync::{Arc, Mutex, PoisonError};

use crate::geometry::Twist;
use crate::global::Path;
use crate::navigator::{Controller, ControllerError, ControllerInput, ControllerReply};

/// Names of the kinds of answers in the order of their numbers in the message.
pub(super) const KINDS: [&str; 6] =
    ["NOT_ASKED", "VELOCITY", "NO_VALID_CONTROL", "LATE", "CONTROLLER_FAILED", "TIMED_OUT"];

/// An answer as fields of the message: its kind, two numbers and a text.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct ReplyFields {
    pub kind: u8,
    /// The velocity; for an answer that never came, the time waited and zero.
    pub numbers: [f64; 2],
    pub reason: String,
}

/// The number of no kind of answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct UnknownKind;

impl ReplyFields {
    pub fn of(reply: Option<&ControllerReply>) -> Self {
        let fields =
            |kind, numbers, reason: &str| Self { kind, numbers, reason: reason.to_owned() };
        match reply {
            None => Self::default(),
            Some(Ok(velocity)) => fields(1, [velocity.linear, velocity.angular], ""),
            Some(Err(ControllerError::NoValidControl { reason })) => fields(2, [0.0; 2], reason),
            Some(Err(ControllerError::Late)) => fields(3, [0.0; 2], ""),
            Some(Err(ControllerError::Failed { reason })) => fields(4, [0.0; 2], reason),
            Some(Err(ControllerError::TimedOut { after_s })) => fields(5, [*after_s, 0.0], ""),
        }
    }

    /// The answer; none where the controller was not asked.
    ///
    /// # Errors
    /// [`UnknownKind`].
    pub fn reply(self) -> Result<Option<ControllerReply>, UnknownKind> {
        let Self { kind, numbers: [first, second], reason } = self;
        Ok(match kind {
            0 => None,
            1 => Some(Ok(Twist::new(first, second))),
            2 => Some(Err(ControllerError::NoValidControl { reason })),
            3 => Some(Err(ControllerError::Late)),
            4 => Some(Err(ControllerError::Failed { reason })),
            5 => Some(Err(ControllerError::TimedOut { after_s: first })),
            _ => return Err(UnknownKind),
        })
    }
}

/// The recorded answer to the next tick.
pub(super) type NextReply = Arc<Mutex<Option<ControllerReply>>>;

/// Repeats recorded answers. It fails at a tick at which the recorded controller was not asked.
pub(super) struct RecordedController {
    name: String,
    next: NextReply,
}

impl RecordedController {
    /// A controller of this name, and where it takes its answers from.
    pub fn new(name: String) -> (Self, NextReply) {
        let next = NextReply::default();
        (Self { name, next: Arc::clone(&next) }, next)
    }
}

impl Controller for RecordedController {
    fn name(&self) -> &str {
        &self.name
    }

    fn set_plan(&mut self, _: &Path) {}

    fn compute_velocity(&mut self, _: &ControllerInput<'_>) -> ControllerReply {
        let next = self.next.lock().unwrap_or_else(PoisonError::into_inner).take();
        let reason = || "the recorded controller was not asked at this tick".to_owned();
        next.unwrap_or_else(|| Err(ControllerError::Failed { reason: reason() }))
    }

    fn reset(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_give_every_answer_back() {
        let reason = || "why".to_owned();
        let answers = [
            None,
            Some(Ok(Twist::new(0.25, -1.5))),
            Some(Err(ControllerError::NoValidControl { reason: reason() })),
            Some(Err(ControllerError::Late)),
            Some(Err(ControllerError::Failed { reason: reason() })),
            Some(Err(ControllerError::TimedOut { after_s: 2.5 })),
        ];
        assert_eq!(answers.len(), KINDS.len());
        for (kind, answer) in answers.into_iter().enumerate() {
            let fields = ReplyFields::of(answer.as_ref());
            assert_eq!((usize::from(fields.kind), fields.reply()), (kind, Ok(answer)));
        }
        assert_eq!(ReplyFields { kind: 6, ..ReplyFields::default() }.reply(), Err(UnknownKind));
    }
}
