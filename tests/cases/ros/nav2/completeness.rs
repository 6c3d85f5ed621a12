//! Every parameter of the imported nodes is in exactly one list.

use std::collections::BTreeSet;

use inbye::ros::nav2::import;
use proptest::prelude::*;
use serde_json::Value;

use super::files::{DWB, ROBOTS, SHIM};

/// The paths of all parameters, without `ros__parameters`.
fn all(text: &str) -> BTreeSet<String> {
    let root: Value = serde_saphyr::from_str(text).expect("the file is YAML");
    let mut found = BTreeSet::new();
    walk(&root, "", false, &mut found);
    found
}

fn walk(value: &Value, path: &str, in_node: bool, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(entries) => {
            for (key, below) in entries {
                let is_parameters = key == "ros__parameters";
                let path = match (is_parameters, path) {
                    (true, path) => path.to_owned(),
                    (false, "") => key.clone(),
                    (false, path) => format!("{path}.{key}"),
                };
                walk(below, &path, in_node || is_parameters, found);
            }
        }
        _ if in_node => {
            found.insert(path.to_owned());
        }
        _ => {}
    }
}

#[track_caller]
fn assert_one_list_per_parameter(text: &str, namespace: Option<&str>) {
    let imported = import(text, namespace).expect("a valid file");
    let mapped: BTreeSet<&str> = imported.mapped.iter().map(|mapped| &*mapped.parameter).collect();
    let unmapped = imported.unmapped.iter();
    let unmapped: BTreeSet<&str> = unmapped.map(|unmapped| &*unmapped.parameter).collect();
    assert_eq!(mapped.len(), imported.mapped.len(), "each once");
    assert_eq!(unmapped.len(), imported.unmapped.len(), "each once");
    assert!(mapped.is_disjoint(&unmapped), "{:?}", mapped.intersection(&unmapped));
    let all = all(text);
    let of_ignored = |key: &str| {
        let begins = |node: &String| key.starts_with(&format!("{node}."));
        imported.ignored_nodes.iter().any(begins)
    };
    let expected: BTreeSet<&str> =
        all.iter().map(String::as_str).filter(|key| !of_ignored(key)).collect();
    let listed: BTreeSet<&str> = mapped.union(&unmapped).copied().collect();
    assert_eq!(listed, expected);
    assert!(imported.mapped.iter().all(|mapped| !mapped.settings.is_empty()));
    assert!(imported.unmapped.iter().all(|unmapped| unmapped.explanation.len() > 4));
}

#[test]
fn every_parameter_is_in_one_list() {
    assert_one_list_per_parameter(DWB, None);
    assert_one_list_per_parameter(SHIM, None);
    assert_one_list_per_parameter(ROBOTS, Some("robot1"));
    assert_one_list_per_parameter(ROBOTS, Some("robot2"));
}

/// Valid lines of a controller in a parameter file.
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
    #[test]
    fn every_parameter_of_random_controllers_is_in_one_list(chosen in proptest::sample::subsequence(LINES.to_vec(), 0..LINES.len())) {
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
        assert_one_list_per_parameter(&text, None);
    }

    #[test]
    fn random_text_never_panics(text in "[a-z_:\\[\\]{}&*!|>~'\" \n.0-9-]{0,200}") {
        drop(import(&text, None));
        drop(import(&format!("controller_server:\n  ros__parameters:\n    {text}"), None));
    }

    #[test]
    fn damaged_file_gives_valid_settings_or_an_error(at in 0..DWB.len(), with in "[a-z:.0-9 \n-]{0,3}") {
        let mut text = DWB.to_owned();
        text.replace_range(at..=at, &with);
        if let Ok(imported) = import(&text, None) {
            let config: inbye::runtime::Config = toml::from_str(&imported.config).expect("valid settings");
            prop_assert_eq!(config.validate(), Ok(()));
        }
    }
}
