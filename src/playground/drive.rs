//! Drives of the whole navigator from the page, each with a page of its own and the command that repeats it.

use core::mem;
use std::collections::VecDeque;
use std::fmt::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
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
use crate::runtime::{Config, EarlyEnd, Mission, MissionResult, Observer, TickEvent};
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

/// Computes drives, one at a time: a new drive cancels the one before.
#[derive(Default)]
pub struct DriveService {
    busy: Mutex<()>,
    /// Interrupts the latest drive.
    latest: Mutex<Arc<AtomicBool>>,
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
        let drive = Drive::new(scene, &request)?;
        let cancelled = || HttpError::new(StatusCode::CONFLICT, "a later drive cancelled this one");
        let _busy = self.turn_of(&drive).ok_or_else(cancelled)?;
        let run =
            drive.run(COMPUTE_TIME).map_err(|error| HttpError::bad_request(error.to_string()))?;
        let DriveRun { result, cut_off, .. } = &run;
        if result.early_end == Some(EarlyEnd::Interrupted) && cut_off.is_none() {
            return Err(cancelled());
        }
        let page = self.keep(drive.page(&run));
        Ok(json!({
            "reached": result.reached,
            "collided": result.collided,
            "why": cut_off.clone().or_else(|| result.why()),
            "is_cut_off": cut_off.is_some(),
            "travelled_m": result.travelled_m,
            "time_s": result.time_s,
            "min_clearance_m": result.min_clearance_m,
            "trace_digest": result.trace.digest(),
            "command": drive.command,
            "page": page,
        }))
    }

    /// Cancels the drive before and waits for its end. Returns nothing if a later drive has cancelled this one meanwhile.
    fn turn_of(&self, drive: &Drive<'_>) -> Option<MutexGuard<'_, ()>> {
        let interrupt = Arc::clone(&drive.interrupt);
        let before = mem::replace(&mut *lock(&self.latest), interrupt);
        before.store(true, Ordering::Relaxed);
        let turn = lock(&self.busy);
        (!drive.interrupt.load(Ordering::Relaxed)).then_some(turn)
    }

    /// The page of a drive, if it is one of the last.
    pub fn page(&self, path: &str) -> Option<String> {
        let number: u64 = path.strip_prefix("/drives/")?.parse().ok()?;
        let pages = lock(&self.pages);
        pages.kept.iter().find(|(kept, _)| *kept == number).map(|(_, page)| page.clone())
    }

    fn keep(&self, page: String) -> String {
        let mut pages = lock(&self.pages);
        let number = pages.next;
        pages.next += 1;
        pages.kept.push_back((number, page));
        if pages.kept.len() > KEPT {
            pages.kept.pop_front();
        }
        format!("/drives/{number}")
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A computed drive.
struct DriveRun {
    result: MissionResult,
    playback: PlaybackRecorder,
    /// The reason, if it ended by the limit of the time of its computation.
    cut_off: Option<String>,
}

/// A requested drive.
struct Drive<'a> {
    scene: &'a Scene,
    config: Config,
    simulation: Simulation,
    interrupt: Arc<AtomicBool>,
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
        let interrupt = Arc::new(AtomicBool::new(false));
        let mission = Mission {
            time_limit_s: TIME_LIMIT_S,
            interrupt: Some(Arc::clone(&interrupt)),
            zones: scene.zones.clone(),
            ..Mission::new(Arc::clone(&scene.map), Pose::from(request.start), goal)
        };
        let simulation = Simulation { moving_obstacles, ..Simulation::new(mission) };
        let command = command(scene, request, &config, &people);
        Ok(Self { scene, config, simulation, interrupt, command })
    }

    fn run(&self, compute_time: Duration) -> Result<DriveRun, SimError> {
        let began = Instant::now();
        let (mut playback, mut is_late) = (PlaybackRecorder::default(), false);
        let mut clock = || began.elapsed().as_secs_f64();
        let mut on_tick = |tick: &TickEvent<'_>| {
            playback.record(tick);
            if began.elapsed() > compute_time {
                is_late = true;
                self.interrupt.store(true, Ordering::Relaxed);
            }
        };
        let mut observer = Observer { clock: &mut clock, on_tick: &mut on_tick };
        let engine = Box::new(CpuEngine::single_threaded());
        let result = self.simulation.run(&self.config, engine, &mut observer)?;
        // The last tick may be late too.
        let is_cut_off = is_late && result.early_end == Some(EarlyEnd::Interrupted);
        let cut_off = is_cut_off.then(|| {
            let (limit_s, time_s) = (compute_time.as_secs(), result.time_s);
            format!(
                "ended by the limit of {limit_s} s of computing after {time_s:.1} s of the drive"
            )
        });
        Ok(DriveRun { result, playback, cut_off })
    }

    fn page(&self, run: &DriveRun) -> String {
        let DriveRun { result, playback, cut_off } = run;
        let intro = "One mission, simulated in a closed loop.".to_owned();
        let intro = match cut_off {
            Some(why) => format!("{intro} It {why}. The command has no such limit."),
            None => intro,
        };
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
            intro: &intro,
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

#[cfg(test)]
mod tests {
    use super::*;

    fn scenes() -> Vec<Scene> {
        Scene::all_built_in(&Config::default(), "").expect("scenes")
    }

    /// A request of the page for the first scene, before anything is changed.
    fn request(scenes: &[Scene]) -> String {
        let problem = &scenes[0].problem;
        let mut request = json!({
            "scene": scenes[0].name, "start": problem["robot"]["pose"], "goal": problem["target"], "people": problem["obstacles"],
        });
        for key in
            ["vx_samples", "vtheta_samples", "sim_time_s", "weights", "normalization", "stopping"]
        {
            request[key] = problem[key].clone();
        }
        request.to_string()
    }

    fn drive<'a>(scenes: &'a [Scene], body: &str) -> Drive<'a> {
        let request = serde_json::from_str(body).expect("a request");
        Drive::new(&scenes[0], &request).unwrap_or_else(|error| panic!("{error:?}"))
    }

    #[test]
    fn drive_that_computes_too_long_names_the_limit_and_its_page_too() {
        let scenes = scenes();
        let drive = drive(&scenes, &request(&scenes));
        let run = drive.run(Duration::ZERO).expect("a drive");
        let why = "ended by the limit of 0 s of computing after 0.0 s of the drive";
        assert_eq!(run.cut_off.as_deref(), Some(why));
        assert!(drive.page(&run).contains(&format!("It {why}.")));
        let whole = self::drive(&scenes, &request(&scenes)).run(Duration::MAX).expect("a drive");
        assert_eq!((whole.cut_off, whole.result.early_end), (None, None));
    }

    #[test]
    fn later_drive_cancels_the_one_before() {
        let (scenes, service) = (scenes(), DriveService::default());
        let (first, body) = (drive(&scenes, &request(&scenes)), request(&scenes));
        drop(service.turn_of(&first).expect("its turn"));
        assert!(service.drive(&scenes, body.as_bytes()).is_ok());
        let run = first.run(COMPUTE_TIME).expect("a drive");
        let ended = (run.result.early_end, run.result.trace.rows.len(), run.cut_off);
        assert_eq!(ended, (Some(EarlyEnd::Interrupted), 0, None));
    }

    /// The sum of 120 steps of 0.05 m is not exactly 6 m.
    #[test]
    fn command_has_the_end_of_a_walk_along_an_axis_without_rounding_errors() {
        let scenes = scenes();
        let command = drive(&scenes, &request(&scenes)).command;
        assert!(command.contains("[[7.1,4.6]]"), "{command}");
    }
}
