//! A configuration in the making: each setting with the parameters that it comes from.

use std::collections::BTreeMap;

use toml::Value;

use super::section::Given;
use super::{Import, Mapped, Nav2Error, NotMapped, Target, Why};
use crate::base::BaseConfig;
use crate::documented::Described;
use crate::runtime::Config;

/// What has been taken over so far.
#[derive(Debug, Default)]
pub(super) struct Draft {
    settings: BTreeMap<&'static str, Setting>,
    not_mapped: BTreeMap<String, NotMapped>,
}

#[derive(Debug)]
struct Setting {
    value: Value,
    sources: Vec<Source>,
}

/// A parameter that a setting comes from.
#[derive(Debug)]
struct Source {
    place: String,
    /// What was made of it.
    how: String,
    /// Where several hold together, what this one asks for.
    own: Option<f64>,
}

impl Setting {
    /// What was made of a parameter, in words.
    fn how(&self, source: &Source) -> String {
        match source.own {
            Some(own) if self.value.as_float() != Some(own) => {
                let gap = if source.how.is_empty() { "" } else { ": " };
                format!("{}{gap}{own:?}, which is not the tighter limit", source.how)
            }
            _ => source.how.clone(),
        }
    }
}

/// Which of two values counts where two parameters limit the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tighter {
    Lower,
    Higher,
}

impl Draft {
    /// Sets a value; `how` says what was made of the parameter, nothing where it is the same.
    pub fn set<T: Into<Value>>(&mut self, key: &'static str, given: Given<T>, how: &str) {
        self.put(key, given, how, None);
    }

    fn put<T: Into<Value>>(
        &mut self,
        key: &'static str,
        given: Given<T>,
        how: &str,
        own: Option<f64>,
    ) {
        let Given { place, value } = given;
        let setting = self.settings.entry(key).or_insert_with(|| Setting {
            value: Value::Boolean(false),
            sources: Vec::new(),
        });
        setting.value = value.into();
        setting.sources.push(Source {
            place,
            how: how.to_owned(),
            own,
        });
    }

    /// Says that a setting comes from one parameter more.
    pub fn also_from(&mut self, key: &'static str, place: String, how: &str) {
        if let Some(setting) = self.settings.get_mut(key) {
            setting.sources.push(Source {
                place,
                how: how.to_owned(),
                own: None,
            });
        }
    }

    /// A number that holds together with all others given for the same key: the lowest counts.
    pub fn at_most(&mut self, key: &'static str, given: Given<f64>, how: &str) {
        self.limit(key, given, how, Tighter::Lower);
    }

    /// The same where the highest counts.
    pub fn at_least(&mut self, key: &'static str, given: Given<f64>, how: &str) {
        self.limit(key, given, how, Tighter::Higher);
    }

    fn limit(&mut self, key: &'static str, mut given: Given<f64>, how: &str, tighter: Tighter) {
        let own = given.value;
        let before = self.settings.get(key);
        if let Some(before) = before.and_then(|setting| setting.value.as_float()) {
            given.value = match tighter {
                Tighter::Lower => own.min(before),
                Tighter::Higher => own.max(before),
            };
        }
        self.put(key, given, how, Some(own));
    }

    /// Notes why a parameter is not taken over.
    pub fn leave(&mut self, place: String, why: Why, reason: impl Into<String>) {
        let new = NotMapped {
            key: place.clone(),
            why,
            reason: reason.into(),
        };
        // A parameter for every node is left by each: what one knows of it says more than that another does not.
        let known = self.not_mapped.get(&place);
        if known.is_none_or(|before| before.why == Why::Unknown) {
            self.not_mapped.insert(place, new);
        }
    }

    /// The configuration, checked. `ignored` are the nodes that were not read.
    pub fn finish(mut self, ignored: Vec<String>) -> Result<Import, Nav2Error> {
        let mapped = self.mapped();
        if mapped.is_empty() {
            return Err(Nav2Error::NothingToRead);
        }
        for Mapped { key, .. } in &mapped {
            self.not_mapped.remove(key);
        }
        let config = self.toml(&Config::keys());
        let base_config = self.toml(&BaseConfig::keys());
        self.check(&config, Config::validate)?;
        self.check(&base_config, BaseConfig::validate)?;
        Ok(Import {
            config,
            base_config,
            mapped,
            not_mapped: self.not_mapped.into_values().collect(),
            ignored,
        })
    }

    /// Every parameter that is taken over, and what it becomes.
    fn mapped(&self) -> Vec<Mapped> {
        let mut mapped: BTreeMap<&str, Mapped> = BTreeMap::new();
        for (key, setting) in &self.settings {
            for source in &setting.sources {
                let entry = mapped.entry(&source.place).or_insert_with(|| Mapped {
                    key: source.place.clone(),
                    to: Vec::new(),
                });
                entry.to.push(Target {
                    key,
                    value: setting.value.clone(),
                    how: setting.how(source),
                });
            }
        }
        mapped.into_values().collect()
    }

    /// The settings that are among the keys, in the order of the keys.
    fn toml(&self, keys: &[Described]) -> String {
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
                let how = match setting.how(source) {
                    how if how.is_empty() => how,
                    how => format!(" ({how})"),
                };
                text += &["# From ", &in_one_line(&source.place), &how, ".\n"].concat();
            }
            text += &[name, " = ", &setting.value.to_string(), "\n"].concat();
        }
        text
    }

    fn check<T, E: ToString>(
        &self,
        text: &str,
        validate: impl FnOnce(&T) -> Result<(), E>,
    ) -> Result<(), Nav2Error>
    where
        T: serde::de::DeserializeOwned,
    {
        let reason = match toml::from_str::<T>(text) {
            Ok(settings) => match validate(&settings) {
                Ok(()) => return Ok(()),
                Err(error) => error.to_string(),
            },
            Err(error) => error.message().to_owned(),
        };
        Err(Nav2Error::OutOfRange {
            keys: self.blamed(&reason),
            reason,
        })
    }

    /// The parameters that a message is about: it names settings.
    fn blamed(&self, reason: &str) -> String {
        let words: Vec<&str> = reason
            .split(|letter: char| !(letter.is_alphanumeric() || letter == '_'))
            .collect();
        let is_named = |key: &str| words.contains(&key.rsplit('.').next().unwrap_or(key));
        let places: Vec<&str> = self
            .settings
            .iter()
            .filter(|(key, _)| is_named(key))
            .flat_map(|(_, setting)| setting.sources.iter().map(|source| source.place.as_str()))
            .collect();
        places.join(", ")
    }
}

fn in_one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
