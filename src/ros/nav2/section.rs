//! The parameters of a node, to be taken one by one: what is left at the end was not mapped.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

use super::Nav2Error;

/// A parameter as it is in force for a node.
#[derive(Clone, Debug)]
pub(super) struct Parameter {
    /// Its place in the file, such as `controller_server.FollowPath.max_vel_x`.
    pub place: String,
    pub value: Value,
}

/// Parameters of a node, or of a part of it, by their names. What is taken is no longer there.
#[derive(Debug, Default)]
pub(super) struct Section(BTreeMap<String, Parameter>);

/// A value that was taken, and its place in the file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Given<T> {
    pub place: String,
    pub value: T,
}

impl<T> Given<T> {
    pub fn map<U>(self, change: impl FnOnce(T) -> U) -> Given<U> {
        Given {
            place: self.place,
            value: change(self.value),
        }
    }
}

impl Section {
    pub const fn new(parameters: BTreeMap<String, Parameter>) -> Self {
        Self(parameters)
    }

    /// The parameters whose names begin with a part and a dot, under the rest of their names.
    pub fn part(&mut self, name: &str) -> Self {
        let prefix = format!("{name}.");
        let (part, rest) = core::mem::take(&mut self.0)
            .into_iter()
            .partition(|(key, _)| key.starts_with(&prefix));
        self.0 = rest;
        let part: BTreeMap<String, Parameter> = part;
        let short =
            |(key, parameter): (String, Parameter)| (key[prefix.len()..].to_owned(), parameter);
        Self(part.into_iter().map(short).collect())
    }

    /// A parameter as it stands, which stays.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.0.get(name)?.value.as_str()
    }

    /// A number, which stays.
    pub fn peek(&self, name: &str) -> Option<f64> {
        self.0.get(name)?.value.as_f64()
    }

    /// Whether a parameter is true; it stays.
    pub fn flag(&self, name: &str) -> bool {
        let value = self.0.get(name).map(|parameter| &parameter.value);
        value.and_then(Value::as_bool).unwrap_or_default()
    }

    /// The texts of a list, which stays.
    pub fn texts(&self, name: &str) -> Vec<String> {
        let list = self
            .0
            .get(name)
            .and_then(|parameter| parameter.value.as_array());
        let texts = list.into_iter().flatten().filter_map(Value::as_str);
        texts.map(str::to_owned).collect()
    }

    /// Names of the first parts of nested parameters, such as `FollowPath`.
    pub fn parts(&self) -> BTreeSet<String> {
        let firsts = self.0.keys().filter_map(|key| key.split_once('.'));
        firsts.map(|(first, _)| first.to_owned()).collect()
    }

    /// Takes a finite number.
    pub fn number(&mut self, name: &str) -> Result<Option<Given<f64>>, Nav2Error> {
        self.take(name, "a finite number", finite)
    }

    /// Takes a whole number, at least one.
    pub fn count(&mut self, name: &str) -> Result<Option<Given<u32>>, Nav2Error> {
        self.take(name, "a whole number, 1 to 4294967295", |value| {
            let count = value.as_u64().and_then(|count| u32::try_from(count).ok());
            count.filter(|&count| count > 0)
        })
    }

    /// Takes three finite numbers: along x, along y, about z.
    pub fn triple(&mut self, name: &str) -> Result<Option<Given<[f64; 3]>>, Nav2Error> {
        self.take(name, "three finite numbers, [x, y, theta]", |value| {
            let numbers: Option<Vec<f64>> = value.as_array()?.iter().map(finite).collect();
            numbers?.try_into().ok()
        })
    }

    /// Takes a value that a function understands.
    pub fn take<T>(
        &mut self,
        name: &str,
        expected: &'static str,
        understand: impl FnOnce(&Value) -> Option<T>,
    ) -> Result<Option<Given<T>>, Nav2Error> {
        let Some(Parameter { place, value }) = self.0.remove(name) else {
            return Ok(None);
        };
        match understand(&value) {
            Some(value) => Ok(Some(Given { place, value })),
            None => Err(Nav2Error::BadValue {
                key: place,
                value: value.to_string().chars().take(60).collect(),
                expected,
            }),
        }
    }

    /// What is left: names and places.
    pub fn rest(self) -> impl Iterator<Item = (String, String)> {
        self.0
            .into_iter()
            .map(|(name, parameter)| (name, parameter.place))
    }
}

fn finite(value: &Value) -> Option<f64> {
    value.as_f64().filter(|number| number.is_finite())
}
