//! `inbye base emulate`.

use super::base::EmulateArguments;

#[cfg(all(unix, feature = "serial"))]
pub use on_pseudo_terminal::run;

/// Fails: there are no pseudo-terminals.
#[cfg(not(all(unix, feature = "serial")))]
pub fn run(_: &EmulateArguments, _: bool) -> anyhow::Result<bool> {
    anyhow::bail!(
        "base emulate needs pseudo-terminals: run it on Unix, in a program built with its feature `serial`"
    )
}

#[cfg(all(unix, feature = "serial"))]
mod on_pseudo_terminal {
    use std::io::{ErrorKind, Read, Write};
    use std::sync::atomic::Ordering;
    use std::time::{Duration, Instant};

    use anyhow::Context;
    use inbye::base::{Emulator, InjectedFault, LidarFaultInjector};
    use inbye::geometry::Pose;
    use inbye::map::UnknownPolicy;
    use inbye::runtime::Config;
    use inbye::sim::{Lidar, RotatingLidar, World};
    use serde_json::json;
    use serialport::{ClearBuffer, SerialPort, TTYPort};

    use super::EmulateArguments;
    use crate::cli::{config, machine, map_file, output};

    /// Longest cycle of the controller. Received bytes start the next cycle at once.
    const CYCLE: Duration = Duration::from_millis(4);

    /// Write timeout of a byte. After it no host reads.
    const WRITE_TIMEOUT: Duration = Duration::from_millis(1);

    /// Speed and turn rate below which the base stands, m/s and rad/s.
    const STANDING: f64 = 0.02;

    /// Emulates a base until the time is over or a signal arrives.
    pub fn run(arguments: &EmulateArguments, json: bool) -> anyhow::Result<bool> {
        let kind = &arguments.kind;
        let settings = config::load_base("--base-config", kind.base_config.as_deref())?.base;
        let emulator = Emulator::new(kind.protocol, settings, arguments.seed)?;
        let mut emulator = emulator.with_motor_lag(arguments.motor_lag);
        for fault in &arguments.fault {
            emulator.schedule(*fault);
        }
        let mut lidar = open_lidar(arguments)?;
        let end = machine::interrupt_flag()?;
        let mut pair = Some(Pair::open()?);
        let port = pair.as_ref().map_or_else(String::new, |pair| pair.name.clone());
        // Bytes that hosts write to the device that has replaced the base.
        let mut replaced_bytes = None;
        let lidar_port = lidar.as_ref().map(|lidar| lidar.name().to_owned());
        if json {
            let mut ports = json!({ "port": port, "protocol": kind.protocol.name() });
            if let Some(lidar_port) = &lidar_port {
                ports["lidar"] = json!(lidar_port);
            }
            output::json(&ports)?;
        } else {
            output::line(&port);
            lidar_port.iter().for_each(output::line);
            output::note(format!("speaks {}; Ctrl-C ends it", kind.protocol));
        }
        let footprint = Config::default().robot.footprint;
        let (mut last_motion_s, mut min_gap_m) = (0.0, f64::INFINITY);
        let started = Instant::now();
        let (mut bytes, mut line) = ([0; 512], Vec::new());
        let time_s = loop {
            let now_s = started.elapsed().as_secs_f64();
            let over = arguments.for_s.is_some_and(|for_s| now_s >= for_s);
            if over || end.load(Ordering::Relaxed) {
                break now_s;
            }
            if replaced_bytes.is_none() && emulator.has(InjectedFault::PortReplaced, now_s) {
                // The system gives the lowest free number, so usually the same name.
                drop(pair.take());
                replaced_bytes = Some(0);
            }
            let pair = match &mut pair {
                Some(pair) => pair,
                none => none.insert(Pair::open()?),
            };
            let count = pair.read(&mut bytes)?;
            let now_s = started.elapsed().as_secs_f64();
            line.clear();
            if let Some(replaced_bytes) = &mut replaced_bytes {
                *replaced_bytes += count;
                emulator.step(now_s, &mut line);
            } else {
                emulator.receive(&bytes[..count], now_s);
                emulator.step(now_s, &mut line);
                pair.write(&line)?;
            }
            let twist = emulator.twist();
            if twist.linear.abs() >= STANDING || twist.angular.abs() >= STANDING {
                last_motion_s = now_s;
            }
            if let Some(lidar) = &mut lidar {
                lidar.step(now_s, emulator.pose())?;
                let pose = lidar.map_pose(emulator.pose());
                min_gap_m = lidar.world.gap_m(&footprint, &pose).min(min_gap_m);
            }
        };
        let min_gap_m = lidar.is_some().then_some(min_gap_m);
        let map_pose = lidar.map(|lidar| lidar.map_pose(emulator.pose()));
        print(&emulator, (map_pose, min_gap_m), replaced_bytes, (time_s, last_motion_s), json)?;
        Ok(true)
    }

