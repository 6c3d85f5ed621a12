//! `inbye drive`.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, anyhow};
use clap::Args;
use inbye::global::PlanError;
use inbye::live::{LiveDrive, LiveView};
use inbye::local::{DecisionError, Engine};
use inbye::map::{ObstacleGrid, OccupancyGrid};
use inbye::navigator::{Fault, Goal};
use inbye::report::{MissionView, PlaybackRecorder};
use inbye::runtime::{
    Config, Mission, MissionError, MissionResult, Observer, PoseSource, TickEvent, run_mission,
};
use inbye::sim::{MovingObstacles, SimError, Simulation};
use serde_json::{Value, json};

use super::arguments::{EngineArguments, Place, above_zero, duration, real, whole};
use super::drive_pictures::{PictureArguments, Pictures};
use super::drive_text::{self, DriveLog};
use super::files::{all_written, command_line, open_file};
use super::hardware_drive::{HardwareArguments, HardwareDrive, HardwareReport};
use super::machine::{interrupt_flag, wall_clock};
use super::map_file::{self, EndArguments, MapArguments, MapInput, MapSettings};
use super::map_output::MapOutput;
use super::own_file::OutputFile;
use super::own_programs::ProgramArguments;
use super::plan_result::stop_name;
use super::recording::{Ending, Recording};
use super::refusal::refused;
use super::zones::ZoneArguments;
use super::{output, plan};

/// `inbye drive`.
#[derive(Debug, Args)]
#[command(
    mut_arg("start", |start| start.required_unless_present_any(["scene", "unknown_start"])),
    after_help = "Example:\n  inbye drive --scene mine --report out\n  inbye drive --scene mine --record run.mcap\n  \
    inbye drive --map mine.yaml --start 10,5 --goal 80,40 --obstacles 5 --seed 7\n\n\
    With --port the command drives a real or emulated base on a serial line, in real time. With --lidar nothing is simulated: the \
    pose comes from the scans of an LD19, matched to the map. The robot stands still while its pose is unknown or its lidar is \
    silent. If that lasts, it gives up with the reason (exit status 1). With --simulated-senses the world and the lidar are \
    simulated, and the pose is the base's odometry. The base is stopped when it gets no command for 0.3 s, when it does not \
    follow its commands, and at the end of the drive; see `inbye base send --help`."
)]
pub struct DriveArguments {
    #[command(flatten)]
    pub map: MapArguments,
    #[command(flatten)]
    pub ends: EndArguments,
    /// An intermediate stop, metres, and optionally its yaw, radians; repeat --via for each stop in order.
    #[arg(long, value_name = "X,Y[,YAW]", allow_hyphen_values = true)]
    pub via: Vec<Place>,
    /// The robot does not know where it starts: it stands still until its scans match exactly one place of the map. Needs the
    /// pose from scans.
    #[arg(long)]
    pub unknown_start: bool,
    /// Map of the simulated world, if it differs from the robot's map. It must have the size, the resolution and the origin of
    /// --map.
    #[arg(long, value_name = "FILE", conflicts_with = "port")]
    pub truth: Option<PathBuf>,
    /// Write the map with the changes that scans showed for a minute: obstacles that appeared or vanished. Needs the pose from
    /// scans.
    #[arg(long, value_name = "FILE.yaml")]
    pub update_map: Option<PathBuf>,
    /// Number of pedestrians, or a JSON or TOML file of moving obstacles [default: 0, or those of the scene].
    #[arg(long, value_name = "N or FILE", allow_negative_numbers = true)]
    pub obstacles: Option<Obstacles>,
    /// Seed of pedestrians and lidar noise [default: 0, or that of the scene].
    #[arg(long, allow_negative_numbers = true, value_parser = whole::<u64>(0, u64::MAX))]
    pub seed: Option<u64>,
    #[command(flatten)]
    pub programs: ProgramArguments,
    #[command(flatten)]
    pub engine: EngineArguments,
    /// Fail without a GPU; a software adapter counts if --engine names it. If the GPU is lost during the drive, the CPU takes over
    /// and the loss is counted.
    #[arg(long)]
    pub require_gpu: bool,
    /// Deadline of a decision by the wall clock, milliseconds. A late decision is replaced by the last command, which decays with
    /// its age, and repeated misses reduce the sampling. Such a run is not repeatable. Waiting for plans counts, unless the
    /// settings have `wait_for_plans = false` [default: the configuration's `deadline_s`; without it none in simulation, one control
    /// period on a real base].
    #[arg(long, value_name = "MS", allow_negative_numbers = true, value_parser = real(above_zero(1e6), "milliseconds, above zero and at most 1e6"))]
    pub deadline: Option<f64>,
    /// Time limit of the drive, seconds of simulated time; on a real base of real time, without the time in which it waits for its
    /// operator.
    #[arg(long, default_value_t = 3600.0, allow_negative_numbers = true, value_parser = duration)]
    pub time_limit: f64,
    #[command(flatten)]
    pub pictures: PictureArguments,
    /// Show the running drive in a browser, at this port of localhost; 0 selects any free port. A simulated drive then runs in real
    /// time; see --real-time-factor.
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = "0", allow_negative_numbers = true, value_parser = whole::<u16>(0, 65_535))]
    pub live: Option<u16>,
    /// Simulated seconds per second [default: 1 with --live, else as fast as possible].
    #[arg(long, value_name = "FACTOR", conflicts_with = "port", allow_negative_numbers = true, value_parser = real(0.01..=1000.0, "0.01 to 1000"))]
    pub real_time_factor: Option<f64>,
    /// Record the drive in this file. If its name ends in .mcap, it has ROS 2 messages for Foxglove, `ros2 bag` and `inbye replay`,
    /// else a line of JSON for each tick. A full disk stops the recording, never the drive: then the exit status is 1, and
    /// `recording.stopped` gives the reason.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    #[command(flatten)]
    pub hardware: HardwareArguments,
}

