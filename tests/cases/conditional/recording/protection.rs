//! The actions of the protective layer in a recording.

use std::collections::BTreeMap;

use inbye::ros::msg::{DiagnosticArray, DiagnosticStatus, Message};
use inbye::sim::WrongPlanner;
use mcap::records::Record;

use super::drives::{record, tour};

pub const TESTS: &[super::Test] =
    &[("diagnostics_hold_each_action_of_the_protective_layer", diagnostics_hold_each_action)];

/// The messages of `/diagnostics`.
fn diagnostics(file: &[u8]) -> Vec<DiagnosticArray> {
    let mut channel_id = None;
    let mut messages = Vec::new();
    for record in mcap::read::ChunkFlattener::new(file).expect("an MCAP file") {
        match record.expect("a whole file") {
            Record::Channel(channel) if channel.topic == "/diagnostics" => {
                channel_id = Some(channel.id);
            }
            Record::Message { header, data } if Some(header.channel_id) == channel_id => {
                messages.push(DiagnosticArray::from_cdr(&data).expect("a message"));
            }
            _ => {}
        }
    }
    messages
}

/// A planner that drives at walls: the layer acts, and the recording names its actions and their reasons.
fn diagnostics_hold_each_action() {
    let (mut simulation, mut config) = tour();
    config.simulation.wrong_planner = WrongPlanner::Obstacles;
    simulation.mission.time_limit_s = 12.0;
    let (result, file) = record(&simulation, &config);
    let messages = diagnostics(&file);
    assert_eq!(messages.len(), result.trace.rows.len());
    let mut ticks: BTreeMap<&str, u64> = BTreeMap::new();
    for message in &messages {
        let names = message.status.iter().map(|status| status.name.as_str());
        assert_eq!(names.collect::<Vec<_>>(), ["inbye: decision", "inbye: protection"]);
        let status = &message.status[1];
        let action = &status.values[0];
        assert_eq!(action.key, "action");
        let passes = action.value == "pass";
        let level = if passes { DiagnosticStatus::OK } else { DiagnosticStatus::WARN };
        assert_eq!(status.level, level, "{status:?}");
        if !passes {
            *ticks.entry(&action.value).or_default() += 1;
        }
        if action.value == "stop" {
            assert!(status.message.contains("m from the body"), "{status:?}");
        }
    }
    assert!(ticks.contains_key("stop"), "{ticks:?}");
    let expected: BTreeMap<&str, u64> =
        result.protective_actions.iter().map(|(name, count)| (*name, *count)).collect();
    assert_eq!(ticks, expected);
}
