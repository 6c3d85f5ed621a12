//! `inbye node`.

use std::path::PathBuf;

use clap::Args;

use super::arguments::{EngineArguments, duration};

/// `inbye node`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  inbye node --config robot.toml --namespace /rover --for 60\n\n\
    Subscriptions, with the names and types of ROS 2: map (OccupancyGrid, latched), scan (LaserScan), odom (Odometry), goal_pose \
    (PoseStamped, in the map's frame), tf and tf_static. Publications: cmd_vel (Twist, or TwistStamped with --stamped), plan \
    (Path, latched), local_markers (MarkerArray). All names are within the namespace, tf too.\n\
    The robot's pose is the odometry's pose, transformed to the map's frame by tf. With --odom-is-map, or if both frames have the \
    same name, it needs no tf. The lidar's pose on the robot comes from tf; without it, the lidar is at the origin. The stamps of \
    scan and odometry compensate the motion during a scan.\n\
    Without a goal the node publishes nothing. With a goal it publishes a velocity at each control_period_s. The robot brakes to \
    zero while map, scan, odometry or transform are missing or older than scan_timeout_s, and continues afterwards. The node \
    aborts the goal if scans are missing for longer than sensor_fault_patience_s. On a new goal or a new map the robot stops before it \
    plans. An orientation of four zeros leaves the goal's yaw free. After a goal, and at its end, the node publishes zero for a \
    second.\n\
    ROS_DOMAIN_ID selects the domain. ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST, or ROS_LOCALHOST_ONLY=1, restricts discovery to \
    this machine. The program must be built with `--features ros2`; it needs no ROS installation."
)]
pub struct NodeArguments {
    /// Settings, TOML: those of `inbye drive`.
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// Namespace of node and topics, such as /rover [default: none].
    #[arg(long, value_name = "NS", default_value = "", hide_default_value = true)]
    pub namespace: String,
    #[command(flatten)]
    pub engine: EngineArguments,
    /// Publish `cmd_vel` as `TwistStamped`, which newer releases of Nav2 and `ros2_control` expect.
    #[arg(long, conflicts_with = "unstamped")]
    pub stamped: bool,
    /// Publish `cmd_vel` as `Twist`: the default.
    #[arg(long)]
    pub unstamped: bool,
    /// Treat the odometry frame as the map frame.
    #[arg(long)]
    pub odom_is_map: bool,
    /// Duration of the run, seconds [default: until Ctrl-C].
    #[arg(long = "for", value_name = "S", allow_negative_numbers = true, value_parser = duration)]
    pub for_s: Option<f64>,
}

#[cfg(not(feature = "ros2"))]
pub fn run(_arguments: &NodeArguments, _json: bool) -> anyhow::Result<bool> {
    anyhow::bail!(
        "inbye node: this program was built without ROS 2: build it with `cargo build --release --features ros2`"
    )
}

#[cfg(feature = "ros2")]
pub use dds::run;

#[cfg(feature = "ros2")]
mod dds {
    use std::env::{self, VarError};
    use std::sync::atomic::Ordering;
    use std::thread;
    use std::time::{Duration, SystemTime, UNIX_EPOCH};

    use anyhow::{Context, anyhow};
    use inbye::ros::msg::Time;
    use inbye::ros::node::dds::{DdsNode, DdsSettings};
    use inbye::ros::node::{NodeCore, NodeSettings, Outgoing};
    use serde_json::json;

    use super::NodeArguments;
    use crate::cli::machine::{interrupt_flag, wall_clock};
    use crate::cli::{config, output};

    /// Interval at which the node takes messages.
    const POLL_INTERVAL: Duration = Duration::from_millis(4);
    /// Zero velocities at the end, with a pause after each: DDS sends them in the background.
    const STOP_REPEATS: u32 = 5;
    const STOP_INTERVAL: Duration = Duration::from_millis(50);
    /// The highest domain with ports of its own.
    const MAX_DOMAIN: u16 = 232;