/// Most obstacles of a decision.
const MAX_OBSTACLES: u64 = 1024;

/// Moving obstacles: a number of pedestrians, or a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Obstacles {
    /// Number of pedestrians.
    Count(usize),
    /// A JSON or TOML file.
    File(PathBuf),
}

impl FromStr for Obstacles {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.parse::<f64>().is_err() {
            return Ok(Self::File(text.into()));
        }
        whole(0, MAX_OBSTACLES)(text)
            .map(Self::Count)
            .map_err(|expected| format!("{expected}, or the name of a JSON or TOML file"))
    }
}

/// The pose comes from scans with a real lidar; only then, or where the settings say so, a robot finds its own start.
fn set_pose_source(
    arguments: &DriveArguments,
    obstacles: &Obstacles,
    config: &mut Config,
) -> anyhow::Result<()> {
    if arguments.hardware.lidar.is_some() {
        anyhow::ensure!(
            matches!(obstacles, Obstacles::Count(0)),
            "--obstacles are simulated, but --lidar measures real ones: leave one of them out"
        );
        config.pose_source = PoseSource::Scans;
    }
    anyhow::ensure!(
        !arguments.unknown_start || config.pose_source == PoseSource::Scans,
        "--unknown-start needs the pose from scans: add --set pose_source=scans, or --lidar on a real robot"
    );
    anyhow::ensure!(
        arguments.update_map.is_none() || config.pose_source == PoseSource::Scans,
        "--update-map needs the pose from scans: add --set pose_source=scans, or --lidar on a real robot"
    );
    Ok(())
}

/// The obstacles of the world, where it differs from the map. `resolution_m` is the side of a cell of a map that does not state it.
fn truth(
    arguments: &DriveArguments,
    map: &OccupancyGrid,
    config: &Config,
    resolution_m: f64,
) -> anyhow::Result<Option<ObstacleGrid>> {
    let Some(file) = &arguments.truth else {
        return Ok(None);
    };
    let truth = map_file::load(file, resolution_m)?;
    anyhow::ensure!(
        truth.frame() == map.frame(),
        "--truth {}: it must have the size, the resolution and the origin of --map",
        file.display()
    );
    Ok(Some(truth.obstacles(config.unknown)))
}

