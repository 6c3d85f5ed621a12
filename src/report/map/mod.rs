//! Parts of map pictures: the viewport, the layers, encounters, decorations, and standalone pictures.

mod areas;
mod decorations;
mod encounters;
mod layers;
mod raster;
mod standalone;
mod viewport;

pub(super) use areas::Areas;
pub(super) use decorations::{
    end_legend, goal_mark, labels, nearest_mark, node_mark, scaled, start_mark, stop_mark,
};
pub(super) use encounters::Encounters;
pub use layers::PathStages;
pub(super) use layers::{
    PAGE_RASTER, PLAYER_RASTER, STANDALONE_RASTER, contacts, ground, ground_legend, path,
    stage_legend, stages, top_speed, track, track_legend, trail_legend, trails,
};
pub(super) use standalone::{MapPanel, MapsSideBySide, STANDALONE_TOLERANCE, StandaloneMap};
pub(super) use viewport::{MAP_WIDTH, Viewport};
