//! The zones of the command line: masks in the form of maps.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::ensure;
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
        let mask = |flag: &str, file: &Path| {
            let mask = map_file::load(file, resolution_m)?;
            let on_map = mask.frame().corners().iter().any(|at| map.frame().cell_of(at).is_some())
                || map.frame().corners().iter().any(|at| mask.frame().cell_of(at).is_some());
            let file = file.display();
            ensure!(
                on_map,
                "{flag} {file}: the mask lies beside the map: give it the origin of the map"
            );
            Ok(mask)
        };
        if let Some(file) = &self.keepout {
            zones.close(&mask("--keepout", file)?);
            let file = file.display();
            ensure!(
                !zones.is_open(),
                "--keepout {file}: no cell of the map is closed: the mask must have occupied cells, of 100 percent"
            );
        }
        if let Some(file) = &self.speed_zones {
            let mask = mask("--speed-zones", file)?;
            ensure!(
                mask.cells().iter().all(|&value| value < 100),
                "--speed-zones {}: a cell is 100 percent, a limit of zero: set `mode: scale` and `occupied_thresh: 1.0` in the mask, \
                 or close the zone with --keepout",
                file.display()
            );
            zones.limit_speed(&mask, |value| (value > 0).then(|| 100.0 - f64::from(value)));
            let file = file.display();
            ensure!(
                zones.has_speed_limits(),
                "--speed-zones {file}: no cell of the map has a limit: the mask must have values above 0 (`mode: scale`)"
            );
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
