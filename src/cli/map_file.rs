//! The map of the command line with its settings.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, bail};
use clap::Args;
use inbye::geometry::{Point, Pose};
use inbye::map::{
    GridFrame, LoadOptions, MapWarning, OccupancyGrid, UNKNOWN, UnknownPolicy, Zones,
    has_own_resolution, load_with_warnings,
};
use inbye::runtime::Config;
use inbye::sim::{Scene, scene as scene_of};
use serde_json::{Value, json};

use super::arguments::{Place, length, scene, unknown};
#[cfg(feature = "playground")]
use super::files::shell_arguments;
use super::zones::ZoneArguments;
use super::{config, output};

/// A map or a built-in scene, and its settings.
#[derive(Debug, Args)]
pub struct MapArguments {
    #[arg(
        long,
        value_name = "FILE",
        required_unless_present = "scene",
        help = "Map: a ROS map_server .yaml, a MovingAI .map, or rows of text (# wall, . free, ? unknown)"
    )]
    pub map: Option<PathBuf>,
    /// Built-in scene instead of a map. Its start, goal, pedestrians and seed are the defaults.
    #[arg(long, value_name = "NAME", conflicts_with = "map", value_parser = scene())]
    pub scene: Option<&'static str>,
    #[command(flatten)]
    pub zones: ZoneArguments,
    #[command(flatten)]
    pub settings: MapSettings,
}

/// Start and goal of a command.
#[derive(Debug, Args)]
pub struct EndArguments {
    /// Start, metres and radians. The default yaw is 0; a drawing of `plan` then shows the start along the path.
    #[arg(
        long,
        value_name = "X,Y[,YAW]",
        required_unless_present = "scene",
        allow_hyphen_values = true
    )]
    pub start: Option<Place>,
    /// Goal, metres, and optionally the final yaw, radians.
    #[arg(
        long,
        value_name = "X,Y[,YAW]",
        required_unless_present = "scene",
        allow_hyphen_values = true
    )]
    pub goal: Option<Place>,
}

impl EndArguments {
    /// Start and goal: as given, else those of the scene. The first path of a robot that will find its own place is planned again there:
    /// until then its goal stands for a start that it does not need.
    pub fn resolve(
        &self,
        scene: Option<&Scene>,
        needs_start: bool,
    ) -> anyhow::Result<(Place, Place)> {
        let of_scene = scene.map(|scene| {
            let Pose { x, y, yaw } = scene.start;
            let start = Place { position: Point::new(x, y), yaw: Some(yaw) };
            (start, Place { position: scene.goal, yaw: None })
        });
        let instead = if needs_start { None } else { self.goal };
        let start = self.start.or(of_scene.map(|(start, _)| start)).or(instead);
        let goal = self.goal.or(of_scene.map(|(_, goal)| goal));
        for (flag, place) in [("--start", start), ("--goal", goal)] {
            place.iter().for_each(|place| place.warn_of_degrees(flag));
        }
        let goal = goal.context("--goal is missing")?;
        Ok((start.context("--start is missing: name the robot's place, X,Y or X,Y,YAW")?, goal))
    }
}

/// The map of a command with its configuration.
pub struct MapInput {
    /// The file as given, or the name of the scene.
    pub name: String,
    pub map: OccupancyGrid,
    pub zones: Option<Arc<Zones>>,
    pub config: Config,
    /// The scene of the map, if it is a built-in one.
    pub scene: Option<Scene>,
    /// Side of a cell of maps that do not state it, metres.
    pub resolution_m: f64,
}

/// The size of the cells of maps that do not state it.
#[derive(Clone, Copy, Debug, Args)]
pub struct Resolution {
    /// Side of a cell of a .map or text map, metres; a .yaml map states its own [default: 1].
    #[arg(long = "resolution", value_name = "METRES", allow_negative_numbers = true, value_parser = length)]
    pub given: Option<f64>,
}

impl Resolution {
    /// The side of a cell, metres, for those of these maps that do not state it.
    ///
    /// # Errors
    /// Rejects a given resolution that none of the maps needs.
    pub fn of<'a>(self, maps: impl IntoIterator<Item = &'a Path>) -> anyhow::Result<f64> {
        let mut maps = maps.into_iter();
        let Some(given) = self.given else {
            return Ok(1.0);
        };
        let first = maps.next();
        if first.into_iter().chain(maps).any(|map| !has_own_resolution(map)) {
            return Ok(given);
        }
        match first {
            Some(map) => bail!(
                "--resolution {given}: {} states its own resolution: leave the flag out",
                map.display()
            ),
            None => bail!("--resolution {given}: it is for a map file: leave the flag out"),
        }
    }
}

