//! What became of the ground that a map does not know, as people and scripts read it.

use inbye::map::{OccupancyGrid, UNKNOWN, UnknownPolicy};
use serde_json::{Value, json};

/// For scripts.
pub fn object(map: &OccupancyGrid, policy: UnknownPolicy) -> Value {
    json!({ "cells": cells(map), "counted_as": policy })
}

/// For people, of a map with such ground.
pub fn fact(map: &OccupancyGrid, policy: UnknownPolicy) -> Option<String> {
    let counted = match policy {
        UnknownPolicy::Blocked => "blocked (--unknown free counts it as free)",
        UnknownPolicy::Free => "free",
    };
    match cells(map) {
        0 => None,
        cells => Some(format!("{cells} cells, counted as {counted}")),
    }
}

fn cells(map: &OccupancyGrid) -> usize {
    let unknown = map.cells().iter().filter(|cell| **cell == UNKNOWN);
    unknown.count()
}
