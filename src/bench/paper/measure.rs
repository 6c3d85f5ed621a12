//! Paths of every search, checked once and timed many times.

use core::cmp::Reverse;
use std::collections::BinaryHeap;

use super::search::{Search, Stage};
use super::site::{PaperError, Site, Task};
use crate::bench::{percentiles, search_grid};
use crate::global::{DIAGONAL, Path, PathClearance, Pruning, STRAIGHT, Searcher, prune, smooth};
use crate::map::{Cell, FreeSpace};

/// Degree of the smoothing B-spline, as in the default settings.
const SPLINE_DEGREE: usize = 3;
/// Tolerance of the distance to obstacles for rounding, metres.
const ROUNDING_M: f64 = 1e-9;

/// Median and tail of a time, milliseconds. In JSON the fields are `p50` and `p95`; the name of the object has the unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct Times {
    /// Median.
    #[serde(rename = "p50")]
    pub p50_ms: f64,
    /// 95th percentile.
    #[serde(rename = "p95")]
    pub p95_ms: f64,
}

/// A path at one stage.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StagePath {
    /// The path.
    pub path: Path,
    /// Smallest distance to an obstacle, metres.
    pub min_clearance_m: f64,
    /// Time from the beginning of the search to the end of this stage.
    pub time: Times,
    /// Median time of this stage alone, milliseconds.
    pub own_ms: f64,
}

/// The result of one search for one task.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The search.
    pub search: Search,
    /// Cost of its moves, in the units of [`STRAIGHT`](crate::global::STRAIGHT).
    pub cost: u64,
    /// Cells expanded.
    pub expanded: u32,
    /// The path at each stage of the search, [`Stage::Raw`] first.
    pub stages: Vec<StagePath>,
}

impl Run {
    /// The path at a stage, or at the search's last stage if that is earlier.
    #[must_use]
    pub fn at(&self, stage: Stage) -> &StagePath {
        &self.stages[(stage as usize).min(self.stages.len() - 1)]
    }
}

/// The results of all searches for one task.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TaskRuns {
    /// The task.
    pub task: Task,
    /// Smallest cost of any path, by another algorithm.
    pub shortest: u64,
    /// One run for each search, in the given order.
    pub runs: Vec<Run>,
}

impl TaskRuns {
    /// The run of a search, if there is one.
    #[must_use]
    pub fn of(&self, search: Search) -> Option<&Run> {
        self.runs.iter().find(|run| run.search == search)
    }

    /// Excess length of a run's raw path over the shortest, as a share.
    #[must_use]
    pub fn over_shortest(&self, run: &Run) -> f64 {
        run.cost as f64 / self.shortest.max(1) as f64 - 1.0
    }

    /// Exact searches without a shortest path, and paths closer to an obstacle than allowed, a sentence each.
    #[must_use]
    pub fn faults(&self, site: &Site) -> Vec<String> {
        let mut faults = Vec::new();
        for run in &self.runs {
            let (name, task) = (run.search.label, &self.task.name);
            let (cost, least) = (run.cost, self.shortest);
            if cost < least || (run.search.is_exact() && cost > least) {
                faults
                    .push(format!("{task}, {name}: its path costs {cost}, a shortest one {least}"));
            }
            for (stage, staged) in Stage::ALL.into_iter().zip(&run.stages) {
                let ground = if stage == Stage::Smoothed { &site.proof } else { &site.search };
                let (clear_m, promised_m) = (staged.min_clearance_m, ground.radius_m());
                if clear_m < promised_m - ROUNDING_M {
                    faults.push(format!(
                        "{task}, {name}, {stage:?}: {clear_m:.4} m from an obstacle, less than {promised_m:.4} m"
                    ));
                }
            }
        }
        faults
    }
}

/// Runs each search for each task of a site: once to check its paths, then `repetitions` times with the clock, in seconds.
/// Each repetition runs all searches, beginning with another one each time: a machine that slows down affects all of them.
/// All use one searcher, as in a robot. `progress` is called after each repetition of each task.
///
/// # Errors
/// Fails when a task has no path.
pub fn measure(
    site: &Site,
    searches: &[Search],
    repetitions: usize,
    clock: &mut dyn FnMut() -> f64,
    mut progress: impl FnMut(),
) -> Result<Vec<TaskRuns>, PaperError> {
    let mut searcher = Searcher::default();
    let clearances = PathClearance::new(&site.obstacles);
    let mut measured = Vec::new();
    for task in &site.tasks {
        let no_path =
            || PaperError::NoPath { task: task.name.clone(), radius_m: site.search.radius_m() };
        let shortest = shortest_cost(&site.search, task.start, task.goal).ok_or_else(no_path)?;
        // The first pass also grows the searcher's memory and is not timed.
        let mut checked = Vec::new();
        for &search in searches {
            let attempt = attempt(&mut searcher, site, task, search, &mut || 0.0);
            checked.push(attempt.ok_or_else(no_path)?);
        }
        let mut seconds = vec![Vec::new(); searches.len()];
        for repetition in 0..repetitions {
            for turn in 0..searches.len() {
                let index = (turn + repetition) % searches.len();
                let timed = attempt(&mut searcher, site, task, searches[index], clock);
                seconds[index].push(timed.ok_or_else(no_path)?.ended_s);
            }
            progress();
        }
        let runs = searches
            .iter()
            .zip(checked)
            .zip(&seconds)
            .map(|((&search, attempt), seconds)| run(&clearances, search, attempt, seconds))
            .collect();
        measured.push(TaskRuns { task: task.clone(), shortest, runs });
    }
    Ok(measured)
}

