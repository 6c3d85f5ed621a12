//! Replays a recording: decides again on the recorded observations and compares the bits.

use core::fmt::{self, Display, Formatter};
use core::ops::ControlFlow;
use std::io::{Read, Seek};
use std::sync::PoisonError;

use serde::{Serialize, Serializer};

use super::controller_reply::RecordedController;
use super::error::RecordingError;
use super::metadata::DriveMetadata;
use super::reader::Reader;
use super::tick::RecordedTick;
use crate::base::ProtectiveAction;
use crate::external::ProgramSettings;
use crate::geometry::Pose;
use crate::local::Engine;
use crate::map::OccupancyGrid;
use crate::navigator::{Controller, Decision, Goal, MapSource, NavigationMap, Navigator};
use crate::runtime::{
    EarlyEnd, GroundTruth, Mission, MissionResult, ObstacleGap, OdometryReading, TickEvent, Trace,
    TraceRow,
};

/// The result of a replay.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Replay {
    /// The mission of the recording.
    pub mission: Mission,
    /// The drive up to the first difference, as the robot knew it: poses are estimated, gaps are those to the map, and there
    /// are no moving obstacles.
    pub drive: MissionResult,
    /// Number of ticks in the recording.
    pub ticks: u64,
    /// The first difference. Later decisions are not compared, because they depend on it.
    pub first_difference: Option<Difference>,
    /// Whether the recording holds the whole drive.
    pub is_complete: bool,
    /// Name of the engine at the start of the replay.
    pub engine: String,
}

/// A value that differs between recording and replay.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Difference {
    /// Number of earlier ticks.
    pub tick: u64,
    /// Time since the start of the drive, seconds.
    pub time_s: f64,
    /// Name of the field.
    pub field: &'static str,
    /// The recorded value.
    pub recorded: FieldValue,
    /// The replayed value.
    pub replayed: FieldValue,
}

/// A value of a decision.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldValue {
    /// A real number.
    Real(f64),
    /// A count.
    Count(u64),
    /// A named constant and its number.
    Named(&'static str, u64),
}

impl FieldValue {
    /// The bits of the value.
    #[must_use]
    pub const fn bits(&self) -> u64 {
        match self {
            Self::Real(value) => value.to_bits(),
            Self::Count(value) | Self::Named(_, value) => *value,
        }
    }
}

impl Display for FieldValue {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Real(value) => value.fmt(formatter),
            Self::Count(value) => value.fmt(formatter),
            Self::Named(name, _) => formatter.write_str(name),
        }
    }
}

/// A number as a number, a constant by its name.
impl Serialize for FieldValue {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Real(value) => serializer.serialize_f64(*value),
            Self::Count(value) => serializer.serialize_u64(*value),
            Self::Named(name, _) => serializer.serialize_str(name),
        }
    }
}

impl Replay {
    /// Whether every decision equals the recorded one.
    #[must_use]
    pub const fn agrees(&self) -> bool {
        self.first_difference.is_none()
    }

    /// Number of decisions that the CPU took in place of a GPU, because the GPU failed or was missing. They do not show what the
    /// GPU decides.
    #[must_use]
    pub fn cpu_ticks(&self) -> u64 {
        self.drive.incidents.as_ref().map_or(0, |incidents| incidents.on_cpu)
    }
}

