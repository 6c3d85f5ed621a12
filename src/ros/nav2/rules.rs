//! The rules of the import and their application.

use core::f64::consts::PI;

use serde_json::Value;

use super::config_builder::{ConfigBuilder, Merge};
use super::parameter_file::{NUMBER, Parameter, Parameters, finite};
use super::tables::COMMON;
use super::{Nav2Error, UnmappedReason};
use crate::runtime::NodeConfig;
use crate::suggest::closest_name;

/// The note of a parameter that the file does not have.
pub(super) const NAV2_DEFAULT: &str = "not given: Nav2's default";

/// Computes settings from several parameters.
pub(super) type Derivation = fn(&mut Parameters, &mut ConfigBuilder) -> Result<(), Nav2Error>;

/// What becomes of a parameter.
#[derive(Clone, Copy)]
pub(super) enum Rule {
    /// A setting follows from the parameter.
    Map(Mapping),
    /// Settings follow from several parameters, whose names are listed.
    Derive(&'static [&'static str], Derivation),
    /// The parameter is not mapped. A name with a star at its start or end, or both, matches a group of parameters.
    Leave(&'static str, UnmappedReason, &'static str),
}

/// A setting that follows from a parameter.
#[derive(Clone, Copy)]
pub(super) struct Mapping {
    parameter: &'static str,
    setting: &'static str,
    merge: Merge,
    conversion: Conversion,
    note: &'static str,
    condition: fn(&Parameters) -> bool,
    /// Nav2's default, which applies if the parameter is missing.
    default: Option<f64>,
}

/// How a value is converted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Conversion {
    Number,
    Negated,
    /// A whole number.
    Count,
    /// A frequency to a period of the control loop.
    Period,
    /// An angle, at most pi.
    Angle,
    /// A truth value to a speed of zero.
    NoReverse,
    /// An element of `[x, y, theta]`.
    Element(usize),
    NegatedElement(usize),
}

/// The setting has the parameter's value.
pub(super) const fn set(parameter: &'static str, setting: &'static str) -> Rule {
    rule(parameter, setting, Merge::Replace)
}

/// The setting is the lowest of several parameters' values.
pub(super) const fn at_most(parameter: &'static str, setting: &'static str) -> Rule {
    rule(parameter, setting, Merge::Min)
}

/// The setting is the highest of several parameters' values.
pub(super) const fn at_least(parameter: &'static str, setting: &'static str) -> Rule {
    rule(parameter, setting, Merge::Max)
}

const fn rule(parameter: &'static str, setting: &'static str, merge: Merge) -> Rule {
    Rule::Map(Mapping {
        parameter,
        setting,
        merge,
        conversion: Conversion::Number,
        note: "",
        condition: |_| true,
        default: None,
    })
}

impl Rule {
    /// The same rule with a conversion and a note about it.
    pub const fn convert(self, conversion: Conversion, note: &'static str) -> Self {
        match self {
            Self::Map(mapping) => Self::Map(Mapping { conversion, note, ..mapping }),
            other => other,
        }
    }

    /// The same rule with a condition.
    pub const fn when(self, condition: fn(&Parameters) -> bool) -> Self {
        match self {
            Self::Map(mapping) => Self::Map(Mapping { condition, ..mapping }),
            other => other,
        }
    }

    /// The same rule with Nav2's default for a missing parameter, where it is safer than the default of the setting.
    pub const fn or_default(self, default: f64) -> Self {
        match self {
            Self::Map(mapping) => Self::Map(Mapping { default: Some(default), ..mapping }),
            other => other,
        }
    }

    /// The parameters of the rule, as names or patterns.
    fn patterns(&self) -> &[&'static str] {
        match self {
            Self::Map(mapping) => core::slice::from_ref(&mapping.parameter),
            Self::Derive(names, _) => names,
            Self::Leave(pattern, ..) => core::slice::from_ref(pattern),
        }
    }
}

