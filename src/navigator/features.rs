//! Parts of the navigator that may be left out.

use crate::documented::documented;
use serde::{Deserialize, Serialize};

documented! {
    /// What the navigator does beyond the dynamic window itself. All is on by default; each part can be switched off to see what
    /// it buys.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    pub struct NavigatorFeatures {
        /// A global path leads the way. Off: the goal itself is the local target.
        pub global_path: bool,
        /// Key nodes, half a metre apart, are passed by progress along the path. Off: the pruned path's nodes alone are the local
        /// targets, and each must be touched before the next one is, as the paper has it (section 3.3.3, step 4).
        pub progress: bool,
        /// Moving obstacles are tracked, and met where they will be. Off: they are marks like all else that the lidar sees.
        pub tracking: bool,
        /// Paths are planned anew. Off: the first one is followed to the end.
        pub replanning: bool,
        /// It moves such that it stands before anybody whom it comes nearer to reaches it, and counts on nobody to go on as he
        /// does. Off for a race among things that mind nobody, where standing is no help.
        pub passive_safety: bool,
        /// The robot turns in place where it faces away from its way, and backs out of where nothing goes on.
        pub recovery: bool,
    }
}

impl Default for NavigatorFeatures {
    fn default() -> Self {
        Self {
            global_path: true,
            progress: true,
            tracking: true,
            replanning: true,
            passive_safety: true,
            recovery: true,
        }
    }
}
