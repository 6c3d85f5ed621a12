//! The parameters of ROS 2 nodes in a YAML file: namespaces, wildcards, nested keys.
//!
//! The parameters of a node are below `ros__parameters`. The keys above it are the node's namespace and name, nested or joined
//! by slashes. The name `/**` matches every node. All sections that match a node count in the order of the file, and the last value
//! wins, as in `rclcpp`. A `*` within a name is no wildcard. Keys of parameters may be nested or joined by dots: for ROS both are equal.

use core::fmt::{self, Formatter};
use std::collections::{BTreeMap, BTreeSet};

use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde_json::{Map, Value};

use super::Nav2Error;
use crate::map::yaml::{self, BadYaml};

/// Maximum number of values of a file after the expansion of aliases: Nav2's own file has about 600.
const MAX_VALUES: usize = 100_000;

/// The key above a node's parameters.
const PARAMETERS_KEY: &str = "ros__parameters";

/// The values that a finite number permits, in words.
pub(super) const NUMBER: &str = "a finite number";

/// The nodes of a file, in its order.
pub(super) struct ParameterFile(Vec<Node>);

struct Node {
    /// Namespace without slashes at its ends; it may have wildcards.
    namespace: String,
    name: String,
    /// Path in the file, such as `/robot1/controller_server`.
    path: String,
    parameters: BTreeMap<String, Value>,
}

impl ParameterFile {
    pub fn parse(text: &str) -> Result<Self, Nav2Error> {
        let root: Sections = yaml::parse(text, MAX_VALUES)
            .map_err(|BadYaml { line, reason }| Nav2Error::BadYaml { line, reason })?;
        let mut nodes = Vec::new();
        collect(&root, &[], &mut nodes)?;
        Ok(Self(nodes))
    }

    /// The given namespace, or the only namespace of the named nodes.
    pub fn select_namespace(
        &self,
        given: Option<&str>,
        names: &[&str],
    ) -> Result<String, Nav2Error> {
        let known = self.0.iter().filter(|node| names.contains(&&*node.name));
        let found: BTreeSet<&str> =
            known.map(robot).filter(|namespace| !namespace.contains('*')).collect();
        let listed = || {
            let quoted = found.iter().map(|namespace| match *namespace {
                "" => "the root".to_owned(),
                namespace => format!("`{namespace}`"),
            });
            quoted.collect::<Vec<_>>().join(", ")
        };
        match given.map(|given| given.trim_matches('/')) {
            Some(given) if found.contains(given) => Ok(given.to_owned()),
            Some(given) => {
                Err(Nav2Error::UnknownNamespace { namespace: given.to_owned(), found: listed() })
            }
            None if found.len() > 1 => Err(Nav2Error::SeveralNamespaces { found: listed() }),
            None => Ok(found.first().copied().unwrap_or_default().to_owned()),
        }
    }

    /// The parameters of a node by name, and the paths of overridden parameters, each with the path that overrides it. None if
    /// the file does not have the node.
    pub fn node(&self, namespace: &str, name: &str) -> Option<(Parameters, Vec<(String, String)>)> {
        let mut parameters: BTreeMap<String, Parameter<Value>> = BTreeMap::new();
        let mut overridden = Vec::new();
        let mut is_found = false;
        for node in self.0.iter().filter(|node| node.matches(namespace, name)) {
            is_found = true;
            for (key, value) in &node.parameters {
                let path = format!("{}.{key}", node.path);
                let parameter = Parameter { path: path.clone(), value: value.clone() };
                if let Some(before) = parameters.insert(key.clone(), parameter) {
                    overridden.push((before.path, path));
                }
            }
        }
        is_found.then(|| (Parameters::new(parameters), overridden))
    }

    /// The paths of the nodes with other names or namespaces.
    pub fn ignored_nodes(&self, namespace: &str, names: &[&str]) -> Vec<String> {
        let is_read = |node: &&Node| names.iter().any(|name| node.matches(namespace, name));
        let others = self.0.iter().filter(|node| !is_read(node));
        others.map(|node| node.path.clone()).collect()
    }
}

impl Node {
    fn matches(&self, namespace: &str, name: &str) -> bool {
        let own = robot(self);
        let has_name = self.name == name || is_wild(&self.name);
        has_name && (own == namespace || is_wild(own) || (own.is_empty() && is_wild(&self.name)))
    }
}

/// The namespace of the node's robot. The namespace of a costmap's node ends with its own name.
fn robot(node: &Node) -> &str {
    let namespace = node.namespace.as_str();
    let (before, last) = namespace.rsplit_once('/').unwrap_or(("", namespace));
    if last == node.name { before } else { namespace }
}

/// Whether a name or namespace has a wildcard. For ROS only a whole name is one: `robot*` matches nothing.
fn is_wild(name: &str) -> bool {
    name.split('/').any(|name| matches!(name, "*" | "**"))
}

/// The sections of a file or of a namespace, in the order of the file, which the mappings of `serde_json` do not keep.
struct Sections(Vec<(String, Section)>);

enum Section {
    Parameters(Value),
    Below(Sections),
}

impl<'de> Deserialize<'de> for Sections {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(SectionsVisitor)
    }
}

struct SectionsVisitor;

impl<'de> Visitor<'de> for SectionsVisitor {
    type Value = Sections;

    fn expecting(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str("a namespace or a node with `ros__parameters`")
    }

