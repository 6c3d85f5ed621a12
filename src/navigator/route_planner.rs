//! Global planning for a robot, at two distances from walls, and through passages that only one heading fits.

use super::NavigatorSettings;
use super::obstacle_model::FIELD_CELL_M;
use crate::geometry::Point;
use crate::global::{
    self, ClearanceCosts, HeadingSearcher, Heuristic, Leg, Part, Plan, PlanError, PlanningSpace,
    Query, STRAIGHT, Searcher,
};
use crate::map::{FreeSpace, ObstacleGrid};
use crate::robot::Footprint;

/// A path need not keep the comfort margin within this many margins of start and goal: either may be anywhere that is safe,
/// and the path between them must not become worse by it.
const END_REACH_MARGINS: f64 = 4.0;

/// A robot that is caught at its start may pass obstacles more closely within this many least radii of the start.
const SQUEEZE_WITHIN_RADII: f64 = 3.0;
/// Distance of the robot's largest disc to obstacles on such a path, metres: the least margin of the local planner and its errors.
const SQUEEZING_MARGIN_M: f64 = 0.03;

/// Plans paths that keep a comfortable distance from walls where there is room, else the least safe distance. Where that leaves no
/// path, or only a big detour, a path may have narrow stretches ([`Plan::narrow`]).
#[derive(Clone, Debug)]
pub struct RoutePlanner {
    settings: global::Settings,
    searcher: Searcher,
    /// Finds narrow stretches; `None` for a body without a polygon.
    heading_searcher: Option<HeadingSearcher>,
    /// Terrain of the last plan, for the next one on the same map.
    terrain: Option<Terrain>,
    body_radius_m: f64,
    least_radius_m: f64,
    comfortable_radius_m: f64,
    squeezing_radius_m: f64,
    comfort_detour: f64,
}

/// Free space and costs of a map.
#[derive(Clone, Debug)]
struct Terrain {
    obstacles: ObstacleGrid,
    least: FreeSpace,
    comfortable: FreeSpace,
    costs: Option<ClearanceCosts>,
    /// The cells in which the robot fits with some heading, once they were needed.
    passable: Option<FreeSpace>,
}

/// What to plan, and the clock that times it.
struct Task<'a> {
    terrain: &'a mut Terrain,
    start: Point,
    /// Yaw of the robot at the start, radians, where it is known.
    start_yaw: Option<f64>,
    goal: Point,
    clock: &'a mut dyn FnMut() -> f64,
}

impl RoutePlanner {
    /// A planner for a robot, on maps of this resolution in metres.
    ///
    /// The least radius is that of the body's circumscribed circle plus the margin of the local planner.
    #[must_use]
    pub fn new(
        footprint: &Footprint,
        navigator: &NavigatorSettings,
        settings: global::Settings,
        resolution_m: f64,
    ) -> Self {
        let least_radius_m =
            footprint.body_radius_m() + navigator.safety_margin_m + lookup_margin_m(resolution_m);
        let comfortable_radius_m = least_radius_m + navigator.comfort_margin_m;
        Self {
            settings,
            searcher: Searcher::default(),
            heading_searcher: footprint
                .body()
                .map(|body| HeadingSearcher::new(body, navigator.safety_margin_m, resolution_m)),
            terrain: None,
            body_radius_m: footprint.max_disc_radius_m(),
            least_radius_m,
            comfortable_radius_m,
            squeezing_radius_m: footprint.max_disc_radius_m() + SQUEEZING_MARGIN_M,
            comfort_detour: navigator.comfort_detour,
        }
    }

    /// The same planner for a robot that drives backwards through narrow passages too, or not. By default it does not.
    #[must_use]
    pub const fn reversing(mut self, may_reverse: bool) -> Self {
        if let Some(searcher) = &mut self.heading_searcher {
            searcher.may_reverse = may_reverse;
        }
        self
    }

    /// The least distance between a path and an obstacle, metres, except on narrow stretches.
    #[must_use]
    pub const fn least_radius_m(&self) -> f64 {
        self.least_radius_m
    }

