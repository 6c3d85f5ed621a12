//! Encounters of the robot with moving obstacles, drawn at a few numbered moments.

use maud::{Markup, html};

use super::viewport::Viewport;
use crate::geometry::{Point, Pose};
use crate::report::number::{coordinate, fixed};
use crate::report::svg::{LegendEntry, points_attribute};
use crate::robot::Footprint;
use crate::runtime::{Trace, TraceRow};

/// Most moments of a map.
const MAX_MOMENTS: usize = 6;

/// Moments at equal intervals, used as far as the others leave room.
const EVEN_MOMENTS: usize = 5;

/// Least distance of the robot between two moments, drawing units.
const MIN_SPACING: f64 = 34.0;

/// Distance from the robot within which a moving obstacle is drawn, m.
const NEAR_M: f64 = 4.0;

/// Distance below which two positions of an obstacle share one disc, drawing units.
const SAME_POSITION: f64 = 12.0;

/// The robot and the obstacles near it at numbered moments.
#[derive(Default)]
pub(crate) struct Encounters {
    /// Time and pose of the robot.
    robots: Vec<(f64, Pose)>,
    obstacles: Vec<Disc>,
    /// Positions of the robot's numbers in the drawing.
    robot_numbers: Vec<[f64; 2]>,
}

/// A moving obstacle in the drawing.
struct Disc {
    obstacle: usize,
    center: [f64; 2],
    radius: f64,
    /// Numbers of the moments.
    numbers: String,
}

impl Encounters {
    /// Selects the moments of a run.
    pub(crate) fn new(trace: &Trace, footprint: &Footprint, view: &Viewport) -> Self {
        let number_distance = footprint.circumscribed_radius_m() * view.scale() + 11.0;
        let mut encounters = Self::default();
        for (index, row) in moments(trace, view).into_iter().enumerate() {
            let number = (index + 1).to_string();
            encounters.robots.push((row.time_s, row.pose));
            for (obstacle, (center, radius)) in
                row.moving.iter().zip(&trace.moving_radii).enumerate()
            {
                let Some(center) = center else { continue };
                let is_near = distance_m(center, &row.pose.position()) - radius <= NEAR_M;
                if is_near && view.shows(center) {
                    encounters.add(obstacle, view.at(center), radius * view.scale(), &number);
                }
            }
            let position = encounters.number_position(&row.pose, view, number_distance);
            encounters.robot_numbers.push(position);
        }
        encounters
    }

    /// Adds a disc, or only its number if the same obstacle has a disc at nearly the same position.
    fn add(&mut self, obstacle: usize, center: [f64; 2], radius: f64, number: &str) {
        let same = self.obstacles.iter_mut().find(|disc| {
            disc.obstacle == obstacle && distance(disc.center, center) < SAME_POSITION
        });
        if let Some(disc) = same {
            disc.numbers = format!("{},{number}", disc.numbers);
        } else {
            self.obstacles.push(Disc { obstacle, center, radius, numbers: number.to_owned() });
        }
    }

    /// The position left or right of the robot that is farther from all discs.
    fn number_position(&self, pose: &Pose, view: &Viewport, reach: f64) -> [f64; 2] {
        let [x, y] = view.at(&pose.position());
        let (sin, cos) = libm::sincos(pose.yaw);
        let clearance = |position: [f64; 2]| {
            self.obstacles
                .iter()
                .map(|disc| distance(disc.center, position) - disc.radius)
                .fold(f64::INFINITY, f64::min)
        };
        // The drawing's y axis points down.
        let left = [x - sin * reach, y - cos * reach];
        let right = [x + sin * reach, y + cos * reach];
        if clearance(left) >= clearance(right) { left } else { right }
    }

    /// The obstacles and the robot.
    pub(crate) fn draw(&self, footprint: &Footprint, view: &Viewport) -> Markup {
        html! {
            @for disc in &self.obstacles {
                circle class="moving" cx=(coordinate(disc.center[0])) cy=(coordinate(disc.center[1]))
                    r=(coordinate(disc.radius)) {}
            }
            @for (_, pose) in &self.robots {
                g class="footprint" {
                    @if let Some(body) = footprint.body() {
                        @let corners = body.corners().iter().map(|corner| view.at(&pose.transform(corner)));
                        polygon points=(points_attribute(&corners.collect::<Vec<_>>())) {}
                    } @else {
                        @for (center, radius) in footprint.at(pose) {
                            @let [x, y] = view.at(&center);
                            circle cx=(coordinate(x)) cy=(coordinate(y)) r=(coordinate(radius * view.scale())) {}
                        }
                    }
                }
                @let [x, y] = view.at(&pose.position());
                @let nose = view.at(&pose.transform(&Point::new(footprint.front_m(), 0.0)));
                line class="heading" x1=(coordinate(x)) y1=(coordinate(y))
                    x2=(coordinate(nose[0])) y2=(coordinate(nose[1])) {}
            }
        }
    }

