//! A cell: all that its result depends on, and its key.

use std::sync::Arc;

use serde_json::{Value, json};

use super::Label;
use super::canonical::canonical;
use super::ground::Ground;
use crate::digest::BitDigest;
use crate::runtime::Config;

/// Number of the form of inputs and results. It is raised whenever the same inputs may give other results, or results are
/// written otherwise, while the crate's version stays.
pub const FORMAT: u32 = 1;

/// Letters of a key: 128 bits of SHA-256, more than any two cells will ever share.
const LETTERS: usize = 32;

/// One combination of everything.
#[derive(Clone, Debug)]
pub struct Cell {
    /// What it is called.
    pub label: Label,
    /// Digest of its inputs.
    pub key: String,
    pub(super) inputs: Value,
    pub(super) ground: Arc<Ground>,
    pub(super) config: Config,
    pub(super) threads: usize,
}

impl Cell {
    /// A cell in a world of this digest. `threads` are those of a CPU engine.
    pub(super) fn new(
        label: Label,
        ground: &Arc<Ground>,
        digest: &str,
        config: Config,
        threads: usize,
    ) -> Self {
        let inputs = json!({
            "format": FORMAT,
            "version": env!("CARGO_PKG_VERSION"),
            "world": digest,
            "seed": label.seed,
            "engine": label.engine,
            "latency_threads": label.latency.then_some(threads),
            "settings": config,
        });
        Self {
            key: key(&inputs),
            label,
            inputs,
            ground: Arc::clone(ground),
            config,
            threads: threads.max(1),
        }
    }
}

/// The key of inputs.
pub(super) fn key(inputs: &Value) -> String {
    let mut digest = BitDigest::default();
    digest.text(&canonical(inputs));
    let mut hex = digest.hex();
    hex.truncate(LETTERS);
    hex
}
