//! How well each place of a map explains the end of a beam, for the search of the whole map.

use super::free_places::FreePlaces;
use super::score_pyramid::ScorePyramid;
use super::signed_distance_field::SignedDistanceField;

/// Smallest side of a cell, metres: the search is followed by the scan matcher.
const MIN_CELL_M: f64 = 0.1;
/// Largest number of cells; larger maps have larger cells.
const MAX_CELLS: f64 = 16e6;
/// Number of levels: the largest node covers 64 x 64 translations.
const LEVELS: usize = 7;
/// A cell scores by the distance of its centre from the next surface, up to this one, metres, or two cells.
const REACH_M: f64 = 0.3;
/// Highest score of a cell.
pub(super) const FULL: u8 = 200;

/// Scores and free places of a map.
#[derive(Clone, Debug)]
pub(super) struct MapScores {
    pub cell_m: f64,
    pub scores: ScorePyramid,
    pub free: FreePlaces,
}

impl MapScores {
    pub fn new(map: &SignedDistanceField) -> Self {
        let frame = &map.frame;
        let (width_m, height_m) = (
            f64::from(frame.width) * frame.resolution_m,
            f64::from(frame.height) * frame.resolution_m,
        );
        let least_m = (width_m / MAX_CELLS.sqrt()).max(height_m / MAX_CELLS.sqrt());
        let cell_m = MIN_CELL_M.max(frame.resolution_m).max(least_m);
        let cells = |length_m: f64| (length_m / cell_m).ceil().max(1.0) as i32;
        let (columns, rows) = (cells(width_m), cells(height_m));
        let reach_m = REACH_M.max(2.0 * cell_m);
        let mut scores = Vec::with_capacity(columns as usize * rows as usize);
        let mut free = Vec::with_capacity(scores.capacity());
        for row in 0..rows {
            for column in 0..columns {
                let center = |cell: i32| cell_m * (f64::from(cell) + 0.5);
                let distance_m = map.cell_distance_m(center(column), center(row));
                let near = distance_m
                    .map_or(0.0, |distance_m| (1.0 - distance_m.abs() / reach_m).max(0.0));
                scores.push((near * f64::from(FULL)).round() as u8);
                free.push(distance_m.is_some_and(|distance_m| distance_m > 0.0));
            }
        }
        Self {
            cell_m,
            scores: ScorePyramid::new(columns, rows, &scores, LEVELS),
            free: FreePlaces::new(columns as usize, &free, LEVELS),
        }
    }
}