    /// The numbers, to be drawn above everything else.
    pub(crate) fn draw_numbers(&self) -> Markup {
        let number = |class: &str, [x, y]: [f64; 2], text: &str| {
            html! { text class=(class) x=(coordinate(x)) y=(coordinate(y)) dy=".35em" { (text) } }
        };
        html! {
            @for disc in &self.obstacles { (number("middle halo number of-moving", disc.center, &disc.numbers)) }
            @for (index, &position) in self.robot_numbers.iter().enumerate() {
                (number("middle halo number of-robot", position, &(index + 1).to_string()))
            }
        }
    }

    /// The legend of the marks.
    pub(crate) fn legend(&self) -> Vec<LegendEntry> {
        let mut legend = Vec::new();
        if !self.robots.is_empty() {
            let mark = html! {
                g class="footprint" { rect x="6" y="2" width="14" height="10" {} }
                line class="heading" x1="14" y1="7" x2="20" y2="7" {}
            };
            legend.push(LegendEntry::new(mark, "robot at a numbered moment"));
        }
        if !self.obstacles.is_empty() {
            let text = format!("moving obstacle within {} m of the robot", fixed(NEAR_M, 0));
            legend.push(LegendEntry::circle("moving", 6.0, text));
        }
        legend
    }

    /// A sentence with the times of the moments, with a leading space; empty without moments.
    pub(crate) fn times_text(&self) -> String {
        if self.robots.is_empty() {
            return String::new();
        }
        let times: Vec<String> = self
            .robots
            .iter()
            .enumerate()
            .map(|(index, (time_s, _))| format!("{} at {} s", index + 1, fixed(*time_s, 1)))
            .collect();
        format!(" Equal numbers are the same moment: {}.", times.join(", "))
    }
}

/// The rows to draw, in order of time: first the closest pass of each moving obstacle, then some at equal intervals. No
/// two are close to each other in the drawing.
fn moments<'a>(trace: &'a Trace, view: &Viewport) -> Vec<&'a TraceRow> {
    let rows = &trace.rows;
    let even = (1..=EVEN_MOMENTS).map(|part| rows.len() * part / (EVEN_MOMENTS + 1));
    let mut chosen: Vec<usize> = Vec::new();
    for index in closest_passes(trace).into_iter().chain(even) {
        let Some(position) = rows.get(index).map(|row| row.pose.position()) else {
            continue;
        };
        let is_far = |&other: &usize| {
            distance_m(&rows[other].pose.position(), &position) * view.scale() >= MIN_SPACING
        };
        if chosen.len() < MAX_MOMENTS && view.shows(&position) && chosen.iter().all(is_far) {
            chosen.push(index);
        }
    }
    chosen.sort_unstable();
    chosen.into_iter().map(|index| &rows[index]).collect()
}

/// The row of the closest pass of each moving obstacle that came near; the nearest obstacle first.
fn closest_passes(trace: &Trace) -> Vec<usize> {
    let mut passes: Vec<(f64, usize)> = trace
        .moving_radii
        .iter()
        .enumerate()
        .filter_map(|(obstacle, radius)| {
            trace
                .rows
                .iter()
                .enumerate()
                .filter_map(|(index, row)| {
                    let center = row.moving.get(obstacle)?.as_ref()?;
                    let distance = distance_m(center, &row.pose.position()) - radius;
                    (distance <= NEAR_M).then_some((distance, index))
                })
                .min_by(|a, b| a.0.total_cmp(&b.0))
        })
        .collect();
    passes.sort_by(|a, b| a.0.total_cmp(&b.0));
    passes.into_iter().map(|(_, index)| index).collect()
}

/// The distance between two points, m; NaN where one is not finite.
pub(super) fn distance_m(a: &Point, b: &Point) -> f64 {
    libm::hypot(a.x - b.x, a.y - b.y)
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}
