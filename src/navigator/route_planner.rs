//! Global planning for a robot, at two distances from walls.

use super::narrow_passages::NarrowPassages;
use super::obstacle_model::FIELD_CELL_M;
use super::{GlobalPlanner, NavigatorSettings};
use crate::geometry::Point;
use crate::global::{
    self, BodySpace, ClearanceCosts, Plan, PlanError, PlanningSpace, SearchMethod, Searcher,
    free_goal_cell, nearest_free, nearest_reachable_within,
};
use crate::map::{Cell, FreeSpace, MovingDisc, ObstacleGrid};
use crate::robot::Footprint;
use crate::settings::{SettingError, require};

/// Within this many margins of start and goal, a path need not keep the comfort margin. Start and goal may be at any safe place, and
/// this must not make the path between them worse.
const END_REACH_MARGINS: f64 = 4.0;

/// A robot that is caught at its start may pass obstacles more closely within this many least radii of the start.
const SQUEEZE_WITHIN_RADII: f64 = 3.0;
/// Distance to obstacles on such a path, metres: the least margin of the local planner and its errors.
const SQUEEZING_MARGIN_M: f64 = 0.03;

/// Additional cost next to an obstacle on a path through narrow passages.
const NARROW_WEIGHT: f64 = 15.0;

/// Plans paths that keep a comfortable distance from walls where there is room, else the least safe distance.
#[derive(Clone, Debug)]
pub struct RoutePlanner {
    settings: global::Settings,
    /// Whether the settings of the navigator and the resolution are in range: the first plan says so.
    checked: Result<(), SettingError>,
    searcher: Searcher,
    /// Terrain of the last plan, for the next one on the same map.
    terrain: Option<Terrain>,
    inscribed_radius_m: f64,
    least_radius_m: f64,
    comfortable_radius_m: f64,
    squeezing_radius_m: f64,
    comfort_detour: f64,
    /// `None` for a robot that is as wide as long.
    narrow: Option<NarrowPassages>,
}

/// Free space and costs of a map.
#[derive(Clone, Debug)]
struct Terrain {
    obstacles: ObstacleGrid,
    least: FreeSpace,
    comfortable: FreeSpace,
    costs: Option<ClearanceCosts>,
}

/// The body in narrow passages, and where it fits.
struct NarrowTerrain {
    passages: NarrowPassages,
    /// Cells in which a disc of the body keeps its distance wherever it is, at the centre, and at some place.
    whole: FreeSpace,
    space: FreeSpace,
    partial: FreeSpace,
    costs: ClearanceCosts,
}

impl NarrowTerrain {
    fn body<'a>(&'a self, wide: &'a FreeSpace) -> BodySpace<'a> {
        let (discs, radius_m) = (&self.passages.discs[..], self.passages.radius_m);
        let NarrowTerrain { whole, space: narrow, partial, .. } = self;
        BodySpace { discs, radius_m, whole, narrow, partial, wide }
    }
}

