//! The zones of the command line: masks in the form of maps.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::ensure;
use clap::Args;
use inbye::geometry::Point;
use inbye::global::PlanError;
use inbye::map::{Mask, MaskError, OccupancyGrid, Zones};

use super::arguments::Place;
#[cfg(feature = "playground")]
use super::files::shell_arguments;
use super::map_file;

/// Masks of zones.
#[derive(Debug, Default, Args)]
pub struct ZoneArguments {
    /// Map file with a mask of closed zones: the robot does not enter its occupied cells. Masks of Nav2's keepout filter have this
    /// form.
    #[arg(long, value_name = "FILE")]
    pub keepout: Option<PathBuf>,
    /// Map file with a mask of speed limits, in `mode: scale` or `raw`: a darker cell has a lower limit. A value of 30 is a limit of 70
    /// percent of the largest speed, as with `base: 100.0` and `multiplier: -1.0` of Nav2's speed filter.
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
        let load = |file: &Option<PathBuf>, load: fn(&Path, f64) -> anyhow::Result<_>| {
            file.as_ref().map(|file| load(file, resolution_m)).transpose()
        };
        let keepout = load(&self.keepout, map_file::load)?;
        let speed = load(&self.speed_zones, map_file::load_speed_mask)?;
        let zones = Zones::from_masks(map.frame(), None, keepout.as_ref(), speed.as_ref());
        let zones = zones.map_err(|MaskError { mask, fault }| {
            let (flag, file) = match mask {
                Mask::Keepout => ("--keepout", &self.keepout),
                Mask::Speed => ("--speed-zones", &self.speed_zones),
            };
            let file = file.as_deref().unwrap_or(Path::new(""));
            anyhow::Error::new(fault).context(format!("{flag} {}", file.display()))
        });
        Ok(zones?.map(Arc::new))
    }

    /// What to add to the message of an error: the library does not tell closed zones from obstacles.
    pub const fn note(&self, error: &PlanError) -> &'static str {
        if self.keepout.is_some() && error.is_caused_by_obstacles() {
            "; the closed zones of --keepout count as obstacles"
        } else {
            ""
        }
    }

    /// The mask files.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.keepout.iter().chain(&self.speed_zones).map(PathBuf::as_path)
    }

    /// The arguments of a shell for the same masks, each after a space.
    #[cfg(feature = "playground")]
    pub fn as_arguments(&self) -> String {
        let masks = [("--keepout", &self.keepout), ("--speed-zones", &self.speed_zones)];
        let given = masks.into_iter().filter_map(|(flag, file)| Some((flag, file.as_ref()?)));
        shell_arguments(given.map(|(flag, file)| (flag, file.display().to_string())))
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
            ensure!(
                !is_closed,
                "{flag} {x},{y}: lies in a closed zone of --keepout {file}: choose a place outside the zone, or change the mask"
            );
        }
        Ok(())
    }
}
