//! A plan through stops: its legs, its figures, and both as text and JSON.

use inbye::geometry::Point;
use inbye::global::{
    self, Curvature, Path, PathClearance, Plan, PlanError, PlanningSpace, Searcher, StageTimes,
};
use inbye::map::{FreeSpace, ObstacleGrid};
use inbye::navigator::GlobalPlanner;
use inbye::runtime::{Config, RobotConfig};
use serde_json::{Value, json};

use super::arguments::Place;
use super::machine::wall_clock;

/// The plan from one stop to the next.
pub struct Leg {
    /// Requested start of the leg.
    from: Point,
    /// End of the leg.
    to: Point,
    plan: Plan,
    /// Smallest distance between its path and an obstacle, metres.
    clearance_m: f64,
}

/// A leg that could not be planned.
pub struct LegFailure {
    /// The stop that cannot be reached, counted from 1; none for the goal.
    pub via: Option<usize>,
    /// Name of that stop; none without intermediate stops.
    pub stop: Option<String>,
    /// The cause.
    pub error: PlanError,
}

/// The name of an intermediate stop, counted from 1.
pub fn stop_name(number: usize) -> String {
    format!("stop {number} of --via")
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

/// The legs up to the first failure, and the figures of the whole path.
pub struct PlanResult {
    pub legs: Vec<Leg>,
    /// Why the next leg could not be planned.
    pub failure: Option<LegFailure>,
    /// The path before pruning; only the start without legs, like the other two.
    pub raw: Path,
    /// The path before smoothing.
    pub pruned: Path,
    /// The path to drive.
    pub smoothed: Path,
    /// Smallest distance between the path and an obstacle, metres.
    pub clearance_m: f64,
    /// Number of cells expanded by all searches.
    expanded: u64,
    /// Time of each stage over all legs, seconds.
    time_s: StageTimes,
    pub curvature: CurvatureCheck,
    is_optimal: bool,
    /// The program that planned in place of inbye.
    program: Option<String>,
}

/// What to plan.
pub struct PlanTask<'a> {
    pub start: Place,
    pub goal: Place,
    /// The intermediate stops.
    pub via: &'a [Place],
    /// Distance to keep from obstacles, metres; by default that of the robot.
    pub radius_m: Option<f64>,
}

/// Plans all legs, up to the first failure.
pub fn plan(task: &PlanTask<'_>, config: &Config, obstacles: &ObstacleGrid) -> PlanResult {
    let start = task.start.position;
    let (legs, failure) = plan_legs(task, config, obstacles);
    let joined = |stage: fn(&Plan) -> &Path| {
        let points = legs.iter().flat_map(|leg| stage(&leg.plan).points());
        let points: Vec<Point> = points.copied().collect();
        Path::new(if points.is_empty() { vec![start] } else { points })
    };
    let curvature = Curvature::of(legs.iter().map(|leg| &leg.plan.spline));
    let times = legs.iter().map(|leg| leg.plan.time_s);
    PlanResult {
        raw: joined(|plan| &plan.raw),
        pruned: joined(|plan| &plan.pruned),
        smoothed: joined(|plan| &plan.smoothed),
        clearance_m: legs.iter().map(|leg| leg.clearance_m).fold(f64::INFINITY, f64::min),
        expanded: legs.iter().map(|leg| u64::from(leg.plan.expanded)).sum(),
        time_s: times.fold(StageTimes::default(), |sum, time_s| sum + time_s),
        curvature: CurvatureCheck::new(&curvature, &config.robot),
        is_optimal: config.global.is_optimal() && !config.global_planner.is_set(),
        program: config.global_planner.name(),
        legs,
        failure,
    }
}

fn plan_legs(
    task: &PlanTask<'_>,
    config: &Config,
    obstacles: &ObstacleGrid,
) -> (Vec<Leg>, Option<LegFailure>) {
    let mut clock = wall_clock();
    let mut planner = match planner(task, config, obstacles, &mut clock) {
        Ok(planner) => planner,
        Err(error) => return (Vec::new(), Some(LegFailure { via: None, stop: None, error })),
    };
    let mut from = task.start.position;
    let (mut plans, mut failure) = (Vec::new(), None);
    for (index, stop) in task.via.iter().chain([&task.goal]).enumerate() {
        let to = stop.position;
        match planner(from, to) {
            Ok(plan) => plans.push((from, to, plan)),
            Err(error) => {
                let count = task.via.len();
                let via = (index < count).then_some(index + 1);
                let name = via.map_or_else(|| "goal".to_owned(), stop_name);
                let stop = (count > 0).then_some(name);
                failure = Some(LegFailure { via, stop, error });
                break;
            }
        }
        from = to;
    }
    // On a large map, search and clearances take most of the memory: one after the other.
    drop(planner);
    if plans.is_empty() {
        return (Vec::new(), failure);
    }
    let clearances = PathClearance::new(obstacles);
    let leg = |(from, to, plan): (Point, Point, Plan)| {
        let clearance_m = clearances.min_m(&plan.smoothed);
        Leg { from, to, plan, clearance_m }
    };
    (plans.into_iter().map(leg).collect(), failure)
}