    /// Plans a path among obstacles, and keeps what depends only on them for the next plan. Times its stages by `clock`, in
    /// seconds.
    ///
    /// The path keeps the comfortable distance unless that makes it much longer. Where both paths had to be found to compare
    /// them, times and expanded cells are the sums.
    ///
    /// Where no such path exists, or only one that is a big detour, the path may lead through passages with room for the body at
    /// one heading.
    ///
    /// For a robot that stands nearer to an obstacle than a path may, but clear of it, the path begins at the nearest free
    /// point. Where no path leads on from there, the path may pass obstacles near the start as closely as the robot's own
    /// width allows: the robot leaves where it came in.
    ///
    /// # Errors
    /// When there is no path even at the least radius, and none through narrow passages.
    pub fn plan(
        &mut self,
        obstacles: &ObstacleGrid,
        start: Point,
        goal: Point,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<Plan, PlanError> {
        self.plan_from(obstacles, (start, None), goal, clock)
    }

    /// As [`Self::plan`], for a robot with this yaw at its start, radians, where it is known: a robot in a narrow passage can drive
    /// only along it.
    ///
    /// # Errors
    /// As [`Self::plan`].
    pub fn plan_from(
        &mut self,
        obstacles: &ObstacleGrid,
        (start, start_yaw): (Point, Option<f64>),
        goal: Point,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<Plan, PlanError> {
        let mut terrain = self.take_terrain(obstacles);
        let task = &mut Task { terrain: &mut terrain, start, start_yaw, goal, clock };
        let outcome = self.plan_on(task);
        self.terrain = Some(terrain);
        outcome
    }

    /// As [`Self::plan`], without narrow stretches.
    ///
    /// # Errors
    /// When there is no path even at the least radius.
    pub(super) fn plan_wide(
        &mut self,
        obstacles: &ObstacleGrid,
        start: Point,
        goal: Point,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<Plan, PlanError> {
        let mut terrain = self.take_terrain(obstacles);
        let task = &mut Task { terrain: &mut terrain, start, start_yaw: None, goal, clock };
        let outcome = match self.plan_open(task) {
            Err(error) if is_without_room(&error) => self.squeezed(task, error),
            outcome => outcome,
        };
        self.terrain = Some(terrain);
        outcome
    }

    /// The terrain of the last plan if its obstacles are these, else a new one.
    fn take_terrain(&mut self, obstacles: &ObstacleGrid) -> Terrain {
        let is_this = |terrain: &Terrain| terrain.obstacles == *obstacles;
        let terrain = self.terrain.take().filter(is_this);
        terrain.unwrap_or_else(|| self.terrain(obstacles))
    }

    fn terrain(&self, obstacles: &ObstacleGrid) -> Terrain {
        let radii_m = [self.least_radius_m, self.comfortable_radius_m];
        let [least, comfortable] = FreeSpace::for_radii(obstacles, radii_m);
        Terrain {
            obstacles: obstacles.clone(),
            least,
            comfortable,
            costs: self.settings.costs(obstacles),
            passable: None,
        }
    }

    fn plan_on(&mut self, task: &mut Task<'_>) -> Result<Plan, PlanError> {
        match self.plan_open(task) {
            Ok(plan) => {
                let most_m = plan.smoothed.length_m() / self.comfort_detour;
                let shorter = if self.may_be_shorter(task, most_m) {
                    self.plan_narrow(task, most_m)
                } else {
                    None
                };
                Ok(shorter.unwrap_or(plan))
            }
            Err(error) if is_without_room(&error) => {
                let narrow = self.plan_narrow(task, f64::INFINITY);
                narrow.map_or_else(|| self.squeezed(task, error), Ok)
            }
            Err(error) => Err(error),
        }
    }

    /// Whether a path of at most this length, metres, may lead through narrow passages.
    fn may_be_shorter(&mut self, task: &mut Task<'_>, most_m: f64) -> bool {
        // No path is shorter than the straight line.
        if most_m < (task.goal - task.start).norm() {
            return false;
        }
        let Some(passable) = self.passable(task.terrain) else {
            return false;
        };
        let frame = *passable.frame();
        let (Some(start), Some(goal)) = (frame.cell_of(&task.start), frame.cell_of(&task.goal))
        else {
            return false;
        };
        let found = self.searcher.astar(passable, start, goal, Heuristic::Octile, None);
        found.is_ok_and(|path| path.cost as f64 / STRAIGHT as f64 * frame.resolution_m <= most_m)
    }

    /// The cells in which the robot fits with some heading; `None` where all headings need the same room.
    fn passable<'a>(&self, terrain: &'a mut Terrain) -> Option<&'a FreeSpace> {
        let searcher = self.heading_searcher.as_ref()?;
        let obstacles = &terrain.obstacles;
        Some(terrain.passable.get_or_insert_with(|| searcher.passable(obstacles)))
    }

    /// A path with narrow stretches; `None` where there is none, or a longer one than this, metres.
    fn plan_narrow(&mut self, task: &mut Task<'_>, most_m: f64) -> Option<Plan> {
        self.passable(task.terrain)?;
        let Task { start, start_yaw, goal, .. } = *task;
        let began_s = (task.clock)();
        let terrain = &*task.terrain;
        let spaces = [&terrain.least, terrain.passable.as_ref()?];
        let query = Query { start, start_yaw, goal, most_m };
        let (legs, expanded) =
            self.heading_searcher.as_mut()?.find(&terrain.obstacles, spaces, &query);
        let legs = legs?;
        let searched_s = (task.clock)() - began_s;
        let (mut parts, mut from) = (Vec::with_capacity(legs.legs.len()), legs.start);
        for leg in legs.legs {
            let (Leg::Open { to } | Leg::Narrow { to, .. }) = leg;
            parts.push(match leg {
                Leg::Narrow { to, travel } => Part::Narrow { to, travel },
                Leg::Open { to } => {
                    let terrain = &mut *task.terrain;
                    let clock = &mut *task.clock;
                    let leg = &mut Task { terrain, start: from, start_yaw: None, goal: to, clock };
                    Part::Open(Box::new(self.plan_open(leg).ok()?))
                }
            });
            from = to;
        }
        let mut plan = global::joined(legs.start, parts);
        plan.expanded += expanded;
        plan.time_s.search += searched_s;
        Some(plan)
    }

    /// A path with room for every heading.
    fn plan_open(&mut self, task: &mut Task<'_>) -> Result<Plan, PlanError> {
        let (start, goal) = (task.start, task.goal);
        let least = &task.terrain.least;
        let mut comfortable = task.terrain.comfortable.clone();
        let margin_m = self.comfortable_radius_m - self.least_radius_m;
        for end in [start, goal] {
            comfortable.free_cells_near(least, &end, END_REACH_MARGINS * margin_m);
        }
        let detour = self.comfort_detour;
        let (terrain, clock) = (&*task.terrain, &mut *task.clock);
        let Ok(wide) = self.search(terrain, [&comfortable, least], [start, goal], clock) else {
            return self.search(terrain, [least, least], [start, goal], clock);
        };
        let is_detour = |shortest_m: f64| wide.smoothed.length_m() > detour * shortest_m;
        // No path is shorter than the straight line.
        if !is_detour((goal - start).norm()) {
            return Ok(wide);
        }
        let close = self.search(terrain, [least, least], [start, goal], clock)?;
        let (expanded, time_s) = (wide.expanded + close.expanded, wide.time_s + close.time_s);
        let chosen = if is_detour(close.smoothed.length_m()) { close } else { wide };
        Ok(Plan { expanded, time_s, ..chosen })
    }

    /// A path that may pass obstacles near its start more closely; the given error where there is none.
    fn squeezed(&mut self, task: &mut Task<'_>, error: PlanError) -> Result<Plan, PlanError> {
        let tight = FreeSpace::new(&task.terrain.obstacles, self.squeezing_radius_m);
        let mut space = task.terrain.least.clone();
        space.free_cells_near(&tight, &task.start, SQUEEZE_WITHIN_RADII * self.least_radius_m);
        let ends = [task.start, task.goal];
        self.search(task.terrain, [&space, &space], ends, task.clock).map_err(|_| error)
    }

    /// Searches in one free space, and smooths the path in another.
    fn search(
        &mut self,
        terrain: &Terrain,
        [search, smoothing]: [&FreeSpace; 2],
        [start, goal]: [Point; 2],
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<Plan, PlanError> {
        let ground = PlanningSpace { search, smoothing, costs: terrain.costs.as_ref() };
        let from = self.free_start(&terrain.obstacles, search, start);
        global::plan(&mut self.searcher, &ground, from, goal, &self.settings, clock)
    }

    /// The nearest free point to a start that is within a margin. Any free point beyond a wall is farther away.
    fn free_start(&self, obstacles: &ObstacleGrid, space: &FreeSpace, start: Point) -> Point {
        let frame = space.frame();
        let Some(cell) = frame.cell_of(&start) else {
            return start;
        };
        if space.is_free(cell) {
            return start;
        }
        let nearest = space.nearest_free(&start).map(|cell| frame.center_of(cell));
        let near = |point: &Point| (point - start).norm() < self.least_radius_m;
        let stands_clear = || FreeSpace::new(obstacles, self.body_radius_m).is_free(cell);
        nearest.filter(|point| near(point) && stands_clear()).unwrap_or(start)
    }
}

/// Whether a path may exist for a robot that takes less room.
const fn is_without_room(error: &PlanError) -> bool {
    matches!(error, PlanError::StartOccupied { .. } | PlanError::NoValidPath { .. })
}

/// What a path keeps for the lookup of clearances, metres. The local planner finds up to the diagonal of a cell of its window too
/// little clearance. Half a cell less suffices: the cells of a path are clear as a whole.
fn lookup_margin_m(resolution_m: f64) -> f64 {
    (core::f64::consts::SQRT_2 - 0.5) * resolution_m.min(FIELD_CELL_M)
}
