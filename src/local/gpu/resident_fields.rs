//! The distance fields that the device holds, so that each is uploaded once.

use super::batch::field_words;
use crate::local::ClearanceField;

/// What lies where in the buffer of fields.
#[derive(Default)]
pub(super) struct ResidentFields {
    /// The number of each field held, and the word at which it begins.
    held: Vec<(u64, u32)>,
    used_words: u64,
}

impl ResidentFields {
    /// Makes room for these fields, which fit into `capacity` bytes, and hands those that are not held yet to `write`
    /// with their first word. Fields of earlier decisions stay where there is room for them beside the new ones.
    pub fn hold(
        &mut self,
        fields: &[&ClearanceField],
        capacity: u64,
        mut write: impl FnMut(u32, &ClearanceField),
    ) {
        let missing = fields.iter().filter(|field| self.find(field).is_none());
        let missing_words: u64 = missing.map(|field| field_words(field)).sum();
        if (self.used_words + missing_words) * 4 > capacity {
            self.held.clear();
            self.used_words = 0;
        }
        for field in fields {
            if self.find(field).is_none() {
                let at = self.used_words as u32;
                write(at, field);
                self.held.push((field.id(), at));
                self.used_words += field_words(field);
            }
        }
    }

    /// The first word of a field that is held.
    pub fn find(&self, field: &ClearanceField) -> Option<u32> {
        let held = self.held.iter().find(|(id, _)| *id == field.id());
        held.map(|(_, at)| *at)
    }
}
