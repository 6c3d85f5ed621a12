//! A path by way of stops, planned leg by leg.

use inbye::geometry::Point;
use inbye::global::{
    self, Curvature, Path, PathClearance, Plan, PlanError, PlanningSpace, Searcher, StageTimes,
};
use inbye::map::{FreeSpace, ObstacleGrid};
use inbye::runtime::Config;

use super::arguments::PlanArguments;
use super::clock::wall_clock;

/// The name of the last stop.
pub const GOAL: &str = "goal";

/// The way from one stop to the next.
pub struct Leg {
    /// Where it was asked to begin.
    pub from: Point,
    /// Where it ends.
    pub to: Point,
    /// How to get there.
    pub plan: Plan,
    /// Smallest distance between its path and an obstacle, metres.
    pub clearance_m: f64,
}

/// The legs in order.
pub struct Tour {
    /// At least one.
    pub legs: Vec<Leg>,
}

/// A tour that cannot be.
pub struct Refused {
    /// The legs before the one that cannot be.
    pub legs: Vec<Leg>,
    /// The stop that cannot be reached, as the user knows it: none where there are no stops but start and goal.
    pub stop: Option<String>,
    /// Why.
    pub error: PlanError,
}

impl Refused {
    /// Why, with the stop in front.
    pub fn reason(&self) -> String {
        match &self.stop {
            Some(stop) => format!("{stop}: {}", self.error),
            None => self.error.to_string(),
        }
    }
}

/// Plans all legs, up to the first that cannot be.
pub fn plan(
    arguments: &PlanArguments,
    config: &Config,
    obstacles: &ObstacleGrid,
) -> Result<Tour, Refused> {
    let mut clock = wall_clock();
    let mut planner = planner(arguments, config, obstacles, &mut clock);
    let stops = arguments.via.iter().chain([&arguments.goal]);
    let mut from = arguments.start.position;
    let mut legs = Vec::new();
    let mut clearances = None;
    for (index, stop) in stops.enumerate() {
        let to = stop.position;
        let plan = match planner(from, to) {
            Ok(plan) => plan,
            Err(error) => {
                let stop = name_of(index, arguments.via.len());
                return Err(Refused { legs, stop, error });
            }
        };
        let clearances = clearances.get_or_insert_with(|| PathClearance::new(obstacles));
        let clearance_m = clearances.min_m(&plan.smoothed);
        legs.push(Leg {
            from,
            to,
            plan,
            clearance_m,
        });
        from = to;
    }
    Ok(Tour { legs })
}

/// Plans one leg; what all legs share is made once.
fn planner<'a>(
    arguments: &PlanArguments,
    config: &'a Config,
    obstacles: &'a ObstacleGrid,
    clock: &'a mut dyn FnMut() -> f64,
) -> Box<dyn FnMut(Point, Point) -> Result<Plan, PlanError> + 'a> {
    if let Some(radius_m) = arguments.radius {
        let space = FreeSpace::new(obstacles, radius_m);
        let costs = config.global.costs(obstacles);
        let mut searcher = Searcher::default();
        return Box::new(move |from, to| {
            let ground = PlanningSpace {
                search: &space,
                smoothing: &space,
                costs: costs.as_ref(),
            };
            global::plan(&mut searcher, &ground, from, to, &config.global, clock)
        });
    }
    let mut planner = config.route_planner(obstacles.frame().resolution_m);
    Box::new(move |from, to| planner.plan(obstacles, from, to, clock))
}

fn name_of(stop: usize, count: usize) -> Option<String> {
    (count > 0).then(|| {
        if stop < count {
            format!("via {}", stop + 1)
        } else {
            GOAL.to_owned()
        }
    })
}

/// One path of all legs, through one of its stages; none of no legs.
pub fn joined(legs: &[Leg], stage: impl Fn(&Plan) -> &Path) -> Option<Path> {
    let points: Vec<Point> = legs
        .iter()
        .flat_map(|leg| stage(&leg.plan).points())
        .copied()
        .collect();
    (!points.is_empty()).then(|| Path::new(points))
}

impl Tour {
    /// The whole path through one of its stages.
    pub fn stage(&self, stage: impl Fn(&Plan) -> &Path) -> Path {
        joined(&self.legs, stage).expect("a tour has a leg, and its path a point")
    }

    /// How the whole path bends.
    pub fn curvature(&self) -> Curvature {
        Curvature::of(self.legs.iter().map(|leg| &leg.plan.spline))
    }

    /// Smallest distance between the path and an obstacle, metres.
    pub fn clearance_m(&self) -> f64 {
        let clearances = self.legs.iter().map(|leg| leg.clearance_m);
        clearances.fold(f64::INFINITY, f64::min)
    }

    /// Cells expanded by all searches.
    pub fn expanded(&self) -> u64 {
        self.legs
            .iter()
            .map(|leg| u64::from(leg.plan.expanded))
            .sum()
    }

    /// Time of each stage over all legs, seconds.
    pub fn time_s(&self) -> StageTimes {
        let times = self.legs.iter().map(|leg| leg.plan.time_s);
        times.fold(StageTimes::default(), |sum, time_s| sum + time_s)
    }
}