/// Drives to a goal. Returns false if it is not reached, an obstacle was hit, or the recording is incomplete.
pub fn run(arguments: &DriveArguments) -> anyhow::Result<bool> {
    let MapInput { name: map_name, map, zones, mut config, scene, resolution_m } =
        map_file::read(&arguments.map, arguments.truth.as_deref())?;
    let needs_start = !arguments.unknown_start || arguments.hardware.lidar.is_none();
    let (start, goal) = arguments.ends.resolve(scene.as_ref(), needs_start)?;
    arguments.map.zones.check(zones.as_deref(), (&start, &goal), &arguments.via)?;
    let seed = arguments.seed.or(scene.as_ref().map(|scene| scene.seed)).unwrap_or(0);
    // A lidar measures the real surroundings: no scene's pedestrians are among them.
    let pedestrians = scene.filter(|_| arguments.hardware.lidar.is_none());
    let pedestrians = Obstacles::Count(pedestrians.map_or(0, |scene| scene.obstacles));
    let obstacles = arguments.obstacles.clone().unwrap_or(pedestrians);
    arguments.programs.set(&mut config);
    if let Some(deadline_ms) = arguments.deadline {
        config.navigator.deadline_s = Some(deadline_ms / 1e3);
    }
    set_pose_source(arguments, &obstacles, &mut config)?;
    let interrupt = interrupt_flag()?;
    let mut hardware = arguments.hardware.connect(start.pose(), &config)?;
    if let Some(hardware) = &hardware {
        hardware.cap_speed(&mut config.robot.limits);
    }
    let stop = |place: &Place| Goal { position: place.position, yaw: place.yaw };
    let mission = Mission {
        zones,
        via: arguments.via.iter().map(stop).collect(),
        is_start_unknown: arguments.unknown_start,
        time_limit_s: arguments.time_limit,
        interrupt: Some(interrupt),
        ..Mission::new(Arc::new(map), start.pose(), stop(&goal))
    };
    let moving_obstacles = match &obstacles {
        Obstacles::File(file) => obstacles_of(file, &mission, &config, seed)?,
        Obstacles::Count(count) => {
            let spawner = config.simulation.pedestrians.spawner(*count, seed);
            match spawner.spawn_on_route(&mission, &config) {
                Ok(moving_obstacles) => moving_obstacles,
                Err(error) => {
                    return no_path_or(error, (&map_name, &arguments.map.zones), &mission, &config);
                }
            }
        }
    };
    let truth = truth(arguments, &mission.map, &config, resolution_m)?;
    let files = DriveFiles::create(arguments)?;
    let simulation = Simulation { truth, moving_obstacles, seed, ..Simulation::new(mission) };
    let mission = &simulation.mission;
    let engine = arguments.engine.open(&config, arguments.require_gpu)?;
    // The live page records the ticks itself.
    let mut playback = if arguments.live.is_none() { files.playback() } else { None };
    let mut recording = files
        .recording
        .map(|file| Recording::begin(file, mission, &config, engine.name(), hardware.as_ref()));
    let live = live_view(arguments, &map_name, mission, &config, hardware.as_ref())?;
    let observers = DriveObservers {
        playback: playback.as_mut(),
        recording: recording.as_mut(),
        live: live.as_ref(),
        real_time_factor: arguments.real_time_factor(),
    };
    let driven = drive(&simulation, &config, engine, "driving", hardware.as_mut(), observers);
    // The base stops before anything is written.
    let late_ticks = driven.as_ref().map_or(0, |result| result.late_ticks);
    let base = hardware.map(|hardware| hardware.end(late_ticks));
    let result = match driven {
        Ok(result) => result,
        Err(SimError::Mission(MissionError::Fault(Fault::Choose(DecisionError::Problem(
            error,
        ))))) => {
            // The source of the invalid setting.
            let MapSettings { config: file, changes, .. } = &arguments.map.settings;
            return Err(anyhow!(error)).with_context(|| match file {
                Some(file) if changes.is_empty() => format!("{}: with {map_name}", file.display()),
                None if changes.is_empty() => format!("{map_name}: with the default settings"),
                _ => format!("{map_name}: with these settings"),
            });
        }
        Err(error) => {
            return no_path_or(error, (&map_name, &arguments.map.zones), mission, &config);
        }
    };
    let playback = live.map(|live| live.end(&result)).or(playback);
    let recording = recording.map(|recording| recording.end(&result));
    let is_sound = base.as_ref().is_none_or(|base| base.is_sound);
    // The result comes first: a picture that cannot be written must not cost it.
    let (object, lines) = outcome(&result, mission, &config, base, recording.as_ref());
    output::result(&object, lines)?;
    let changes = files.updated_map.zip(result.map_changes.as_ref());
    let mapped = changes.map(|(output, it)| output.write(&it.applied_to(&mission.map)).map(drop));
    let drawn = playback.as_ref().filter(|_| files.pictures.are_requested).map(|playback| {
        let (command, facts) = (&command_line(), &drive_text::facts(&result, seed));
        let view = MissionView {
            title: &map_name,
            command,
            mission,
            config: &config,
            result: &result,
            playback: Some(playback),
            facts,
        };
        files.pictures.write(arguments.hardware.description(), view, playback)
    });
    all_written(mapped.into_iter().chain(drawn))?;
    let is_recorded = recording.is_none_or(|recording| recording.is_whole);
    Ok(result.reached && !result.collided && is_recorded && is_sound)
}