impl Mapping {
    fn apply(
        &self,
        parameters: &mut Parameters,
        builder: &mut ConfigBuilder,
    ) -> Result<(), Nav2Error> {
        if !(self.condition)(parameters) {
            return Ok(());
        }
        let name = self.parameter;
        let value = match self.conversion {
            Conversion::Count => {
                if let Some(count) = parameters.count(name)? {
                    builder.set(self.setting, count, self.note);
                }
                return Ok(());
            }
            Conversion::Number => parameters.number(name),
            Conversion::Negated => parameters.take(name, NUMBER, |value| finite(value).map(|n| -n)),
            Conversion::Angle => {
                parameters.take(name, NUMBER, |value| finite(value).map(|angle| angle.min(PI)))
            }
            Conversion::NoReverse => {
                parameters.take(name, "true or false", |value| value.as_bool().map(|_| 0.0))
            }
            Conversion::Period => parameters.take(name, "a number of Hz above zero", |value| {
                let hertz = finite(value).filter(|&hertz| hertz > 0.0);
                let (shortest_s, longest_s) = NodeConfig::PERIODS_S.into_inner();
                hertz.map(|hertz| hertz.recip().clamp(shortest_s, longest_s))
            }),
            Conversion::Element(index) => {
                parameters.take(name, TRIPLE, |value| triple(value).map(|values| values[index]))
            }
            Conversion::NegatedElement(index) => {
                parameters.take(name, TRIPLE, |value| triple(value).map(|values| -values[index]))
            }
        }?;
        let Some(value) = value else {
            if let (Some(value), Some(path)) = (self.default, parameters.path_of(name)) {
                let value = Parameter { path, value };
                builder.merge(self.setting, value, (NAV2_DEFAULT, false), self.merge);
            }
            return Ok(());
        };
        // Smaller angles keep their value.
        let is_unchanged = self.conversion == Conversion::Angle && value.value < PI;
        let note = if is_unchanged { "" } else { self.note };
        builder.merge(self.setting, value, (note, true), self.merge);
        Ok(())
    }
}

const TRIPLE: &str = "three finite numbers, [x, y, theta]";

/// Three finite numbers: along x, along y, about z.
fn triple(value: &Value) -> Option<[f64; 3]> {
    let numbers: Option<Vec<f64>> = value.as_array()?.iter().map(finite).collect();
    numbers?.try_into().ok()
}

/// Applies tables of rules to parameters, and lists each parameter that remains with its reason.
pub(super) fn apply(
    mut parameters: Parameters,
    tables: &[&[Rule]],
    builder: &mut ConfigBuilder,
) -> Result<(), Nav2Error> {
    let rules = || tables.iter().copied().flatten().chain(COMMON);
    for rule in rules() {
        match rule {
            Rule::Map(mapping) => mapping.apply(&mut parameters, builder)?,
            Rule::Derive(_, derive) => derive(&mut parameters, builder)?,
            Rule::Leave(..) => {}
        }
    }
    for (name, path) in parameters.unused() {
        let reason = rules().find_map(|rule| match rule {
            Rule::Leave(pattern, reason, text) if matches(pattern, &name) => Some((*reason, *text)),
            _ => None,
        });
        if let Some((reason, text)) = reason {
            builder.add_unmapped(path, reason, text);
            continue;
        }
        let known = rules().flat_map(Rule::patterns).copied();
        let explanation = match closest_name(&name, known.filter(|known| !known.contains('*'))) {
            Some(closest) => format!("the parameter is unknown: did you mean `{closest}`?"),
            None => "the parameter is unknown".to_owned(),
        };
        builder.add_unmapped(path, UnmappedReason::Unknown, explanation);
    }
    Ok(())
}

fn matches(pattern: &str, name: &str) -> bool {
    match (pattern.strip_prefix('*'), pattern.strip_suffix('*')) {
        (Some(_), Some(_)) => name.contains(pattern.trim_matches('*')),
        (Some(end), None) => name.ends_with(end),
        (None, Some(start)) => name.starts_with(start),
        (None, None) => name == pattern,
    }
}

