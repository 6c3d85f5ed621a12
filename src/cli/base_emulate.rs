//! `inbye base emulate`.

use super::base_arguments::EmulateArguments;

#[cfg(all(unix, feature = "serial"))]
pub use on_pseudo_terminal::run;

/// There is nothing to be a base on.
#[cfg(not(all(unix, feature = "serial")))]
pub fn run(_: &EmulateArguments, _: bool) -> anyhow::Result<bool> {
    anyhow::bail!(
        "base emulate needs pseudo-terminals: run it on a Unix, in a program built with its feature `serial`"
    )
}

#[cfg(all(unix, feature = "serial"))]
mod on_pseudo_terminal {
    use std::io::{ErrorKind, Read, Write};
    use std::sync::atomic::Ordering;
    use std::time::{Duration, Instant};

    use anyhow::Context;
    use inbye::base::Emulator;
    use inbye::geometry::Pose;
    use inbye::map::UnknownPolicy;
    use inbye::sim::{Lidar, RotatingLidar, World};
    use serde_json::json;
    use serialport::{ClearBuffer, SerialPort, TTYPort};

    use super::EmulateArguments;
    use crate::cli::{interrupt, map_file, output, settings_file};

    /// Longest time from one turn of the controller to the next. Bytes that come begin one at once.
    const TURN: Duration = Duration::from_millis(4);

    /// How long a byte waits for room. Where there is none nobody reads.
    const ROOM: Duration = Duration::from_millis(1);

    /// Is a base until the time is over or a signal comes.
    pub fn run(arguments: &EmulateArguments, json: bool) -> anyhow::Result<bool> {
        let kind = &arguments.kind;
        let settings = settings_file::read_base(kind.base_config.as_deref())?.base;
        let mut emulator = Emulator::new(kind.protocol, settings, arguments.seed)?;
        for trouble in &arguments.fault {
            emulator.schedule(*trouble);
        }
        let mut lidar = lidar(arguments)?;
        let end = interrupt::flag()?;
        let mut pair = Pair::open()?;
        let lidar_port = lidar.as_ref().map(|lidar| lidar.name().to_owned());
        if json {
            let mut ports = json!({ "port": pair.name, "protocol": kind.protocol.name() });
            if let Some(lidar_port) = &lidar_port {
                ports["lidar"] = json!(lidar_port);
            }
            output::json(&ports)?;
        } else {
            output::line(&pair.name);
            lidar_port.iter().for_each(output::line);
            output::note(format!("speaks {}; Ctrl-C ends it", kind.protocol));
        }
        let began = Instant::now();
        let (mut bytes, mut line) = ([0; 512], Vec::new());
        let time_s = loop {
            let now_s = began.elapsed().as_secs_f64();
            let over = arguments.for_s.is_some_and(|for_s| now_s >= for_s);
            if over || end.load(Ordering::Relaxed) {
                break now_s;
            }
            let count = pair.read(&mut bytes)?;
            let now_s = began.elapsed().as_secs_f64();
            emulator.receive(&bytes[..count], now_s);
            line.clear();
            emulator.step(now_s, &mut line);
            pair.write(&line)?;
            if let Some(lidar) = &mut lidar {
                lidar.step(now_s, emulator.pose())?;
            }
        };
        let place = lidar.map(|lidar| lidar.place(emulator.pose()));
        print(&emulator, place, time_s, json)?;
        Ok(true)
    }

    /// The lidar of a whole robot, if it shall be one.
    fn lidar(arguments: &EmulateArguments) -> anyhow::Result<Option<EmulatedLidar>> {
        let Some(file) = &arguments.lidar_map else {
            return Ok(None);
        };
        let map = map_file::load(file, arguments.resolution)?;
        let start = arguments.start.as_ref();
        let start = start.context("--lidar-map needs --start: say where on it the robot stands")?;
        let world = World::new(map.obstacles(UnknownPolicy::Blocked));
        let lidar = RotatingLidar::new(Lidar::default(), world, arguments.seed)?;
        Ok(Some(EmulatedLidar {
            lidar,
            start: start.pose(),
            pair: Some(Pair::open()?),
            until_s: arguments.lidar_until.unwrap_or(f64::INFINITY),
            line: Vec::new(),
        }))
    }