/// What to plan, and the clock that times it.
struct Task<'a> {
    terrain: &'a Terrain,
    transient: &'a [MovingDisc],
    start: Point,
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
        let is_valid = resolution_m.is_finite() && resolution_m > 0.0;
        let resolution = require(is_valid, "resolution_m", resolution_m, "finite and above zero");
        let checked = navigator.validate().map_err(|error| error.in_table("navigator"));
        Self {
            settings,
            checked: checked.and(resolution),
            searcher: Searcher::default(),
            terrain: None,
            inscribed_radius_m: footprint.inscribed_radius_m(),
            least_radius_m,
            comfortable_radius_m,
            squeezing_radius_m: footprint.passing_radius_m() + SQUEEZING_MARGIN_M,
            comfort_detour: navigator.comfort_detour,
            narrow: NarrowPassages::new(footprint, navigator, resolution_m, least_radius_m),
        }
    }

    /// The least distance between a path and an obstacle, metres.
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
    /// For a robot that stands nearer to an obstacle than a path may, but clear of it, the path begins at the nearest free
    /// point. Where no path leads on from there, the path may pass obstacles near the start as closely as the robot's own
    /// width allows: the robot leaves where it came in.
    ///
    /// The circle around the robot may fit on no path, not at the start or the goal, or only on a much longer path. Then the path may
    /// lead through passages that the robot fits only lengthwise.
    ///
    /// # Errors
    /// When a setting or the resolution is out of range, or there is no path even at the least radius.
    pub fn plan(
        &mut self,
        obstacles: &ObstacleGrid,
        start: Point,
        goal: Point,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<Plan, PlanError> {
        GlobalPlanner::plan(self, obstacles, &[], start, goal, clock)
    }

    fn terrain(&self, obstacles: &ObstacleGrid) -> Terrain {
        let radii_m = [self.least_radius_m, self.comfortable_radius_m];
        let [least, comfortable] = FreeSpace::for_radii(obstacles, radii_m);
        Terrain {
            obstacles: obstacles.clone(),
            least,
            comfortable,
            costs: self.settings.costs(obstacles),
        }
    }

    /// The narrow passages of a task; none for a robot that is as wide as long.
    fn narrow_terrain(&self, task: &Task<'_>) -> Option<NarrowTerrain> {
        let passages = self.narrow.clone()?;
        let obstacles = &task.terrain.obstacles;
        let [whole, space, partial] = passages.spaces(obstacles, task.transient);
        // Through the middle of a passage, and not round its corner.
        let costs = ClearanceCosts::new(obstacles, self.comfortable_radius_m, NARROW_WEIGHT);
        Some(NarrowTerrain { passages, whole, space, partial, costs })
    }

    fn plan_on(&mut self, task: &mut Task<'_>) -> Result<Plan, PlanError> {
        let (terrain, start, goal) = (task.terrain, task.start, task.goal);
        let least = &terrain.least;
        let mut comfortable = terrain.comfortable.clone();
        let margin_m = self.comfortable_radius_m - self.least_radius_m;
        for end in [start, goal] {
            comfortable.free_cells_near(least, &end, END_REACH_MARGINS * margin_m);
        }
        let detour = self.comfort_detour;
        let Ok(wide) = self.search(task, [&comfortable, least]) else {
            return self.search(task, [least, least]);
        };
        let is_detour = |shortest_m: f64| wide.smoothed.length_m() > detour * shortest_m;
        // No path is shorter than the straight line.
        if !is_detour((goal - start).norm()) {
            return Ok(wide);
        }
        let close = self.search(task, [least, least])?;
        let (expanded, time_s) = (wide.expanded + close.expanded, wide.time_s + close.time_s);
        let chosen = if is_detour(close.smoothed.length_m()) { close } else { wide };
        Ok(Plan { expanded, time_s, ..chosen })
    }

    /// A path through narrow passages where there is no other one, or only a much longer one; else the other one. Where there is
    /// neither, one that leaves a tight place.
    fn narrow_if_better(
        &mut self,
        task: &mut Task<'_>,
        usual: Result<Plan, PlanError>,
    ) -> Result<Plan, PlanError> {
        let straight_m = (task.goal - task.start).norm();
        let length_m = match &usual {
            Ok(plan) => plan.smoothed.length_m(),
            Err(
                PlanError::NoValidPath { .. }
                | PlanError::StartOccupied { .. }
                | PlanError::GoalOccupied { .. },
            ) => f64::INFINITY,
            Err(_) => straight_m,
        };
        let detour = self.comfort_detour;
        let is_far = length_m > detour * straight_m;
        let Some(ground) = is_far.then(|| self.narrow_terrain(task)).flatten() else {
            return usual.or_else(|error| self.squeezed(task, error));
        };
        let is_better = |plan: &Plan| detour * plan.smoothed.length_m() < length_m;
        let nearest = match self.narrow(task, &ground) {
            Ok(plan) if is_better(&plan) => return Ok(plan),
            Ok(_) => None,
            Err(nearest) => nearest,
        };
        usual
            .or_else(|error| self.squeezed(task, error))
            .map_err(|error| self.with_narrow_passages(task, &ground, nearest, error))
    }

    /// The error of a search without narrow passages, as it is with them: start or goal may be in such a passage, and the reachable
    /// point nearest to the goal beyond some. `reached` is that point, where the search for the body has found it.
    fn with_narrow_passages(
        &mut self,
        task: &mut Task<'_>,
        ground: &NarrowTerrain,
        reached: Option<Point>,
        error: PlanError,
    ) -> PlanError {
        let (Terrain { obstacles, least, .. }, space) = (task.terrain, &ground.space);
        let (start, goal, frame) = (task.start, task.goal, *space.frame());
        let fits = |place: &Point| ground.body(least).fits(place);
        let (expanded, nearest) = match &error {
            PlanError::NoValidPath { expanded, nearest, .. } => (*expanded, *nearest),
            PlanError::GoalOccupied { .. } if fits(&goal) => (0, None),
            PlanError::StartOccupied { .. } if fits(&start) => match free_goal_cell(space, goal) {
                Ok(_) => (0, None),
                Err(error) => return error,
            },
            _ => return error,
        };
        let from_goal = |place: &Point| (goal - *place).norm();
        // Where not even the discs reach the goal, the search for the body has not run: a place that the discs reach may do.
        let by_discs = || {
            let from = frame.cell_of(&self.free_start(obstacles, space, start))?;
            let cell = nearest_reachable_within(space, least, from, &goal)?;
            Some(frame.center_of(cell))
        };
        let beyond = reached
            .or_else(by_discs)
            .filter(|place| nearest.is_none_or(|nearest| from_goal(place) < from_goal(&nearest)))
            .filter(|place| {
                let (terrain, transient) = (task.terrain, task.transient);
                let task =
                    &mut Task { goal: *place, clock: &mut *task.clock, start, terrain, transient };
                // The usual search has just found nothing nearer.
                let is_usual = nearest.is_none() && self.plan_on(task).is_ok();
                is_usual || self.narrow(task, ground).is_ok()
            });
        let (nearest, turning_m) = (beyond.or(nearest), self.least_radius_m);
        if let PlanError::GoalOccupied { place, .. } = error {
            let hint = nearest.map_or_else(String::new, |Point { x, y }| {
                format!("; the reachable point nearest to it is ({x:.3}, {y:.3})")
            });
            let near = frame.cell_of(&place).map(|cell| global::too_near(&frame, cell, turning_m));
            let why = format!(
                "{}: the robot cannot turn there, and no path ends in a direction in which it fits{hint}",
                near.unwrap_or_default()
            );
            return PlanError::GoalOccupied { place, why };
        }
        PlanError::NoValidPath {
            start,
            goal,
            radius_m: ground.passages.radius_m,
            turning_radius_m: Some(turning_m),
            expanded,
            nearest,
            reason: None,
        }
    }

    /// A path through narrow passages on which the robot fits. Without one: the reachable point nearest to the goal, where a search
    /// for the body has found it.
    fn narrow(
        &mut self,
        task: &mut Task<'_>,
        ground: &NarrowTerrain,
    ) -> Result<Plan, Option<Point>> {
        let (body, costs) = (&ground.body(&task.terrain.least), &ground.costs);
        let mut of_discs = Vec::new();
        for start in self.narrow_starts(task, ground) {
            let Some(plan) = self.discs_plan(start, task, body, costs) else { continue };
            if body.fits_along(plan.smoothed.points()) {
                return Ok(plan);
            }
            let near = body.path_near(&plan.raw, costs);
            if let Some(path) = near.filter(|path| body.fits_along(path.points())) {
                return Ok(plan.along(path));
            }
            of_discs.push((start, plan));
        }
        // The discs pass where the body cannot head along its way. The body may fit on another way, far from that of the discs.
        let from_goal = |place: &Point| (task.goal - *place).norm();
        let mut nearest = None;
        for (start, plan) in of_discs {
            match body.path_anywhere([start, task.goal], costs) {
                Ok(path) if body.fits_along(path.points()) => return Ok(plan.along(path)),
                Ok(_) => {}
                Err(reached) => {
                    let places = nearest.into_iter().chain(reached);
                    nearest =
                        places.min_by(|one, other| from_goal(one).total_cmp(&from_goal(other)));
                }
            }
        }
        Err(nearest)
    }

    /// The places at which a path through narrow passages may begin. A robot that stands where its body cannot turn may also begin at
    /// the nearest place where it can, as on other paths.
    fn narrow_starts(
        &self,
        task: &Task<'_>,
        ground: &NarrowTerrain,
    ) -> impl Iterator<Item = Point> + use<> {
        let Terrain { obstacles, least, .. } = task.terrain;
        let start = self.free_start(obstacles, &ground.space, task.start);
        let turning = self.free_start(obstacles, least, task.start);
        core::iter::once(start).chain((turning != start).then_some(turning))
    }

    /// The path of the discs of a body that has any heading.
    fn discs_plan(
        &mut self,
        start: Point,
        task: &mut Task<'_>,
        body: &BodySpace<'_>,
        costs: &ClearanceCosts,
    ) -> Option<Plan> {
        let space = body.narrow;
        let ground = PlanningSpace { search: space, smoothing: space, costs: Some(costs) };
        let settings = global::Settings { search: SearchMethod::AStar, ..self.settings.clone() };
        let plan =
            global::plan(&mut self.searcher, &ground, start, task.goal, &settings, task.clock);
        Some(Plan { radius_m: body.radius_m, ..plan.ok()? })
    }

    /// A path that may pass obstacles near its start more closely; the given error where there is none.
    fn squeezed(&mut self, task: &mut Task<'_>, error: PlanError) -> Result<Plan, PlanError> {
        if !matches!(error, PlanError::StartOccupied { .. } | PlanError::NoValidPath { .. }) {
            return Err(error);
        }
        let tight = FreeSpace::new(&task.terrain.obstacles, self.squeezing_radius_m);
        let mut space = task.terrain.least.clone();
        space.free_cells_near(&tight, &task.start, SQUEEZE_WITHIN_RADII * self.least_radius_m);
        // The robot leaves such a place as it drives through a narrow passage.
        let radius_m = self.squeezing_radius_m;
        self.search(task, [&space, &space]).map(|plan| Plan { radius_m, ..plan }).map_err(|_| error)
    }

    /// Searches in one free space, and smooths the path in another.
    fn search(
        &mut self,
        task: &mut Task<'_>,
        [search, smoothing]: [&FreeSpace; 2],
    ) -> Result<Plan, PlanError> {
        let terrain = task.terrain;
        let ground = PlanningSpace { search, smoothing, costs: terrain.costs.as_ref() };
        let from = self.free_start(&terrain.obstacles, search, task.start);
        let planned =
            global::plan(&mut self.searcher, &ground, from, task.goal, &self.settings, task.clock);
        planned.map_err(|error| self.with_start_criterion(&terrain.obstacles, search, error))
    }

    /// The error of a start, with the distance that a start needs: a robot may begin nearer to obstacles than its path.
    fn with_start_criterion(
        &self,
        obstacles: &ObstacleGrid,
        space: &FreeSpace,
        error: PlanError,
    ) -> PlanError {
        let PlanError::StartOccupied { place, why } = error else {
            return error;
        };
        let cell = space.frame().cell_of(&place).filter(|cell| !space.is_obstacle(*cell));
        let Some(cell) = cell.filter(|cell| !self.stands_clear(obstacles, *cell)) else {
            return PlanError::StartOccupied { place, why };
        };
        let near = global::too_near(space.frame(), cell, self.inscribed_radius_m);
        let hint = nearest_free(space, &place);
        let why = format!("{near}, too near for the robot at any yaw: {hint}");
        PlanError::StartOccupied { place, why }
    }

    /// The nearest free point to a start that is within a margin. Any free point beyond a wall is farther away.
    ///
    /// The yaw of the robot is not known here. At every yaw, the circle within its body must have room.
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
        nearest.filter(|point| near(point) && self.stands_clear(obstacles, cell)).unwrap_or(start)
    }

    /// Whether the circle within the robot's body has room in a cell.
    fn stands_clear(&self, obstacles: &ObstacleGrid, cell: Cell) -> bool {
        FreeSpace::new(obstacles, self.inscribed_radius_m).is_free(cell)
    }
}

