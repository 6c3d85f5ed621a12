//! Deciding again on what was observed, and whether the bits agree.

use std::io::Read;

use super::{Head, Recording, RecordingError, Tick};
use crate::local::{Engine, LocalPlanner};
use crate::navigator::{Decision, Navigator};

/// What came of a replay.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// Ticks in the recording.
    pub ticks: u64,
    /// Where a decision first differed; what follows it is not compared, for it rests on another past.
    pub first_difference: Option<Difference>,
    /// Whether the recording holds the drive to its end.
    pub is_complete: bool,
    /// What decided this time, to begin with.
    pub engine: String,
}

/// A number that is not what it was.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Ticks before it.
    pub tick: u64,
    /// When it was, seconds since the drive began.
    pub time_s: f64,
    /// Which number.
    pub field: &'static str,
    /// What it was.
    pub recorded: Number,
    /// What it is now.
    pub replayed: Number,
}

/// A number of a decision.
#[derive(Clone, Debug, PartialEq)]
pub enum Number {
    /// A real one.
    Real(f64),
    /// A whole one.
    Whole(u64),
    /// One that has a word.
    Word(&'static str, u64),
}

impl Number {
    /// Its bits.
    #[must_use]
    pub const fn bits(&self) -> u64 {
        match self {
            Self::Real(value) => value.to_bits(),
            Self::Whole(value) | Self::Word(_, value) => *value,
        }
    }
}

impl Replay {
    /// Whether every decision was the recorded one.
    #[must_use]
    pub const fn agrees(&self) -> bool {
        self.first_difference.is_none()
    }
}

/// Runs the recorded decisions again, to the end of the recording or the first that differs.
///
/// The navigator is made as it was, sees what it saw, and its clock says what each decision took; plans beside the control
/// loop arrive when they arrived. So a drive on a real base, among late decisions and late plans, is repeated as well.
///
/// # Errors
/// When the recording is damaged or cannot be read, or the drive cannot begin.
pub fn replay<R: Read>(
    recording: &mut Recording<R>,
    engine: Box<dyn Engine>,
) -> Result<Replay, RecordingError> {
    let mut navigator = navigator(recording.head(), engine)?;
    let engine = navigator.planner().engine_name();
    let mut ticks = 0;
    let mut first_difference = None;
    while let Some(tick) = recording.next_tick()? {
        ticks += 1;
        if first_difference.is_none() {
            first_difference = decide_again(&mut navigator, &tick);
        }
    }
    Ok(Replay {
        ticks,
        first_difference,
        is_complete: recording.is_complete(),
        engine,
    })
}

/// The navigator as it was when the drive began.
fn navigator(head: &Head, engine: Box<dyn Engine>) -> Result<Navigator, RecordingError> {
    let config = &head.config;
    let known = head.map.obstacles(config.unknown);
    let route_planner = config.route_planner(known.frame().resolution_m);
    Ok(Navigator::new(
        known,
        &head.journey,
        config.robot.model(),
        LocalPlanner::new(engine, config.local.clone()),
        route_planner,
        config.navigator.clone(),
        // Tells how long planning takes, and decides nothing.
        &mut || 0.0,
    )?)
}

fn decide_again(navigator: &mut Navigator, tick: &Tick) -> Option<Difference> {
    let took_before = navigator.plans_received();
    navigator.replay_plan_arrival(tick.plans_received > took_before);
    // Read when a decision begins and when it ends.
    let mut readings = [0.0, tick.took_s].into_iter();
    let mut clock = || readings.next().unwrap_or(tick.took_s);
    let (decision, _) = navigator.step_by(&tick.observation, &mut clock);
    let recorded = numbers(&tick.decision, tick.plans, tick.plans_received);
    let plans = navigator.plans().len() as u64;
    let replayed = numbers(&decision, plans, navigator.plans_received());
    let pairs = recorded.into_iter().zip(replayed);
    let different = |((field, recorded), (_, replayed)): (Named, Named)| {
        (recorded.bits() != replayed.bits()).then_some(Difference {
            tick: tick.tick,
            time_s: tick.observation.time_s,
            field,
            recorded,
            replayed,
        })
    };
    pairs.into_iter().find_map(different)
}

type Named = (&'static str, Number);

/// Everything that a decision consists of.
fn numbers(decision: &Decision, plans: u64, plans_received: u64) -> [Named; 12] {
    let Decision {
        command,
        mode,
        local_target,
        counts,
    } = decision;
    let [admissible, collision, cannot_stop, outside] =
        counts.unwrap_or_default().to_array().map(u64::from);
    [
        ("mode", Number::Word(mode.as_str(), *mode as u64)),
        ("plans", Number::Whole(plans)),
        ("plans_received", Number::Whole(plans_received)),
        ("target_x", Number::Real(local_target.x)),
        ("target_y", Number::Real(local_target.y)),
        ("sampled", Number::Whole(u64::from(counts.is_some()))),
        ("admissible", Number::Whole(admissible)),
        ("collision", Number::Whole(collision)),
        ("cannot_stop", Number::Whole(cannot_stop)),
        ("outside", Number::Whole(outside)),
        ("command_linear", Number::Real(command.linear)),
        ("command_angular", Number::Real(command.angular)),
    ]
}
