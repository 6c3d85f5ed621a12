//! The definitions of all messages, as ROS 2 writes them: those of `common_interfaces` since Humble without
//! their comments, and our own `inbye_msgs/Tick`.

use std::collections::VecDeque;

/// Every definition under a line with its name, parted by [`separator`].
const DEFINITIONS: &str = include_str!("definitions.msg");

/// What stands between two definitions in the encoding `ros2msg`.
fn separator() -> String {
    format!("{}\n", "=".repeat(80))
}

/// The definition of a type such as `nav_msgs/Path`, without those that it is made of; none of an unknown type.
fn definition(name: &str) -> Option<&'static str> {
    let separator = separator();
    DEFINITIONS.split(separator.as_str()).find_map(|entry| {
        let (head, body) = entry.split_once('\n')?;
        (head.strip_prefix("MSG: ")? == name).then_some(body)
    })
}

/// The types that a definition's fields have, besides those built in.
fn parts(definition: &str) -> impl Iterator<Item = &str> {
    let types = definition
        .lines()
        .filter_map(|line| line.split(' ').next()?.split('[').next());
    types.filter(|name| name.contains('/'))
}

/// A type's schema in the encoding `ros2msg`: its definition, then those of all types that it is made of, each once.
pub fn schema(name: &str) -> String {
    let mut text = definition(name).unwrap_or_default().to_owned();
    let mut told = Vec::new();
    let mut ahead: VecDeque<&str> = parts(definition(name).unwrap_or_default()).collect();
    while let Some(part) = ahead.pop_front() {
        if told.contains(&part) {
            continue;
        }
        told.push(part);
        let body = definition(part).unwrap_or_default();
        ahead.extend(parts(body));
        text.extend([separator().as_str(), "MSG: ", part, "\n", body]);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_of_every_definition_is_defined() {
        let separator = separator();
        let mut seen = 0;
        for entry in DEFINITIONS.split(separator.as_str()) {
            let (_, body) = entry.split_once('\n').expect("a name and a body");
            for part in parts(body) {
                assert!(definition(part).is_some(), "{part}");
                seen += 1;
            }
        }
        assert!(seen > 20, "{seen}");
    }

    #[test]
    fn a_schema_holds_what_it_is_made_of_once() {
        let schema = schema("nav_msgs/Path");
        assert!(schema.starts_with("std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n"));
        let names: Vec<&str> = schema
            .lines()
            .filter_map(|line| line.strip_prefix("MSG: "))
            .collect();
        assert_eq!(
            names,
            [
                "std_msgs/Header",
                "geometry_msgs/PoseStamped",
                "builtin_interfaces/Time",
                "geometry_msgs/Pose",
                "geometry_msgs/Point",
                "geometry_msgs/Quaternion",
            ]
        );
    }
}
