//! The control process: the navigator, and the link to the network process.

use std::path::Path;
use std::process::Command;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::Duration;

use anyhow::bail;
use inbye::ros::msg::TwistStamped;
use inbye::ros::node::dds::DdsSettings;
use inbye::ros::node::network::{LinkEvents, NetworkLink, ToNetwork};
use inbye::ros::node::{IncomingMessage, NodeCore, NodeNames, NodeSettings, Outgoing};
use inbye::runtime::PoseSource;
use serde_json::json;

use super::network_process::{dds_settings, now};
use super::{NameArguments, NodeArguments, OperatorArguments};
use crate::cli::machine::{interrupt_flag, wall_clock};
use crate::cli::{config, invocation, operator, output};

/// Interval at which the node takes messages.
const POLL_INTERVAL: Duration = Duration::from_millis(4);
/// Time for the network process to publish the last zeros and to end, seconds.
const END_S: f64 = 2.0;
/// Time for a network process that is being started again when the node ends, seconds.
const RECOVER_S: f64 = 3.0;

/// Runs the node until Ctrl-C.
pub fn run(arguments: &NodeArguments) -> anyhow::Result<bool> {
    let config = config::load("--config", arguments.config.as_deref())?;
    NodeCore::check(&config)
        .map_err(|error| config::in_file(&error, arguments.config.as_deref()))?;
    if arguments.odom_is_map && config.pose_source == PoseSource::Scans {
        bail!(
            "--odom-is-map: the settings have pose_source = \"scans\", by which the node measures the odometry's pose in the map: \
             leave one of the two out"
        );
    }
    let settings = dds_settings(arguments)?;
    let engine = arguments.engine.open(&config, false)?;
    let stop = interrupt_flag()?;
    let mut clock = wall_clock();
    let mut link = NetworkLink::new(new_command(arguments, config.node.network_memory_mib));
    let first_messages = start(&mut link, &mut clock)?;
    let node_settings = NodeSettings {
        config,
        odom_is_map: arguments.odom_is_map,
        is_managed: arguments.lifecycle.managed,
        names: settings.names.clone(),
    };
    let mut core = NodeCore::new(node_settings, engine)?;
    // Among them may be the map and the static transforms, which are sent once.
    receive_messages(&mut core, &first_messages);
    let DdsSettings { names, domain, .. } = &settings;
    output::note(format!("node {} in domain {domain}", names.full_node()));
    let OperatorArguments { arm, operator_port } = arguments.operator;
    operator::serve(core.operator(), arm, operator_port)?;
    let mut due_s = 0.0;
    while !stop.load(Ordering::Relaxed) {
        let now_s = clock();
        if arguments.for_s.is_some_and(|for_s| now_s >= for_s) || core.has_ended() {
            break;
        }
        receive(&mut core, link.poll(now_s));
        if now_s >= due_s {
            due_s += core.period_s();
            if due_s <= now_s {
                // Missed ticks are skipped.
                due_s = now_s + core.period_s();
            }
            let outgoing = core.tick(now().seconds(), &mut clock);
            publish(&mut link, outgoing, core.base_frame());
        }
        thread::sleep(POLL_INTERVAL);
    }
    stop_robot(&mut core, &mut link, &mut clock);
    report(&core, &link, names)?;
    Ok(true)
}

/// The command that starts the network process.
fn new_command(arguments: &NodeArguments, memory_mib: u32) -> Box<dyn FnMut() -> Command> {
    // The link to the running program stays valid when its file is replaced.
    let running = Path::new("/proc/self/exe");
    let is_linked = invocation::is_own_file() && running.exists();
    let mut options = vec!["--network-memory-mib".to_owned(), memory_mib.to_string()];
    let NameArguments { namespace, remap, .. } = &arguments.names;
    if !namespace.is_empty() {
        options.extend(["--namespace".to_owned(), namespace.clone()]);
    }
    options.extend(remap.iter().flat_map(|rule| ["--remap".to_owned(), rule.clone()]));
    if arguments.lifecycle.managed {
        options.push("--managed".to_owned());
    }
    if arguments.stamped {
        options.push("--stamped".to_owned());
    }
    Box::new(move || {
        let mut command = if is_linked { Command::new(running) } else { invocation::program() };
        command.arg("node").args(&options);
        // Out of memory, a backtrace takes seconds before the restart.
        command.env("RUST_BACKTRACE", "0");
        // Ctrl-C in a terminal must not reach the process that publishes the last zeros.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        command
    })
}

