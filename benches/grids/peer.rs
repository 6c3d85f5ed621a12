//! Reference search: A* of the `pathfinding` crate, used as its documentation shows.

use inbye::global::{DIAGONAL, STRAIGHT};
use inbye::map::{Cell, ObstacleGrid};
use pathfinding::prelude::astar;

/// Cost of a shortest path between connected cells, and the number of expansions.
pub fn shortest(obstacles: &ObstacleGrid, start: Cell, goal: Cell) -> (u64, u32) {
    let mut expanded = 0;
    let found = astar(
        &start,
        |&cell| {
            expanded += 1;
            moves(obstacles, cell)
        },
        |&cell| octile(cell, goal),
        |&cell| cell == goal,
    );
    (found.map_or(u64::MAX, |(_, cost)| u64::from(cost)), expanded)
}

/// The neighbours of a cell; diagonals only between two free cells.
fn moves(obstacles: &ObstacleGrid, from: Cell) -> Vec<(Cell, u32)> {
    let to = |dx: i32, dy: i32| Cell::new(from.column + dx, from.row + dy);
    let is_free = |dx, dy| !obstacles.is_blocked(to(dx, dy));
    let straight = [(1, 0), (0, 1), (-1, 0), (0, -1)];
    let open = straight.map(|(dx, dy)| is_free(dx, dy));
    let mut moves = Vec::with_capacity(8);
    for (place, (dx, dy)) in straight.into_iter().enumerate() {
        if open[place] {
            moves.push((to(dx, dy), STRAIGHT as u32));
        }
        let next = (place + 1) % 4;
        let (sx, sy) = (dx + straight[next].0, dy + straight[next].1);
        if open[place] && open[next] && is_free(sx, sy) {
            moves.push((to(sx, sy), DIAGONAL as u32));
        }
    }
    moves
}

fn octile(from: Cell, to: Cell) -> u32 {
    let dx = from.column.abs_diff(to.column);
    let dy = from.row.abs_diff(to.row);
    dx.max(dy) * STRAIGHT as u32 + dx.min(dy) * (DIAGONAL - STRAIGHT) as u32
}
