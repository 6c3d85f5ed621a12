//! The distance fields that the device holds: each is uploaded once.

use super::batch::field_words;
use crate::local::ClearanceField;

/// Positions of the fields in their buffer.
#[derive(Default)]
pub(super) struct ResidentFields {
    /// Id and first word of each field.
    held: Vec<(u64, u32)>,
    used_words: u64,
}

impl ResidentFields {
    /// Makes the device hold these fields, which fit into `capacity` bytes: calls `write` with the first word of each
    /// field that it does not hold yet. Earlier fields stay if there is room for them.
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

    /// The first word of a field that the device holds.
    pub fn find(&self, field: &ClearanceField) -> Option<u32> {
        let held = self.held.iter().find(|(id, _)| *id == field.id());
        held.map(|(_, at)| *at)
    }
}
