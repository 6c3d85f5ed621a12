//! A sampling of the dynamic window, as plans write it.

use core::fmt::{self, Display};
use core::str::FromStr;

use serde::{Deserialize, Serialize};

/// Numbers of forward speeds and turn rates, written as `16x64`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct SamplingGrid {
    /// Number of forward speeds, at least one.
    pub vx_samples: u32,
    /// Number of turn rates, at least one.
    pub vtheta_samples: u32,
}

impl FromStr for SamplingGrid {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let count = |text: &str| text.parse().ok().filter(|&count: &u32| count > 0);
        let counts = text.split_once('x');
        counts
            .and_then(|(v, omega)| {
                Some(Self { vx_samples: count(v)?, vtheta_samples: count(omega)? })
            })
            .ok_or_else(|| {
                let text = text.escape_debug();
                format!(
                    "`{text}` is no sampling: write forward speeds x turn rates, such as \"16x64\""
                )
            })
    }
}

impl TryFrom<String> for SamplingGrid {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<SamplingGrid> for String {
    fn from(grid: SamplingGrid) -> Self {
        grid.to_string()
    }
}

impl Display for SamplingGrid {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}x{}", self.vx_samples, self.vtheta_samples)
    }
}
