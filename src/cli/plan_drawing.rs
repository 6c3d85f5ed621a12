//! The pictures that `inbye plan` leaves behind, their files opened before the search.

use std::path::Path as FilePath;

use inbye::geometry::{Point, Pose, bearing};
use inbye::global::{Path, PlanError};
use inbye::map::OccupancyGrid;
use inbye::report::{PlanFigures, PlanOutcome, PlanView, plan_svg};

use super::arguments::{Place, PlanArguments};
use super::output_file::Output;
use super::tour::{GOAL, Leg, Refused, Tour, joined};

/// Width of the picture in pixels: two for each of its units, which is sharp on a screen and in a printed report.
const PNG_WIDTH: u32 = 1440;

const WITHOUT_PNG: &str =
    "--png: this program was built without its feature `png`: build it with that, or use --svg";

/// The files of `--svg` and `--png`.
pub struct Drawing<'a> {
    arguments: &'a PlanArguments,
    svg: Option<Output<'a>>,
    png: Option<Output<'a>>,
}

impl<'a> Drawing<'a> {
    /// Opens the files that are asked for.
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
    pub fn of_tour(self, tour: &Tour, map: &OccupancyGrid) -> anyhow::Result<()> {
        let pruned = tour.stage(|plan| &plan.pruned);
        let smoothed = tour.stage(|plan| &plan.smoothed);
        let sharp_turns = tour.curvature().sharp_turns;
        let figures = PlanFigures {
            length_m: smoothed.length_m(),
            // A corner counts from a smaller angle on than a turn does.
            turns: pruned.turns().max(sharp_turns),
            sharp_turns,
            min_clearance_m: tour.clearance_m(),
        };
        self.write(map, &tour.legs, PlanOutcome::Found(figures))
    }

    /// Draws how far a plan got.
    pub fn of_refused(self, refused: &Refused, map: &OccupancyGrid) -> anyhow::Result<()> {
        let nearest = match refused.error {
            PlanError::NoValidPath { nearest, .. } => nearest,
            _ => None,
        };
        let to = refused.stop.as_deref().filter(|stop| *stop != GOAL);
        let why = format!(
            "no path to {} ({})",
            to.unwrap_or("the goal"),
            refused.error.code()
        );
        let outcome = PlanOutcome::NotFound { why: &why, nearest };
        self.write(map, &refused.legs, outcome)
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
        let [searched, pruned, smoothed] = stages
            .each_ref()
            .map(|path| path.as_ref().map_or(&[][..], Path::points));
        let stops: Vec<Point> = self.arguments.via.iter().map(|via| via.position).collect();
        let svg = plan_svg(&PlanView {
            title: &title(self.arguments),
            map,
            start: start(&self.arguments.start, smoothed),
            stops: &stops,
            goal: self.arguments.goal.position,
            searched,
            pruned,
            smoothed,
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

/// The map and the ends.
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

/// The start with the yaw that was given, or else along the path.
fn start(place: &Place, path: &[Point]) -> Pose {
    let along = match path {
        [first, second, ..] => bearing(first, second),
        _ => 0.0,
    };
    let Point { coords, .. } = place.position;
    Pose::new(coords.x, coords.y, place.yaw.unwrap_or(along))
}
