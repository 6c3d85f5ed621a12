//! The engine of a command. What `--engine auto` measured is kept in a file of the user, so that later commands start at once.

use std::fs;
use std::path::Path;
use std::thread;
use std::time::Instant;

use anyhow::Context;
use inbye::bench::{DecisionSize, EngineRequest, EngineTime, measure_engines};
use inbye::input_file::read_text;
use inbye::local::{
    CpuEngine, Engine, EngineChoice, EngineError, SelectedEngine, open_engine, open_to_replay,
    open_with_fallback,
};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::whole_file::write_whole;
use super::{machine, output};

/// Name of the file in the user's cache folder.
const FILE: &str = "engine-times.json";
/// Number of measurements that it keeps, the newest.
const KEPT: usize = 32;

/// A measurement, and what it holds for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Measurement {
    /// Version of inbye, processor and its vector instructions.
    machine: String,
    /// Adapters with their drivers.
    adapters: Vec<String>,
    threads: usize,
    size: DecisionSize,
    /// The fastest first.
    times: Vec<EngineTime>,
}

impl Measurement {
    /// Whether it holds here: the same processor and size, and no adapter that was not measured. A missing adapter may come
    /// back.
    fn is_for(
        &self,
        machine: &str,
        adapters: &[String],
        threads: usize,
        size: &DecisionSize,
    ) -> bool {
        (&*self.machine, self.threads, &self.size) == (machine, threads, size)
            && adapters.iter().all(|adapter| self.adapters.contains(adapter))
    }

    /// Whether its times are those of a measurement.
    fn is_valid(&self) -> bool {
        let is_time = |time: &EngineTime| time.p50_ms.is_finite() && time.p50_ms >= 0.0;
        let is_engine = |time: &EngineTime| time.threads <= CpuEngine::MAX_THREADS;
        !self.times.is_empty() && self.times.iter().all(|time| is_time(time) && is_engine(time))
    }

    /// The times of the CPU, and of the adapters that are there now.
    fn times_here(&self, adapters: &[String]) -> Vec<EngineTime> {
        let is_adapter = |time: &EngineTime, adapter: &String| {
            adapter.strip_prefix(&*time.name).is_some_and(|rest| rest.starts_with(" ("))
        };
        let is_here = |time: &&EngineTime| {
            time.threads > 0 || adapters.iter().any(|adapter| is_adapter(time, adapter))
        };
        self.times.iter().filter(is_here).cloned().collect()
    }
}

/// Which times of the user's file are used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeptTimes {
    /// None: the engines are measured again.
    None,
    /// Those of engines that are there now.
    OfPresentEngines,
    /// All: a GPU that is missing now may come back while the robot drives.
    All,
}

/// Times of the engines for decisions of one size, the fastest first: from the user's file, or measured if the file has none.
/// `left_out` receives the error of each GPU that was not measured.
pub fn engine_times(
    size: &DecisionSize,
    threads: usize,
    usable: KeptTimes,
    left_out: &mut dyn FnMut(&EngineError),
) -> anyhow::Result<Vec<EngineTime>> {
    let features = machine::cpu_features().join(" ");
    let machine = format!("{}, {}, {features}", env!("CARGO_PKG_VERSION"), machine::description());
    let adapters: Vec<String> = machine::adapters().iter().map(machine::adapter_text).collect();
    let file = machine::cache_folder().map(|folder| folder.join(FILE));
    let mut kept = file.as_deref().map(read).unwrap_or_default();
    let is_for = |one: &Measurement| one.is_for(&machine, &adapters, threads, size);
    let known = kept.iter().find(|one| is_for(one)).map(|one| match usable {
        KeptTimes::None => Vec::new(),
        KeptTimes::OfPresentEngines => one.times_here(&adapters),
        KeptTimes::All => one.times.clone(),
    });
    if let Some(times) = known.filter(|times| !times.is_empty()) {
        return Ok(times);
    }
    let mut clock = machine::wall_clock();
    let mut is_kept = true;
    let times = measure_engines(size, threads, &mut clock, &mut thread::sleep, |error| {
        left_out(error);
        is_kept &= !may_recover(error);
    })?;
    if !is_kept {
        return Ok(times);
    }
    kept.retain(|one| !is_for(one));
    let excess = (kept.len() + 1).saturating_sub(KEPT);
    kept.drain(..excess);
    kept.push(Measurement { machine, adapters, threads, size: *size, times: times.clone() });
    match file.map(|file| write(&file, &kept)) {
        Some(Err(error)) => {
            output::detail(format!("the times of the engines are not kept: {error:#}"));
        }
        None => output::detail("the times of the engines are not kept: no HOME"),
        Some(Ok(())) => {}
    }
    Ok(times)
}

