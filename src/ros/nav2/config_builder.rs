//! Collects settings with the parameters that they follow from.

use std::collections::BTreeMap;

use toml::Value;

use super::footprint::FOOTPRINT;
use super::parameter_file::Parameter;
use super::{Import, Mapped, MappedSetting, Nav2Error, Unmapped, UnmappedReason};
use crate::base::BaseConfig;
use crate::local::LocalSettings;
use crate::navigator::NavigatorSettings;
use crate::runtime::Config;
use crate::settings::KeyDescription;
use crate::suggest::in_one_line;

/// Shortest lookahead of an imported robot, metres: the default of Nav2's regulated pure pursuit.
const MIN_LOOKAHEAD_M: f64 = 0.6;
/// The warning of settings without a footprint.
const NO_FOOTPRINT: &str = "no costmap has a footprint or a robot_radius: robot.footprint keeps its default of 0.7 x 0.5 m";
/// Fewer samples of the dynamic window than this are too coarse: 5 speeds with 10 turn rates each.
const LEAST_SAMPLES: u32 = 50;
const HALF_OF_IT: &str = "at most half of the distance driven within it";

/// How several parameters of one setting are combined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Merge {
    /// The last value.
    Replace,
    /// The lowest value.
    Min,
    /// The highest value.
    Max,
}

/// The settings and the unmapped parameters so far.
#[derive(Debug, Default)]
pub(super) struct ConfigBuilder {
    settings: BTreeMap<&'static str, Setting>,
    unmapped: BTreeMap<String, Unmapped>,
    warnings: Vec<String>,
}

#[derive(Debug)]
struct Setting {
    value: Value,
    sources: Vec<Source>,
}

/// A parameter that a setting follows from.
#[derive(Debug)]
struct Source {
    path: String,
    note: String,
    /// Whether the file has it.
    is_given: bool,
    /// The value by this parameter alone, if it is one of several limits.
    own_value: Option<f64>,
}

/// How a value follows from a parameter: the fields of [`Source`].
struct Origin<'n> {
    note: &'n str,
    is_given: bool,
    own_value: Option<f64>,
}

impl Setting {
    /// How the value follows from a parameter.
    fn note(&self, source: &Source) -> String {
        match source.own_value {
            Some(own) if self.value.as_float() != Some(own) => {
                let gap = if source.note.is_empty() { "" } else { ": " };
                format!("{}{gap}{own:?}, which is not the tighter limit", source.note)
            }
            _ => source.note.clone(),
        }
    }
}

impl ConfigBuilder {
    /// Sets a value. The note is empty if the setting has the parameter's value.
    pub fn set<T: Into<Value>>(&mut self, setting: &'static str, value: Parameter<T>, note: &str) {
        self.add(setting, value, Origin { note, is_given: true, own_value: None });
    }

    /// Sets a value that Nav2's default of a missing parameter gives. The path is the one that the parameter would have.
    pub fn set_default<T: Into<Value>>(
        &mut self,
        setting: &'static str,
        value: Parameter<T>,
        note: &str,
    ) {
        self.add(setting, value, Origin { note, is_given: false, own_value: None });
    }

    /// Sets a number, or combines it with the values of other parameters.
    pub fn merge(
        &mut self,
        setting: &'static str,
        mut value: Parameter<f64>,
        (note, is_given): (&str, bool),
        merge: Merge,
    ) {
        let own = value.value;
        let before = self.settings.get(setting);
        if let Some(before) = before.and_then(|setting| setting.value.as_float()) {
            value.value = match merge {
                Merge::Replace => own,
                Merge::Min => own.min(before),
                Merge::Max => own.max(before),
            };
        }
        let own_value = (merge != Merge::Replace).then_some(own);
        self.add(setting, value, Origin { note, is_given, own_value });
    }

    fn add<T: Into<Value>>(
        &mut self,
        setting: &'static str,
        Parameter { path, value }: Parameter<T>,
        Origin { note, is_given, own_value }: Origin<'_>,
    ) {
        let setting = self
            .settings
            .entry(setting)
            .or_insert_with(|| Setting { value: Value::Boolean(false), sources: Vec::new() });
        setting.value = value.into();
        setting.sources.push(Source { path, note: note.to_owned(), is_given, own_value });
    }

