//! What people are told: each thing once, when it begins.

use std::collections::HashSet;
use std::mem::{Discriminant, discriminant, take};

use super::{MessageError, Missing, Topic};
use crate::navigator::{Mode, Navigator};

/// Notes for people, and what they have been told before.
#[derive(Debug, Default)]
pub struct Told {
    notes: Vec<String>,
    refusals: HashSet<(Topic, Discriminant<MessageError>)>,
    missing: Option<Missing>,
    mount: bool,
    had_sensor_fault: bool,
}

impl Told {
    pub fn note(&mut self, note: impl Into<String>) {
        self.notes.push(note.into());
    }

    /// What is new since the last time.
    pub fn take(&mut self) -> Vec<String> {
        take(&mut self.notes)
    }

    /// A message is refused: told once for each topic and reason.
    pub fn refused(&mut self, topic: Topic, error: &MessageError) {
        if self.refusals.insert((topic, discriminant(error))) {
            self.note(format!(
                "a message on {} is not used: {error}",
                topic.name()
            ));
        }
    }

    /// The robot stands for want of something, or of nothing.
    pub fn missing(&mut self, missing: Option<Missing>) {
        if let Some(new) = missing.as_ref().filter(|_| self.missing != missing) {
            self.note(format!("stands: {new}"));
            // That its clock has jumped when this is over is no news.
            self.had_sensor_fault = true;
        }
        self.missing = missing;
    }

    /// Nobody says where the lidar is.
    pub fn no_mount(&mut self, base_frame: &str) {
        if !self.mount {
            self.mount = true;
            self.note(format!(
                "nothing on tf says where the lidar is on the robot: its scans are taken as from the origin of `{base_frame}`"
            ));
        }
    }

    /// A new navigator has had no sensor fault yet.
    pub fn set_out(&mut self) {
        self.had_sensor_fault = false;
    }

    /// Why the robot brakes, at the first tick of each time.
    pub fn sensor_fault(&mut self, mode: Mode, navigator: &Navigator) {
        let has_sensor_fault = mode == Mode::SensorFault;
        if let Some(fault) = navigator
            .observation_fault()
            .filter(|_| has_sensor_fault && !self.had_sensor_fault)
        {
            self.note(format!("brakes: {fault}"));
        }
        self.had_sensor_fault = has_sensor_fault;
    }
}