/// One search, with the stages after it.
struct Attempt {
    cost: u64,
    expanded: u32,
    paths: Vec<Path>,
    /// End of each stage, seconds after the start.
    ended_s: Vec<f64>,
}

fn attempt(
    searcher: &mut Searcher,
    site: &Site,
    task: &Task,
    search: Search,
    clock: &mut dyn FnMut() -> f64,
) -> Option<Attempt> {
    let frame = site.search.frame();
    let began = clock();
    let found =
        search_grid(searcher, &site.search, [task.start, task.goal], search.heuristic).ok()?;
    let centers = found.cells.iter().map(|&cell| frame.center_of(cell));
    let mut paths = vec![Path::new(centers.collect())];
    let (cost, expanded) = (found.cost, found.expanded);
    let mut ended_s = vec![clock() - began];
    if search.last_stage >= Stage::Pruned {
        paths.push(prune(&site.search, None, &paths[0], Pruning::Sparse));
        ended_s.push(clock() - began);
    }
    if search.last_stage >= Stage::Smoothed {
        paths.push(smooth(&site.proof, &paths[1], SPLINE_DEGREE).0);
        ended_s.push(clock() - began);
    }
    Some(Attempt { cost, expanded, paths, ended_s })
}

fn run(clearances: &PathClearance, search: Search, attempt: Attempt, seconds: &[Vec<f64>]) -> Run {
    let stages = attempt
        .paths
        .into_iter()
        .enumerate()
        .map(|(stage, path)| {
            let total: Vec<f64> = seconds.iter().map(|ends| ends[stage]).collect();
            let before = |ends: &Vec<f64>| stage.checked_sub(1).map_or(0.0, |one| ends[one]);
            let own: Vec<f64> = seconds.iter().map(|ends| ends[stage] - before(ends)).collect();
            StagePath {
                min_clearance_m: clearances.min_m(&path),
                path,
                time: times(&total),
                own_ms: times(&own).p50_ms,
            }
        })
        .collect();
    Run { search, cost: attempt.cost, expanded: attempt.expanded, stages }
}

/// Median and tail of times in seconds; zero for no times.
fn times(seconds: &[f64]) -> Times {
    let [p50_ms, p95_ms] =
        percentiles(seconds.to_vec(), [0.5, 0.95]).map(|time_s| time_s.map_or(0.0, |it| it * 1e3));
    Times { p50_ms, p95_ms }
}

/// Returns the smallest cost of moves from a cell to another by a plain Dijkstra search; none without a path. The searches
/// share only the costs of moves with this reference.
fn shortest_cost(space: &FreeSpace, start: Cell, goal: Cell) -> Option<u64> {
    let frame = space.frame();
    if !(space.is_free(start) && space.is_free(goal)) {
        return None;
    }
    let mut least = vec![u64::MAX; frame.len()];
    least[frame.index(start)] = 0;
    let mut open = BinaryHeap::from([(Reverse(0), frame.index(start))]);
    while let Some((Reverse(cost), index)) = open.pop() {
        let Cell { column, row } = frame.cell_at(index);
        if Cell::new(column, row) == goal {
            return Some(cost);
        }
        if cost > least[index] {
            continue;
        }
        let is_free = |right: i32, up: i32| space.is_free(Cell::new(column + right, row + up));
        for (right, up) in (-1..=1).flat_map(|up| (-1..=1).map(move |right| (right, up))) {
            let moves = (right, up) != (0, 0);
            if !(moves && is_free(right, up) && is_free(right, 0) && is_free(0, up)) {
                continue;
            }
            let step = if right != 0 && up != 0 { DIAGONAL } else { STRAIGHT };
            let neighbour = frame.index(Cell::new(column + right, row + up));
            if cost + step < least[neighbour] {
                least[neighbour] = cost + step;
                open.push((Reverse(cost + step), neighbour));
            }
        }
    }
    None
}
