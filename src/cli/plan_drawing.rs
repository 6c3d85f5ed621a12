//! The pictures of `inbye plan`.

use std::path::Path as FilePath;

use inbye::geometry::{Point, Pose, bearing};
use inbye::global::{Path, PlanError};
use inbye::map::OccupancyGrid;
use inbye::report::{PathStages, PlanMetrics, PlanOutcome, PlanView, plan_svg};

use super::arguments::{Place, PlanArguments};
use super::multi_leg_plan::{GOAL, Leg, LegFailure, MultiLegPlan, joined};
use super::output_file::Output;

/// Width of the picture, pixels: two per unit, which is sharp on a screen and in print.
const PNG_WIDTH: u32 = 1440;

const WITHOUT_PNG: &str =
    "--png: this build has no feature `png`: install it with `--features png`, or use --svg";

/// The files of `--svg` and `--png`.
pub struct Drawing<'a> {
    arguments: &'a PlanArguments,
    svg: Option<Output<'a>>,
    png: Option<Output<'a>>,
}

impl<'a> Drawing<'a> {
    /// Creates the requested files, before the search.
    pub fn create(arguments: &'a PlanArguments) -> anyhow::Result<Self> {
        let can_png = cfg!(feature = "png") || arguments.png.is_none();
        anyhow::ensure!(can_png, WITHOUT_PNG);
        Ok(Self {
            arguments,
            svg: Output::create("--svg", arguments.svg.as_deref(), &["svg"])?,
            png: Output::create("--png", arguments.png.as_deref(), &["png"])?,
        })
    }

    /// Draws a plan.
    pub fn draw_plan(self, plan: &MultiLegPlan, map: &OccupancyGrid) -> anyhow::Result<()> {
        let pruned = plan.stage(|plan| &plan.pruned);
        let smoothed = plan.stage(|plan| &plan.smoothed);
        let sharp_turns = plan.curvature().sharp_turns;
        let figures = PlanMetrics {
            length_m: smoothed.length_m(),
            // A sharp turn counts from a smaller angle than a turn does.
            turns: pruned.turns().max(sharp_turns),
            sharp_turns,
            min_clearance_m: plan.clearance_m(),
        };
        self.write(map, &plan.legs, PlanOutcome::Found(figures))
    }

    /// Draws the legs before a failure.
    pub fn draw_failure(self, failure: &LegFailure, map: &OccupancyGrid) -> anyhow::Result<()> {
        let nearest = match failure.error {
            PlanError::NoValidPath { nearest, .. } => nearest,
            _ => None,
        };
        let to = failure.stop.as_deref().filter(|stop| *stop != GOAL);
        let why = format!("no path to {} ({})", to.unwrap_or("the goal"), failure.error.code());
        let outcome = PlanOutcome::NotFound { reason: &why, nearest };
        self.write(map, &failure.legs, outcome)
    }

    fn write(self, map: &OccupancyGrid, legs: &[Leg], outcome: PlanOutcome) -> anyhow::Result<()> {
        if self.svg.is_none() && self.png.is_none() {
            return Ok(());
        }
        let stages = [
            joined(legs, |plan| &plan.raw),
            joined(legs, |plan| &plan.pruned),
            joined(legs, |plan| &plan.smoothed),
        ];
        let [searched, pruned, smoothed] =
            stages.each_ref().map(|path| path.as_ref().map_or(&[][..], Path::points));
        let stops: Vec<Point> = self.arguments.via.iter().map(|via| via.position).collect();
        let svg = plan_svg(&PlanView {
            title: &title(self.arguments),
            map,
            start: start(&self.arguments.start, smoothed),
            stops: &stops,
            goal: self.arguments.goal.position,
            stages: PathStages { searched, pruned, smoothed },
            outcome,
        });
        if let Some(file) = self.png {
            file.write(pixels(&svg, PNG_WIDTH)?)?;
        }
        if let Some(file) = self.svg {
            file.write(svg)?;
        }
        Ok(())
    }
}

#[cfg(feature = "png")]
fn pixels(svg: &str, width_px: u32) -> anyhow::Result<Vec<u8>> {
    use anyhow::Context;
    inbye::report::png(svg, width_px).context("--png")
}

#[cfg(not(feature = "png"))]
fn pixels(_svg: &str, _width_px: u32) -> anyhow::Result<Vec<u8>> {
    anyhow::bail!(WITHOUT_PNG)
}

/// The title: map, start and goal.
fn title(arguments: &PlanArguments) -> String {
    let map = &arguments.map.map;
    let name = map.file_name().map_or(map.as_path(), FilePath::new);
    let (start, goal) = (arguments.start.position, arguments.goal.position);
    format!(
        "{}: ({:.1}, {:.1}) to ({:.1}, {:.1})",
        name.display(),
        start.x,
        start.y,
        goal.x,
        goal.y
    )
}

/// The start pose; without a given yaw it faces along the path.
fn start(place: &Place, path: &[Point]) -> Pose {
    let along = match path {
        [first, second, ..] => bearing(first, second),
        _ => 0.0,
    };
    let Point { coords, .. } = place.position;
    Pose::new(coords.x, coords.y, place.yaw.unwrap_or(along))
}
