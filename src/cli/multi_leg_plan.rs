//! Plans a path through stops, leg by leg.

use inbye::geometry::Point;
use inbye::global::{
    self, Curvature, Path, PathClearance, Plan, PlanError, PlanningSpace, Searcher, StageTimes,
};
use inbye::map::{FreeSpace, ObstacleGrid};
use inbye::runtime::Config;

use super::arguments::PlanArguments;
use super::process::wall_clock;

/// Name of the last stop.
pub const GOAL: &str = "goal";

/// The plan from one stop to the next.
pub struct Leg {
    /// Requested start of the leg.
    pub from: Point,
    /// End of the leg.
    pub to: Point,
    /// The plan.
    pub plan: Plan,
    /// Smallest distance between its path and an obstacle, metres.
    pub clearance_m: f64,
}

/// The plan of all legs in order.
pub struct MultiLegPlan {
    /// At least one.
    pub legs: Vec<Leg>,
}

/// A leg that could not be planned.
pub struct LegFailure {
    /// The legs before it.
    pub legs: Vec<Leg>,
    /// Name of the stop that cannot be reached; none without intermediate stops.
    pub stop: Option<String>,
    /// The cause.
    pub error: PlanError,
}

impl LegFailure {
    /// The cause, preceded by the name of the stop.
    pub fn reason(&self) -> String {
        match &self.stop {
            Some(stop) => format!("{stop}: {}", self.error),
            None => self.error.to_string(),
        }
    }
}

/// Plans all legs, up to the first failure.
pub fn plan(
    arguments: &PlanArguments,
    config: &Config,
    obstacles: &ObstacleGrid,
) -> Result<MultiLegPlan, LegFailure> {
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
                let stop = stop_name(index, arguments.via.len());
                return Err(LegFailure { legs, stop, error });
            }
        };
        let clearances = clearances.get_or_insert_with(|| PathClearance::new(obstacles));
        let clearance_m = clearances.min_m(&plan.smoothed);
        legs.push(Leg { from, to, plan, clearance_m });
        from = to;
    }
    Ok(MultiLegPlan { legs })
}

/// Returns a function that plans one leg; all legs share its inflated maps.
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
            let space = PlanningSpace { search: &space, smoothing: &space, costs: costs.as_ref() };
            global::plan(&mut searcher, &space, from, to, &config.global, clock)
        });
    }
    let mut planner = config.route_planner(obstacles.frame().resolution_m);
    Box::new(move |from, to| planner.plan(obstacles, from, to, clock))
}

fn stop_name(index: usize, count: usize) -> Option<String> {
    (count > 0).then(|| if index < count { format!("via {}", index + 1) } else { GOAL.to_owned() })
}

/// Joins one stage of all legs to a path; none without legs.
pub fn joined(legs: &[Leg], stage: impl Fn(&Plan) -> &Path) -> Option<Path> {
    let points: Vec<Point> =
        legs.iter().flat_map(|leg| stage(&leg.plan).points()).copied().collect();
    (!points.is_empty()).then(|| Path::new(points))
}

impl MultiLegPlan {
    /// The whole path of one stage.
    pub fn stage(&self, stage: impl Fn(&Plan) -> &Path) -> Path {
        joined(&self.legs, stage).expect("there is a leg, and its path has a point")
    }

    /// Curvature of the whole path.
    pub fn curvature(&self) -> Curvature {
        Curvature::of(self.legs.iter().map(|leg| &leg.plan.spline))
    }

    /// Smallest distance between the path and an obstacle, metres.
    pub fn clearance_m(&self) -> f64 {
        let clearances = self.legs.iter().map(|leg| leg.clearance_m);
        clearances.fold(f64::INFINITY, f64::min)
    }

    /// Number of cells expanded by all searches.
    pub fn expanded(&self) -> u64 {
        self.legs.iter().map(|leg| u64::from(leg.plan.expanded)).sum()
    }

    /// Time of each stage over all legs, seconds.
    pub fn time_s(&self) -> StageTimes {
        let times = self.legs.iter().map(|leg| leg.plan.time_s);
        times.fold(StageTimes::default(), |sum, time_s| sum + time_s)
    }
}
