//! Arguments that several commands share, and parsers of argument values.

use core::f64::consts::TAU;
use std::ffi::OsStr;
use std::ops::{Bound, RangeBounds};
use std::str::FromStr;
use std::sync::Arc;

use clap::builder::{PossibleValue, TypedValueParser};
use clap::{Arg, Args, Command, Error};
use inbye::base::Protocol;
use inbye::bench::{DecisionSize, EngineRequest};
use inbye::geometry::{MAX_COORDINATE, Point, Pose};
use inbye::local::{CpuEngine, Engine};
use inbye::map::UnknownPolicy;
use inbye::runtime::{Config, PlantKind, PoseSource};
use inbye::sim::SCENE_NAMES;

use super::{engine_selection, machine, output};

/// The engine that decides in a closed loop.
#[derive(Debug, Args)]
pub struct EngineArguments {
    /// Engine: `auto` measures once which is fastest; gpu:NAME is the adapter NAME, or else the first whose name contains it.
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

    /// As [`Self::open`], for a replay: no robot waits for the answers, and a GPU must be there.
    pub fn open_to_replay(&self, config: &Config) -> anyhow::Result<Box<dyn Engine>> {
        let threads = self.threads.unwrap_or_else(machine::cores);
        engine_selection::open_for_replay(&self.engine, &decision_size(config), threads)
    }
}

/// Size of the decisions with these settings.
pub fn decision_size(config: &Config) -> DecisionSize {
    DecisionSize::new(&config.local, config.robot.footprint.discs().len())
}

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
            _ => {
                let is_unknown = text.eq_ignore_ascii_case("unknown");
                let hint = if is_unknown {
                    "; for a start that is not known: --unknown-start"
                } else {
                    ""
                };
                Err(format!(
                    "`{text}` is not a position: write X,Y or X,Y,YAW in metres and radians, such as 2.5,-1,0{hint}"
                ))
            }
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

/// Returns a parser of numbers in a range; the error names the expected numbers.
pub fn real(
    range: impl RangeBounds<f64> + Clone + Send + Sync,
    expected: &'static str,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync {
    move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        number.ok_or_else(|| format!("it must be a number: {expected}"))
    }
}

/// The range of numbers above zero.
pub const fn above_zero(most: f64) -> (Bound<f64>, Bound<f64>) {
    (Bound::Excluded(0.0), Bound::Included(most))
}

/// Parses a length above zero, metres.
pub fn length(text: &str) -> Result<f64, String> {
    real(above_zero(MAX_COORDINATE), "metres, above zero and at most 1e9")(text)
}

/// Parses a duration above zero, seconds.
pub fn duration(text: &str) -> Result<f64, String> {
    real(above_zero(1e9), "seconds, above zero and at most 1e9")(text)
}

/// Reads a value, or says what is wrong with its text.
type Parse<T> = dyn Fn(&str) -> Result<T, String> + Send + Sync;

/// Parses a value by a function and lists keywords for the help and for shell completion.
#[derive(Clone)]
pub struct KeywordParser<T> {
    keywords: Vec<&'static str>,
    parse: Arc<Parse<T>>,
}

impl<T: Clone + Send + Sync + 'static> KeywordParser<T> {
    /// A parser of a keyword for each value; of another text the error says that it is `neither` of them.
    fn of<const N: usize>(values: [(&'static str, T); N], neither: impl Into<String>) -> Self {
        let neither = neither.into();
        let keywords = values.iter().map(|(keyword, _)| *keyword).collect();
        let parse = move |text: &str| {
            let value = values.iter().find(|(keyword, _)| *keyword == text);
            let value = value.map(|(_, value)| value.clone());
            value.ok_or_else(|| format!("`{text}` is {neither}"))
        };
        Self { keywords, parse: Arc::new(parse) }
    }
}

/// Parses an engine: `auto`, `cpu`, `gpu`, or `gpu:` with part of an adapter's name.
pub fn engine() -> KeywordParser<EngineRequest> {
    KeywordParser { keywords: vec!["auto", "cpu", "gpu"], parse: Arc::new(str::parse) }
}

/// Parses a base's protocol.
pub fn protocol() -> KeywordParser<Protocol> {
    let keywords = Protocol::ALL.map(Protocol::name).to_vec();
    KeywordParser { keywords, parse: Arc::new(str::parse) }
}

/// Parses the policy for unknown cells.
pub fn unknown() -> KeywordParser<UnknownPolicy> {
    let policies = [("blocked", UnknownPolicy::Blocked), ("free", UnknownPolicy::Free)];
    KeywordParser::of(policies, "neither blocked nor free")
}

/// Parses the name of a built-in scene.
pub fn scene() -> KeywordParser<&'static str> {
    let neither = format!("none of {}", SCENE_NAMES.join(", "));
    KeywordParser::of(SCENE_NAMES.map(|name| (name, name)), neither)
}

/// Parses the source of the pose.
pub fn pose_source() -> KeywordParser<PoseSource> {
    let sources = [("fixes", PoseSource::Fixes), ("scans", PoseSource::Scans)];
    KeywordParser::of(sources, "neither fixes nor scans")
}

/// Parses a choice of simulated robots; the kinds in the order of the rows.
pub fn plants() -> KeywordParser<&'static [PlantKind]> {
    use PlantKind::{Agreeing, Disagreeing};
    let plants: [(_, &[PlantKind]); 3] = [
        ("agreeing", &[Agreeing]),
        ("disagreeing", &[Disagreeing]),
        ("both", &[Disagreeing, Agreeing]),
    ];
    KeywordParser::of(plants, "none of agreeing, disagreeing and both")
}

impl<T: Clone + Send + Sync + 'static> TypedValueParser for KeywordParser<T> {
    type Value = T;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<T, Error> {
        let parse = Arc::clone(&self.parse);
        TypedValueParser::parse_ref(&move |text: &str| parse(text), command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(self.keywords.iter().map(PossibleValue::new)))
    }
}
