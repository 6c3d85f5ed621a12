//! The parameters of a node or of one of its plugins.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

use super::error::Nav2Error;

/// A parameter with its path in the file, such as `controller_server.FollowPath.max_vel_x`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Parameter<T> {
    pub path: String,
    pub value: T,
}

impl<T> Parameter<T> {
    pub fn map<U>(self, convert: impl FnOnce(T) -> U) -> Parameter<U> {
        Parameter { path: self.path, value: convert(self.value) }
    }
}

/// Parameters by name, and which of them were used.
#[derive(Debug, Default)]
pub(super) struct Parameters {
    parameters: BTreeMap<String, Parameter<Value>>,
    used: BTreeSet<String>,
}

impl Parameters {
    pub const fn new(parameters: BTreeMap<String, Parameter<Value>>) -> Self {
        Self { parameters, used: BTreeSet::new() }
    }

    /// Removes the parameters of a plugin and returns them without the plugin's name.
    pub fn remove_plugin(&mut self, name: &str) -> Self {
        let prefix = format!("{name}.");
        let all = core::mem::take(&mut self.parameters).into_iter();
        let (plugin, rest): (BTreeMap<_, _>, BTreeMap<_, _>) =
            all.partition(|(key, _)| key.starts_with(&prefix));
        self.parameters = rest;
        let short = |(key, parameter): (String, _)| (key[prefix.len()..].to_owned(), parameter);
        Self::new(plugin.into_iter().map(short).collect())
    }

    /// The value of a parameter, without use of it.
    pub fn peek(&self, name: &str) -> Option<&Value> {
        self.parameters.get(name).map(|parameter| &parameter.value)
    }

    /// The text of a parameter, without use of it.
    pub fn peek_text(&self, name: &str) -> Option<&str> {
        self.peek(name)?.as_str()
    }

    /// The names of the plugins of a kind: those of the lists first, then all others by their type.
    pub fn plugins(&self, lists: &[&str], is_kind: impl Fn(&str) -> bool) -> Vec<String> {
        let nested = self.parameters.keys().filter_map(|key| key.split_once('.'));
        let prefixes: BTreeSet<&str> = nested.map(|(prefix, _)| prefix).collect();
        let listed = lists.iter().filter_map(|list| self.peek(list));
        let listed = listed.flat_map(|list| match list {
            Value::Array(names) => names.iter().filter_map(Value::as_str).collect(),
            single => single.as_str().into_iter().collect::<Vec<_>>(),
        });
        let of_kind = prefixes.iter().copied().filter(|name| {
            let plugin = self.peek_text(&format!("{name}.plugin"));
            plugin.is_some_and(&is_kind)
        });
        let mut names: Vec<String> = Vec::new();
        for name in listed.filter(|name| prefixes.contains(name)).chain(of_kind) {
            if names.iter().all(|known| known != name) {
                names.push(name.to_owned());
            }
        }
        names
    }

    /// Uses a finite number.
    pub fn number(&mut self, name: &str) -> Result<Option<Parameter<f64>>, Nav2Error> {
        self.take(name, "a finite number", finite)
    }

    /// Uses a whole number, at least one.
    pub fn count(&mut self, name: &str) -> Result<Option<Parameter<u32>>, Nav2Error> {
        self.take(name, "a whole number, 1 to 4294967295", |value| {
            let count = value.as_u64().and_then(|count| u32::try_from(count).ok());
            count.filter(|&count| count > 0)
        })
    }

    /// Uses three finite numbers: along x, along y, about z.
    pub fn triple(&mut self, name: &str) -> Result<Option<Parameter<[f64; 3]>>, Nav2Error> {
        self.take(name, "three finite numbers, [x, y, theta]", |value| {
            let numbers: Option<Vec<f64>> = value.as_array()?.iter().map(finite).collect();
            numbers?.try_into().ok()
        })
    }

    /// Uses a parameter, if it is present, with a conversion that returns nothing for an invalid value.
    pub fn take<T>(
        &mut self,
        name: &str,
        expected: &'static str,
        convert: impl FnOnce(&Value) -> Option<T>,
    ) -> Result<Option<Parameter<T>>, Nav2Error> {
        let Some(Parameter { path, value }) = self.parameters.get(name) else {
            return Ok(None);
        };
        self.used.insert(name.to_owned());
        let path = path.clone();
        match convert(value) {
            Some(value) => Ok(Some(Parameter { path, value })),
            None => Err(Nav2Error::BadValue {
                parameter: path,
                value: value.to_string().chars().take(60).collect(),
                expected,
            }),
        }
    }

    /// The names and paths of the parameters that were not used.
    pub fn unused(self) -> impl Iterator<Item = (String, String)> {
        let Self { parameters, used } = self;
        let unused = move |(name, _): &(String, _)| !used.contains(name);
        parameters.into_iter().filter(unused).map(|(name, parameter)| (name, parameter.path))
    }
}

fn finite(value: &Value) -> Option<f64> {
    value.as_f64().filter(|number| number.is_finite())
}
