//! The node over DDS with an independent peer: Eclipse Cyclone DDS in Python (`peer.py`).
//!
//! Both run in a network namespace with only the loopback: no packet reaches another machine. That
//! needs `unshare` and `ip`, root or user namespaces, and a Python with `cyclonedds` and numpy: `python3`, or the one that
//! `INBYE_DDS_PYTHON` names. Without them the trials are ignored, or fail if `INBYE_REQUIRE` holds the word `cyclonedds`.

use std::env;
use std::fmt::Display;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use libtest_mimic::{Completion, Failed, Trial};
use serde_json::Value;

use crate::support::requirements::required;

const PROGRAM: &str = env!("CARGO_BIN_EXE_inbye");
const PEER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cases/conditional/node/peer.py");

/// A network of the loopback alone, with multicast, for the command that follows.
const ALONE: &str = "ip link set lo up && ip link set lo multicast on && ip route add 239.0.0.0/8 dev lo && exec \"$@\"";

type Check = fn(&Value) -> Result<(), Failed>;

pub fn trials() -> Vec<Trial> {
    let scenarios: [(&'static str, Check); 13] = [
        ("drives_to_goal", drives_to_goal),
        ("remapped_names", remapped_names),
        ("localizes", localizes),
        ("navigates", navigates),
        ("managed", managed),
        ("late_joiner", late_joiner),
        ("missing_inputs", missing_inputs),
        ("invalid_messages", invalid_messages),
        ("endless_heartbeat", endless_heartbeat),
        ("mutated_packets", mutated_packets),
        ("network_process_hangs", network_process_hangs),
        ("control_process_dies", control_process_dies),
        ("arming", arming),
    ];
    let trial = |(name, check): (&'static str, Check)| {
        Trial::ignorable_test(name, move || with_peer(name, check))
    };

    scenarios.map(trial).into()
}

/// The robot reaches the goal with a namespace, `tf`, a lidar off the origin and stamped velocities.
fn drives_to_goal(facts: &Value) -> Result<(), Failed> {
    holds(facts["commands_before_goal"] == 0, "no command without a goal", facts)?;
    holds(facts["took_s"].is_number(), "the goal is reached", facts)?;
    holds(number(facts, "away_m") < 0.1, "near the goal", facts)?;
    holds(number(facts, "yaw_error").abs() < 0.15, "yaw of the goal", facts)?;
    holds(facts["contacts"] == 0, "no wall is touched", facts)?;
    let shown = facts["markers"].to_string();
    // 65 arcs of 10 pieces with two ends each.
    holds(shown.contains("[\"arcs\",5,1300]"), "arcs are shown", facts)?;
    holds(shown.contains("[\"chosen\",4,11]"), "the chosen arc is shown", facts)?;
    // One may be in the pipe between the two processes of the node.
    holds(number(facts, "commands_after_end") <= 1.0, "no command after the goal", facts)?;
    holds(facts["stats"]["reached"] == 1, "the goal is counted", facts)?;
    ends_cleanly(facts)
}

/// With the arguments of a launch file, the node has its namespace, and reads scans and publishes commands by their remapped names.
/// A driver that wants stamped velocities is a warning until it is gone.
fn remapped_names(facts: &Value) -> Result<(), Failed> {
    holds(facts["had_conflict"] == false, "no warning without the driver", facts)?;
    holds(facts["warned_s"].is_number(), "another type is a warning", facts)?;
    holds(facts["left_s"].is_number(), "until the driver is gone", facts)?;
    let notices = facts["notices"].to_string();
    for words in [
        "node /robot1/inbye in domain 0",
        "reads /base/cmd_vel as geometry_msgs/msg/TwistStamped, but this node publishes geometry_msgs/msg/Twist,",
        "start this node with --stamped",
    ] {
        holds(notices.contains(words), words, facts)?;
    }
    holds(facts["took_s"].is_number(), "the goal is reached", facts)?;
    holds(facts["contacts"] == 0, "no wall is touched", facts)?;
    ends_cleanly(facts)
}

/// The robot without a localization node reaches the goal, and `tf` has where its odometry began.
fn localizes(facts: &Value) -> Result<(), Failed> {
    holds(facts["stats"]["received"]["initialpose"] == 1, "the rough pose is received", facts)?;
    holds(facts["took_s"].is_number(), "the goal is reached", facts)?;
    holds(number(facts, "away_m") < 0.15, "near the goal", facts)?;
    holds(facts["contacts"] == 0, "no wall is touched", facts)?;
    holds(number(facts, "transforms") > 100.0, "at each tick", facts)?;
    // A cell of the map is 0.1 m, and a beam ends in steps of 0.03 m.
    holds(number(facts, "largest_error_m") < 0.2, "where the odometry began", facts)?;
    holds(facts["warned_s"].is_number(), "other publishers are a warning", facts)?;
    holds(facts["left_s"].is_number(), "until they are gone", facts)?;
    let notices = facts["notices"].to_string();
    holds(notices.contains("another node publishes on cmd_vel too"), "and a notice", facts)?;
    ends_cleanly(facts)
}

/// A client of the action `navigate_to_pose`, with services as Cyclone DDS's RMW speaks them.
fn navigates(facts: &Value) -> Result<(), Failed> {
    holds(facts["first_accepted"] == true, "the first goal is accepted", facts)?;
    holds(facts["started_s"].is_number(), "the robot drives", facts)?;
    holds(facts["cancel_code"] == 0, "the request to cancel is accepted", facts)?;
    holds(facts["canceling"] == serde_json::json!([true]), "it names the goal", facts)?;
    holds(facts["first_status"] == 5, "the first goal is cancelled", facts)?;
    holds(number(facts, "crept_m") < 0.01, "the robot stands", facts)?;
    holds(facts["second_accepted"] == true, "the second goal is accepted", facts)?;
    holds(facts["took_s"].is_number(), "the goal is reached", facts)?;
    holds(facts["second_status"] == 4, "the second goal has succeeded", facts)?;
    holds(facts["second_error"] == serde_json::json!([0, ""]), "without an error", facts)?;
    holds(facts["statuses"].to_string().contains("[2,4]"), "a status says so", facts)?;
    holds(facts["third_accepted"] == false, "a goal nowhere is rejected", facts)?;
    holds(facts["fourth_started_s"].is_number(), "the robot drives to the fourth goal", facts)?;
    let end = facts["fourth_end"].to_string();
    holds(end.starts_with("[6,9000,\"the network process was restarted"), "its end", facts)?;
    holds(
        facts["open_request_end"] == serde_json::json!([6, 9000]),
        "also of an open request",
        facts,
    )?;
    holds(facts["late_cancel_code"] == 3, "it is no longer there to be cancelled", facts)?;
    holds(number(facts, "crept_after_restart_m") < 0.01, "the robot stands", facts)?;
    let feedback = &facts["feedback"];
    let at = |index: usize| feedback[index].as_f64().unwrap_or(f64::NAN);
    holds(at(0) > 20.0 && at(1) > 3.0 && at(2) < 1.0, "the distance falls", facts)?;
    holds(facts["contacts"] == 0, "no wall is touched", facts)?;
    holds(facts["status"] == 0, "exit status 0", facts)
}

/// A lifecycle manager configures and activates the node, deactivates it while the robot drives, and shuts it down.
fn managed(facts: &Value) -> Result<(), Failed> {
    holds(facts["commands_before"] == 0, "no command before it is active", facts)?;
    let states = serde_json::json!([[1, "unconfigured"], [3, "active"], [2, "inactive"]]);
    holds(facts["states"] == states, "its states", facts)?;
    let changes = serde_json::json!([false, true, true, true, true]);
    holds(facts["changes"] == changes, "only transitions that begin there", facts)?;
    holds(facts["started_s"].is_number(), "the robot drives", facts)?;
    holds(number(facts, "stopped_s") < 5.0, "the robot stands", facts)?;
    holds(facts["has_ended"] == true, "the node ends", facts)?;
    holds(facts["contacts"] == 0, "no wall is touched", facts)?;
    ends_cleanly(facts)
}

/// The map is older than the node, the plan older than its reader; Ctrl-C ends the node during the drive.
fn late_joiner(facts: &Value) -> Result<(), Failed> {
    holds(facts["stats"]["received"]["map"] == 1, "the map is received", facts)?;
    holds(facts["started_s"].is_number(), "the robot drove", facts)?;
    holds(facts["plan_s"].is_number(), "the plan is received", facts)?;
    holds(number(facts, "plan_from_m") < 0.01, "from the start", facts)?;
    holds(number(facts, "plan_to_m") < 0.01, "to the goal", facts)?;
    holds(facts["plan_frame"] == "map", "in the map's frame", facts)?;
    holds(number(facts, "speed_at_end") > 0.1, "still on the move", facts)?;
    let last = facts["last_command"].to_string();
    holds(last == "[0.0,0.0]", "the last command is zero", facts)?;
    ends_cleanly(facts)
}

/// Scans stop, then odometry: the robot stops within seconds and continues when they return.
fn missing_inputs(facts: &Value) -> Result<(), Failed> {
    for input in ["scan", "odometry"] {
        let speed = number(facts, &format!("{input}_speed"));
        holds(speed > 0.1, "on the move", facts)?;
        // 0.3 s until the input is too old and as long to brake; the rest is for busy cores.
        let zero_s = number(facts, &format!("{input}_zero_s"));
        holds(zero_s < 3.0, "zero is commanded", facts)?;
        let crept_m = number(facts, &format!("{input}_crept_m"));
        holds(crept_m < 0.01, "the robot stands", facts)?;
        let resumed = &facts[format!("{input}_resumed_s")];
        holds(resumed.is_number(), "the robot continues", facts)?;
    }
    let notices = facts["notices"].to_string();
    for words in ["there is no fresh scan", "odometry is no longer received"] {
        holds(notices.contains(words), words, facts)?;
    }
    holds(facts["took_s"].is_number(), "the goal is reached", facts)?;
    holds(facts["contacts"] == 0, "no wall is touched", facts)?;
    ends_cleanly(facts)
}

/// Each invalid message is rejected and counted; each invalid goal is reported, and each other cause once.
fn invalid_messages(facts: &Value) -> Result<(), Failed> {
    holds(facts["commands"] == 0, "nothing is commanded", facts)?;
    let rejected = &facts["stats"]["rejected"];
    holds(rejected["map"] == 1, "a cell of 101", facts)?;
    holds(rejected["goal_pose"] == 4, "goals nowhere", facts)?;
    let notices = facts["notices"].to_string();
    let other_qos = "a publisher on goal_pose has another quality of service (QoS), and none of its messages arrive: publish as reliable";
    let no_pose = "in the frame `odom`, whose pose in the map's frame `map` is not known";
    for (words, count) in
        [("cell 364 is 101", 1), (no_pose, 3), ("pose is not finite", 1), (other_qos, 1)]
    {
        holds(notices.matches(words).count() == count, words, facts)?;
    }
    ends_cleanly(facts)
}

/// A message of 52 bytes makes the DDS library list 2^32 numbers: its process ends at its memory limit of 256 MiB and starts
/// again. The robot stands meanwhile, gets zeros first, and continues.
fn endless_heartbeat(facts: &Value) -> Result<(), Failed> {
    holds(facts["bytes"] == 52, "a message of 52 bytes", facts)?;
    stood_and_continued(facts)?;
    let notices = facts["notices"].to_string();
    holds(notices.contains("the network process was lost"), "the loss is reported", facts)?;
    holds(number(facts, "network_mib") < 256.0, "the network process keeps its limit", facts)?;
    holds(number(facts, "control_mib") < 128.0, "the control process stays small", facts)
}

/// 400 mutated packets a second reach the node while the robot drives: it stays in control, and reaches its goal afterwards. `INBYE_PACKET_SECONDS=3600`
/// makes that a search of an hour.
fn mutated_packets(facts: &Value) -> Result<(), Failed> {
    holds(number(facts, "packets") > 500.0, "many packets", facts)?;
    holds(facts["contacts"] == 0, "no contact", facts)?;
    holds(number(facts, "fastest") <= 1.0, "no command beyond the limit", facts)?;
    holds(number(facts, "network_mib") < 256.0, "the network process keeps its limit", facts)?;
    holds(number(facts, "control_mib") < 128.0, "the control process stays small", facts)?;
    holds(facts["took_s"].is_number(), "the robot reaches its goal", facts)?;
    ends_cleanly(facts)
}

/// A network process that hangs is ended and started again.
fn network_process_hangs(facts: &Value) -> Result<(), Failed> {
    stood_and_continued(facts)?;
    let notices = facts["notices"].to_string();
    holds(notices.contains("no sign of life"), "the loss is reported", facts)
}

fn stood_and_continued(facts: &Value) -> Result<(), Failed> {
    holds(facts["started_s"].is_number(), "the robot drove", facts)?;
    // 1 s until a silent process counts as lost; the rest is for busy cores.
    holds(number(facts, "lost_s") < 15.0, "the process is replaced", facts)?;
    holds(number(facts, "zero_s") < 15.0, "zeros arrive afterwards", facts)?;
    holds(facts["first_after"] == serde_json::json!([0.0, 0.0]), "zeros come first", facts)?;
    holds(facts["resumed_s"].is_number(), "the robot continues", facts)?;
    holds(facts["took_s"].is_number(), "the goal is reached", facts)?;
    holds(facts["contacts"] == 0, "no wall is touched", facts)?;
    holds(number(&facts["stats"], "network_restarts") >= 1.0, "restarts are counted", facts)?;
    holds(facts["status"] == 0, "exit status 0", facts)
}

/// While the control process is stopped, and after it is killed, the network process publishes zeros; then it ends.
fn control_process_dies(facts: &Value) -> Result<(), Failed> {
    for state in ["stopped", "killed"] {
        let speed = number(facts, &format!("{state}_speed"));
        holds(speed > 0.1, "on the move", facts)?;
        // 0.3 s of silence; the rest is for busy cores.
        let zero_s = number(facts, &format!("{state}_zero_s"));
        holds(zero_s < 3.0, "zeros arrive", facts)?;
    }
    holds(facts["resumed_s"].is_number(), "the robot continues", facts)?;
    holds(facts["orphans"] == serde_json::json!([]), "no process is left", facts)?;
    holds(facts["contacts"] == 0, "no wall is touched", facts)
}

/// A goal does not arm the robot. A message on `inbye/arm` or a request on the operator's port does, and a stop by either is zero at
/// once and stays.
fn arming(facts: &Value) -> Result<(), Failed> {
    holds(number(facts, "unarmed_commands") > 10.0, "zeros are published", facts)?;
    holds(facts["unarmed_m"] == 0.0, "the robot stands until it is armed", facts)?;
    for means in ["message", "request"] {
        holds(facts[format!("{means}_armed_s")].is_number(), "the robot drives", facts)?;
        // One control period; the rest is for busy cores.
        let stopped_s = number(facts, &format!("{means}_stopped_s"));
        holds(stopped_s < 2.0, "zero is commanded", facts)?;
        let crept_m = number(facts, &format!("{means}_crept_m"));
        holds(crept_m == 0.0, "a new goal does not arm it", facts)?;
    }
    let states = serde_json::json!(["not_armed", "stopped", "stopped", "armed"]);
    holds(facts["states"] == states, "the port answers with the state", facts)?;
    let operators = serde_json::json!(["armed", "not_armed", "stopped"]);
    holds(facts["operators"] == operators, "diagnostics have the state", facts)?;
    let notices = facts["notices"].to_string();
    holds(notices.contains("not armed: the robot stands"), "a notice has the state", facts)?;
    holds(facts["took_s"].is_number(), "the goal is reached", facts)?;
    holds(facts["contacts"] == 0, "no wall is touched", facts)?;
    ends_cleanly(facts)
}

fn ends_cleanly(facts: &Value) -> Result<(), Failed> {
    holds(facts["status"] == 0, "exit status 0", facts)?;
    holds(facts["stats"]["unsent"] == 0, "all was sent", facts)
}

fn number(facts: &Value, name: &str) -> f64 {
    facts[name].as_f64().unwrap_or(f64::NAN)
}

fn holds(is_true: bool, what: impl Display, facts: &Value) -> Result<(), Failed> {
    if is_true {
        return Ok(());
    }
    Err(format!("not true: {what}: {facts:#}").into())
}

/// Runs a scenario and checks its facts.
fn with_peer(scenario: &str, check: Check) -> Result<Completion, Failed> {
    static FOUND: OnceLock<Result<(Command, PathBuf), String>> = OnceLock::new();
    let (alone, python) = match FOUND.get_or_init(find_peer) {
        Ok((alone, python)) => (alone, python),
        Err(why) if required().iter().any(|word| word == "cyclonedds") => {
            return Err(why.as_str().into());
        }
        Err(why) => return Ok(Completion::ignored_with(why.clone())),
    };
    let output = again(alone)
        .arg(python)
        .args([PEER, PROGRAM, scenario])
        .env("VK_DRIVER_FILES", "/nonexistent")
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env_remove("ROS_DOMAIN_ID")
        .stderr(Stdio::piped())
        .output()?;
    let said = String::from_utf8_lossy(&output.stdout);
    let facts = serde_json::from_str(&said).map_err(|_| {
        let errors = String::from_utf8_lossy(&output.stderr);
        format!("no facts: {said}{errors}")
    })?;
    check(&facts).map(|()| Completion::Completed)
}

fn again(command: &Command) -> Command {
    let mut again = Command::new(command.get_program());
    again.args(command.get_args());
    again
}

/// The command that creates a network namespace, and the Python; or the missing part.
fn find_peer() -> Result<(Command, PathBuf), String> {
    let alone = [["-n"].as_slice(), &["-r", "-n"]]
        .into_iter()
        .map(|flags| {
            let mut command = Command::new("unshare");
            command.args(flags).args(["sh", "-c", ALONE, "sh"]);
            command
        })
        .find(|command| runs(again(command).arg("true")))
        .ok_or("no network namespace can be made here: it takes Linux, iproute2, and root or user namespaces")?;
    let candidates = match env::var_os("INBYE_DDS_PYTHON") {
        Some(python) => vec![PathBuf::from(python)],
        None => vec!["python3".into()],
    };
    let python = candidates
        .into_iter()
        .find(|python| runs(Command::new(python).args(["-c", "import cyclonedds, numpy"])))
        .ok_or("no Python with cyclonedds and numpy was found; INBYE_DDS_PYTHON names one")?;
    Ok((alone, python))
}

fn runs(command: &mut Command) -> bool {
    let ended = command.stdout(Stdio::null()).stderr(Stdio::null()).status();
    ended.is_ok_and(|status| status.success())
}
