//! Grid searches compared with an independent A*, on the same queries in the same run.
//!
//! The queries are the hundred longest of six public maps if these are next to the repository, else of generated maps.
//! Results are compared before timing. Timings on a shared machine vary, so each query runs with all searches in turn
//! and the best of several passes counts; only the ratios are meaningful.
//!
//! `cargo bench --bench grids -- --record FILE.csv` writes the rows to a file.

mod maps;
mod peer;

use std::fmt::Write;
use std::time::Instant;

use inbye::global::{Heuristic, Searcher};
use inbye::map::{Cell, FreeSpace};
use maps::TimedMap;

/// Passes over each query; the best one counts.
const PASSES: usize = 3;

/// A search: returns the path's cost and the number of expansions.
type Search = fn(&mut Searcher, &TimedMap, Cell, Cell) -> (u64, u32);

/// The searches, with the reference first, and whether the cost must equal the reference's.
const SEARCHES: [(&str, bool, Search); 4] = [
    ("pathfinding astar", true, |_, course, start, goal| {
        peer::shortest(&course.obstacles, start, goal)
    }),
    ("A*, octile", true, |searcher, course, start, goal| {
        astar(searcher, &course.space, start, goal, Heuristic::Octile)
    }),
    ("A*, default", false, |searcher, course, start, goal| {
        astar(searcher, &course.space, start, goal, Heuristic::default())
    }),
    ("jump points", true, |searcher, course, start, goal| {
        let found = searcher.jump_points(&course.space, start, goal);
        found.map_or((u64::MAX, 0), |found| (found.cost, found.expanded))
    }),
];

fn astar(
    searcher: &mut Searcher,
    space: &FreeSpace,
    start: Cell,
    goal: Cell,
    heuristic: Heuristic,
) -> (u64, u32) {
    let found = searcher.astar(space, start, goal, heuristic, None);
    found.map_or((u64::MAX, 0), |found| (found.cost, found.expanded))
}

#[expect(clippy::print_stdout, reason = "a bench prints what it finds")]
fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let record = arguments
        .iter()
        .position(|argument| argument == "--record")
        .and_then(|place| arguments.get(place + 1));
    let mut rows =
        "map,queries,search,median_ms,p95_ms,max_ms,mean_expanded,times_faster\n".to_owned();
    for course in maps::courses() {
        println!("\n{}, {} queries", course.name, course.queries.len());
        println!(
            "  {:18} {:>10} {:>10} {:>10} {:>12} {:>8}",
            "", "median ms", "p95 ms", "max ms", "expanded", "faster"
        );
        let timed = time(&course);
        let base_ms = timed[0].quantile(0.5);
        for ((name, ..), timed) in SEARCHES.iter().zip(&timed) {
            let [median, p95, max] = [0.5, 0.95, 1.0].map(|share| timed.quantile(share));
            let expanded = timed.expanded / course.queries.len() as u64;
            let faster = base_ms / median;
            println!("  {name:18} {median:10.4} {p95:10.4} {max:10.4} {expanded:12} {faster:7.1}x");
            let queries = course.queries.len();
            writeln!(
                rows,
                "{},{queries},\"{name}\",{median:.5},{p95:.5},{max:.5},{expanded},{faster:.2}",
                course.name
            )
            .expect("text takes all");
        }
    }
    if let Some(file) = record {
        std::fs::write(file, rows).expect("the record can be written");
    }
}

/// The best time of each query, in ascending order, milliseconds.
struct Timed {
    times_ms: Vec<f64>,
    expanded: u64,
}

impl Timed {
    /// The time that this fraction of the queries does not exceed.
    fn quantile(&self, share: f64) -> f64 {
        let rank = (share * self.times_ms.len() as f64).ceil() as usize;
        self.times_ms[rank.max(1) - 1]
    }
}

fn time(course: &TimedMap) -> Vec<Timed> {
    let mut searcher = Searcher::default();
    let mut timed: Vec<Timed> =
        SEARCHES.iter().map(|_| Timed { times_ms: Vec::new(), expanded: 0 }).collect();
    for &(start, goal) in &course.queries {
        let (least, _) = peer::shortest(&course.obstacles, start, goal);
        let mut best_ms = [f64::INFINITY; SEARCHES.len()];
        for pass in 0..PASSES {
            for (number, (name, exact, search)) in SEARCHES.iter().enumerate() {
                let began = Instant::now();
                let (cost, expanded) = search(&mut searcher, course, start, goal);
                best_ms[number] = best_ms[number].min(began.elapsed().as_secs_f64() * 1e3);
                let right = if *exact { cost == least } else { cost >= least && cost < u64::MAX };
                assert!(right, "{name} from {start:?} to {goal:?}: {cost}, not {least}");
                if pass == 0 {
                    timed[number].expanded += u64::from(expanded);
                }
            }
        }
        for (timed, best_ms) in timed.iter_mut().zip(best_ms) {
            timed.times_ms.push(best_ms);
        }
    }
    for timed in &mut timed {
        timed.times_ms.sort_by(f64::total_cmp);
    }
    timed
}
