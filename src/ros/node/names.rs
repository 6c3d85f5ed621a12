//! The names of the node, its topics, its services and its action in ROS, and rules that remap them.

use std::collections::BTreeMap;

use thiserror::Error;

/// The name of the node, unless a rule sets another.
const NODE: &str = "inbye";
/// Where the names begin that are within the node's own name.
const PRIVATE: &str = "inbye/";

/// The names in rules for the namespace and for the name of the node, which ROS 2 also calls `__name`.
const SPECIAL: [&str; 3] = ["__ns", "__node", "__name"];

/// The names that a rule can remap, relative to the namespace.
const NAMES: [&str; 23] = [
    "cmd_vel",
    "costmap_filter_info",
    "diagnostics",
    "goal_pose",
    "inbye/arm",
    "inbye/change_state",
    "inbye/get_available_transitions",
    "inbye/get_state",
    "inbye/stop",
    "inbye/transition_event",
    "inbye/updated_map",
    "initialpose",
    "keepout_filter_mask",
    "local_markers",
    "map",
    "navigate_to_pose",
    "odom",
    "plan",
    "scan",
    "speed_filter_mask",
    "speed_limit",
    "tf",
    "tf_static",
];

/// Why names are invalid.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NameError {
    /// The namespace is invalid in ROS.
    #[error(
        "the namespace `{namespace}` is invalid: begin with a slash and a letter, then letters, digits and single underscores, \
         such as /robot1"
    )]
    BadNamespace {
        /// The namespace.
        namespace: String,
    },
    /// The name of the node is invalid in ROS.
    #[error(
        "the node's name `{name}` is invalid: begin with a letter, then letters, digits and single underscores"
    )]
    BadNodeName {
        /// The name.
        name: String,
    },
    /// A text is not a rule.
    #[error("`{rule}` is not a rule: write FROM:=TO, such as scan:=/front/scan")]
    BadRule {
        /// The text.
        rule: String,
    },
    /// A name in a rule is invalid in ROS.
    #[error(
        "the name `{name}` is invalid: its parts between slashes begin with a letter, then letters, digits and single underscores"
    )]
    BadName {
        /// The name.
        name: String,
    },
    /// A rule is for a name that the node does not have.
    #[error("the node has no name `{name}`: its names are {}, __ns and __node", NAMES.join(", "))]
    UnknownName {
        /// The name.
        name: String,
    },
}

/// The names of a node in ROS.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeNames {
    /// With a leading slash; empty for the root.
    namespace: String,
    node: String,
    /// The full names that differ from the usual ones.
    remapped: BTreeMap<&'static str, String>,
}

/// The node `inbye` without a namespace.
impl Default for NodeNames {
    fn default() -> Self {
        let (namespace, node) = (String::new(), NODE.to_owned());
        Self { namespace, node, remapped: BTreeMap::new() }
    }
}

impl NodeNames {
    /// The names within a namespace, remapped by rules `FROM:=TO` as in ROS 2: `__ns` sets the namespace and `__node` the name of
    /// the node; other names are relative, absolute with a leading slash, or within the node's own name with a leading `~/`. The
    /// first of several rules for a name counts.
    ///
    /// # Errors
    /// A name is invalid in ROS, or a rule is for a name that the node does not have.
    pub fn new(namespace: &str, rules: &[String]) -> Result<Self, NameError> {
        let split = |rule: &'_ String| {
            let parts = rule.split_once(":=").map(|(from, to)| (from.to_owned(), to.to_owned()));
            parts.ok_or_else(|| NameError::BadRule { rule: rule.clone() })
        };
        let rules: Vec<(String, String)> = rules.iter().map(split).collect::<Result<_, _>>()?;
        let [ns, node, name] =
            SPECIAL.map(|name| rules.iter().find(|(from, _)| from == name).map(|(_, to)| &**to));
        let mut names = Self::default();
        names.set_namespace(ns.unwrap_or(namespace))?;
        names.set_node(node.or(name).unwrap_or(NODE))?;
        let mut remapped = BTreeMap::new();
        for (from, to) in rules.iter().filter(|(from, _)| !SPECIAL.contains(&&**from)) {
            let full = names.expand(from)?;
            let name = NAMES.into_iter().find(|name| names.full(name) == full);
            let name = name.ok_or_else(|| NameError::UnknownName { name: from.clone() })?;
            remapped.entry(name).or_insert(names.expand(to)?);
        }
        names.remapped.extend(remapped);
        Ok(names)
    }

    fn set_namespace(&mut self, namespace: &str) -> Result<(), NameError> {
        if !(["", "/"].contains(&namespace) || is_full_name(namespace)) {
            return Err(NameError::BadNamespace { namespace: namespace.to_owned() });
        }
        // A slash alone is the root.
        namespace.trim_end_matches('/').clone_into(&mut self.namespace);
        Ok(())
    }

    fn set_node(&mut self, node: &str) -> Result<(), NameError> {
        if !is_token(node) {
            return Err(NameError::BadNodeName { name: node.to_owned() });
        }
        node.clone_into(&mut self.node);
        if node != NODE {
            let private =
                NAMES.iter().filter_map(|name| Some((*name, name.strip_prefix(PRIVATE)?)));
            let full = |(name, inner)| (name, format!("{}/{node}/{inner}", self.namespace));
            self.remapped = private.map(full).collect();
        }
        Ok(())
    }

    /// The full name of a name in a rule.
    fn expand(&self, name: &str) -> Result<String, NameError> {
        let full = match name.strip_prefix("~/") {
            Some(inner) => format!("{}/{inner}", self.full_node()),
            None if name.starts_with('/') => name.to_owned(),
            None => format!("{}/{name}", self.namespace),
        };
        if is_full_name(&full) {
            Ok(full)
        } else {
            Err(NameError::BadName { name: name.to_owned() })
        }
    }

    /// The namespace, with a leading slash; a slash alone for the root.
    #[must_use]
    pub fn namespace(&self) -> &str {
        if self.namespace.is_empty() { "/" } else { &self.namespace }
    }

    /// The name of the node.
    #[must_use]
    pub fn node(&self) -> &str {
        &self.node
    }

    /// The name of the node with its namespace.
    #[must_use]
    pub fn full_node(&self) -> String {
        format!("{}/{}", self.namespace, self.node)
    }

    /// The full name of a topic, a service or the action, by its usual name.
    #[must_use]
    pub fn full(&self, name: &str) -> String {
        let usual = || format!("{}/{name}", self.namespace);
        self.remapped.get(name).cloned().unwrap_or_else(usual)
    }

    /// The name for texts: the usual one, or the full one if it is remapped.
    #[must_use]
    pub fn shown<'a>(&'a self, name: &'a str) -> &'a str {
        self.remapped.get(name).map_or(name, |full| full)
    }
}