impl GlobalPlanner for RoutePlanner {
    /// As [`RoutePlanner::plan`]; next to obstacles that may not stay, the path keeps the usual distance in narrow passages too.
    fn plan(
        &mut self,
        obstacles: &ObstacleGrid,
        transient: &[MovingDisc],
        start: Point,
        goal: Point,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<Plan, PlanError> {
        self.checked.clone()?;
        let is_this = |terrain: &Terrain| terrain.obstacles == *obstacles;
        let terrain = self.terrain.take().filter(is_this);
        let terrain = terrain.unwrap_or_else(|| self.terrain(obstacles));
        let task = &mut Task { terrain: &terrain, transient, start, goal, clock };
        let usual = self.plan_on(task);
        let outcome = self.narrow_if_better(task, usual);
        self.terrain = Some(terrain);
        outcome
    }

    fn least_radius_m(&self) -> f64 {
        self.least_radius_m
    }
}

/// What a path keeps for the lookup of clearances, metres. The local planner finds up to the diagonal of a cell of its window too
/// little clearance. Half a cell less suffices: the cells of a path are clear as a whole.
fn lookup_margin_m(resolution_m: f64) -> f64 {
    (core::f64::consts::SQRT_2 - 0.5) * resolution_m.min(FIELD_CELL_M)
}