    /// Lists a parameter as unmapped.
    pub fn add_unmapped(
        &mut self,
        path: String,
        reason: UnmappedReason,
        explanation: impl Into<String>,
    ) {
        let new = Unmapped { parameter: path.clone(), reason, explanation: explanation.into() };
        // A parameter of all nodes is listed by each of them: a known reason replaces an unknown parameter.
        let known = self.unmapped.get(&path);
        if known.is_none_or(|before| before.reason == UnmappedReason::Unknown) {
            self.unmapped.insert(path, new);
        }
    }

    /// Adds a warning, which has the place of its cause.
    pub fn add_warning(&mut self, warning: impl Into<String>) {
        self.warnings.push(warning.into());
    }

    /// Whether a setting has a value.
    pub fn has(&self, setting: &str) -> bool {
        self.settings.contains_key(setting)
    }

    /// The validated configuration.
    pub fn finish(mut self, ignored_nodes: Vec<String>) -> Result<Import, Nav2Error> {
        self.derive_lookahead();
        let base_config = self.base_config()?;
        let (mapped, defaults) = (self.mapped(true), self.mapped(false));
        if mapped.is_empty() {
            return Err(self.nothing_mapped());
        }
        for mapped in &mapped {
            self.unmapped.remove(&mapped.parameter);
        }
        let mut config = self.toml(&Config::keys());
        self.validate(&config, Config::validate)?;
        if !self.has(FOOTPRINT) {
            self.add_warning(NO_FOOTPRINT);
        }
        self.check_samples();
        if !self.warnings.is_empty() {
            let comment = |warning: &String| format!("# Warning: {}.\n", in_one_line(warning));
            let comments: String = self.warnings.iter().map(comment).collect();
            config = [&comments, "\n", &config].concat();
        }
        Ok(Import {
            config,
            base_config,
            mapped,
            defaults,
            unmapped: self.unmapped.into_values().collect(),
            ignored_nodes,
            warnings: self.warnings,
        })
    }

    /// Warns of few samples of the dynamic window: MPPI has noise around its last decision, a grid only its own speeds.
    fn check_samples(&mut self) {
        let LocalSettings { vx_samples, vtheta_samples, .. } = LocalSettings::default();
        let count = |key: &str, default: u32| {
            let setting = self.settings.get(key);
            let given = setting.and_then(|setting| setting.value.as_integer());
            given.map_or(i64::from(default), |count| count)
        };
        let speeds = count("local.vx_samples", vx_samples);
        let rates = count("local.vtheta_samples", vtheta_samples);
        if speeds.saturating_mul(rates) < i64::from(LEAST_SAMPLES) {
            let causes = self.causes("vx_samples, vtheta_samples");
            self.add_warning(format!(
                "{causes}: {speeds} x {rates} samples of the dynamic window are too coarse: set local.vx_samples and \
                 local.vtheta_samples, whose defaults are {vx_samples} and {vtheta_samples}"
            ));
        }
    }

    /// The settings of the base. Each that is out of range is left out, and its parameters are listed.
    fn base_config(&mut self) -> Result<String, Nav2Error> {
        let keys = BaseConfig::keys();
        loop {
            let text = self.toml(&keys);
            let Err(error) = self.validate(&text, BaseConfig::validate) else {
                return Ok(text);
            };
            let Nav2Error::OutOfRange { reason, .. } = &error else {
                return Err(error);
            };
            let named =
                keys.iter().find(|known| self.has(&known.key) && is_named(reason, &known.key));
            let Some(setting) = named.and_then(|known| self.settings.remove(&*known.key)) else {
                return Err(error);
            };
            for source in setting.sources {
                self.add_unmapped(source.path, UnmappedReason::OutOfRange, reason.as_str());
            }
        }
    }

    /// Why no parameter is mapped: a plugin that is not supported, any other parameter, or none at all.
    fn nothing_mapped(&self) -> Nav2Error {
        let unsupported = |it: &&Unmapped| {
            it.reason == UnmappedReason::NotSupported && it.parameter.ends_with(".plugin")
        };
        let all = || self.unmapped.values();
        match all().find(unsupported).or_else(|| all().next()) {
            None => Nav2Error::NoNodes,
            Some(Unmapped { parameter, explanation, .. }) => Nav2Error::NothingMapped {
                parameter: parameter.clone(),
                explanation: explanation.clone(),
            },
        }
    }

