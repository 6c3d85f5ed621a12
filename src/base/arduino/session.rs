//! The host's side: one line, one answer.

use super::lines::{Answer, LONGEST, read_answer};
use crate::base::exchange::{Exchange, Patience, Turn};
use crate::base::tick_meter::TickMeter;
use crate::base::{BaseError, BaseSettings, Counters, Feedback, Heard, Session};
use crate::geometry::Twist;
use crate::robot::TrackSpeeds;

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Question {
    /// `m`: run.
    Run,
    /// `e`: read the encoders.
    Read,
}

/// A base driven by a `ROSArduinoBridge`. It reports encoders and nothing else.
#[derive(Clone, Debug)]
pub struct ArduinoSession {
    settings: BaseSettings,
    wanted: TrackSpeeds,
    is_due: bool,
    exchange: Exchange<Question>,
    /// Whether the firmware may hold the beginning of a line: before anything is known, and after each lost answer.
    is_unsure: bool,
    /// What came since the last line feed, and whether it is too long to be of use.
    line: Vec<u8>,
    next_read_s: f64,
    meter: TickMeter,
    newest: Option<Heard>,
    counters: Counters,
}

impl ArduinoSession {
    /// A session that has sent nothing.
    ///
    /// # Errors
    /// Those of [`BaseSettings::validate`].
    pub fn new(settings: BaseSettings) -> Result<Self, BaseError> {
        settings.validate()?;
        let patience = Patience {
            answer_within_s: settings.arduino.answer_within_s,
            tries: settings.arduino.tries,
        };
        Ok(Self {
            settings,
            wanted: TrackSpeeds::default(),
            is_due: false,
            exchange: Exchange::new(patience),
            is_unsure: true,
            line: Vec::new(),
            next_read_s: f64::NEG_INFINITY,
            meter: TickMeter::new(&settings),
            newest: None,
            counters: Counters::default(),
        })
    }

    fn ask(&mut self, question: Question, line: &mut Vec<u8>) {
        if self.is_unsure {
            line.push(b'\r');
            self.is_unsure = false;
        }
        match question {
            Question::Run => {
                self.is_due = false;
                let interval_s = self.settings.arduino.pid_interval_s;
                let rates = self.settings.channel_rates(&self.wanted);
                // The firmware's integers have 16 bits on the smaller boards.
                let [first, second] = rates.map(|rate| (rate * interval_s).round() as i16);
                line.extend(format!("m {first} {second}\r").into_bytes());
            }
            Question::Read => line.extend(*b"e\r"),
        }
    }

    fn take_line(&mut self, now_s: f64) {
        let line = std::mem::take(&mut self.line);
        let content = line.strip_suffix(b"\r\n");
        match (self.exchange.question(), content.and_then(read_answer)) {
            (Some(Question::Run), Some(Answer::Done)) => self.exchange.settle(),
            (Some(Question::Read), Some(Answer::Counts(counts))) => {
                self.exchange.settle();
                self.take_counts(counts, now_s);
            }
            // The answer to the carriage return that went first is of this kind too.
            _ => self.counters.dropped_bytes += line.len() as u64,
        }
    }

    fn take_counts(&mut self, counts: [u32; 2], now_s: f64) {
        let ticks = self.settings.track_ticks(counts);
        let Some(speeds) = self.meter.read(ticks, now_s) else {
            return;
        };
        let feedback = Feedback {
            twist: self.settings.drive().twist(&speeds),
            ticks: Some(ticks),
            faults: self.meter.faults(),
            ..Feedback::default()
        };
        self.newest = Some(Heard {
            at_s: now_s,
            feedback,
        });
    }
}

impl Session for ArduinoSession {
    fn baud(&self) -> u32 {
        self.settings.arduino.baud
    }

    fn command(&mut self, wanted: &Twist) -> Result<(), BaseError> {
        let possible = self.settings.possible(wanted)?;
        self.wanted = self.settings.drive().tracks(&possible);
        self.is_due = true;
        Ok(())
    }

    fn receive(&mut self, bytes: &[u8], now_s: f64) {
        for byte in bytes {
            if self.line.len() < LONGEST {
                self.line.push(*byte);
            } else {
                self.counters.dropped_bytes += 1;
            }
            if *byte == b'\n' {
                self.take_line(now_s);
            }
        }
    }

    fn transmit(&mut self, now_s: f64, line: &mut Vec<u8>) {
        let turn = self.exchange.turn(now_s);
        self.is_unsure |= matches!(turn, Turn::Again(_) | Turn::GivenUp(_));
        match turn {
            Turn::Wait => return,
            // A command does not wait for the second try of a question.
            Turn::Again(Question::Read) if self.is_due => {
                self.exchange.settle();
                self.counters.unanswered += 1;
            }
            Turn::Again(question) => {
                self.counters.repeated += 1;
                self.ask(question, line);
                return;
            }
            Turn::GivenUp(_) => self.counters.unanswered += 1,
            Turn::Free => {}
        }
        let question = if self.is_due {
            Question::Run
        } else if now_s >= self.next_read_s {
            self.next_read_s = now_s + self.settings.arduino.poll_every_s;
            Question::Read
        } else {
            return;
        };
        self.exchange.ask(question, now_s);
        self.ask(question, line);
    }

    fn is_waiting(&self) -> bool {
        self.exchange.question().is_some()
    }

    fn newest(&self) -> Option<&Heard> {
        self.newest.as_ref()
    }

    fn counters(&self) -> Counters {
        Counters {
            refused_readings: self.meter.refused(),
            ..self.counters
        }
    }

    fn engage_stop(&mut self) {
        self.wanted = TrackSpeeds::default();
        self.is_due = true;
    }

    fn release(&mut self) {
        self.engage_stop();
        self.meter.release();
    }
}