/// Waits for the network process and returns the messages that it passed on so far. What keeps it from starting the first time
/// is an error.
fn start(
    link: &mut NetworkLink,
    clock: &mut dyn FnMut() -> f64,
) -> anyhow::Result<Vec<IncomingMessage>> {
    loop {
        let events = link.poll(clock());
        if events.is_lost {
            match link.failure() {
                Some(reason) => bail!("{reason}"),
                None => bail!("{}", events.notices.join("; ")),
            }
        }
        if events.is_up {
            return Ok(events.messages);
        }
        thread::sleep(POLL_INTERVAL);
    }
}

fn receive(core: &mut NodeCore, events: LinkEvents) {
    let LinkEvents { messages, is_lost, is_up, notices, .. } = events;
    receive_messages(core, &messages);
    if is_lost {
        core.transport_lost();
    }
    if is_up {
        core.transport_restored(now().seconds());
        output::note("the network process is up again");
    }
    notices.into_iter().for_each(output::note);
}

fn receive_messages(core: &mut NodeCore, messages: &[IncomingMessage]) {
    let now_s = now().seconds();
    for message in messages {
        core.receive(now_s, message);
    }
}

fn publish(link: &mut NetworkLink, outgoing: Outgoing, base_frame: &str) {
    let Outgoing {
        command,
        path,
        markers,
        transforms,
        updated_map,
        diagnostics,
        action,
        states,
        notices,
        ..
    } = outgoing;
    notices.into_iter().for_each(output::note);
    // What a network process that is down does not take is counted; it gets the last path and map when it is up again.
    link.send(match command {
        Some(command) => ToNetwork::Command(TwistStamped::new(&command, now(), base_frame)),
        None => ToNetwork::Alive,
    });
    let others = [
        transforms.map(ToNetwork::Transforms),
        path.map(ToNetwork::Path),
        markers.map(ToNetwork::Markers),
        diagnostics.map(ToNetwork::Diagnostics),
        updated_map.map(ToNetwork::UpdatedMap),
    ];
    let others = others
        .into_iter()
        .flatten()
        .chain(action.into_iter().map(ToNetwork::Action))
        .chain(states.into_iter().map(ToNetwork::State));
    others.for_each(|frame| link.send(frame));
}

/// Publishes the last zeros and the end of the goal. If the network process is down, it is started for them.
fn stop_robot(core: &mut NodeCore, link: &mut NetworkLink, clock: &mut dyn FnMut() -> f64) {
    if core.final_command().is_some() {
        let until_s = clock() + RECOVER_S;
        while !link.is_up() && clock() < until_s {
            receive(core, link.poll(clock()));
            thread::sleep(POLL_INTERVAL);
        }
    }
    publish(link, core.shut_down(now().seconds()), core.base_frame());
    let until_s = clock() + END_S;
    while !link.close() && clock() < until_s {
        thread::sleep(POLL_INTERVAL);
    }
}

fn report(core: &NodeCore, link: &NetworkLink, names: &NodeNames) -> anyhow::Result<()> {
    let (stats, network) = (core.stats(), link.stats());
    let mut object = json!(stats);
    object["unsent"] = json!(network.unsent);
    object["network_restarts"] = json!(network.network_restarts);
    let (goals, reached, aborted) = (stats.goals, stats.reached, stats.aborted);
    let (commands, late_ticks) = (stats.commands, stats.late_ticks);
    let unsent = network.unsent;
    let mut lines = vec![format!(
        "{goals} goals, {reached} reached, {aborted} aborted; {commands} commands, {late_ticks} ticks late, \
         {unsent} not sent"
    )];
    if network.network_restarts > 0 {
        lines.push(format!("the network process was restarted {} times", network.network_restarts));
    }
    let counters = [
        ("received", &stats.received),
        ("rejected", &stats.rejected),
        ("protection", &stats.protective_actions),
    ];
    for (what, counts) in counters {
        let counts = counts.iter().map(|(topic, count)| format!("{} {count}", names.shown(topic)));
        let counts: Vec<String> = counts.collect();
        if !counts.is_empty() {
            lines.push(format!("{what:<12} {}", counts.join(", ")));
        }
    }
    let delays = stats.least_delay_s.iter();
    let delays: Vec<String> =
        delays.map(|(topic, delay_s)| format!("{} {delay_s:.3} s", names.shown(topic))).collect();
    if !delays.is_empty() {
        lines.push(format!("{:<12} {}", "least delay", delays.join(", ")));
    }
    output::result(&object, lines)
}