    fn visit_unit<E>(self) -> Result<Sections, E> {
        Ok(Sections(Vec::new()))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Sections, A::Error> {
        let mut sections = Vec::new();
        while let Some(key) = map.next_key::<String>()? {
            let section = if key == PARAMETERS_KEY {
                Section::Parameters(map.next_value()?)
            } else {
                Section::Below(map.next_value()?)
            };
            sections.push((key, section));
        }
        Ok(Sections(sections))
    }
}

/// Collects the nodes of sections, in their order.
fn collect(
    Sections(sections): &Sections,
    above: &[&str],
    nodes: &mut Vec<Node>,
) -> Result<(), Nav2Error> {
    for (key, section) in sections {
        let below = match section {
            Section::Below(below) => {
                collect(below, &[above, &[key.as_str()]].concat(), nodes)?;
                continue;
            }
            Section::Parameters(Value::Object(below)) => below,
            Section::Parameters(_) => continue,
        };
        let names: Vec<&str> =
            above.iter().flat_map(|name| name.split('/')).filter(|name| !name.is_empty()).collect();
        let path = above.join(".");
        let mut parameters = BTreeMap::new();
        flatten(below, "", &path, &mut parameters)?;
        let (name, namespace) = names.split_last().unwrap_or((&"**", &[]));
        nodes.push(Node {
            namespace: namespace.join("/"),
            name: (*name).to_owned(),
            path,
            parameters,
        });
    }
    Ok(())
}

/// Collects all values except mappings, by their names joined with dots.
fn flatten(
    mapping: &Map<String, Value>,
    above: &str,
    path: &str,
    found: &mut BTreeMap<String, Value>,
) -> Result<(), Nav2Error> {
    for (key, value) in mapping {
        let name = if above.is_empty() { key.clone() } else { format!("{above}.{key}") };
        if let Value::Object(below) = value {
            flatten(below, &name, path, found)?;
        } else if found.insert(name.clone(), value.clone()).is_some() {
            return Err(Nav2Error::Duplicate { parameter: format!("{path}.{name}") });
        }
    }
    Ok(())
}

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

    /// The names of the plugins whose type is of a kind.
    pub fn plugins(&self, is_kind: impl Fn(&str) -> bool) -> Vec<String> {
        let types = self.parameters.keys().filter_map(|key| key.strip_suffix(".plugin"));
        let of_kind = types.filter(|name| {
            !name.contains('.') && self.peek_text(&format!("{name}.plugin")).is_some_and(&is_kind)
        });
        of_kind.map(str::to_owned).collect()
    }

    /// The names in lists of plugins, each once, without those that have no parameters; none if the file has none of the lists.
    pub fn listed_plugins(&self, lists: &[&str]) -> Option<Vec<String>> {
        let lists: Vec<&Value> = lists.iter().filter_map(|list| self.peek(list)).collect();
        if lists.is_empty() {
            return None;
        }
        let listed = lists.into_iter().flat_map(|list| match list {
            Value::Array(names) => names.iter().filter_map(Value::as_str).collect(),
            single => single.as_str().into_iter().collect::<Vec<_>>(),
        });
        let mut names: Vec<String> = Vec::new();
        for name in listed.filter(|name| self.has_plugin(name)) {
            if names.iter().all(|known| known != name) {
                names.push(name.to_owned());
            }
        }
        Some(names)
    }

    fn has_plugin(&self, name: &str) -> bool {
        let prefixes = self.parameters.keys().filter_map(|key| key.split_once('.'));
        prefixes.map(|(prefix, _)| prefix).any(|prefix| prefix == name)
    }

    /// The path that a parameter would have next to these; none if there are none.
    pub fn path_of(&self, name: &str) -> Option<String> {
        let (key, parameter) = self.parameters.first_key_value()?;
        Some(parameter.path.strip_suffix(key.as_str())?.to_owned() + name)
    }

    /// Uses a finite number.
    pub fn number(&mut self, name: &str) -> Result<Option<Parameter<f64>>, Nav2Error> {
        self.take(name, NUMBER, finite)
    }

    /// Uses a whole number, at least one.
    pub fn count(&mut self, name: &str) -> Result<Option<Parameter<u32>>, Nav2Error> {
        self.take(name, "a whole number, 1 to 4294967295", |value| {
            let count = value.as_u64().and_then(|count| u32::try_from(count).ok());
            count.filter(|&count| count > 0)
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

/// A finite number.
pub(super) fn finite(value: &Value) -> Option<f64> {
    value.as_f64().filter(|number| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_whole_names_are_wildcards() {
        let node = |name: &str, value: u32| format!("{name}:\n  ros__parameters: {{a: {value}}}\n");
        let names =
            ["/**", "/control*", "/robot*/controller_server", "/*/controller_server", "/robot"];
        let text: String = names.iter().zip(1..).map(|(name, value)| node(name, value)).collect();
        let file = ParameterFile::parse(&text).expect("a valid file");
        let names = ["controller_server"];
        assert_eq!(file.select_namespace(None, &names).ok().as_deref(), Some(""));
        let (parameters, overridden) = file.node("robot1", names[0]).expect("it has the node");
        assert_eq!(parameters.peek("a"), Some(&Value::from(4)));
        assert_eq!(overridden.len(), 1, "{overridden:?}");
        let mut ignored = file.ignored_nodes("robot1", &names);
        ignored.sort_unstable();
        assert_eq!(ignored, ["/control*", "/robot", "/robot*/controller_server"]);
    }

    /// As in `rclcpp`: a wildcard after a node's own section overrides it.
    #[test]
    fn last_matching_section_wins() {
        let (own, any) = ("b/a: {ros__parameters: {x: 1}}\n", "/**: {ros__parameters: {x: 2}}\n");
        for (text, value) in [([own, any].concat(), 2), ([any, own].concat(), 1)] {
            let file = ParameterFile::parse(&text).expect("a valid file");
            let (parameters, overridden) = file.node("b", "a").expect("it has the node");
            assert_eq!(parameters.peek("x"), Some(&Value::from(value)));
            assert_eq!(overridden.len(), 1, "{overridden:?}");
        }
    }
}
