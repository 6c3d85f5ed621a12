//! `inbye node`.

use super::node_arguments::NodeArguments;

/// Without the feature there is no wire.
#[cfg(not(feature = "ros2"))]
pub fn run(_arguments: &NodeArguments, _json: bool) -> anyhow::Result<bool> {
    anyhow::bail!(
        "inbye node: this program was built without ROS 2: build it with `cargo build --release --features ros2`"
    )
}

#[cfg(feature = "ros2")]
pub use wired::run;

#[cfg(feature = "ros2")]
mod wired {
    use std::env::{self, VarError};
    use std::sync::atomic::Ordering;
    use std::thread;
    use std::time::{Duration, SystemTime, UNIX_EPOCH};

    use anyhow::{Context, anyhow};
    use inbye::ros::msg::Time;
    use inbye::ros::node::dds::{WireSettings, Wires};
    use inbye::ros::node::{NodeCore, NodeSettings, Published};
    use serde_json::json;

    use super::super::clock::wall_clock;
    use super::super::{engines, interrupt, output, settings_file};
    use super::NodeArguments;

    /// From one look for messages to the next.
    const LOOK_EVERY: Duration = Duration::from_millis(4);
    /// At the end a zero is sent so many times, with a pause for the wires: who listens must get one.
    const ZEROS: u32 = 5;
    const BETWEEN_ZEROS: Duration = Duration::from_millis(50);
    /// The highest domain that has ports of its own.
    const LAST_DOMAIN: u16 = 232;

    /// Runs the node until Ctrl-C.
    pub fn run(arguments: &NodeArguments, json: bool) -> anyhow::Result<bool> {
        let config = settings_file::read(arguments.config.as_deref())?;
        let settings = WireSettings {
            namespace: arguments.namespace.clone(),
            domain: domain()?,
            localhost_only: is_localhost_only(),
            stamped: arguments.stamped,
        };
        let engine = engines::choose_to_drive(&arguments.engine, arguments.threads, false)?;
        let stop = interrupt::flag()?;
        let mut wires = Wires::open(&settings)?;
        let mut core = NodeCore::new(
            NodeSettings {
                config,
                odom_is_map: arguments.odom_is_map,
            },
            engine,
        );
        let namespace = &settings.namespace;
        let domain = settings.domain;
        output::note(format!("node {namespace}/inbye in domain {domain}"));
        let mut clock = wall_clock();
        let (mut due_s, mut late) = (0.0, 0_u64);
        while !stop.load(Ordering::Relaxed) {
            let now_s = clock();
            if arguments.for_s.is_some_and(|for_s| now_s >= for_s) {
                break;
            }
            for message in wires.arrived() {
                core.hear(now_s, &message);
            }
            if now_s >= due_s {
                due_s += core.period_s();
                if due_s <= now_s {
                    // Missed ticks are not made up for.
                    late += 1;
                    due_s = now_s + core.period_s();
                }
                let stamp = now();
                let mut published = core.tick(now_s, stamp, &mut clock);
                for note in std::mem::take(&mut published.notes) {
                    output::note(note);
                }
                wires.publish(published, stamp, core.base_frame());
            }
            thread::sleep(LOOK_EVERY);
        }
        farewell(&core, &mut wires);
        report(&core, &wires, late, json)?;
        Ok(true)
    }

    fn farewell(core: &NodeCore, wires: &mut Wires) {
        let Some(zero) = core.farewell() else {
            return;
        };
        for _ in 0..ZEROS {
            let last = Published {
                command: Some(zero),
                ..Published::default()
            };
            wires.publish(last, now(), core.base_frame());
            thread::sleep(BETWEEN_ZEROS);
        }
    }

    fn report(core: &NodeCore, wires: &Wires, late: u64, json: bool) -> anyhow::Result<()> {
        let tally = core.tally();
        if json {
            let mut object = json!(tally);
            object["unsent"] = json!(wires.unsent());
            object["late_ticks"] = json!(late);
            return output::json(&object);
        }
        output::line(format!(
            "{} goals, {} reached, {} given up; {} commands, {late} ticks late, {} not sent",
            tally.goals,
            tally.reached,
            tally.given_up,
            tally.commands,
            wires.unsent(),
        ));
        for (what, counts) in [("received", &tally.received), ("refused", &tally.refused)] {
            let each = counts
                .iter()
                .map(|(topic, count)| format!("{topic} {count}"));
            let each: Vec<String> = each.collect();
            if !each.is_empty() {
                output::line(format!("{what:<12} {}", each.join(", ")));
            }
        }
        Ok(())
    }

    /// The time by the wall clock, for stamps.
    fn now() -> Time {
        let since = SystemTime::now().duration_since(UNIX_EPOCH);
        since.map_or_else(
            |_| Time::default(),
            |since| Time {
                sec: i32::try_from(since.as_secs()).unwrap_or(i32::MAX),
                nanosec: since.subsec_nanos(),
            },
        )
    }

    fn domain() -> anyhow::Result<u16> {
        let name = "ROS_DOMAIN_ID";
        match env::var(name) {
            Err(VarError::NotPresent) => Ok(0),
            Err(error) => Err(error).context(name),
            Ok(text) if text.is_empty() => Ok(0),
            Ok(text) => {
                let number = text.parse().ok().filter(|domain| *domain <= LAST_DOMAIN);
                number.ok_or_else(|| {
                    anyhow!("{name} is `{text}`: it must be a whole number, 0 to {LAST_DOMAIN}")
                })
            }
        }
    }

    fn is_localhost_only() -> bool {
        let is = |name: &str, value: &str| env::var(name).is_ok_and(|found| found == value);
        is("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST") || is("ROS_LOCALHOST_ONLY", "1")
    }
}
