//! Drives of the whole navigator from the page, each with a page of its own and the command that repeats it.

use std::collections::VecDeque;
use std::fmt::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use hyper::StatusCode;
use serde::Deserialize;
use serde_json::{Value, json};

use super::decision::{MAX_OBSTACLES, MAX_SAMPLES};
use super::scene::{Scene, clearance_m, free_way_m};
use crate::geometry::{Point, Pose, Vector};
use crate::local::{CpuEngine, Normalization, Sampler, Stopping, Weights};
use crate::map::MovingDisc;
use crate::navigator::Goal;
use crate::report::{MissionView, PlaybackRecorder, Report, html};
use crate::runtime::{Config, Mission, MissionResult, Observer, TickEvent};
use crate::server::HttpError;
use crate::sim::{MovingObstacles, SimError, Simulation};

/// Longest drive: simulated seconds, and time of its computation.
const TIME_LIMIT_S: f64 = 600.0;
const COMPUTE_TIME: Duration = Duration::from_secs(15);
/// A person walks to and fro along this distance, metres, or as far as there is room.
const WALK_M: f64 = 6.0;
const WALK_STEP_M: f64 = 0.05;
/// Number of drives whose pages are kept.
const KEPT: usize = 8;
/// The file of the people in a command.
const PEOPLE_FILE: &str = "people.json";

/// A drive as the page requests it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DriveRequest {
    scene: String,
    start: [f64; 3],
    goal: [f64; 2],
    people: Vec<MovingDisc>,
    vx_samples: u32,
    vtheta_samples: u32,
    #[serde(default)]
    sampler: Sampler,
    sim_time_s: f64,
    weights: Weights,
    normalization: Normalization,
    stopping: Stopping,
}

/// Computes drives, one at a time.
#[derive(Default)]
pub struct DriveService {
    busy: Mutex<()>,
    pages: Mutex<Pages>,
}

/// The pages of the last drives.
#[derive(Default)]
struct Pages {
    next: u64,
    kept: VecDeque<(u64, String)>,
}

impl DriveService {
    /// Drives, and returns the result, the command that repeats the drive, and the path of its page.
    pub fn drive(&self, scenes: &[Scene], body: &[u8]) -> Result<Value, HttpError> {
        let request: DriveRequest = serde_json::from_slice(body)
            .map_err(|error| HttpError::bad_request(error.to_string()))?;
        let scene = scenes.iter().find(|scene| scene.name == request.scene);
        let scene = scene.ok_or_else(|| HttpError::bad_request("there is no such scene"))?;
        let Ok(_busy) = self.busy.try_lock() else {
            let message = "another drive is being computed: try again in some seconds";
            return Err(HttpError::new(StatusCode::SERVICE_UNAVAILABLE, message));
        };
        let drive = Drive::new(scene, &request)?;
        let (result, playback) =
            drive.run().map_err(|error| HttpError::bad_request(error.to_string()))?;
        let page = self.keep(drive.page(&result, &playback));
        Ok(json!({
            "reached": result.reached,
            "collided": result.collided,
            "why": result.why(),
            "travelled_m": result.travelled_m,
            "time_s": result.time_s,
            "min_clearance_m": result.min_clearance_m,
            "trace_digest": result.trace.digest(),
            "command": drive.command,
            "page": page,
        }))
    }

    /// The page of a drive, if it is one of the last.
    pub fn page(&self, path: &str) -> Option<String> {
        let number: u64 = path.strip_prefix("/drives/")?.parse().ok()?;
        let pages = self.pages.lock().unwrap_or_else(PoisonError::into_inner);
        pages.kept.iter().find(|(kept, _)| *kept == number).map(|(_, page)| page.clone())
    }

    fn keep(&self, page: String) -> String {
        let mut pages = self.pages.lock().unwrap_or_else(PoisonError::into_inner);
        let number = pages.next;
        pages.next += 1;
        pages.kept.push_back((number, page));
        if pages.kept.len() > KEPT {
            pages.kept.pop_front();
        }
        format!("/drives/{number}")
    }
}

/// A requested drive.
struct Drive<'a> {
    scene: &'a Scene,
    config: Config,
    simulation: Simulation,
    is_late: Arc<AtomicBool>,
    command: String,
}

impl<'a> Drive<'a> {
    fn new(scene: &'a Scene, request: &DriveRequest) -> Result<Self, HttpError> {
        let samples = u64::from(request.vx_samples) * u64::from(request.vtheta_samples);
        if samples > MAX_SAMPLES as u64 || request.people.len() > MAX_OBSTACLES {
            let message = format!("at most {MAX_SAMPLES} samples and {MAX_OBSTACLES} people");
            return Err(HttpError::bad_request(message));
        }
        let mut config = scene.config.clone();
        let local = &mut config.local;
        local.vx_samples = request.vx_samples;
        local.vtheta_samples = request.vtheta_samples;
        local.sampler = request.sampler;
        local.sim_time_s = request.sim_time_s;
        local.weights = request.weights;
        local.normalization = request.normalization;
        local.stopping = request.stopping;
        let people: Vec<Person> =
            request.people.iter().map(|disc| Person::new(scene, disc)).collect();
        let people = people_text(&people);
        let moving_obstacles = moving_obstacles(scene, request.start, &people)
            .map_err(|error| HttpError::bad_request(error.to_string()))?;
        let [x, y] = request.goal;
        let goal = Goal::at(Point::new(x, y));
        let is_late = Arc::new(AtomicBool::new(false));
        let mission = Mission {
            time_limit_s: TIME_LIMIT_S,
            interrupt: Some(Arc::clone(&is_late)),
            zones: scene.zones.clone(),
            ..Mission::new(Arc::clone(&scene.map), Pose::from(request.start), goal)
        };
        let simulation = Simulation { moving_obstacles, ..Simulation::new(mission) };
        let command = command(scene, request, &config, &people);
        Ok(Self { scene, config, simulation, is_late, command })
    }

