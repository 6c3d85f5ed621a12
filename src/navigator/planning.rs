//! Global planning for a robot: the same map at two distances from walls.

use super::NavigatorSettings;
use crate::geometry::Point;
use crate::global::{self, Ground, Plan, PlanError};
use crate::map::{FreeSpace, ObstacleGrid};
use crate::robot::Footprint;

/// Plans paths that keep a comfortable distance from walls where there is room, and the least safe one where not.
#[derive(Clone, Debug)]
pub struct RoutePlanner {
    settings: global::Settings,
    least_radius_m: f64,
    comfortable_radius_m: f64,
}

impl RoutePlanner {
    /// A planner for a robot on maps of this resolution.
    ///
    /// The least radius is that of the footprint's circle, with the margin that the local planner keeps as well.
    #[must_use]
    pub fn new(
        footprint: &Footprint,
        navigator: &NavigatorSettings,
        settings: global::Settings,
        resolution_m: f64,
    ) -> Self {
        let least_radius_m = footprint.circumscribed_radius_m()
            + local_margin_m(navigator, resolution_m)
            - resolution_m / 2.0;
        let comfortable_radius_m = least_radius_m + navigator.comfort_margin_m;
        Self {
            settings,
            least_radius_m,
            comfortable_radius_m,
        }
    }

    /// The least distance kept between a path and an obstacle, metres.
    #[must_use]
    pub const fn least_radius_m(&self) -> f64 {
        self.least_radius_m
    }

    /// A path among obstacles. Times its stages by `clock`, in seconds.
    ///
    /// # Errors
    /// When there is none even at the least radius.
    pub fn plan(
        &self,
        obstacles: &ObstacleGrid,
        start: Point,
        goal: Point,
        clock: &mut dyn FnMut() -> f64,
    ) -> Result<Plan, PlanError> {
        let least = FreeSpace::new(obstacles, self.least_radius_m);
        let comfortable = FreeSpace::new(obstacles, self.comfortable_radius_m);
        let mut search = |search| {
            let ground = Ground {
                search,
                proof: &least,
            };
            global::plan(&ground, start, goal, &self.settings, clock)
        };
        search(&comfortable).or_else(|_| search(&least))
    }
}

/// What the local planner adds to the footprint: the margin asked for, half a cell's diagonal because a clearance is
/// looked up by the cell, and another because obstacle cells are squares while the field measures to their centres.
#[must_use]
pub fn local_margin_m(settings: &NavigatorSettings, resolution_m: f64) -> f64 {
    settings.safety_margin_m + core::f64::consts::SQRT_2 * resolution_m
}
