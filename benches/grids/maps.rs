//! Maps and their timed queries.

use std::path::Path;

use inbye::geometry::Pose;
use inbye::global::{Heuristic, Searcher};
use inbye::map::{
    Cell, FreeSpace, GridFrame, LoadOptions, ObstacleGrid, UnknownPolicy, cell_from_top_left, load,
    read_scen,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Number of queries per map.
const QUERIES: usize = 100;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data");

/// The common timing set: structured maps, a random one, and a real mine.
const PUBLIC: [&str; 6] = [
    "movingai/dao/den520d",
    "movingai/dao/brc202d",
    "movingai/da2/ca_caverns1_mines",
    "movingai/random/random512-25-0",
    "movingai/mazes/maze512-8-0",
    "mine/niosh_sr_025m",
];

/// Side of the generated maps, cells.
const SIDE: i32 = 512;

/// A map with queries that all have a path.
pub struct TimedMap {
    pub name: String,
    pub obstacles: ObstacleGrid,
    pub space: FreeSpace,
    pub queries: Vec<(Cell, Cell)>,
}

/// All timed maps.
#[expect(clippy::print_stdout, reason = "a bench prints what it does")]
pub fn courses() -> Vec<TimedMap> {
    let public: Vec<TimedMap> = PUBLIC.into_iter().filter_map(public).collect();
    if public.is_empty() {
        println!("The public maps are not next to the repository: timing generated maps.");
        return vec![
            made("pillars", |column, row, _| column % 16 < 9 && row % 16 < 9),
            made("clutter of a quarter", |_, _, random| random.random_bool(0.25)),
            made("drifts", |column, row, random| {
                let wall = column % 9 == 0 || row % 9 == 0;
                wall && !random.random_bool(0.12)
            }),
        ];
    }
    public
}

/// The scenarios with the largest listed lengths, ties in file order; none without the files.
fn public(name: &str) -> Option<TimedMap> {
    let file = |ending: &str| Path::new(DATA).join(format!("{name}.{ending}"));
    let map = load(&file("map"), &LoadOptions::default()).ok()?;
    let mut scenarios = read_scen(&file("map.scen")).ok()?;
    scenarios.sort_by(|one, other| other.optimal.total_cmp(&one.optimal));
    let at = |place| cell_from_top_left(map.frame(), place);
    let queries = scenarios.iter().take(QUERIES);
    let queries = queries.map(|query| (at(query.start), at(query.goal)));
    let obstacles = map.obstacles(UnknownPolicy::Blocked);
    Some(TimedMap {
        name: name.to_owned(),
        space: FreeSpace::new(&obstacles, 0.0),
        queries: queries.collect(),
        obstacles,
    })
}

/// Generates a map from a rule for its cells, with random queries.
fn made(name: &str, mut is_blocked: impl FnMut(i32, i32, &mut Pcg64Mcg) -> bool) -> TimedMap {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let frame = GridFrame::new(SIDE, SIDE, 1.0, Pose::default()).expect("a sound size");
    let obstacles =
        ObstacleGrid::from_fn(frame, |Cell { column, row }| is_blocked(column, row, &mut random));
    let space = FreeSpace::new(&obstacles, 0.0);
    let mut searcher = Searcher::default();
    let mut queries = Vec::new();
    while queries.len() < QUERIES {
        let mut any = || Cell::new(random.random_range(0..SIDE), random.random_range(0..SIDE));
        let (start, goal) = (any(), any());
        let far = start.column.abs_diff(goal.column) + start.row.abs_diff(goal.row) > SIDE as u32;
        if far && searcher.astar(&space, start, goal, Heuristic::Octile, None).is_ok() {
            queries.push((start, goal));
        }
    }
    TimedMap { name: name.to_owned(), obstacles, space, queries }
}
