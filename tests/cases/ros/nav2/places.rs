//! Every parameter of the nodes that are read is in exactly one list.

use std::collections::BTreeSet;

use inbye::ros::nav2::import;
use proptest::prelude::*;
use serde_json::Value;

use super::files::{DWB, ROBOTS, SHIM};

/// Places of all parameters, by a walk of our own: the path without the mark.
fn all(text: &str) -> BTreeSet<String> {
    let root: Value = serde_saphyr::from_str(text).expect("the file is YAML");
    let mut found = BTreeSet::new();
    walk(&root, "", false, &mut found);
    found
}

fn walk(value: &Value, path: &str, marked: bool, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(entries) => {
            for (key, below) in entries {
                let is_mark = key == "ros__parameters";
                let path = match (is_mark, path) {
                    (true, path) => path.to_owned(),
                    (false, "") => key.clone(),
                    (false, path) => format!("{path}.{key}"),
                };
                walk(below, &path, marked || is_mark, found);
            }
        }
        _ if marked => {
            found.insert(path.to_owned());
        }
        _ => {}
    }
}

#[track_caller]
fn assert_each_in_one_list(text: &str, namespace: Option<&str>) {
    let taken = import(text, namespace).expect("a file that can be taken over");
    let mapped: BTreeSet<&str> = taken.mapped.iter().map(|mapped| &*mapped.key).collect();
    let left: BTreeSet<&str> = taken.not_mapped.iter().map(|left| &*left.key).collect();
    assert_eq!(mapped.len(), taken.mapped.len(), "each once");
    assert_eq!(left.len(), taken.not_mapped.len(), "each once");
    assert!(
        mapped.is_disjoint(&left),
        "{:?}",
        mapped.intersection(&left)
    );
    let all = all(text);
    let of_ignored = |key: &str| {
        let begins = |node: &String| key.starts_with(&format!("{node}."));
        taken.ignored.iter().any(begins)
    };
    let expected: BTreeSet<&str> = all
        .iter()
        .map(String::as_str)
        .filter(|key| !of_ignored(key))
        .collect();
    let listed: BTreeSet<&str> = mapped.union(&left).copied().collect();
    assert_eq!(listed, expected);
    assert!(taken.mapped.iter().all(|mapped| !mapped.to.is_empty()));
    assert!(taken.not_mapped.iter().all(|left| left.reason.len() > 4));
}

#[test]
fn each_parameter_is_in_one_list() {
    assert_each_in_one_list(DWB, None);
    assert_each_in_one_list(SHIM, None);
    assert_each_in_one_list(ROBOTS, Some("robot1"));
    assert_each_in_one_list(ROBOTS, Some("robot2"));
}

/// Lines that a parameter file may have under a controller, each sound.
const LINES: [&str; 16] = [
    "plugin: dwb_core::DWBLocalPlanner",
    "plugin: nav2_mppi_controller::MPPIController",
    "plugin: nav2_rotation_shim_controller::RotationShimController",
    "primary_controller: dwb_core::DWBLocalPlanner",
    "max_vel_x: 0.5",
    "vx_max: 0.5",
    "model_dt: 0.05",
    "time_steps: 40",
    "batch_size: 500",
    "max_speed_xy: -1.0",
    "angular_dist_threshold: 0.9",
    "discretize_by_time: true",
    "time_granularity: 0.1",
    "critics: [a, b]",
    "PathDist.scale: 3",
    "nothing: ~",
];

proptest! {
    /// Whatever of it is there.
    #[test]
    fn each_parameter_of_any_controller_is_in_one_list(chosen in proptest::sample::subsequence(LINES.to_vec(), 0..LINES.len())) {
        let mut text = "controller_server:\n  ros__parameters:\n    controller_frequency: 10\n".to_owned();
        let mut seen = BTreeSet::new();
        let mut body = String::new();
        for line in chosen {
            if seen.insert(line.split(':').next().expect("a key")) {
                body += &["      ", line, "\n"].concat();
            }
        }
        if !body.is_empty() {
            text += "    FollowPath:\n";
            text += &body;
        }
        assert_each_in_one_list(&text, None);
    }

    /// No text at all makes it panic.
    #[test]
    fn any_text_is_taken_or_refused(text in "[a-z_:\\[\\]{}&*!|>~'\" \n.0-9-]{0,200}") {
        drop(import(&text, None));
        drop(import(&format!("controller_server:\n  ros__parameters:\n    {text}"), None));
    }

    /// Nor does a damaged file, and what is taken is always sound.
    #[test]
    fn a_damaged_file_is_taken_or_refused(at in 0..DWB.len(), with in "[a-z:.0-9 \n-]{0,3}") {
        let mut text = DWB.to_owned();
        text.replace_range(at..=at, &with);
        if let Ok(taken) = import(&text, None) {
            let config: inbye::runtime::Config = toml::from_str(&taken.config).expect("settings of ours");
            prop_assert_eq!(config.validate(), Ok(()));
        }
    }
}
