//! The zones of the command line: masks in the form of maps.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, ensure};
use clap::Args;
use inbye::geometry::Point;
use inbye::map::{OccupancyGrid, Zones};

use super::arguments::Place;
use super::map_file;

/// Masks of zones.
#[derive(Debug, Default, Args)]
pub struct ZoneArguments {
    /// Mask of closed zones, a map file: the robot does not enter its occupied cells. Nav2's masks for its keepout filter are such files.
    #[arg(long, value_name = "FILE")]
    pub keepout: Option<PathBuf>,
    /// Mask of speed limits, a map file with `mode: scale` or `raw`: the darker, the slower. A value of 30 is a limit of 70 percent of
    /// the largest speed, as with `base: 100.0` and `multiplier: -1.0` of Nav2's speed filter.
    #[arg(long, value_name = "FILE")]
    pub speed_zones: Option<PathBuf>,
}

impl ZoneArguments {
    /// The zones on a map; none without masks. `resolution_m` applies to a mask without its own.
    pub fn read(
        &self,
        map: &OccupancyGrid,
        resolution_m: f64,
    ) -> anyhow::Result<Option<Arc<Zones>>> {
        let mut zones = Zones::new(map.frame());
        if let Some(file) = &self.keepout {
            let mask = map_file::load(file, resolution_m)?;
            zones
                .add_keepout_mask(&mask)
                .with_context(|| format!("--keepout {}", file.display()))?;
        }
        if let Some(file) = &self.speed_zones {
            let mask = map_file::load(file, resolution_m)?;
            zones
                .add_speed_mask(&mask)
                .with_context(|| format!("--speed-zones {}", file.display()))?;
        }
        let is_given = self.keepout.is_some() || self.speed_zones.is_some();
        Ok(is_given.then(|| Arc::new(zones)))
    }

    /// An error for an end or a stop in a closed zone.
    pub fn check(
        &self,
        zones: Option<&Zones>,
        (start, goal): (&Place, &Place),
        vias: &[Place],
    ) -> anyhow::Result<()> {
        let (Some(zones), Some(file)) = (zones, &self.keepout) else {
            return Ok(());
        };
        let closed = zones.closed();
        let vias = vias.iter().map(|via| ("--via", via));
        for (flag, place) in [("--start", start), ("--goal", goal)].into_iter().chain(vias) {
            let cell = closed.frame().cell_of(&place.position);
            let is_closed = cell.is_some_and(|cell| closed.is_blocked(cell));
            let (Point { x, y }, file) = (place.position, file.display());
            ensure!(!is_closed, "{flag} {x},{y} lies in a closed zone of --keepout {file}");
        }
        Ok(())
    }
}
