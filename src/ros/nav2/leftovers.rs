//! Why the rest of a node's parameters is not taken over.

use super::Why;
use super::draft::Draft;
use super::section::Section;
use crate::suggest::closest_name;

/// A parameter, or a group of them where the name begins or ends with a star, or both; why it is left; in words.
pub(super) type Rule = (&'static str, Why, &'static str);

/// What all nodes have.
const COMMON: [Rule; 9] = [
    (
        "plugin",
        Why::NoSuchThing,
        "it says which plugin is read; nothing is plugged in here",
    ),
    ("use_sim_time", Why::NoSuchThing, "no ROS clock"),
    ("*_topic", Why::NoSuchThing, "no ROS topics"),
    ("topic", Why::NoSuchThing, "no ROS topics"),
    (
        "*_frame",
        Why::NoSuchThing,
        "no tf: the planner is given poses",
    ),
    (
        "*transform_tolerance",
        Why::NoSuchThing,
        "no tf: the planner is given poses",
    ),
    ("bond_*", Why::NoSuchThing, "no lifecycle manager"),
    (
        "use_realtime_priority",
        Why::NoSuchThing,
        "the process keeps its priority",
    ),
    ("introspection_mode", Why::NoSuchThing, "no ROS actions"),
];

/// Lists each parameter that is left with its reason; `mapped` are the names that would have been taken.
pub(super) fn leave(section: Section, draft: &mut Draft, mapped: &[&str], rules: &[&[Rule]]) {
    let all = || rules.iter().copied().flatten().chain(&COMMON);
    for (name, place) in section.rest() {
        if let Some((_, why, words)) = all().find(|(pattern, ..)| matches(pattern, &name)) {
            draft.leave(place, *why, *words);
            continue;
        }
        let known = all()
            .map(|(pattern, ..)| *pattern)
            .chain(mapped.iter().copied());
        let words = match closest_name(&name, known.filter(|known| !known.contains('*'))) {
            Some(meant) => format!("no parameter that is known here: did you mean `{meant}`?"),
            None => "no parameter that is known here".to_owned(),
        };
        draft.leave(place, Why::Unknown, words);
    }
}

fn matches(pattern: &str, name: &str) -> bool {
    match (pattern.strip_prefix('*'), pattern.strip_suffix('*')) {
        (Some(_), Some(_)) => name.contains(pattern.trim_matches('*')),
        (Some(end), None) => name.ends_with(end),
        (None, Some(start)) => name.starts_with(start),
        (None, None) => name == pattern,
    }
}