    /// Opens the emulated lidar, if requested.
    fn open_lidar(arguments: &EmulateArguments) -> anyhow::Result<Option<EmulatedLidar>> {
        let Some(file) = &arguments.lidar_map else {
            return Ok(None);
        };
        let map = map_file::load(file, arguments.resolution)?;
        let start = arguments.start.as_ref();
        let start = start.context("--lidar-map needs --start: give the robot's pose on the map")?;
        let world = World::new(map.obstacles(UnknownPolicy::Blocked));
        let lidar = RotatingLidar::new(Lidar::turning(), world.clone(), arguments.seed)?;
        Ok(Some(EmulatedLidar {
            lidar,
            world,
            start: start.pose(),
            pair: Some(Pair::open()?),
            faults: LidarFaultInjector::new(&arguments.fault),
            until_s: arguments.lidar_until.unwrap_or(f64::INFINITY),
            line: Vec::new(),
        }))
    }

    /// An LD19 on the emulated base, with its port.
    struct EmulatedLidar {
        lidar: RotatingLidar,
        world: World,
        start: Pose,
        /// None after the lidar was unplugged.
        pair: Option<Pair>,
        faults: LidarFaultInjector,
        until_s: f64,
        line: Vec<u8>,
    }

    impl EmulatedLidar {
        fn name(&self) -> &str {
            self.pair.as_ref().map_or("", |pair| &pair.name)
        }

        /// The pose on the map; `pose` is relative to the start.
        fn map_pose(&self, pose: &Pose) -> Pose {
            self.start.transform_pose(pose)
        }

        fn step(&mut self, now_s: f64, pose: &Pose) -> anyhow::Result<()> {
            let map_pose = self.map_pose(pose);
            self.line.clear();
            self.lidar.step(now_s, &map_pose, &mut self.line);
            self.faults.apply(now_s, &mut self.line);
            if now_s >= self.until_s {
                self.pair = None;
            }
            if let Some(pair) = &mut self.pair {
                pair.release_exclusive_lock();
                pair.write(&self.line)?;
            }
            Ok(())
        }
    }

    /// Both ends of a pseudo-terminal. The host's end stays open so that hosts can reconnect.
    struct Pair {
        device: TTYPort,
        host: TTYPort,
        name: String,
    }

    impl Pair {
        fn open() -> anyhow::Result<Self> {
            let (device, host) = TTYPort::pair().context("cannot open a pseudo-terminal")?;
            let name = host.name().context("the pseudo-terminal has no name")?;
            Ok(Self { device, host, name })
        }

        fn read(&mut self, bytes: &mut [u8]) -> anyhow::Result<usize> {
            self.device.set_timeout(CYCLE)?;
            match self.device.read(bytes) {
                Err(error) if is_timeout(error.kind()) => {
                    self.release_exclusive_lock();
                    Ok(0)
                }
                read => read.context("the pseudo-terminal"),
            }
        }

        /// Releases the exclusive mode that a killed host left on the terminal: it would exclude all other hosts until both ends
        /// are closed. Dropping a port releases it, so a copy is dropped here; a running host also holds a lock.
        fn release_exclusive_lock(&self) {
            drop(self.host.try_clone_native());
        }

        /// Writes one byte at a time, since there may be space for one only. If no host reads, the buffered bytes are outdated and
        /// are dropped.
        fn write(&mut self, bytes: &[u8]) -> anyhow::Result<()> {
            self.device.set_timeout(WRITE_TIMEOUT)?;
            for byte in bytes {
                match self.device.write(&[*byte]) {
                    Err(error) if is_timeout(error.kind()) => {
                        return Ok(self.host.clear(ClearBuffer::Input)?);
                    }
                    written => written.context("the pseudo-terminal")?,
                };
            }
            Ok(())
        }
    }

    fn is_timeout(kind: ErrorKind) -> bool {
        matches!(kind, ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted)
    }

    fn print(
        emulator: &Emulator,
        (map_pose, min_gap_m): (Option<Pose>, Option<f64>),
        replaced_bytes: Option<usize>,
        (time_s, last_motion_s): (f64, f64),
        json: bool,
    ) -> anyhow::Result<()> {
        let (stats, twist) = (emulator.command_stats(), emulator.twist());
        let travelled_m = emulator.travelled_m();
        let object = json!({
            "time_s": time_s,
            "commands": stats.commands,
            "final_zero_commands": stats.final_zero_commands,
            "watchdog_stops": stats.watchdog_stops,
            "zero_commands_after_watchdog": stats.zero_commands_after_watchdog,
            "bytes_after_replacement": replaced_bytes,
            "travelled_m": travelled_m,
            "pose": emulator.pose(),
            "map_pose": map_pose,
            "last_motion_s": last_motion_s,
            "min_gap_m": min_gap_m,
            "linear": twist.linear,
            "angular": twist.angular,
        });
        let summary = format!(
            "{time_s:.1} s, {} commands, the last {} zero; {} watchdog stops; {travelled_m:.2} m",
            stats.commands, stats.final_zero_commands, stats.watchdog_stops,
        );
        output::result(json, &object, [summary])
    }
}