/// The settings for a map.
#[derive(Debug, Args)]
pub struct MapSettings {
    #[command(flatten)]
    pub resolution: Resolution,
    /// How unknown cells count [default: the configuration's, blocked].
    #[arg(long, value_parser = unknown())]
    pub unknown: Option<UnknownPolicy>,
    /// Settings, TOML.
    #[arg(long)]
    pub config: Option<PathBuf>,
    #[arg(
        long = "set",
        value_name = "KEY=VALUE",
        help = "One setting, which overrides that of --config, such as local.vx_samples=32; repeat --set for more"
    )]
    pub changes: Vec<String>,
}

impl MapSettings {
    /// Loads the configuration.
    pub fn load(&self) -> anyhow::Result<Config> {
        let config = config::load("--config", self.config.as_deref())?;
        let mut config = config::with_set(config, &self.changes)?;
        config.unknown = self.unknown.unwrap_or(config.unknown);
        Ok(config)
    }
}

#[cfg(feature = "playground")]
impl MapSettings {
    /// The arguments that give these settings again, each after a space.
    pub fn as_arguments(&self) -> String {
        let resolution = self.resolution.given.map(|given| ("--resolution", given.to_string()));
        let unknown = self
            .unknown
            .map(|policy| ("--unknown", json!(policy).as_str().unwrap_or_default().to_owned()));
        let config = self.config.as_ref().map(|file| ("--config", file.display().to_string()));
        let changes = self.changes.iter().map(|change| ("--set", change.clone()));
        let all = resolution.into_iter().chain(unknown).chain(config).chain(changes);
        shell_arguments(all)
    }
}

/// Loads map and configuration. `truth` is another map of the command, which its resolution may be for.
pub fn read(arguments: &MapArguments, truth: Option<&Path>) -> anyhow::Result<MapInput> {
    let settings = &arguments.settings;
    let maps = arguments.map.as_deref().into_iter().chain(truth).chain(arguments.zones.files());
    let resolution_m = settings.resolution.of(maps)?;
    let config = settings.load()?;
    let scene = arguments.scene.and_then(scene_of);
    let (name, map) = match (&arguments.map, &scene) {
        (Some(file), _) => (file.display().to_string(), load(file, resolution_m)?),
        (None, Some(scene)) => (format!("scene {}", scene.name), scene.map.clone()),
        (None, None) => bail!("--map or --scene is missing"),
    };
    if output::is_verbose() {
        let unknown = unknown_cells_text(&map, config.unknown);
        let unknown =
            unknown.map_or_else(|| "all known".to_owned(), |text| format!("unknown: {text}"));
        let GridFrame { width, height, resolution_m, .. } = map.frame();
        output::detail(format!(
            "map: {name}: {width} x {height} cells of {resolution_m} m; {unknown}",
        ));
    }
    let zones = arguments.zones.read(&map, resolution_m)?;
    Ok(MapInput { name, map, zones, config, scene, resolution_m })
}

/// Loads a map of any format; `resolution_m` applies to a format without its own. Warnings go to standard error.
pub fn load(file: &Path, resolution_m: f64) -> anyhow::Result<OccupancyGrid> {
    load_as(file, resolution_m, |_| ())
}

/// Loads a mask of speed limits like a map with [`load`], and warns of limits that are not those of its greys.
pub fn load_speed_mask(file: &Path, resolution_m: f64) -> anyhow::Result<OccupancyGrid> {
    let place = file.display();
    load_as(file, resolution_m, |warning| output::warn(format!("--speed-zones {place}: {warning}")))
}

/// Loads a map; `warn_of_scale` gets the warning that only matters for a mask of speed limits.
fn load_as(
    file: &Path,
    resolution_m: f64,
    warn_of_scale: impl Fn(MapWarning),
) -> anyhow::Result<OccupancyGrid> {
    let options = LoadOptions { resolution_m };
    let mut warn = |warning| match warning {
        MapWarning::ClippedScale { .. } => warn_of_scale(warning),
        warning => output::note(format!("note: {}: {warning}", file.display())),
    };
    Ok(load_with_warnings(file, &options, &mut warn)?)
}

/// Loads a map like [`load`], with its name: that of the file without folder and extension.
pub fn load_named(file: &Path, resolution_m: f64) -> anyhow::Result<(String, Arc<OccupancyGrid>)> {
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    Ok((name.into_owned(), Arc::new(load(file, resolution_m)?)))
}

/// The number of unknown cells and how they count, as JSON.
pub fn unknown_cells_json(map: &OccupancyGrid, policy: UnknownPolicy) -> Value {
    json!({ "cells": count_unknown(map), "counted_as": policy })
}

/// The number of unknown cells and how they count, as text; none for a map without such cells.
pub fn unknown_cells_text(map: &OccupancyGrid, policy: UnknownPolicy) -> Option<String> {
    let counted = match policy {
        UnknownPolicy::Blocked => "blocked (--unknown free counts them as free)",
        UnknownPolicy::Free => "free",
    };
    match count_unknown(map) {
        0 => None,
        cells => Some(format!("{cells} cells, counted as {counted}")),
    }
}

fn count_unknown(map: &OccupancyGrid) -> usize {
    map.cells().iter().filter(|cell| **cell == UNKNOWN).count()
}