/// The result as JSON and as text.
fn outcome(
    result: &MissionResult,
    mission: &Mission,
    config: &Config,
    base: Option<HardwareReport>,
    recording: Option<&Ending>,
) -> (Value, Vec<String>) {
    let mut object = drive_text::object(result);
    object["map_changes"] = json!(result.map_changes.as_ref().map(|changes| {
        let [appeared, vanished] = changes.areas(mission.map.frame());
        json!({ "appeared": appeared, "vanished": vanished })
    }));
    object["unknown"] = map_file::unknown_cells_json(&mission.map, config.unknown);
    object["recording"] = json!(recording.as_ref().map(|recording| &recording.object));
    if let Some(base) = &base {
        object["base"] = base.object.clone();
        if object["fault"].is_null() {
            object["fault"] = base.object["stop_cause"].clone();
        }
    }
    let mut lines = drive_text::lines(result);
    lines.extend(drive_text::map_changes(result, mission.map.frame()));
    let unknown = map_file::unknown_cells_text(&mission.map, config.unknown);
    lines.extend(unknown.map(|text| format!("unknown      {text}")));
    lines.extend(base.into_iter().flat_map(|base| base.lines));
    lines.extend(recording.as_ref().map(|recording| recording.line.clone()));
    (object, lines)
}

/// The output files of a drive. They are opened before it: a wrong name must not cost an hour of driving.
struct DriveFiles<'a> {
    recording: Option<(OutputFile, &'a Path)>,
    pictures: Pictures<'a>,
    updated_map: Option<MapOutput<'a>>,
}

impl<'a> DriveFiles<'a> {
    fn create(arguments: &'a DriveArguments) -> anyhow::Result<Self> {
        let name = arguments.record.as_deref();
        let recording = name.map(|name| open_file("--record", name)).transpose()?.zip(name);
        let updated = arguments.update_map.as_deref();
        Ok(Self {
            recording,
            pictures: Pictures::create(&arguments.pictures)?,
            updated_map: updated.map(|name| MapOutput::create("--update-map", name)).transpose()?,
        })
    }

    /// The recorder of what the pictures show. It costs time in every tick.
    fn playback(&self) -> Option<PlaybackRecorder> {
        self.pictures.are_requested.then(PlaybackRecorder::default)
    }
}

impl DriveArguments {
    /// Simulated seconds per second; none for a drive as fast as possible, and for a real base, which has its own time.
    fn real_time_factor(&self) -> Option<f64> {
        let default = self.live.filter(|_| self.hardware.port.is_none()).map(|_| 1.0);
        self.real_time_factor.or(default)
    }
}

/// Serves the page of a running drive, if it is requested.
fn live_view(
    arguments: &DriveArguments,
    title: &str,
    mission: &Mission,
    config: &Config,
    hardware: Option<&HardwareDrive>,
) -> anyhow::Result<Option<LiveView>> {
    let Some(port) = arguments.live else {
        return Ok(None);
    };
    let stop =
        hardware.filter(|_| arguments.hardware.operator).map(|base| base.operator.switch.clone());
    let drive = LiveDrive { title, command: &command_line(), mission, config, stop };
    let live = LiveView::start(port, drive).map_err(|error| {
        let what = format!("--live {port}: cannot be served");
        refused(what, error, "choose another port, or 0 for any free one")
    })?;
    output::note(format!("the drive is shown at http://{}/", live.address()));
    Ok(Some(live))
}

/// What observes a drive.
#[derive(Default)]
pub struct DriveObservers<'a, 'r> {
    pub playback: Option<&'a mut PlaybackRecorder>,
    pub recording: Option<&'a mut Recording<'r>>,
    pub live: Option<&'a LiveView>,
    /// Simulated seconds per second; none: as fast as possible.
    pub real_time_factor: Option<f64>,
}