/// Warns of a motion model of MPPI that this program does not have.
pub(super) fn motion_model(
    parameters: &mut Parameters,
    builder: &mut ConfigBuilder,
) -> Result<(), Nav2Error> {
    if parameters.peek_text("motion_model").is_none_or(|model| model == "DiffDrive") {
        return Ok(());
    }
    let model = |value: &Value| value.as_str().map(str::to_owned);
    if let Some(Parameter { path, value }) = parameters.take("motion_model", "a text", model)? {
        let explanation = format!(
            "{value} is not supported: inbye drives only robots with tracks or a differential drive, which turn on the spot"
        );
        builder.add_warning(format!("{path}: {explanation}"));
        builder.add_unmapped(path, UnmappedReason::NotSupported, explanation);
    }
    Ok(())
}

/// Nav2's defaults of MPPI's `model_dt`, seconds, and `time_steps`: their product is the horizon.
const DEFAULT_STEP_S: f64 = 0.05;
const DEFAULT_STEPS: u32 = 56;

/// MPPI's time step is `local.sim_step_s`. The horizon is the number of steps times it.
pub(super) fn mppi_horizon(
    parameters: &mut Parameters,
    builder: &mut ConfigBuilder,
) -> Result<(), Nav2Error> {
    let step = parameters.number("model_dt")?;
    let steps = parameters.count("time_steps")?;
    let (step_s, count) = (
        step.as_ref().map_or(DEFAULT_STEP_S, |step| step.value),
        steps.as_ref().map_or(DEFAULT_STEPS, |steps| steps.value),
    );
    let note = format!("time_steps x model_dt, {count} x {step_s:?}");
    // Rounding removes the error of the product of two decimals.
    let horizon_s = (step_s * f64::from(count) * 1e9).round() / 1e9;
    if let Some(step) = &step {
        builder.set("local.sim_step_s", step.clone(), "");
    } else if let Some(steps) = &steps {
        let default = steps.clone().map(|_| DEFAULT_STEP_S);
        builder.set("local.sim_step_s", default, "Nav2's default of model_dt");
    }
    let sources =
        [step.map(|step| step.map(|_| horizon_s)), steps.map(|steps| steps.map(|_| horizon_s))];
    for source in sources.into_iter().flatten() {
        builder.set("local.sim_time_s", source, &note);
    }
    Ok(())
}

/// Turn rates per forward speed, as in the default sampling of 20 x 40.
const RATES_PER_SPEED: u32 = 2;

/// MPPI's batch size becomes a grid of samples.
pub(super) fn mppi_samples(
    parameters: &mut Parameters,
    builder: &mut ConfigBuilder,
) -> Result<(), Nav2Error> {
    if let Some(batch) = parameters.count("batch_size")? {
        let (speeds, rates) = sample_grid(batch.value);
        let note = format!(
            "{} samples: the largest grid of at most that size with {RATES_PER_SPEED} turn rates per speed, {speeds} x {rates}",
            batch.value
        );
        builder.set("local.vx_samples", batch.clone().map(|_| speeds), &note);
        builder.set("local.vtheta_samples", batch.map(|_| rates), &note);
    }
    Ok(())
}

/// The numbers of speeds and turn rates of the largest grid of at most a number of samples.
fn sample_grid(samples: u32) -> (u32, u32) {
    let speeds = (samples / RATES_PER_SPEED).isqrt().max(1);
    (speeds, samples / speeds)
}

/// The thresholds of the rotation shim. Nav2's default of the lower one is half of the upper one.
pub(super) fn rotation_thresholds(
    parameters: &mut Parameters,
    builder: &mut ConfigBuilder,
) -> Result<(), Nav2Error> {
    let (from, until) = ("navigator.rotate_in_place_from", "navigator.rotate_in_place_until");
    let start = parameters.number("angular_dist_threshold")?;
    let end = parameters.number("angular_disengage_threshold")?;
    if let Some(start) = start {
        let default_until = crate::navigator::NavigatorSettings::default().rotate_in_place_until;
        // The lower threshold must not exceed the upper one.
        if end.is_none() && default_until > start.value {
            let half: Parameter<f64> = start.clone().map(|angle| angle / 2.0);
            builder.set(until, half, "half of it");
        }
        builder.set(from, start, "");
    }
    if let Some(end) = end {
        builder.set(until, end, "");
    }
    Ok(())
}
