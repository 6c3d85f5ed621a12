//! A cell: everything that its result depends on, and its key.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::canonical::canonical;
use super::{World, WorldKind};
use crate::digest::BitDigest;
use crate::runtime::Config;

/// Number of the format of inputs and results. Raise it when the same inputs may give other results, or results are
/// written differently, while the crate's version stays.
pub const FORMAT: u32 = 2;

/// Hex digits of a key: 128 bits of SHA-256.
const KEY_DIGITS: usize = 32;

/// One combination of world, settings, engine and seed.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Its names.
    pub id: CellId,
    /// Digest of its inputs.
    pub key: String,
    /// Its world.
    pub world: World,
    /// Its settings.
    pub config: Config,
    pub(super) inputs: Value,
    pub(super) threads: usize,
    /// Whether its ticks are timed while other cells run; a latency cell runs alone.
    pub(super) timed: bool,
}

impl Cell {
    /// A cell with these names. `threads` is the number of threads of a CPU engine.
    pub(super) fn new(id: CellId, world: &World, config: Config, threads: usize) -> Self {
        let inputs = json!({
            "format": FORMAT,
            "version": env!("CARGO_PKG_VERSION"),
            "world": world.digest,
            "seed": id.seed,
            "engine": id.engine,
            "latency_threads": id.latency.then_some(threads),
            "settings": config,
        });
        Self {
            key: key(&inputs),
            id,
            world: world.clone(),
            config,
            inputs,
            threads: threads.max(1),
            timed: false,
        }
    }
}

/// The key of inputs.
pub(super) fn key(inputs: &Value) -> String {
    let mut digest = BitDigest::default();
    digest.text(&canonical(inputs));
    let mut hex = digest.hex();
    hex.truncate(KEY_DIGITS);
    hex
}

/// Where a cell is in the grid of its plan. Its key does not depend on these names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellId {
    /// Kind of the world.
    pub kind: WorldKind,
    /// Name or number of the world.
    pub world: String,
    /// Name of the changes to the settings; none where the plan has none.
    pub config: Option<String>,
    /// Name of the weights; none where the plan has none.
    pub weights: Option<String>,
    /// Forward speeds.
    pub vx_samples: u32,
    /// Turn rates.
    pub vtheta_samples: u32,
    /// The engine, as the plan names it.
    pub engine: String,
    /// The seed.
    pub seed: u64,
    /// Whether the cell measures latency and so has the machine to itself.
    pub latency: bool,
}