    fn run(&self) -> Result<(MissionResult, PlaybackRecorder), SimError> {
        let began = Instant::now();
        let mut playback = PlaybackRecorder::default();
        let mut clock = || began.elapsed().as_secs_f64();
        let mut on_tick = |tick: &TickEvent<'_>| {
            playback.record(tick);
            if began.elapsed() > COMPUTE_TIME {
                self.is_late.store(true, Ordering::Relaxed);
            }
        };
        let mut observer = Observer { clock: &mut clock, on_tick: &mut on_tick };
        let engine = Box::new(CpuEngine::single_threaded());
        let result = self.simulation.run(&self.config, engine, &mut observer)?;
        Ok((result, playback))
    }

    fn page(&self, result: &MissionResult, playback: &PlaybackRecorder) -> String {
        let view = MissionView {
            title: &self.scene.title,
            command: &self.command,
            mission: &self.simulation.mission,
            config: &self.config,
            result,
            playback: Some(playback),
            facts: &[("Trace digest".to_owned(), result.trace.digest())],
        };
        html(&Report {
            title: "inbye: a drive from the playground",
            intro: "One mission, simulated in a closed loop.",
            missions: vec![view],
            ..Report::default()
        })
    }
}

/// A moving obstacle of the page, which walks to and fro.
struct Person {
    radius_m: f64,
    speed: f64,
    route: [Point; 2],
}

impl Person {
    fn new(scene: &Scene, disc: &MovingDisc) -> Self {
        let (from, speed) = (disc.center(), libm::hypot(disc.vx, disc.vy));
        let (direction, walked_m) = if speed > 0.0 {
            let direction = Vector::new(disc.vx, disc.vy) / speed;
            let field = &scene.field;
            let has_room = |point: &Point| {
                let cell = field.frame().cell_of(point);
                cell.is_some_and(|cell| clearance_m(field, cell) > disc.radius)
            };
            (direction, free_way_m(has_room, &from, &direction, WALK_STEP_M, WALK_M))
        } else {
            (Vector::ZERO, 0.0)
        };
        Self { radius_m: disc.radius, speed, route: [from, from + direction * walked_m] }
    }

    /// The person in a file of moving obstacles.
    fn json(&self) -> Value {
        let [from, to] = self.route;
        json!({ "x": from.x, "y": from.y, "radius": self.radius_m, "speed": self.speed, "route": [[to.x, to.y]] })
    }
}

/// The content of the file of people in a command; empty without people.
fn people_text(people: &[Person]) -> String {
    if people.is_empty() {
        return String::new();
    }
    let people: Vec<Value> = people.iter().map(Person::json).collect();
    json!(people).to_string()
}

/// The people of a file, with the checks of `inbye drive --obstacles`: the page rejects what the printed command would reject.
fn moving_obstacles(
    scene: &Scene,
    start: [f64; 3],
    people: &str,
) -> Result<MovingObstacles, SimError> {
    if people.is_empty() {
        return Ok(MovingObstacles::default());
    }
    let ground = scene.map.obstacles(scene.config.unknown);
    let moving = MovingObstacles::parse(people, PEOPLE_FILE, &ground, 0)?;
    let footprint = &scene.config.robot.footprint;
    moving.check_start_in((people, PEOPLE_FILE), &Pose::from(start), footprint)?;
    Ok(moving)
}

/// The command of a shell that repeats a drive, with the file of its people.
fn command(scene: &Scene, request: &DriveRequest, config: &Config, people: &str) -> String {
    let ([x, y, yaw], [goal_x, goal_y]) = (request.start, request.goal);
    let mut text = String::new();
    let file = if people.is_empty() {
        "0"
    } else {
        // Writing to a text never fails.
        let _ = writeln!(text, "echo '{people}' > {PEOPLE_FILE}");
        PEOPLE_FILE
    };
    let _ = write!(
        text,
        "inbye drive {} --start {x},{y},{yaw} --goal {goal_x},{goal_y} --obstacles {file} --seed 0 --time-limit {TIME_LIMIT_S}",
        scene.arguments
    );
    for (key, value) in changes(&scene.config, config) {
        let _ = write!(text, " --set {key}={value}");
    }
    text + " --report out"
}

/// The settings of the local planner that differ, as `--set` takes them.
fn changes(from: &Config, to: &Config) -> Vec<(String, String)> {
    let local = |config: &Config| {
        let local = &config.local;
        let weights = &local.weights;
        [
            ("vx_samples", local.vx_samples.to_string()),
            ("vtheta_samples", local.vtheta_samples.to_string()),
            ("sampler", local.sampler.name().to_owned()),
            ("sim_time_s", local.sim_time_s.to_string()),
            ("weights.heading", weights.heading.to_string()),
            ("weights.clearance", weights.clearance.to_string()),
            ("weights.velocity", weights.velocity.to_string()),
            ("weights.path", weights.path.to_string()),
            ("normalization", name_of(&json!(local.normalization))),
            ("stopping", name_of(&json!(local.stopping))),
        ]
    };
    let both = local(from).into_iter().zip(local(to));
    both.filter(|(from, to)| from != to)
        .map(|(_, (key, value))| (format!("local.{key}"), value))
        .collect()
}

fn name_of(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}