    /// An LD19 on the emulated base, and its line.
    struct EmulatedLidar {
        lidar: RotatingLidar,
        start: Pose,
        /// None after it was unplugged.
        pair: Option<Pair>,
        until_s: f64,
        line: Vec<u8>,
    }

    impl EmulatedLidar {
        fn name(&self) -> &str {
            self.pair.as_ref().map_or("", |pair| &pair.name)
        }

        /// Where the base is on the map that has come to a pose of its own.
        fn place(&self, own: &Pose) -> Pose {
            self.start.transform_pose(own)
        }

        fn step(&mut self, now_s: f64, own: &Pose) -> anyhow::Result<()> {
            let place = self.place(own);
            self.line.clear();
            self.lidar.step(now_s, &place, &mut self.line);
            if now_s >= self.until_s {
                self.pair = None;
            }
            if let Some(pair) = &mut self.pair {
                pair.admit_hosts();
                pair.write(&self.line)?;
            }
            Ok(())
        }
    }

    /// Both ends: ours, and the host's, which is held open so that hosts may come and go.
    struct Pair {
        ours: TTYPort,
        hosts: TTYPort,
        name: String,
    }

    impl Pair {
        fn open() -> anyhow::Result<Self> {
            let (ours, hosts) = TTYPort::pair().context("no pseudo-terminal can be opened")?;
            let name = hosts.name().context("the pseudo-terminal has no name")?;
            Ok(Self { ours, hosts, name })
        }

        fn read(&mut self, bytes: &mut [u8]) -> anyhow::Result<usize> {
            self.ours.set_timeout(TURN)?;
            match self.ours.read(bytes) {
                Err(error) if is_silence(error.kind()) => {
                    self.admit_hosts();
                    Ok(0)
                }
                read => read.context("the pseudo-terminal"),
            }
        }

        /// Takes back the claim that a host which was killed has left on the line: it would keep all others out until both ends
        /// are closed. A port does so when it is dropped, and a copy of ours is a port; a living host has a lock as well.
        fn admit_hosts(&self) {
            drop(self.hosts.try_clone_native());
        }

        /// One byte at a time, since there may be room for one only. Where nobody reads, what lies there is old by now.
        fn write(&mut self, bytes: &[u8]) -> anyhow::Result<()> {
            self.ours.set_timeout(ROOM)?;
            for byte in bytes {
                match self.ours.write(&[*byte]) {
                    Err(error) if is_silence(error.kind()) => {
                        return Ok(self.hosts.clear(ClearBuffer::Input)?);
                    }
                    written => written.context("the pseudo-terminal")?,
                };
            }
            Ok(())
        }
    }

    fn is_silence(kind: ErrorKind) -> bool {
        matches!(
            kind,
            ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
        )
    }

    fn print(
        emulator: &Emulator,
        place: Option<Pose>,
        time_s: f64,
        json: bool,
    ) -> anyhow::Result<()> {
        let (orders, twist) = (emulator.command_stats(), emulator.twist());
        let distance_m = emulator.travelled_m();
        if json {
            return output::json(&json!({
                "time_s": time_s,
                "frames": orders.commands,
                "final_zero_commands": orders.final_zero_commands,
                "watchdog_stops": orders.watchdog_stops,
                "distance_m": distance_m,
                "pose": emulator.pose(),
                "place": place,
                "linear": twist.linear,
                "angular": twist.angular,
            }));
        }
        output::line(format!(
            "{time_s:.1} s, {} commands, the last {} to stand; {} stops by the watchdog; {distance_m:.2} m",
            orders.commands, orders.final_zero_commands, orders.watchdog_stops,
        ));
        Ok(())
    }
}
