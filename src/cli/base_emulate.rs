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
    use std::sync::atomic::Ordering;
    use std::time::Instant;

    use inbye::base::{BaseSettings, Emulator, InjectedFault};
    use inbye::geometry::Twist;
    use serde_json::json;

    use super::EmulateArguments;
    use crate::cli::emulated_surroundings::EmulatedSurroundings;
    use crate::cli::machine::interrupt_flag;
    use crate::cli::pseudo_terminal::PseudoTerminal;
    use crate::cli::{config, output};

    /// Shortest time in which a base stands, seconds: a reversal passes through zero.
    const STANDSTILL_S: f64 = 0.2;

    /// Longest step, seconds: after a stall of this process the machine catches up in such steps, with its watchdog.
    const MAX_STEP_S: f64 = 0.01;

    /// Emulates a base until the time is over or a signal arrives.
    pub fn run(arguments: &EmulateArguments) -> anyhow::Result<bool> {
        let kind = &arguments.kind;
        let settings = config::load_base("--base-config", kind.base_config.as_deref())?;
        let emulator = emulator(arguments, settings.base)?;
        let surroundings = EmulatedSurroundings::open(arguments, &settings.lidar)?;
        let end = interrupt_flag()?;
        let mut pair = Some(PseudoTerminal::open()?);
        let port = pair.as_ref().map_or_else(String::new, |pair| pair.name.clone());
        // Bytes that hosts write to the device that has replaced the base.
        let mut replaced_bytes = None;
        let lidar_port = surroundings.as_ref().map(|lidar| lidar.port().to_owned());
        let mut ports = json!({ "port": port, "protocol": kind.protocol.name() });
        if let Some(lidar_port) = &lidar_port {
            ports["lidar"] = json!(lidar_port);
        }
        output::result(&ports, [&port].into_iter().chain(&lidar_port))?;
        if !output::is_json() {
            let lidar = lidar_port.map(|port| format!("the lidar sends to {port}; "));
            let lidar = lidar.unwrap_or_default();
            output::note(format!("speaks {}; {lidar}Ctrl-C ends it", kind.protocol));
        }
        let mut machine = Machine { emulator, surroundings, motion: MotionLog::default() };
        let started = Instant::now();
        let (mut bytes, mut line) = ([0; 512], Vec::new());
        loop {
            let now_s = started.elapsed().as_secs_f64();
            let over = arguments.for_s.is_some_and(|for_s| now_s >= for_s);
            if over || end.load(Ordering::Relaxed) {
                machine.motion.end(now_s);
                break;
            }
            if replaced_bytes.is_none() && machine.emulator.has(InjectedFault::PortReplaced, now_s)
            {
                // The system gives the lowest free number, so usually the same name.
                drop(pair.take());
                replaced_bytes = Some(0);
            }
            let pair = match &mut pair {
                Some(pair) => pair,
                none => none.insert(PseudoTerminal::open()?),
            };
            let count = pair.read(&mut bytes)?;
            line.clear();
            let now_s = started.elapsed().as_secs_f64();
            while now_s - machine.motion.time_s > MAX_STEP_S {
                machine.step(machine.motion.time_s + MAX_STEP_S, &mut line)?;
            }
            if let Some(replaced_bytes) = &mut replaced_bytes {
                *replaced_bytes += count;
                machine.step(now_s, &mut line)?;
            } else {
                machine.emulator.receive(&bytes[..count], now_s);
                machine.step(now_s, &mut line)?;
                pair.write(&line)?;
            }
        }
        print(&machine, replaced_bytes)?;
        Ok(true)
    }

    /// An emulated base in its surroundings.
    struct Machine {
        emulator: Emulator,
        surroundings: Option<EmulatedSurroundings>,
        motion: MotionLog,
    }

    impl Machine {
        /// Advances to a time, seconds, and appends the bytes that the base writes.
        fn step(&mut self, now_s: f64, line: &mut Vec<u8>) -> anyhow::Result<()> {
            self.emulator.step(now_s, line);
            let twist = self.emulator.twist();
            self.motion.record(now_s, &twist);
            match &mut self.surroundings {
                Some(surroundings) => surroundings.step(now_s, self.emulator.pose(), &twist),
                None => Ok(()),
            }
        }
    }

    /// The base with its faults.
    fn emulator(arguments: &EmulateArguments, settings: BaseSettings) -> anyhow::Result<Emulator> {
        let mut emulator = Emulator::new(arguments.kind.protocol, settings, arguments.seed)?
            .with_motor_lag(arguments.motor_lag)
            .with_width_ratio(arguments.width_ratio)
            .with_slip(arguments.slip)
            .with_deadband(arguments.deadband);
        for fault in &arguments.fault {
            emulator.schedule(*fault);
        }
        Ok(emulator)
    }

    /// When the base moved and when it stood, seconds.
    #[derive(Default)]
    struct MotionLog {
        /// The present time.
        time_s: f64,
        last_motion_s: f64,
        /// Begin and end of each standstill.
        standstills: Vec<(f64, f64)>,
    }

    impl MotionLog {
        fn record(&mut self, now_s: f64, twist: &Twist) {
            if !twist.stands() {
                self.end(now_s);
                self.last_motion_s = now_s;
            }
            self.time_s = now_s;
        }

        /// Ends a standstill, if there is one.
        fn end(&mut self, now_s: f64) {
            if now_s - self.last_motion_s >= STANDSTILL_S {
                self.standstills.push((self.last_motion_s, now_s));
            }
            self.time_s = now_s;
        }
    }

    fn print(machine: &Machine, replaced_bytes: Option<usize>) -> anyhow::Result<()> {
        let Machine { emulator, surroundings, motion } = machine;
        let surroundings = surroundings.as_ref();
        let (stats, twist) = (emulator.command_stats(), emulator.twist());
        let (time_s, travelled_m) = (motion.time_s, emulator.travelled_m());
        let observed = surroundings.map(EmulatedSurroundings::observed);
        let object = json!({
            "time_s": time_s,
            "commands": stats.commands,
            "final_zero_commands": stats.final_zero_commands,
            "watchdog_stops": stats.watchdog_stops,
            "zero_commands_after_watchdog": stats.zero_commands_after_watchdog,
            "bytes_after_replacement": replaced_bytes,
            "travelled_m": travelled_m,
            "pose": emulator.pose(),
            "map_pose": surroundings.map(|world| world.map_pose(emulator.pose())),
            "last_motion_s": motion.last_motion_s,
            "standstills": motion.standstills,
            "min_gap_m": observed.map(|observed| observed.min_gap_m),
            "robot_touched": observed.map(|observed| observed.robot_touched),
            "person_touched": observed.map(|observed| observed.person_touched),
            "parking_from_s": observed.and_then(|observed| observed.parking_from_s),
            "linear": twist.linear,
            "angular": twist.angular,
        });
        let summary = format!(
            "{time_s:.1} s, {} commands, the last {} zero; {} watchdog stops; {travelled_m:.2} m",
            stats.commands, stats.final_zero_commands, stats.watchdog_stops,
        );
        output::result(&object, [summary])
    }
}
