//! The pictures of `inbye plan`.

use std::path::Path as FilePath;

use inbye::geometry::{Point, Pose, bearing};
use inbye::global::PlanError;
use inbye::report::{PathStages, PlanMetrics, PlanOutcome, PlanView, plan_svg};

use super::arguments::Place;
use super::files::{Output, all_written};
use super::map_file::MapInput;
use super::plan::PlanArguments;
use super::plan_result::{LegFailure, PlanResult, PlanTask};

/// Width of the picture, pixels: two per unit, which is sharp on a screen and in print.
const PNG_WIDTH: u32 = 1440;

const WITHOUT_PNG: &str = "--png: this build, such as that of the Python wheel, has no feature `png`: use --svg, a package, or a build with `--features png`";

/// The files of `--svg` and `--png`.
pub struct Drawing<'a> {
    svg: Output<'a>,
    png: Output<'a>,
}

impl<'a> Drawing<'a> {
    /// Creates the requested files, before the search.
    pub fn create(arguments: &'a PlanArguments) -> anyhow::Result<Self> {
        let can_png = cfg!(feature = "png") || arguments.png.is_none();
        anyhow::ensure!(can_png, WITHOUT_PNG);
        Ok(Self {
            svg: Output::create("--svg", arguments.svg.as_deref(), &["svg"])?,
            png: Output::create("--png", arguments.png.as_deref(), &["png"])?,
        })
    }

    /// Draws a plan, or the legs before its failure.
    pub fn write(
        self,
        task: &PlanTask<'_>,
        input: &MapInput,
        plan: &PlanResult,
    ) -> anyhow::Result<()> {
        if !self.svg.is_requested() && !self.png.is_requested() {
            return Ok(());
        }
        let why;
        let outcome = match &plan.failure {
            None => PlanOutcome::Found(PlanMetrics {
                length_m: plan.smoothed.length_m(),
                // A sharp turn counts from a smaller angle than a turn does.
                turns: plan.pruned.turns().max(plan.curvature.sharp_turns),
                sharp_turns: plan.curvature.sharp_turns,
                min_clearance_m: plan.clearance_m,
            }),
            Some(LegFailure { via, error, .. }) => {
                let nearest = match error {
                    PlanError::NoValidPath { nearest, .. } => *nearest,
                    _ => None,
                };
                let to = via.map_or_else(|| "the goal".to_owned(), |via| format!("via {via}"));
                why = format!("no path to {to} ({})", error.code());
                PlanOutcome::NotFound { reason: &why, nearest }
            }
        };
        let stages = if plan.legs.is_empty() {
            PathStages::default()
        } else {
            PathStages {
                searched: plan.raw.points(),
                pruned: plan.pruned.points(),
                smoothed: plan.smoothed.points(),
            }
        };
        let stops: Vec<Point> = task.via.iter().map(|via| via.position).collect();
        let svg = plan_svg(&PlanView {
            title: &title(task, &input.name),
            map: &input.map,
            zones: input.zones.as_deref(),
            start: start(&task.start, stages.smoothed),
            stops: &stops,
            goal: task.goal.position,
            stages,
            outcome,
        });
        let png = if self.png.is_requested() {
            pixels(&svg, PNG_WIDTH).and_then(|pixels| self.png.write(|| pixels))
        } else {
            Ok(())
        };
        all_written([png, self.svg.write(|| svg)])
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
fn title(task: &PlanTask<'_>, map: &str) -> String {
    let map = FilePath::new(map);
    let name = map.file_name().map_or(map, FilePath::new);
    let (start, goal) = (task.start.position, task.goal.position);
    let place = |at: Point| format!("({:.1}, {:.1})", at.x, at.y);
    format!("{}: {} to {}", name.display(), place(start), place(goal))
}

/// The start pose; without a given yaw it faces along the path.
fn start(place: &Place, path: &[Point]) -> Pose {
    let along = match path {
        [first, second, ..] => bearing(first, second),
        _ => 0.0,
    };
    let Point { x, y } = place.position;
    Pose::new(x, y, place.yaw.unwrap_or(along))
}
