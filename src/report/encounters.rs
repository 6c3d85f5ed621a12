//! Where the robot and the obstacles near it were at some moments, so that a reader sees how they passed.

use maud::{Markup, html};

use super::number::{coordinate, fixed};
use super::snapshot::{NEAR_M, distance_m, moments};
use super::viewport::Viewport;
use crate::geometry::{Point, Pose};
use crate::robot::Footprint;
use crate::runtime::Trace;

/// Places nearer than this, drawing units, share one number.
const SAME_PLACE: f64 = 12.0;

/// The robot and the obstacles near it at some moments, which are numbered.
#[derive(Default)]
pub(super) struct Encounters {
    /// Time and pose of the robot.
    robots: Vec<(f64, Pose)>,
    obstacles: Vec<Disc>,
    /// Where the robot's numbers stand in the drawing.
    robot_numbers: Vec<[f64; 2]>,
}

/// A moving obstacle as drawn.
struct Disc {
    obstacle: usize,
    center: [f64; 2],
    radius: f64,
    /// Numbers of the moments.
    number: String,
}

impl Encounters {
    pub(super) fn of(trace: &Trace, footprint: &Footprint, view: &Viewport) -> Self {
        let reach = footprint.circumscribed_radius_m() * view.scale() + 11.0;
        let mut encounters = Self {
            robots: Vec::new(),
            obstacles: Vec::new(),
            robot_numbers: Vec::new(),
        };
        for (index, row) in moments(trace, view).into_iter().enumerate() {
            let number = (index + 1).to_string();
            encounters.robots.push((row.time_s, row.pose));
            for (obstacle, (center, radius)) in
                row.moving.iter().zip(&trace.moving_radii).enumerate()
            {
                let Some(center) = center else { continue };
                let near = distance_m(center, &row.pose.position()) - radius <= NEAR_M;
                if near && view.shows(center) {
                    encounters.add(obstacle, view.at(center), radius * view.scale(), &number);
                }
            }
            let place = encounters.free_side(&row.pose, view, reach);
            encounters.robot_numbers.push(place);
        }
        encounters
    }

    /// Adds a disc, or only its number where the same obstacle is drawn at nearly the same place.
    fn add(&mut self, obstacle: usize, center: [f64; 2], radius: f64, number: &str) {
        let same = self
            .obstacles
            .iter_mut()
            .find(|disc| disc.obstacle == obstacle && apart(disc.center, center) < SAME_PLACE);
        if let Some(disc) = same {
            disc.number = format!("{},{number}", disc.number);
        } else {
            self.obstacles.push(Disc {
                obstacle,
                center,
                radius,
                number: number.to_owned(),
            });
        }
    }

    /// A place beside the robot, on the side that is farther from all discs.
    fn free_side(&self, pose: &Pose, view: &Viewport, reach: f64) -> [f64; 2] {
        let [x, y] = view.at(&pose.position());
        let (sin, cos) = libm::sincos(pose.yaw);
        let room = |place: [f64; 2]| {
            self.obstacles
                .iter()
                .map(|disc| apart(disc.center, place) - disc.radius)
                .fold(f64::INFINITY, f64::min)
        };
        // Left of the heading; the drawing's y axis points down.
        let left = [x - sin * reach, y - cos * reach];
        let right = [x + sin * reach, y + cos * reach];
        if room(left) >= room(right) {
            left
        } else {
            right
        }
    }

    pub(super) fn draw(&self, footprint: &Footprint, view: &Viewport) -> Markup {
        html! {
            @for disc in &self.obstacles {
                circle class="moving" cx=(coordinate(disc.center[0])) cy=(coordinate(disc.center[1]))
                    r=(coordinate(disc.radius)) {}
            }
            @for (_, pose) in &self.robots {
                g class="footprint" {
                    @for (center, radius) in footprint.at(pose) {
                        @let [x, y] = view.at(&center);
                        circle cx=(coordinate(x)) cy=(coordinate(y)) r=(coordinate(radius * view.scale())) {}
                    }
                }
                @let [x, y] = view.at(&pose.position());
                @let nose = view.at(&pose.transform(&Point::new(footprint.circumscribed_radius_m(), 0.0)));
                line class="heading" x1=(coordinate(x)) y1=(coordinate(y))
                    x2=(coordinate(nose[0])) y2=(coordinate(nose[1])) {}
            }
        }
    }

    /// The numbers, to be drawn above everything else.
    pub(super) fn draw_numbers(&self) -> Markup {
        let number = |class: &str, [x, y]: [f64; 2], text: &str| {
            html! { text class=(class) x=(coordinate(x)) y=(coordinate(y)) dy=".35em" { (text) } }
        };
        html! {
            @for disc in &self.obstacles { (number("middle halo number of-moving", disc.center, &disc.number)) }
            @for (index, &place) in self.robot_numbers.iter().enumerate() {
                (number("middle halo number of-robot", place, &(index + 1).to_string()))
            }
        }
    }

    /// What its marks mean.
    pub(super) fn keys(&self) -> Vec<(Markup, String)> {
        let mut keys = Vec::new();
        if !self.robots.is_empty() {
            let mark = html! {
                g class="footprint" { circle cx="14" cy="7" r="6" {} }
                line class="heading" x1="14" y1="7" x2="20" y2="7" {}
            };
            keys.push((mark, "robot at a numbered moment".to_owned()));
        }
        if !self.obstacles.is_empty() {
            let mark = html! { circle class="moving" cx="14" cy="7" r="6" {} };
            keys.push((
                mark,
                format!("moving obstacle within {} m of it then", fixed(NEAR_M, 0)),
            ));
        }
        keys
    }

    /// The times of the moments, as a sentence with a leading space; empty without any.
    pub(super) fn in_words(&self) -> String {
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

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}
