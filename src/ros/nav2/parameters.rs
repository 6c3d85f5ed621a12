//! The parameters of ROS 2 nodes in a YAML file: namespaces, wildcards, nested keys.
//!
//! What stands under `ros__parameters` is a node's; the keys above it are the node's name and namespace, nested or joined by
//! slashes. The name `/**` means every node, and what a node says itself goes before that. Keys of parameters may be nested
//! or joined by dots, which is the same to ROS.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value};

use super::Nav2Error;
use super::section::{Parameter, Section};
use crate::map::yaml::{self, BadYaml};

/// Most values a file may unfold to: Nav2's own has about 600.
const MAX_NODES: usize = 100_000;

/// What stands above a node's parameters.
const MARK: &str = "ros__parameters";

/// All nodes of a file.
pub(super) struct Nodes(Vec<Node>);

struct Node {
    /// Namespace, without slashes at its ends; may hold wildcards.
    namespace: String,
    name: String,
    /// Its place in the file, such as `/robot1/controller_server`.
    place: String,
    parameters: BTreeMap<String, Value>,
}

impl Nodes {
    pub fn parse(text: &str) -> Result<Self, Nav2Error> {
        let root: Map<String, Value> = yaml::parse(text, MAX_NODES)
            .map_err(|BadYaml { line, reason }| Nav2Error::BadYaml { line, reason })?;
        let mut nodes = Vec::new();
        collect(&root, &[], &mut nodes)?;
        Ok(Self(nodes))
    }

    /// The namespace to read, of the nodes named: the one asked for, or the only one.
    pub fn namespace(&self, wanted: Option<&str>, names: &[&str]) -> Result<String, Nav2Error> {
        let known = self.0.iter().filter(|node| names.contains(&&*node.name));
        let found: BTreeSet<&str> = known
            .map(robot)
            .filter(|namespace| !is_wild(namespace))
            .collect();
        let listed = || {
            let quoted = found.iter().map(|namespace| match *namespace {
                "" => "the root".to_owned(),
                namespace => format!("`{namespace}`"),
            });
            quoted.collect::<Vec<_>>().join(", ")
        };
        match wanted.map(|wanted| wanted.trim_matches('/')) {
            Some(wanted) if found.contains(wanted) => Ok(wanted.to_owned()),
            Some(wanted) => Err(Nav2Error::NoSuchNamespace {
                wanted: wanted.to_owned(),
                found: listed(),
            }),
            None if found.len() > 1 => Err(Nav2Error::SeveralNamespaces { found: listed() }),
            None => Ok(found.first().copied().unwrap_or_default().to_owned()),
        }
    }

    /// The parameters in force for a node, by their names; and those that give way to others, each with the place of what is
    /// in force. None when nothing is said of it.
    pub fn of(&self, namespace: &str, name: &str) -> Option<(Section, Vec<(String, String)>)> {
        let mut parameters: BTreeMap<String, Parameter> = BTreeMap::new();
        let mut overridden = Vec::new();
        let mut matching: Vec<&Node> = self
            .0
            .iter()
            .filter(|node| node.is_for(namespace, name))
            .collect();
        // The most general first: what follows takes its place.
        matching.sort_by_key(|node| (!is_wild(&node.name), !is_wild(&node.namespace)));
        for node in &matching {
            for (key, value) in &node.parameters {
                let place = format!("{}.{key}", node.place);
                let parameter = Parameter {
                    place: place.clone(),
                    value: value.clone(),
                };
                if let Some(before) = parameters.insert(key.clone(), parameter) {
                    overridden.push((before.place, place));
                }
            }
        }
        (!matching.is_empty()).then(|| (Section::new(parameters), overridden))
    }

    /// Places of the nodes that are not among those named, or not in the namespace.
    pub fn others(&self, namespace: &str, names: &[&str]) -> Vec<String> {
        let is_read = |node: &&Node| names.iter().any(|name| node.is_for(namespace, name));
        let others = self.0.iter().filter(|node| !is_read(node));
        others.map(|node| node.place.clone()).collect()
    }
}

impl Node {
    fn is_for(&self, namespace: &str, name: &str) -> bool {
        let own = robot(self);
        let named = self.name == name || is_wild(&self.name);
        named && (own == namespace || is_wild(own) || (own.is_empty() && is_wild(&self.name)))
    }
}

/// The namespace of the robot: a costmap's node has its own name once more as the last part.
fn robot(node: &Node) -> &str {
    let namespace = node.namespace.as_str();
    let (before, last) = namespace.rsplit_once('/').unwrap_or(("", namespace));
    if last == node.name { before } else { namespace }
}

fn is_wild(name: &str) -> bool {
    name.contains('*')
}

/// Finds the nodes in a mapping, and below.
fn collect(
    mapping: &Map<String, Value>,
    above: &[&str],
    nodes: &mut Vec<Node>,
) -> Result<(), Nav2Error> {
    for (key, value) in mapping {
        let Value::Object(below) = value else {
            continue;
        };
        if key != MARK {
            collect(below, &[above, &[key.as_str()]].concat(), nodes)?;
            continue;
        }
        let names: Vec<&str> = above
            .iter()
            .flat_map(|name| name.split('/'))
            .filter(|name| !name.is_empty())
            .collect();
        let place = above.join(".");
        let mut parameters = BTreeMap::new();
        flatten(below, "", &place, &mut parameters)?;
        let (name, namespace) = names.split_last().unwrap_or((&"**", &[]));
        nodes.push(Node {
            namespace: namespace.join("/"),
            name: (*name).to_owned(),
            place,
            parameters,
        });
    }
    Ok(())
}

/// All values that are no mappings, by their names joined with dots.
fn flatten(
    mapping: &Map<String, Value>,
    above: &str,
    place: &str,
    found: &mut BTreeMap<String, Value>,
) -> Result<(), Nav2Error> {
    for (key, value) in mapping {
        let name = if above.is_empty() {
            key.clone()
        } else {
            format!("{above}.{key}")
        };
        if let Value::Object(below) = value {
            flatten(below, &name, place, found)?;
        } else if found.insert(name.clone(), value.clone()).is_some() {
            return Err(Nav2Error::Twice {
                key: format!("{place}.{name}"),
            });
        }
    }
    Ok(())
}