    /// Runs the node until Ctrl-C.
    pub fn run(arguments: &NodeArguments, json: bool) -> anyhow::Result<bool> {
        let config = config::load("--config", arguments.config.as_deref())?;
        let mut settings = DdsSettings::default();
        settings.namespace.clone_from(&arguments.namespace);
        settings.domain = domain()?;
        settings.localhost_only = is_localhost_only();
        settings.stamped = arguments.stamped;
        let engine = arguments.engine.open(false)?;
        let stop = interrupt_flag()?;
        let mut dds = DdsNode::open(&settings)?;
        let mut node_settings = NodeSettings::default();
        node_settings.config = config;
        node_settings.odom_is_map = arguments.odom_is_map;
        let mut core = NodeCore::new(node_settings, engine);
        let DdsSettings { namespace, domain, .. } = &settings;
        output::note(format!("node {namespace}/inbye in domain {domain}"));
        let mut clock = wall_clock();
        let (mut due_s, mut late_ticks) = (0.0, 0_u64);
        while !stop.load(Ordering::Relaxed) {
            let now_s = clock();
            if arguments.for_s.is_some_and(|for_s| now_s >= for_s) {
                break;
            }
            for message in dds.receive() {
                core.receive(now_s, &message);
            }
            if now_s >= due_s {
                due_s += core.period_s();
                if due_s <= now_s {
                    // Missed ticks are skipped.
                    late_ticks += 1;
                    due_s = now_s + core.period_s();
                }
                let stamp = now();
                let mut outgoing = core.tick(now_s, stamp, &mut clock);
                for notice in std::mem::take(&mut outgoing.notices) {
                    output::note(notice);
                }
                dds.publish(outgoing, stamp, core.base_frame());
            }
            thread::sleep(POLL_INTERVAL);
        }
        stop_robot(&core, &mut dds);
        report(&core, dds.unsent(), late_ticks, json)?;
        Ok(true)
    }

    fn stop_robot(core: &NodeCore, dds: &mut DdsNode) {
        let Some(zero) = core.final_command() else {
            return;
        };
        for _ in 0..STOP_REPEATS {
            let mut outgoing = Outgoing::default();
            outgoing.command = Some(zero);
            dds.publish(outgoing, now(), core.base_frame());
            thread::sleep(STOP_INTERVAL);
        }
    }

    fn report(core: &NodeCore, unsent: u64, late_ticks: u64, json: bool) -> anyhow::Result<()> {
        let stats = core.stats();
        let mut object = json!(stats);
        object["unsent"] = json!(unsent);
        object["late_ticks"] = json!(late_ticks);
        let (goals, reached, aborted) = (stats.goals, stats.reached, stats.aborted);
        let commands = stats.commands;
        let mut lines = vec![format!(
            "{goals} goals, {reached} reached, {aborted} aborted; {commands} commands, {late_ticks} ticks late, \
             {unsent} not sent"
        )];
        for (what, counts) in [("received", &stats.received), ("rejected", &stats.rejected)] {
            let counts = counts.iter().map(|(topic, count)| format!("{topic} {count}"));
            let counts: Vec<String> = counts.collect();
            if !counts.is_empty() {
                lines.push(format!("{what:<12} {}", counts.join(", ")));
            }
        }
        output::result(json, &object, lines)
    }

    /// The time by the wall clock.
    fn now() -> Time {
        let since = SystemTime::now().duration_since(UNIX_EPOCH);
        let since = since.unwrap_or_default();
        let sec = i32::try_from(since.as_secs()).unwrap_or(i32::MAX);
        Time { sec, nanosec: since.subsec_nanos() }
    }

    fn domain() -> anyhow::Result<u16> {
        let name = "ROS_DOMAIN_ID";
        match env::var(name) {
            Err(VarError::NotPresent) => Ok(0),
            Err(error) => Err(error).context(name),
            Ok(text) if text.is_empty() => Ok(0),
            Ok(text) => {
                let number = text.parse().ok().filter(|domain| *domain <= MAX_DOMAIN);
                number.ok_or_else(|| {
                    anyhow!("{name} is `{text}`: it must be a whole number, 0 to {MAX_DOMAIN}")
                })
            }
        }
    }

    fn is_localhost_only() -> bool {
        let is = |name: &str, value: &str| env::var(name).is_ok_and(|found| found == value);
        is("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST") || is("ROS_LOCALHOST_ONLY", "1")
    }
}
