//! Arguments that several commands share, and parsers of argument values.

use core::f64::consts::TAU;
use std::ffi::OsStr;
use std::str::FromStr;

use clap::builder::{PossibleValue, TypedValueParser};
use clap::{Arg, Args, Command, Error};
use inbye::base::Protocol;
use inbye::bench::{DecisionSize, EngineRequest};
use inbye::geometry::{Point, Pose};
use inbye::local::{CpuEngine, Engine};
use inbye::map::UnknownPolicy;
use inbye::runtime::{Config, PlantKind, PoseSource};
use inbye::sim::SCENE_NAMES;

use super::{engine_selection, machine, output};

/// The engine that decides in a closed loop.
#[derive(Debug, Args)]
pub struct EngineArguments {
    /// Engine: `auto` measures once which is fastest; gpu:NAME is an adapter whose name contains NAME.
    #[arg(long, default_value = "auto", value_parser = engine())]
    pub engine: EngineRequest,
    /// CPU threads; `auto` uses at most this many [default: all cores].
    #[arg(long, allow_negative_numbers = true, value_parser = whole::<usize>(1, CpuEngine::MAX_THREADS as u64))]
    pub threads: Option<usize>,
}

impl EngineArguments {
    /// Opens the engine, a GPU only with the CPU as fallback, and prints which one and why to standard error.
    pub fn open(&self, config: &Config, gpu_required: bool) -> anyhow::Result<Box<dyn Engine>> {
        let threads = self.threads.unwrap_or_else(machine::cores);
        let size = decision_size(config);
        engine_selection::open_to_drive(&self.engine, &size, threads, gpu_required)
    }
}

/// Size of the decisions with these settings.
pub fn decision_size(config: &Config) -> DecisionSize {
    DecisionSize::new(&config.local, config.robot.footprint.discs().len())
}

/// Largest coordinate, metres.
const MAX_COORDINATE: f64 = 1e9;

/// A yaw beyond a whole turn is probably in degrees.
const WHOLE_TURN: f64 = TAU + 0.01;

/// A position with an optional yaw: two or three numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Position, metres.
    pub position: Point,
    /// Yaw, radians.
    pub yaw: Option<f64>,
}

impl Place {
    /// Converts to a pose; the default yaw is 0.
    pub fn pose(&self) -> Pose {
        Pose::new(self.position.x, self.position.y, self.yaw.unwrap_or(0.0))
    }

    /// Warns of a yaw that is probably in degrees.
    pub fn warn_of_degrees(&self, flag: &str) {
        if let Some(yaw) = self.yaw.filter(|yaw| yaw.abs() > WHOLE_TURN) {
            output::warn(format!(
                "{flag}: a yaw of {yaw} rad is more than a turn: yaws are in radians; {yaw} degrees are {:.4} rad",
                yaw.to_radians()
            ));
        }
    }
}

impl FromStr for Place {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |part: &str| {
            part.trim().parse().ok().filter(|number: &f64| number.abs() <= MAX_COORDINATE)
        };
        let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
        match numbers.as_deref() {
            Some(&[x, y]) => Ok(Self { position: Point::new(x, y), yaw: None }),
            Some(&[x, y, yaw]) => Ok(Self { position: Point::new(x, y), yaw: Some(yaw) }),
            _ => Err(format!(
                "`{text}` is not a position: write X,Y or X,Y,YAW in metres and radians, such as 2.5,-1,0"
            )),
        }
    }
}

