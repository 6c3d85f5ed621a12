//! What moved on the map: the driven track, the ways of the obstacles, and where all were at some moments.

use maud::{Markup, html};

use super::MissionView;
use super::figure::key;
use super::number::{coordinate, fixed};
use super::panel::points_attribute;
use super::simplify::{TOLERANCE, simplify};
use super::snapshot::{NEAR_M, distance_m, moments};
use super::viewport::Viewport;
use crate::geometry::{Point, Pose};
use crate::robot::Footprint;
use crate::sim::{Trace, TraceRow};

/// A faster obstacle, m/s, has jumped from the end of its way to the start.
const JUMP_M_S: f64 = 15.0;

/// Classes of speed that the track's colour tells apart.
const SPEED_CLASSES: f64 = 4.0;

/// How far, in classes, the speed must be past a border before the colour changes: noise must not stripe the track.
const HYSTERESIS: f64 = 0.12;

/// Places nearer than this, drawing units, share one number.
const SAME_PLACE: f64 = 12.0;

/// The highest true speed of a run, m/s.
pub(super) fn top_speed(rows: &[TraceRow]) -> f64 {
    rows.iter()
        .map(|row| row.twist.linear.abs())
        .filter(|speed| speed.is_finite())
        .fold(0.0, f64::max)
}

/// The driven track, its colour the speed.
pub(super) fn track(rows: &[TraceRow], view: &Viewport) -> Markup {
    let top = top_speed(rows).max(1e-9);
    let mut class = 0.0;
    let mut stretches: Vec<(u8, Vec<[f64; 2]>)> = Vec::new();
    for row in rows.iter().filter(|row| row.pose.is_finite()) {
        let place = view.at(&row.pose.position());
        let speed = row.twist.linear.abs() / top * SPEED_CLASSES;
        if speed < class - HYSTERESIS || speed > class + 1.0 + HYSTERESIS {
            class = libm::floor(speed).min(SPEED_CLASSES - 1.0);
        }
        if let Some((_, stretch)) = stretches.last_mut() {
            stretch.push(place);
        }
        if stretches
            .last()
            .is_none_or(|&(last, _)| last != class as u8)
        {
            stretches.push((class as u8, vec![place]));
        }
    }
    let whole: Vec<[f64; 2]> = rows
        .iter()
        .filter(|row| row.pose.is_finite())
        .map(|row| view.at(&row.pose.position()))
        .collect();
    html! {
        polyline class="track-edge" points=(points_attribute(&simplify(&whole, TOLERANCE))) {}
        @for (class, stretch) in &stretches {
            polyline class=(format!("track speed-{class}"))
                points=(points_attribute(&simplify(stretch, TOLERANCE))) {}
        }
    }
}

/// Whether any moving obstacle is ever in the picture.
pub(super) fn has_trails(trace: &Trace, view: &Viewport) -> bool {
    trace
        .rows
        .iter()
        .any(|row| row.moving.iter().any(|center| view.shows(center)))
}

/// The ways of the moving obstacles as far as the picture shows them.
pub(super) fn trails(trace: &Trace, view: &Viewport) -> Markup {
    let ways = (0..trace.moving_radii.len()).flat_map(|obstacle| {
        let seen: Vec<(f64, Point)> = trace
            .rows
            .iter()
            .filter_map(|row| Some((row.time_s, *row.moving.get(obstacle)?)))
            .collect();
        seen.chunk_by(|(earlier, from), (later, to)| {
            view.shows(from)
                && view.shows(to)
                && distance_m(from, to) <= JUMP_M_S * (later - earlier)
        })
        .map(|way| way.iter().map(|(_, place)| view.at(place)).collect())
        .collect::<Vec<Vec<[f64; 2]>>>()
    });
    html! {
        @for way in ways.filter(|way| way.len() > 1) {
            polyline class="trail" points=(points_attribute(&simplify(&way, TOLERANCE))) {}
        }
    }
}

/// A cross where each contact begins.
pub(super) fn contacts(rows: &[TraceRow], view: &Viewport) -> Markup {
    let touches = |row: &TraceRow| row.gap_m <= 0.0;
    let begins = rows
        .chunk_by(|a, b| touches(a) == touches(b))
        .filter_map(|stretch| stretch.first())
        .filter(|row| touches(row) && view.shows(&row.pose.position()));
    html! {
        @for row in begins {
            @let [x, y] = view.at(&row.pose.position());
            path class="contact-mark" d=(format!("M{} {}l12 12m0 -12l-12 12", coordinate(x - 6.0), coordinate(y - 6.0))) {}
        }
    }
}

/// The robot and the obstacles near it at some moments, which are numbered.
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
    pub(super) fn of(mission: &MissionView, view: &Viewport) -> Self {
        let trace = mission.trace;
        let reach = mission.footprint.circumscribed_radius_m() * view.scale() + 11.0;
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

    pub(super) fn legend(&self) -> Vec<Markup> {
        let mut legend = Vec::new();
        if !self.robots.is_empty() {
            let mark = html! {
                g class="footprint" { circle cx="14" cy="7" r="6" {} }
                line class="heading" x1="14" y1="7" x2="20" y2="7" {}
            };
            legend.push(key(&mark, "robot at a numbered moment"));
        }
        if !self.obstacles.is_empty() {
            let mark = html! { circle class="moving" cx="14" cy="7" r="6" {} };
            legend.push(key(
                &mark,
                &format!("moving obstacle within {} m of it then", fixed(NEAR_M, 0)),
            ));
        }
        legend
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
