//! The line of a keeper: opened, used, given up with zeros, opened anew.

use super::KeeperSettings;
use super::back_off::BackOff;
use super::guard::Order;
use crate::base::{Base, BaseError, Feedback};
use crate::geometry::Twist;

/// Commands of zero with which a line is left: three, and two for those that wait for an answer which does not come, and
/// are then replaced by the next.
const FAREWELLS: usize = 5;

/// Opens a line with a conversation that begins anew.
pub type Open = Box<dyn FnMut() -> Result<Box<dyn Base + Send>, BaseError> + Send>;

pub(super) struct Link {
    open: Open,
    base: Option<Box<dyn Base + Send>>,
    back_off: BackOff,
}

/// What came of an exchange.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Outcome {
    /// The order was sent. The report is none while there is none since the line was opened.
    Up(Option<Feedback>),
    /// There is no line, and it is not yet time to open one.
    Pausing,
    /// The line was just lost, or could not be opened.
    Lost(BaseError),
    /// A line was opened; nothing was sent on it yet.
    Opened,
}

impl Link {
    /// A line that is opened now.
    pub(super) fn new(mut open: Open, settings: &KeeperSettings) -> Result<Self, BaseError> {
        let base = Some(open()?);
        Ok(Self {
            open,
            base,
            back_off: BackOff::new(settings.first_pause_s, settings.longest_pause_s),
        })
    }

    /// Sends an order and asks for the newest report; or opens the line, if there is none and it is time.
    pub(super) fn exchange(&mut self, order: Order, now_s: f64) -> Outcome {
        let Some(base) = &mut self.base else {
            return self.reopen(now_s);
        };
        let sent = match order {
            Order::Run(twist) => base.send(&twist),
            Order::Stop => base.engage_stop(),
            Order::Release => base.release(),
        };
        match sent.and_then(|()| base.feedback()) {
            Ok(feedback) => {
                self.back_off.worked();
                Outcome::Up(Some(feedback))
            }
            Err(BaseError::NoFeedbackYet { .. }) => Outcome::Up(None),
            Err(error) => {
                self.leave();
                self.back_off.failed(now_s);
                Outcome::Lost(error)
            }
        }
    }

    fn reopen(&mut self, now_s: f64) -> Outcome {
        if !self.back_off.is_due(now_s) {
            return Outcome::Pausing;
        }
        match (self.open)() {
            Ok(base) => {
                self.base = Some(base);
                Outcome::Opened
            }
            Err(error) => {
                self.back_off.failed(now_s);
                Outcome::Lost(error)
            }
        }
    }

    /// Leaves the line with zeros, as far as it takes them: a base that no longer answers may still hear.
    fn leave(&mut self) {
        if let Some(mut base) = self.base.take() {
            for _ in 0..FAREWELLS {
                let _ = base.send(&Twist::STOP);
                // Where answers are waited for, the next command goes only after the last one's.
                let _ = base.feedback();
            }
        }
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        self.leave();
    }
}