    /// Shortens the lookahead of a slow robot to the distance that it drives within the horizon, the length of the arcs of its
    /// dynamic window. A target far beyond them can lie behind an obstacle that they must avoid.
    fn derive_lookahead(&mut self) {
        let number = |key: &str| self.settings.get(key)?.value.as_float();
        let horizon = self.settings.get("local.sim_time_s").and_then(|time| time.sources.last());
        let speed_and_time = number("robot.limits.max_vel_x").zip(number("local.sim_time_s"));
        let (Some(horizon), Some((speed, time_s))) = (horizon, speed_and_time) else {
            return;
        };
        let path = horizon.path.clone();
        let default = NavigatorSettings::default();
        let ahead_m = ((speed * time_s).max(MIN_LOOKAHEAD_M) * 100.0).round() / 100.0;
        if ahead_m >= default.lookahead_m {
            return;
        }
        for (setting, value, note) in [
            ("navigator.lookahead_m", ahead_m, "the distance driven within it at full speed"),
            ("navigator.min_lookahead_m", default.min_lookahead_m.min(ahead_m / 2.0), HALF_OF_IT),
            (
                "navigator.key_node_spacing_m",
                default.key_node_spacing_m.min(ahead_m / 2.0),
                HALF_OF_IT,
            ),
        ] {
            self.set(setting, Parameter { path: path.clone(), value }, note);
        }
    }

    /// Every mapped parameter that the file has, or has not, with its settings.
    fn mapped(&self, is_given: bool) -> Vec<Mapped> {
        let mut mapped: BTreeMap<&str, Mapped> = BTreeMap::new();
        for (name, setting) in &self.settings {
            for source in setting.sources.iter().filter(|source| source.is_given == is_given) {
                let entry = mapped.entry(&source.path).or_insert_with(|| Mapped {
                    parameter: source.path.clone(),
                    settings: Vec::new(),
                });
                entry.settings.push(MappedSetting {
                    setting: name,
                    value: serde_json::json!(setting.value),
                    note: setting.note(source),
                });
            }
        }
        mapped.into_values().collect()
    }

    /// The settings among the keys in TOML, in the order of the keys.
    fn toml(&self, keys: &[KeyDescription]) -> String {
        let mut text = String::new();
        let mut open = "";
        for known in keys {
            let Some(setting) = self.settings.get(&*known.key) else {
                continue;
            };
            let (table, name) = known.key.rsplit_once('.').unwrap_or(("", &known.key));
            if open != table {
                let gap = if text.is_empty() { "" } else { "\n" };
                text += &[gap, "[", table, "]\n"].concat();
                open = table;
            }
            for source in &setting.sources {
                let note = match setting.note(source) {
                    note if note.is_empty() => note,
                    note => format!(" ({note})"),
                };
                text += &["# From ", &in_one_line(&source.path), &note, ".\n"].concat();
            }
            text += &[name, " = ", &setting.value.to_string(), "\n"].concat();
        }
        text
    }

    fn validate<T: serde::de::DeserializeOwned, E: ToString>(
        &self,
        text: &str,
        validate: impl FnOnce(&T) -> Result<(), E>,
    ) -> Result<(), Nav2Error> {
        let checked = toml::from_str(text)
            .map_err(|error| error.message().to_owned())
            .and_then(|settings: T| validate(&settings).map_err(|error| error.to_string()));
        checked.map_err(|reason| Nav2Error::OutOfRange { parameters: self.causes(&reason), reason })
    }

    /// The parameters of the settings that an error message names.
    fn causes(&self, message: &str) -> String {
        let paths: Vec<&str> = self
            .settings
            .iter()
            .filter(|(key, _)| is_named(message, key))
            .flat_map(|(_, setting)| setting.sources.iter().map(|source| source.path.as_str()))
            .collect();
        paths.join(", ")
    }
}

/// Whether a message names a setting.
fn is_named(message: &str, key: &str) -> bool {
    let mut words = message.split(|letter: char| !(letter.is_alphanumeric() || letter == '_'));
    words.any(|word| key.rsplit('.').next() == Some(word))
}
