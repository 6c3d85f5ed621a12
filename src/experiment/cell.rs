//! A cell: everything that its result depends on, and its key.

use core::str::FromStr;
use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use super::{ExperimentError, RunOutcome, RunRow, World};
use crate::digest::BitDigest;
use crate::external::{NO_ANSWER, ProgramSettings};
use crate::runtime::Config;

/// Number of the format of inputs and results. Raise it when the same inputs may give other results, or results are
/// written differently, while the crate's version stays.
pub const FORMAT: u32 = 7;

/// Hex digits of a key: 128 bits of SHA-256.
const KEY_DIGITS: usize = 32;
/// Largest number of shards.
const MAX_SHARDS: usize = 1_000_000;

/// One combination of world, settings, engine and seed.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Cell {
    /// Its row before the run: its names, and its key, the digest of its inputs. The key does not depend on the names.
    pub row: RunRow,
    /// Its world.
    pub world: World,
    /// Its settings.
    pub config: Config,
    pub(super) threads: usize,
    /// Whether its ticks are timed while other cells run; a latency cell runs alone.
    pub(super) timed: bool,
}

impl Cell {
    /// A cell with the names of this row. `threads` is the number of threads of a CPU engine.
    pub(super) fn new(names: RunRow, world: &World, config: Config, threads: usize) -> Self {
        let (world, threads) = (world.clone(), threads.max(1));
        let mut cell = Self { row: names, world, config, threads, timed: false };
        cell.row.key = key(&cell.inputs());
        cell
    }

    /// Whether programs of the user's own decide, plan or simulate.
    #[must_use]
    pub fn has_programs(&self) -> bool {
        programs(&self.config).iter().any(|program| program.is_set())
    }

    /// Whether a program did not start, or did not answer in time, in a run of this cell. That may depend on the machine and its load:
    /// such a result is not final.
    #[must_use]
    pub fn is_failed_by_machine(&self, row: &RunRow) -> bool {
        let is_sound = matches!(row.outcome, RunOutcome::Reached | RunOutcome::Contact);
        // After the program's name: a wrong answer is quoted, and comes again.
        let silence = format!(": {NO_ANSWER} ");
        let is_silent = || row.reason.as_ref().is_some_and(|reason| reason.contains(&silence));
        self.has_programs() && !is_sound && (row.ticks == 0 || is_silent())
    }

    /// Everything that its result depends on. Not kept: it takes 20 kB, and a plan may have 100,000 cells.
    pub(super) fn inputs(&self) -> Value {
        json!({
            "format": FORMAT,
            "version": env!("CARGO_PKG_VERSION"),
            "world": self.world.digest,
            // The ideal time is that of the world's own robot.
            "world_settings": self.world.settings.digest,
            "seed": self.row.seed,
            "engine": self.row.engine,
            "latency_threads": self.row.latency.then_some(self.threads),
            "settings": self.config,
            "program_files": program_files(&self.config),
        })
    }
}

const fn programs(config: &Config) -> [&ProgramSettings; 3] {
    [&config.controller, &config.global_planner, &config.simulator]
}

/// Digests of the files that the programs of a configuration consist of: a changed program is another input. A file that cannot
/// be read has the digest of an empty one; its program will not start.
fn program_files(config: &Config) -> Option<Vec<String>> {
    let digest = |file: &Path| {
        let mut digest = BitDigest::default();
        digest.bytes(&fs::read(file).unwrap_or_default());
        digest.hex()
    };
    let digests: Vec<String> =
        programs(config).iter().flat_map(|program| program.files().map(digest)).collect();
    (!digests.is_empty()).then_some(digests)
}

/// The key of inputs: a digest of their JSON with the fields of every object sorted by name.
pub(super) fn key(inputs: &Value) -> String {
    let mut inputs = inputs.clone();
    inputs.sort_all_objects();
    let mut digest = BitDigest::default();
    digest.text(&inputs.to_string());
    let mut hex = digest.hex();
    hex.truncate(KEY_DIGITS);
    hex
}

/// Whether a text has the form of a key: its hex digits, none in upper case.
pub(super) fn is_key(text: &str) -> bool {
    let is_digit = |byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f');
    text.len() == KEY_DIGITS && text.bytes().all(is_digit)
}

/// Part `index`, from 1, of `count` parts of the cells, for one machine of several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: usize,
    count: usize,
}

impl FromStr for Shard {
    type Err = ExperimentError;

    fn from_str(text: &str) -> Result<Self, ExperimentError> {
        let parts = text.split_once('/').and_then(|(index, count)| {
            let (index, count) = (index.parse().ok()?, count.parse().ok()?);
            Some(Self { index, count })
        });
        parts
            .filter(|shard| (1..=shard.count).contains(&shard.index) && shard.count <= MAX_SHARDS)
            .ok_or_else(|| ExperimentError::BadShard { text: text.escape_debug().to_string() })
    }
}

impl Shard {
    /// The cells of this part. Each cell is in one part. The numbers of latency cells differ by at most one between parts, and
    /// so do the numbers of other cells. The keys determine the part, not the plan's order: a part mixes easy and hard cells.
    #[must_use]
    pub fn of<'c>(&self, cells: &[&'c Cell]) -> Vec<&'c Cell> {
        let mut all = Vec::new();
        for latency in [false, true] {
            let kind = cells.iter().filter(|cell| cell.row.latency == latency);
            let mut kind: Vec<&Cell> = kind.copied().collect();
            kind.sort_by(|one, other| one.row.key.cmp(&other.row.key));
            all.extend(kind.into_iter().skip(self.index - 1).step_by(self.count));
        }
        all
    }
}