/// Runs a mission with the wall clock and a progress bar: on a real base if one is connected, else simulated.
pub fn drive(
    simulation: &Simulation,
    config: &Config,
    engine: Box<dyn Engine>,
    what: &str,
    hardware: Option<&mut HardwareDrive>,
    observers: DriveObservers<'_, '_>,
) -> Result<MissionResult, SimError> {
    let DriveObservers { mut playback, mut recording, live, real_time_factor } = observers;
    let mission = &simulation.mission;
    let goal = mission.goal.position;
    let far_m = (goal - mission.start.position()).norm();
    if let Some(warning) = recording.as_ref().and_then(|it| it.warning()) {
        output::warn(warning);
    }
    let bar = output::progress_m(far_m, what);
    let mut nearest_m = far_m;
    let began = Instant::now();
    let mut log = output::is_verbose().then(DriveLog::default);
    let (mut is_late_known, mut waits) = (false, false);
    let operator = hardware.as_ref().map(|hardware| hardware.operator.clone());
    let mut on_tick = |tick: &TickEvent<'_>| {
        if let Some(playback) = &mut playback {
            playback.record(tick);
        }
        if let Some(live) = live {
            live.record(tick);
        }
        if let Some(log) = &mut log {
            log.update(tick);
        }
        let late = tick.navigator.tick_clock().last().warning();
        if let Some(late) = late.filter(|_| !std::mem::replace(&mut is_late_known, true)) {
            bar.suspend(|| output::warn(format!("the control loop is late: {late}")));
        }
        let action = tick.protective_action;
        if std::mem::replace(&mut waits, action.awaits_operator()) != waits {
            let state = if waits { action.name().replace('_', " ") } else { what.to_owned() };
            bar.set_message(state);
        }
        let away_m = (goal - tick.row.pose.position()).norm();
        operator.iter().for_each(|operator| operator.show(tick, away_m));
        nearest_m = nearest_m.min(away_m);
        bar.set_position(output::whole_cm(far_m - nearest_m));
        if let Some(warning) = recording.as_mut().and_then(|it| it.record(tick)) {
            bar.suspend(|| output::warn(warning));
        }
        if let Some(factor) = real_time_factor {
            let due = Duration::from_secs_f64(tick.row.time_s / factor);
            thread::sleep(due.saturating_sub(began.elapsed()));
        }
    };
    let mut clock = wall_clock();
    let mut observer = Observer { clock: &mut clock, on_tick: &mut on_tick };
    let result = match hardware {
        Some(HardwareDrive { robot, lidar_port: Some(_), .. }) => {
            run_mission(mission, config, engine, robot, &mut observer).map_err(SimError::from)
        }
        Some(hardware) => simulation.run_with(&mut hardware.robot, config, engine, &mut observer),
        None => simulation.run(config, engine, &mut observer),
    };
    bar.finish_and_clear();
    result
}

/// The moving obstacles of a file. None may touch the robot at its start.
fn obstacles_of(
    file: &Path,
    mission: &Mission,
    config: &Config,
    seed: u64,
) -> Result<MovingObstacles, SimError> {
    let obstacles = MovingObstacles::read(file, &mission.map.obstacles(config.unknown), seed)?;
    obstacles.check_start(file, &mission.start, &config.robot.footprint)?;
    Ok(obstacles)
}

/// The intermediate stop at which an error of a plan is.
fn stop_of(error: &PlanError, mission: &Mission) -> Option<String> {
    let (PlanError::GoalOccupied { place, .. }
    | PlanError::GoalOutsideMap { place, .. }
    | PlanError::NoValidPath { goal: place, .. }) = error
    else {
        return None;
    };
    let index = mission.via.iter().position(|stop| stop.position == *place)?;
    Some(stop_name(index + 1))
}

/// Prints a missing path, which is an answer; every other planning error is unusable input.
fn no_path_or(
    error: SimError,
    (map_name, zones): (&str, &ZoneArguments),
    mission: &Mission,
    config: &Config,
) -> anyhow::Result<bool> {
    let SimError::Mission(MissionError::Fault(Fault::Plan(error))) = error else {
        return Err(error.into());
    };
    let stop = stop_of(&error, mission);
    let reason = match &stop {
        Some(stop) => format!("{stop}: {error}"),
        None => error.to_string(),
    } + zones.note(&error);
    if !matches!(error, PlanError::NoValidPath { .. }) {
        return Err(plan::unusable(&error, &reason, map_name, &mission.map, config, None));
    }
    let mut object = plan::no_path_json(&error, &reason);
    object["stop"] = json!(stop);
    object["reached"] = json!(false);
    object["collided"] = json!(false);
    object["interrupted"] = json!(false);
    object["fault"] = json!(reason);
    object["why"] = json!(reason);
    output::result(&object, [reason])?;
    Ok(false)
}
