//! The host's side: sends command frames, keeps the latest report.

use super::BAUD;
use super::Decoder;
use super::frames::{Command, Report};
use crate::base::encoder_speed::max_plausible_speed;
use crate::base::{BaseError, BaseSettings, Feedback, Session, SessionCounters, TimedFeedback};
use crate::geometry::Twist;

/// Host session of the WHEELTEC protocol.
///
/// The firmware mixes the tracks by the geometric width, so the session scales turn rates by the ratio of the effective width in
/// both directions. The protocol cannot latch a stop.
#[derive(Clone, Debug)]
pub struct WheeltecSession {
    settings: BaseSettings,
    /// The command to send.
    pending: Option<Command>,
    decoder: Decoder<Report>,
    latest: Option<TimedFeedback>,
    rejected: u64,
}

impl WheeltecSession {
    /// Creates a session.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn new(settings: BaseSettings) -> Result<Self, BaseError> {
        settings.validate()?;
        Ok(Self { settings, pending: None, decoder: Decoder::default(), latest: None, rejected: 0 })
    }

    /// Converts a report, or returns none if no track runs that fast: the check byte accepts one of 256 damaged frames.
    fn feedback(&self, report: Report) -> Option<Feedback> {
        let mut feedback = Feedback::from(report);
        feedback.twist.angular /= self.settings.effective_width_ratio;
        let tracks = self.settings.drive().tracks(&feedback.twist);
        let max = max_plausible_speed(&self.settings);
        (tracks.left.abs().max(tracks.right.abs()) <= max).then_some(feedback)
    }
}

impl Session for WheeltecSession {
    fn baud(&self) -> u32 {
        BAUD
    }

    fn command(&mut self, twist: &Twist) -> Result<(), BaseError> {
        let limited = self.settings.limit(twist)?;
        let angular = limited.angular * self.settings.effective_width_ratio;
        self.pending = Some(Command { twist: Twist::new(limited.linear, angular) });
        Ok(())
    }

    fn receive(&mut self, bytes: &[u8], now_s: f64) {
        self.decoder.push(bytes);
        while let Some(report) = self.decoder.next() {
            match self.feedback(report) {
                Some(feedback) => {
                    self.latest = Some(TimedFeedback { received_s: now_s, feedback });
                }
                None => self.rejected += 1,
            }
        }
    }

    fn transmit(&mut self, _now_s: f64, line: &mut Vec<u8>) {
        if let Some(command) = self.pending.take() {
            // `command` accepts finite motions only.
            line.extend(command.encode().into_iter().flatten());
        }
    }

    fn is_waiting(&self) -> bool {
        false
    }

    fn latest(&self) -> Option<&TimedFeedback> {
        self.latest.as_ref()
    }

    fn counters(&self) -> SessionCounters {
        SessionCounters {
            dropped_bytes: self.decoder.dropped_bytes(),
            rejected_readings: self.rejected,
            ..SessionCounters::default()
        }
    }

    fn engage_stop(&mut self) {
        self.pending = Some(Command { twist: Twist::STOP });
    }

    fn release(&mut self) {
        self.engage_stop();
    }
}
