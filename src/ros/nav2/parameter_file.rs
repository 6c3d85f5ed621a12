//! The parameters of ROS 2 nodes in a YAML file: namespaces, wildcards, nested keys.
//!
//! The parameters of a node are below `ros__parameters`. The keys above it are the node's namespace and name, nested or joined
//! by slashes. The name `/**` matches every node; a node's own parameters override it. Keys of parameters may be nested or
//! joined by dots: for ROS both are equal.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value};

use super::error::Nav2Error;
use super::parameters::{Parameter, Parameters};
use crate::map::yaml::{self, BadYaml};

/// Maximum number of values of a file after the expansion of aliases: Nav2's own file has about 600.
const MAX_VALUES: usize = 100_000;

/// The key above a node's parameters.
const PARAMETERS_KEY: &str = "ros__parameters";

/// The nodes of a file.
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
        let root: Map<String, Value> = yaml::parse(text, MAX_VALUES)
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
            known.map(robot).filter(|namespace| !is_wild(namespace)).collect();
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
        let mut matching: Vec<&Node> =
            self.0.iter().filter(|node| node.matches(namespace, name)).collect();
        // The most general first: the others override it.
        matching.sort_by_key(|node| (!is_wild(&node.name), !is_wild(&node.namespace)));
        for node in &matching {
            for (key, value) in &node.parameters {
                let path = format!("{}.{key}", node.path);
                let parameter = Parameter { path: path.clone(), value: value.clone() };
                if let Some(before) = parameters.insert(key.clone(), parameter) {
                    overridden.push((before.path, path));
                }
            }
        }
        (!matching.is_empty()).then(|| (Parameters::new(parameters), overridden))
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

fn is_wild(name: &str) -> bool {
    name.contains('*')
}

/// Collects the nodes in a mapping and its nested mappings.
fn collect(
    mapping: &Map<String, Value>,
    above: &[&str],
    nodes: &mut Vec<Node>,
) -> Result<(), Nav2Error> {
    for (key, value) in mapping {
        let Value::Object(below) = value else {
            continue;
        };
        if key != PARAMETERS_KEY {
            collect(below, &[above, &[key.as_str()]].concat(), nodes)?;
            continue;
        }
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