/// Plans one leg from a point to another.
type LegPlanner<'a> = Box<dyn FnMut(Point, Point) -> Result<Plan, PlanError> + 'a>;

/// Returns a function that plans one leg; all legs share its inflated maps, or its program.
fn planner<'a>(
    task: &PlanTask<'_>,
    config: &'a Config,
    obstacles: &'a ObstacleGrid,
    clock: &'a mut dyn FnMut() -> f64,
) -> Result<LegPlanner<'a>, PlanError> {
    let mut own = config.route_planner(obstacles.frame().resolution_m);
    let radius_m = task.radius_m.unwrap_or(own.least_radius_m());
    if let Some(mut program) = config.start_global_planner(radius_m)? {
        return Ok(Box::new(move |from, to| program.plan(obstacles, &[], from, to, clock)));
    }
    if let Some(radius_m) = task.radius_m {
        let space = FreeSpace::new(obstacles, radius_m);
        let costs = config.global.costs(obstacles);
        let mut searcher = Searcher::default();
        return Ok(Box::new(move |from, to| {
            let space = PlanningSpace { search: &space, smoothing: &space, costs: costs.as_ref() };
            global::plan(&mut searcher, &space, from, to, &config.global, clock)
        }));
    }
    Ok(Box::new(move |from, to| own.plan(obstacles, from, to, clock)))
}

impl PlanResult {
    /// The JSON object.
    pub fn object(&self) -> Value {
        let stage = |path: &Path| {
            let points = path.points().len();
            json!({ "length_m": path.length_m(), "points": points, "turns": path.turns() })
        };
        let smoothed = &self.smoothed;
        json!({
            "found": true,
            "path": smoothed.points(),
            "length_m": smoothed.length_m(),
            "turns": smoothed.turns(),
            "raw": stage(&self.raw),
            "pruned": stage(&self.pruned),
            "min_clearance_m": finite(self.clearance_m),
            "expanded": self.expanded,
            "exact": self.is_optimal,
            "global_planner": self.program,
            "time_ms": times(&self.time_s),
            "curvature": self.curvature.object(),
            "legs": self.legs.iter().map(Leg::object).collect::<Vec<_>>(),
        })
    }

    /// The lines of text.
    pub fn lines(&self) -> Vec<String> {
        let stages =
            [("searched", &self.raw), ("pruned", &self.pruned), ("smoothed", &self.smoothed)];
        let stage = |(name, path): (&str, &Path)| {
            let (length_m, points, turns) = (path.length_m(), path.points().len(), path.turns());
            format!("{name:9} {length_m:8.2} m  {points:5} points  {turns:3} turns")
        };
        let mut lines: Vec<String> = match &self.program {
            Some(_) => vec![stage(("path", &self.smoothed))],
            None => stages.into_iter().map(stage).collect(),
        };
        lines.push(if self.clearance_m.is_finite() {
            format!("clearance {:8.3} m at the narrowest", self.clearance_m)
        } else {
            "clearance no obstacle on the map".to_owned()
        });
        lines.push(self.curvature.line());
        lines.push(self.time_line());
        if self.legs.len() > 1 {
            lines.push(String::new());
            lines.push(format!(
                "{:>3}  {:20} {:20} {:>10} {:>5} {:>11} {:>9} {:>9}",
                "leg", "from", "to", "length, m", "turns", "clear, m", "expanded", "time, ms"
            ));
            lines.extend(self.legs.iter().enumerate().map(|(index, leg)| leg.line(index + 1)));
        }
        lines
    }

    /// The line of text about the search.
    fn time_line(&self) -> String {
        let StageTimes { search, prune, smooth } = self.time_s;
        if let Some(program) = &self.program {
            return format!("planned by {program} in {:.2} ms", search * 1e3);
        }
        let optimality = if self.is_optimal { "a shortest path" } else { "near a shortest path" };
        format!(
            "search {:.2} ms ({} cells expanded, {optimality}), prune {:.2} ms, smooth {:.2} ms",
            search * 1e3,
            self.expanded,
            prune * 1e3,
            smooth * 1e3,
        )
    }
}

