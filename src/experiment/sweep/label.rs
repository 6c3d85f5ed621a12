//! What a cell is called.

use serde::{Deserialize, Serialize};

use super::WorldKind;

/// Where a cell stands in the grid, in the plan's words. Its key does not depend on them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Label {
    /// Kind of the world.
    pub kind: WorldKind,
    /// Name or number of the world.
    pub world: String,
    /// Name of the changes to the settings; none where the plan has none.
    pub config: Option<String>,
    /// Name of the weights, likewise.
    pub weights: Option<String>,
    /// Forward speeds.
    pub vx_samples: u32,
    /// Turn rates.
    pub vtheta_samples: u32,
    /// The engine, as the plan names it.
    pub engine: String,
    /// The seed.
    pub seed: u64,
    /// Whether latency is measured: such a cell has the machine to itself.
    pub latency: bool,
}