/// Whether a GPU that was not measured may work the next time: times without it are not kept. One that does not open rarely
/// does, and each command would measure again.
pub const fn may_recover(error: &EngineError) -> bool {
    matches!(error, EngineError::Lost { .. })
}

/// The measurements of a file. One that cannot be read has none: it is replaced. A pipe may never end.
fn read(file: &Path) -> Vec<Measurement> {
    let is_file = fs::metadata(file).is_ok_and(|metadata| metadata.is_file());
    let text = if is_file { read_text(file).unwrap_or_default() } else { String::new() };
    let all: Vec<Value> = serde_json::from_str(&text).unwrap_or_default();
    // Of another version, some may not fit.
    let read = all.into_iter().filter_map(|one| serde_json::from_value(one).ok());
    read.filter(Measurement::is_valid).collect()
}

fn write(file: &Path, kept: &[Measurement]) -> anyhow::Result<()> {
    if let Some(folder) = file.parent() {
        fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    write_whole(file, &serde_json::to_string_pretty(kept)?)
}

/// The engine to open, its threads, and why.
struct Selection {
    choice: EngineChoice,
    threads: usize,
    reason: String,
    is_named: bool,
}

impl Selection {
    fn new(
        request: &EngineRequest,
        size: &DecisionSize,
        threads: usize,
        usable: KeptTimes,
    ) -> anyhow::Result<Self> {
        if let EngineRequest::Chosen(choice) = request {
            let (choice, reason) = (choice.clone(), "requested".to_owned());
            return Ok(Self { choice, threads, reason, is_named: true });
        }
        let times = engine_times(size, threads, usable, &mut |error| {
            output::warn(format!("not measured: {error}"));
        })?;
        let reason = fastest_text(&times, size);
        let first = times.first().context("no engine was measured")?;
        let (choice, threads) = first.choice(threads);
        Ok(Self { choice, threads, reason, is_named: false })
    }
}

/// Which engine is fastest, and the best times.
pub fn fastest_text(times: &[EngineTime], size: &DecisionSize) -> String {
    let gpu = times.iter().find(|time| time.threads == 0);
    let cpu = times.iter().find(|time| time.threads > 0);
    let best = |time: Option<&EngineTime>| time.map(ToString::to_string);
    let best: Vec<String> = [cpu, gpu].into_iter().filter_map(best).collect();
    format!("fastest for {size} ({})", best.join("; "))
}

/// Opens the engine of a request and prints which one and why to standard error.
pub fn open(
    request: &EngineRequest,
    size: &DecisionSize,
    threads: usize,
) -> anyhow::Result<Box<dyn Engine>> {
    let selection = Selection::new(request, size, threads, KeptTimes::OfPresentEngines)?;
    announce(&selection.reason, || open_engine(&selection.choice, selection.threads))
}

/// As [`open`], for a drive: a GPU has the CPU as fallback.
pub fn open_to_drive(
    request: &EngineRequest,
    size: &DecisionSize,
    threads: usize,
    gpu_required: bool,
) -> anyhow::Result<Box<dyn Engine>> {
    let Selection { choice, threads, reason, is_named } =
        Selection::new(request, size, threads, KeptTimes::All)?;
    // A GPU that was measured once may be missing now; one that the user names must be there.
    let gpu_required = gpu_required || is_named && choice != EngineChoice::Cpu;
    announce(&reason, || open_with_fallback(&choice, threads, gpu_required))
}

/// As [`open`], for a replay: a GPU has the CPU as fallback, so that the rest of a recording is compared after a failure.
pub fn open_for_replay(
    request: &EngineRequest,
    size: &DecisionSize,
    threads: usize,
) -> anyhow::Result<Box<dyn Engine>> {
    let selection = Selection::new(request, size, threads, KeptTimes::OfPresentEngines)?;
    announce(&selection.reason, || open_to_replay(&selection.choice, selection.threads))
}

/// Opens an engine and prints its name, the reason for it and the time it took to open.
fn announce(
    reason: &str,
    open: impl FnOnce() -> Result<SelectedEngine, EngineError>,
) -> anyhow::Result<Box<dyn Engine>> {
    let started = Instant::now();
    let SelectedEngine { engine, description, .. } = open().map_err(machine::with_option)?;
    output::note(format!("engine: {description}: {reason}"));
    let ms = started.elapsed().as_secs_f64() * 1e3;
    output::detail(format!("{} ready after {ms:.0} ms", engine.name()));
    Ok(engine)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measurement(adapters: &[&str]) -> Measurement {
        let size = DecisionSize::default();
        let time =
            |name: &str, threads, p50_ms| EngineTime { name: name.to_owned(), threads, p50_ms };
        Measurement {
            machine: "machine".to_owned(),
            adapters: adapters.iter().map(ToString::to_string).collect(),
            threads: 4,
            size,
            times: vec![time("GPU", 0, 0.1), time("CPU, 4 threads", 4, 0.2)],
        }
    }

    #[test]
    fn measurement_holds_until_machine_size_threads_change_or_an_adapter_is_new() {
        let kept = measurement(&["one", "two"]);
        let adapters = |names: &[&str]| names.iter().map(ToString::to_string).collect::<Vec<_>>();
        let is_for = |machine, names: &[&str], threads, size| {
            kept.is_for(machine, &adapters(names), threads, size)
        };
        assert!(is_for("machine", &["one", "two"], 4, &kept.size));
        assert!(is_for("machine", &["two"], 4, &kept.size), "a missing adapter may come back");
        assert!(!is_for("machine", &["two", "three"], 4, &kept.size));
        assert!(!is_for("other", &["one"], 4, &kept.size));
        assert!(!is_for("machine", &["one"], 2, &kept.size));
        let larger = DecisionSize { steps: kept.size.steps + 1, ..kept.size };
        assert!(!is_for("machine", &["one"], 4, &larger));
    }

    #[test]
    fn times_of_an_adapter_that_is_missing_now_are_left_out() {
        let kept = measurement(&["GPU (hardware, vulkan, a)"]);
        let names = |adapters: &[&str]| {
            let adapters: Vec<String> = adapters.iter().map(ToString::to_string).collect();
            kept.times_here(&adapters).into_iter().map(|time| time.name).collect::<Vec<_>>()
        };
        assert_eq!(names(&["GPU (hardware, vulkan, a)"]), ["GPU", "CPU, 4 threads"]);
        assert_eq!(names(&[]), ["CPU, 4 threads"]);
        assert_eq!(names(&["GPU 2 (hardware, vulkan, a)"]), ["CPU, 4 threads"]);
    }

    #[test]
    fn times_are_kept_without_an_adapter_that_does_not_open_but_not_without_one_that_failed() {
        let (adapter, message) = ("GPU".to_owned(), String::new());
        let closed = EngineError::Setup { adapter: adapter.clone(), message: message.clone() };
        assert!(!may_recover(&closed) && !may_recover(&EngineError::NoGpuSupport));
        let kind = inbye::local::GpuFailureKind::DeviceLost;
        assert!(may_recover(&EngineError::Lost { adapter, kind, message }));
    }

    #[cfg(unix)]
    #[test]
    fn pipe_in_place_of_the_file_holds_nothing() {
        let folder = tempfile::tempdir().expect("a place for temporary files");
        let pipe = folder.path().join(FILE);
        nix::unistd::mkfifo(&pipe, nix::sys::stat::Mode::S_IRWXU).expect("a pipe");
        assert_eq!(read(&pipe), []);
    }

    #[test]
    fn text_names_best_cpu_and_best_gpu() {
        let kept = measurement(&[]);
        assert_eq!(
            fastest_text(&kept.times, &kept.size),
            "fastest for 20 x 40 arcs of 25 steps, 1 disc (CPU, 4 threads 0.200 ms; GPU 0.100 ms)"
        );
    }

    #[test]
    fn file_is_read_again_and_a_broken_one_holds_nothing() {
        let folder = tempfile::tempdir().expect("a place for temporary files");
        let file = folder.path().join("below").join(FILE);
        let kept = vec![measurement(&["one"]), measurement(&[])];
        write(&file, &kept).expect("the folder is made");
        assert_eq!(read(&file), kept);
        fs::write(&file, "[{\"machine\": 1}, ").expect("writable");
        assert_eq!(read(&file), []);
        fs::write(&file, "[{\"machine\": 1}]").expect("writable");
        assert_eq!(read(&file), []);
        // A file that a person changed.
        let changed = |change: &dyn Fn(&mut Measurement)| {
            let mut one = measurement(&[]);
            change(&mut one);
            one
        };
        let odd = [
            changed(&|one| one.times.clear()),
            changed(&|one| one.times[1].threads = CpuEngine::MAX_THREADS + 1),
            changed(&|one| one.times[0].p50_ms = -1.0),
        ];
        write(&file, &[&odd[..], &kept[..1]].concat()).expect("writable");
        assert_eq!(read(&file), kept[..1]);
    }
}
