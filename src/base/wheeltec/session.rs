//! The host's side: a frame for each motion, and the newest report.

use super::BAUD;
use super::frames::{Command, Decoder, Report};
use crate::base::tick_meter::highest_m_s;
use crate::base::{BaseError, BaseSettings, Counters, Feedback, Heard, Session};
use crate::geometry::Twist;

/// A base that speaks WHEELTEC's frames.
///
/// Its firmware mixes the tracks by the geometric width, so that turn rates are scaled by the effective width's ratio on
/// their way there and back. A stop cannot be latched in it.
#[derive(Clone, Debug)]
pub struct WheeltecSession {
    settings: BaseSettings,
    /// What did not go out yet.
    due: Option<Command>,
    decoder: Decoder<Report>,
    newest: Option<Heard>,
    refused: u64,
}

impl WheeltecSession {
    /// A session that has sent nothing.
    ///
    /// # Errors
    /// Those of [`BaseSettings::validate`].
    pub fn new(settings: BaseSettings) -> Result<Self, BaseError> {
        settings.validate()?;
        Ok(Self {
            settings,
            due: None,
            decoder: Decoder::default(),
            newest: None,
            refused: 0,
        })
    }

    /// What a report says, or none where no track runs so fast: its check lets one of 256 damaged frames through.
    fn feedback(&self, report: Report) -> Option<Feedback> {
        let mut feedback = Feedback::from(report);
        feedback.twist.angular /= self.settings.effective_width_ratio;
        let tracks = self.settings.drive().tracks(&feedback.twist);
        let most = highest_m_s(&self.settings);
        (tracks.left.abs().max(tracks.right.abs()) <= most).then_some(feedback)
    }
}

impl Session for WheeltecSession {
    fn baud(&self) -> u32 {
        BAUD
    }

    fn command(&mut self, wanted: &Twist) -> Result<(), BaseError> {
        let possible = self.settings.possible(wanted)?;
        let angular = possible.angular * self.settings.effective_width_ratio;
        self.due = Some(Command {
            twist: Twist::new(possible.linear, angular),
        });
        Ok(())
    }

    fn receive(&mut self, bytes: &[u8], now_s: f64) {
        self.decoder.push(bytes);
        while let Some(report) = self.decoder.next() {
            match self.feedback(report) {
                Some(feedback) => {
                    self.newest = Some(Heard {
                        at_s: now_s,
                        feedback,
                    });
                }
                None => self.refused += 1,
            }
        }
    }

    fn transmit(&mut self, _now_s: f64, line: &mut Vec<u8>) {
        if let Some(command) = self.due.take() {
            // Only finite commands are taken in.
            line.extend(command.encode().into_iter().flatten());
        }
    }

    fn is_waiting(&self) -> bool {
        false
    }

    fn newest(&self) -> Option<&Heard> {
        self.newest.as_ref()
    }

    fn counters(&self) -> Counters {
        Counters {
            dropped_bytes: self.decoder.dropped_bytes(),
            refused_readings: self.refused,
            ..Counters::default()
        }
    }

    fn engage_stop(&mut self) {
        self.due = Some(Command { twist: Twist::STOP });
    }

    fn release(&mut self) {
        self.due = Some(Command { twist: Twist::STOP });
    }
}