impl Leg {
    fn object(&self) -> Value {
        json!({
            "from": self.from,
            "to": self.to,
            "length_m": self.plan.smoothed.length_m(),
            "turns": self.plan.smoothed.turns(),
            "min_clearance_m": finite(self.clearance_m),
            "expanded": self.plan.expanded,
            "time_ms": times(&self.plan.time_s),
        })
    }

    fn line(&self, number: usize) -> String {
        let place = |at: &Point| format!("({:.2}, {:.2})", at.x, at.y);
        let clearance = finite(self.clearance_m);
        let clearance = clearance.map_or_else(|| "-".to_owned(), |metres| format!("{metres:.3}"));
        format!(
            "{number:3}  {:20} {:20} {:10.2} {:5} {clearance:>11} {:9} {:9.2}",
            place(&self.from),
            place(&self.to),
            self.plan.smoothed.length_m(),
            self.plan.smoothed.turns(),
            self.plan.expanded,
            total_ms(&self.plan.time_s),
        )
    }
}

/// A number; none for an infinite distance.
fn finite(number: f64) -> Option<f64> {
    number.is_finite().then_some(number)
}

fn times(of: &StageTimes) -> Value {
    json!({
        "search": of.search * 1e3,
        "prune": of.prune * 1e3,
        "smooth": of.smooth * 1e3,
        "total": total_ms(of),
    })
}

fn total_ms(of: &StageTimes) -> f64 {
    (of.search + of.prune + of.smooth) * 1e3
}

/// A path's curvature compared with a base's limits.
pub struct CurvatureCheck {
    max_per_m: f64,
    /// Number of bends that the robot can only turn in place.
    pub sharp_turns: usize,
    /// Highest speed, m/s.
    max_speed: f64,
    /// Highest curvature at that speed, 1/m; infinite for a base that does not drive forward.
    limit_per_m: f64,
    within_limit_share: f64,
    slowest: f64,
}

impl CurvatureCheck {
    /// Compares a path's curvature with a robot's limits.
    fn new(curvature: &Curvature, robot: &RobotConfig) -> Self {
        let (drive, limits) = (robot.drive(), &robot.limits);
        let (max_speed, turn_rate) = (limits.max_vel_x, limits.max_vel_theta);
        let top_track = drive.top_track_speed(limits);
        let limit_per_m = if max_speed > 0.0 {
            drive.max_curvature(max_speed, top_track, turn_rate)
        } else {
            f64::INFINITY
        };
        let max_per_m = curvature.max_per_m();
        let slowest = if curvature.sharp_turns > 0 {
            0.0
        } else if max_per_m > limit_per_m {
            drive.max_speed(max_per_m, top_track, turn_rate).min(max_speed)
        } else {
            max_speed
        };
        Self {
            max_per_m,
            sharp_turns: curvature.sharp_turns,
            max_speed,
            limit_per_m,
            within_limit_share: curvature.fraction_within(limit_per_m),
            slowest,
        }
    }

    /// The JSON object.
    fn object(&self) -> Value {
        json!({
            "max_per_m": self.max_per_m,
            "min_radius_m": self.min_radius_m(),
            "sharp_turns": self.sharp_turns,
            "limit_per_m": self.limit_per_m.is_finite().then_some(self.limit_per_m),
            "within_limit_share": self.within_limit_share,
            "slowest_speed_mps": self.slowest,
        })
    }

    /// The line of text.
    fn line(&self) -> String {
        let bends = match self.min_radius_m() {
            Some(radius_m) => {
                format!("{:8.3} 1/m at the tightest, radius {radius_m:.2} m", self.max_per_m)
            }
            None => "   0.000 1/m".to_owned(),
        };
        let turns = match self.sharp_turns {
            0 => "no sharp turn".to_owned(),
            1 => "1 sharp turn, in place".to_owned(),
            sharp => format!("{sharp} sharp turns, in place"),
        };
        let followed = if self.within_limit_share == 1.0 {
            let what = if self.sharp_turns == 0 { "all" } else { "the rest" };
            format!("{what} followed at {:.2} m/s", self.max_speed)
        } else {
            let (percent, max_speed) = (self.within_limit_share * 100.0, self.max_speed);
            let share = format!("{percent:.1} % followed at {max_speed:.2} m/s");
            if self.slowest > 0.0 {
                format!("{share}, all at {:.2} m/s", self.slowest)
            } else {
                share
            }
        };
        format!("curvature {bends}; {turns}; {followed}")
    }

    /// Radius of the tightest bend, metres; none for a straight path.
    fn min_radius_m(&self) -> Option<f64> {
        (self.max_per_m > 0.0).then(|| self.max_per_m.recip())
    }
}
