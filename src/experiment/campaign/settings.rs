//! One short name for all settings of a campaign.

use serde::Serialize;

use crate::digest::BitDigest;

/// Letters of the digest: enough to tell the settings that anybody tries.
const LETTERS: usize = 12;

/// A digest of everything that runs depend on beside their keys: other settings, other digest.
#[must_use]
pub fn settings_digest(settings: &impl Serialize) -> String {
    // Settings are flat tables of numbers and words, which JSON has no trouble with.
    let text = serde_json::to_string(settings).unwrap_or_default();
    let mut digest = BitDigest::default();
    text.bytes().for_each(|byte| digest.word(u32::from(byte)));
    let mut hex = digest.hex();
    hex.truncate(LETTERS);
    hex
}
