//! Parts of map pictures: the viewport, the occupancy grid, paths, tracks, encounters, and standalone pictures.

mod decorations;
mod encounters;
mod layers;
mod motion;
mod raster;
mod side_by_side;
mod standalone_map;
mod viewport;

pub(super) use decorations::{
    STRIP, goal_mark, labels, nearest_mark, scaled, start_mark, stop_mark, strip,
};
pub(super) use encounters::Encounters;
pub(super) use layers::{
    PAGE_RASTER, STANDALONE_RASTER, Stages, ground, ground_legend, path, stage_legend, stages,
};
pub(super) use motion::{contacts, has_trails, top_speed, track, track_legend, trails};
pub(super) use side_by_side::{MapPanel, MapsSideBySide};
pub(super) use standalone_map::{StandaloneMap, TOLERANCE as STANDALONE_TOLERANCE};
pub(super) use viewport::{MAP_WIDTH, Viewport};
