//! The identity of a cell within its plan.

use serde::{Deserialize, Serialize};

use super::WorldKind;

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