/// Repeats the recorded decisions up to the end of the recording or the first difference.
///
/// The navigator has the recorded settings and observations. Its clock returns the recorded durations of the decisions, and
/// asynchronous plans arrive at the recorded ticks. So a drive with a real base, late decisions and late plans is repeatable. The
/// user's own controller does not run again, because its answers are recorded. A program that planned the paths runs again, but
/// never by the command in the recording, which may be of another person: `global_planner` is the command to run.
///
/// `on_tick` is called after each equal tick; it may end the replay.
///
/// # Errors
/// When the recording has no tick, is damaged or cannot be read, `on_tick` ends the replay, the drive cannot start, or a global planner is given where the drive had none,
/// or none where it had one.
pub fn replay<R: Read + Seek>(
    reader: &mut Reader<R>,
    engine: Box<dyn Engine>,
    global_planner: Option<&[String]>,
    on_tick: &mut dyn FnMut(&TickEvent<'_>) -> ControlFlow<()>,
) -> Result<Replay, RecordingError> {
    let DriveMetadata { mut config, waypoints, map, zones, controller, .. } =
        reader.metadata().clone();
    set_global_planner(&mut config.global_planner, global_planner)?;
    let known = NavigationMap { obstacles: map.obstacles(config.unknown), zones: zones.clone() };
    let footprint = &config.robot.footprint;
    let mut gap = ObstacleGap::new(known.obstacles.clone());
    // The clock measures the duration of planning, which no decision depends on.
    let (controller, next_reply) = controller.map(RecordedController::new).unzip();
    let controller = controller.map(|it| Box::new(it) as Box<dyn Controller>);
    let clock = &mut || 0.0;
    let mut navigator = config.new_navigator_with(known, &waypoints, engine, controller, clock)?;
    let engine = navigator.planner().engine_name();
    let (mut trace, mut decision_s, mut start) = (Trace::default(), Vec::new(), None);
    let (mut ticks, mut first_difference) = (0, None);
    while let Some(tick) = reader.next_tick()? {
        ticks += 1;
        if first_difference.is_some() {
            continue;
        }
        if let Some(next) = &next_reply {
            next.lock().unwrap_or_else(PoisonError::into_inner).clone_from(&tick.reply);
        }
        let updated_map = reader.take_updated_map();
        if let Some(map) = &updated_map {
            let zones = zones.clone();
            let known = NavigationMap { obstacles: map.obstacles(config.unknown), zones };
            gap = ObstacleGap::new(known.obstacles.clone());
            navigator.replace_map(config.prepare_map(known)?, MapSource::Scans);
        }
        first_difference = repeat(&mut navigator, &tick);
        if first_difference.is_none() {
            start = start.or(Some(tick.observation.pose));
            let gap_m = |pose: &Pose| gap.gap_m(footprint, pose);
            let (row, flow) = show(&tick, updated_map.as_ref(), gap_m, &navigator, on_tick);
            if flow.is_break() {
                return Err(RecordingError::Interrupted { ticks });
            }
            trace.rows.push(row);
            decision_s.push(tick.took_s);
        }
    }
    if ticks == 0 {
        return Err(RecordingError::NotOurs { missing: "tick" });
    }
    let place = waypoints.start;
    let start = start.unwrap_or(Pose::new(place.x, place.y, 0.0));
    let (via, goal) = match waypoints.goals.split_last() {
        Some((goal, via)) => (via.to_vec(), *goal),
        None => (Vec::new(), Goal::at(place)),
    };
    let mission = Mission { zones, via, ..Mission::new(map, start, goal) };
    let is_complete = reader.is_complete();
    let early_end = (!is_complete).then_some(EarlyEnd::RecordingTruncated);
    let drive = MissionResult::of_drive(&mission, trace, &navigator, decision_s, engine.clone());
    let drive = MissionResult { early_end, ..drive };
    Ok(Replay { mission, drive, ticks, first_difference, is_complete, engine })
}

/// Shows a tick. `gap_m` measures the gap on the map at a pose, metres. Returns its row, and whether the replay goes on.
fn show(
    tick: &RecordedTick,
    updated_map: Option<&OccupancyGrid>,
    gap_m: impl FnOnce(&Pose) -> f64,
    navigator: &Navigator,
    on_tick: &mut dyn FnMut(&TickEvent<'_>) -> ControlFlow<()>,
) -> (TraceRow, ControlFlow<()>) {
    let RecordedTick { observation, decision, took_s, .. } = tick;
    let estimated = GroundTruth::of(observation, observation.twist);
    let gap_m = estimated.gap_m.unwrap_or_else(|| gap_m(&estimated.pose));
    let path = navigator.plans().len() - 1;
    let row = TraceRow::new(observation, decision, estimated, gap_m, path);
    let flow = on_tick(&TickEvent {
        row: &row,
        observation,
        odometry: &OdometryReading { pose: observation.pose, twist: observation.twist },
        fix: None,
        decision,
        took_s: *took_s,
        moving_radii: &[],
        protective_action: &ProtectiveAction::Pass,
        robot_fault: None,
        updated_map,
        navigator,
    });
    (row, flow)
}

/// Replaces the recorded command of a global planner by the given one.
fn set_global_planner(
    recorded: &mut ProgramSettings,
    given: Option<&[String]>,
) -> Result<(), RecordingError> {
    match (recorded.name(), given) {
        (None, None) => {}
        (Some(_), Some(given)) => recorded.command = given.to_vec(),
        (Some(name), None) => {
            let command = name.escape_debug().to_string();
            return Err(RecordingError::PlannerNotGiven { command });
        }
        (None, Some(_)) => return Err(RecordingError::NoPlanner),
    }
    Ok(())
}

/// Repeats a decision and returns its first difference.
fn repeat(navigator: &mut Navigator, tick: &RecordedTick) -> Option<Difference> {
    let is_plan_received = tick.plans_received > navigator.plans_received();
    navigator.replay_plan_arrival(is_plan_received);
    // The navigator reads the clock at the start and at the end of a decision.
    let mut readings = [0.0, tick.took_s].into_iter();
    let mut clock = || readings.next().unwrap_or(tick.took_s);
    let (decision, _) = navigator.step_by(&tick.observation, &mut clock);
    if tick.awaits_operator {
        navigator.restart_progress();
    }
    let recorded = fields(&tick.decision, tick.plans, tick.plans_received);
    let plans = navigator.plans().len() as u64;
    let replayed = fields(&decision, plans, navigator.plans_received());
    let mut pairs = recorded.into_iter().zip(replayed);
    pairs.find_map(|((field, recorded), (_, replayed))| {
        (recorded.bits() != replayed.bits()).then_some(Difference {
            tick: tick.tick,
            time_s: tick.observation.time_s,
            field,
            recorded,
            replayed,
        })
    })
}

/// All values of a decision.
fn fields(
    decision: &Decision,
    plans: u64,
    plans_received: u64,
) -> [(&'static str, FieldValue); 12] {
    let Decision { command, mode, local_target, counts } = decision;
    let [admissible, collision, cannot_stop, outside] =
        counts.unwrap_or_default().to_array().map(u64::from);
    [
        ("mode", FieldValue::Named(mode.name(), *mode as u64)),
        ("plans", FieldValue::Count(plans)),
        ("plans_received", FieldValue::Count(plans_received)),
        ("target_x", FieldValue::Real(local_target.x)),
        ("target_y", FieldValue::Real(local_target.y)),
        ("sampled", FieldValue::Count(u64::from(counts.is_some()))),
        ("admissible", FieldValue::Count(admissible)),
        ("collision", FieldValue::Count(collision)),
        ("cannot_stop", FieldValue::Count(cannot_stop)),
        ("outside", FieldValue::Count(outside)),
        ("command_linear", FieldValue::Real(command.linear)),
        ("command_angular", FieldValue::Real(command.angular)),
    ]
}