/// Whether a text is a full name: parts with a slash before each.
fn is_full_name(name: &str) -> bool {
    name.strip_prefix('/').is_some_and(|parts| parts.split('/').all(is_token))
}

/// Whether a text is a part of a name.
fn is_token(token: &str) -> bool {
    token.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_')
        && token.chars().all(|it| it.is_ascii_alphanumeric() || it == '_')
        && !token.contains("__")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(namespace: &str, rules: &[&str]) -> Result<NodeNames, NameError> {
        let rules: Vec<String> = rules.iter().map(|rule| (*rule).to_owned()).collect();
        NodeNames::new(namespace, &rules)
    }

    #[test]
    fn rule_remaps_relative_absolute_and_private_names() {
        for (namespace, rule, name, expected) in [
            ("", "scan:=front/scan", "scan", "/front/scan"),
            ("/rover", "scan:=front/scan", "scan", "/rover/front/scan"),
            ("/rover", "/rover/scan:=/scan", "scan", "/scan"),
            ("/rover", "tf:=/tf", "tf", "/tf"),
            ("/rover", "~/arm:=arm", "inbye/arm", "/rover/arm"),
            ("/rover", "inbye/arm:=~/on", "inbye/arm", "/rover/inbye/on"),
            ("/", "cmd_vel:=cmd_vel_nav", "cmd_vel", "/cmd_vel_nav"),
        ] {
            let names = names(namespace, &[rule]).expect(rule);
            assert_eq!((names.full(name), names.shown(name)), (expected.to_owned(), expected));
            // All others keep their names.
            let odom = format!("{}/odom", namespace.trim_end_matches('/'));
            assert_eq!((names.full("odom"), names.shown("odom")), (odom, "odom"));
        }
    }

    #[test]
    fn rules_set_namespace_and_node_before_all_others() {
        let names = names("/rover", &["~/stop:=halt", "__ns:=/robot1", "__node:=nav"]);
        let names = names.expect("valid rules");
        assert_eq!((names.namespace(), names.node()), ("/robot1", "nav"));
        assert_eq!(names.full("inbye/get_state"), "/robot1/nav/get_state");
        assert_eq!(names.full("inbye/stop"), "/robot1/halt");
        assert_eq!(names.full("scan"), "/robot1/scan");
    }

    #[test]
    fn first_rule_for_a_name_counts() {
        let names = names("", &["scan:=first", "/scan:=second", "odom:=scan"]);
        let names = names.expect("valid rules");
        // A name that a rule gives is not remapped again.
        assert_eq!((names.full("scan"), names.full("odom")), ("/first".into(), "/scan".into()));
    }

    #[test]
    fn invalid_names_and_rules_are_errors() {
        let error = |namespace, rule| names(namespace, &[rule]).expect_err(rule).to_string();
        for rule in ["scans:=/scan", "/scan:=/front/scan", "~/scan:=/scan"] {
            let text = error("/rover", rule);
            assert!(text.contains("has no name") && text.contains("plan, scan, speed"), "{text}");
        }
        for (rule, words) in [
            ("scan", "`scan` is not a rule: write FROM:=TO"),
            ("scan:=", "the name `` is invalid"),
            ("scan:=a//b", "the name `a//b` is invalid"),
            ("scan:=1st", "the name `1st` is invalid"),
            ("scan:=a__b", "the name `a__b` is invalid"),
            ("scan:=~scan", "the name `~scan` is invalid"),
            ("__ns:=robot1", "the namespace `robot1` is invalid"),
            ("__node:=a/b", "the node's name `a/b` is invalid"),
        ] {
            let text = error("/rover", rule);
            assert!(text.contains(words), "{text}");
        }
        for namespace in ["rover", "/rover/", "/1st", "//"] {
            let found = names(namespace, &[]);
            assert!(matches!(found, Err(NameError::BadNamespace { .. })), "{namespace}");
        }
    }

    #[test]
    fn every_topic_of_a_message_can_be_remapped() {
        use crate::ros::node::IncomingMessage;
        for name in IncomingMessage::topics() {
            assert!(NAMES.contains(&name), "{name}");
        }
        assert!(NAMES.is_sorted());
    }
}