/// Returns a parser of whole numbers in a range.
pub fn whole<T: TryFrom<u64>>(
    min: u64,
    max: u64,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync {
    move |text| {
        let number: Option<u64> = text.parse().ok();
        number
            .filter(|number| (min..=max).contains(number))
            .and_then(|number| T::try_from(number).ok())
            .ok_or_else(|| format!("it must be a whole number, {min} to {max}"))
    }
}

/// Parses a length above zero, metres.
pub fn length(text: &str) -> Result<f64, String> {
    let is_valid = |metres: f64| metres > 0.0 && metres <= MAX_COORDINATE;
    number(text, is_valid, "metres, above zero and at most 1e9")
}

/// Parses a distance, metres.
pub fn distance(text: &str) -> Result<f64, String> {
    let is_valid = |metres: f64| (0.0..=MAX_COORDINATE).contains(&metres);
    number(text, is_valid, "metres, 0 to 1e9")
}

/// Parses a duration above zero, seconds.
pub fn duration(text: &str) -> Result<f64, String> {
    let is_valid = |seconds: f64| seconds > 0.0 && seconds <= 1e9;
    number(text, is_valid, "seconds, above zero and at most 1e9")
}

/// Parses a number; the error names the expected numbers.
pub fn number(text: &str, is_valid: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(number) if is_valid(number) => Ok(number),
        _ => Err(format!("it must be a number: {expected}")),
    }
}

/// Parses a value by a function and lists keywords for the help and for shell completion.
#[derive(Clone)]
pub struct KeywordParser<T> {
    keywords: Vec<&'static str>,
    parse: fn(&str) -> Result<T, String>,
}

/// Parses an engine: `auto`, `cpu`, `gpu`, or `gpu:` with part of an adapter's name.
pub fn engine() -> KeywordParser<EngineRequest> {
    KeywordParser { keywords: vec!["auto", "cpu", "gpu"], parse: str::parse }
}

/// Parses a base's protocol.
pub fn protocol() -> KeywordParser<Protocol> {
    KeywordParser { keywords: Protocol::ALL.map(Protocol::name).to_vec(), parse: str::parse }
}

/// Parses the policy for unknown cells.
pub fn unknown() -> KeywordParser<UnknownPolicy> {
    let parse = |text: &str| match text {
        "blocked" => Ok(UnknownPolicy::Blocked),
        "free" => Ok(UnknownPolicy::Free),
        _ => Err(format!("`{text}` is neither blocked nor free")),
    };
    KeywordParser { keywords: vec!["blocked", "free"], parse }
}

/// Parses the name of a built-in scene.
pub fn scene() -> KeywordParser<&'static str> {
    let parse = |text: &str| {
        let name = SCENE_NAMES.iter().find(|name| **name == text);
        name.copied().ok_or_else(|| format!("`{text}` is none of {}", SCENE_NAMES.join(", ")))
    };
    KeywordParser { keywords: SCENE_NAMES.to_vec(), parse }
}

/// Parses the source of the pose.
pub fn pose_source() -> KeywordParser<PoseSource> {
    let parse = |text: &str| match text {
        "fixes" => Ok(PoseSource::Fixes),
        "scans" => Ok(PoseSource::Scans),
        _ => Err(format!("`{text}` is neither fixes nor scans")),
    };
    KeywordParser { keywords: vec!["fixes", "scans"], parse }
}

/// Parses a choice of simulated robots; the kinds in the order of the rows.
pub fn plants() -> KeywordParser<&'static [PlantKind]> {
    let parse = |text: &str| -> Result<&'static [PlantKind], String> {
        match text {
            "agreeing" => Ok(&[PlantKind::Agreeing]),
            "disagreeing" => Ok(&[PlantKind::Disagreeing]),
            "both" => Ok(&[PlantKind::Disagreeing, PlantKind::Agreeing]),
            _ => Err(format!("`{text}` is none of agreeing, disagreeing and both")),
        }
    };
    KeywordParser { keywords: vec!["agreeing", "disagreeing", "both"], parse }
}

impl<T: Clone + Send + Sync + 'static> TypedValueParser for KeywordParser<T> {
    type Value = T;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<T, Error> {
        let parse = self.parse;
        TypedValueParser::parse_ref(&move |text: &str| parse(text), command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(self.keywords.iter().map(PossibleValue::new)))
    }
}
