//! Paths on all public development maps: none touches an obstacle, and in the mine their lengths are as documented.
//!
//! The maps are expected next to the repository; without them the trials are ignored.

use inbye::geometry::Point;
use inbye::global::{PlanError, PlanningSpace, SearchMethod, Searcher, Settings, plan};
use inbye::map::{
    FreeSpace, LoadOptions, ObstacleGrid, UnknownPolicy, cell_from_top_left, load, read_scen,
};
use libtest_mimic::{Failed, Trial};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::fs;
use std::path::{Path as FilePath, PathBuf};

use crate::support::trials::{DATA, with_data};

/// The map of a mine with 0.25 m cells, in the development data.
const MINE: &str = "mine/niosh_sr_025m.map";

/// Paths planned on each map.
const PATHS: usize = 24;

pub fn trials() -> Vec<Trial> {
    let mut maps = Vec::new();
    collect(FilePath::new(DATA), &mut maps);
    maps.sort();
    let mut trials: Vec<Trial> = maps.into_iter().map(keeps_clear).collect();
    trials.push(with_data("an obstacle on a path is detected", MINE, is_noticed));
    trials.push(with_data("paths in the mine are short", MINE, are_short));
    trials
}

/// The map files below a folder.
fn collect(folder: &FilePath, maps: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let is_map = path.extension().is_some_and(|kind| kind == "map" || kind == "yaml");
        if path.is_dir() {
            collect(&path, maps);
        } else if is_map {
            maps.push(path);
        }
    }
}

fn read(file: &FilePath) -> Result<ObstacleGrid, Failed> {
    let options = LoadOptions { resolution_m: 0.25 };
    Ok(load(file, &options)?.obstacles(UnknownPolicy::Blocked))
}

/// Plans between random points, with several clearances, both search methods and all spline degrees.
fn keeps_clear(file: PathBuf) -> Trial {
    let name = file.strip_prefix(DATA).unwrap_or(&file).display().to_string();
    Trial::test(name, move || {
        let obstacles = read(&file)?;
        let mut random = Pcg64Mcg::seed_from_u64(31);
        let mut searcher = Searcher::default();
        let mut planned = 0;
        for number in 0..PATHS {
            let cell_m = obstacles.frame().resolution_m;
            let radius_m = [0.0, 1.0, 2.3][number % 3] * cell_m;
            let space = FreeSpace::new(&obstacles, radius_m);
            if space.count() == 0 {
                continue;
            }
            let settings = Settings::default()
                .search([SearchMethod::AStar, SearchMethod::JumpPoints][number % 2])
                .spline_degree(1 + number % 6);
            let ends = [(); 2].map(|()| free_point(&space, &mut random));
            let outcome = path(&mut searcher, &space, ends, &settings);
            let path = match outcome {
                Ok(plan) => plan.smoothed,
                Err(PlanError::NoValidPath { .. }) => continue,
                Err(error) => return Err(error.into()),
            };
            planned += 1;
            clear(path.points(), &obstacles, radius_m)?;
        }
        if planned < 3 {
            return Err(format!("only {planned} of {PATHS} paths were found").into());
        }
        Ok(())
    })
}

fn path(
    searcher: &mut Searcher,
    space: &FreeSpace,
    [start, goal]: [Point; 2],
    settings: &Settings,
) -> Result<inbye::global::Plan, PlanError> {
    let ground = PlanningSpace { search: space, smoothing: space, costs: None };
    plan(searcher, &ground, start, goal, settings, &mut || 0.0)
}

/// A random point inside a free cell; at least one cell is free.
fn free_point(space: &FreeSpace, random: &mut Pcg64Mcg) -> Point {
    let frame = space.frame();
    let within = |random: &mut Pcg64Mcg, side: i32| random.random_range(0.0..f64::from(side));
    let any = frame
        .from_cell_units(&Point::new(within(random, frame.width), within(random, frame.height)));
    let cell = space.nearest_free(&any).expect("some cell is free");
    let inside = |at: i32, random: &mut Pcg64Mcg| f64::from(at) + random.random_range(0.01..0.99);
    frame.from_cell_units(&Point::new(inside(cell.column, random), inside(cell.row, random)))
}

/// Fails if a path violates its clearance or leaves the map.
fn clear(points: &[Point], obstacles: &ObstacleGrid, radius_m: f64) -> Result<(), Failed> {
    let gap_m =
        crate::support::gap::smallest_gap_m(points, obstacles, radius_m, crate::support::gap::STEP);
    // With radius zero, a path may run along the edge of an obstacle but not enter it.
    if gap_m < radius_m - 1e-9 || !crate::support::gap::is_on_grid(points, obstacles) {
        return Err(format!("comes within {gap_m} m, not {radius_m} m").into());
    }
    Ok(())
}

fn is_noticed(mine: &FilePath) -> Result<(), Failed> {
    let mut obstacles = read(mine)?;
    let space = FreeSpace::new(&obstacles, 0.5);
    let mut random = Pcg64Mcg::seed_from_u64(32);
    let ends = [(); 2].map(|()| free_point(&space, &mut random));
    let smoothed = path(&mut Searcher::default(), &space, ends, &Settings::default())?.smoothed;
    clear(smoothed.points(), &obstacles, 0.5)?;
    let middle = smoothed.point_at(smoothed.length_m() / 2.0);
    let cell = obstacles.frame().cell_of(&middle).ok_or("it leaves the map")?;
    obstacles.set(cell, true);
    if clear(smoothed.points(), &obstacles, 0.5).is_ok() {
        return Err("an obstacle on the path was not detected".into());
    }
    Ok(())
}

/// Compares smoothed lengths with the shortest cell paths over the mine's 500 queries.
fn are_short(mine: &FilePath) -> Result<(), Failed> {
    let obstacles = read(mine)?;
    let space = FreeSpace::new(&obstacles, 0.0);
    let settings = Settings::default().search(SearchMethod::JumpPoints);
    let mut searcher = Searcher::default();
    let (mut ratios, mut worst) = (0.0, 0.0_f64);
    let queries = read_scen(&mine.with_extension("map.scen"))?;
    for query in &queries {
        let center = |at| obstacles.frame().center_of(cell_from_top_left(obstacles.frame(), at));
        let ends = [center(query.start), center(query.goal)];
        let plan = path(&mut searcher, &space, ends, &settings)?;
        let shortest_m = query.optimal * obstacles.frame().resolution_m;
        let raw_m = plan.raw.length_m();
        if (raw_m - shortest_m).abs() > 1e-3 {
            return Err(format!("{raw_m} m searched, {shortest_m} m listed").into());
        }
        let ratio = plan.smoothed.length_m() / shortest_m.max(f64::MIN_POSITIVE);
        ratios += ratio;
        worst = worst.max(ratio);
        clear(plan.smoothed.points(), &obstacles, 0.0)?;
    }
    let mean = ratios / queries.len() as f64;
    #[expect(clippy::print_stderr, reason = "the figure that the README names")]
    {
        eprintln!("mean {mean:.4}, worst {worst:.4} of the octile length");
    }
    if mean > 0.975 || worst > 1.0 + 1e-9 {
        return Err(format!("mean {mean}, worst {worst}").into());
    }
    Ok(())
}
